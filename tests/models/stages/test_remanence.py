"""Remanence: plays against known answers, its numbers found from nothing, and the ladder on iron of another model."""

from __future__ import annotations

from math import sinh, tanh

import numpy as np
import pytest

from erclutch.arithmetic.play import play
from erclutch.fit.choice.ladder import grown, of_iron, of_law
from erclutch.fit.kinds.law_alone import with_memory
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.laws.yield_stress import TANH
from erclutch.models.stages import stage_named
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Carry, Clock, Span
from erclutch.signals.device import Element, Units

PERIOD = 2e-3
ROWS = 6000


def clock_of(rows: int) -> Clock:
    return Clock(np.arange(float(rows)) * PERIOD, (Span(0, rows, PERIOD),))


def ramps(rows: int = ROWS) -> Array:
    """A current in A that rises and falls between random turns, some of them at zero."""
    rng = np.random.default_rng(4)
    turns = [0.0]
    for _ in range(16):
        turns += [rng.uniform(0.4, 2.0), rng.choice([0.0, rng.uniform(0.0, 1.0)])]
    return np.interp(np.linspace(0.0, len(turns) - 1.0, rows), np.arange(len(turns)), turns)


def behind(stage: str, command: Array, r_h: float, s_h: float) -> Array:
    """The field behind a command, in the command's unit over 2."""
    field: Array = stage_named(stage).respond(
        command / 2.0, clock_of(command.size), [r_h, s_h], slice(None)
    )
    return field


def brake(command: Array, field: Array) -> Dataset:
    """A brake that turns to and fro under a field in its iron; the log has the command."""
    t = np.arange(float(command.size)) * PERIOD
    slip = 15.0 * np.sin(5.7 * t) + 8.0 * np.sin(1.45 * t)
    effort = (0.15 + 4.0 * np.abs(field) ** 1.3) * np.tanh(slip / 0.8) + 0.01 * slip
    effort += 0.02 * np.random.default_rng(5).standard_normal(command.size)
    return Dataset(
        "single",
        (Element(command, slip),),
        effort,
        clock_of(command.size),
        Units("N*m", "A", "rad/s"),
    )


def iron(command: Array) -> Array:
    """Iron of Jiles and Atherton (1986, doi 10.1016/0304-8853(86)90066-1), which knows nothing of plays."""
    width, coupling, pinning, reversible = 0.25, 0.12, 0.12, 0.2
    magnetised = 0.0
    curve = [0.0]
    for before, now in zip(command[:-1].tolist(), command[1:].tolist(), strict=True):
        step = now - before
        if step == 0.0:
            curve.append(magnetised)
            continue
        x = (before + coupling * magnetised) / width
        small = abs(x) < 1e-4
        aim = x / 3.0 if small else 1.0 / tanh(x) - 1.0 / x
        slope = (1.0 / 3.0 if small else 1.0 / x**2 - 1.0 / sinh(x) ** 2) / width
        way = 1.0 if step > 0.0 else -1.0
        away = aim - magnetised
        pinned = 0.0 if way * away < 0.0 else away / (way * pinning - coupling * away)
        magnetised += (reversible * slope + (1.0 - reversible) * pinned) * step
        curve.append(magnetised)
    return np.array(curve)


