"""A sensor that is wrong drives no field: on the TWIN as `studies/sensor_faults.py` tells, and sample by sample."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.signals.device import DeviceName
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.offered_programs import rig_settings, shaft_angle, standard_programs
from erclutch.wings.live.orders import Order
from erclutch.wings.live.ring import State, doubt_in_words
from erclutch.wings.live.sensor_limits import free_drive, free_output, sensor_limits, torque_limits
from erclutch.wings.live.session import LiveModel
from erclutch.wings.live.settings import (
    REST,
    LoopProgram,
    LoopSettings,
    Mode,
    ObserverName,
    Waveform,
)
from erclutch.wings.rig.twin.parameters import default_rig
from tests.support import sensor_faults as study

RIG = default_rig()
#: Torques that no device gives; each was answered with the full field.
IMPOSSIBLE = ("1e30", "100", "5", "-5")
SENSOR = replace(
    LoopSettings(
        observer="sensor",
        least_slip=1.0,
        rise_rate=1e6,
        fall_rate=1e6,
        programs=(
            LoopProgram("torque", Mode.TORQUE, Waveform.SINE, 0.1, 2.0, 0.15, motor_torque=0.1),
        ),
    ),
    **torque_limits(effort=0.4, band=5e-3, period=1e-3),
)


@pytest.fixture(scope="module")
def pair() -> LiveModel:
    """Bingham's law, fitted to the TWIN's pair."""
    return study.model_of(RIG, "bingham", "coaxial")


#: Frames of the loop without a fault, by control and seed: many faults are judged beside the same ones.
_HEALTHY: dict[tuple[str, int], Any] = {}


def found(pair: LiveModel, control: str, sensor: str, kind: str, seed: int = 0) -> study.FaultRun:
    settings = study.settings_of(control, pair, RIG)
    if (control, seed) not in _HEALTHY:
        _HEALTHY[control, seed] = study.frames_of(settings, pair.library, RIG, seed)
    healthy = _HEALTHY[control, seed]
    begin = int(np.random.default_rng(seed).choice(study.under_field(healthy)))
    return study.judged(
        healthy, study.frames_of(settings, pair.library, RIG, seed, (sensor, kind, begin)), begin
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*IMPOSSIBLE, "0"])
def test_a_torque_that_cannot_be_drives_no_field(kind: str, pair: LiveModel) -> None:
    fault = found(pair, "torque", "torque", kind)
    assert fault.held, fault
    assert "torque-doubted" in fault.said


@pytest.mark.slow
@pytest.mark.parametrize("sensor", ["theta", "alpha"])
@pytest.mark.parametrize("kind", ["1e30", "0", "stuck", "reversed", "late", "doubled"])
def test_an_angle_that_cannot_be_drives_no_field(sensor: str, kind: str, pair: LiveModel) -> None:
    fault = found(pair, "computed torque", sensor, kind)
    assert fault.held, fault
    assert f"{sensor}-doubted" in fault.said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("control", "sensor", "kind"),
    [
        ("torque", "torque", "reversed"),
        ("torque", "torque", "doubled"),
        ("computed torque", "torque", "reversed"),
        ("equation 23", "alpha", "doubled"),
        ("impedance", "torque", "doubled"),
    ],
)
def test_meter_and_encoder_tell_of_each_other(
    control: str, sensor: str, kind: str, pair: LiveModel
) -> None:
    fault = found(pair, control, sensor, kind, seed=2)
    assert fault.outcome in ("held", "safe"), fault
    assert fault.zero > 0


def of_attack(pair: LiveModel, control: str, sensor: str, kind: str, seed: int) -> study.FaultRun:
    """What a fault came to that begins where `make attack` lets it begin."""
    settings = study.settings_of(control, pair, RIG)
    healthy = study.frames_of(settings, pair.library, RIG, seed)
    begin = int(np.random.default_rng((7, seed)).choice(study.under_field(healthy)))
    return study.judged(
        healthy, study.frames_of(settings, pair.library, RIG, seed, (sensor, kind, begin)), begin
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stuck", "late"])
@pytest.mark.parametrize("seed", [2, 4])
def test_no_command_is_held_once_nothing_takes_a_doubt_back(
    kind: str, seed: int, pair: LiveModel
) -> None:
    """The output turns round, control asks for less, and the field from before was held: a tenth too high for 7 ms."""
    fault = of_attack(pair, "computed torque", "alpha", kind, seed)
    assert fault.held, fault


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 6])
def test_an_output_at_rest_is_not_swung_up_by_an_encoder_that_is_late(
    seed: int, pair: LiveModel
) -> None:
    """Spring and damper swung it up: the field was more than a tenth above that of health for 16 and 27 ms."""
    fault = found(pair, "impedance", "alpha", "late", seed)
    assert fault.above == 0, fault
    assert fault.zero > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("control", "seed"), [("equation 23", 5), ("torque", 4), ("computed torque", 4)]
)
def test_a_meter_that_steps_while_nothing_moves_its_torque_is_told_by_a_few_readings(
    control: str, seed: int, pair: LiveModel
) -> None:
    """Beside motion a doubled torque that is hardly more than dry friction took 24 to 28 ms."""
    fault = of_attack(pair, control, "torque", "doubled", seed)
    assert fault.held, fault
    assert fault.zero <= 10
    assert "torque-doubted" in fault.said


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["1e30", "stuck", "0", "late"])
def test_a_meter_that_cannot_be_stops_a_program_that_does_not_ask_for_it(
    kind: str, pair: LiveModel
) -> None:
    fault = found(pair, "equation 23", "torque", kind)
    assert fault.held, fault
    assert "torque-doubted" in fault.said


@pytest.mark.slow
def test_with_no_meter_needed_a_program_that_asks_for_none_goes_on(pair: LiveModel) -> None:
    settings = study.settings_of("equation 23", pair, RIG)
    goes_on = replace(settings, meter_needed=0.0)
    healthy = study.frames_of(settings, pair.library, RIG, 0)
    begin = int(study.under_field(healthy)[0])
    faulty = study.frames_of(goes_on, pair.library, RIG, 0, ("torque", "1e30", begin))
    assert said(faulty, "torque-doubted", "out-of-range").size > 500
    for name in ("field1", "field2"):
        assert np.array_equal(healthy[name], faulty[name])


@pytest.mark.parametrize(("needed", "stops"), [(0.0, False), (1.0, False), (2.0, True)])
def test_a_meter_that_only_disagrees_with_the_model_stops_a_program_where_the_meter_is_needed(
    needed: float, stops: bool, bingham: Path
) -> None:
    """The model may be the wrong party. So without --meter-needed its word alone stops nothing."""
    fields = LoopProgram("fields", Mode.FIELDS, amplitude=0.3, motor_torque=0.1)
    core = Core(replace(SENSOR, observer="none", meter_needed=needed, programs=(fields,)), bingham)
    frames = closed(core, 900, lambda k, torque: torque - 0.3 if k >= 600 else torque)
    assert said(frames, "torque-doubted", "disagrees")[0] == 600
    assert bool(said(frames, "trip").size) == stops
    assert np.all(frames["field1"][620:] == 0.0) == stops


@pytest.mark.parametrize("needed", [1.0, 2.0])
def test_a_rig_without_a_meter_that_sends_zero_is_stopped_only_where_the_meter_is_needed(
    needed: float, bingham: Path
) -> None:
    wave = LoopProgram(
        "fields", Mode.FIELDS, Waveform.SINE, amplitude=0.1, frequency=2.0, offset=0.3
    )
    core = Core(replace(SENSOR, observer="none", meter_needed=needed, programs=(wave,)), bingham)
    frames = closed(core, 900, lambda k, torque: 0.0)
    assert said(frames, "torque-doubted", "stuck").size > 100
    assert bool(said(frames, "trip").size) == (needed > 1.0)


@pytest.mark.slow
def test_a_coarse_meter_that_shows_a_count_late_is_not_stuck(bingham: Path) -> None:
    """Counts of 20 mN m: the model's torque moves by 2 % of the largest effort, and no count shows it."""
    wave = LoopProgram(
        "fields", Mode.FIELDS, Waveform.SINE, amplitude=0.05, frequency=2.0, offset=0.3
    )
    core = Core(replace(SENSOR, observer="none", meter_needed=1.0, programs=(wave,)), bingham)
    frames = closed(core, 2000, lambda k, torque: 0.02 * round(torque / 0.02))
    assert np.ptp(frames["estimate"][600:]) > SENSOR.torque_still
    assert np.unique(frames["torque"][600:]).size > 1
    assert said(frames, "torque-doubted", "stuck").size == 0


