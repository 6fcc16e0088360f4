"""The experiments of sections IV-B to V with the live loop: what runs, what it gives, and that online is offline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import SettingError
from erclutch.export.exported_step import LIMITED, OUTSIDE
from erclutch.models.load import load_model
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import SAMPLE
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform
from erclutch.wings.paper import hand_experiments, torque_control
from erclutch.wings.paper.control_figure import describe_control
from erclutch.wings.paper.hand_experiments import (
    CALM,
    STIFFNESS,
    WALLS,
    describe_impedance,
    describe_wall,
    hand_points,
    hand_runs,
)
from erclutch.wings.paper.online import EXPERIMENTS, lines, run, tracking_error, trial
from erclutch.wings.paper.online_figures import FIGURE_OF, describe_online
from erclutch.wings.paper.torque_control import INVERSES, KNOWS, WITHHELD, control_runs, kept_runs
from erclutch.wings.rig.interface import RigCommand
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.twin import Twin

pytestmark = pytest.mark.slow
MODEL = Path(__file__).resolve().parents[1] / "live" / "model.json"


@pytest.fixture(scope="module")
def ready() -> Any:
    return live_model(MODEL, "coaxial"), [load_model(MODEL)]


@pytest.fixture(scope="module")
def fitted() -> dict[int, Any]:
    """By seed, the models of the TWIN as it is: what the experiments of torque and of impedance begin with."""
    return {}


@pytest.fixture
def fitted_once(fitted: dict[int, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The second experiment takes the models that the first has fitted to the same log."""
    fit = torque_control.fitted_models

    def once(rig: RigParameters, seed: int, folder: Path) -> Any:
        assert rig == default_rig()
        if seed not in fitted:
            fitted[seed] = fit(rig, seed, folder)
        return fitted[seed]

    for place in (torque_control, hand_experiments):
        monkeypatch.setattr(place, "fitted_models", once)


@pytest.mark.parametrize("name", list(EXPERIMENTS))
def test_online_is_offline(name: str, ready: Any, tmp_path: Path) -> None:
    model, saved = ready
    traces = run(name, model, saved, default_rig(), seconds=4.0, seed=1)
    assert len(traces) == (2 if name == "tracking" else 1)
    for trace in traces:
        assert trace.compiled_off == 0.0
        assert trace.numpy_off == 0.0
        frames = trace.frames
        # Outside its range the compiled model holds its inputs, NumPy does not: how much is left to compare.
        inside = frames["flags"] & (OUTSIDE | LIMITED) == 0
        assert inside.mean() > (0.5 if name == "zero-field" else 0.95)
        assert len(frames) == 4000 // len(traces)
        assert (np.minimum(frames["field1"], frames["field2"]) == 0.0).all()
        assert np.isfinite(frames["estimate"]).all()
        found = lines(trace)[0]
        assert found.rows == len(frames)
        assert found.mse == pytest.approx(
            float(np.mean((frames["estimate"] - frames["torque"]) ** 2))
        )
        assert (frames["alpha"] == frames["alpha"][0]).all() == (name == "zero-motion")
        assert (frames["field1"] + frames["field2"] == 0.0).all() == (name == "zero-field")
        assert (trace.other_alpha is not None) == (name == "encoders")
    plot = describe_online(traces[0], FIGURE_OF[name])
    assert plot.title.startswith("TWIN, ")
    assert [panel.y.title[:4].strip() for panel in plot.panels][:2] == ["(a)", "(a)"]
    for file in save_plot(plot, tmp_path / "figure.png"):
        assert file.stat().st_size > 1000


def test_tracking_follows(ready: Any) -> None:
    model, saved = ready
    slow, fast = run("tracking", model, saved, default_rig(), seconds=20.0)
    assert tracking_error(slow) < 1.5  # of an amplitude of 12.6 rad
    assert tracking_error(fast) < 2.0
    assert fast.frames["seq"][0] == 10_000
    assert trial(slow, 0) == trial(slow, -1) == slice(0, 10_000)


@pytest.mark.timed
def test_real_time_is_the_same_loop(ready: Any) -> None:
    model, saved = ready
    trace = run("sine", model, saved, default_rig(), seconds=3.0, real_time=True)[0]
    assert trace.compiled_off == 0.0
    assert len(trace.frames) == 3000
    assert trace.frames["lateness_ns"].max() > 0


