"""Faults of sensors, packets and control, injected into the loop's core step by step, so counts are exact."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import FRAME, SAMPLE
from erclutch.wings.live.orders import Order
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.rig.packet import SensorPacket, pack_sensors
from tests.support.live_faults.finding import (
    CONTROLS,
    EASE,
    SETTINGS,
    STEPS,
    Finding,
    chosen,
    compiled_model,
    count,
    good_samples,
    mutated,
    one_by_one,
    places,
    run_core,
    sound,
    zero_after,
)

# --- faults of sensors and packets ------------------------------------------------------------------------------------


def bad_number(sensor: str, value: float) -> Finding:
    """A sensor that is not finite now and then, then for good."""
    samples, at = good_samples(), places(1)
    samples[sensor][at] = value
    frames = run_core(one_by_one(samples))
    seen, trips = count(frames, "sample-invalid"), count(frames, "trip")
    lasting = good_samples()
    lasting[sensor][1000:] = value
    zero = zero_after(run_core(one_by_one(lasting)), 1000)
    must_stop = sensor != "torque"  # no command depends on the torque meter
    passed = (
        seen == 10 and trips == 0 and sound(frames) and (zero == 13 if must_stop else zero == -1)
    )
    ends = "zero after 13 ms" if must_stop else "control goes on"
    return Finding(
        f"{sensor} is {value}",
        10,
        f"10 invalid, no trip; lasting: {ends}",
        f"{seen}, {trips}; {zero} ms",
        passed,
    )


def wraps() -> Finding:
    """Both encoders start again at zero after each turn."""
    samples, turn = good_samples(), 2.0 * np.pi
    raw = samples.copy()
    for name in ("theta", "alpha"):
        raw[name] = np.mod(samples[name], turn)
    settings = replace(chosen(), theta_wrap=turn, alpha_wrap=turn)
    frames, plain = run_core(one_by_one(raw), settings), run_core(one_by_one(samples))
    seen = count(frames, "wrap")
    off = max(
        float(np.max(np.abs(np.diff(frames[n]) - np.diff(plain[n]))))
        for n in ("theta", "alpha", "theta_dot")
    )
    at = [np.flatnonzero(np.abs(np.diff(raw[n])) > 1.0) for n in ("theta", "alpha")]
    steps = len(np.union1d(*at))  # both may wrap in one step
    passed = seen == steps and off < 1e-9 and count(frames, "glitch") == 0
    return Finding(
        "encoder wraps",
        steps,
        f"{steps} wraps, angles as without",
        f"{seen}, off by {off:.1e}",
        passed,
    )


def glitch(sensor: str) -> Finding:
    """A jump of 60 rad/s for one sample."""
    samples, at = good_samples(), places(2)
    samples[sensor][at] += 0.06
    frames, plain = run_core(one_by_one(samples)), run_core(one_by_one(good_samples()))
    seen = count(frames, "glitch")
    off = float(np.max(np.abs(frames[f"{sensor}_dot"] - plain[f"{sensor}_dot"])))
    passed = seen == 10 and off < 1.5 and sound(frames) and count(frames, "trip") == 0
    return Finding(
        f"{sensor}: 60 rad/s glitch",
        10,
        "10 rejected, speed off < 1.5 rad/s",
        f"{seen}, {off:.2f}",
        passed,
    )


def loss(share: float) -> Finding:
    """Samples lost at random; the expectation follows from the runs of losses that were drawn."""
    total = 60_000
    rng = np.random.default_rng(3)
    gone = rng.random(total) < share
    gone[:100] = False
    edges = np.flatnonzero(np.diff(np.concatenate(([0], gone.astype(int), [0]))))
    longest = int(np.max(np.diff(edges)[::2])) if edges.size else 0
    samples = good_samples(total)
    steps = [samples[k : k if gone[k] else k + 1] for k in range(total)]
    frames = run_core(steps)
    plain = run_core(one_by_one(samples))
    seen, trips = count(frames, "sample-lost"), count(frames, "trip")
    expected = int(np.count_nonzero(gone))
    off = float(np.max(np.abs((frames["alpha_dot"] - plain["alpha_dot"])[~gone])))
    passed = seen == expected and (trips > 0) == (longest >= 21) and sound(frames)
    said = f"{seen} lost, {trips} trips, speed off {off:.2f} rad/s"
    return Finding(
        f"{share:.0%} lost",
        expected,
        f"{expected} lost, longest run {longest}: no trip",
        said,
        passed,
    )


def burst(length: int) -> Finding:
    """A run of lost samples."""
    samples = good_samples()
    steps = one_by_one(samples)
    for k in range(1000, 1000 + length):
        steps[k] = samples[:0]
    frames = run_core(steps)
    field1 = frames["field1"]
    tripped = count(frames, "trip") > 0
    zero = zero_after(frames, 1000)
    held = bool(np.all(field1[1000:1005] == field1[999]))
    falling = bool(np.all(np.diff(field1[1004 : 1000 + min(length, 14)]) < 0))
    passed = (
        tripped == (length >= 21)
        and (zero == 13 if tripped else zero == -1)
        and held
        and falling
        and sound(frames)
    )
    wanted = (
        "hold 5, reduce, zero at the 14th, stay"
        if length >= 21
        else "hold 5, reduce, then on as before"
    )
    return Finding(
        f"burst of {length} lost", length, wanted, f"trip {tripped}, zero after {zero} ms", passed
    )


def recovery() -> Finding:
    """A second without samples trips; after a reset and an order to run, the field comes back without a jump."""
    samples, gone = good_samples(), slice(900, 1900)
    core, steps, frames = (
        Core(chosen(), compiled_model()),
        one_by_one(samples),
        np.zeros(STEPS, FRAME),
    )
    for k in range(STEPS):
        if k == gone.stop + 10:
            core.order(Order.RESET)
            core.order(Order.PROGRAM, 0.0)
        frames[k] = core.step(samples[:0] if gone.start <= k < gone.stop else steps[k], k)[1]
    field1 = frames["field1"]
    zero, most = (
        zero_after(frames[: gone.stop + 10], gone.start),
        chosen().field_limit / EASE + 1e-9,
    )
    jump = float(np.max(np.diff(field1[gone.stop : gone.stop + EASE + 10])))
    eased = chosen() is CONTROLS["equation 23"] or jump <= most
    passed = zero == 13 and eased and bool(field1[-1] > 0.05) and sound(frames)
    said = f"zero after {zero} ms, then {jump:.3f} a step"
    return Finding(
        "trip and recovery",
        1,
        f"zero after 13 ms, then at most {most:.3f} a step in stages",
        said,
        passed,
    )


def duplicates() -> Finding:
    """Packets that come twice."""
    samples = good_samples()
    steps = one_by_one(samples)
    at = places(4)
    for k in at:
        steps[k] = samples[[k, k]]
    frames, plain = run_core(steps), run_core(one_by_one(samples))
    seen = count(frames, "stale-packet")
    same = bool(np.array_equal(frames["estimate"], plain["estimate"], equal_nan=True))
    return Finding(
        "duplicated packets",
        10,
        "10 dropped, nothing else changes",
        f"{seen}, same: {same}",
        seen == 10 and same,
    )


def reordered() -> Finding:
    """Packets that come one step late, after the next one."""
    samples = good_samples()
    steps = one_by_one(samples)
    for k in places(5):
        steps[k] = samples[:0]
        steps[k + 1] = samples[[k + 1, k]]
    frames = run_core(steps)
    seen, lost = count(frames, "stale-packet"), count(frames, "sample-lost")
    passed = seen == 10 and lost == 10 and sound(frames) and count(frames, "trip") == 0
    return Finding(
        "reordered packets", 10, "10 dropped as stale, 10 held", f"{seen}, {lost}", passed
    )


def clock_jump() -> Finding:
    """The rig's clock jumps by 10 s and back, and by an hour into the past."""
    samples = good_samples()
    samples["time_ns"][500:] += np.uint64(10_000_000_000)
    samples["time_ns"][1000:] -= np.uint64(10_000_000_000)
    samples["time_ns"][1500:] -= np.uint64(1_000_000)
    samples["time_ns"][1500:] = samples["time_ns"][1500:] + np.uint64(2**64 - 3600 * 10**9)
    frames, plain = run_core(one_by_one(samples)), run_core(one_by_one(good_samples()))
    seen = count(frames, "clock-jump")
    same = bool(np.array_equal(frames["estimate"], plain["estimate"], equal_nan=True))
    return Finding(
        "rig's clock jumps",
        3,
        "3 said, nothing else changes",
        f"{seen}, same: {same}",
        seen == 3 and same,
    )


