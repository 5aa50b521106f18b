# SPDX-License-Identifier: MIT
"""Writes everything that is generated from shared_c/spec. See run.py for the list."""