def test_a_play_moves_once_the_signal_has_gone_its_way() -> None:
    u = np.array([0.0, 0.5, 2.0, 1.5, 0.5, 0.0, 0.3, 2.0])
    x = play(u, 1.0, clock_of(u.size))
    assert x.tolist() == [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    assert play(u, 0.4, clock_of(u.size)).tolist() == pytest.approx(
        [0.0, 0.1, 1.6, 1.6, 0.9, 0.4, 0.4, 1.6]
    )


def test_a_play_begins_anew_in_each_span_and_goes_on_over_a_border_inside_of_one() -> None:
    u = np.array([0.0, 2.0, 0.0, 3.0, 2.5, 2.0])
    whole = clock_of(u.size)
    parted = Clock(whole.time, (Span(0, 2, PERIOD), Span(2, 6, PERIOD)))
    assert play(u, 1.0, parted).tolist() == [0.0, 1.0, 0.0, 2.0, 2.0, 2.0]

    first, second = Carry([], 3), Carry([], 2)
    early = Clock(whole.time[:4], (Span(0, 4, PERIOD),), carry=first)
    begun = play(u[:4], 1.0, early)
    second.begin = first.end
    late = Clock(whole.time[3:], (Span(0, 3, PERIOD),), carry=second)
    joined = [*begun.tolist(), *play(u[3:], 1.0, late).tolist()[1:]]
    assert joined == play(u, 1.0, whole).tolist()


@pytest.mark.parametrize("stage", ["remanence", "remanence-1", "remanence-4"])
def test_what_stays_does_not_hang_on_the_pace_or_on_noise(stage: str) -> None:
    command = np.concatenate([np.linspace(0.0, 2.0, 400), np.linspace(2.0, 0.0, 400)])
    edges = 0.3 * np.arange(1, stage_named(stage).plays + 1) / stage_named(stage).plays  # type: ignore[attr-defined]
    left = 0.6 * float(np.mean(edges))
    assert behind(stage, command, 0.3, 0.6)[-1] == pytest.approx(left)
    assert behind(stage, command[[0, 399, 799]], 0.3, 0.6)[-1] == pytest.approx(left)
    # At rest for long, under a noise of half an edge at most: nothing creeps.
    waiting = np.zeros(5000)
    waiting[::2] = 0.01
    assert behind(stage, np.concatenate([command, waiting]), 0.3, 0.6)[-1] == pytest.approx(left)


@pytest.mark.slow
def test_known_numbers_are_found_in_the_unit_of_the_field() -> None:
    command = ramps()
    log = brake(command, behind("remanence", command, 0.15, 0.6))
    law = law_from_name("bingham", "single")
    outcome = fit_structure(log, Structure("single", "bingham", law, "remanence", friction=True))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert outcome.sound
    assert found["r_h"].unit == "A"
    truth = {"r_h": 0.15 * 2.0, "s_h": 0.6, "n": 1.3, "T_f": 0.15, "eta": 0.01}
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name
    assert found["r_h"].high - found["r_h"].low < 0.1 * 0.3


@pytest.mark.slow
def test_the_data_ask_for_it_on_iron_of_another_model_and_not_without() -> None:
    command = ramps()
    base = Structure(
        "single", "bingham/tanh", law_from_name("bingham/tanh", "single"), "none", friction=True
    )
    among = ("dahl/field", "remanence")
    rungs = grown(brake(command, iron(command / 2.0)), base, among=among)
    assert "remanence" in rungs[-1].structure.dynamics.split("+")
    assert rungs[-1].error < 0.4 * rungs[0].error

    without = grown(brake(command, command / 2.0), base, among=among)
    assert all("remanence" not in rung.structure.dynamics for rung in without)


@pytest.mark.slow
def test_iron_that_keeps_a_field_saturates_too() -> None:
    """By itself either shows little: with a power of the field a third of what the iron does would stay."""
    command = ramps()
    base = Structure("single", "bingham", law_from_name("bingham", "single"), "none", friction=True)
    rungs = grown(brake(command, iron(command / 2.0)), base, among=("dahl/field", "remanence"))
    assert (rungs[-1].structure.specification, rungs[-1].structure.dynamics) == (
        "bingham/tanh",
        "remanence",
    )
    assert rungs[-1].error < 0.2 * rungs[0].error
    # Another law of the same memory saturates as well.
    train = brake(command, iron(command / 2.0))
    other = Structure("single", "casson", law_from_name("casson", "single"), "none", friction=True)
    assert of_law(train, rungs[-1], other).structure.specification == "casson/tanh"

    # Where a power of the field is the truth, it stays.
    plays = brake(command, behind("remanence", command, 0.15, 0.6))
    rungs = grown(plays, base, among=("remanence",))
    assert (rungs[-1].structure.specification, rungs[-1].structure.dynamics) == (
        "bingham",
        "remanence",
    )


@pytest.mark.slow
def test_another_law_gets_the_iron_where_fields_change_within_a_log() -> None:
    """Of a series of kernels no number may be told: then no law with a memory could be recommended."""
    command = ramps()
    log = brake(command, iron(command / 2.0))
    named = ("rbfm-5", "bingham", "casson")
    laws = [
        fit_structure(log, Structure("single", name, law_from_name(name, "single")))
        for name in named
    ]
    candidates, _ = with_memory(log, laws)
    with_iron = [each.structure.specification for each in candidates if of_iron(each.structure)]
    assert len(set(with_iron)) == 2
    assert all(name.endswith("/tanh") for name in with_iron)
    # Laws that are asked for by name saturate too, and each stands there once: a run keeps one model of a name.
    candidates, _ = with_memory(log, laws, named)
    names = [each.name for each in candidates]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    ("law", "saturating"),
    [
        ("casson", "casson/tanh"),
        ("casson/power", "casson/tanh"),
        ("bingham/power/forward", "bingham/tanh/forward"),
    ],
)
def test_a_law_of_any_form_gets_another_form(law: str, saturating: str) -> None:
    """A form that was spelled out stayed in the name beside the other, and the fit ended in an unknown yield stress."""
    assert (
        Structure("single", law, law_from_name(law, "single")).with_yield_form(TANH).specification
        == saturating
    )


def test_a_steady_field_is_not_asked() -> None:
    steady = brake(np.full(ROWS, 1.0), np.full(ROWS, 0.5))
    base = Structure(
        "single", "bingham/constant", law_from_name("bingham/constant", "single"), "none"
    )
    rungs = grown(steady, base, among=("remanence",))
    assert len(rungs) == 1


@pytest.mark.slow
def test_a_play_within_the_noise_of_a_measured_current_is_no_remanence() -> None:
    """It smooths the noise, and an estimate gets better by that; the iron of this brake keeps nothing."""
    true = np.abs(ramps())
    measured = true + 0.01 * np.random.default_rng(7).standard_normal(true.size)
    train = brake(measured, true / 2.0)
    law = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "none", friction=True, offset=True
    )
    assert [rung.structure.dynamics for rung in grown(train, law, among=["remanence"])] == ["none"]


@pytest.mark.slow
def test_remanence_is_told_through_the_noise_of_a_measured_current() -> None:
    true = ramps()
    field = behind("remanence", true, r_h=0.3, s_h=0.7)
    measured = true + 0.01 * np.random.default_rng(7).standard_normal(true.size)
    law = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "none", friction=True, offset=True
    )
    rungs = grown(brake(measured, field), law, among=["remanence"])
    assert [rung.structure.dynamics for rung in rungs] == ["none", "remanence"]