def mutated_packets(number: int = 100_000) -> Finding:
    """Packets with random bytes changed, cut or prolonged: each is refused."""
    import ctypes

    from erclutch.wings.live.c_build import core_library

    library = ctypes.CDLL(str(core_library()))
    out = np.zeros(1, SAMPLE)
    rng = random.Random(6)
    whole = pack_sensors(SensorPacket(77, 5, 6, 1.0, 2.0, 3.0))
    taken = 0
    for _ in range(number):
        data = mutated(whole, rng)
        taken += library.erc_get_sample(
            data, ctypes.c_size_t(len(data)), ctypes.c_uint32(77), ctypes.c_void_p(out.ctypes.data)
        )
    control = library.erc_get_sample(
        whole, ctypes.c_size_t(64), ctypes.c_uint32(77), ctypes.c_void_p(out.ctypes.data)
    )
    foreign = library.erc_get_sample(
        whole, ctypes.c_size_t(64), ctypes.c_uint32(78), ctypes.c_void_p(out.ctypes.data)
    )
    passed = taken == 0 and control == 1 and foreign == 0
    return Finding(
        "forged packets",
        number,
        "none taken, the whole one is",
        f"{taken} taken; {control}",
        passed,
    )


# --- faults of control ------------------------------------------------------------------------------------------------


