"""The band and the alarms of an exported step: the record in NumPy, the C, and what the alarms promise."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, export_model, step_of, verify_export
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.export.cost import operations
from erclutch.export.exported_step import DRIFT, NON_FINITE, OUTSIDE, WIDE_BAND, ExportedStep
from erclutch.export.step_numbers import band_of, inverse, inverse_now, run
from erclutch.export.step_record import step_record
from erclutch.export.targets.python import compile_model
from erclutch.models.alarms import Alarms, alarms_of
from erclutch.models.band import Band
from erclutch.models.model import Model
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, slips_of
from tests.support.examples import examples
from tests.support.slow_params import slow_but
from tests.support.wide_band import BAND, HASTY, SMOOTH

BLOCK, SHORT = 20, 5
#: One of each device, with gaps in the grid, with and without a memory.
LABELS = ("bingham, single", "fnn-16, coaxial", "bingham+rise-fall, coaxial")


def alarmed(
    model: Any, precision: str = "float64", block: int = BLOCK, band: Band = BAND
) -> ExportedStep:
    """A step with alarms whose blocks are short and whose goal is near."""
    options = ExportOptions("m", precision, 1e-3, alarms=True)  # type: ignore[arg-type]
    made = step_of(replace(model, band=band), options)
    assert made.alarms is not None
    return replace(made, alarms=replace(made.alarms, block=block, goal=1000.0))


def motion(made: ExportedStep, count: int, seed: int = 0) -> Array:
    """Slow rows within the ranges; no measured effort."""
    rng, e = np.random.default_rng(seed), made.elements
    held = np.repeat(rng.uniform(*made.field.range, count // 50 + 1), 50)[:count]
    fields = (
        [held] if e == 1 else [np.where(held > 300.0, held, 0.0), np.where(held > 300.0, 0.0, held)]
    )
    speeds = [12.0 * np.sin(np.arange(count) / 40.0 + i) for i in range(e)]
    return np.column_stack([*fields, *speeds, np.full(count, np.nan)])


def measuring(made: ExportedStep, rows: Array, errors: Array) -> Array:
    """The rows with measured efforts: errors of one are at the ends of the band."""
    effort = run(made, rows)[0].astype(np.float64)
    low, high = band_of(made, rows).astype(np.float64).T
    rows = rows.copy()
    rows[:, -1] = effort + np.where(errors < 0, effort - low, high - effort) * errors
    return rows


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("label", LABELS)
def test_the_c_gives_the_bits_of_the_record(
    label: str, precision: str, models: dict[str, Model], need: Callable[..., None]
) -> None:
    need("gcc")
    made = alarmed(models[label], precision, band=SMOOTH)
    rows = motion(made, 3000)
    noise = np.random.default_rng(1).normal(size=len(rows))
    rows = measuring(made, rows, np.where(np.arange(len(rows)) < 1000, 0.5 * noise, 2.0 + noise))
    rows[::97, 0], rows[5::31, -1] = np.nan, np.inf
    rows = rows.astype(made.precision.dtype).astype(np.float64)
    effort, flags = run(made, rows)
    assert {int(bit) for bit in (OUTSIDE, NON_FINITE, WIDE_BAND, DRIFT) if np.any(flags & bit)} >= {
        2,
        32,
        64,
    }
    device = compile_model(made)
    found = device.run(np.ascontiguousarray(rows))
    with pytest.raises(TypeError, match="are no rows of"):
        device.run(np.ascontiguousarray(rows[: rows.shape[1] * 2, :-1]))
    assert np.array_equal(np.array(found[0]), effort.astype(np.float64))
    assert np.array_equal(np.array(found[1]), flags)
    device.reset()
    for row, ends in zip(rows[:300].tolist(), band_of(made, rows[:300]).tolist(), strict=True):
        device.step(*row)
        assert device.band == tuple(ends)


@pytest.mark.slow
@pytest.mark.parametrize(
    "band", [BAND, HASTY, SMOOTH], ids=["plain", "by haste", "by smoothed haste"]
)
@pytest.mark.parametrize("label", slow_but(("bingham, single",), LABELS))
def test_the_band_is_the_models(label: str, band: Band, models: dict[str, Model]) -> None:
    made = alarmed(models[label], band=band)
    rows = motion(made, 500)
    e = made.elements
    fields, slips = rows[:, :e].T, slips_of(made.device, list(rows[:, e : 2 * e].T))
    elements = [Element(f, w) for f, w in zip(fields, slips, strict=True)]
    clock = Clock(1e-3 * np.arange(500.0), (Span(0, 500, 1e-3),))
    effort, flags = run(made, rows)
    low, high = band.around(effort, elements, clock)
    assert np.array_equal(band_of(made, rows), np.column_stack([low, high]))
    assert np.array_equal((flags & WIDE_BAND) != 0, high - low > 0.25 * made.scale)


@pytest.mark.slow
@pytest.mark.parametrize("label", LABELS)
def test_far_from_all_rows_there_is_no_band(label: str, models: dict[str, Model]) -> None:
    made = alarmed(models[label])
    rows = motion(made, 200)
    wide = (run(made, rows)[1] & WIDE_BAND) != 0
    assert not np.all(wide)
    fast = rows.copy()
    fast[100:, made.elements] += 3.0 * made.slip.hold[1]
    found = (run(made, fast)[1] & WIDE_BAND) != 0
    assert np.all(found[100:])
    assert np.array_equal(found[:100], wide[:100])


def test_edges_of_a_band_cost_nothing_in_a_step(models: dict[str, Model]) -> None:
    many = alarmed(models[LABELS[0]])
    assert many.alarms is not None
    whole = replace(BAND, field_edges=(), slip_edges=(), behind=(1.0, 2.0), ahead=(1.5, 2.5))
    one = replace(many, alarms=replace(many.alarms, band=whole))
    counts = [operations(step_record(step).record.flat(), step) for step in (many, one)]
    assert counts[0] == counts[1]


@pytest.mark.slow
def test_alarms_change_no_effort_and_no_inverse(models: dict[str, Model]) -> None:
    for label in LABELS:
        made, plain = (
            alarmed(models[label]),
            step_of(models[label], ExportOptions("m", period=1e-3)),
        )
        rows = measuring(made, motion(made, 200), np.full(200, 3.0))
        assert np.array_equal(run(made, rows)[0], run(plain, rows[:, :-1])[0])
        wanted = np.linspace(-0.5, 0.5, 20)
        for of in (inverse, inverse_now):
            for got, expected in zip(
                of(made, rows[:20], wanted), of(plain, rows[:20, :-1], wanted), strict=True
            ):
                assert np.array_equal(got, expected)


# --- drift -----------------------------------------------------------------------------------------------------------


@cache
def watcher() -> tuple[Alarms, Callable[[Array], Array]]:
    """The wealth over blocks from the misses of each, with blocks of 100 rows."""
    alarms = alarms_of(BAND, 1.0, 0.01)

    def over(misses: Array) -> Array:
        wealth, found = np.zeros(misses.shape[1:]), []
        for block in misses:
            wealth = alarms.wealth(wealth, block / alarms.block, alarms.missing)
            found.append(wealth)
        return np.array(found)

    return alarms, over


def _misses(alarms: Alarms, blocks: int, runs: int, correlation: float) -> Array:
    """Rows of AR(1) residuals outside a band that holds all but the tolerated share, in each block, (blocks, runs)."""
    rng = np.random.default_rng(4)
    state, counts = rng.normal(size=runs), np.zeros((blocks, runs))
    edge = 1.6448536  # of 10 % on both sides
    for block in range(blocks):
        for _ in range(alarms.block):
            state = correlation * state + np.sqrt(1.0 - correlation**2) * rng.normal(size=runs)
            counts[block] += np.abs(state) > edge
    return counts


@pytest.mark.slow
@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_false_alarms_are_as_rare_as_said(correlation: float) -> None:
    """At the very share of misses that is tolerated, with a goal of a thousand blocks, in 60,000 blocks."""
    alarms, _ = watcher()
    alarms = replace(alarms, goal=1000.0)
    misses = _misses(alarms, 100, 600, correlation)
    assert abs(misses.mean() / alarms.block - alarms.missing) < 0.003
    wealth, raised = np.zeros(600), 0
    for block in misses:
        wealth = alarms.wealth(wealth, block / alarms.block, alarms.missing)
        raised += int(np.sum(wealth >= alarms.goal))
        wealth = np.where(wealth >= alarms.goal, 0.0, wealth)
    assert raised <= 60 + 3 * np.sqrt(60)


@pytest.mark.slow
@pytest.mark.parametrize(("correlation", "least", "most"), [(0.0, 0.0, 0.001), (0.9, 0.15, 0.2)])
def test_blocks_that_lean_by_chance_raise_no_more(
    correlation: float, least: float, most: float
) -> None:
    """AR(1) residuals, 95 % of them in the band: with long correlation nearly as many blocks lean as may."""
    alarms, _ = watcher()
    alarms = replace(alarms, goal=1000.0)
    rng, runs, blocks = np.random.default_rng(6), 600, 100
    state, wealth, raised, leaning = rng.normal(size=runs), np.zeros(runs), 0, 0.0
    for _ in range(blocks):
        total = np.zeros(runs)
        for _ in range(alarms.block):
            state = correlation * state + np.sqrt(1.0 - correlation**2) * rng.normal(size=runs)
            total += np.clip(state / 1.96, -1.0, 1.0)
        above = (total / alarms.block > alarms.lean).astype(float)
        leaning += above.mean() / blocks
        wealth = alarms.wealth(wealth, above, alarms.leaning)
        raised += int(np.sum(wealth >= alarms.goal))
        wealth = np.where(wealth >= alarms.goal, 0.0, wealth)
    assert least <= leaning <= most
    assert raised <= 60 + 3 * np.sqrt(60)


@pytest.mark.slow
def test_a_residual_that_leans_inside_the_band_is_a_drift() -> None:
    made = _single()
    rows = motion(made, 60 * SHORT)
    forward = np.where(rows[:, 1] < 0, -1.0, 1.0)
    for share, told in ((0.3, True), (-0.3, True), (0.1, False)):
        assert bool(run(made, measuring(made, rows, share * forward))[1][-1] & DRIFT) == told
    assert (
        not run(made, measuring(made, rows, 0.9 * np.resize([1.0, -1.0], len(rows))))[1][-1] & DRIFT
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "asked", "told"),
    [(-0.04, 0.005, True), (0.04, 0.005, True), (0.015, 0.005, False), (-0.04, None, False)],
)
def test_residuals_that_are_a_part_of_the_estimate_are_a_drift(
    part: float, asked: float | None, told: bool
) -> None:
    """They lie inside the band and lean less than is told."""
    watched = alarmed(_single().model, block=SHORT, band=replace(BAND, part=asked))
    rows = motion(watched, 200 * SHORT)
    effort = run(watched, rows)[0].astype(np.float64)
    low, high = band_of(watched, rows).astype(np.float64).T
    rows[:, -1] = (1.0 + part) * effort
    assert np.all((low < rows[:, -1]) & (rows[:, -1] < high))
    assert bool(np.any(run(watched, rows)[1] & DRIFT)) == told


def test_blocks_that_follow_the_estimate_as_often_as_tolerated_raise_no_more() -> None:
    alarms = replace(alarms_of(replace(BAND, part=0.05), 1.0, 0.01), goal=1000.0)
    rng, wealth, raised = np.random.default_rng(8), np.zeros(600), 0
    for _ in range(100):
        followed = (rng.uniform(size=600) < alarms.following).astype(float)
        wealth = alarms.wealth(wealth, followed, alarms.following)
        raised += int(np.sum(wealth >= alarms.goal))
        wealth = np.where(wealth >= alarms.goal, 0.0, wealth)
    assert raised <= 60 + 3 * np.sqrt(60)


def test_alarms_say_how_seldom_they_come_by_chance() -> None:
    assert 1.0 / alarms_of(replace(BAND, part=0.05), 1.0, 0.01).false_alarms == 500_000
    assert 1.0 / alarms_of(BAND, 1.0, 0.01).false_alarms == pytest.approx(2e6 / 3.0)


def test_a_drift_is_found_and_its_end_too() -> None:
    alarms, over = watcher()
    share = np.repeat([0.05, 0.6, 0.0], [50, 20, 3])
    wealth = over((share * alarms.block)[:, None])[:, 0]
    assert wealth[:50].max() < 1.0
    assert 5 < np.argmax(wealth >= alarms.goal) - 50 < 12
    assert wealth[69] == alarms.goal
    assert wealth[70] < alarms.goal


ODD = st.sampled_from([np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.0])


@pytest.mark.slow
@settings(deadline=None, max_examples=examples(30))
@given(st.data())
def test_no_input_spoils_an_alarm_for_ever(data: st.DataObject) -> None:
    made = _single()
    odd = np.array(
        data.draw(
            st.lists(st.tuples(*[ODD | st.floats(-50.0, 700.0)] * 3), min_size=1, max_size=60)
        )
    )
    after = measuring(made, motion(made, 12 * SHORT), np.tile([0.3, -0.4], 6 * SHORT))
    far = after.copy()
    far[:, -1] += 10.0
    quiet, loud = (run(made, np.concatenate([odd, rows]))[1][-1] & DRIFT for rows in (after, far))
    assert not quiet
    assert loud


@cache
def _single() -> ExportedStep:
    from erclutch.models.law_model import TorqueModel
    from erclutch.models.laws import law_from_name
    from erclutch.models.model import Range
    from erclutch.models.structure import Reference, Structure
    from erclutch.signals.device import Units

    structure = Structure("single", "bingham", law_from_name("bingham", "single"))
    shape = {s.name: 0.4 * (s.lower + s.upper) for s in structure.shapes(1e-3)}
    gains = {g.name: 0.1 for g in structure.gains()}
    ranges = Range((0.0, 600.0), (-25.0, 25.0), (-1.0, 1.0))
    model = TorqueModel(
        structure, Reference(600.0, 17.0, 1e-3), shape, gains, Units("N*m", "V", "rad/s"), ranges
    )
    return alarmed(model, block=SHORT)


@pytest.mark.slow
def test_rows_that_no_training_row_was_near_do_not_count() -> None:
    made = _single()
    rows = measuring(made, motion(made, 20 * BLOCK), np.full(20 * BLOCK, 5.0))
    assert run(made, rows)[1][-1] & DRIFT
    rows[:, 1] = 100.0
    assert not np.any(run(made, rows)[1] & DRIFT)


# --- exports ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_plain_export_says_nothing_of_alarms(models: dict[str, Model], tmp_path: Path) -> None:
    folders = [
        export_model(model, tmp_path / name, options=ExportOptions("m", period=1e-3))
        for name, model in (
            ("without", models[LABELS[0]]),
            ("with", replace(models[LABELS[0]], band=BAND)),  # type: ignore[type-var]
        )
    ]
    digests = [json.loads((folder / "model.json").read_text())["digest"] for folder in folders]
    for name in ("m.c", "m.h", "m_check.c", "Makefile"):
        texts = [
            (folder / name).read_text().replace(d, "")
            for folder, d in zip(folders, digests, strict=True)
        ]
        texts = [
            re.sub(r"\bM_H_[0-9a-f]{16}\b", "", text) for text in texts
        ]  # the header's mark follows its text
        assert texts[0] == texts[1]
        assert "DRIFT" not in texts[0]
    assert "alarms" not in (folders[0] / "export.json").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("to", ["c", "python"])
@pytest.mark.parametrize("label", LABELS)
def test_exports_with_alarms_verify(
    label: str, to: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "g++")
    model: Any = replace(models[label], band=BAND)  # type: ignore[type-var]
    options = ExportOptions("m", "float32", 1e-3, alarms=True)
    checks = verify_export(export_model(model, tmp_path / to, to, options))
    assert checks
    assert all(check.passed and check.other_bits == 0 for check in checks), checks


def test_what_has_no_alarms_says_so(models: dict[str, Model]) -> None:
    with pytest.raises(ExportError, match="alarms need a band"):
        step_of(models[LABELS[0]], ExportOptions(alarms=True))
    model: Any = replace(models["fnn-16, coaxial"], band=BAND)  # type: ignore[type-var]
    with pytest.raises(ExportError, match="alarms need a sampling period"):
        step_of(model, ExportOptions(alarms=True))


@pytest.mark.slow
def test_a_library_without_alarms_has_no_band(
    models: dict[str, Model], need: Callable[..., None]
) -> None:
    need("gcc")
    device: CompiledModel = compile_model(
        step_of(models[LABELS[0]], ExportOptions("m", period=1e-3))
    )
    with pytest.raises(TypeError, match="exported without alarms"):
        _ = device.band


def test_alarms_need_a_period_and_a_band(models: dict[str, Model]) -> None:
    model: Any = models["fnn-16, coaxial"]
    with pytest.raises(ExportError, match="alarms need a sampling period"):
        step_of(replace(model, band=BAND), ExportOptions(alarms=True))
    with pytest.raises(ExportError, match="alarms need a band"):
        step_of(model, ExportOptions(alarms=True, period=1e-3))
