# SPDX-License-Identifier: MIT
"""`python -m terazi`: the same as the command `terazi`."""

from terazi.cli import main

if __name__ == "__main__":
    main()