def asked(rows: Any, **changes: Any) -> Any:
    """Frames for fields that are asked for outright."""
    table = np.asarray(rows, float)
    program = LoopProgram("asked", Mode.FIELDS, Waveform.TABLE, table=table)
    return run_core(
        one_by_one(good_samples(len(table))), replace(SETTINGS, programs=(program,), **changes)
    )


def both_fields() -> Finding:
    """Both fields asked for, in all proportions."""
    rng = np.random.default_rng(7)
    table = np.column_stack([rng.uniform(0.01, 0.5, (1000, 2)), np.full(1000, 0.1)])
    frames = asked(table, rise_rate=1e6, fall_rate=1e6)
    seen = count(frames, "both-fields")
    larger = np.maximum(frames["field1"], frames["field2"]) == table[:, :2].max(axis=1)
    passed = seen == 1000 and sound(frames) and bool(larger.all())
    return Finding(
        "both fields asked for",
        1000,
        "1000 said; the larger alone",
        f"{seen}; sound {sound(frames)}",
        passed,
    )


def too_high() -> Finding:
    """3000 V asked for: 0.75 where 0.5 is 2000 V."""
    frames = asked(np.tile([0.75, 0.0, 0.1], (1000, 1)))
    seen, top = count(frames, "beyond-limit"), float(frames["field1"].max())
    return Finding(
        "3000 V asked for",
        1000,
        "1000 clipped to 2000 V",
        f"{seen}, {4000 * top:.0f} V",
        (seen, top) == (1000, 0.5),
    )


def not_finite() -> Finding:
    """A command that is not finite."""
    table = np.tile([0.3, 0.0, 0.1], (1000, 1))
    table[100:110, 0], table[200:210, 2], table[300:310, 1] = np.nan, np.inf, -np.inf
    frames = asked(table)
    seen = count(frames, "command-not-finite")
    zero = float(np.max(frames["field1"][100:110]))
    return Finding(
        "command not finite",
        30,
        "30 said, counted as zero",
        f"{seen}, field {zero:g}",
        seen == 30 and zero == 0.0,
    )


def slew() -> Finding:
    """Steps from one clutch to the other, through a slow supply."""
    wave = np.where(np.arange(1000) // 50 % 2 == 0, 0.5, -0.5)
    table = np.column_stack([np.maximum(wave, 0), np.maximum(-wave, 0), np.full(1000, 0.1)])
    frames = asked(table, rise_rate=25.0, fall_rate=50.0)
    field_now = frames["field1"] - frames["field2"]
    up = float(np.max(np.diff(np.abs(field_now))))
    down = float(-np.min(np.diff(np.abs(field_now))))
    passed = (
        up <= 0.025 + 1e-12
        and down <= 0.05 + 1e-12
        and sound(frames)
        and count(frames, "rate-limited") > 0
    )
    return Finding(
        "jumps of the field",
        20,
        "up at most 0.025, down 0.05 a step",
        f"{up:.3f}, {down:.3f}",
        passed,
    )


EXACT: dict[str, Callable[[], Finding]] = {
    "nan-theta": lambda: bad_number("theta", float("nan")),
    "nan-alpha": lambda: bad_number("alpha", float("nan")),
    "nan-torque": lambda: bad_number("torque", float("nan")),
    "inf-theta": lambda: bad_number("theta", float("inf")),
    "inf-alpha": lambda: bad_number("alpha", float("-inf")),
    "wraps": wraps,
    "glitch-theta": lambda: glitch("theta"),
    "glitch-alpha": lambda: glitch("alpha"),
    "loss-1": lambda: loss(0.01),
    "loss-5": lambda: loss(0.05),
    "loss-50": lambda: loss(0.5),
    "burst-19": lambda: burst(19),
    "burst-20": lambda: burst(20),
    "burst-21": lambda: burst(21),
    "recovery": recovery,
    "duplicates": duplicates,
    "reordered": reordered,
    "forged": mutated_packets,
    "clock-jump": clock_jump,
    "both-fields": both_fields,
    "too-high": too_high,
    "not-finite": not_finite,
    "slew": slew,
}
