"""Of a log beyond memory whole stretches of rows are kept: most of them even in time, some where rows are rare.

A row is rare by its field, slip and acceleration, and by when it was. The measured effort has no say: rows that were
chosen by what they measured would bias every fit to them. Rare rows widen what a model has seen; too many of them would
make the kept rows unlike the log. Stretches begin in motion: at rest a fluid holds what the rows before did to it.
The shares are measured in docs/decisions/0020-any-size.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from erclutch.logs.batches import copied, neighbours
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array

STRETCH = 4096  # rows: seconds, in which a fluid forgets how it began
_RARE = 0.1  # share of the kept rows that is chosen by cells
_SECTIONS = 4  # parts of the log in time, in each of which a cell counts anew
_AT_REST = 0.01  # of the size of the slip
_LONGEST_REST = 16  # stretches; of a longer rest the end is not kept
_EVERY = 4  # of so many rows one is looked at
_IN_CELL = 4  # of these that a stretch needs in a cell
_FINENESS = 3.0  # cells for a factor of e in field, slip or acceleration
_FARTHEST = 40  # cells from zero


@dataclass(frozen=True)
class Stretch:
    """Neighbouring rows of one log.

    Attributes:
        log: which log, counted from 0.
        first: place of the first row among the log's usable rows, counted from 0.
        data: the rows.
        lead: rows at the start that are left out where the rows before the stretch are not kept.
    """

    log: int
    first: int
    data: Dataset
    lead: int = 0

    @property
    def begins_in_motion(self) -> bool:
        """Whether next to no rows are left out at the start."""
        return 8 * self.lead <= self.data.rows

    def alone(self) -> Stretch:
        """The same, whose rows do not keep those of the block around them in memory."""
        return replace(self, data=copied(self.data))

    @property
    def stop(self) -> int:
        """Place behind the last row."""
        return self.first + self.data.rows


def cut(log: int, first: int, block: Dataset) -> list[Stretch]:
    """The stretches of a block of rows, whose first row has this place in its log."""
    stretches: list[Stretch] = []
    for start in range(0, block.rows, STRETCH):
        stop = min(start + STRETCH, block.rows)
        stretches.append(Stretch(log, first + start, neighbours(block, start, stop)))
    return stretches


@dataclass(frozen=True)
class _Rare:
    """A stretch that is kept for its cells."""

    stretch: Stretch
    section: int
    cells: frozenset[int]


class StretchChoice:
    """Keeps some of the stretches that it is shown in the order of the logs.

    Args:
        rows: about how many rows it will be shown.
        most: rows that it may keep; from ``rows`` on it keeps all.
        seed: of the places, which are drawn one in each equal part of the logs: a fixed step could fall in with a
            programme that repeats.
    """

    def __init__(self, rows: int, most: int, seed: int = 0) -> None:
        self._rows = rows
        self._most = most
        self._share = 1.0  # of the stretches, even in time
        if most < rows:
            self._share = (1.0 - _RARE) * most / rows
        self._random = np.random.default_rng(seed)
        self._shown = 0  # rows so far
        self._count = 0  # stretches so far
        self._slot = 0  # parts of the logs, of each of which one stretch is kept
        self._due = self._place_in_slot()
        # The last stretch that begins in motion, and those behind it.
        self._since_motion: list[Stretch] = []
        self._even: list[Stretch] = []
        self._rare: list[_Rare] = []
        self._holders: Counter[int] = Counter()  # how many kept stretches hold a cell
        self._scales = [0.0, 0.0, 0.0]  # of field, slip and acceleration

    @property
    def kept(self) -> list[Stretch]:
        """The stretches that are kept, in the order of the logs."""
        rare = [each.stretch for each in self._rare]
        places = {(stretch.log, stretch.first): stretch for stretch in (*self._even, *rare)}
        return [places[place] for place in sorted(places)]

    def show(self, stretch: Stretch) -> None:
        """Keep a stretch or not; one that was kept for its rare rows may have to go."""
        section = _SECTIONS * self._shown // max(self._rows, 1)
        section = min(section, _SECTIONS - 1)
        self._shown += stretch.data.rows
        self._count += 1
        every = motion_of(stretch.data)
        self._widen_scales(every)
        stretch = replace(stretch, lead=self._rows_at_rest(stretch.data))
        if self._share == 1.0:
            self._even.append(stretch.alone())
            self._thin_out()
        else:
            self._keep_or_not(stretch, section, self._cells(every, section))
        if stretch.begins_in_motion:
            self._since_motion = [stretch]
        elif self._since_motion:
            self._since_motion.append(stretch)
            if len(self._since_motion) > _LONGEST_REST:
                self._since_motion = []

    def _keep_or_not(self, stretch: Stretch, section: int, cells: frozenset[int]) -> None:
        """Keep a stretch that is due, or that has a cell which no kept stretch has."""
        if self._count > self._due:
            # A stretch that begins at rest comes with those before it, back to the last motion.
            pieces = [stretch] if stretch.begins_in_motion else [*self._since_motion, stretch]
            if not pieces[0].begins_in_motion:
                return  # nobody knows what the fluid holds; the next stretch is due
            before = {(piece.log, piece.first) for piece in self._even[-_LONGEST_REST:]}
            pieces = [piece for piece in pieces if (piece.log, piece.first) not in before]
            self._even.extend(piece.alone() for piece in pieces)
            self._holders.update(cells)
            self._slot = max(self._slot + len(pieces), int(self._count * self._share))
            self._due = self._place_in_slot()
            self._thin_out()
        elif stretch.begins_in_motion and any(cell not in self._holders for cell in cells):
            self._rare.append(_Rare(stretch.alone(), section, cells))
            self._holders.update(cells)
            self._drop_least_rare(section)

    def _widen_scales(self, every: Sequence[Sequence[Array]]) -> None:
        """The size of field, slip and acceleration: a power of two above the largest mean square of any stretch."""
        for k in range(len(self._scales)):
            together = np.concatenate([element[k] for element in every])
            if not together.size:
                continue
            size = float(np.sqrt(np.mean(together * together)))
            if size > self._scales[k]:
                self._scales[k] = float(np.exp2(np.ceil(np.log2(size))))

    def _rows_at_rest(self, data: Dataset) -> int:
        """Rows before a gap ends, as where a log begins, or before all elements move: then a fluid soon forgets."""
        _, scale_of_slip, _ = self._scales
        ready = np.ones(data.rows, np.bool_)
        for element in data.elements:
            ready &= np.abs(element.slip) > _AT_REST * scale_of_slip
        for span in data.clock.spans:
            if span.start or not data.clock.joins:
                ready[span.start] = True
        return int(np.argmax(ready)) if ready.any() else data.rows

    def _place_in_slot(self) -> int:
        """The stretch, counted from 0, that is kept of the slot."""
        return int((self._slot + self._random.random()) / self._share)

    def _thin_out(self) -> None:
        """Where the log is longer than was said: every second stretch goes, and half as many are kept from now on."""
        if sum(stretch.data.rows for stretch in self._even) <= self._most:
            return
        self._even = [stretch for stretch in self._even[::2] if stretch.begins_in_motion]
        self._share *= 0.5
        self._slot = int(self._count * self._share) + 1
        self._due = self._place_in_slot()

    def _drop_least_rare(self, section: int) -> None:
        """Keep to the rows for rare stretches of a section: first go those with fewest cells that are theirs alone."""
        most = _RARE * self._most / _SECTIONS  # rows

        def alone(rare: _Rare) -> int:
            """Cells that no other stretch holds."""
            return sum(self._holders[cell] == 1 for cell in rare.cells)

        while True:
            here = [each for each in self._rare if each.section == section]
            rows = sum(each.stretch.data.rows for each in here)
            if rows <= most:
                return
            least = min(here, key=alone)
            self._rare = [each for each in self._rare if each is not least]
            self._holders.subtract(least.cells)
            self._holders += Counter[int]()  # drops cells that nobody holds

    def _cells(self, every: Sequence[Sequence[Array]], section: int) -> frozenset[int]:
        """The cells in which a stretch has rows enough."""
        cells: set[int] = set()
        for number, element in enumerate(every):
            code = np.full(element[0].size, _SECTIONS * number + section, np.int64)
            for values, scale in zip(element, self._scales, strict=True):
                place = np.rint(_FINENESS * np.arcsinh(values / (scale or 1.0)))
                near = np.clip(place, -_FARTHEST, _FARTHEST).astype(np.int64)
                code = code * (2 * _FARTHEST + 1) + near + _FARTHEST
            cell, rows = np.unique(code, return_counts=True)
            cells.update(cell[rows >= _IN_CELL].tolist())
        return frozenset(cells)


def motion_of(data: Dataset) -> list[list[Array]]:
    """Field, slip and size of the acceleration of each element, of every few rows."""
    step = np.diff(data.clock.time, append=np.nan)
    usable = np.flatnonzero(step > 0.0)[::_EVERY]
    motions: list[list[Array]] = []
    for element in data.elements:
        change = np.diff(element.slip, append=np.nan)
        acceleration = np.abs(change[usable]) / step[usable]
        motions.append([element.field[usable], element.slip[usable], acceleration])
    return motions
