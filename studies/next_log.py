#!/usr/bin/env python
"""Does a recommendation hold on the next log, and its band, whatever that log is and whatever the device?

SYNTHETIC devices of eight kinds, their numbers drawn by a seed: Dahl's, LuGre's, Bouc-Wen's and Spencer's memory, a
hysteretic tanh, Herschel-Bulkley's and Casson's flow without a memory, a brake with a drag and an iron that saturates.
Each is logged at four fields, of which the lowest is none, in three sines and in one random motion. The sensor has
noise, and a zero that differs a little from log to log. What is asked next is taken away, and the rows taken away judge
what is fitted to the rest.

    python studies/next_log.py [--first 0] [--devices 8] [--only spencer] [--cases "no field" random]
    python studies/next_log.py --recommend [--models all --lag auto]

Printed for each device and case, of a law near to the device: share of the rows that its band holds, of all and of the
worst log, and its half width over the needed; by the rules before decision 0019 was amended on 2026-11-29, and now.
With --recommend several models are fitted: the recommended one and the best ranked one, how many times larger the error
of the first is, and its band as it is now.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.bands.haste_widths import with_haste
from erclutch.fit.bands.new_fields import wider_at_new_fields
from erclutch.fit.bands.prediction_bands import calibrated, coverage
from erclutch.fit.bands.standstill_widths import wide_next_to_standstill
from erclutch.fit.candidate import Fitted
from erclutch.fit.choice.validation import chosen
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.fit.kinds.law_alone import KIND
from erclutch.logs.dataset import Dataset, joined
from erclutch.logs.held_out import hold_out
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD = 5e-3  # s
STEPS = 20  # of the simulation in a period
FIELDS, SINES = 4, 3
SECONDS = {"sine": 1.75, "slow sine": 3.0, "random": 3.0}
#: What is asked next, and the logs that are taken away: motion m0 is the slowest sine, m9 is random.
CASES = {
    "no field": ("m[012] f0",),
    "inner field": ("m[012] f1",),
    "next inner field": ("m[012] f2",),
    "highest field": ("m[012] f3",),
    "amplitude": ("m1 *",),
    "slow to fast": ("m2 *",),
    "random": ("m9 *",),
}
#: Laws and stages without a search, so that a case takes some seconds.
LAWS = (
    "bingham+dahl/field",
    "bingham/tanh+dahl/field",
    "casson+dahl/field",
    "herschel-bulkley+hysteretic-tanh",
)
#: Of each kind of device a law that is near to it, for its bands alone.
LAW_OF = {
    "hysteretic_tanh": "herschel-bulkley+hysteretic-tanh",
    "herschel_bulkley": "herschel-bulkley",
    "casson": "casson+inertia",
}
OTHERWISE = "bingham+dahl/field"
#: Share of the rows that a band promises.
LEVEL = 0.95

#: From field (as a share of the largest), slip and position of each step of the simulation, and that step in s: effort.
Truth = Callable[[float, Array, Array, float], Array]


def _level(draw: Callable[[float, float], float]) -> Callable[[float], float]:
    """How the yield effort rises with the field, from 0 to 1: a power, or one that saturates."""
    exponent, bends_at = draw(0.9, 1.9), draw(0.5, 1.5)
    if draw(0.0, 1.0) < 0.5:
        return lambda field: field**exponent
    top = np.tanh(bends_at**-exponent)
    return lambda field: float(np.tanh((field / bends_at) ** exponent) / top)


def dahl(draw: Callable[[float, float], float]) -> Truth:
    """A damper whose fluid bends before it yields (Dahl), beside a viscous effort that thins."""
    floor, rise, bend = draw(30.0, 150.0), draw(300.0, 800.0), draw(0.1, 0.8)
    viscosity, thickening, thinning = draw(0.5, 3.0), draw(0.0, 2.0), draw(0.7, 1.0)
    level = _level(draw)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        state = np.empty(slip.size)
        at = 0.0
        for k, w in enumerate(slip.tolist()):
            at += (w - abs(w) * at) * step / bend
            state[k] = at
        viscous = (viscosity + thickening * field) * np.sign(slip) * np.abs(slip) ** thinning
        return (floor + rise * level(field)) * state + viscous

    return effort


def lugre(draw: Callable[[float, float], float]) -> Truth:
    """A brake of bristles, with more effort at rest than in motion."""
    floor, rise = draw(20.0, 120.0), draw(300.0, 700.0)
    more, speed, bend = draw(0.05, 0.3), draw(5.0, 15.0), draw(0.2, 1.0)
    damping, viscosity = draw(0.0, 0.2), draw(0.3, 2.0)
    level = _level(draw)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        whole = floor + rise * level(field)
        sliding = whole * (1.0 + more * np.exp(-((slip / speed) ** 2)))
        stiffness = whole / bend
        result = np.empty(slip.size)
        bent = 0.0
        for k, (w, size) in enumerate(zip(slip.tolist(), sliding.tolist(), strict=True)):
            rate = w - stiffness * abs(w) / size * bent
            bent += rate * step
            result[k] = stiffness * bent + damping * rate
        return result + viscosity * slip

    return effort


def bouc_wen(draw: Callable[[float, float], float]) -> Truth:
    """A damper with Bouc-Wen's state beside a spring and a dashpot, all of which the field raises in proportion."""
    viscosity, thicker = draw(0.5, 2.0), draw(0.5, 2.5)
    floor, rise = draw(40.0, 120.0), draw(300.0, 700.0)
    spring, sharp, bend = draw(0.0, 2.0), draw(1.0, 2.0), draw(0.2, 1.0)
    beta = draw(0.3, 0.7)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        state = np.empty(slip.size)
        at = 0.0
        for k, w in enumerate(slip.tolist()):
            size = abs(at) ** sharp
            turned = (1.0 - beta) * abs(w) * np.sign(at) * size + beta * w * size
            at += (w - turned) * step / bend
            state[k] = at
        dashpot = viscosity * (1.0 + thicker * field) * slip
        return dashpot + (floor + rise * field) * state + spring * place

    return effort


