# SPDX-License-Identifier: MIT
"""Coefficients: how the filters' numbers come from what is wanted of them."""
