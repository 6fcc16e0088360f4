"""Margins mean what they say: a loop with so much more gain or delay swings; and `erclutch tune` on the TWIN."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from erclutch.errors import SettingError
from erclutch.signals.speed import Derivative, live
from erclutch.wings.live import loop_margins as lm
from tests.support.command import run
from tests.support.examples import examples
from tests.support.warm_log import warm_run

PERIOD = 1e-3
SPEED = live(Derivative("kalman"), PERIOD)


def path(tau: float = 1e-3, delay: int = 1, late: int = 0) -> lm.TorquePath:
    """A first-order lag behind a dead time; the estimate may be later by some samples."""
    pulse = np.diff(1.0 - np.exp(-PERIOD * np.arange(16) / tau))
    pulse = np.append(np.zeros(delay), pulse / pulse.sum())
    return lm.TorquePath(PERIOD, pulse, np.append(np.zeros(late), pulse))


def more(one: lm.LinearLoop, gain: float = 1.0, samples: int = 0) -> bool:
    """Whether the loop with more gain and delay is stable."""
    over = np.append(np.zeros(samples), gain * one.over)
    return lm.margins_of(replace(one, over=over)).stable


@pytest.mark.slow
@given(
    tau=st.floats(2e-4, 5e-3),
    delay=st.integers(1, 4),
    bandwidth=st.floats(2.0, 9.0),
    integral=st.sampled_from([0.0, 5.0]),
)
@example(tau=0.003729227163499043, delay=1, bandwidth=5.875, integral=5.0)
@settings(max_examples=examples(6), deadline=None)
def test_a_loop_bears_its_margins_and_no_more(
    tau: float, delay: int, bandwidth: float, integral: float
) -> None:
    for loop in (
        lm.motion_loop(path(tau, delay), bandwidth, integral, SPEED),
        lm.torque_loop(path(tau, delay), 2.0 * bandwidth, integral, 0.0),
    ):
        found = lm.margins_of(loop)
        assert found.stable
        assert more(loop, 0.98 * found.gain)
        assert not more(loop, 1.002 * found.gain)  # with still more gain it may be stable once more
        assert more(loop, 1.02 * found.least or 1e-3)
        assert not found.least or not more(loop, 0.98 * found.least)
        assert more(loop, samples=math.floor(found.delay / PERIOD * 0.99))
        assert not more(loop, samples=math.ceil(found.delay / PERIOD * 1.01))
        assert found.gain >= found.sensitivity / (found.sensitivity - 1.0) - 1e-6
        assert found.phase >= math.degrees(2.0 * math.asin(0.5 / found.sensitivity)) - 0.1


def test_the_step_is_that_of_the_loop_sample_by_sample() -> None:
    """Computed torque once more, as the C does it: a filter of the speed, a spring, a damper, an integral, a mass."""
    own, stiff, integral = path(), 2.0 * np.pi * 8.0, 6.0
    told = lm.motion_loop(own, 8.0, integral, SPEED).step()
    speed = live(Derivative("kalman"), PERIOD)
    speed.position = 0.0
    asked, torque, at, rate, sums = np.zeros(500), np.zeros(501), 0.0, 0.0, 0.0
    for k in range(500):
        torque[k] = sum(
            own.pulse[j] * asked[k - j] for j in range(1, min(k, own.pulse.size - 1) + 1)
        )
        if k:  # torque turns linearly between samples
            at += PERIOD * rate + PERIOD**2 * (torque[k - 1] / 3.0 + torque[k] / 6.0)
            rate += 0.5 * PERIOD * (torque[k - 1] + torque[k])
        assert told[k] == pytest.approx(at, abs=1e-9)
        asked[k] = stiff * (-2.0 * speed.step(at) + stiff * (1.0 - at + sums))
        sums += integral * PERIOD * (1.0 - at)


def test_with_an_estimate_that_is_right_the_observer_takes_away_what_its_filter_passes() -> None:
    """1 / (1 + L) = 1 - F P: the torque beyond the model, less what the filter and the device make of it."""
    own = path()
    f, loop = lm.torque_loop(own, 30.0, 0.0, 0.0).response()
    q, share = np.exp(-2j * np.pi * f * PERIOD), 1.0 - math.exp(-2.0 * np.pi * 30.0 * PERIOD)
    passed = share / (1.0 - (1.0 - share) * q) * np.polyval(own.pulse[::-1], q)
    assert np.max(np.abs(1.0 / (1.0 + loop) - (1.0 - passed))) < 1e-6


@pytest.mark.slow
def test_the_largest_bandwidth_is_where_the_sensitivity_is_two() -> None:
    def loop(bandwidth: float) -> lm.LinearLoop:
        return lm.motion_loop(path(), bandwidth, bandwidth, SPEED)

    largest = lm.largest_bandwidth(loop, 100.0)
    assert lm.margins_of(loop(largest)).sensitivity == pytest.approx(2.0, abs=0.01)
    assert lm.largest_bandwidth(loop, 5.0) == pytest.approx(5.0)
    slow = lm.motion_loop(path(delay=100), 20.0, 0.0, SPEED)
    assert lm.largest_bandwidth(lambda _: slow, 100.0) == 0.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("stiff = 1", "stiff = 1"),
        ("damping = true", "damping = True"),
        ("= 3", "cannot be read"),
        ("track_bandwidth = 5", "--track-bandwidth without the inertia"),
        ("track_bandwidth = 5\noutput_inertia = 1e-5", "--track-bandwidth without a model"),
    ],
)
def test_a_settings_file_is_not_believed(text: str, said: str, tmp_path: Path) -> None:
    from erclutch.cli import app

    (tmp_path / "control.toml").write_text(text, encoding="utf-8")
    words = ["live", "--headless", "--no-model", "--tuned", str(tmp_path / "control.toml")]
    with pytest.raises(SettingError) as caught:
        app(words, exit_on_error=False)
    assert said in str(caught.value)


@pytest.mark.slow
def test_a_bandwidth_that_nobody_asked_for_fits_a_slow_device() -> None:
    """A brake that follows by 60 ms bears no 10 Hz: the command refused a bandwidth that it had chosen itself."""
    from erclutch.wings.live.commands.tune import tuned_loops
    from erclutch.wings.rig.twin.parameters import default_rig

    slow = path(0.02, delay=40)
    torque, motion = tuned_loops(slow, default_rig(), None, None)
    for loop, usual in ((torque, 20.0), (motion, 10.0)):
        assert loop.bandwidth == min(usual, 0.7 * loop.largest)
        assert loop.margins.stable
    assert motion.bandwidth < 10.0
    with pytest.raises(SettingError, match="--bandwidth 10 Hz: the lag of the torque allows"):
        tuned_loops(slow, default_rig(), 10.0, None)


# --- on the TWIN ------------------------------------------------------------------------------------------------------


def _erclutch(*words: str) -> Any:
    from erclutch.cli import app

    return app(list(words), exit_on_error=False)


@pytest.mark.slow
def test_what_tune_predicts_is_what_the_twin_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """TWIN: overshoot, rise, and the gain at which it swings; a model of its log, never its own parameters."""
    from erclutch.runs.run_folder import read_run
    from erclutch.wings.live.accelerated import AcceleratedRun
    from erclutch.wings.live.commands.tune import torque_path, tuned_loops
    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.live.offered_programs import rig_settings
    from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
    from erclutch.wings.rig.twin.parameters import default_rig

    monkeypatch.chdir(tmp_path)
    _erclutch("simulate", "training", "--seconds", "20", "--out", "log.csv")
    fit = ("--models", "bingham", "--lag", "rise-fall", "--derivative", "kalman", "--out", "run")
    _erclutch("fit", "log.csv", "--device", "coaxial", *fit)
    _erclutch("tune", "run", "--bandwidth", "10", "--as", "svg", "pdf", "--out", "tuning")
    assert {file.name for file in (tmp_path / "tuning").iterdir()} == {
        *("control.toml", "loops.csv", "loops.pdf", "loops.svg")
    }
    for option in ("--bandwidth", "--torque-bandwidth"):
        with pytest.raises(SettingError, match="allows"):
            _erclutch("tune", "run", option, "150", "--force")
    gains = tomllib.loads((tmp_path / "tuning" / "control.toml").read_text())
    rig, run = default_rig(), read_run("run")
    motion = tuned_loops(torque_path(run.model())[0], rig, 10.0, 20.0)[1]
    library = live_model(next((tmp_path / "run" / "models").glob("*.json")), "coaxial").library

    def twin(height: float, gain: float = 1.0) -> Any:
        step = LoopProgram(
            "s", Mode.TRACK, Waveform.SQUARE, height, 0.25, motor_torque=0.2, relative=True
        )
        changed = {**gains, "output_inertia": gain * gains["output_inertia"], "observer": "none"}
        return AcceleratedRun(
            rig_settings(rig, [step], **changed), library, rig, seed=3, speed=150.0
        ).frames(4000)[0]

    frames, told = twin(0.5), motion.loop.step()
    seen = (frames["alpha"][2000:3000] - frames["alpha"][1999]) / -1.0
    assert float(seen.max()) == pytest.approx(float(told.max()), abs=0.03)
    rises = [int(np.argmax(y > 0.9) - np.argmax(y > 0.1)) for y in (seen, told)]
    assert rises[0] == pytest.approx(rises[1], rel=0.15)
    still, swings = (
        float(np.std(twin(0.05, k * motion.margins.gain)["alpha_dot"][3000:])) for k in (0.8, 1.5)
    )
    assert still < 0.25  # rad/s: the encoder's last count
    assert swings > 2.0 * still


@pytest.mark.slow
def test_tune_takes_the_best_model_that_will_do_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = warm_run(tmp_path)
    monkeypatch.chdir(tmp_path)
    _erclutch("tune", str(folder), "--bandwidth", "5", "--as", "svg")
    said = " ".join(capsys.readouterr().out.split())
    assert (
        "which has further inputs, and the loop has fields and speeds; bingham+lag is its best that will do"
        in said
    )
    assert "(default rig, not yours)" in said
    with pytest.raises(SettingError, match="Name a model without them with --model"):
        _erclutch("tune", str(folder), "--model", "bingham+lag+softening", "--force")
    unfit = ("--models", "bingham/constant", "--lag", "none", "--field", "none", "--out", "still")
    _erclutch("fit", "log.csv", "--slip", "w", "--effort", "M", *unfit)
    with pytest.raises(SettingError, match="was fitted without a field"):
        _erclutch("tune", "still", "--model", "m1", "--force")


def test_tune_takes_the_only_run_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "first").mkdir()
    (tmp_path / "first" / "run.json").write_text("{}", encoding="utf-8")
    assert run("tune", cwd=tmp_path).error.startswith("run: first, the only run here\n")
