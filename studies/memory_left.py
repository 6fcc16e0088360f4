"""What Bingham's law with memory still misses on the TWIN, and in which rows: `docs/twin.md`.

Run: python studies/memory_left.py
"""

from __future__ import annotations

import argparse

import numpy as np

from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array, Mask
from erclutch.wings.paper.tables import twin_runs
from erclutch.wings.rig.twin.parameters import default_rig

MODEL = "bingham+lag+effort-lag+inertia+dahl/field"
AFTER = 30  # rows, at 1 kHz


def turned(data: Dataset) -> Mask:
    """Rows soon after the slip of an element has turned."""
    found = np.zeros(data.rows, np.bool_)
    for element in data.elements:
        turns = np.flatnonzero(np.diff(np.sign(element.slip)))
        for later in range(AFTER):
            found[np.clip(turns + later, 0, data.rows - 1)] = True
    return found


def at_stop(data: Dataset) -> Mask:
    """Rows with the table within an eighth of the half stroke of an end stop."""
    output = -0.5 * (data.elements[0].slip + data.elements[1].slip)
    angle = np.cumsum(output) * data.period
    rig = default_rig()
    return np.abs(angle) > 0.875 * 2.0 * np.pi * rig.value("screw.half_stroke") / rig.value("screw.lead")


def said(rows: Mask, square: Array) -> str:
    """Share of the rows, share of the squared error, and the error elsewhere."""
    share = square[rows].sum() / square.sum()
    return f"{rows.mean():.1%} of the rows, {share:.1%} of the squared error, MSE elsewhere {square[~rows].mean():.2e}"


def main() -> None:
    """Fit, and print what is left."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    runs = twin_runs(("training", "test"))
    train = runs["training"]
    (structure,) = structures_for(train, Settings(models=(MODEL,), lag="none"))
    model = fit_structure(train, structure, intervals=False).model
    for name, data in runs.items():
        square = (data.effort - model.predict(data)) ** 2
        print(f"TWIN, {name}: {MODEL}, MSE {square.mean():.2e}")
        print(f"  within {AFTER} ms after a slip has turned: {said(turned(data), square)}")
        print(f"  near an end stop: {said(at_stop(data), square)}")


if __name__ == "__main__":
    main()
