# SPDX-License-Identifier: MIT
"""Entry for both `python tools/gen` and `python -m tools.gen`."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "host" / "src")]

from tools.gen.run import main  # noqa: E402  (the path must be set first)

sys.exit(main())