def spencer(draw: Callable[[float, float], float]) -> Truth:
    """The modified Bouc-Wen damper of Spencer and others (1997) with its numbers, each up to a fifth off, to 2.25 V."""
    near = [draw(0.8, 1.2) for _ in range(8)]
    volts, per_mm = 2.25, 0.1  # cm of a mm

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        u = volts * field
        c0, c1 = near[0] * (21.0 + 3.5 * u), near[1] * (283.0 + 2.95 * u)  # N s/cm
        alpha = near[2] * (140.0 + 695.0 * u)  # N/cm
        k0, k1, x0 = near[3] * 46.9, near[4] * 5.0, near[5] * 14.3 * 0.1  # N/cm, cm
        gamma, amplitude = near[6] * 363.0, near[7] * 301.0  # 1/cm2, 1
        result = np.empty(slip.size)
        inner = z = 0.0
        for k, (v, x) in enumerate(
            zip((per_mm * slip).tolist(), (per_mm * place).tolist(), strict=True)
        ):
            rate = (alpha * z + c0 * v + k0 * (x - inner)) / (c0 + c1)
            relative = v - rate
            bends, turns = (
                amplitude * relative,
                gamma * abs(z) * (abs(relative) + relative * np.sign(z)),
            )
            z = (z + step * bends) / (
                1.0 + step * turns
            )  # backwards: it turns within less than a step
            inner += step * rate
            result[k] = c1 * rate + k1 * (x - x0)
        return result

    return effort


