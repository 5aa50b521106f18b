# SPDX-License-Identifier: MIT
"""``python -m tools.checks [WORD...]``: run the laws, or those whose claim holds one of the words.

With ``--counts FILE`` the numbers of kept and broken laws are left there for the stages.
"""

import json
import sys
import time
from pathlib import Path

from tools.checks.laws import LAWS

ROOT = Path(__file__).resolve().parents[2]
SHOWN_MAX = 25


def main(arguments: list[str]) -> int:
    counts_file = None
    if arguments[:1] == ["--counts"]:
        counts_file, arguments = Path(arguments[1]), arguments[2:]
    chosen = [law for law in LAWS if not arguments or any(word in law.claim for word in arguments)]
    broken = 0
    for law in chosen:
        start_s = time.monotonic()
        try:
            breaches = law.breaches(ROOT)
        except Exception as error:  # a law that cannot be looked at is not kept
            breaches = [f"cannot be looked at: {type(error).__name__}: {error}"]
        broken += bool(breaches)
        word = "BROKEN" if breaches else "kept"
        print(f"{word:6}  {law.claim}  ({time.monotonic() - start_s:.1f} s)", flush=True)
        for breach in breaches[:SHOWN_MAX]:
            print(f"        {breach}")
        if len(breaches) > SHOWN_MAX:
            print(f"        ... and {len(breaches) - SHOWN_MAX} more")
    if counts_file:
        counts_file.write_text(json.dumps({"passed": len(chosen) - broken, "failed": broken}))
    return 1 if broken or not chosen else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