@pytest.mark.slow
def test_a_small_torque_whose_sign_turns_is_told_by_the_last_readings(bingham: Path) -> None:
    """It is within the band of the model and within dry friction; impedance went on for half a second."""
    small = LoopProgram(
        "torque", Mode.TORQUE, Waveform.SINE, amplitude=0.004, frequency=25.0, motor_torque=0.1
    )
    settings = replace(SENSOR, programs=(small,))
    frames = closed(Core(settings, bingham), 700, lambda k, torque: -torque if k >= 600 else torque)
    told = said(frames, "torque-doubted", "disagrees")
    assert 604 <= told[0] <= 610
    assert np.all(np.abs(frames["field1"] - frames["field2"])[620:] == 0.0)
    healthy = closed(Core(settings, bingham), 3000)
    assert said(healthy, "torque-doubted").size == 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_under_impedance_a_meter_whose_sign_turns_is_held(seed: int, pair: LiveModel) -> None:
    fault = found(pair, "impedance", "torque", "reversed", seed)
    assert fault.held, fault


@pytest.mark.slow
@pytest.mark.parametrize(
    ("control", "kind", "begin"),
    [("impedance", "doubled", 1000), ("computed torque", "reversed", 1548)],
    ids=["at rest", "while torque and motion nearly disagree"],
)
def test_a_small_torque_that_is_wrong_within_dry_friction_is_held(
    control: str, kind: str, begin: int, pair: LiveModel
) -> None:
    """The first came to zero after 461 ms, the second after 34 ms.

    The output rests so near its place that the torque is 0.5 mN m: where its double is within the noise, nothing tells.
    """
    settings = study.settings_of(control, pair, RIG)
    healthy = study.frames_of(settings, pair.library, RIG, 0)
    faulty = study.frames_of(settings, pair.library, RIG, 0, ("torque", kind, begin))
    fault = study.judged(healthy, faulty, begin)
    assert fault.held, fault
    assert said(healthy, "torque-doubted").size == 0


