# SPDX-License-Identifier: MIT
"""The board in a terminal, live: `session` follows it in a thread, `app` shows it (textual)."""
