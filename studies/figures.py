"""Figures that pages cite: printed again by their commands, with what moved.

    python studies/figures.py [NAME ...] [--data FOLDER]

`docs/figures.toml` names each command. What it prints stands in `docs/figures/NAME.txt`, and tests/docs/test_figures.py
holds the pages to these files. Without a NAME all commands run. FOLDER holds the recordings that are not shipped, by
default `../shared/data` beside the project.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.figures import HERE, KEPT, LISTED, moved, printed


def main() -> None:
    """Run the commands, keep what they print, say what moved."""
    listed = tomllib.loads(LISTED.read_text(encoding="utf-8"))
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(listed))
    parser.add_argument("--data", type=Path, default=HERE.parent / "shared" / "data")
    asked = parser.parse_args()
    if unknown := set(asked.names) - set(listed):
        parser.error(
            f"no figures named {', '.join(sorted(unknown))}; there are {', '.join(listed)}"
        )
    KEPT.mkdir(exist_ok=True)
    for name in asked.names or listed:
        file = KEPT / f"{name}.txt"
        old = file.read_text(encoding="utf-8") if file.exists() else ""
        new = printed(listed[name], asked.data)
        file.write_text(new, encoding="utf-8")
        print(f"{name}:", *(moved(old, new) or ["nothing moved"]), sep="\n  ")


if __name__ == "__main__":
    main()
