"""Why no check tells of some faults of a sensor in time: a healthy loop shows the same, or more. TWIN.

    python studies/sensor_bound.py [--seeds 2] [--healthy 2] [--model bingham] [--only CONTROL]

Takes each session of `studies/sensor_faults.py` that misses the aim to the letter, up to the last row in which an alarm
would be in time. Where each sample and each command has the bits of health, no check can tell. Else what the loop can
see is put into numbers that grow with how unusual it is (`LOOKS` of `tests/support/sensor_bound.py`). Printed is the
healthy session, and its row, from which on as many rows are at least as unusual in each number: of the same loop under
its own program, and under each program that `erclutch live` offers. A check that raises an alarm where such numbers are
large, alone or together, raises an alarm there, too. "alone" is the same of each number by itself: below 1 there is a
number that no healthy session has had, and a check might tell.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.signals.device import DeviceName
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import default_rig

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.sensor_bound import (
    LOOKS,
    HealthySessions,
    likeness_of,
    looks_of,
    rows_in_time,
    same_bits,
)
from tests.support.sensor_faults import (
    CONTROLS,
    FAULTS,
    ROWS,
    SENSORS,
    frames_of,
    judged,
    model_of,
    settings_of,
    under_field,
)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument(
        "--healthy", type=int, default=2, help="sessions of each program and motor torque"
    )
    parser.add_argument("--model", default="bingham")
    parser.add_argument("--only", default="", help="control")
    asked = parser.parse_args()
    rig, counts = default_rig(), Counter[str]()
    devices: tuple[DeviceName, ...] = ("coaxial", "single")
    fitted = {device: model_of(rig, asked.model, device) for device in devices}
    print(f"TWIN, {asked.model}, {asked.seeds} seeds; {len(LOOKS)} looks")
    print(f"{asked.healthy} healthy sessions of {ROWS} rows for each program and motor torque")
    columns = (
        "control",
        "sensor",
        "fault",
        "seed",
        "rows",
        "healthy session",
        "row",
        "least ratio",
        "of",
        "alone",
    )
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for control in CONTROLS:
        if asked.only not in (control, ""):
            continue
        model = fitted[CONTROLS[control][0]]
        settings = settings_of(control, model, rig)
        well = [frames_of(settings, model.library, rig, seed) for seed in range(asked.seeds)]
        rng = np.random.default_rng(7)
        begins = [int(rng.choice(under_field(frames))) for frames in well]
        sessions = HealthySessions(settings, model, rig, asked.healthy)
        for sensor, kind, seed in itertools.product(SENSORS, FAULTS, range(asked.seeds)):
            if kind == "silent" or (sensor == "alpha" and control == "wall"):
                continue
            faulty = frames_of(settings, model.library, rig, seed, (sensor, kind, begins[seed]))
            run = judged(well[seed], faulty, begins[seed])
            counts["held"] += run.held
            if run.held:
                continue
            for too_high in (False, True)[: 1 + (not run.never_above)]:
                name = f"{control} | {sensor} | {kind} | {seed}"
                counts[
                    _printed(name, well[seed], faulty, begins[seed], too_high, settings, sessions)
                ] += 1
    print(f"{counts['held']} sessions hold; of the others: {dict(counts)}")
    return 0


def _printed(
    name: str,
    healthy: Any,
    faulty: Any,
    begin: int,
    too_high: bool,
    settings: LoopSettings,
    sessions: HealthySessions,
) -> str:
    """A row of the table, and what came of it."""
    rows = rows_in_time(healthy, faulty, begin, too_high=too_high)
    until = f"{rows}{', too high then' if too_high else ''}"
    if same_bits(healthy, faulty, begin, rows):
        print(f"| {name} | {until} | the same one | {begin} | 1 | each bit | 1 |", flush=True)
        return "the bits of health"
    found = likeness_of(looks_of(faulty, settings)[begin : begin + rows], sessions)
    nearest = (
        f"{found.session} | {found.row} | {found.margin:.2f} | {found.least} | {found.alone:.2f}"
    )
    print(f"| {name} | {until} | {nearest} |", flush=True)
    if found.margin >= 1.0:
        return "as unusual in health"
    return "each number as unusual in health" if found.alone >= 1.0 else "might be told"


if __name__ == "__main__":
    raise SystemExit(main())
