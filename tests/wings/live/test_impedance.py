"""Impedance of a pair and the wall of a brake: properties of the C, sample by sample, on the hand-written models."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import SettingError
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import CONFIG, EVENT_BITS, FRAME, SAMPLE, sealed
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform, config_of
from tests.support.examples import examples

FREE = {"observer": "none", "rise_rate": 1e6, "fall_rate": 1e6}
SPRING = LoopProgram(
    "spring", Mode.IMPEDANCE, Waveform.SINE, 0.3, 1.0, motor_torque=0.1, relative=True
)
PAIR = LoopSettings(programs=(SPRING,), stiffness=0.4, damping=0.01, least_slip=0.0, **FREE)
WALL = LoopProgram("wall", Mode.WALL, amplitude=1.0, relative=True)
BRAKE = LoopSettings(
    "single",
    programs=(WALL,),
    theta_glitch=0.0,
    stiffness=2.0,
    damping=0.01,
    least_slip=1.0,
    **FREE,
)


def readings(theta: Any, alpha: Any = 0.0, torque: Any = np.nan) -> Any:
    out = np.zeros(len(theta), SAMPLE)
    out["seq"] = np.arange(1, len(theta) + 1)
    out["time_ns"] = out["seq"] * np.uint64(1_000_000)
    out["theta"], out["alpha"], out["torque"] = theta, alpha, torque
    return out


def run(chosen: LoopSettings, model: Path, given: Any) -> Any:
    core, frames = Core(chosen, model), np.zeros(len(given), FRAME)
    for k in range(len(given)):
        frames[k] = core.step(given[k : k + 1], k)[1]
    return frames


def test_impedance_is_a_spring_and_a_damper_with_a_lead_on_the_spring(
    bingham: Path, as_filtered: Any, asks: Any
) -> None:
    """The field is the model's inverse of that torque: the observer knows the model alone, so nothing is added."""
    rows, lead = 900, 2e-3
    turned = 0.1 + 0.2 * np.sin(2.0 * np.pi * 2e-3 * np.arange(rows))
    frames = run(replace(PAIR, torque_lead=lead), bingham, readings(0.04 * np.arange(rows), turned))
    phase, model = 2.0 * np.pi * 1e-3 * np.arange(rows), CompiledModel(bingham)
    off = 0.1 + 0.3 * np.sin(phase) - turned  # relative: from where the output was
    rate = as_filtered(0.6 * np.pi * np.cos(phase)) - frames["alpha_dot"]
    wanted = 0.4 * off + 0.01 * rate + lead * 0.4 * rate
    field = frames["field1"] - frames["field2"]
    for k in range(100, rows):
        if abs(field[k]) > 0.02:  # a smaller field does not wake the other clutch
            assert asks(frames[k], model, wanted[k], 1e-2 * PAIR.torque_scale)
    assert np.ptp(np.sign(field)) == 2.0
    assert frames["reference"] == pytest.approx(0.1 + 0.3 * np.sin(phase))


FREE_LOAD = {"load_inertia": 1.6e-5, "load_friction": 3e-3, "load_band": 0.1}


@pytest.mark.parametrize(
    ("load", "swings_up"),
    [(FREE_LOAD, False), ({}, True)],
    ids=["free output", "a hand may be there"],
)
def test_an_output_at_rest_that_seems_to_move_asks_for_no_more_field_than_the_rest(
    load: dict[str, float], swings_up: bool, bingham: Path
) -> None:
    """Its encoder comes to read 0.5 rad/s, as a late one does. Where a hand may move it, the damper answers."""
    program = replace(SPRING, shape=Waveform.SQUARE, amplitude=0.1, frequency=0.1)
    chosen = replace(PAIR, programs=(program,), damping=0.05, **load)
    turned = -5e-4 * np.maximum(np.arange(500) - 480, 0)
    frames = run(chosen, bingham, readings(0.04 * np.arange(500), turned))
    field = np.abs(frames["field1"] - frames["field2"])
    usual = float(np.mean(field[400:480]))
    assert usual > 0.05
    most = 1.11 * usual + 0.005 * PAIR.field_limit
    assert bool(np.any(field[480:] > most)) is swings_up


def test_an_output_at_rest_that_is_told_to_go_elsewhere_is_asked_for_at_once(bingham: Path) -> None:
    program = replace(SPRING, shape=Waveform.SQUARE, amplitude=0.3, frequency=1.0, relative=False)
    chosen = replace(PAIR, programs=(program,), **FREE_LOAD)
    frames = run(chosen, bingham, readings(0.04 * np.arange(510), 0.29))
    field = np.abs(frames["field1"] - frames["field2"])
    assert np.max(field[400:499]) < 0.1 < np.max(field[500:505])


