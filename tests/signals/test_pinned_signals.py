"""What is read of units, and what speeds and clocks come to, stays as it is kept beside this file.

`tests/conftest.py` says how to pin anew after a change that is meant.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from erclutch.signals import units
from erclutch.signals.channels import channels_of, named, wired
from erclutch.signals.clock import Carry, Clock, Span, cut_spans, stretches, within
from erclutch.signals.device import Units, elements_of, slips_of, speeds_of
from erclutch.signals.recording import SIGNALS
from erclutch.signals.speed import DERIVATIVES, Derivative, differentiate, live, reach
from tests.support.pinning import Pinned, told

ROWS = 90
X = np.sin(0.11 * np.arange(ROWS)) + 0.3 * np.cos(0.7 * np.arange(ROWS))
TEXTS = (
    *(
        "cm/s",
        "N m",
        "N*m",
        "rpm",
        "980.665 N",
        "-",
        "",
        "?",
        "kV/mm",
        "%",
        "ppm",
        "m/s^2",
        "1/s",
        "Hz",
        "1/min",
        "deg",
    ),
    *(
        "°",
        "rad/s",
        "U/min",
        "Nm",
        "kN",
        "mV",
        "A",
        "mA",
        "Pa",
        "MPa",
        "T",
        "kA/m",
        "dB",
        "degC",
        "°C",
        "K",
        "bit",
        "3",
    ),
    *(
        "count",
        "2^2^2",
        "m**2",
        "m^99",
        "x" * 65,
        "in/s",
        "lbf",
        "lbf*in",
        "ft/s",
        "N/0",
        "rev/min",
        "µm/s",
        "s",
        "RPM",
    ),
)


@pytest.mark.slow
def test_units(pinned: Pinned) -> None:
    found: dict[str, Any] = {}
    for text in TEXTS:
        found[text] = [
            units.is_unit(text),
            units.is_written_well(text),
            told(lambda t=text: units.parse(t).factor),
        ]
        for kind in ("field", "slip", "position", "effort"):
            signal = SIGNALS[kind]
            found[text].append(told(lambda t=text, s=signal: units.fits(t, s.si_units)))
            found[text].append(told(lambda t=text, s=signal: units.conversion(t, s, "x")))
    amounts = ("2 mm", "2", "-1.5e3 N", "N", "", "1 2", "1e400 N", "nan N", "2mm", "0 s")
    found["amounts"] = [told(lambda a=a: units.quantity(a)) for a in amounts]
    pinned(found)


def test_temperatures(pinned: Pinned) -> None:
    def kelvin(values: Any, unit: str | None) -> Any:
        factor, offset = units.to_kelvin(values, unit, "w")
        return factor * values + offset

    given = [(np.array([v, np.nan]), u) for v in (149.9, 150.0, 300.0, 800.0, 800.1, -123.2, -123.1, 526.8, 526.9)
             for u in ("K", "°C", "degC", None, "V")]  # fmt: skip
    pinned([told(lambda v=v, u=u: kelvin(v, u)[0]) for v, u in given])


@pytest.mark.parametrize("name", DERIVATIVES)
def test_speeds(name: Any, pinned: Pinned) -> None:
    rows: Any = np.arange(ROWS)
    clock = Clock(rows * 0.002, (Span(0, 50, 0.002), Span(50, 51, 0.002), Span(51, ROWS, 0.002)))
    uneven = Clock(np.cumsum(0.002 + 0.001 * (rows % 3)), (Span(0, ROWS, None),))
    short = Clock(np.arange(4.0), (Span(0, 4, 1.0),))
    found: list[Any] = []
    for cutoff, window in ((20.0, 5), (100.0, 9), (249.9, 5), (250.0, 5)):
        filter_ = Derivative(name, cutoff, window)
        for x, at in ((X, clock), (X, uneven), (X[:4], short)):
            found.append(told(lambda x=x, at=at, f=filter_: differentiate(x, at, f)[::7].tolist()))
        found.append(told(lambda f=filter_: reach(f, 0.002)))
        found.append(
            told(lambda f=filter_: [f_.step(v) for f_ in [live(f, 0.002)] for v in X[:12]])
        )
    wrong: Any = (
        ("x",),
        (name, 0.0),
        (name, np.inf),
        (name, 1.0, 4),
        (name, 1.0, 6),
        (name, 1.0, 3),
    )
    found += [told(lambda w=w: str(Derivative(*w))) for w in wrong]
    pinned(found, least=1e-9)


def test_clocks(pinned: Pinned) -> None:
    spans = (Span(0, 4, 0.1), Span(4, 5, 0.1), Span(5, 9, None))
    cuts = [(a, b) for a in range(10) for b in range(a, 10)]
    masks = [np.array([(k >> i) & 1 for i in range(5)], np.bool_) for k in range(32)]
    parts = [
        [[tuple(vars(s).values()) for s in cut(spans, a, b)] for a, b in cuts]
        for cut in (within, cut_spans)
    ]
    first = np.zeros(2)
    Carry([np.array([1.0, 2.0])], 3).into(first)
    pinned([parts, [stretches(mask) for mask in masks], first])


def test_devices_and_channels(pinned: Pinned) -> None:
    pair = {
        "E": np.array([0.3, -0.2]),
        "theta_dot": np.array([5.0, 1.0]),
        "alpha_dot": np.array([2.0, -3.0]),
    }
    both = {**pair, "E1": np.array([0.1, 0.2]), "E2": np.array([0.3, 0.4])}
    found: list[Any] = [
        [[e.field, e.slip] for e in elements_of("coaxial", signals)] for signals in (pair, both)
    ]
    found += [
        slips_of("coaxial", [5.0, 2.0]),
        speeds_of("coaxial", [3.0, -7.0]),
        slips_of("single", [5.0]),
    ]
    for device in ("single", "coaxial"):
        for own in (None, Units("N", "A", "m/s"), Units("?", "", "1/s")):
            found.append(
                [
                    str(c) + c.role + c.slot
                    for motor in (True, False)
                    for c in channels_of(device, own, motor=motor)
                ]
            )
        found.append(wired(device))
        texts = (
            {"field": "coil current [A]"},
            {"field": ""},
            {"x": "y"},
            {"effort": "a [b"},
            {"effort": "[N]"},
            {"torque": "T"},
        )
        for text in texts:
            found.append(
                told(lambda d=device, t=text: [str(c) for c in named(d, t).of(channels_of(d))])
            )
    found += [Units(*u).text() for u in (("N*m", "", "?"), ("?", "V", "rad/s"))]
    pinned(found)
