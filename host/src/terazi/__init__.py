# SPDX-License-Identifier: MIT
"""Terazi: a fixed-point balance and spirit level on an Arduino Uno, and its tools on the PC."""

__version__ = "0.1.0"