def hysteretic_tanh(draw: Callable[[float, float], float]) -> Truth:
    """Kwok's damper (2006): a tanh of the slip that the side of the position moves, and a field that saturates."""
    viscosity, thicker, spring = draw(0.5, 2.0), draw(0.0, 2.0), draw(0.0, 2.0)
    floor, rise, speed = draw(40.0, 120.0), draw(300.0, 700.0), draw(3.0, 12.0)
    moved, zero = draw(0.1, 0.8), draw(-30.0, 30.0)
    level = _level(draw)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        whole = floor + rise * level(field)
        side = moved * np.tanh(place)
        return (
            viscosity * (1.0 + thicker * field) * slip
            + spring * place
            + zero
            + whole * np.tanh(slip / speed + side)
        )

    return effort


def herschel_bulkley(draw: Callable[[float, float], float]) -> Truth:
    """An electrorheological clutch that thins, without a memory and without a friction."""
    rise, consistency, index, speed = (
        draw(300.0, 700.0),
        draw(5.0, 30.0),
        draw(0.4, 0.9),
        draw(0.3, 2.0),
    )
    thicker = draw(0.0, 1.0)
    level = _level(draw)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        flow = consistency * (1.0 + thicker * field) * np.sign(slip) * np.abs(slip) ** index
        return rise * level(field) * np.tanh(slip / speed) + flow

    return effort


def casson(draw: Callable[[float, float], float]) -> Truth:
    """A damper of Casson's flow with an inertia."""
    floor, rise, viscosity = draw(10.0, 80.0), draw(200.0, 600.0), draw(0.3, 2.0)
    speed, inertia = draw(0.5, 3.0), draw(0.0, 0.5)
    level = _level(draw)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        whole = floor + rise * level(field)
        flow = (np.sqrt(whole) + np.sqrt(viscosity * np.abs(slip))) ** 2
        return flow * np.tanh(slip / speed) + inertia * np.gradient(slip, step)

    return effort


def brake_with_drag(draw: Callable[[float, float], float]) -> Truth:
    """A brake whose seal rubs much, whose field works from its square on to saturation, and whose fluid tires."""
    drag, speed = draw(80.0, 250.0), draw(0.5, 4.0)
    rise, bends_at, weaker = draw(300.0, 700.0), draw(0.6, 1.2), draw(0.0, 0.15)
    viscosity, bend = draw(0.2, 1.0), draw(0.05, 0.4)

    def effort(field: float, slip: Array, place: Array, step: float) -> Array:
        state = np.empty(slip.size)
        at = 0.0
        for k, w in enumerate(slip.tolist()):
            at += (w - abs(w) * at) * step / bend
            state[k] = at
        raised = rise * np.tanh((field / bends_at) ** 2)
        return (
            drag * np.tanh(slip / speed)
            + raised * state * (1.0 - weaker * np.abs(slip) / 100.0)
            + viscosity * slip
        )

    return effort


TRUTHS = (
    dahl,
    lugre,
    bouc_wen,
    spencer,
    hysteretic_tanh,
    herschel_bulkley,
    casson,
    brake_with_drag,
)


