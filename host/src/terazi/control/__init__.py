# SPDX-License-Identifier: MIT
"""What a host does to a scale that weighs: follow it, wait for it, tare, zero, save.

    with open_link(port) as link:
        balance = Balance(link)
        balance.tare(wait_s=5.0)

Nothing here knows a terminal; the verbs of terazi.cli and the dialogues of terazi.calibration
stand on it.
"""

from terazi.control.balance import Balance

__all__ = ["Balance"]
