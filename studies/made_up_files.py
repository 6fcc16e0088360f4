"""Made-up files in the forms that loggers and people write are read, and held against the numbers behind them.

    python studies/made_up_files.py            # 2,000 files by seeds 0 .. 1999
    python studies/made_up_files.py 50 --from 7

Printed: how many were read right at once, asked about, refused and misread, and each that was not read right. The files
are SYNTHETIC; `tests/support/made_up_files.py` writes and judges them.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tests.support.made_up_files import ASKED, MISREAD, REFUSED, RIGHT, tried


def main() -> int:
    """Print the outcomes; the exit code is 1 where a file was misread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=int, nargs="?", default=2000)
    parser.add_argument("--from", dest="first", type=int, default=0, help="first seed")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        outcomes = tried(range(asked.first, asked.first + asked.files), Path(folder))
    counts = ", ".join(f"{name} {outcomes[name]}" for name in (RIGHT, ASKED, REFUSED, MISREAD))
    print(f"{sum(outcomes.values())} made-up files: {counts}")
    return int(outcomes[MISREAD] > 0)


if __name__ == "__main__":
    sys.exit(main())
