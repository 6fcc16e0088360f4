"""Damaged exports, JSON and texts of several tables: `python studies/container_mutations.py --count 1000`.

Each sample is made up (SYNTHETIC), so what is right is known. A copy gets one change: a character is replaced, left out
or doubled, or a line is left out or doubled. Counted is what a reader makes of the copy:

- refused: an error of ours;
- as before, or one row less or more where a line is less or more;
- one value other: a digit is another digit, which nobody can see;
- told: other numbers, and a note on what is left out;
- MOVED: more than one value of a row differs, or a column has the numbers of another, in silence;
- TRACEBACK: any other exception.

The program ends with 1 where anything moved or broke.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from erclutch.errors import ErclutchError
from erclutch.logs import read_table
from erclutch.signals.array import Array
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.logs.test_json_layout import FORMS
from tests.logs.test_text_tables import two
from tests.wings.rheology.test_flow_curve_file import rheocompass
from tests.wings.rheology.test_rheometer_exports import (
    compass,
    kinexus,
    rheowin,
    trios,
)

Columns = Mapping[str, Array]
_LETTERS = "0123456789.,;\t -+eE\"'[]{}:|#xN"


def curves(path: Path) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Rates and stresses of all curves of a file."""
    file = read_flow_curves(path)
    columns = {
        f"{i} {name}": getattr(each, name)
        for i, each in enumerate(file.curves)
        for name in ("rate", "stress")
    }
    return columns, file.notes


def tables(path: Path) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Columns of both tables of a text."""
    columns: dict[str, Array] = {}
    notes: tuple[str, ...] = ()
    for name in ("table 1", "table 2"):
        table = read_table(path, variable=name)
        columns |= {f"{name} {label}": values for label, values in table.columns.items()}
        notes += (*table.notes, *table.unreadable.values())
    return columns, notes


def one_table(path: Path) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Columns of a file that is one table."""
    table = read_table(path)
    return dict(table.columns), (*table.notes, *table.unreadable.values())


Reads = Callable[[Path], tuple[dict[str, Array], tuple[str, ...]]]
SAMPLES: dict[str, tuple[str, str, Reads]] = {
    "rheocompass tab": ("a.csv", rheocompass("\t", "."), curves),
    "rheocompass semicolon": ("a.csv", rheocompass(";", ","), curves),
    "rheocompass bare": ("a.csv", compass(""), curves),
    "trios": ("a.txt", trios(), curves),
    "kinexus comma": ("a.csv", kinexus(",", "."), curves),
    "kinexus semicolon": ("a.csv", kinexus(";", ","), curves),
    "rheowin": ("a.txt", rheowin(), curves),
    "two tables": ("a.csv", two(), tables),
    **{
        f"json {form}": ("a.json", json.dumps(document), one_table)
        for form, document in FORMS.items()
    },
}


def changed(text: str, chance: random.Random) -> tuple[str, int]:
    """A text with one change, and how many rows may be more or less."""
    kind = chance.choice(("replace", "replace", "leave out", "double", "line out", "line twice"))
    at = chance.randrange(len(text))
    if kind == "replace":
        return text[:at] + chance.choice(_LETTERS) + text[at + 1 :], 0
    if kind == "leave out":
        return text[:at] + text[at + 1 :], 0
    if kind == "double":
        return text[:at] + text[at] + text[at:], 0
    whole = text.splitlines(keepends=True)
    line = chance.randrange(len(whole))
    return "".join(
        whole[:line] + whole[line : line + 1] * (2 * (kind == "line twice")) + whole[line + 1 :]
    ), 1


def outcome(found: Columns, right: Columns, rows: int, said: bool) -> str:
    """What the columns of a changed file are beside what is right."""
    other = 0
    new = [name for name in found if name not in right]
    gone = [name for name in right if name not in found]
    renamed = dict(zip(new, gone, strict=False))
    found = {
        renamed.get(name, name): values for name, values in found.items()
    }  # a name that changed is seen
    for name, values in found.items():
        if name not in right:
            return "told" if said else "MOVED"
        size = right[name].size
        if values.size != size:
            told = said or abs(values.size - size) <= rows
            return "a row less or more" if told and rows else "told" if said else "MOVED"
        other += int(np.count_nonzero(values != right[name]))
    if not set(right) <= set(found):
        return "told" if said or rows else "MOVED"
    if other == 0:
        return "as before"
    return "one value other" if other <= 1 else "told" if said else "MOVED"


def main() -> int:
    """Print a row a sample; see the module."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, (file, text, reads) in SAMPLES.items():
            if asked.only not in name:
                continue
            path = Path(folder) / file
            path.write_text(text, encoding="utf-8")
            right, notes = reads(path)
            chance = random.Random(f"{asked.seed} {name}")
            counts: Counter[str] = Counter()
            for number in range(asked.count):
                copy, rows = changed(text, chance)
                path.write_text(copy, encoding="utf-8")
                try:
                    found, told = reads(path)
                    seen = outcome(found, right, rows, bool({*told} - {*notes}))
                except ErclutchError:
                    seen = "refused"
                except Exception as error:
                    seen = "TRACEBACK"
                    print(f"{name} {number}: {error!r}", file=sys.stderr)
                if seen in ("MOVED", "TRACEBACK"):
                    bad += 1
                    Path(
                        tempfile.gettempdir(), f"mutation {name} {number}{path.suffix}"
                    ).write_text(copy, "utf-8")
                counts[seen] += 1
            print(
                f"{name}: " + ", ".join(f"{word} {count}" for word, count in counts.most_common()),
                flush=True,
            )
    print(f"{bad} moved or broke")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
