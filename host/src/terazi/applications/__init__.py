# SPDX-License-Identifier: MIT
"""What the filters are for: each application stands on its own, above cshared and models."""
