# SPDX-License-Identifier: MIT
"""The house's laws. ``./dev check --laws`` runs them all; host/tests/checks shows each can fail.

A law is a function from the tree's top to the list of what breaks it, one line a breach.
"""
