#!/usr/bin/env python
"""What do bands hold on motions and fields that no training log has?

SYNTHETIC devices of known truth (a yield effort with pre-yield strain, a thinning viscosity, inertia, a spring; all
numbers drawn) are logged in six motions at five fields. Two laws that are not the truth are fitted to the logs that are
left when one field, one motion, or the quickest two or three are taken away. Rules of bands were chosen by this table.
With a folder, the same of the UTFSM damper, a real recording: pairs of motions, and a motion with a current.

    python studies/unseen.py [--devices 5] [--cases quickest]
    python studies/unseen.py --utfsm FOLDER

Printed for what was taken away, with the band of motions and fields that were logged alone, and with what the band has
for others: share of the rows inside, mean and least; how often that is below 90 % and above 99 %, and how often the
worst log has 80 %; the half width over what the logs needed.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

import numpy as np

from erclutch.fit.bands.haste_widths import with_haste
from erclutch.fit.bands.new_fields import wider_at_new_fields
from erclutch.fit.bands.prediction_bands import calibrated, coverage
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.models.band import Band
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from studies.bands import UTFSM

PERIOD = 5e-3
LAWS = (("bingham/square", "none"), ("casson/power", "dahl/field"))
#: What is taken away of a made-up device, by names of its logs; of UTFSM, what no other study takes away.
MADE_UP = (
    ("field below", ("f0",)),
    *(("field between", (f"f{k}",)) for k in (1, 2, 3)),
    ("field beyond", ("f4",)),
    ("slowest motion", ("m0",)),
    *(("motion between", (f"m{k}",)) for k in (1, 2, 3, 4)),
    ("quickest motion", ("m5",)),
    ("quickest two", ("m4", "m5")),
    ("quickest three", ("m3", "m4", "m5")),
)
REAL = (
    ("quickest two", ("2mm5Hz", "5mm3Hz")),
    ("next two", ("5mm3Hz", "10mm1Hz")),
    ("slowest two", ("25mm0x1Hz", "25mm0x25Hz")),
    *(
        (f"{current} A and 5 mm 3 Hz", (f"Hz{current}A", "5mm3Hz"))
        for current in ("0x25", "0x5", "0x75")
    ),
)


@dataclass(frozen=True)
class Device:
    """A made-up device.

    Attributes:
        rng: it draws its numbers.
    """

    rng: np.random.Generator

    def logs(self) -> Dataset:
        """Six motions, the slowest first, at five fields, the lowest first."""
        draw = self.rng.uniform
        strain, floor, rise, exponent = (
            draw(0.2, 1.5),
            draw(20.0, 150.0),
            draw(300.0, 800.0),
            draw(0.8, 1.8),
        )
        stribeck, speed = draw(-0.2, 0.4), draw(10.0, 40.0)
        viscosity, thickening, thinning = draw(0.5, 3.0), draw(0.0, 2.0), draw(0.6, 1.0)
        inertia, spring, noise = draw(0.0, 0.15), draw(0.0, 0.8), draw(2.0, 15.0)
        fields = np.linspace(0.0, 1.0, 5) + draw(-0.04, 0.04, 5) * (0.0, 1.0, 1.0, 1.0, 1.0)
        hertz = np.exp(np.linspace(np.log(0.2), np.log(draw(3.0, 7.0)), 6) + draw(-0.15, 0.15, 6))
        logs: list[Dataset] = []
        for f, field in enumerate(fields.tolist()):
            for m, (top, each) in enumerate(zip(draw(20.0, 100.0, 6), hertz.tolist(), strict=True)):
                time = PERIOD * np.arange(700.0 if each > 0.6 else 1400.0)
                turn, begin = 2.0 * np.pi * each, draw(0.0, 6.28)
                slip, rate = (
                    top * np.sin(turn * time + begin),
                    top * turn * np.cos(turn * time + begin),
                )
                bend, at = np.empty(time.size), 0.0
                for k, step in enumerate((slip * PERIOD / strain).tolist()):
                    at = (at + step) / (1.0 + abs(step))
                    bend[k] = at
                effort = (
                    (floor + rise * field**exponent)
                    * bend
                    * (1.0 + stribeck * np.tanh(np.abs(slip) / speed))
                )
                effort += (
                    (viscosity + thickening * field) * np.sign(slip) * np.abs(slip) ** thinning
                )
                effort += (
                    inertia * rate
                    - spring * rate / turn**2
                    + noise * self.rng.standard_normal(time.size)
                )
                clock = Clock(time, (Span(0, time.size, PERIOD),))
                element = Element(np.full(time.size, field), slip)
                log = Dataset("single", (element,), effort, clock, Units("N", "A", "mm/s"))
                logs.append(replace(log, sources=(f"m{m} f{f}",)))
        return joined(logs)


def judged(
    data: Dataset, taken: tuple[str, ...], law: str, stages: str
) -> Iterator[tuple[str, list[float]]]:
    """For each rule: share inside, of the worst log, and the half width over the needed."""
    held = np.zeros(data.rows, np.bool_)
    for source, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        held[start:stop] = any(fnmatch(str(source), f"*{word}*") for word in taken)
    train = data.take(~held)
    structure = Structure("single", law, law_from_name(law, "single"), stages, True, True)
    outcome = fit_structure(train, structure)
    predicted = outcome.model.predict(data)
    made = calibrated(
        data, ~held, [data.effort - predicted], [outcome.parameters], [outcome.unseen]
    )[0]
    assert made is not None
    assert outcome.unseen is not None
    grown = with_haste(made[0], train, outcome.unseen)
    bands: dict[str, Band] = {"logged": made[0]}
    bands["unseen"] = wider_at_new_fields(grown, train, without_its_field(train, structure))
    size = np.abs(data.effort - predicted)
    logs = [slice(a, b) for a, b in data.source_rows if held[a]]
    needed = float(np.mean([np.quantile(size[log], 0.95) for log in logs]))
    for rule, band in bands.items():
        found = coverage(data, band.around(predicted, data.elements, data.clock), held)
        yield rule, [found.share, found.worst, 0.5 * found.width / needed]


def without_its_field(train: Dataset, structure: Structure) -> Array:
    """Measured less estimated effort of each row by a fit without its field, shape (n,)."""
    field, errors = np.round(train.elements[0].field, 9), np.empty(train.rows)
    for each in np.unique(field).tolist():
        rows = field == each
        model = fit_structure(train.take(~rows), structure, intervals=False).model
        errors[rows] = (train.effort - model.predict(train))[rows]
    return errors


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=5)
    parser.add_argument("--utfsm", type=Path, help="folder with the logs of the UTFSM damper")
    parser.add_argument(
        "--cases", default="", help="what the name of a case begins with; none: all"
    )
    asked = parser.parse_args()
    logs: list[Callable[[], Dataset]] = [
        Device(np.random.default_rng(seed)).logs for seed in range(asked.devices)
    ]
    cases = MADE_UP
    if asked.utfsm is not None:
        paths = sorted(asked.utfsm.glob("*.txt"))
        logs, cases = [lambda: build_dataset([read(path, UTFSM) for path in paths])], REAL
    table: dict[tuple[str, str], list[list[float]]] = defaultdict(list)
    for make in logs:
        data = make()
        for name, taken in [case for case in cases if case[0].startswith(asked.cases)]:
            for law, stages in LAWS:
                for rule, figures in judged(data, taken, law, stages):
                    table[name, rule].append(figures)
    for (name, rule), figures in table.items():
        inside, worst, width = np.array(figures).T
        print(
            f"{name:<20} {rule:<7} inside {inside.mean():6.1%} (least {inside.min():6.1%}), below 90 % in "
            f"{np.mean(inside < 0.9):4.0%}, above 99 % in {np.mean(inside > 0.99):4.0%}, worst log 80 % in "
            f"{np.mean(worst >= 0.8):4.0%}; half width {np.median(width):.2f} of the needed ({len(figures)})"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
