"""The limits of a rig as options of the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from erclutch.cli.quantities import SECONDS, quantity

if TYPE_CHECKING:
    from erclutch.wings.design.limits import RigLimits

_LIMITS = Group(
    "Limits of the rig, in SI units (a damper's motion in m, others' in rad)", sort_key=2
)
_Number = Annotated[float | None, Parameter(group=_LIMITS)]


@Parameter(name="*")
@dataclass(frozen=True)
class LimitOptions:
    """What the rig may do."""

    rig_limits: Annotated[Path | None, Parameter(group=_LIMITS)] = None
    """TOML file with a table named limits, or a log of the rig: what it did there it may do again."""
    largest: _Number = None
    """Largest field. That of the paper's pair is 0.5, which is 2000 V."""
    field_rate: _Number = None
    """Largest change of the field in a second. Default: the field may step."""
    speed: _Number = None
    """Largest slip to either side; for a pair the motor's speed."""
    acceleration: _Number = None
    """Largest change of the speed in a second."""
    stroke: _Number = None
    """Travel from end to end; the motion begins in the middle. Default: no end."""
    rest: Annotated[float | None, SECONDS, Parameter(group=_LIMITS)] = None
    """Time without field and motion at the start and at the end. Default: 0.5 s."""
    heat: Annotated[float | None, quantity("W"), Parameter(group=_LIMITS)] = None
    """Largest mean power in W; needs --largest-effort."""
    largest_effort: _Number = None
    """Torque or force that the device never exceeds."""
    idle_effort: _Number = None
    """Torque or force without field at the largest speed; a field adds to it. Default: --largest-effort."""
    slow_effort: _Number = None
    """Torque or force without field at rest; motion adds to it. Default: --idle-effort."""
    exponent: _Number = None
    """Power of the field's share by which the effort grows to the largest one. Default: 1."""
    one_way: Annotated[bool, Parameter(group=_LIMITS, negative=())] = False
    """The motion never turns back."""
    field_unit: Annotated[str, Parameter(group=_LIMITS)] = ""
    """Unit of the field, for the column's name: A, V, T, kV/mm."""

    def given(self) -> dict[str, float]:
        """The numbers that were given, by the names of `RigLimits`."""
        options = {
            "field": self.largest,
            "field_rate": self.field_rate,
            "speed": self.speed,
            "acceleration": self.acceleration,
            "stroke": self.stroke,
            "rest": self.rest,
            "heat": self.heat,
            "effort": self.largest_effort,
            "idle_effort": self.idle_effort,
            "slow_effort": self.slow_effort,
            "exponent": self.exponent,
        }
        return {name: limit for name, limit in options.items() if limit is not None}

    def limits(self, known: Mapping[str, float], *, pair: bool) -> RigLimits:
        """The limits, over those of a file or a log, over those of a run.

        Args:
            known: limits of a run's rows; empty without a run.
            pair: whether the device is a pair, whose motor turns one way.

        Raises:
            SettingError: a limit is missing, or cannot be.
        """
        from erclutch.errors import SettingError
        from erclutch.wings.design.limits import limits_of, limits_of_file, limits_of_log

        one_way = self.one_way or pair
        kept = {name: limit for name, limit in known.items() if not (one_way and name == "stroke")}
        if self.rig_limits is not None and self.rig_limits.suffix.lower() == ".toml":
            kept |= limits_of_file(self.rig_limits)
        elif self.rig_limits is not None:
            from erclutch.cli.options import LogOptions

            reading = LogOptions(device="coaxial" if pair else None)
            of_log = limits_of_log(reading.dataset(reading.read((self.rig_limits,))))
            if pair:
                of_log.pop("stroke", None)
            kept |= of_log
        if one_way and "stroke" in self.given() | kept:
            raise SettingError(
                "--stroke of a motion that never turns back",
                remedy="Leave out --stroke" + ("" if pair else " or --one-way"),
            )
        return limits_of(self.given(), kept)


NO_LIMITS = LimitOptions()