def in_and_out(rows: int = 1200) -> Any:
    """A hand that begins at 0.5 rad, goes to 2 rad and back; a wall 1 rad ahead stands at 1.5 rad."""
    return 0.5 + 0.75 * (1.0 - np.cos(2.0 * np.pi * np.arange(rows) / rows))


def test_a_wall_resists_the_way_in_and_nothing_else(brake: Path) -> None:
    at = in_and_out()
    frames = run(BRAKE, brake, readings(at))
    into = (at > 1.5) & (np.arange(len(at)) < 600)
    assert frames["reference"][into] == pytest.approx(
        2.0 * (at[into] - 1.5) + 0.01 * frames["theta_dot"][into]
    )
    assert np.all(frames["field1"][into][1:] > 0.0)
    back = (at < 2.0 - BRAKE.wall_play) & (np.arange(len(at)) > 600)
    for rest in (at < 1.5, back):
        assert np.all(frames["reference"][rest] == 0.0)
        assert np.all(frames["field1"][rest] == 0.0)
    assert np.all(frames["field2"] == 0.0)


@pytest.mark.slow
def test_a_hand_at_rest_is_held_and_one_that_pulls_is_let_go(brake: Path) -> None:
    at = in_and_out()
    at[600:] = 2.0 + 3e-3 * np.sin(
        np.arange(600)
    )  # it stands in the wall and trembles within the play
    held = run(BRAKE, brake, readings(at, torque=0.5))
    assert np.all(held["field1"][600:] > 0.5 * held["field1"][599])
    pulls = np.where(np.arange(1200) < 900, 0.5, -0.3)
    for observer, end in (("none", held["field1"][-1]), ("sensor", 0.0)):
        chosen = replace(BRAKE, observer=observer)
        frames = run(chosen, brake, readings(np.minimum(at, at[600]), torque=pulls))
        assert frames["field1"][-1] == pytest.approx(end, abs=1e-3), observer


def test_a_stiffness_that_gives_energy_away_is_refused(bingham: Path) -> None:
    """K <= 2 B / T, with a period of 1 ms."""
    config_of(replace(PAIR, stiffness=20.0, damping=0.01))
    with pytest.raises(SettingError, match="at most 2 damping / period, 20 N m/rad"):
        config_of(replace(PAIR, stiffness=20.1, damping=0.01))
    config = np.frombuffer(config_of(PAIR)[0], CONFIG).copy()[0]
    config["stiffness"] = 20.1
    import ctypes

    from erclutch.wings.live.c_build import core_library

    library = ctypes.CDLL(str(core_library()))
    library.erc_config_error.restype = ctypes.c_char_p
    assert b"2 damping / period" in library.erc_config_error(
        sealed(np.asarray(config)), ctypes.c_uint64(0)
    )


@pytest.mark.parametrize(
    "words", [{"stiffness": -1.0}, {"damping": np.nan}, {"wall_play": -0.1}, {"device": "single"}]
)
def test_settings_that_cannot_be(words: dict[str, Any]) -> None:
    with pytest.raises(SettingError):
        config_of(replace(PAIR, **words))
    with pytest.raises(SettingError):
        config_of(replace(BRAKE, device="coaxial"))


@pytest.mark.slow
@given(
    jumps=st.lists(st.floats(-40.0, 40.0), min_size=2, max_size=8),
    torque=st.lists(st.floats(width=32), min_size=1, max_size=8),
    stiffness=st.floats(0.0, 1e6),
    observer=st.sampled_from(["off", "none", "sensor", "motion"]),
)
@settings(max_examples=examples(25), deadline=None)
def test_however_a_hand_moves_one_field_within_limits_and_its_rate(
    bingham: Path,
    brake: Path,
    jumps: list[float],
    torque: list[float],
    stiffness: float,
    observer: Any,
) -> None:
    speed = np.repeat(jumps, 20)
    numbers: dict[str, Any] = {
        "stiffness": stiffness,
        "damping": stiffness,
        "observer": observer,
        "rise_rate": 20.0,
    }
    for chosen, model in ((PAIR, bingham), (BRAKE, brake)):
        given = readings(1e-3 * np.cumsum(speed), torque=np.resize(torque, speed.size))
        frames = run(replace(chosen, **numbers), model, given)
        assert np.all(np.minimum(frames["field1"], frames["field2"]) == 0.0)
        for field in (frames["field1"], frames["field2"]):
            assert np.all((field >= 0.0) & (field <= 0.5))
            assert np.all(np.diff(field) <= 0.02 + 1e-12)
        assert not np.any(frames["events"] & EVENT_BITS["command-not-finite"])