def device(seed: int) -> Dataset:
    """Logs of three sines and a random motion at four fields; the kind goes by turns, the numbers are drawn."""
    rng = np.random.default_rng(seed)

    def draw(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    truth = TRUTHS[seed % len(TRUTHS)](draw)
    noise, drift = draw(0.005, 0.03), draw(0.0, 0.02)  # of the effort's spread
    levels = np.array([0.0, 1.0, 2.0, 3.0]) / 3.0
    levels[1:3] += [draw(-0.08, 0.08), draw(-0.08, 0.08)]
    hertz = (draw(0.5, 0.8), draw(1.2, 2.0), draw(3.0, 5.0))
    tops = (draw(20.0, 50.0), draw(30.0, 80.0), draw(40.0, 120.0))  # mm/s
    logs: list[Dataset] = []
    for f, field in enumerate(levels.tolist()):
        for motion in ("m0", "m1", "m2", "m9"):
            kind = {"m0": "slow sine", "m9": "random"}.get(motion, "sine")
            fine = PERIOD / STEPS
            steps = round(SECONDS[kind] / PERIOD) * STEPS
            time = fine * np.arange(float(steps))
            # Spencer's fluid bends under all that moves more slowly.
            faster = 3.0 if TRUTHS[seed % len(TRUTHS)] is spencer else 1.0
            if kind == "random":
                slip = _quake(draw, time, tops[1], hertz)
            else:
                number = int(motion[1])
                slip = tops[number] * np.sin(2.0 * np.pi * hertz[number] * time + draw(0.0, 6.28))
            slip *= faster
            place = fine * np.cumsum(slip)
            place -= 0.5 * (place.max() + place.min())
            effort = truth(field, slip, place, fine)[::STEPS]
            own = Element(np.full(effort.size, field), slip[::STEPS])
            clock = Clock(time[::STEPS], (Span(0, effort.size, PERIOD),))
            log = Dataset("single", (own,), effort, clock, Units("N", "A", "mm/s"))
            logs.append(replace(log, sources=(f"{motion} f{f}",)))
    data = joined(logs)
    spread = float(np.std(data.effort))
    effort = data.effort + noise * spread * rng.standard_normal(data.rows)
    for start, stop in data.source_rows:
        effort[start:stop] += drift * spread * float(rng.standard_normal())
    return replace(data, effort=effort)


def _quake(
    draw: Callable[[float, float], float], time: Array, top: float, hertz: tuple[float, ...]
) -> Array:
    """A motion that swells and dies away, of ten sines within the frequencies of the logs and a little beyond."""
    slip = np.zeros(time.size)
    for _ in range(10):
        own = np.exp(draw(np.log(hertz[0]), np.log(1.5 * hertz[-1])))
        slip += draw(0.3, 1.0) * np.sin(2.0 * np.pi * own * time + draw(0.0, 6.28))
    share = time / time[-1]
    slip *= share * np.exp(1.0 - share / 0.3) + 0.1
    return 1.3 * top * slip / np.abs(slip).max()


@dataclass(frozen=True)
class Judged:
    """How the recommendation does on the logs taken away: errors over the standard deviation of the effort there."""

    recommended: str
    best: str
    error: float
    ratio: float
    inside: float
    worst: float
    width: float


def bands_of(
    data: Dataset, left_out: tuple[str, ...], law: str
) -> Iterator[tuple[float, float, float]]:
    """Share inside, of the worst log, and half width over the needed: by the rules before, and now."""
    test = hold_out(data, left_out)
    train = data.take(~test)
    (candidate,) = KIND.candidates(Settings((law,), lag="none"), train)
    outcome = candidate.fit(train, (), 1)
    choice = chosen(train, [Fitted(candidate, outcome)], [outcome.name], seed=0)
    assert choice is not None
    assert outcome.unseen is not None
    new = choice.at_new_fields[outcome.name]
    predicted = outcome.model.predict(data)
    error = data.effort - predicted
    made = calibrated(data, ~test, [error], [outcome.parameters], [outcome.unseen])[0]
    assert made is not None
    before = with_haste(made[0], train, outcome.unseen)
    now = wide_next_to_standstill(before, train, outcome.unseen)
    needed = float(np.quantile(np.abs(error[test]), LEVEL))
    for band in (
        wider_at_new_fields(before, train, new.usual),
        wider_at_new_fields(now, train, new.usual, new.in_doubt),
    ):
        held = coverage(data, band.around(predicted, data.elements, data.clock), test)
        yield held.share, held.worst, 0.5 * held.width / needed


def judged(comparison: Comparison) -> Judged:
    """The recommendation on the rows held out."""
    taken, best = comparison.entry(comparison.recommended), comparison.entries[0]
    assert taken.band is not None
    held = taken.band.held
    size = np.abs(comparison.data.effort - taken.predicted)[comparison.test]
    return Judged(
        taken.name,
        best.name,
        taken.test.share.value,
        taken.test.rmse.value / best.test.rmse.value,
        held.share,
        held.worst,
        0.5 * held.width / float(np.quantile(size, LEVEL)),
    )


def asked_next(data: Dataset, case: str) -> tuple[Dataset, tuple[str, ...]]:
    """The logs of a case, and the patterns of those that are taken away; a random motion is asked of sines alone."""
    wanted = "m9" if case == "random" else ""
    kept = np.zeros(data.rows, np.bool_)
    for source, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        kept[start:stop] = wanted == "m9" or not str(source).startswith("m9")
    return data.take(kept), CASES[case]


def cases_of(
    seeds: range, only: str, cases: list[str]
) -> Iterator[tuple[str, str, Dataset, tuple[str, ...]]]:
    """Of each device and case: the kind, the case, the logs, the patterns of those that are taken away."""
    for seed in seeds:
        kind = TRUTHS[seed % len(TRUTHS)].__name__
        if only in kind:
            every = device(seed)
            for case in cases:
                data, left_out = asked_next(every, case)
                yield kind, case, data, left_out


def print_bands(seeds: range, only: str, cases: list[str]) -> None:
    """A line for each device and case, and what each case comes to."""
    found: dict[str, list[list[tuple[float, float, float]]]] = {case: [] for case in cases}
    for kind, case, data, left_out in cases_of(seeds, only, cases):
        law = LAW_OF.get(kind, OTHERWISE)
        both = list(bands_of(data, left_out, law))
        found[case].append(both)
        told = [
            f"{inside:4.0%}, worst {worst:4.0%}, width {width:5.2f}"
            for inside, worst, width in both
        ]
        print(f"{kind:<16} {case:<16} before {told[0]}; now {told[1]}: {law}", flush=True)
    for case, of_case in found.items():
        for rule, figures in zip(("before", "now"), np.array(of_case).swapaxes(0, 1), strict=True):
            inside, worst, width = figures.T
            print(
                f"{case:<16} {rule:<6} inside {inside.mean():6.1%} (least {inside.min():4.0%}), below 90 % in "
                f"{np.mean(inside < 0.9):4.0%}, above 99 % in {np.mean(inside > 0.99):4.0%}; worst log 80 % in "
                f"{np.mean(worst >= 0.8):4.0%}; half width {np.median(width):.2f} of the needed ({inside.size})"
            )


def print_recommended(seeds: range, only: str, cases: list[str], settings: Settings) -> None:
    """A line for each device and case, and what each case comes to."""
    found: dict[str, list[Judged]] = {case: [] for case in cases}
    for kind, case, data, left_out in cases_of(seeds, only, cases):
        own = judged(compare(data, replace(settings, test=left_out)))
        found[case].append(own)
        print(
            f"{kind:<16} {case:<16} {own.ratio:5.2f} times, {own.error:5.1%} of std, band holds {own.inside:4.0%}, "
            f"worst {own.worst:4.0%}, width {own.width:4.2f}: {own.recommended}, best {own.best}",
            flush=True,
        )
    for case, of_case in found.items():
        ratio = np.array([own.ratio for own in of_case])
        print(
            f"{case:<16} times {np.exp(np.log(ratio).mean()):.3f} (largest {ratio.max():.2f}, "
            f"over 1.1 in {np.mean(ratio > 1.1):4.0%})"
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first", type=int, default=0, help="seed of the first device")
    parser.add_argument("--devices", type=int, default=len(TRUTHS))
    parser.add_argument("--only", default="", help="a part of the kind's name")
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--recommend", action="store_true", help="fit several models")
    parser.add_argument("--models", nargs="+", default=list(LAWS))
    parser.add_argument(
        "--lag",
        default="none",
        help="of fit: auto searches for a memory, which takes half a minute",
    )
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.devices)
    if asked.recommend:
        settings = Settings(tuple(asked.models), lag=asked.lag)
        print_recommended(seeds, asked.only, asked.cases, settings)
    else:
        print_bands(seeds, asked.only, asked.cases)


if __name__ == "__main__":
    main()