def held_output(**changes: Any) -> LoopSettings:
    """A loop whose output rests within its dry friction of 3 mN m, while the field swings about 0.033."""
    wave = LoopProgram(
        "fields", Mode.FIELDS, Waveform.SINE, amplitude=0.003, frequency=40.0, offset=0.033
    )
    load = {"load_inertia": 1.6e-5, "load_friction": 0.003, "load_drag": 1e-5, "load_band": 0.002}
    return replace(SENSOR, meter_needed=2.0, programs=(wave,), **{**load, **changes})


@pytest.mark.slow
def test_at_rest_the_meter_keeps_its_usual_distance_from_the_model(bingham: Path) -> None:
    def reads(change: Any, **changes: Any) -> Any:
        return said(
            closed(Core(held_output(**changes), bingham), 1200, change),
            "torque-doubted",
            "disagrees",
        )

    def more(by: float) -> Any:
        return lambda k, torque: torque + by if k >= 600 else torque

    assert 603 <= reads(more(1e-3))[0] <= 607
    assert 603 <= reads(lambda k, torque: torque * 1.5 if k >= 600 else torque)[0] <= 609
    for change in (
        None,
        more(4e-4),  # twice its noise
        lambda k, torque: torque + (3e-3 if k == 600 else 0.0),  # a spike
        lambda k, torque: torque + 1e-6 * k,  # warmth
        lambda k, torque: 1e-3 * round(torque / 1e-3),  # a coarse meter
    ):
        assert reads(change).size == 0
    assert reads(more(1e-3), load_inertia=0.0).size == 0  # a hand that moves may hold the output


@pytest.mark.slow
def test_an_output_that_a_hand_holds_is_no_fault_where_nothing_is_said_of_its_load(
    pair: LiveModel,
) -> None:
    settings = replace(study.settings_of("impedance", pair, RIG), load_inertia=0.0)
    frames = AcceleratedRun(settings, pair.library, RIG, seed=0, hand=np.zeros(1)).frames(2000)[0]
    assert said(frames, "alpha-doubted").size == 0
    assert said(frames, "trip").size == 0


def test_a_sensor_adds_no_more_than_a_tenth_at_once(bingham: Path) -> None:
    """The meter reads less and less than the model says, slowly enough to be believed: the device may be weaker."""
    fields: list[float] = []
    for observer in ("none", "sensor"):
        still = LoopProgram("torque", Mode.TORQUE, amplitude=0.15, motor_torque=0.1)
        core = Core(
            replace(SENSOR, observer=observer, torque_scale=1e-6, programs=(still,)), bingham
        )
        frames = closed(
            core, 900, lambda k, torque: torque - (0.0006 * (k - 600) if k >= 600 else 0.0)
        )
        assert said(frames[:680], "trip").size == 0
        fields.append(float(frames["field1"][680]))
    assert 1.0 < fields[1] / fields[0] < 1.25  # Bingham's torque is no line of the field


