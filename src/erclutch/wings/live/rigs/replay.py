"""A recording plays back as a rig in a process of its own: its sensors again, row after row, and its commands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from erclutch.errors import SettingError
from erclutch.wings.live.offered_rig import AskedRig, OfferedRig

if TYPE_CHECKING:
    from erclutch.wings.live.session import ServedRig
    from erclutch.wings.live.settings import LoopProgram
    from erclutch.wings.rig.interface import SteppedRig


def _chosen(asked: AskedRig) -> tuple[ServedRig, LoopProgram]:
    """The recording as a rig, and its commands as the program."""
    import numpy as np

    from erclutch.signals.channels import NamedChannels
    from erclutch.signals.device import EFFORT_OF, Units
    from erclutch.signals.origins import MEASURED
    from erclutch.signals.units import UNKNOWN
    from erclutch.wings.live.command_line.chosen_rig import PERIOD
    from erclutch.wings.live.offered_programs import recorded
    from erclutch.wings.live.session import ServedRig
    from erclutch.wings.rig.playback import angles_of, at_period, fields_of

    if asked.options.log is None:
        raise SettingError("--rig replay needs a recording", remedy="Give --log FILE")
    if asked.control.field_limit is not None:
        raise SettingError(
            "--field-limit with a replay", remedy="Leave it out: the fields are those of the log"
        )
    log, *_ = asked.reading.read((asked.options.log,))
    device = asked.reading.device
    if device is None:
        device = "coaxial" if EFFORT_OF["coaxial"] in log.signals else "single"
    single = device == "single"

    # The rows as the loop meets them: what the sensors read, and what was commanded.
    seconds = math.inf if asked.loop.seconds is None else asked.loop.seconds
    angles = angles_of(log, (asked.control.theta_wrap, asked.control.alpha_wrap))
    file = asked.folder / "angles.npy"
    np.save(file, at_period(log, angles, PERIOD, held=False, seconds=seconds))
    commands = at_period(log, fields_of(log), PERIOD, held=True, seconds=seconds)

    # What the log knows of its units.
    effort = log.units.get(EFFORT_OF[device], UNKNOWN)
    fields = [log.units[name] for name in ("field", "E1", "E") if name in log.units]
    field = next(iter(fields), UNKNOWN)
    slip = "rad/s"
    if single:
        of_position = log.units.get("position", "")
        of_motion = {"rad": "rad/s", "m": "m/s"}.get(of_position, UNKNOWN)
        slip = log.units.get("slip", of_motion)
    named = NamedChannels(
        {},
        Units(effort, field, slip),
        motor="motor_torque" in log.signals,
        sensor=EFFORT_OF[device] in log.signals,
    )
    origin = "RECORDING" if log.origin in MEASURED else f"RECORDING of {log.origin}"
    spec = {"kind": "replay", "angles": str(file), "period": PERIOD, "single": single}
    return ServedRig(log.name, origin, spec, named), recorded(commands)


def _stepped(spec: Mapping[str, Any]) -> tuple[SteppedRig, float]:
    """The recording of a specification, and its lead in m: its output stands in rad."""
    import numpy as np

    from erclutch.wings.rig.playback import Playback

    angles = np.load(spec["angles"], allow_pickle=False)
    return Playback(angles, float(spec["period"])), 2.0 * np.pi


RIG = OfferedRig(place=3, chosen=_chosen, stepped=_stepped, learns=False)
