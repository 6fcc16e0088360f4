#!/usr/bin/env python
"""Should a law that errs without the rows at no field be chosen less often? And which of laws that are as good?

SYNTHETIC devices of known truth (a yield effort that is a power of the field or saturates, a thinning viscosity; all
numbers drawn) are logged in six motions at five fields, the lowest of which is none. One field or one motion is taken
away, nine laws or more are fitted to the rest, and the training rows choose one: as now, and as before decision 0004
was amended.

    python studies/lowest_field.py [--before no-field] [--devices 5] [--first 0] [--cases "field 0"]
    python studies/lowest_field.py --before middle --laws bingham casson seo-seo herschel-bulkley --cases "field 0"

Before, the parts at no field were among those that choose (no-field); or of laws that the parts cannot tell apart the
one with the fewest parameters was chosen, not the one with the least error on all parts (ties); or the least error
decided however little the errors differ (alike); or a law need not lie in the middle of what all estimate at no field,
where no log is there (middle). A rule that was tried and left out stands in the place of a rule before, too: the two
lowest fields above none are left out together as well, so that a law has to go further down from the fields that it
knows (low-pair).

Printed for what was taken away: the error of the chosen law over the least error of all laws, mean and largest, by both
rules. Field 0 is none: where it is taken away parts at no field decide nothing.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any
from unittest import mock

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.candidate import Fitted
from erclutch.fit.choice.parts_left_out import LeftOut, parts_of_training
from erclutch.fit.choice.validation import chosen, counted_parameters
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import KIND
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset, joined
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD = 1e-2  # s
FORMS = ("", "/tanh", "/saturating")
TAKEN = {"f0": "field 0", "f1": "field 1", "f2": "field 2", "f4": "field 4"} | {
    "m1": "motion 1",
    "m3": "motion 3",
    "m5": "motion 5",
}


def device(seed: int) -> Dataset:
    """Logs of six motions, the slowest first, at five fields, the lowest first; every other device saturates."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    strain, floor, rise, exponent = (
        draw(0.02, 0.3),
        draw(0.0, 150.0),
        draw(300.0, 800.0),
        draw(0.8, 1.8),
    )
    saturates_at = draw(0.4, 1.2) if seed % 2 else None
    stribeck, speed = draw(-0.2, 0.4), draw(10.0, 40.0)
    viscosity, thickening, thinning = draw(0.5, 3.0), draw(0.0, 2.0), draw(0.6, 1.0)
    noise = draw(2.0, 15.0)
    fields = np.linspace(0.0, 1.0, 5) + draw(-0.04, 0.04, 5) * (0.0, 1.0, 1.0, 1.0, 1.0)
    hertz = np.exp(np.linspace(np.log(0.2), np.log(draw(3.0, 7.0)), 6) + draw(-0.15, 0.15, 6))
    logs: list[Dataset] = []
    for f, field in enumerate(fields.tolist()):
        for m, (top, each) in enumerate(zip(draw(20.0, 100.0, 6), hertz.tolist(), strict=True)):
            time = PERIOD * np.arange(150.0 if each > 0.6 else 500.0)
            slip = top * np.sin(2.0 * np.pi * each * time + draw(0.0, 6.28))
            bend, at = (
                np.empty(time.size),
                0.0,
            )  # strain of the fluid, as a share of that at which it yields
            for k, step in enumerate((slip * PERIOD / strain).tolist()):
                at = (at + step) / (1.0 + abs(step))
                bend[k] = at
            level = field**exponent
            if saturates_at is not None:
                level = np.tanh((field / saturates_at) ** exponent) / np.tanh(
                    saturates_at**-exponent
                )
            effort = (
                (floor + rise * level) * bend * (1.0 + stribeck * np.tanh(np.abs(slip) / speed))
            )
            effort += (viscosity + thickening * field) * np.sign(slip) * np.abs(slip) ** thinning
            effort += noise * rng.standard_normal(time.size)
            clock = Clock(time, (Span(0, time.size, PERIOD),))
            element = Element(np.full(time.size, field), slip)
            log = Dataset("single", (element,), effort, clock, Units("N", "A", "mm/s"))
            logs.append(replace(log, sources=(f"m{m} f{f}",)))
    return joined(logs)


