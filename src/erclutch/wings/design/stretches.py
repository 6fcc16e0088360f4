"""Stretches of field and motion are drawn at random: they are what a sequence is put together from.

Each kind shows something that another hides: steps of the field show the lag, slow turns the memory, a field of zero
the friction, and fields and slips that are held the law.
"""

from __future__ import annotations

import math

import numpy as np

from erclutch.wings.design.courses import Bounds, GrowingSequence, Ticks, course

#: s; a stretch is at most so long, or as long as the rig needs to reach its speed.
_LONGEST = 0.6
_SHORTEST_HOLD = 0.005  # s, of a field between two switches
_LONGEST_HOLD = 0.25  # s
_WEAK = 0.25  # share of the stretches that are weak, where heat is limited
_WEAKEST = 0.05  # share of the largest field that a weak stretch stays within
_SLOW = 0.05  # share of the largest speed that slow turns stay within

Piece = tuple[int, int, int]


class StretchMaker:
    """Draws stretches that may follow a sequence; they are not yet cut to what is safe.

    Attributes:
        sequence: that they follow.
        bounds: its limits.
        rows: of a stretch.
    """

    def __init__(
        self,
        sequence: GrowingSequence,
        rng: np.random.Generator,
        rate: float,
        *,
        signed: bool,
        one_way: bool,
    ) -> None:
        """Draw for a sequence.

        Args:
            sequence: that the stretches follow.
            rng: random numbers.
            rate: rows a second.
            signed: whether the field has two signs: that of a pair.
            one_way: whether the motion has one direction.
        """
        self.sequence = sequence
        self.bounds = bounds = sequence.bounds
        self._rng = rng
        self._rate = rate
        self._signed = signed
        self._one_way = one_way
        self._most = bounds.field  # of the stretch that is drawn
        to_largest_speed = 1.5 * bounds.speed / bounds.speed_step  # rows
        moving = bounds.rows - 2 * bounds.rest  # rows
        longest = max(_LONGEST * rate, to_largest_speed)
        self.rows = max(8, round(min(longest, moving / 8)))

    def draw(self) -> tuple[Ticks, Ticks]:
        """Field and speed of one stretch, of a kind that is drawn too."""
        kind = self._rng.random()
        self._most = self.bounds.field
        if self.bounds.heat_is_limited and self._rng.random() < _WEAK:
            # A mean power lets the rig turn fast only where the field is weak.
            share_of_field = _WEAKEST ** self._rng.random()
            self._most = max(1, round(self.bounds.field * share_of_field))
        share = float(self._rng.uniform(0.3, 1.0))
        rows = max(8, round(share * self.rows))
        if kind < 0.45:
            fields = self._switches()
            speeds = self._moves(rows)
        elif kind < 0.65:
            fields = self._triangles()
            speeds = self._moves(rows)
        elif kind < 0.85:
            fields = [(self._level(), self._field_step(), rows)]
            speeds = self._slow_turns()
        else:  # without field: the friction
            fields = [(0, self._field_step(), rows)]
            speeds = self._moves(rows)
        now = self.sequence
        return self._cut(now.field, fields, rows), self._cut(now.speed, speeds, rows)

    @staticmethod
    def _cut(now: int, pieces: list[Piece], rows: int) -> Ticks:
        """A course of so many rows; where it is shorter its last value is held."""
        ticks = course(now, pieces, rows)[:rows]
        last = int(ticks[-1]) if ticks.size else now
        return np.concatenate([ticks, np.full(rows - ticks.size, last, np.int64)])

    def _level(self) -> int:
        """A field; each eighth is the largest, each eighth zero."""
        choice = self._rng.random()
        if choice < 0.125:
            size = 0
        elif choice < 0.875:
            size = round(self._most * self._rng.random())
        else:
            size = self._most
        negative = self._signed and self._rng.random() < 0.5
        return -size if negative else size

    def _field_step(self) -> int:
        return min(self.bounds.field_step, 2 * self.bounds.field)

    def _dwell(self) -> int:
        """Rows of a hold, drawn evenly over the logarithm."""
        logarithm = self._rng.uniform(math.log(_SHORTEST_HOLD), math.log(_LONGEST_HOLD))
        return max(1, round(math.exp(logarithm) * self._rate))

    def _switches(self) -> list[Piece]:
        """Steps of the field as fast as the supply allows, each held for another time."""
        return [(self._level(), self._field_step(), self._dwell()) for _ in range(6)]

    def _triangles(self) -> list[Piece]:
        """The field rises and falls evenly, each time at another rate."""
        pieces: list[Piece] = []
        for _ in range(4):
            rows = max(2, self._dwell())  # from the largest field on one side to that on the other
            step = max(1, 2 * self.bounds.field // rows)
            rise = min(step, self._field_step())
            pieces.append((self._level(), rise, 0))
        return pieces

    def _acceleration(self) -> int:
        """A step of the speed, from a fiftieth of the acceleration to all of it."""
        share = 10.0 ** self._rng.uniform(-1.7, 0.0)
        return max(1, int(self.bounds.speed_step * share))

    def _speed(self) -> int:
        """A speed; many are low, where the law bends, and each eighth is the largest."""
        largest = self._rng.random() < 0.125
        share = 1.0 if largest else self._rng.random() ** 1.5
        size = round(self.bounds.speed * share)
        ahead = self._one_way or self._rng.random() < 0.5
        return size if ahead else -size

    def _moves(self, rows: int) -> list[Piece]:
        """Speeds that are gone to at a constant acceleration, and held for a while."""
        pieces: list[Piece] = []
        for _ in range(3):
            target = self._speed()
            step = self._acceleration()
            hold = round(rows * self._rng.uniform(0.0, 0.5))
            pieces.append((target, step, hold))
        return pieces

    def _slow_turns(self) -> list[Piece]:
        """Slowly through zero and back several times: what a memory of the slip shows in."""
        share = _SLOW * 10.0 ** self._rng.uniform(-1.0, 0.0)
        size = max(1, round(self.bounds.speed * share))
        rows = max(2, self._dwell())  # of the way to that speed
        step = min(self.bounds.speed_step, max(1, size // rows))
        start = (size, self.bounds.speed_step, 0)
        back = 0 if self._one_way else -size
        return [start, *[(back, step, 0), (size, step, 0)] * 4]


class PaperStretches:
    """Draws stretches as section III-B draws its sequence: the field changes nearly all the time."""

    def __init__(
        self,
        maker: StretchMaker,
        rng: np.random.Generator,
        rate: float,
        *,
        signed: bool,
        one_way: bool,
    ) -> None:
        """Draw stretches as long as those of a maker, for its sequence."""
        self._maker = maker
        self._rng = rng
        self._rate = rate
        self._one_way = one_way
        self._fields = fields_of_paper(maker.bounds, rng, rate, signed=signed)

    def draw(self) -> tuple[Ticks, Ticks]:
        """Field and speed of one stretch, not yet cut to what is safe."""
        now = self._maker.sequence
        bounds = self._maker.bounds
        rows = max(8, round(float(self._rng.uniform(0.3, 1.0)) * self._maker.rows))
        start = int(self._rng.integers(0, max(1, self._fields.size - rows)))
        fields = followed(now.field, self._fields[start : start + rows], bounds.field_step)
        lowest, highest = frequencies_of_paper(self._rate)
        speeds = np.zeros(0, np.int64)
        while speeds.size < fields.size:
            last = int(speeds[-1]) if speeds.size else now.speed
            piece = pieces_of_paper(
                bounds,
                self._rng,
                self._rate,
                one_way=self._one_way,
                lowest=lowest,
                highest=highest,
            )
            speeds = np.concatenate([speeds, course(last, [piece])])
        return fields, speeds[: fields.size]


def frequencies_of_paper(rate: float) -> tuple[float, float]:
    """Lowest and highest frequency of the draws of section III-B in Hz, as far as the rate has them."""
    highest = min(100.0, rate / 4.0)
    return min(2.0, 0.5 * highest), highest


def fields_of_paper(
    bounds: Bounds, rng: np.random.Generator, rate: float, *, signed: bool
) -> Ticks:
    """The random squares and sines of field of section III-B, for the rows of a sequence."""
    from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence

    lowest, highest = frequencies_of_paper(rate)
    settings = FieldSettings(lowest=lowest, highest=highest)
    drawn = field_sequence(bounds.rows, rng, settings, rate) / settings.largest
    fields = np.rint(drawn * bounds.field).astype(np.int64)
    return fields if signed else np.abs(fields)


def followed(now: int, wanted: Ticks, step: int) -> Ticks:
    """A wanted course of the field as a supply of limited rate follows it."""
    if wanted.size == 0 or np.abs(np.diff(wanted, prepend=now)).max() <= step:
        return wanted
    reached = np.empty_like(wanted)
    for row, target in enumerate(wanted.tolist()):
        now = min(max(target, now - step), now + step)
        reached[row] = now
    return reached


def pieces_of_paper(
    bounds: Bounds,
    rng: np.random.Generator,
    rate: float,
    *,
    one_way: bool,
    lowest: float = 2.0,
    highest: float = 100.0,
) -> Piece:
    """One half period of a random square of speed, as section III-B draws its torques."""
    half_period = rng.uniform(0.5 / highest, 0.5 / lowest)  # s
    hold = max(1, round(half_period * rate))
    share = rng.uniform(0.0 if one_way else -1.0, 1.0)
    return round(bounds.speed * share), bounds.speed_step, hold
