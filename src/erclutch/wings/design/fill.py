"""A sequence without a model: it fills the space of field, slip and their rates as evenly as the limits allow.

Of some stretches that may come next the one is taken that adds most to the sum of log(1 + rows) over the cells of that
space, for what it takes of the time and of the heat. This is the D-optimal design, made greedily, of a model that has
one number for each cell. Sources: Fedorov and Hackl 1997, doi:10.1007/978-1-4612-0703-0 (designs made by exchange);
Pronzato and Mueller 2012, doi:10.1007/s11222-011-9242-3 (designs that fill a space).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array
from erclutch.wings.design.courses import Bounds, Commands, GrowingSequence, Ticks, course
from erclutch.wings.design.limits import RigLimits
from erclutch.wings.design.stretches import (
    PaperStretches,
    StretchMaker,
    fields_of_paper,
    followed,
    frequencies_of_paper,
    pieces_of_paper,
)

#: Cells along the field and along the slip; of the field zero has one more, and a pair has them on both sides.
FIELD_CELLS = 8
SLIP_CELLS = 8
#: Cells of the rates: field and slip each fall, are steady or rise.
_RATE_CELLS = 9
_STEADY = 0.02  # share of the fastest rate below which a field or a slip is steady
_FAST = 2.0  # rates of a field that may step: from zero to the largest in so many milliseconds
_CANDIDATES = 24
_SHORT = 64  # parts of a stretch; one of them may be all that is safe

Cells = NDArray[np.intp]
#: Field and speed of some rows.
Stretch = tuple[Ticks, Ticks]


class Worth(Protocol):
    """What stretches of field and speed are worth that may follow a sequence."""

    def gains(self, sequence: GrowingSequence, offers: Sequence[Stretch]) -> list[float]:
        """What each stretch would add."""
        ...

    def take(self, sequence: GrowingSequence, stretch: Stretch) -> None:
        """The stretch will be added."""
        ...


class CellCounts:
    """Rows in the cells of field, slip, and whether each of the two rises, falls or is steady."""

    def __init__(
        self,
        bounds: Bounds,
        rate: float,
        *,
        signed: bool,
        one_way: bool,
    ) -> None:
        self._bounds = bounds
        self._signed = signed
        self._one_way = one_way
        fastest = bounds.field * 1000.0 / (_FAST * rate)  # ticks a row
        self._steady_field = max(1.0, _STEADY * min(bounds.field_step, fastest))
        self._steady_speed = _STEADY * bounds.speed_step
        self.counts = np.zeros((2 * FIELD_CELLS + 1) * SLIP_CELLS * _RATE_CELLS, np.intp)

    def gains(self, sequence: GrowingSequence, offers: Sequence[Stretch]) -> list[float]:
        """Growth of the sum of log(1 + rows) over the cells."""
        growths: list[float] = []
        for fields, speeds in offers:
            of_rows = self.cells(sequence.field, sequence.speed, fields, speeds)
            cells, added = np.unique(of_rows, return_counts=True)
            # log(1 + old + added) - log(1 + old).
            growth = np.log1p(added / (1.0 + self.counts[cells]))
            growths.append(float(np.sum(growth)))
        return growths

    def take(self, sequence: GrowingSequence, stretch: Stretch) -> None:
        """Count the rows."""
        fields, speeds = stretch
        np.add.at(self.counts, self.cells(sequence.field, sequence.speed, fields, speeds), 1)

    def known(self, fields: Array, speeds: Array) -> None:
        """Count rows that are logged already, of those within the limits: field (signed of a pair) and speed."""
        bounds = self._bounds
        field_ticks = np.rint(fields * bounds.field_ticks)
        speed_ticks = np.rint(speeds * bounds.speed_ticks)
        within = np.abs(field_ticks) <= bounds.field + 1
        within &= np.abs(speed_ticks) <= bounds.speed + 1
        fields_within = field_ticks[within].astype(np.int64)
        speeds_within = speed_ticks[within].astype(np.int64)
        np.add.at(self.counts, self.cells(0, 0, fields_within, speeds_within), 1)

    def cells(
        self,
        field: int,
        speed: int,
        fields: Ticks,
        speeds: Ticks,
    ) -> Cells:
        """The cell of each row, with the field and the speed before the first."""
        bounds = self._bounds
        # The fields' levels from the most negative to the most positive, with zero in the middle.
        size = np.minimum(np.abs(fields) * FIELD_CELLS // (bounds.field + 1), FIELD_CELLS - 1)
        signed = np.where(fields > 0, FIELD_CELLS + 1 + size, FIELD_CELLS - 1 - size)
        level = np.where(fields == 0, FIELD_CELLS, signed)
        span = bounds.speed if self._one_way else 2 * bounds.speed
        above = speeds if self._one_way else speeds + bounds.speed
        slip = np.clip(above * SLIP_CELLS // (span + 1), 0, SLIP_CELLS - 1)
        field_direction = _direction(_changes(field, fields), self._steady_field)
        slip_direction = _direction(_changes(speed, speeds), self._steady_speed)
        rates = field_direction * 3 + slip_direction
        return ((level * SLIP_CELLS + slip) * _RATE_CELLS + rates).astype(np.intp)

    def share(self) -> float:
        """Share of the cells that hold a row, of those that can."""
        levels = 2 * FIELD_CELLS + 1 if self._signed else FIELD_CELLS + 1
        return float(np.count_nonzero(self.counts)) / (levels * SLIP_CELLS * _RATE_CELLS)


def _changes(before: int, ticks: Ticks) -> Ticks:
    """From each row to the next, the first from what was before."""
    changes = np.empty_like(ticks)
    changes[:1] = ticks[:1] - before
    np.subtract(ticks[1:], ticks[:-1], out=changes[1:])
    return changes


def _direction(change: Ticks, steady: float) -> NDArray[np.int64]:
    """0 falls, 1 is steady, 2 rises."""
    return np.where(np.abs(change) <= steady, 1, np.where(change > 0, 2, 0))


def chosen_sequence(
    limits: RigLimits,
    rate: float,
    seconds: float,
    rng: np.random.Generator,
    worth: Worth | None = None,
    *,
    signed: bool = False,
    one_way: bool = False,
    candidates: int = _CANDIDATES,
    of_paper: bool = False,
) -> Commands:
    """A sequence within limits, of the stretches that are worth most.

    Args:
        limits: of the rig.
        rate: rows a second.
        seconds: length.
        rng: random numbers; the same ones give the same sequence.
        worth: of a stretch; None: how it fills the space.
        signed: whether the field has two signs: that of a pair.
        one_way: whether the motion has one direction.
        candidates: how many stretches are compared each time.
        of_paper: whether every second of them is drawn as section III-B does, and may be short. Within a short stroke
            and little heat few long stretches are safe, and such sequences visit twice as many cells.

    Raises:
        SettingError: the limits leave no sequence; it names the limit that forbids.
    """
    bounds = Bounds.of(limits, rate, seconds)
    sequence = GrowingSequence(bounds)
    maker = StretchMaker(sequence, rng, rate, signed=signed, one_way=one_way)
    draws = [maker.draw]
    if of_paper:
        draws.append(PaperStretches(maker, rng, rate, signed=signed, one_way=one_way).draw)
    shortest = max(1, maker.rows // (_SHORT if of_paper else 4))  # rows
    worth = worth or CellCounts(bounds, rate, signed=signed, one_way=one_way)
    while sequence.left > 0:
        offers: list[Stretch] = []
        for number in range(candidates):
            fields, speeds = draws[number % len(draws)]()
            rows = sequence.safe(fields, speeds)
            if rows >= min(shortest, sequence.left):
                offers.append((fields[:rows], speeds[:rows]))
        if len(offers) == 1:
            stretch = offers[0]
        elif offers:
            gains = worth.gains(sequence, offers)
            prices = [sequence.cost(fields, speeds) for fields, speeds in offers]
            stretch = offers[int(np.argmax(np.array(gains) / np.array(prices)))]
        else:
            # Near the end of the stroke, or when the heat is used up: brake, and rest for a while.
            fields, speeds = sequence.stop(maker.rows // 4)
            rows = sequence.safe(fields, speeds)
            stretch = fields[:rows], speeds[:rows]
        worth.take(sequence, stretch)
        sequence.append(*stretch)
    return sequence.end()


def papers_sequence(
    limits: RigLimits,
    rate: float,
    seconds: float,
    rng: np.random.Generator,
    *,
    signed: bool = False,
    one_way: bool = False,
) -> Commands:
    """The draws of section III-B within the same limits: random squares and sines of field, random squares of speed."""
    bounds = Bounds.of(limits, rate, seconds)
    sequence = GrowingSequence(bounds)
    wanted = fields_of_paper(bounds, rng, rate, signed=signed)
    lowest, highest = frequencies_of_paper(rate)
    while sequence.left > 0:
        piece = pieces_of_paper(bounds, rng, rate, one_way=one_way, highest=highest, lowest=lowest)
        speeds = course(sequence.speed, [piece])[: sequence.left]
        next_wanted = wanted[sequence.rows : sequence.rows + speeds.size]
        # Where heat is scarce nine of ten draws have no safe row: the first row alone shows that.
        first = followed(sequence.field, next_wanted[:1], bounds.field_step)
        rows = sequence.safe(first, speeds[:1])
        if rows:
            fields = followed(sequence.field, next_wanted, bounds.field_step)
            rows = sequence.safe(fields, speeds)
        else:
            fields, speeds = sequence.stop()
            rows = speeds.size
        sequence.append(fields[:rows], speeds[:rows])
    return sequence.end()


def coverage_share(
    commands: Commands,
    limits: RigLimits,
    rate: float,
    seconds: float,
    *,
    signed: bool,
    one_way: bool,
) -> float:
    """Share of the cells of field, slip and their directions that a sequence visits."""
    cells = CellCounts(Bounds.of(limits, rate, seconds), rate, signed=signed, one_way=one_way)
    cells.known(commands.field, commands.speed)
    return cells.share()
