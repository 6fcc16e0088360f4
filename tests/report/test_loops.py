"""Loops of effort over slip: windows are what they say, areas are right; stages are credited with their own gain."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import CheckError
from erclutch.logs.dataset import Dataset
from erclutch.report.html.dynamics_section import DYNAMICS
from erclutch.report.html.picture_sections import LOOPS
from erclutch.report.html.symbols import plain_symbol
from erclutch.report.numbers.effort_loops import effort_loops, loop_areas
from erclutch.report.numbers.model_stages import APART, remembers_slip, stage_gain
from erclutch.report.numbers.run_material import Material, material_of
from erclutch.report.plots.loops_plot import describe_loops
from erclutch.report.plots.run_plots import write_figure
from erclutch.runs.run_folder import read_run
from erclutch.runs.run_rows import RunRows
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

LONG = "bingham+rise-fall+dahl-2/field+inertia+effort-lag"


def rows_of(phase: float, fields: tuple[float, ...] = (0.0, 1.0, 2.0)) -> RunRows:
    """A sine of slip at 5 Hz, 10 periods at each field, and an effort that follows with a phase; all held out."""
    n = 2000
    t = np.arange(n * len(fields)) / 1000.0
    slip = np.sin(2 * np.pi * 5 * t)
    field = np.repeat(fields, n)
    effort = (1.0 + field) * np.sin(2 * np.pi * 5 * t + phase)
    spans = tuple(Span(k * n, (k + 1) * n, 1e-3) for k in range(len(fields)))
    data = Dataset(
        "single", (Element(field, slip),), effort, Clock(t, spans), Units("N", "V", "m/s")
    )
    models = {"right": effort, "half": 0.5 * effort, "closed": (1.0 + field) * slip}
    return RunRows(data, np.ones(t.size, np.bool_), models)


def test_windows_are_whole_periods_at_a_field_each() -> None:
    loops = effort_loops(rows_of(0.5), ["right"])
    assert [loop.fields for loop in loops] == [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]
    for loop in loops:
        assert loop.held
        assert loop.slip.size > 200
        assert abs(loop.slip[0] - loop.slip[-1]) < 0.05
        assert float(np.ptp(loop.travel)) == pytest.approx(2 / (2 * np.pi * 5), rel=0.01)
        assert loop.modelled["right"].tolist() == loop.measured.tolist()


def test_of_several_logs_each_loop_names_its_own() -> None:
    rows = rows_of(0.5)
    assert {loop.log for loop in effort_loops(rows, ["right"])} == {""}
    logs = replace(
        rows.data, sources=("a", "b", "c"), source_rows=((0, 2000), (2000, 4000), (4000, 6000))
    )
    assert [loop.log for loop in effort_loops(replace(rows, data=logs), ["right"])] == [
        "a",
        "b",
        "c",
    ]


def test_the_area_of_an_ellipse() -> None:
    """An effort with a phase runs around an ellipse, which fills pi / 4 sin(phase) of its box."""
    for phase in (0.1, -0.4, 1.2):
        found = loop_areas(rows_of(phase), ["right", "half", "closed"])
        assert found is not None
        assert found.periods == 3 * 8
        assert found.measured == pytest.approx(np.pi / 4 * abs(np.sin(phase)), rel=0.02)
        assert found.drawn["right"] == pytest.approx(1.0)
        assert found.drawn["half"] == pytest.approx(0.5)
        assert found.drawn["closed"] == pytest.approx(0.0, abs=0.02)


def test_a_pair_shows_each_clutch_while_the_other_is_free() -> None:
    single = rows_of(0.5)
    (own,) = single.data.elements
    first = np.where(np.arange(own.field.size) < 4000, own.field, 0.0)
    pair = (Element(first, own.slip), Element(own.field - first, -own.slip))
    data = Dataset(
        "coaxial", pair, single.data.effort, single.data.clock, Units("N*m", "", "rad/s")
    )
    loops = effort_loops(RunRows(data, single.test, single.predicted), ["right"])
    assert {(loop.element, loop.fields[1]) for loop in loops} == {
        (0, 0.0),
        (0, 1.0),
        (1, 0.0),
        (1, 2.0),
    }


def test_no_loop_where_the_slip_never_turns(material: Material) -> None:
    rows = rows_of(0.5)
    (own,) = rows.data.elements
    data = Dataset(
        "single",
        (Element(own.field, own.slip * 0 + 3.0),),
        rows.data.effort,
        rows.data.clock,
        rows.data.units,
    )
    still = RunRows(data, rows.test, rows.predicted)
    assert effort_loops(still, ["right"]) == []
    assert loop_areas(still, ["right"]) is None
    predicted = {name: rows.data.effort for name in material.run.names}
    empty = Material(material.run, RunRows(data, rows.test, predicted))
    assert LOOPS.fill(empty) is None
    with pytest.raises(CheckError, match="does not go to and fro"):
        describe_loops(empty)


def test_symbols_come_from_their_names() -> None:
    names = ("tau_rise", "zeta_e", "gamma", "lamda_1", "r_1", "delay", "eta_0_1")
    assert [plain_symbol(name) for name in names] == [
        "τ_rise",
        "ζ_e",
        "γ",
        "λ_1",
        "r_1",
        "delay",
        "η_0,1",
    ]


def entry(name: str, rmse: float, **more: Any) -> dict[str, Any]:
    return {"name": name, "test": {"rmse": [rmse, None, None]}, "dynamics": {}, **more}


def test_stages_are_credited_with_their_own_gain_alone() -> None:
    """A network with past samples beside a law with a lag tells nothing of the lag."""
    assert (
        stage_gain([entry("fnn-16", 1.0), entry("bingham+lag", 2.0), entry("casson", 3.0)]) is None
    )
    found = stage_gain([entry("fnn-16", 1.0), entry("bingham+lag", 2.0), entry("bingham", 3.0)])
    assert found is not None
    assert (found.richer["name"], found.plainer["name"], found.added) == (
        "bingham+lag",
        "bingham",
        ("lag",),
    )
    apart = [
        entry("fnn-16+lag", 1.0, **{APART: "past 5"}),
        entry("fnn-16", 2.0, **{APART: "past none"}),
    ]
    assert stage_gain(apart) is None
    assert stage_gain([entry("a+lag", 1.0), entry("a+rise-fall", 2.0)]) is None
    found = stage_gain(
        [entry("bingham+fnn-4+lag", 1.0), entry("bingham", 2.0), entry("bingham+fnn-4", 3.0)]
    )
    assert found is not None
    assert (found.richer["name"], found.plainer["name"]) == ("bingham+fnn-4+lag", "bingham+fnn-4")


def test_memory_of_the_slip_is_told_from_other_stages() -> None:
    assert remembers_slip({"name": "casson+dahl/field", "dynamics": {"r_1": 0.01}})
    assert not remembers_slip(
        {"name": "casson+lag+effort-lag", "dynamics": {"delay": 0.0, "tau": 0.1, "tau_e": 0.1}}
    )
    assert not remembers_slip({"name": "casson+viscous", "dynamics": {"p": 1.0}})


@pytest.fixture(scope="module")
def long_chain(
    run_maker: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> Material:
    lag = LONG.partition("+")[2]
    run = run_maker(tmp_path_factory.mktemp("chain"), seconds=2.0, models=("bingham",), lag=lag)
    return material_of(read_run(run))


@pytest.mark.slow
def test_constants_of_any_chain_have_units_and_intervals(long_chain: Material) -> None:
    values = DYNAMICS.fill(long_chain)
    (model,) = values["models"]
    assert model["title"] == long_chain.titles[LONG]
    assert [len(stage["rows"]) for stage in model["stages"]] == [3, 4, 1, 1]
    units = {str(row["meaning"]): row["unit"] for stage in model["stages"] for row in stage["rows"]}
    assert units["time constant of the rising field"] == "ms"
    assert units["travel over which memory 1 yields"] == "rad"
    assert units["inertia between fluid and load cell"] == "N·m/(rad/s²)"
    assert values["figures"]
    assert "nothing tells what the stages gain" in values["lead"]


@pytest.mark.slow
def test_the_figure_has_its_numbers(long_chain: Material, tmp_path: Path) -> None:
    paths = write_figure("loops", long_chain, tmp_path)
    assert sorted(path.suffix for path in paths) == [".csv", ".pdf", ".png"]
    with (tmp_path / "loops.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["curve"] for row in rows} == {"measured", LONG}
    assert "at a steady field" in LOOPS.fill(long_chain)["lead"]
