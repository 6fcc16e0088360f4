"""Logs that went wrong: no field, a turned sign, a slip of one sign, rest at the end. SYNTHETIC, with known truths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

import erclutch
from erclutch.cli.ranking_table import held_out, verdict
from erclutch.errors import CheckError, RunError
from erclutch.fit.checks.data_check import check
from erclutch.fit.checks.effort_and_slip import SIGN
from erclutch.fit.choice.standing import explains, standing
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.fit.kinds import network_alone as module
from erclutch.fit.turned_sign import with_turned_fit
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.report.html.verdict_section import choice, next_steps
from erclutch.report.numbers.run_material import material_of
from erclutch.report.plots.model_plot import describe_model
from erclutch.report.printed_table import ranking_table
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording
from tests.support.command import good

Array = NDArray[np.float64]
PERIOD = 2e-3
TIME = np.arange(4000) * PERIOD
SPEED = 3.0 * np.sin(2 * np.pi * 0.7 * TIME) + 2.0 * np.sin(2 * np.pi * 1.9 * TIME)
FIELD = 0.5 + 0.5 * np.sign(np.sin(2 * np.pi * 0.31 * TIME))
MODELS = Settings(("bingham", "casson", "fnn-4"))


def dahl(speed: Array, travel: float) -> Array:
    state, states = 0.0, np.empty(speed.size)
    for k, w in enumerate(speed):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / travel)
        state = (1.0 - gone) * state + gone * np.sign(w)
        states[k] = state
    return states


def noise(size: float, seed: int = 0) -> Array:
    return size * np.random.default_rng(seed).standard_normal(TIME.size)


def logged(slip: Array, torque: Array, field: Array | None = None) -> Dataset:
    """A data set; without a field as a log that has none."""
    return build_dataset(recorded(slip, torque, field))


def recorded(slip: Array, torque: Array, field: Array | None = None) -> Recording:
    units = {"slip": "rad/s", "effort": "N*m", "field": "A"}
    signals = {
        "slip": slip,
        "effort": torque,
        "field": np.zeros(slip.size) if field is None else field,
    }
    return erclutch.recording_from_arrays(signals, units, time=TIME)


@pytest.fixture(scope="module")
def friction() -> tuple[Array, Array]:
    """Speed and torque of Dahl friction with a viscous part."""
    return SPEED, 1.5 * dahl(SPEED, 0.02) + 0.1 * SPEED + noise(0.02)


@pytest.fixture(scope="module")
def without_field(friction: tuple[Array, Array]) -> Comparison:
    return compare(logged(*friction), MODELS)


@pytest.mark.slow
def test_friction_without_a_field_is_recovered(without_field: Comparison) -> None:
    chosen = without_field.entry(without_field.recommended)
    found = {estimate.name: estimate.value for estimate in chosen.outcome.estimates}
    assert chosen.name.endswith("+dahl/field")
    assert found["T_z1"] == pytest.approx(1.5, rel=0.01)
    assert found["r_1"] == pytest.approx(0.02, rel=0.02)
    assert chosen.test.rmse.value == pytest.approx(0.02, rel=0.05)


@pytest.mark.slow
def test_networks_remember_without_a_field_too(without_field: Comparison) -> None:
    remembering = [e for e in without_field.entries if e.name.startswith("fnn-4+dahl")]
    corrected = [e for e in without_field.entries if "+fnn-4+dahl" in e.name]
    assert remembering
    assert corrected
    assert all(e.test.rmse.value < 0.025 for e in (*remembering, *corrected))


@pytest.mark.slow
def test_a_brake_at_one_speed_tells_how_its_torque_follows_the_field(tmp_path: Path) -> None:
    field = np.random.default_rng(2).choice([0.0, 0.3, 0.6, 1.0], TIME.size // 100).repeat(100)
    field[:100] = 0.0  # the oil is at rest before the first step
    followed = np.zeros(TIME.size)
    for row in range(1, TIME.size):
        followed[row] = followed[row - 1] + PERIOD / 0.04 * (field[row - 1] - followed[row - 1])
    speed = np.full(TIME.size, 10.0)
    torque = 0.3 + 4.0 * followed + noise(0.02)
    recording = recorded(speed, torque, field)
    result = compare(build_dataset(recording), Settings(("bingham", "casson")))
    chosen = result.entry(result.recommended)
    found = {estimate.name: estimate.value for estimate in chosen.outcome.estimates}
    assert chosen.test.rmse.value == pytest.approx(0.02, rel=0.06)
    assert found["tau"] == pytest.approx(0.04, rel=0.05)
    assert any("in all rows: no model knows" in str(finding) for finding in result.findings)
    material = material_of(read_run(write_run(tmp_path / "run", result, [recording])))
    (panel,) = describe_model(material).panels  # nothing is drawn over a slip that never changes
    assert panel.title == "recommended, over the field"


@pytest.mark.slow
def test_a_model_that_the_rows_cannot_make_ends_nothing(
    friction: tuple[Array, Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise CheckError("input z1 is constant at 0 over all training rows", remedy="Leave it out")

    monkeypatch.setattr(module, "fit_network", refuse)
    result = compare(logged(*friction), Settings(("bingham", "fnn-4"), lag="none"))
    left_out = [f for f in result.findings if f.subject == "left out"]
    assert {f.message.split()[0].partition("+")[0] for f in left_out} == {"fnn-4"}
    assert all("input z1 is constant" in f.message for f in left_out)
    assert result.entries
    with pytest.raises(CheckError, match="fnn-4: input z1 is constant"):
        compare(logged(*friction), Settings(("fnn-4",), lag="none"))


# --- signs ------------------------------------------------------------------------------------------------------------


def law(speed: Array, field: Array) -> Array:
    return (0.2 + field**1.5) * np.tanh(speed / 0.2) + 0.05 * speed


ONE_WAY = 5.0 + SPEED.clip(-4.0)
SIGNED = {
    "no field": (SPEED, 1.5 * dahl(SPEED, 0.02) + 0.1 * SPEED, None),
    "with a field": (SPEED, law(SPEED, FIELD), FIELD),
    "one way": (ONE_WAY, law(ONE_WAY, FIELD), FIELD),
    "one way without a field": (ONE_WAY, 1.0 + 0.05 * ONE_WAY, None),
    "a sensor's zero": (SPEED, law(SPEED, FIELD) + 3.0, FIELD),
}


@pytest.mark.parametrize("kind", SIGNED)
def test_a_turned_sign_is_told_in_every_case(kind: str) -> None:
    slip, torque, field = SIGNED[kind]
    for sign in (1.0, -1.0):
        data = logged(slip, sign * torque + noise(0.02), field)
        told = [f for f in check(data, np.arange(data.rows) >= 2800) if f.subject == SIGN]
        assert len(told) == (sign < 0)


@pytest.mark.slow
def test_the_fit_of_the_turned_log_stands_beside(friction: tuple[Array, Array]) -> None:
    slip, torque = friction
    # Of the log as it is no memory is asked; that of the turned log is looked for all the same.
    result = compare(logged(slip, -torque), Settings(("bingham",), lag="none"))
    (finding,) = [f for f in result.findings if f.subject == SIGN]
    assert "with the effort turned, bingham/constant+dahl" in finding.message
    assert finding.remedy.startswith("Turn a sign")
    assert verdict(result).startswith("No model is recommended before the sign is settled")


def test_a_sign_that_turned_fits_no_better_is_not_in_question() -> None:
    """A zero that is off opposes a motion one way too. Turned it was worse, and nothing could be used till then."""
    data = logged(ONE_WAY, -law(ONE_WAY, FIELD) + noise(0.02), FIELD)
    test = np.arange(data.rows) >= 2800
    (finding,) = [each for each in check(data, test) if each.subject == SIGN]
    near = SimpleNamespace(train_cost=1e-6, train_rows=2800, weights=None)
    far = SimpleNamespace(train_cost=2800.0, train_rows=2800, weights=None)
    settings = Settings(("bingham",), lag="none")
    kept = with_turned_fit(finding, data, test, settings, [cast(Any, far)])
    assert kept.subject == SIGN
    other = with_turned_fit(finding, data, test, settings, [cast(Any, near)])
    assert other.subject == "power"
    assert other.remedy.startswith("Check the zero")


@pytest.mark.slow
def test_noise_asks_for_no_sign() -> None:
    """Noise that happens to oppose the slip: with the sign turned it would be noise again."""
    torque = noise(0.3, 1)
    if float(np.dot(torque, SPEED)) > 0:
        torque = -torque
    result = compare(logged(SPEED, torque, FIELD), Settings(("bingham", "casson"), lag="none"))
    assert SIGN not in [finding.subject for finding in result.findings]
    assert verdict(result).startswith("No model is recommended: the nearest,")


# --- terms that cannot be told ----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_slip_of_one_sign_leaves_laws_eligible() -> None:
    result = compare(logged(ONE_WAY, law(ONE_WAY, FIELD) + noise(0.01), FIELD), MODELS)
    chosen = result.entry(result.recommended)
    assert chosen.outcome.weights == 0
    assert chosen.test.rmse.value == pytest.approx(0.01, rel=0.05)


@pytest.mark.slow
def test_a_term_that_cannot_be_told_is_taken_out() -> None:
    """A field that turns but never changes its strength: friction at zero field is the yield effort once more."""
    field = np.where(np.sin(40 * TIME) < 0, -1.0, 1.0)
    data = logged(SPEED, law(SPEED, np.ones(TIME.size)) + noise(0.01), field)
    (entry,) = compare(data, Settings(("bingham",), lag="none")).entries
    assert "T_f" not in [estimate.name for estimate in entry.outcome.estimates]
    said = "left out: friction, which these rows cannot tell from the law's own terms"
    assert said in entry.notes
    assert entry.test.rmse.value == pytest.approx(0.01, rel=0.1)


@pytest.mark.slow
def test_a_law_of_two_fields_stays_eligible_before_a_network_that_errs_more() -> None:
    """Friction, yield effort and exponent of two fields, SYNTHETIC: three numbers where the log tells two."""
    field = np.where(FIELD > 0.5, 2.0, 0.2)
    result = compare(
        logged(SPEED, law(SPEED, field) + noise(0.05), field),
        Settings(("bingham", "fnn-2"), lag="none"),
    )
    chosen = result.entry("bingham")
    assert result.recommended == "bingham"
    assert result.standing.word == "recommended"
    assert any(
        "left out: friction, which these rows cannot tell from the law's own terms" in note
        for note in chosen.notes
    )
    assert chosen.test.rmse.value < 0.06


# --- nothing to recommend ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def resting() -> tuple[Comparison, Recording]:
    """The last third at rest: the rows held out hold nothing but noise."""
    moving = TIME < 5.0
    torque = np.where(moving, law(SPEED, FIELD), 0.0) + noise(0.005)
    recording = recorded(np.where(moving, SPEED, 0.0), torque, FIELD)
    return compare(build_dataset(recording), Settings(("bingham", "casson"), lag="none")), recording


@pytest.mark.slow
def test_nothing_is_recommended_where_nothing_explains(
    resting: tuple[Comparison, Recording],
) -> None:
    assert verdict(resting[0]).startswith("No model is recommended: the nearest,")


@pytest.mark.slow
def test_stretches_like_the_whole_log_are_held_out_where_its_end_is_a_rest(
    resting: tuple[Comparison, Recording],
) -> None:
    result, recording = resting
    (told,) = [finding for finding in result.findings if finding.subject == "rest"]
    assert told.message.startswith("100 % of the rows held out are at rest, of the others 1")
    assert "--test stretches" in told.remedy
    fair = compare(
        build_dataset(recording), Settings(("bingham",), lag="none", test=("stretches",))
    )
    assert fair.standing.word == "recommended"
    assert fair.entry("bingham").test.share.value < 0.02
    assert not [finding for finding in fair.findings if finding.subject == "rest"]
    assert (
        held_out(fair) == "held out: 6 stretches that cover field, slip and motion as all rows do"
    )


@pytest.mark.slow
def test_a_run_without_a_recommendation_hands_out_no_model(
    resting: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    result, recording = resting
    run = read_run(write_run(tmp_path / "run", result, [recording]))
    with pytest.raises(
        RunError, match=r"this run recommends no model: the nearest, .* explains nothing"
    ):
        run.model()
    assert run.model(result.recommended).name
    assert not run.recommends(result.recommended)


def test_a_model_that_errs_by_little_on_few_rows_is_not_said_to_explain_nothing() -> None:
    figures = {"share": [0.42, 0.1, 1.2], "r2": [0.822, -0.467, 0.998]}
    chosen = {"sound": True, "test": figures}
    assert standing(chosen, set()).why_none == "cannot be told from a constant on the rows held out"


@pytest.mark.slow
def test_a_fit_to_all_rows_that_is_not_made_is_told(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    columns = np.column_stack([0.01 * np.arange(400), rng.standard_normal((400, 2))])
    np.savetxt(
        tmp_path / "log.csv",
        columns,
        delimiter=",",
        header="time [s],v [m/s],F [N]",
        comments="",
        fmt="%.9g",
    )
    words = (
        "--slip",
        "v",
        "--effort",
        "F",
        "--field",
        "none",
        "--models",
        "bingham",
        "--lag",
        "none",
    )
    said = good("fit", "log.csv", *words, "--final", "--out", "run", cwd=tmp_path)
    assert "none is fitted to all rows, as --final asks" in " ".join(said.split())


@pytest.mark.slow
def test_a_model_that_is_named_is_scored_all_the_same(
    resting: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    result, recording = resting
    run = write_run(tmp_path / "run", result, [recording], reading={})
    columns = np.column_stack(
        [recording.time, *(recording.signals[name] for name in ("field", "slip", "effort"))]
    )
    log = tmp_path / "log.csv"
    units = recording.units
    header = f"time [s],field [{units['field']}],slip [{units['slip']}],effort [{units['effort']}]"
    np.savetxt(log, columns, delimiter=",", header=header, comments="", fmt="%.9g")
    assert "Models of" in good("score", log, "--run", run, "--model", "m1")


@pytest.mark.slow
def test_whoever_shows_a_run_says_that_it_recommends_nothing(
    resting: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    """Terminal, table of a paper, report and notebook ask one place; so do `export`, `live` and `tune` (above)."""
    result, recording = resting
    run = read_run(write_run(tmp_path / "run", result, [recording]))
    material = material_of(run)
    assert result.standing == run.standing
    assert (result.standing.word, result.standing.why_none) == (
        "nearest",
        "explains nothing of the rows held out",
    )
    assert f"nearest {result.called(result.recommended)}" in repr(result)
    assert f"nearest {result.titles[result.recommended]}" in repr(run)
    assert "no model is recommended, nearest: " in ranking_table(run).caption
    assert choice(material).startswith("No model is recommended.")
    assert not any("to a controller" in step["text"] for step in next_steps(material))


@pytest.mark.slow
def test_a_run_whose_sign_is_open_hands_out_no_model(
    friction: tuple[Array, Array], tmp_path: Path
) -> None:
    slip, torque = friction
    recording = recorded(slip, -torque)
    result = compare(build_dataset(recording), Settings(("bingham",), lag="none"))
    run = read_run(write_run(tmp_path / "run", result, [recording]))
    assert run.standing.sign_open
    with pytest.raises(RunError, match="before the sign of the effort is settled") as caught:
        run.model()
    assert "Turn a sign" in str(caught.value.remedy)


@pytest.mark.parametrize(
    ("share", "low", "said"),
    [(0.1, 0.9, True), (0.96, 0.05, False), (0.5, -0.1, False), (None, 0.9, False)],
)
def test_what_explains(share: float | None, low: float, said: bool) -> None:
    assert explains(share, low) is said


@pytest.mark.slow
def test_a_network_beside_a_law_is_fitted_to_few_rows() -> None:
    t = np.arange(100) * 0.01
    slip = 2.0 * np.sin(9.0 * t)
    signals = {
        "field": np.floor(4.0 * t) % 3,
        "slip": slip,
        "effort": 3.0 * np.tanh(9.0 * slip) + slip,
    }
    log = erclutch.recording_from_arrays(
        signals, {"field": "A", "slip": "rad/s", "effort": "N*m"}, rate=100.0
    )
    comparison = compare(build_dataset(log), Settings(models=("bingham+fnn-2",), lag="none"))
    (entry,) = comparison.entries
    assert entry.outcome.train_rows == 70


@pytest.mark.slow
def test_a_column_that_helps_is_named_unless_it_was_made_of_the_effort() -> None:
    pressure = np.sin(2 * np.pi * 0.13 * TIME)  # nothing else tells of it
    oil = 25.0 + np.cos(2 * np.pi * 0.07 * TIME)  # °C
    torque = (
        FIELD * np.tanh(SPEED / 0.1)
        + 0.1 * SPEED
        + 0.05 * pressure  # no memory says as much, so that the search for one soon ends
        + 0.03 * (oil - 25.0)
        + noise(0.02)
    )
    data = logged(SPEED, torque, FIELD)
    made_of_the_effort = {"power": torque * SPEED / 745.7, "gauge": 3.0 - 2.0 * torque}
    spare = {"pressure": pressure, "oil": oil, **made_of_the_effort}
    data = replace(data, spare=spare, extra_units={"oil": "°C"})
    result = compare(data, Settings(("bingham",)))
    told = [finding for finding in result.findings if finding.subject == "spare column"]
    assert [each.message.partition(" would take ")[0] for each in told] == [
        "the column 'pressure', which no model has as an input,",
        "the column 'oil', which no model has as an input,",
    ]
    # The lines of the log say --temperature; the fit offered --input for it.
    assert [each.remedy.partition(",")[0] for each in told] == [
        'Fit with --input "pressure"',
        'Fit with --temperature "oil [°C]"',
    ]