@pytest.mark.slow
@pytest.mark.parametrize("control", ["torque", "computed torque", "impedance", "wall"])
def test_no_impossible_reading_of_any_sensor_drives_the_field(
    control: str, pair: LiveModel
) -> None:
    model = study.model_of(RIG, "bingham", "single") if control == "wall" else pair
    for sensor in study.SENSORS[: 2 if control == "wall" else 3]:
        for kind in IMPOSSIBLE:
            fault = found(model, control, sensor, kind, seed=3)
            assert fault.held, (control, sensor, kind, fault)


def test_a_wrong_encoder_that_comes_by_where_it_was_last_seen_to_go_is_not_believed_again() -> None:
    """The angle goes on as it was last seen; 20 rows later a turned reading crosses it, and the field came back."""
    sample = np.zeros(1, SAMPLE)
    fields = LoopProgram("fields", Mode.FIELDS, amplitude=0.3)
    core = Core(replace(rig_settings(RIG, (fields,)), rise_rate=1e6, fall_rate=1e6), None)
    for k in range(200):
        sample["seq"], sample["time_ns"], sample["alpha"] = k + 1, (k + 1) * 1_000_000, 0.01 * k
        if k >= 100:
            sample["alpha"] = 9.0 if k < 110 else 0.01 * k
        frame = core.step(sample, k)[1]
        if k == 99:
            assert frame["field1"] > 0.0
        if k >= 110:
            assert frame["field1"] < 0.3
        if k >= 114:
            assert frame["field1"] == 0.0
    assert core.state == State.TRIPPED
    assert frame["events"] & EVENT_BITS["alpha-doubted"] == 0
    core.order(Order.RESET)
    assert core.state == State.READY


@pytest.mark.slow
def test_a_healthy_sensor_is_not_doubted(pair: LiveModel) -> None:
    settings = study.settings_of("torque", pair, RIG)
    frames = study.frames_of(settings, pair.library, RIG, seed=1)
    named = sum(
        bit for name, bit in EVENT_BITS.items() if name.endswith("-doubted") or name == "trip"
    )
    assert not (frames["events"] & np.uint32(named)).any()


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["torque-sine", "torque-step", "impedance", "tracking-slow", "step"]
)
def test_the_programs_of_the_pair_ask_for_what_it_can_give(name: str, pair: LiveModel) -> None:
    frames = program_frames(pair, name).frames(4000)[0]
    unwanted = ("unreachable", "trip", "torque-doubted", "theta-doubted", "alpha-doubted")
    assert {event: said(frames, event).size for event in unwanted} == dict.fromkeys(unwanted, 0)


@pytest.mark.slow
@pytest.mark.parametrize("effort", [0.02, 0.139, 4.0])
@pytest.mark.parametrize("device", ["coaxial", "single"])
def test_no_program_asks_for_more_torque_than_the_model_has_seen(
    device: DeviceName, effort: float
) -> None:
    offered = standard_programs(RIG, model=True, device=device, effort=effort, stiffness=0.5)
    programs = {program.name: program for program in offered}
    for name in ("torque-sine", "torque-step"):
        asked = programs[name]
        assert 0.0 < asked.amplitude + abs(asked.offset) < effort, name
        assert (asked.amplitude < asked.offset) == (device == "single"), (
            "a brake gives no torque of the other sign"
        )
        assert f"{asked.amplitude:g}" in asked.meaning
    if device == "coaxial":
        assert 0.5 * programs["impedance"].amplitude < effort
    else:
        push = programs["wall"].table
        assert push is not None
        assert np.abs(push[:, 2]).max() < effort


@pytest.mark.slow
def test_on_the_twin_torque_programs_ask_for_12_and_20_millinewton_metres(pair: LiveModel) -> None:
    for effort in (0.0, pair.effort):
        offered = standard_programs(RIG, model=True, effort=effort)
        asked = {program.name: program.amplitude for program in offered}
        assert asked["torque-step"] == pytest.approx(0.012, rel=0.15)
        assert asked["torque-sine"] == pytest.approx(0.020, rel=0.15)
        assert asked["impedance"] == pytest.approx(0.3)


