"""Which tests of the core may ask for what a wing brings: those run once more without any wing, in a copy.

The others run once: that they ask for nothing of a wing is shown by the sources of their rooms, and where a room finds
its readers by name, by a fixture that looks at each test.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Rooms that import no room with a registry's group of the wings, and look up no such group but that of readers.
NO_GROUP_OF_A_WING = ("arithmetic", "fit", "logs", "models", "signals")
#: Words of a test that may ask for a wing all the same: by a room above, a command or a process, such as the one that
#: finds the reader of a sheet's text.
MAY_ASK = re.compile(
    r"erclutch\.(?:cli|export|report|runs|wings)|wings|subprocess|\bmain\(|registry|[pP]lugin|xls|\bods\b|sheet"
)
SUPPORT = re.compile(r"tests\.support(?:\.| import )(\w+)")


@cache
def may_ask(test: Path) -> bool:
    """Whether a file of tests, or what tests share that it imports, has a word that may lead to a wing."""
    text = test.read_text("utf-8")
    shared = [ROOT / f"tests/support/{name}.py" for name in SUPPORT.findall(text)]
    return MAY_ASK.search(text) is not None or any(path.exists() and may_ask(path) for path in shared)
