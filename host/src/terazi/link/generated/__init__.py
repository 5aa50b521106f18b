# SPDX-License-Identifier: MIT
"""Written by tools/gen; never edited."""