@pytest.mark.slow
def test_an_end_stop_that_is_hit_hard_is_no_fault() -> None:
    """The output comes with 50 rad/s and turns within six periods; the filter of its speed is late meanwhile."""
    push = LoopProgram("push", Mode.FIELDS, amplitude=-0.08, motor_torque=0.28)
    settings = replace(rig_settings(RIG, (push,)), **sensor_limits("coaxial", None, RIG))
    frames = AcceleratedRun(settings, None, RIG, seed=0, speed=150.0).frames(4000)[0]
    stop = 2.0 * np.pi * RIG.value("screw.half_stroke") / RIG.value("screw.lead")
    assert np.abs(frames["alpha"]).max() > stop
    hit = int(np.argmax(np.abs(frames["alpha"]) > stop))
    assert np.abs(frames["alpha_dot"][hit]) > 30.0
    for event in ("alpha-doubted", "theta-doubted", "trip"):
        assert said(frames, event).size == 0, event


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "observer"),
    [("sine", "none"), ("torque-sine", "none"), ("torque-sine", "sensor"), ("torque-step", "none")],
)
def test_a_strong_motor_that_drives_the_output_into_its_stops_is_no_fault(
    pair: LiveModel, name: str, observer: ObserverName
) -> None:
    """The meter reads what the stop takes, which no model knows, and the encoder turns faster than its filter."""
    programs = standard_programs(RIG, model=True, motor=0.6)
    chosen = next(p for p in programs if p.name == name)
    settings = rig_settings(RIG, (chosen,), observer=observer, torque_lead=1.5e-3, torque_lag=1e-3)
    stroke = {"stroke": shaft_angle(RIG, 0.9)}
    settings = replace(
        settings, **stroke, **sensor_limits("coaxial", pair, RIG), **free_output(RIG)
    )
    frames = study.frames_of(settings, pair.library, RIG, seed=1)
    assert np.abs(frames["alpha"]).max() > shaft_angle(RIG, 1.0)
    for event in ("trip", "torque-doubted", "alpha-doubted", "theta-doubted"):
        assert said(frames, event).size == 0, event


def test_a_jump_at_an_end_stop_is_believed_inward_only() -> None:
    """The output comes with 100 rad/s; the reading after next is where the stop has thrown it, or further out."""
    for back, believed in ((True, True), (False, False)):
        core = Core(replace(rig_settings(RIG, (REST,)), stroke=9.0), None)
        sample = np.zeros(1, SAMPLE)
        for k in range(100):
            sample["seq"], sample["time_ns"], sample["alpha"] = k + 1, (k + 1) * 1_000_000, 0.1 * k
            core.step(sample, k)
        sample["seq"], sample["time_ns"] = 101, 101 * 1_000_000
        sample["alpha"] = 9.9 - 0.1 if back else 9.9 + 0.3
        frame = core.step(sample, 100)[1]
        assert bool(frame["events"] & EVENT_BITS["alpha-doubted"]) != believed


@pytest.mark.slow
def test_the_motor_of_a_brake_pushes_no_more_than_the_brake_holds() -> None:
    """A stronger motor ran away, and the loop tripped in health."""
    for program in standard_programs(RIG, model=True, motor=0.6, device="single", effort=0.684):
        if program.mode == Mode.TORQUE:
            assert program.motor_torque == program.offset


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["reversed", "doubled"])
def test_a_wrong_meter_keeps_no_brake_at_rest_shut(kind: str) -> None:
    """Motor, meter and encoder tell of each other as soon as the torque is more than the drive's dry friction.

    A reversed meter kept the wall at its full field for 903 ms.
    """
    brake = study.model_of(RIG, "bingham", "single")
    for seed in range(3):
        fault = found(brake, "wall", "torque", kind, seed)
        assert fault.above <= 40, (seed, fault)
        assert 0 <= fault.zero <= 300, (seed, fault)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["reversed", "doubled"])
def test_a_meter_that_jumps_while_a_brake_rests_is_wrong(kind: str) -> None:
    """What holds a drive at rest does not jump. Its torque stayed within the dry friction: 29 and 161 ms passed."""
    brake = study.model_of(RIG, "bingham", "single")
    settings, begin = study.settings_of("wall", brake, RIG), 1113
    healthy = study.frames_of(settings, brake.library, RIG, 0)
    rest = healthy["theta"][begin - 50 : begin + 20]
    assert np.ptp(rest) == 0.0
    fault = study.judged(
        healthy, study.frames_of(settings, brake.library, RIG, 0, ("torque", kind, begin)), begin
    )
    assert fault.held, fault
    assert fault.zero < 12


