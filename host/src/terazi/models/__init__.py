# SPDX-License-Identifier: MIT
"""Float64 truths and exact integer twins of shared_c. Nothing here may import terazi.cshared."""
