"""How much there is to read before a user gets anywhere: commands, options, words of help and of the pages.

    python studies/words.py [CHECKOUT ...]      without a checkout: this one

Each checkout is run with the packages of this interpreter, so an older commit can stand beside the present one.
Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from pathlib import Path

from tests.support.docs_parts import users_way, words

HERE = Path(__file__).parents[1]
#: A command's name at the left edge of the list of all, which older checkouts print in boxes.
COMMAND = re.compile(r"^(?:│|  )\s?([a-z][a-z0-9-]+)  ", re.MULTILINE)
OPTION = re.compile(r"(?<![\w-])--(?!no-|help)[A-Za-z][\w-]*")
WORD = re.compile(r"[A-Za-z]{2,}")


def counted(checkout: Path) -> dict[str, int]:
    """The counts of a checkout.

    Raises:
        SystemExit: its command line does not run.
    """
    commands = COMMAND.findall(_help(checkout))
    if not commands:
        raise SystemExit(f"{checkout} prints no list of commands: is it a checkout of erclutch?")
    texts = {command: _help(checkout, command) for command in commands}
    whole = {
        command: _help(checkout, command, option="--help-all") or texts[command]
        for command in commands
    }
    return {
        "commands": len(commands),
        "options": sum(len(set(OPTION.findall(text))) for text in whole.values()),
        "options that --help shows": sum(len(set(OPTION.findall(text))) for text in texts.values()),
        "words of all --help": sum(len(WORD.findall(text)) for text in texts.values()),
        "pages in the user's way": len(users_way(checkout / "docs")),
        "words of these pages": sum(map(words, users_way(checkout / "docs"))),
        "words of all pages": sum(map(words, (checkout / "docs").rglob("*.md"))),
    }


def _help(checkout: Path, *command: str, option: str = "--help") -> str:
    surroundings = {
        **os.environ,
        "PYTHONPATH": str(checkout / "src"),
        "COLUMNS": "120",
        "NO_COLOR": "1",
    }
    words = [sys.executable, "-m", "erclutch", *command, option]
    ended = subprocess.run(
        words, env=surroundings, capture_output=True, text=True, timeout=120, check=False
    )
    return ended.stdout if ended.returncode == 0 else ""


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("checkouts", nargs="*", type=Path, default=[HERE])
    checkouts = parser.parse_args().checkouts
    print(
        json.dumps({path.resolve().name: counted(path.resolve()) for path in checkouts}, indent=1)
    )


if __name__ == "__main__":
    main()
