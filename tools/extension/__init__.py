# SPDX-License-Identifier: MIT
"""Builds the compiled part of the package: for wheels, in place, and under UBSan."""
