"""A ripple over the position is read, found from nothing, chosen by the data, and kept with the model."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.law_model import model_from_dict
from erclutch.models.laws import law_from_name
from erclutch.models.stages import stage_named
from erclutch.models.stages.ripple import Ripple
from erclutch.models.structure import Structure
from erclutch.signals.array import rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import POSITION

ROWS, LENGTH = 2000, 0.0137  # rad: some 44 periods over the way of the log
COSINE, SINE, SPRING = 0.31, -0.12, 0.8  # N m, N m, N m/rad


SECOND_LENGTH, SECOND_COSINE, SECOND_SINE = (
    0.0343,
    0.05,
    0.08,
)  # rad, N m, N m: a bearing beside the gear


def log(*, start: float = 0.4, ripple: float = 1.0, second: float = 0.0) -> Dataset:
    """A made-up joint that turns to and fro; its position begins anywhere."""
    t = np.arange(float(ROWS)) * 2e-3
    slip = 0.9 * np.cos(3.0 * t) + 0.3 * np.cos(7.1 * t)
    position = start + 0.3 * np.sin(3.0 * t) + 0.3 / 7.1 * np.sin(7.1 * t)
    angle = 2.0 * np.pi * position / LENGTH
    effort = 1.5 * np.tanh(slip / 0.05) + 0.4 * slip + SPRING * position
    effort += ripple * (COSINE * np.cos(angle) + SINE * np.sin(angle))
    angle = 2.0 * np.pi * position / SECOND_LENGTH
    effort += second * (SECOND_COSINE * np.cos(angle) + SECOND_SINE * np.sin(angle))
    effort += 0.02 * np.random.default_rng(5).standard_normal(ROWS)
    clock, units = Clock(t, (Span(0, ROWS, 2e-3),)), Units("N*m", "?", "rad/s")
    return Dataset(
        "single",
        (Element(np.zeros(ROWS), slip),),
        effort,
        clock,
        units,
        extras={POSITION: position},
    )


def structure(stages: str = "ripple") -> Structure:
    return Structure(
        "single", "bingham/constant", law_from_name("bingham/constant", "single"), stages
    )


@pytest.mark.slow
def test_known_numbers_are_found_in_the_unit_of_the_position() -> None:
    outcome = fit_structure(log(), structure())
    found = {e.name: e for e in outcome.estimates}
    assert outcome.sound
    units = {name: found[name].unit for name in ("lambda_p", "T_rc1", "c_1")}
    assert units == {"lambda_p": "rad", "T_rc1": "N*m", "c_1": "N*m/rad"}
    for name, value in {
        "lambda_p": LENGTH,
        "T_rc1": COSINE,
        "T_rs1": SINE,
        "c_1": SPRING,
        "eta": 0.4,
    }.items():
        assert found[name].low < value < found[name].high, name
    assert found["lambda_p"].high - found["lambda_p"].low < 1e-3 * LENGTH


@pytest.mark.slow
def test_a_second_ripple_has_a_period_of_its_own() -> None:
    outcome = fit_structure(log(second=1.0), structure("ripple+second-ripple"))
    found = {e.name: e for e in outcome.estimates}
    assert outcome.sound
    truth = {"lambda_p": LENGTH, "T_rc1": COSINE, "T_rs1": SINE}
    truth |= {"lambda_q": SECOND_LENGTH, "T_a1": SECOND_COSINE, "T_b1": SECOND_SINE}
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name


@pytest.mark.slow
def test_a_ripple_stands_beside_a_memory() -> None:
    outcome = fit_structure(log(), structure("dahl+ripple"))
    found = {e.name: e for e in outcome.estimates}
    assert len(found) == len(outcome.estimates)
    assert found["T_rs1"].low < SINE < found["T_rs1"].high
    assert rms(log().effort - outcome.model.predict(log())) < 0.03


def test_the_period_is_found_wherever_the_search_begins() -> None:
    data, own = log(), structure()
    told = next(
        s for s in shapes_told(data, own, reference_of(data, own.extras)) if s.name == "lambda_p"
    ).scanned
    scale = reference_of(data, own.extras).slip
    assert told[0] * scale < LENGTH < told[1] * scale
    assert told[1] < 1.1 * told[0]


@pytest.mark.parametrize(
    ("stages", "taken"), [("ripple", []), ("ripple+second-ripple", ["ripple"])]
)
def test_only_waves_that_hide_others_are_taken_away(
    monkeypatch: pytest.MonkeyPatch, stages: str, taken: list[str]
) -> None:
    """Each time 33 fits of waves are made; those behind the last stage are for nobody."""
    seen: list[str] = []
    own = Ripple.without
    monkeypatch.setattr(
        Ripple, "without", lambda stage, *given: (seen.append(stage.name), own(stage, *given))[1]
    )
    data = log(second=1.0)
    shapes = shapes_told(data, structure(stages), reference_of(data))
    assert seen == taken
    assert sum(
        shape.scanned != (1e-2, 10.0) for shape in shapes if shape.name.startswith("lambda")
    ) == 1 + len(taken)


def test_a_position_that_stands_still_tells_no_period() -> None:
    assert Ripple().usual(np.full(50, 0.3), np.sin(np.arange(50.0))) is None
    assert Ripple().usual(np.linspace(0.0, 1.0, 50), np.zeros(50)) is None


def test_waves_are_those_of_the_library() -> None:
    position = np.linspace(-40.0, 40.0, 1001)
    waves = stage_named("ripple-3")
    assert isinstance(waves, Ripple)
    for k, (cosine, sine) in enumerate(
        zip(*[iter(waves.outputs_at(position, 0.7))] * 2, strict=True), start=1
    ):
        np.testing.assert_allclose(cosine, np.cos(2.0 * np.pi * k * position / 0.7), atol=2e-8)
        np.testing.assert_allclose(sine, np.sin(2.0 * np.pi * k * position / 0.7), atol=2e-8)


@pytest.mark.slow
def test_the_ladder_takes_a_ripple_where_there_is_one() -> None:
    rung = grown(log(), structure("none"), (POSITION,))[-1]
    assert "ripple" in rung.structure.dynamics
    without = grown(log(ripple=0.0), structure("none"), (POSITION,))[-1]
    assert "ripple" not in without.structure.dynamics
    assert without.structure.extras == (POSITION,)


@pytest.mark.slow
def test_the_ladder_takes_a_second_ripple_where_there_is_one() -> None:
    among = ("ripple", "second-ripple")
    both = grown(log(second=1.0), structure("none"), (POSITION,), among)[-1]
    assert both.structure.dynamics == "ripple+second-ripple"
    first = grown(log(), structure("none"), (POSITION,), among)[-1]
    assert first.structure.dynamics == "ripple"


@pytest.mark.slow
def test_the_ladder_tries_no_second_ripple_alone() -> None:
    rungs = grown(log(second=1.0), structure("none"), (POSITION,), ("second-ripple",))
    assert [rung.structure.dynamics for rung in rungs] == [
        "none",
        "none",
    ]  # the position itself is taken


@pytest.mark.slow
def test_the_ladder_tries_no_ripple_without_a_position() -> None:
    data = replace(log(), extras={})
    assert all("ripple" not in rung.structure.dynamics for rung in grown(data, structure("none")))


@pytest.mark.slow
def test_a_model_is_itself_behind_its_file_and_asks_for_the_position() -> None:
    data = log()
    model = fit_structure(data, structure(), intervals=False).model
    again = model_from_dict(json.loads(json.dumps(model.to_dict())))
    np.testing.assert_array_equal(again.predict(data), model.predict(data))
    with pytest.raises(MappingError, match=r"'position' is not in these rows.*--position"):
        again.predict(replace(data, extras={}))


@pytest.mark.slow
def test_a_position_given_beside_the_slip_is_a_further_input(tmp_path: Path) -> None:
    data, path = log(), tmp_path / "joint.csv"
    columns = np.column_stack(
        [data.clock.time, data.extras[POSITION], data.elements[0].slip, data.effort]
    )
    lines = (",".join(f"{x:.9g}" for x in row) for row in columns)
    path.write_text("\n".join(["time [s],q [rad],dq [rad/s],tau [N*m]", *lines]), "utf-8")
    given = {"field": "none", "slip": "dq [rad/s]", "effort": "tau [N*m]"}
    without = build_dataset(read(path, {"time": "time [s]", "columns": given}))
    beside = build_dataset(
        read(path, {"time": "time [s]", "columns": {**given, "position": "q [rad]"}})
    )
    assert not without.extras
    np.testing.assert_allclose(beside.extras[POSITION], data.extras[POSITION], rtol=1e-8)
    np.testing.assert_array_equal(beside.elements[0].slip, without.elements[0].slip)
