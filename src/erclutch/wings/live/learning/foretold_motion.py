"""The motion that a table of fields and drive would bring is foretold from the law and from what the logs show.

Each speed's acceleration is linear in the drive, the effort, the direction and the speed itself, so inertia and
friction of the drive need not be known. Where the loop commands no drive, the last log's motion is taken to come again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.signals.array import Array, largest_size
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, slips_of, speeds_of
from erclutch.wings.design.fill import Cells

_FEWEST_ROWS = 200
_STEP = 2  # rows of a table in one step
_OVER = 0.004  # s, over which an acceleration is taken
_FIELDS, _SLIPS = 17, 81  # places of the table of settled efforts
_BEYOND = 2.0  # times the largest slip of the logs that efforts are known to


@dataclass(frozen=True)
class LoggedRound:
    """A round as it was logged.

    Attributes:
        rows: fields, slips and effort.
        drive: commanded torque of the drive, shape (n,); None: no drive.
    """

    rows: Dataset
    drive: Array | None

    @property
    def teaches(self) -> bool:
        """Whether a law can be fitted: there are rows enough, and slip, field and effort move."""
        if self.rows.rows < _FEWEST_ROWS:
            return False
        signals = [self.rows.effort]
        for element in self.rows.elements:
            signals += [element.slip, element.field]
        return all(bool(np.ptp(signal) > 0.0) for signal in signals)


class ForetoldMotion:
    """Foretells speeds.

    Attributes:
        model: the law.
        largest: speed of the logs, by size.
    """

    def __init__(self, model: TorqueModel, rounds: Sequence[LoggedRound]) -> None:
        self.model = model
        self._last = rounds[-1]
        self._driven = all(each.drive is not None for each in rounds)
        speeds = [np.array(_speeds(each.rows)) for each in rounds]  # each (speeds, n)
        self.largest = max(largest_size(of_round) for of_round in speeds)
        self._turn = 1e-3 * self.largest  # speed over which a direction turns
        self._coefficients = np.zeros((len(speeds[0]), 5))
        if self._driven:
            self._coefficients = self._learned(rounds, speeds)
        self._tabulate()

    def rows(self, tables: Array) -> list[Dataset]:
        """Rows that tables would bring, shape (tables, n, 3), from rest; the effort is zero."""
        speeds = self._simulated(tables) if self._driven else self._repeated(tables)
        last = self._last.rows
        count = len(tables[0])
        time = np.arange(count) * np.float64(last.period)
        clock = Clock(time, (Span(0, count, last.period),))
        no_effort = np.zeros(count)
        foretold: list[Dataset] = []
        for table, of_table in zip(tables, speeds, strict=True):
            slips = slips_of(last.device, list(of_table))
            elements = tuple(Element(table[:, number], slip) for number, slip in enumerate(slips))
            foretold.append(Dataset(last.device, elements, no_effort, clock, last.units))
        return foretold

    def _learned(self, rounds: Sequence[LoggedRound], speeds: Sequence[Array]) -> Array:
        """Least squares of each speed's acceleration, shape (speeds, 5)."""
        wanted: list[Array] = []  # accelerations, each (speeds, m)
        known: list[Array] = []  # what they are linear in, each (speeds, m, 5)
        for each, of_round in zip(rounds, speeds, strict=True):
            assert each.drive is not None
            half = max(1, round(0.5 * _OVER / each.rows.period))
            for span in each.rows.clock.spans:
                middle = np.arange(span.start + half, span.stop - half)
                change = of_round[:, middle + half] - of_round[:, middle - half]
                wanted.append(change / (2 * half * each.rows.period))
                speeds_there = of_round[:, middle]
                terms = self._terms(each.drive[middle], each.rows.effort[middle], speeds_there)
                known.append(terms)
        all_accelerations = np.concatenate(wanted, axis=1)
        all_terms = np.concatenate(known, axis=1)
        solve: Any = np.linalg.lstsq
        coefficients: list[Array] = []
        for terms, accelerations in zip(all_terms, all_accelerations, strict=True):  # a speed each
            solution = solve(terms, accelerations, rcond=None)[0]
            coefficients.append(np.asarray(solution, np.float64))
        return np.array(coefficients)

    def _terms(self, drive: Array, effort: Array, speeds: Array) -> Array:
        """What accelerations are linear in, shape (speeds, n, 5); both clutches of a pair brake its motor."""
        loads = [effort] if len(speeds) == 1 else [np.abs(effort), effort]
        of_speeds: list[Array] = []
        for load, speed in zip(loads, speeds, strict=True):
            direction = np.tanh(speed / self._turn)
            constant = np.ones_like(speed)
            of_speeds.append(np.column_stack([drive, load, direction, speed, constant]))
        return np.array(of_speeds)

    def _tabulate(self) -> None:
        """Settled efforts of each element over field and slip; the others rest without field."""
        elements = self._last.rows.elements
        strongest = max(largest_size(element.field) for element in elements) or 1.0
        fastest = _BEYOND * max(largest_size(element.slip) for element in elements)
        self._field_grid = np.linspace(0.0, strongest, _FIELDS)
        bent = np.sinh(np.linspace(-7.0, 7.0, _SLIPS))  # fine about zero, where the law turns
        self._slip_grid = fastest * bent / bent[-1]
        field: Array = np.repeat(self._field_grid, _SLIPS)
        slip: Array = np.tile(self._slip_grid, _FIELDS)
        rest: Array = np.zeros(slip.size)
        self._efforts: list[Array] = []
        for number in range(len(elements)):
            fields = [field if other == number else rest for other in range(len(elements))]
            slips = [slip if other == number else rest for other in range(len(elements))]
            efforts = self.model.steady(fields, slips)
            self._efforts.append(efforts.reshape(_FIELDS, _SLIPS))
        none = [np.zeros(1)] * len(elements)
        self._at_rest = float(self.model.steady(none, none)[0])  # counted with each element

    def _effort(self, fields: Array, speeds: Array) -> Array:
        """Settled effort, shape (tables,), of fields (elements, tables) and speeds (speeds, tables)."""
        slips = slips_of(self._last.rows.device, list(speeds))
        counted_twice = self._at_rest * (len(slips) - 1)
        total = np.full(speeds.shape[1], -counted_twice)
        for efforts, field, slip in zip(self._efforts, fields, slips, strict=True):
            field_at, field_share = _place(self._field_grid, field)
            slip_at, slip_share = _place(self._slip_grid, slip)
            # Bilinear: along the slip at both fields around, then along the field.
            weaker = efforts[field_at, slip_at] * (1.0 - slip_share)
            weaker += efforts[field_at, slip_at + 1] * slip_share
            stronger = efforts[field_at + 1, slip_at] * (1.0 - slip_share)
            stronger += efforts[field_at + 1, slip_at + 1] * slip_share
            total += weaker * (1.0 - field_share) + stronger * field_share
        return total

    def _acceleration(self, fields: Array, drive: Array, speeds: Array) -> Array:
        terms = self._terms(drive, self._effort(fields, speeds), speeds)
        return np.einsum("snk,sk->sn", terms, self._coefficients)

    def _simulated(self, tables: Array) -> Array:
        """Speeds, shape (tables, speeds, n): steps that are implicit in each speed, since a yield effort is stiff."""
        count = len(tables)
        rows = int(tables.shape[1])
        numbers = len(self._coefficients)  # of speeds
        step = _STEP * self._last.rows.period  # [s]
        nudge = 0.1 * self._turn
        limit = _BEYOND * self.largest
        speeds = np.zeros((numbers, count))
        out = np.zeros((count, numbers, rows))
        for row in range(0, rows, _STEP):
            out[:, :, row : row + _STEP] = speeds.T[:, :, None]
            fields = tables[:, row, : len(self._efforts)].T
            drive = tables[:, row, 2]
            now = self._acceleration(fields, drive, speeds)
            change = np.empty_like(speeds)
            for number in range(numbers):
                nudged = speeds.copy()
                nudged[number] += nudge
                after = self._acceleration(fields, drive, nudged)
                slope = (after[number] - now[number]) / nudge
                stiffness = 1.0 - step * np.minimum(slope, 0.0)
                change[number] = step * now[number] / stiffness
            speeds = np.clip(speeds + change, -limit, limit)
        return out

    def _repeated(self, tables: Array) -> Array:
        """The speeds of the last log again, as often as it takes, shape (tables, speeds, n)."""
        rows = np.arange(len(tables[0])) % self._last.rows.rows
        speeds = np.array(_speeds(self._last.rows))[:, rows]
        return np.repeat(speeds[None], len(tables), axis=0)


def _speeds(rows: Dataset) -> list[Array]:
    return speeds_of(rows.device, [element.slip for element in rows.elements])


def _place(grid: Array, at: Array) -> tuple[Cells, Array]:
    """Which cell of a grid, and how far in it from 0 to 1."""
    within = np.clip(at, grid[0], grid[-1])
    below = np.searchsorted(grid, within, side="right") - 1
    cell = np.clip(below, 0, grid.size - 2).astype(np.intp)
    width = grid[cell + 1] - grid[cell]
    return cell, (within - grid[cell]) / width