@pytest.mark.slow
def test_an_encoder_that_is_wrong_while_its_drive_rests_reads_as_in_health() -> None:
    """No check can tell a fault whose samples have the bits of a healthy device: the loop goes on as in health."""
    brake = study.model_of(RIG, "bingham", "single")
    settings, begin = study.settings_of("wall", brake, RIG), 1113
    healthy = study.frames_of(settings, brake.library, RIG, 0)
    unknown = begin + study.ZERO_WITHIN
    for kind in ("stuck", "late"):
        faulty = study.frames_of(settings, brake.library, RIG, 0, ("theta", kind, begin))
        for name in FRAME.names or ():
            assert np.array_equal(
                healthy[name][:unknown], faulty[name][:unknown], equal_nan=True
            ), (kind, name)
        assert study.cause_of(settings, RIG, ("theta", kind, begin), healthy, faulty) == "same bits"


@pytest.mark.slow
def test_readings_of_health_and_readings_outside_are_told_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The proof that `studies/sensor_faults.py` prints for what no check can tell."""
    monkeypatch.setattr(study, "ROWS", 1200)
    monkeypatch.setattr(study, "HEALTHY", study.HEALTHY[:6])
    brake = study.model_of(RIG, "bingham", "single")
    settings = study.settings_of("wall", brake, RIG)

    def outside(sensor: str, kind: str) -> float:
        fault = (sensor, kind, 1113)
        faulty = study.frames_of(settings, brake.library, RIG, 0, fault)
        return study.outside_health(settings, brake.library, RIG, 0, fault, faulty)

    assert outside("theta", "late") == 0.0
    assert outside("torque", "doubled") > 5.0


def resting(change: Any, wave: Waveform = Waveform.CONSTANT) -> Any:
    """Frames of a brake whose drive rests on one count of its encoder; what its meter reads is noise about 8 mN m."""
    program = LoopProgram("fields", Mode.FIELDS, wave, amplitude=0.1, frequency=1.0, offset=0.3)
    limits: dict[str, Any] = torque_limits(0.4, 5e-3, 1e-3) | free_drive(RIG)
    core = Core(
        LoopSettings(device="single", programs=(program,), rise_rate=1e6, fall_rate=1e6, **limits),
        None,
    )
    noise = 3e-4 * np.random.default_rng(5).standard_normal(900)
    sample, frames = np.zeros(1, SAMPLE), np.zeros(900, FRAME)
    for k in range(900):
        sample["seq"], sample["time_ns"] = k + 1, (k + 1) * 1_000_000
        sample["torque"] = change(k, 0.008 + float(noise[k]))
        frames[k] = core.step(sample, k)[1]
    return frames


def test_at_rest_four_periods_of_another_torque_are_told_and_a_spike_is_not() -> None:
    def spike(lasts: int) -> Any:
        return resting(lambda k, torque: 2.0 * torque if 0 <= k - 600 < lasts else torque)

    assert said(spike(3), "torque-doubted").size == 0
    assert said(spike(900), "torque-doubted", "disagrees")[0] == 603
    assert said(spike(4), "torque-doubted").size > 200  # no agreement takes that back


@pytest.mark.slow
def test_at_rest_no_count_of_a_coarse_meter_no_slow_change_and_no_new_field_is_a_fault() -> None:
    coarse = resting(lambda k, torque: 0.008 * round((torque + 5e-6 * k) / 0.008))
    assert said(coarse, "torque-doubted").size == 0
    assert np.unique(coarse["torque"][100:]).size > 1
    assert said(resting(lambda k, torque: torque - 1e-5 * k), "torque-doubted").size == 0
    fields = resting(lambda k, torque: torque if k % 1000 < 500 else 2.0 * torque, Waveform.SQUARE)
    assert np.ptp(fields["field1"][100:]) > 0.1
    assert said(fields, "torque-doubted").size == 0


@pytest.mark.slow
def test_a_healthy_drive_and_its_meter_agree() -> None:
    brake = study.model_of(RIG, "bingham", "single")
    for program in standard_programs(
        RIG, model=True, motor=0.6, device="single", effort=brake.effort
    ):
        settings = rig_settings(
            RIG, (program,), device="single", observer="sensor", torque_lead=1.5e-3
        )
        settings = replace(settings, **sensor_limits("single", brake, RIG), **free_drive(RIG))
        frames = study.frames_of(settings, brake.library, RIG, seed=1)
        assert said(frames, "torque-doubted").size == 0, program.name
        assert said(frames, "trip").size == 0, program.name


@pytest.mark.slow
def test_a_rest_is_no_drift(pair: LiveModel) -> None:
    """A clutch at rest holds whatever twists it; each of the TWIN's programs was followed by 5 s of drift or more."""
    run = program_frames(pair, "torque-step")
    run.frames(3000)
    run.core.order(Order.PROGRAM, 1.0)
    frames = run.frames(12_000)[0]
    assert not (frames["flags"] & 64).any()


