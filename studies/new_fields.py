#!/usr/bin/env python
"""How wide must a band be at a field that no log has? Chosen inside the training logs, by leaving a second field out.

Logs of the UTFSM damper, a real recording at five currents. One current a is left out, as if nobody had measured it. Of
the other four each b is left out in turn and is to be held by a band that knows the remaining three. These are left out
one by one, and rules make a half width of the errors: the largest over all fields ("all"), the largest over fields that
had others on both sides ("like"). So a rule is judged 20 times, and the current a never has a say.

    python studies/new_fields.py FOLDER

Printed for each law, rule, and place of the field b: share of its rows inside, mean and least; how often its worst log
has 80 % inside; half width over the half width that would have held 95 %.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

import numpy as np

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, Mask
from studies.bands import UTFSM
from studies.blind import CURRENTS

LEVEL = 0.95
#: Laws whose form over the field is given, so that two fields are enough for a fit.
LAWS = (
    ("bingham/square", "none"),
    ("bingham/square", "dahl/field"),
    ("casson/square", "dahl-2/field"),
)


class Damper:
    """The logs, and the errors of a law that was fitted without some currents."""

    def __init__(self, logs: Dataset, law: str, stages: str) -> None:
        self.logs, self.structure = (
            logs,
            Structure("single", law, law_from_name(law, "single"), stages, True, True),
        )
        self.log = np.repeat(
            np.arange(len(logs.sources)), [stop - start for start, stop in logs.source_rows]
        )
        names = [Path(str(source)).name for source in logs.sources]
        of_log = [CURRENTS.index(name.partition("Hz")[2].removesuffix("A.txt")) for name in names]
        self.current = np.array(of_log)[self.log]
        slip = np.abs(logs.elements[0].slip)
        self.slip_class = np.searchsorted(np.quantile(slip, [0.25, 0.5, 0.75]), slip)
        self._errors: dict[frozenset[int], Array] = {}

    def without(self, *currents: int) -> Array:
        """Measured less estimated effort of all rows, shape (n,), by a fit without some currents."""
        key = frozenset(currents)
        if key not in self._errors:
            kept = self.logs.take(~np.isin(self.current, currents))
            model = fit_structure(kept, self.structure, intervals=False).model
            self._errors[key] = self.logs.effort - model.predict(self.logs)
        return self._errors[key]

    def half_width(self, errors: Array, rows: Mask) -> float:
        """What a share of the rows does not exceed, each log counting the same."""
        size, log = np.abs(errors[rows]), self.log[rows]
        _, number, count = np.unique(log, return_inverse=True, return_counts=True)
        order = np.argsort(size)
        counted = np.cumsum(1.0 / count[number[order]])
        at = int(np.searchsorted(counted, LEVEL * counted[-1]))
        return float(size[order][min(at, size.size - 1)])

    def unseen(self, current: int, *others: int) -> float:
        """The half width that a current needs without which, and without others, the law was fitted; worst slips."""
        errors, rows = self.without(current, *others), self.current == current
        return max(self.half_width(errors, rows & (self.slip_class == k)) for k in range(4))


def rules(damper: Damper, a: int, b: int) -> tuple[str, dict[str, float]]:
    """Where the current b lies among those that are known, and the half width there by each rule."""
    known = [c for c in range(len(CURRENTS)) if c not in (a, b)]
    place = "below" if b < known[0] else "beyond" if b > known[-1] else "between"
    unseen = {c: damper.unseen(c, a, b) for c in known}
    errors = damper.without(a, b)
    seen = {c: damper.half_width(errors, damper.current == c) for c in known}
    beside = [
        min((c for c in known if c > b), default=known[-1]),
        max((c for c in known if c < b), default=known[0]),
    ]
    every = max(*unseen.values(), *seen.values())
    like = max(*(unseen[c] for c in known[1:-1]), *(seen[c] for c in beside))
    return place, {"all": every, "like": like}


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="logs of the UTFSM damper")
    logs = build_dataset(
        [read(path, UTFSM) for path in sorted(parser.parse_args().folder.glob("*.txt"))]
    )
    for law, stages in LAWS:
        damper = Damper(logs, law, stages)
        found: dict[tuple[str, str], list[tuple[float, float, float]]] = defaultdict(list)
        for a in range(len(CURRENTS)):
            for b in (b for b in range(len(CURRENTS)) if b != a):
                place, widths = rules(damper, a, b)
                errors, rows = np.abs(damper.without(a, b)), damper.current == b
                for rule, width in widths.items():
                    inside = errors <= width
                    worst = min(
                        float(np.mean(inside[rows & (damper.log == k)]))
                        for k in np.unique(damper.log[rows])
                    )
                    needed = damper.half_width(errors, rows)
                    found[place, rule].append((float(np.mean(inside[rows])), worst, width / needed))
        for (place, rule), judged in sorted(found.items()):
            inside, worst, wide = np.array(judged).T
            print(
                f"{law}+{stages:<13} {place:<8} {rule:<5} inside {inside.mean():.1%} (least {inside.min():.1%}), "
                f"worst log holds 80 % in {np.mean(worst >= 0.8):.0%}, width {np.median(wide):.2f} of the needed",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
