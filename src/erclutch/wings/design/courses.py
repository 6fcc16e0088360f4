"""Field and motion are counted in whole ticks, so that the limits hold exactly in the numbers that are written.

A tick is a power of ten with nine digits for the largest number: what a CSV file holds is what was counted. Speed and
field are ticks; the position is the sum of a speed and the next (trapezoid), so in units of half a tick and a period.

A state is *safe* if the rig can still brake at its full acceleration within stroke, heat and time, and bring its field
to zero in time. From a safe state the braking itself is safe, so a stretch that is cut after its last safe row can
always be followed by another one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError
from erclutch.signals.array import Array
from erclutch.wings.design.limits import LINGER, RigLimits, option_of, trailing_largest

Ticks = NDArray[np.int64]
_DIGITS = 9
_FAR = 1 << 61  # ticks: no limit
_FULL = 128  # parts of the largest effort, in which a row's effort is counted
_LEVELS = 128  # of the field felt and of the speed, by which the effort is looked up
#: A limit that lets the field or the speed reach less than this share of its own limit is refused.
_LEAST_SHARE = 0.1


def course(now: int, pieces: Iterable[tuple[int, int, int]], enough: int = _FAR) -> Ticks:
    """Ticks after ``now``: for each piece a straight line to its target by a step a row, then a hold of some rows.

    Args:
        now: where it starts; not part of the course.
        pieces: target, step (above 0) and rows of the hold.
        enough: rows after which no further piece is looked at.
    """
    parts: list[Ticks] = [np.zeros(0, np.int64)]
    count = 0
    for target, step, hold in pieces:
        if count >= enough:
            break
        rows = -(-abs(target - now) // step)
        line = np.empty(rows + hold, np.int64)
        line[:rows] = now + (step if target > now else -step) * np.arange(1, rows + 1)
        line[max(rows - 1, 0) :] = target
        parts.append(line)
        count += line.size
        now = target
    return np.concatenate(parts)


def _ticks_per_unit(largest: float) -> float:
    return 10.0 ** (_DIGITS - 1 - math.floor(math.log10(largest)))


def _below(limit: float) -> int:
    """Whole ticks that stay below a limit by a tick, which is more than the rounding of a float can add."""
    return _FAR if limit >= _FAR else math.floor(limit) - 1


@dataclass(frozen=True)
class Bounds:
    """The limits of a rig in ticks, for a rate and a number of rows.

    Attributes:
        rows: of the whole sequence.
        rest: rows of rest at the start and at the end.
        field, field_step: largest field, and its largest change in a row.
        speed, speed_step: the same of the speed.
        half_stroke: from the middle, in half ticks times a period.
        heat: sum over the sequence of the speeds' sizes times the parts of the largest effort.
        parts: of the largest effort that the device may give, shape (levels of the field felt, levels of the speed).
        linger: rows over which the device may feel a field that is gone.
        field_ticks, speed_ticks, position_ticks: ticks in a unit.
        notes: limits that another limit keeps from being reached.
    """

    rows: int
    rest: int
    field: int
    field_step: int
    speed: int
    speed_step: int
    half_stroke: int
    heat: int
    parts: Ticks
    linger: int
    field_ticks: float
    speed_ticks: float
    position_ticks: float
    notes: tuple[str, ...]

    @property
    def heat_is_limited(self) -> bool:
        """Whether the rig's mean power has a limit."""
        return self.heat < _FAR - 1

    @staticmethod
    def of(limits: RigLimits, rate: float, seconds: float) -> Bounds:
        """The limits as ticks.

        Raises:
            SettingError: the limits leave no sequence; it names the limit that forbids.
        """
        rows = round(rate * seconds)
        rest = math.ceil(limits.rest * rate)
        moving = (rows - 2 * rest - 2) / rate  # s
        if moving < 20 / rate:
            raise SettingError(
                f"--rest {limits.rest:g} at the start and at the end of {seconds:g} s leaves no time",
                remedy="Give more --seconds or less --rest",
            )
        notes: list[str] = []
        speeds = {
            "acceleration": 0.5 * limits.acceleration * moving,
            "stroke": math.sqrt(limits.acceleration * limits.stroke),
        }
        speed = _reached("speed", limits.speed, speeds, notes)
        heat = math.inf  # speed x rows, at the largest effort
        without_field = math.inf
        if limits.heat < math.inf:
            heat = limits.heat / limits.effort * rows
            idle = max(limits.idle_effort, limits.effort / _FULL)
            without_field = heat * max(1.0, limits.effort / idle)
        # A speed that is held for a single row still costs its braking: the heat of the way up and down.
        by_heat = math.sqrt(without_field * limits.acceleration / rate)
        speed = _reached("speed", speed, {"heat": by_heat}, notes)
        by_rate = 0.5 * limits.field_rate * moving  # up, and down again
        field = _reached("field", limits.field, {"field_rate": by_rate}, notes)
        # Parts of the largest effort by level of the field felt and of the speed, each rounded up.
        parts = np.full((_LEVELS + 1, _LEVELS + 1), _FULL, np.int64)
        if limits.effort < math.inf:
            levels = np.arange(_LEVELS + 1) / _LEVELS
            of_speed = speed / limits.speed * levels  # shares of the largest speed
            efforts = limits.effort_at(levels[:, None], of_speed)
            parts = np.clip(np.ceil(_FULL * efforts / limits.effort), 1, _FULL).astype(np.int64)
        field_ticks = _ticks_per_unit(field)
        speed_ticks = _ticks_per_unit(speed)
        position_ticks = 2.0 * rate * speed_ticks
        bounds = Bounds(
            rows=rows,
            rest=rest,
            field=_below(field * field_ticks),
            field_step=_below(limits.field_rate / rate * field_ticks),
            speed=_below(speed * speed_ticks),
            speed_step=_below(limits.acceleration / rate * speed_ticks),
            half_stroke=_below(0.5 * limits.stroke * position_ticks * (1.0 - 1e-8)),
            heat=_below(_FULL * heat * speed_ticks * (1.0 - 1e-9)),
            parts=parts,
            linger=math.ceil(LINGER * rate),
            field_ticks=field_ticks,
            speed_ticks=speed_ticks,
            position_ticks=position_ticks,
            notes=tuple(notes),
        )
        if bounds.half_stroke < 4 * bounds.speed_step:
            raise SettingError(
                f"--stroke {limits.stroke:g} is passed within two rows at {rate:g} rows a second",
                remedy="Give a higher --rate, or less --acceleration",
            )
        return bounds