def program_frames(pair: LiveModel, name: str) -> AcceleratedRun:
    """A run of the TWIN under one of the offered programs; a rest is its second."""
    chosen = (next(p for p in study.offered() if p.name == name), REST)
    settings = rig_settings(
        RIG, chosen, observer="none", torque_lead=1.5e-3, stroke=shaft_angle(RIG, 0.9)
    )
    settings = replace(settings, **sensor_limits("coaxial", pair, RIG), **free_output(RIG))
    return AcceleratedRun(settings, pair.library, RIG, seed=3)


# --- sample by sample, on the hand-written Bingham model --------------------------------------------------------------


def closed(core: Core, rows: int, change: Any = None) -> Any:
    """Frames of a drive that turns evenly; the sensor reads what the model gives, with noise, or what is changed."""
    noise = 2e-4 * np.random.default_rng(5).standard_normal(rows)
    sample, frames = np.zeros(1, SAMPLE), np.zeros(rows, FRAME)
    for k in range(rows):
        sample["seq"], sample["time_ns"], sample["theta"] = k + 1, (k + 1) * 1_000_000, 0.04 * k
        torque = (frames["estimate"][k - 1] if k else 0.0) + noise[k]
        sample["torque"] = torque if change is None else change(k, torque)
        frames[k] = core.step(sample, k)[1]
    return frames


def said(frames: Any, *names: str) -> Any:
    """Rows with all of some events."""
    bits = np.uint32(sum(EVENT_BITS[name] for name in names))
    return np.flatnonzero((frames["events"] & bits) == bits)


@pytest.mark.parametrize(
    ("reason", "wrong"),
    [
        ("out-of-range", lambda k, torque: 5.0),
        ("out-of-range", lambda k, torque: float("inf")),
        ("glitch", lambda k, torque: torque - 2.0),
        ("disagrees", lambda k, torque: torque - 0.3),
        ("disagrees", lambda k, torque: -torque),
    ],
)
def test_the_event_names_sensor_and_reason_and_the_trip_says_it(
    reason: str, wrong: Any, bingham: Path
) -> None:
    core = Core(SENSOR, bingham)
    frames = closed(core, 700, lambda k, torque: wrong(k, torque) if k >= 600 else torque)
    assert said(frames, "torque-doubted", reason)[0] == 600
    assert said(frames, "trip").size == 1
    size = np.abs(frames["field1"] - frames["field2"])
    assert np.all(size[600:] <= size[599] + 1e-12)
    assert np.all(size[614:] == 0.0)
    assert core.state == State.TRIPPED
    core.order(Order.RESET)
    assert core.state == (
        State.TRIPPED if reason == "out-of-range" else State.READY
    )  # without a field nothing is compared


def test_a_spike_teaches_the_observer_nothing(bingham: Path) -> None:
    plain = closed(Core(SENSOR, bingham), 900)
    spiked = closed(Core(SENSOR, bingham), 900, lambda k, torque: 1e30 if k % 97 == 0 else torque)
    assert said(spiked, "torque-doubted").size == 10
    assert said(spiked, "trip").size == 0
    off = np.abs((spiked["field1"] - spiked["field2"]) - (plain["field1"] - plain["field2"]))
    assert float(np.max(off[50:])) < 0.02


def test_samples_that_come_together_are_each_asked_for_a_period(bingham: Path) -> None:
    """A rig that was late sends two samples into one step: their torques may differ as in two steps."""
    core, samples = Core(replace(SENSOR, observer="none"), bingham), np.zeros(200, SAMPLE)
    samples["seq"] = np.arange(1, 201)
    samples["time_ns"] = samples["seq"] * np.uint64(1_000_000)
    samples["theta"] = 0.04 * np.arange(200)
    samples["torque"] = 0.05 * np.arange(200) % 0.2
    frames = np.array(
        [core.step(samples[2 * k : 2 * k + 2], 2 * k + 1)[1].copy() for k in range(100)]
    )
    assert said(frames, "torque-doubted", "glitch").size == 0