def parameters_of(
    usable: Mapping[str, Sequence[Array]], outcomes: Mapping[str, AnyOutcome], parts: LeftOut
) -> dict[str, float]:
    """What decided between laws that are as good, before."""
    return {name: float(counted_parameters(outcomes[name])) for name in usable}


def parts_with_low_pair(train: Dataset) -> LeftOut | None:
    """What is left out in turn, and the two lowest fields above none together."""
    parts = parts_of_training(train)
    if parts is None or parts.fields - parts.lowest < 3:
        return parts
    of_fields = list(parts.masks[: parts.fields])
    pair = of_fields[parts.lowest] | of_fields[parts.lowest + 1]
    masks = [*of_fields, pair, *parts.masks[parts.fields :]]
    return replace(parts, masks=masks, fields=parts.fields + 1)


#: Of each rule the function that made it, and what stands in its place.
BEFORE: dict[str, tuple[str, Any]] = {
    "no-field": ("parts_left_out.has_no_field", lambda train, start, stop: False),
    "ties": ("validation.burdens_of", parameters_of),
    "alike": ("validation._ALIKE", 0.0),
    "middle": ("validation.in_the_middle", lambda train, laws: list(laws)),
    "low-pair": ("validation.parts_of_training", parts_with_low_pair),
}


def judged(data: Dataset, word: str, rule: str, laws: Sequence[str]) -> tuple[float, float]:
    """Error of the chosen law over the least of all, before a rule and now.

    Args:
        data: of a device.
        word: which logs are taken away, by a part of their names.
        rule: the rule's name.
        laws: names; each is fitted with all forms.
    """
    held = np.zeros(data.rows, np.bool_)
    for source, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        held[start:stop] = word in source
    train = data.take(~held)
    models = tuple(law + form for law in laws for form in FORMS)
    candidates = KIND.candidates(Settings(models, lag="none"), train)
    fitted = [
        Fitted(each, fit_structure(train, each.structure, intervals=False)) for each in candidates
    ]
    errors: dict[str, float] = {}
    for each in fitted:
        model = each.outcome.model
        left = (data.effort - model.predict(data))[held]
        errors[model.name] = float(np.sqrt(np.mean(left**2)))
    now = chosen(train, fitted, list(errors), seed=0)
    name, other = BEFORE[rule]
    with mock.patch(f"erclutch.fit.choice.{name}", other):
        before = chosen(train, fitted, list(errors), seed=0)
    assert now is not None
    assert before is not None
    least = min(errors.values())
    return errors[before.recommended] / least, errors[now.recommended] / least


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--before", choices=list(BEFORE), default="no-field")
    parser.add_argument("--devices", type=int, default=5)
    parser.add_argument("--first", type=int, default=0, help="seed of the first device")
    parser.add_argument(
        "--cases", nargs="+", default=list(TAKEN.values()), choices=list(TAKEN.values())
    )
    parser.add_argument("--laws", nargs="+", default=["bingham", "casson", "seo-seo"])
    asked = parser.parse_args()
    devices = [device(seed) for seed in range(asked.first, asked.first + asked.devices)]
    for word, title in TAKEN.items():
        if title not in asked.cases:
            continue
        ratios = np.array([judged(data, word, asked.before, asked.laws) for data in devices])
        told = [
            f"{mean:.3f} (largest {most:.3f})"
            for mean, most in zip(ratios.mean(0), ratios.max(0), strict=True)
        ]
        print(f"{title:<9} before {told[0]}, now {told[1]}", flush=True)


if __name__ == "__main__":
    main()