def _reached(
    what: str,
    asked: float,
    allowed: dict[str, float],
    notes: list[str],
) -> float:
    """What of a limit the others let the rig reach.

    Raises:
        SettingError: less than a tenth.
    """
    name, most = min(allowed.items(), key=lambda pair: pair[1])
    if most >= asked:
        return asked
    option = option_of(name)
    if most < _LEAST_SHARE * asked:
        raise SettingError(
            f"{option} lets the {what} reach {most:.3g} of {asked:g}",
            remedy=f"Give more {option}, more --seconds, or a smaller {option_of(what)}",
        )
    notes.append(f"the {what} reaches {most:.3g} of {asked:g}: {option} forbids more")
    return most


class GrowingSequence:
    """A sequence that grows by stretches; each row of it is safe.

    Attributes:
        bounds: the limits.
        rows: how many are there.
        field, speed, position: at the last row, in ticks.
    """

    def __init__(self, bounds: Bounds) -> None:
        self.bounds = bounds
        self.rows = self.field = self.speed = self.position = self._heat = 0
        self._felt = np.zeros(bounds.linger, np.int64)  # sizes of the last fields
        self._fields: list[Ticks] = []
        self._speeds: list[Ticks] = []
        still = np.zeros(bounds.rest + 1, np.int64)
        self.append(still, still)

    @property
    def left(self) -> int:
        """Rows until the last rest, which begins with a row at zero."""
        return self.bounds.rows - self.bounds.rest - self.rows

    def safe(self, fields: Ticks, speeds: Ticks) -> int:
        """How many of further rows are safe, from the first one on."""
        bounds = self.bounds
        number = min(fields.size, speeds.size, self.left)
        speed = speeds[:number]
        speed_before = np.concatenate([[self.speed], speed[:-1]])
        size = np.abs(speed)
        step = bounds.speed_step
        fine = size <= bounds.speed
        fine &= np.abs(speed - speed_before) <= step

        field = fields[:number]
        field_before = np.concatenate([[self.field], field[:-1]])
        fine &= np.abs(field) <= bounds.field
        fine &= np.abs(field - field_before) <= bounds.field_step

        # Braking from here must end within the stroke, the heat and the time.
        braking = size // step  # rows of full braking before the last
        # Sum of the speeds until rest.
        way = (braking + 1) * size - step * (braking * (braking + 1) // 2)
        done = self.rows + np.arange(1, number + 1)
        if bounds.half_stroke < _FAR - 1:
            position = self.position + np.cumsum(speed + speed_before)
            at_rest = position + np.sign(speed) * (2 * way - size)
            fine &= np.abs(at_rest) <= bounds.half_stroke
        if bounds.heat_is_limited:
            share = np.minimum(1.0, 0.15 + done / bounds.rows)  # not all of it at the start
            parts = self._parts(field, size)
            heat_at_rest = self._heat + np.cumsum(size * parts) + way * parts
            fine &= heat_at_rest <= np.floor(share * bounds.heat)
        remaining = bounds.rows - bounds.rest - done
        fine &= -(-size // step) <= remaining
        fine &= -(-np.abs(field) // bounds.field_step) <= remaining
        return number if fine.all() else int(np.argmin(fine))

    def _parts(self, fields: Ticks, sizes: Ticks) -> Ticks:
        """Parts of the largest effort that the device may give in further rows.

        Args:
            fields: of the rows; the largest field counts that the device may still feel.
            sizes: of the rows' speeds.
        """
        bounds = self.bounds
        if not bounds.heat_is_limited:
            return np.full(fields.size, _FULL, np.int64)
        sizes_of_fields = np.concatenate([self._felt, np.abs(fields)])
        felt = trailing_largest(sizes_of_fields, bounds.linger)[bounds.linger :]
        field_level = np.minimum(-(-_LEVELS * felt // bounds.field), _LEVELS)  # rounded up
        speed_level = np.minimum(-(-_LEVELS * sizes // bounds.speed), _LEVELS)
        return bounds.parts[field_level, speed_level]

    def cost(self, fields: Ticks, speeds: Ticks) -> float:
        """What a stretch takes of the time that is left, and of the heat that is left.

        As a share of the whole heat it would be as dear where much of that heat will stay unused.
        """
        sizes = np.abs(speeds)
        heat = float((sizes * self._parts(fields, sizes)).sum())
        heat_left = max(1, self.bounds.heat - self._heat)
        return speeds.size / self.left + heat / heat_left

    def stop(self, hold: int = 0) -> tuple[Ticks, Ticks]:
        """Field and speed to zero as fast as may be, and some rows there; always safe, but for the rows of the hold."""
        if not self.field and not self.speed:
            still = np.zeros(max(hold, 1), np.int64)
            return still, still
        field_step = min(self.bounds.field_step, self.bounds.field)
        fields = course(self.field, [(0, field_step, hold)])
        speeds = course(self.speed, [(0, self.bounds.speed_step, hold)])
        rows = max(fields.size, speeds.size, 1)
        return _held(fields, rows), _held(speeds, rows)

    def append(self, fields: Ticks, speeds: Ticks) -> None:
        """Add rows that are safe."""
        if not speeds.size:
            return
        before = np.concatenate([[self.speed], speeds[:-1]])
        self.position += int((speeds + before).sum())
        sizes = np.abs(speeds)
        if sizes.any():
            self._heat += int((sizes * self._parts(fields, sizes)).sum())
        felt = np.concatenate([self._felt, np.abs(fields)])[fields.size :]
        self._felt = felt[-self.bounds.linger :]
        self.field = int(fields[-1])
        self.speed = int(speeds[-1])
        self.rows += speeds.size
        self._fields.append(fields)
        self._speeds.append(speeds)

    def last(self, rows: int) -> tuple[Ticks, Ticks]:
        """Field and speed of the last rows, as many of so many as there are."""
        # Pieces of both are of the same lengths.
        first = len(self._speeds) - 1
        count = self._speeds[first].size
        while first > 0 and count < rows:
            first -= 1
            count += self._speeds[first].size
        fields = np.concatenate(self._fields[first:])
        speeds = np.concatenate(self._speeds[first:])
        return fields[-rows:], speeds[-rows:]

    def end(self) -> Commands:
        """The whole sequence: what is still moving stops, and rests to the end."""
        if self.field or self.speed:
            self.append(*self.stop())
        still = np.zeros(self.bounds.rows - self.rows, np.int64)
        self.append(still, still)
        bounds = self.bounds
        fields = np.concatenate(self._fields)
        speeds = np.concatenate(self._speeds)
        speeds_before = np.concatenate([[0], speeds[:-1]])
        position: Array = np.cumsum(speeds + speeds_before) / bounds.position_ticks
        farthest = float(np.abs(position).max(initial=0.0))
        if farthest > 0.0:
            # Rounded to what a CSV file holds; the half stroke is smaller by more than this rounding.
            tens = _ticks_per_unit(farthest)
            position = np.rint(position * tens) / tens
        return Commands(fields / bounds.field_ticks, speeds / bounds.speed_ticks, position)


def _held(ticks: Ticks, rows: int) -> Ticks:
    """A course to which its last value, zero, is added until it has so many rows."""
    return np.concatenate([ticks, np.zeros(rows - ticks.size, np.int64)])


@dataclass(frozen=True)
class Commands:
    """References for a rig, a row a period.

    Attributes:
        field: field; of a pair signed, positive for the first clutch; shape (n,).
        speed: slip; of a pair the speed of the motor; shape (n,).
        position: its integral from the middle, by trapezoids; shape (n,).
    """

    field: Array
    speed: Array
    position: Array
