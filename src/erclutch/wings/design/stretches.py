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
_SHORTEST_HOLD, _LONGEST_HOLD = 0.005, 0.25  # s, of a field between two switches
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
        self, sequence: GrowingSequence, rng: np.random.Generator, rate: float, *, signed: bool, one_way: bool
    ) -> None:
        """Draw for a sequence.

        Args:
            sequence: that the stretches follow.
            rng: random numbers.
            rate: rows a second.
            signed: whether the field has two signs: that of a pair.
            one_way: whether the motion has one direction.
        """
        self.sequence, self.bounds, self._rng, self._rate = sequence, sequence.bounds, rng, rate
        self._signed, self._one_way = signed, one_way
        reach = 1.5 * self.bounds.speed / self.bounds.speed_step  # rows, to the largest speed
        moving = self.bounds.rows - 2 * self.bounds.rest
        self.rows = max(8, round(min(max(_LONGEST * rate, reach), moving / 8)))

    def draw(self) -> tuple[Ticks, Ticks]:
        """Field and speed of one stretch, of a kind that is drawn too."""
        kind = self._rng.random()
        share = float(self._rng.uniform(0.3, 1.0))
        rows = max(8, round(share * self.rows))
        if kind < 0.45:
            fields, speeds = self._switches(), self._moves(rows)
        elif kind < 0.65:
            fields, speeds = self._triangles(), self._moves(rows)
        elif kind < 0.85:
            fields, speeds = [(self._level(), self._field_step(), rows)], self._slow_turns()
        else:
            fields, speeds = [(0, self._field_step(), rows)], self._moves(rows)
        return self._cut(self.sequence.field, fields, rows), self._cut(self.sequence.speed, speeds, rows)

    @staticmethod
    def _cut(now: int, pieces: list[Piece], rows: int) -> Ticks:
        """A course of so many rows; where it is shorter its last value is held."""
        ticks = course(now, pieces)[:rows]
        last = int(ticks[-1]) if ticks.size else now
        return np.concatenate([ticks, np.full(rows - ticks.size, last, np.int64)])

    def _level(self) -> int:
        """A field; each eighth is the largest, each eighth zero."""
        choice = self._rng.random()
        size = 0 if choice < 0.125 else self.bounds.field
        if 0.125 <= choice < 0.875:
            size = round(self.bounds.field * self._rng.random())
        return -size if self._signed and self._rng.random() < 0.5 else size

    def _field_step(self) -> int:
        return min(self.bounds.field_step, 2 * self.bounds.field)

    def _dwell(self) -> int:
        """Rows of a hold, drawn evenly over the logarithm."""
        low, high = math.log(_SHORTEST_HOLD), math.log(_LONGEST_HOLD)
        return max(1, round(math.exp(self._rng.uniform(low, high)) * self._rate))

    def _switches(self) -> list[Piece]:
        """Steps of the field as fast as the supply allows, each held for another time."""
        return [(self._level(), self._field_step(), self._dwell()) for _ in range(6)]

    def _triangles(self) -> list[Piece]:
        """The field rises and falls evenly, each time at another rate."""
        pieces: list[Piece] = []
        for _ in range(4):
            slowly = max(1, 2 * self.bounds.field // max(2, self._dwell()))
            pieces.append((self._level(), min(slowly, self._field_step()), 0))
        return pieces

    def _acceleration(self) -> int:
        """A step of the speed, from a fiftieth of the acceleration to all of it."""
        return max(1, int(self.bounds.speed_step * 10.0 ** self._rng.uniform(-1.7, 0.0)))

    def _speed(self) -> int:
        """A speed; many are low, where the law bends, and each eighth is the largest."""
        size = 1.0 if self._rng.random() < 0.125 else self._rng.random() ** 1.5
        ahead = self._one_way or self._rng.random() < 0.5
        return round(self.bounds.speed * size) * (1 if ahead else -1)

    def _moves(self, rows: int) -> list[Piece]:
        """Speeds that are gone to at a constant acceleration, and held for a while."""
        return [(self._speed(), self._acceleration(), round(rows * self._rng.uniform(0.0, 0.5))) for _ in range(3)]

    def _slow_turns(self) -> list[Piece]:
        """Slowly through zero and back several times: what a memory of the slip shows in."""
        size = max(1, round(self.bounds.speed * _SLOW * 10.0 ** self._rng.uniform(-1.0, 0.0)))
        step = min(self.bounds.speed_step, max(1, size // max(2, self._dwell())))
        near = (size, self.bounds.speed_step, 0)
        back = 0 if self._one_way else -size
        return [near, *((target, step, 0) for _ in range(4) for target in (back, size))]


def pieces_of_paper(
    bounds: Bounds, rng: np.random.Generator, rate: float, *, one_way: bool, lowest: float = 2.0, highest: float = 100.0
) -> Piece:
    """One half period of a random square of speed, as section III-B draws its torques."""
    hold = max(1, round(rng.uniform(0.5 / highest, 0.5 / lowest) * rate))
    target = round(bounds.speed * rng.uniform(0.0 if one_way else -1.0, 1.0))
    return target, bounds.speed_step, hold
