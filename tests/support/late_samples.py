"""A healthy device whose samples come late, on a counted clock: no machine has to be quick or slow. TWIN."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.signals.device import DeviceName
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import FRAME, SAMPLE
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.twin import Twin
from tests.support.sensor_faults import FAULTS, SENSORS, command_of

PERIOD_NS = 1_000_000
#: What may be late: packets, which then come together; all packets but the newest, which are lost; the loop, which
#: sleeps through its deadlines; the rig, which stands still meanwhile, as a TWIN does whose process has to wait.
LATE = ("packets", "lost", "loop", "rig")


def frames_of_late(
    settings: LoopSettings,
    model: Path | None,
    rig: RigParameters,
    late: str,
    pauses: Sequence[tuple[int, int]],
    *,
    rows: int,
    fault: tuple[str, str, int] | None = None,
) -> Any:
    """Frames of the loop on the TWIN, dtype `FRAME`, one a step: a loop that sleeps makes none meanwhile.

    Args:
        settings: of the loop.
        model: compiled.
        rig: parameters of the TWIN.
        late: one of `LATE`.
        pauses: first row of each, and how many rows of 1 ms it lasts.
        rows: how many.
        fault: sensor, kind and row of a fault that lasts.
    """
    device: DeviceName = settings.device
    single, turns = device == "single", 2.0 * np.pi / rig.value("screw.lead")
    twin, core = Twin(rig, seed=1, locked=single, single=single), Core(settings, model)
    paused = {row for first, count in pauses for row in range(first, first + count)}
    seen = {name: np.zeros(rows) for name in SENSORS}
    samples, frames = np.zeros(rows, SAMPLE), np.zeros(rows, FRAME)
    arrived = taken = steps = slept = 0
    for k in range(rows):
        stands = late == "rig" and k in paused
        if not stands:
            read = twin.sense()
            for name, value in zip(
                SENSORS, (read.torque, read.theta, turns * read.alpha_raw), strict=True
            ):
                seen[name][arrived] = samples[name][arrived] = value
                if fault is not None and k >= fault[2]:
                    begin = arrived - (k - fault[2])
                    samples[name][arrived] = (
                        value if name != fault[0] else FAULTS[fault[1]](seen[name], begin, arrived)
                    )
            samples["seq"][arrived], samples["time_ns"][arrived] = arrived + 1, (k + 1) * PERIOD_NS
            arrived += 1
        if late == "loop" and k in paused:
            slept += 1
        else:
            begin = arrived if late != "rig" and k in paused else taken
            begin = max(begin, arrived - 1) if late == "lost" and k - 1 in paused else begin
            command, frame = core.step(samples[begin:arrived], k, late_ns=slept * PERIOD_NS)
            frames[steps], steps, slept = frame, steps + 1, 0
            frames["seq"][steps - 1] = k
            taken = taken if late != "rig" and k in paused else arrived
            twin.command(command_of(command))
        if not stands:
            twin.step()
    return frames[:steps]