def test_accelerated_is_the_twin_step_by_step() -> None:
    program = LoopProgram("sine", Mode.TRACK, Waveform.SINE, 6.0, 1.0, motor_torque=0.1)
    settings, rig = LoopSettings(programs=(program,)), default_rig()
    frames, _ = AcceleratedRun(settings, None, rig, seed=3, speed=40.0).frames(300)
    twin, core, sample = Twin(rig, seed=3, speed=40.0), Core(settings), np.zeros(1, SAMPLE)
    for k in range(300):
        seen = twin.sense()
        alpha = seen.alpha_raw * (2.0 * np.pi / rig.value("screw.lead"))
        sample[0] = (k + 1, (k + 1) * 10**6, seen.theta, alpha, frames["torque"][k], 0, 0)
        command, frame = core.step(sample, k)
        for name in ("theta", "alpha", "theta_dot", "alpha_dot", "field1", "field2"):
            assert frame[name] == pytest.approx(frames[name][k], abs=1e-12), (k, name)
        twin.command(RigCommand(*(float(command[n]) for n in ("field1", "field2", "motor_torque"))))
        twin.step()


@pytest.mark.parametrize(
    "words",
    [
        {"name": "nothing"},
        {"name": "sine", "seconds": 0.1},
        {"name": "encoders", "real_time": True},
    ],
)
def test_experiments_that_cannot_be(words: dict[str, Any], ready: Any) -> None:
    model, saved = ready
    name = words.pop("name")
    with pytest.raises(SettingError):
        run(name, model, saved, default_rig(), **words)


def test_all_in_real_time_leaves_out_what_cannot(
    monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    from erclutch.cli import app
    from erclutch.wings.paper.commands import experiment

    asked: list[Any] = []
    monkeypatch.setattr(experiment, "run_online", lambda *given: asked.append(given))
    app(["experiment", "all", "--real-time"], exit_on_error=False)
    assert asked[0][0] == [n for n in EXPERIMENTS if n != "encoders"]
    assert "left out, for it does not run in real time: encoders" in capsys.readouterr().out


def test_kept_runs_of_other_logs_do_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = default_rig()
    assert kept_runs(tmp_path, rig).get("a run", lambda: 1) == 1
    assert kept_runs(tmp_path, rig).others == 0
    monkeypatch.setattr("erclutch.wings.paper.torque_control._LOG_ROWS", 60_000)
    assert kept_runs(tmp_path, rig).others == 1


@pytest.mark.usefixtures("fitted_once")
def test_torque_control_wins_where_it_should(tmp_path: Path) -> None:
    """One seed: stages beat the inverse, a sensor makes up for what the models do not know."""
    rig, told = default_rig(), []
    runs = control_runs(
        1, rig, kept_runs(tmp_path, rig), lambda done, total, what: told.append(what)
    )
    figures = {(run.model, run.knows): run.figures for run in runs}
    assert len(figures) == len(told) == len(INVERSES) * len(KNOWS)
    bingham = figures["Bingham", "inverse alone"]["chirp"]
    for model in INVERSES:
        found = {knows: figures[model, knows] for knows in KNOWS}
        assert found["stages"]["chirp"] < found["inverse alone"]["chirp"]
        assert found["stages, sensor"]["chirp"] < 0.5 * bingham
        for knows in ("stages, sensor", "stages, motion"):
            assert all(found[knows][name] < 0.04 for name in ("chirp", *WITHHELD)), knows
        assert all(found[knows]["locked"] for knows in KNOWS if knows != "inverse alone")
    assert len(describe_control(runs).panels) == len(INVERSES)
    again = control_runs(
        1, rig, kept_runs(tmp_path, rig), lambda done, total, what: None
    )  # nothing is run again
    assert again == runs


@pytest.mark.usefixtures("fitted_once")
def test_a_hand_feels_what_was_asked_and_a_brake_lets_it_go(tmp_path: Path) -> None:
    """One seed, TWIN: stiffness with a sensor, damping that stays above zero, a calm wall, a pull that is let go."""
    rig = default_rig()
    for name in ("impedance", "wall"):
        runs = hand_runs(
            name, 1, rig, hand_points(tmp_path, rig, name), lambda done, total, what: None
        )
        figures = {(run.model, run.knows): run.figures for run in runs}
        if name == "impedance":
            felt = figures["Bingham", "stages, sensor"]
            assert felt["stiffness"][:4] == pytest.approx([STIFFNESS] * 4, rel=0.03)
            assert min(felt["damping"]) > 0.0
            assert len(describe_impedance(runs).panels) == 4
            continue
        for own in figures.values():
            assert own["rise"] < 0.003
            assert max(own["swing"]) < CALM
            assert own["deepest"][0] == pytest.approx(0.15 / WALLS[0], rel=0.15)
            assert own["deepest"] == sorted(own["deepest"], reverse=True)
        assert (
            figures["Bingham", "stages, sensor"]["pull"]
            < 0.3 * figures["Bingham", "stages"]["pull"]
        )
        assert describe_wall(runs).panels
        again = hand_runs(
            name, 1, rig, hand_points(tmp_path, rig, name), lambda done, total, what: None
        )
        assert again == runs  # nothing is run again
