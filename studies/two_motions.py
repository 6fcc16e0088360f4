#!/usr/bin/env python
"""What does a band hold on a further motion where two motions were logged?

SYNTHETIC devices of `studies/unseen.py` at one field; for every other device gain and zero of the effort drift between
logs. Three laws that are not the truth are fitted to one log each of two motions, a third motion judges the band: as
now, and as before, when two logs were too few to leave one out and two motions too few for a haste.

    python studies/two_motions.py [--devices 6] [--first 20] [--noise 0.05]

Noise is that of the slip, as a share of its root mean square over all logs. By turns of three devices it is white, of a
speed that was taken from positions, and filtered.

Printed for each choice of motions: the share of the rows inside, mean and least; how often that is below 90 %, and how
often the worst second has 80 %; the half width over what the motion needed, and over the spread of its effort (one
standard deviation).
"""

from __future__ import annotations

import argparse
import os
from collections import defaultdict
from dataclasses import replace

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.signal import lfilter

from erclutch.fit.bands.haste_widths import with_haste
from erclutch.fit.bands.prediction_bands import calibrated, coverage
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import rms
from erclutch.signals.device import Element
from studies.unseen import Device

#: Numbers of the motions that are fitted, and of the motion that judges; 0 is the slowest.
CHOICES = {
    "next quicker": ((1, 3), 5),
    "far quicker": ((0, 1), 4),
    "between": ((1, 5), 3),
    "slower": ((2, 4), 0),
}
LAWS = (
    ("bingham/constant", "none"),
    ("bingham/constant", "dahl/field"),
    ("herschel-bulkley/constant", "lugre/field"),
)
MOST_DRIFT = 0.15
#: Pole of the filter of a filtered noise.
FILTER = 0.7


def device(seed: int, noise: float = 0.0) -> Dataset:
    """Logs of six motions at one field, with noise of the slip."""
    rng = np.random.default_rng(seed)
    every = Device(rng).logs()
    drift = rng.uniform(0.0, MOST_DRIFT) if seed % 2 else 0.0
    effort = every.effort.copy()
    for start, stop in every.source_rows:
        zero, gain = drift * rng.standard_normal(2)
        effort[start:stop] = (1.0 + gain) * effort[start:stop] + zero * np.std(every.effort)
    field = f"f{rng.integers(1, 5)}"
    kept = np.zeros(every.rows, np.bool_)
    for source, (start, stop) in zip(every.sources, every.source_rows, strict=True):
        kept[start:stop] = str(source).endswith(field)
    data = replace(every, effort=effort).take(kept)
    if noise == 0.0:
        return data
    (element,) = data.elements
    drawn = rng.standard_normal(data.rows + 1)
    kinds = (drawn[1:], np.diff(drawn), lfilter([1.0], [1.0, -FILTER], drawn)[1:])
    of_kind = kinds[seed % len(kinds)]
    slip = element.slip + noise * rms(element.slip) * of_kind / np.std(of_kind)
    return replace(data, elements=(Element(element.field, slip),))


def rows_of(data: Dataset, motions: tuple[int, ...]) -> np.ndarray:
    """Mask of the rows of some motions."""
    mask = np.zeros(data.rows, np.bool_)
    for source, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        mask[start:stop] = int(str(source)[1]) in motions
    return mask


def judged(data: Dataset, held: np.ndarray, law: str, stages: str) -> dict[str, tuple[float, ...]]:
    """For each rule: share inside, of the worst second, the half width over the needed and over the effort's spread."""
    train = data.take(~held)
    structure = Structure("single", law, law_from_name(law, "single"), stages, False, True)
    outcome = fit_structure(train, structure)
    predicted = outcome.model.predict(data)
    error = data.effort - predicted
    needed = float(np.quantile(np.abs(error[held]), 0.95))
    spread = float(np.std(data.effort[held]))
    figures: dict[str, tuple[float, ...]] = {}
    for rule, unseen in (("before", None), ("now", outcome.unseen)):
        made = calibrated(data, ~held, [error], [outcome.parameters], [unseen])[0]
        assert made is not None
        band, _ = made
        if unseen is not None:
            band = with_haste(band, train, unseen)
        found = coverage(data, band.around(predicted, data.elements, data.clock), held)
        half_width = 0.5 * found.width
        figures[rule] = (found.share, found.worst, half_width / needed, half_width / spread)
    return figures


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=6)
    parser.add_argument("--first", type=int, default=20, help="seed of the first device")
    parser.add_argument("--noise", type=float, default=0.0, help="of the slip, as a share of it")
    asked = parser.parse_args()
    table: dict[tuple[str, str], list[tuple[float, ...]]] = defaultdict(list)
    for seed in range(asked.first, asked.first + asked.devices):
        every = device(seed, asked.noise)
        for name, (fitted, judge) in CHOICES.items():
            data = every.take(rows_of(every, (*fitted, judge)))
            for law, stages in LAWS:
                for rule, figures in judged(data, rows_of(data, (judge,)), law, stages).items():
                    table[name, rule].append(figures)
                    table["all", rule].append(figures)
    for (name, rule), figures in table.items():
        inside, worst, width, of_spread = np.array(figures).T
        print(
            f"{name:<13} {rule:<7} inside {inside.mean():6.1%} (least {inside.min():6.1%}), below 90 % in "
            f"{np.mean(inside < 0.9):4.0%}, worst second 80 % in {np.mean(worst >= 0.8):4.0%}; half width "
            f"{np.median(width):.2f} of the needed, {np.median(of_spread):.2f} of the spread ({len(figures)})"
        )


if __name__ == "__main__":
    main()