@pytest.mark.slow
def test_a_repeated_reading_is_stuck_while_the_model_moves_or_where_there_was_noise(
    bingham: Path,
) -> None:
    frames = closed(Core(SENSOR, bingham), 900, lambda k, torque: 0.15 if k >= 600 else torque)
    assert 604 <= said(frames, "torque-doubted", "stuck")[0] <= 620
    still = replace(
        SENSOR, programs=(LoopProgram("torque", Mode.TORQUE, amplitude=0.15, motor_torque=0.1),)
    )
    coarse = closed(Core(still, bingham), 3000, lambda k, torque: round(torque, 2))
    assert said(coarse[50:], "torque-doubted").size == 0
    noisy = closed(Core(still, bingham), 900, lambda k, torque: 0.15 if k >= 600 else torque)
    assert said(noisy[50:], "torque-doubted", "stuck")[0] == 605 - 50


def test_without_an_observer_of_the_sensor_control_goes_on(bingham: Path) -> None:
    frames = closed(
        Core(replace(SENSOR, observer="none"), bingham),
        700,
        lambda k, torque: 5.0 if k >= 600 else torque,
    )
    assert said(frames, "torque-doubted").size == 100
    assert said(frames, "trip").size == 0


def test_the_first_samples_are_asked_too(bingham: Path) -> None:
    """Before the filter has settled no speed is known, but none is beyond what turns."""
    core, sample = Core(replace(SENSOR, observer="none"), bingham), np.zeros(1, SAMPLE)
    for k in range(40):
        sample["seq"], sample["time_ns"], sample["theta"] = k + 1, (k + 1) * 1_000_000, 0.04 * k
        sample["alpha"] = 1e30 if k == 30 else 0.0
        frame = core.step(sample, k)[1]
        assert abs(frame["alpha_dot"]) < 1.0
        assert bool(int(frame["events"]) & EVENT_BITS["alpha-doubted"]) == (k == 30)


def test_limits_follow_from_the_device_and_the_model() -> None:
    model = LiveModel(Path("none"), "some", "0", effort=0.2, slip=50.0, band=0.01)
    pair, foreign = sensor_limits("coaxial", model, RIG), sensor_limits("single", model, None)
    assert pair["torque_limit"] == pytest.approx(2.0 * (0.51 + 0.48))
    assert pair["alpha_limit"] > 2.0 * np.pi * RIG.value("screw.half_stroke") / RIG.value(
        "screw.lead"
    )
    assert foreign["torque_limit"] == pytest.approx(1.6)
    assert foreign["theta_glitch"] == foreign["alpha_fastest"] == pytest.approx(500.0)
    assert not any(sensor_limits("single", None, None).values())


@pytest.mark.parametrize(
    ("trip", "words"),
    [
        (
            "alpha-doubted: torque-doubted: disagrees",
            "The torque meter and the output encoder contradict each other",
        ),
        ("torque-doubted: stuck", "The torque meter is stuck"),
        ("torque-doubted: disagrees", "The torque meter disagrees with the model"),
        ("alpha-doubted: theta-doubted: glitch", "The drive encoder or the output encoder jumps"),
        ("rig-fault", ""),
        ("", ""),
    ],
)
def test_a_trip_by_a_sensor_is_told_as_a_sentence(trip: str, words: str) -> None:
    assert doubt_in_words(trip).startswith(words)
    assert bool(doubt_in_words(trip)) == bool(words)


@pytest.mark.slow
def test_a_network_that_comes_back_to_the_edge_of_its_log_is_not_taken_for_a_fault(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With twice the usual torque of the motor the drive leaves the slips of the log, and returns."""
    monkeypatch.setattr(study, "ROWS", 1000)
    model = study.model_of(RIG, "fnn-16", "coaxial")
    usual = study.settings_of("torque", model, RIG)
    fast = replace(
        usual, programs=tuple(replace(program, motor_torque=0.2) for program in usual.programs)
    )
    frames = study.frames_of(fast, model.library, RIG, 0)
    outside = frames["flags"] & 1 != 0
    assert np.count_nonzero(np.diff(outside.astype(int)) < 0) > 0, "it never came back"
    assert study.doubted(frames) == 0
