# SPDX-License-Identifier: MIT
"""What the built firmware costs: bytes, stack and cycles, against firmware/budget.toml."""
