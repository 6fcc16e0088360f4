"""What a rig may do, given or read from a file or a log: field, speed, acceleration, stroke, rests and heat."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError
from erclutch.files.given_files import plain_words, small_file, toml_of
from erclutch.signals.array import Array, largest_size

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset

_Number = TypeVar("_Number", np.int64, np.float64)
DeviceKind = Literal["brake", "clutch", "damper", "pair"]
#: The numbers of a limits file, in SI units, with the smallest and the largest that make sense.
RANGES: Mapping[str, tuple[float, float]] = {
    "field": (1e-6, 1e9),
    "field_rate": (1e-6, math.inf),
    "speed": (1e-6, 1e6),
    "acceleration": (1e-6, 1e9),
    "stroke": (1e-6, math.inf),
    "rest": (0.0, 3600.0),
    "heat": (1e-9, math.inf),
    "effort": (1e-9, math.inf),
    "idle_effort": (0.0, math.inf),
    "slow_effort": (0.0, math.inf),
    "exponent": (0.05, 20.0),
}
_OPTIONS = {"field": "--largest", "effort": "--largest-effort"}
_NEEDED = ("field", "speed", "acceleration")
#: Of the differences of a logged slip: sensor noise makes the largest ones.
_SURE = 0.99
_OVER = 0.01  # s, over which the acceleration of a log is taken
#: s; a device feels the largest field of so long ago, at most.
LINGER = 0.05
_WEAK = 0.125  # share of the largest field below which an effort is that without field
_CELLS = (8, 4)  # over the field felt and over the speed, in which a log's efforts are averaged
_EXPONENTS = (0.05, 4.0)  # that a log may say
_NEARLY_ALL = 0.999  # of the largest field, whose logarithm is not zero
_FEW = 1e-3  # share of a log's rows, below which a cell says nothing


def option_of(name: str) -> str:
    """The option of the command line that sets a limit."""
    return _OPTIONS.get(name, f"--{name.replace('_', '-')}")


@dataclass(frozen=True)
class RigLimits:
    """Limits of a rig, in SI units.

    Attributes:
        field: largest field, in the unit of the log's field; the smallest is 0.
        field_rate: how fast the field may change, field unit/s.
        speed: largest slip to either side, rad/s or m/s; of a pair the speed of the motor.
        acceleration: largest change of that speed, rad/s^2 or m/s^2.
        stroke: from end to end, rad or m; the motion begins in the middle.
        rest: time without field and motion at the start and at the end, s.
        heat: largest mean power over the sequence, W: effort times slip.
        effort: effort that the device never exceeds, N m or N; needed for the heat.
        idle_effort: the same without field, at the largest speed.
        slow_effort: the same without field, at rest.
        exponent: how the effort grows from there to the largest: by the share of the largest field to this power.
    """

    field: float
    speed: float
    acceleration: float
    field_rate: float = math.inf
    stroke: float = math.inf
    rest: float = 0.5
    heat: float = math.inf
    effort: float = math.inf
    idle_effort: float = math.inf
    slow_effort: float = math.inf
    exponent: float = 1.0

    def __post_init__(self) -> None:
        for name, (low, high) in RANGES.items():
            limit = getattr(self, name)
            if not low <= limit <= high:
                allowed = f"{low:g} or more" if high == math.inf else f"{low:g} to {high:g}"
                raise SettingError(f"{option_of(name)} {limit:g}", remedy=f"Give {allowed}")
        if self.heat < math.inf and self.effort == math.inf:
            raise SettingError(
                f"--heat {self.heat:g} without an effort", remedy="Give --largest-effort"
            )

    def effort_at(self, field: Array, speed: Array) -> Array:
        """The effort that the heat counts, N m or N, where a field is felt at a speed.

        Args:
            field: share of the largest field.
            speed: share of the largest speed.
        """
        idle = min(self.idle_effort, self.effort)
        slow = min(self.slow_effort, idle)
        without_field = slow + (idle - slow) * speed
        return without_field + (self.effort - without_field) * field**self.exponent

    def line(self, motion_unit: str, field_unit: str) -> str:
        """The limits as one line for people."""
        words = [
            f"field 0 .. {self.field:g} {field_unit}".rstrip(),
            f"speed +-{self.speed:g} {motion_unit}/s",
            f"acceleration {self.acceleration:g} {motion_unit}/s^2",
        ]
        further = (
            ("field rate", self.field_rate, f"{field_unit or 1}/s"),
            ("stroke", self.stroke, motion_unit),
            ("mean power", self.heat, "W"),
        )
        words += [f"{name} {limit:g} {unit}" for name, limit, unit in further if limit < math.inf]
        return ", ".join(words)


def limits_of(given: Mapping[str, float | None], known: Mapping[str, float]) -> RigLimits:
    """Limits from options, over those of a file or a log.

    Raises:
        SettingError: the field, speed or acceleration is missing, or a limit is outside its range.
    """
    merged = dict(known)
    merged.update({name: limit for name, limit in given.items() if limit is not None})
    missing = [name for name in _NEEDED if name not in merged]
    if missing:
        options = " ".join(f"{option_of(name)} NUMBER" for name in missing)
        verb = "is" if len(missing) == 1 else "are"
        raise SettingError(
            f"the rig's {' and '.join(missing)} {verb} not known",
            remedy=f"Give {options}, or --rig-limits with a TOML file or a log",
        )
    return RigLimits(**merged)


def limits_of_file(path: Path) -> dict[str, float]:
    """The table ``[limits]`` of a TOML file: numbers named as the attributes of `RigLimits`.

    Raises:
        SettingError: no such file, no such table, or a name or a number that cannot be.
    """
    where = str(path)
    try:
        body = toml_of(small_file(path))
    except (OSError, ValueError, RecursionError) as error:
        raise SettingError(
            plain_words(error), where=where, remedy="Give a TOML file with a table [limits]"
        ) from error
    table: Any = body.get("limits")
    known = [field.name for field in fields(RigLimits)]
    if not isinstance(table, dict):
        raise SettingError(
            "it has no table [limits]", where=where, remedy=f"Write one with {', '.join(known)}"
        )
    limits: dict[str, float] = {}
    for name, limit in table.items():  # pyright: ignore[reportUnknownVariableType]
        if name not in known:
            raise SettingError(
                f"[limits] has {name!r}", where=where, remedy=f"Names are {', '.join(known)}"
            )
        if isinstance(limit, bool) or not isinstance(limit, int | float):
            raise SettingError(
                f"{name} = {limit!r}", where=where, remedy="Give a number in SI units"
            )
        limits[name] = float(limit)
    return limits


def limits_of_log(data: Dataset) -> dict[str, float]:
    """What the rig did in a log, it may do again: the largest field and its rate, speed, acceleration, stroke, power.

    The stroke is taken where the motion keeps coming back: its way is less than half of what the speed would run.
    """
    slip = data.elements[0].slip
    fields_of = [element.field for element in data.elements]
    period = data.period  # s
    over = max(1, round(_OVER / period))  # rows
    accelerations: list[float] = []  # of each span
    field_rates: list[float] = []
    ways: list[float] = []
    for span in data.clock.spans:
        rows = slice(span.start, span.stop)
        in_span = slip[rows]
        if in_span.size > over:
            change = np.abs(in_span[over:] - in_span[:-over]) / (over * period)
            accelerations.append(float(np.quantile(change, _SURE)))
        way = np.cumsum(in_span) * period
        ways.append(float(np.ptp(way)))
        for field in fields_of:
            steps = np.abs(np.diff(field[rows]))
            largest_step = float(steps.max(initial=0.0))
            field_rates.append(largest_step / period)

    limits = {
        "field": max(float(field.max()) for field in fields_of),
        "field_rate": max(field_rates),
        "speed": largest_size(slip),
        "acceleration": max(accelerations, default=0.0),
        "heat": float(np.mean(np.abs(data.effort * slip))),
        "effort": largest_size(data.effort),
    }
    limits |= _effort_by_field_and_speed(data, limits)
    usual_speed = float(np.mean(np.abs(slip)))
    way_at_speed = usual_speed * data.duration
    if max(ways) < 0.5 * way_at_speed:
        limits["stroke"] = max(ways)
    return {name: limit for name, limit in limits.items() if limit > 0.0}


def _effort_by_field_and_speed(data: Dataset, limits: Mapping[str, float]) -> dict[str, float]:
    """Effort without field at the largest speed and at rest, and the exponent: no cell of a log has a larger mean.

    The heat is a mean power, so means count: a rotor that rings lifts single rows alone.
    """
    largest = limits["effort"]

    # Cells over the share of the largest field that is felt, and over the share of the largest speed.
    field = np.max(np.abs([element.field for element in data.elements]), axis=0)
    felt = trailing_largest(field, round(LINGER / data.period)) / (limits["field"] or 1.0)
    speed = np.abs(data.elements[0].slip) / (limits["speed"] or 1.0)
    along_field, along_speed = _CELLS
    cell = np.minimum(felt * along_field, along_field - 1).astype(int) * along_speed
    cell += np.minimum(speed * along_speed, along_speed - 1).astype(int)
    rows = np.bincount(cell, minlength=along_field * along_speed)
    enough = rows > _FEW * field.size

    def means(values: Array) -> Array:
        """The mean in each cell of enough rows."""
        return np.bincount(cell, values, rows.size)[enough] / rows[enough]

    fields = means(felt)
    speeds = means(speed)
    efforts = means(np.abs(data.effort))
    weak = fields < _WEAK
    if not weak.any() or largest <= 0.0:
        return {"idle_effort": largest, "slow_effort": largest}

    # Without field: a line through the slowest cell, as steep as the steepest way from there to another one.
    least = 1e-3 * largest
    weak_speeds = np.where(weak, speeds, np.inf)
    slowest = int(np.argmin(weak_speeds))
    slow = max(float(efforts[slowest]), least)
    slopes = (efforts[weak] - slow) / np.maximum(speeds[weak], _WEAK)
    steepest = max(float(slopes.max()), 0.0)
    idle = min(slow + steepest, largest)
    if data.device == "coaxial":
        # Nobody commands the output of a pair: at the whole power of its log it would be driven into its ends.
        return {"idle_effort": idle}

    # Under a field: the largest power of the field's share that leaves no cell above.
    without_field = slow + (idle - slow) * speeds[~weak]
    shares = (efforts[~weak] - without_field) / np.maximum(largest - without_field, least)
    above = shares > 0.0
    if not above.any():
        return {"idle_effort": idle, "slow_effort": slow}
    shares_above = np.minimum(shares[above], 1.0)
    fields_above = np.minimum(fields[~weak][above], _NEARLY_ALL)
    powers = np.log(shares_above) / np.log(fields_above)
    exponent = float(np.clip(powers.min(), *_EXPONENTS))
    return {"idle_effort": idle, "slow_effort": slow, "exponent": exponent}


def trailing_largest(values: NDArray[_Number], rows: int) -> NDArray[_Number]:
    """The largest of each value and so many values before it, of values that are not negative."""
    largest = values.copy()
    seen = 1  # values that each of the largest has seen, itself among them
    while seen <= rows:
        further = min(seen, rows + 1 - seen)
        largest[further:] = np.maximum(largest[further:], largest[:-further])
        seen += further
    return largest
