"""How often the alarms of a healthy device are false, and how soon they tell a drift, on the TWIN.

    python studies/alarms.py                         # 100 seeds of each fault, 5 accelerated hours
    python studies/alarms.py --hours 24 --seeds 20

The model is the network that `erclutch live` fits to 60 s of the TWIN. Sessions run the loop's own C core on the
accelerated twin with internal steps of 1/3 ms; each has commands and noise of its own seed. The flags are those of the
exported step. Faults: a yield torque that is 10 % lower from the start, a tare of 5 % of the largest training effort,
a motor encoder that stands still, and the viscosity of a fluid that is 20 K warmer. The TWIN's yield stress does not
depend on temperature, so the last one is milder than on a device.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.export.c.compiled_model import DRIFT, OUTSIDE_RANGE, WIDE_BAND, CompiledModel
from erclutch.models.load import load_model
from erclutch.signals.array import Array
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.offered_programs import rig_settings, standard_programs, starting_with
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin_model import twin_model

SECOND = 1000
#: Programs of whose motion the model knows enough; the others show what happens where it does not.
KNOWN = ("square", "sine", "tracking-slow", "tracking-fast")
UNKNOWN = ("step", "torque-sine", "zero-field")
LAYERS = {"outside": OUTSIDE_RANGE, "wide band": WIDE_BAND, "drift": DRIFT}


def session(rig: RigParameters, library: Path, program: str, seed: int, seconds: int) -> Array:
    """What the alarms see: fields, speeds and measured torque, shape (rows, 5)."""
    programs = starting_with(standard_programs(rig, model=True, seed=seed), program)
    coarse = rig.changed({"integration.step": 1e-3 / 3.0})
    run = AcceleratedRun(rig_settings(rig, programs), library, coarse, seed=seed, speed=40.0)
    frames: Any
    frames, *_ = run.frames(seconds * SECOND)
    names = ("field1", "field2", "theta_dot", "alpha_dot", "torque")
    return np.column_stack([frames[name] for name in names])


def flags_of(device: CompiledModel, rows: Array) -> NDArray[np.int64]:
    """Flags of the exported step from a reset."""
    device.reset()
    _, flags = device.run(np.ascontiguousarray(rows))
    return np.array(flags, np.int64)


def healthy(device: CompiledModel, library: Path, hours: float, first_seed: int) -> None:
    """Share and episodes of each alarm on a device that is as it was."""
    length = 300  # s of a session
    count = round(hours * 3600.0 / length)
    share = dict.fromkeys(LAYERS, 0.0)
    episodes = dict.fromkeys(LAYERS, 0)
    for k in range(count):
        program = KNOWN[k % len(KNOWN)]
        flags = flags_of(device, session(default_rig(), library, program, first_seed + k, length))
        for name, bit in LAYERS.items():
            raised = (flags & bit) != 0
            share[name] += float(raised.mean()) / count
            episodes[name] += int(np.count_nonzero(np.diff(raised.astype(int), prepend=0) > 0))
    ran = count * length / 3600.0
    seeds = f"seeds from {first_seed} on"
    print(
        f"TWIN, healthy, {ran:.2f} accelerated hours in sessions of {length} s, {seeds}: {', '.join(KNOWN)}"
    )
    print(f"{'alarm':<12}{'share of rows':>15}{'episodes':>10}{'in 24 h':>10}{'95 % below':>12}")
    for name in LAYERS:
        seen = episodes[name]
        most = f"{3.0 * 24.0 / ran:.1f}" if seen == 0 else "-"  # the rule of three: none seen
        print(f"{name:<12}{share[name]:>15.5f}{seen:>10}{seen * 24.0 / ran:>10.1f}{most:>12}")


def elsewhere(device: CompiledModel, library: Path) -> None:
    """The same where the model does not know the motion."""
    print("\nTWIN, healthy, 120 s of each program; the model knows little of the last three")
    print(f"{'program':<16}" + "".join(f"{name:>12}" for name in LAYERS) + f"{'first drift s':>16}")
    for program in (*KNOWN, *UNKNOWN):
        flags = flags_of(device, session(default_rig(), library, program, 7, 120))
        shares = "".join(f"{np.mean((flags & bit) != 0):>12.3f}" for bit in LAYERS.values())
        print(f"{program:<16}{shares}{first(flags) or float('nan'):>16.1f}")


def first(flags: NDArray[np.int64]) -> float | None:
    """Seconds to the first alarm of a drift."""
    raised = np.flatnonzero(flags & DRIFT)
    return (float(raised[0]) + 1.0) / SECOND if raised.size else None


def faults(
    library: Path, largest: float, seed: int, program: str, seconds: int
) -> Iterator[tuple[str, Array]]:
    """Rows of a session with each fault."""
    rig = default_rig()
    rows = session(rig, library, program, seed, seconds)
    yield "none", rows
    for name, sign in (("tare +5 %", 1.0), ("tare -5 %", -1.0)):
        yield name, rows + np.array([0.0, 0.0, 0.0, 0.0, sign * 0.05 * largest])
    yield "stuck encoder", rows * np.array([1.0, 1.0, 0.0, 1.0, 1.0])
    rated = ("clutch.rated_torque_1", "clutch.rated_torque_2")
    weaker = rig.changed({path: 0.9 * rig.value(path) for path in rated})
    yield "yield -10 %", session(weaker, library, program, seed, seconds)
    warm = math.exp(-20.0 * rig.value("thermal.thinning")) * rig.value("fluid.viscosity")
    yield (
        "20 K warmer",
        session(rig.changed({"fluid.viscosity": warm}), library, program, seed, seconds),
    )


def delays(
    device: CompiledModel, library: Path, largest: float, seeds: range, seconds: int
) -> None:
    """Seconds from the start of a session with a fault to the alarm."""
    for program in KNOWN:
        delays_of: dict[str, list[float]] = {}  # s, by fault
        for seed in seeds:
            for name, rows in faults(library, largest, seed, program, seconds):
                delay = first(flags_of(device, rows)) or math.inf
                delays_of.setdefault(name, []).append(delay)
        listed = f"seeds {seeds.start} to {seeds.stop - 1}"
        print(
            f"\nTWIN, {program}, {listed}, sessions of {seconds} s: seconds to the alarm of a drift"
        )
        print(f"{'fault':<16}{'told':>8}{'10 %':>8}{'median':>8}{'90 %':>8}")
        for name, of_seeds in delays_of.items():
            raised = np.mean(np.isfinite(of_seeds))
            quantiles = np.quantile(of_seeds, (0.1, 0.5, 0.9), method="inverted_cdf")
            cells = [f"{delay:>8.1f}" if delay < math.inf else f"{'-':>8}" for delay in quantiles]
            print(f"{name:<16}{raised:>8.0%}{''.join(cells)}")


def main() -> None:
    """Print rates of false alarms and times to alarms."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        "--hours", type=float, default=5.0, help="accelerated hours of a healthy device"
    )
    parser.add_argument("--seeds", type=int, default=100, help="sessions with each fault")
    parser.add_argument(
        "--first-seed", type=int, default=20_000, help="of the sessions; those below 10,000 chose"
    )
    parser.add_argument("--seconds", type=int, default=30, help="length of a session with a fault")
    asked = parser.parse_args()
    from rich.console import Console

    began = time.process_time()
    path = twin_model(default_rig(), Console(stderr=True))
    library = live_model(path, "coaxial").library
    device = CompiledModel(library)
    largest = float(np.max(np.abs(load_model(path).trained_on.effort)))
    seeds = range(asked.first_seed, asked.first_seed + asked.seeds)
    delays(device, library, largest, seeds, asked.seconds)
    elsewhere(device, library)
    print()
    healthy(device, library, asked.hours, asked.first_seed + 1000)
    print(f"{time.process_time() - began:.0f} CPU s")


if __name__ == "__main__":
    main()
