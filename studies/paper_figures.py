"""Figures 3 to 6 of the paper in numbers: `python studies/paper_figures.py FOLDER`, of what `erclutch reproduce` drew.

Of a section (figure 3: the training log; figure 6: what each approach estimates) each signal's size, and of each
approach what it misses. Of a sweep (figure 4: RBFN; figure 5: FNN) the errors by neurons.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from erclutch.signals.array import Array

_SIGNALS = ("time_s", "measured", "field CH1", "field CH2", "slip CH1", "slip CH2")


def columns(file: Path) -> dict[str, Array]:
    """Numbers by column; an empty cell is nan."""
    with file.open(encoding="utf-8", newline="") as text:
        header, *rows = csv.reader(text)
    numbers = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return dict(zip(header, numbers.T, strict=True))


def section(file: Path) -> Iterable[str]:
    """Figure 3: root mean square, smallest and largest of each signal."""
    for name, values in columns(file).items():
        if name != "time":
            yield f"figure 3, {name}: rms {np.sqrt(np.mean(values**2)):.3g}, {values.min():.3g} to {values.max():.3g}"


def estimates(file: Path) -> Iterable[str]:
    """Figure 6: what each approach misses of the measured torque, as a share of its standard deviation too."""
    signals = columns(file)
    measured = signals["measured"]
    for name, estimated in signals.items():
        if name not in _SIGNALS:
            off = float(np.sqrt(np.mean((estimated - measured) ** 2)))
            yield f"figure 6, {name}: {1e3 * off:.3g} mN m rms, {off / measured.std():.0%} of the torque's deviation"


def rbfn(file: Path) -> Iterable[str]:
    """Figure 4: the best spread of each size with its errors."""
    sweep = columns(file)
    scored = ~np.isnan(sweep["train_mse"])
    names = ("neurons", "spread", "train_mse", "test_mse")
    for neurons, spread, train, test in zip(*(sweep[name][scored] for name in names), strict=True):
        yield f"figure 4, {neurons:.0f} neurons: spread {spread:.3g}, training {train:.3g}, test {test:.3g}"


def fnn(file: Path) -> Iterable[str]:
    """Figure 5: errors by neurons, and by how much ten starts differ."""
    sweep = columns(file)
    starts = np.array([values for name, values in sweep.items() if name.startswith("restart")])
    worst = starts.max(axis=0) / starts.min(axis=0)
    for neurons, train, test, ratio in zip(
        sweep["neurons"], sweep["train_mse"], sweep["test_mse"], worst, strict=True
    ):
        shown = f"training {train:.3g}, test {test:.3g}, worst over best start {ratio:.2f}"
        yield f"figure 5, {neurons:.0f} neurons: {shown}"


def main() -> None:
    """Print what the folder holds."""
    folder = Path(sys.argv[1])
    for name, told in (("fig3", section), ("fig4", rbfn), ("fig5", fnn), ("fig6", estimates)):
        print(*told(folder / f"{name}.csv"), sep="\n")


if __name__ == "__main__":
    main()
