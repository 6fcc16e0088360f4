"""With a model: which stretch takes most off what is not known of its numbers, or of its effort where it is used.

Rows add to the information matrix M = J' J / variance of the law's numbers, J being the exact derivatives that the fit
has, with the states of lags and memories as the sequence brings them. A design is D-optimal if it makes det M largest,
A-optimal if it makes the relative variances smallest, and I-optimal if it makes the variance of the effort smallest
where the device is used (Atkinson, Donev and Tobias 2007, chapters 10 and 17; Fedorov and Leonov 2013,
doi:10.1201/b15054). What the run knows already stands in M from the start, with a wide prior where it knows nothing
(Chaloner and Verdinelli 1995, doi:10.1214/ss/1177009939). A law whose residual is no noise is wrong somewhere. D
and A believe it all the same, for they ask for its numbers; I doubts it (`design.doubt`).
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from erclutch.errors import SettingError
from erclutch.fit.laws.law_problem import separable
from erclutch.fit.solver.intervals import correlated_rows
from erclutch.fit.solver.variable_projection import Projection, coordinates, linearised
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.signals.array import Array, Mask, largest_size, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, slips_of
from erclutch.wings.design.courses import Commands, GrowingSequence
from erclutch.wings.design.doubt import CellGrid, Doubt, RowsOfUse
from erclutch.wings.design.fill import Cells, Stretch

Criterion = Literal["D", "A", "I", "fill"]
#: Prior standard deviation of a number of which the rows say nothing: of a logarithm, and of a gain over the effort.
_PRIOR = 5.0
_WARM_UP = 0.5  # s, after which lags and memories have their states
QUANTILE = 1.96


@dataclass(frozen=True)
class Region:
    """Where a device is used.

    Attributes:
        field, slip: lowest and highest.
    """

    field: tuple[float, float]
    slip: tuple[float, float]

    def rows(self, data: Dataset) -> Mask:
        """Which rows have an element there, shape (n,)."""
        least_field, most_field = self.field
        least_slip, most_slip = self.slip
        inside = np.zeros(data.rows, np.bool_)
        for element in data.elements:
            field = (least_field <= element.field) & (element.field <= most_field)
            slip = (least_slip <= element.slip) & (element.slip <= most_slip)
            inside |= field & slip
        return inside


def region_of(text: str) -> Region:
    """``field 0..2 A, slip +-5 rad/s`` as a region; units are those of the run.

    Raises:
        SettingError: it is no such text.
    """
    number = r"([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)"
    either = rf"(?:\+-\s*{number}|{number}\s*\.\.\s*{number})"
    unit = r"(?:\s+\S+)?"
    ranges: dict[str, tuple[float, float]] = {}
    for part in text.split(","):
        match = re.fullmatch(rf"\s*(field|slip)\s+{either}{unit}\s*", part)
        if match is None:
            remedy = "Write it like --where 'field 0..2 A, slip +-5 rad/s'"
            raise SettingError(f"--where {text!r}: {part.strip()!r} is no range", remedy=remedy)
        name, both, low, high = match.groups()
        if both:
            ranges[name] = -float(both), float(both)
        else:
            ranges[name] = float(low), float(high)
    everywhere = (-math.inf, math.inf)
    return Region(ranges.get("field", everywhere), ranges.get("slip", everywhere))


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of a law's effort by its numbers: the coordinates of the fit first, then the gains."""

    model: TorqueModel

    def rows(self, data: Dataset) -> Array:
        """Derivatives in each row, shape (n, k + p)."""
        model = self.model
        shapes = model.structure.shapes(model.reference.period)
        problem = separable(data, model.structure, model.reference, shapes, slice(None))
        at = coordinates(shapes, list(model.shape.values()))
        gains = np.array(list(model.gains.values()))
        stacked, by_coordinates, _ = linearised(problem, at, Projection.of_known(gains))
        by_gains = stacked[:, :-1]  # the last column is the effort
        return np.hstack([by_coordinates, by_gains])

    def of_commands(self, pieces: Sequence[tuple[Array, Array]], period: float) -> Dataset:
        """Rows of field and speed, each piece a span of its own; the output of a pair is held."""
        structure = self.model.structure
        fields = np.concatenate([field for field, _ in pieces])
        speeds = np.concatenate([speed for _, speed in pieces])
        rows = fields.size
        ends = itertools.accumulate((field.size for field, _ in pieces), initial=0)
        spans = tuple(Span(start, stop, period) for start, stop in itertools.pairwise(ends))
        if structure.device == "coaxial":
            slips = slips_of("coaxial", (speeds, np.zeros_like(speeds)))
            first = Element(np.maximum(fields, 0.0), slips[0])
            second = Element(np.maximum(-fields, 0.0), slips[1])
            elements = (first, second)
        else:
            elements = (Element(fields, speeds),)
        # Further inputs stay as usual.
        usual = zip(structure.extras, self.model.reference.extras, strict=True)
        return Dataset(
            device=structure.device,
            elements=elements,
            effort=np.zeros(rows),
            clock=Clock(np.arange(float(rows)) * np.float64(period), spans),
            units=self.model.units,
            extras={name: np.full(rows, scale) for name, scale in usual},
        )


def _inverse(information: Array) -> Array:
    inverse: Any = np.linalg.inv(information)
    return inverse


class Knowledge:
    """What rows say of a law's numbers: the worth of stretches for `chosen_sequence`.

    Attributes:
        information: M, shape (k + p, k + p), with the prior.
        prior: what is known before any row, shape (k + p, k + p).
        weight: of a row of the sequence in M: neighbours are alike, so many rows count as one.
        noise: standard deviation of a row's residual.
        alike: how many rows that are known count as one.
        doubt: what the rows say of the law's offsets; None: the law is believed.
    """

    def __init__(
        self,
        model: TorqueModel,
        known: Dataset,
        rate: float,
        criterion: Criterion = "D",
        use: Dataset | None = None,
        wanted: Mask | None = None,
    ) -> None:
        """Start from the rows that a model was fitted to.

        Args:
            model: a law with its stages.
            known: the rows.
            rate: of the sequence, rows a second.
            criterion: D, A, or I, which needs rows of use.
            use: rows of use among others, which bring the states; None: the rows of the fit.
            wanted: which of them are rows of use, shape (n,); None: all.
        """
        self.sensitivity = Sensitivity(model)
        self._rate = rate
        self._criterion = criterion
        derivatives = self.sensitivity.rows(known)  # shape (n, k + p)
        residual = known.effort - model.predict(known)
        self.noise = rms(residual)

        # Neighbours are alike: so many rows count as one, in the new rows as in the old, of the same time.
        self.alike = correlated_rows(residual)
        alike = self.alike * known.period  # s
        variance = max(self.noise, 1e-300) ** 2
        self.weight = 1.0 / (variance * max(alike * rate, 1.0))  # of a new row
        known_weight = 1.0 / (variance * max(alike / known.period, 1.0))

        largest = largest_size(known.effort)
        gains = np.array(list(model.gains.values()))
        shapes = derivatives.shape[1] - gains.size
        deviations = np.full(derivatives.shape[1], _PRIOR)
        deviations[shapes:] *= largest  # a gain's is over the effort
        self.prior = np.diag(deviations**-2.0)
        self.information = self.prior + known_weight * (derivatives.T @ derivatives)
        # A coordinate of a shape is a logarithm, so its error is relative already.
        gain_sizes = np.maximum(np.abs(gains), 1e-3 * largest)
        self._scales = np.concatenate([np.ones(shapes), gain_sizes])
        if use is None:
            where, used = known, derivatives
        else:
            where = use
            used = self.sensitivity.rows(use)
        grid = CellGrid.of(known, where)
        # A residual whose neighbours are alike is no noise: it is what the law does not say.
        doubted = variance * (1.0 - 1.0 / max(alike / known.period, 1.0))
        self.doubt: Doubt | None = None
        if doubted > 0.0 and criterion == "I":
            self.doubt = Doubt.of(grid, known, math.sqrt(doubted), derivatives, known_weight)
        cells = grid.cells(where)
        if wanted is not None:
            used, cells = used[wanted], cells[wanted]
        self._use = RowsOfUse.of(used, cells, grid)
        # Stretches, with their derivatives and cells.
        self._looked_at: list[tuple[Stretch, tuple[Array, Cells]]] = []

    def gains(self, sequence: GrowingSequence, offers: Sequence[Stretch]) -> list[float]:
        """What each stretch takes off the criterion: the logarithm of what is not known."""
        now = self.criterion(self.information, self.doubt)
        of_offers = self._rows(sequence, offers)
        self._looked_at = list(zip(offers, of_offers, strict=True))
        return [
            now - self._after(derivatives, cells, self.weight) for derivatives, cells in of_offers
        ]

    def take(self, sequence: GrowingSequence, stretch: Stretch) -> None:
        """The stretch will be logged: one of those just looked at, or another."""
        known = [of_offer for offer, of_offer in self._looked_at if offer is stretch]
        ((derivatives, cells),) = known or self._rows(sequence, [stretch])
        self._add(derivatives, cells, self.weight)
        self._looked_at = []

    def learn(self, commands: Commands) -> None:
        """A whole sequence will be logged."""
        whole = [(commands.field, commands.speed)]
        self.learn_rows(self.sensitivity.of_commands(whole, 1.0 / self._rate))

    def learn_rows(self, rows: Dataset) -> None:
        """Rows will be logged; their effort is not looked at."""
        self._add(self.sensitivity.rows(rows), self._cells(rows), self.weight)

    def worth(self, log: Dataset) -> float:
        """What a log that is there would take off the logarithm of the criterion; its effort is not looked at."""
        weight = self.weight * self._rate * log.period  # of a row of that log
        now = self.criterion(self.information, self.doubt)
        return now - self._after(self.sensitivity.rows(log), self._cells(log), weight)

    def criterion(self, information: Array, doubt: Doubt | None = None) -> float:
        """Logarithm of the criterion, the smaller the better; of a law that is believed, or with what is doubted."""
        if self._criterion == "D":
            return -float(np.linalg.slogdet(information)[1])
        if self._criterion == "A":
            relative = np.diag(_inverse(information)) / self._scales**2
            return math.log(float(np.sum(relative)))
        used = self._use
        if doubt is None:
            return math.log(_mean_variance(used.squares, information, used.rows))
        squares = doubt.squares(used)
        left = doubt.left_to_numbers(information)
        of_numbers = _mean_variance(squares, left, used.rows)
        return math.log(of_numbers + doubt.own_variance(used))

    def errors(self) -> Array:
        """Standard error of each number: of the coordinates, then of the gains; shape (k + p,)."""
        variances = np.diag(_inverse(self.information))
        return np.sqrt(variances)

    def band(self) -> float:
        """Half width of the effort's 95 % interval over the rows of use: what the numbers leave open, without noise."""
        variance = _mean_variance(self._use.squares, self.information, self._use.rows)
        return QUANTILE * math.sqrt(variance)

    def _cells(self, rows: Dataset) -> Cells:
        """The cell of each row, shape (n,); nobody asks where the law is believed."""
        if self.doubt is None:
            return np.zeros(rows.rows, np.intp)
        return self.doubt.grid.cells(rows)

    def _after(self, derivatives: Array, cells: Cells, weight: float) -> float:
        """The criterion once rows are logged."""
        more = self.information + weight * (derivatives.T @ derivatives)
        doubt = None if self.doubt is None else self.doubt.plus(cells, derivatives, weight)
        return self.criterion(more, doubt)

    def _add(self, derivatives: Array, cells: Cells, weight: float) -> None:
        self.information = self.information + weight * (derivatives.T @ derivatives)
        if self.doubt is not None:
            self.doubt = self.doubt.plus(cells, derivatives, weight)

    def _rows(
        self, sequence: GrowingSequence, offers: Sequence[Stretch]
    ) -> list[tuple[Array, Cells]]:
        """Derivatives and cells of each stretch, with the states that the sequence leaves."""
        bounds = sequence.bounds
        fields, speeds = sequence.last(round(_WARM_UP * self._rate))
        pieces: list[tuple[Array, Array]] = []
        for field, speed in offers:
            whole_field = np.concatenate([fields, field]) / bounds.field_ticks
            whole_speed = np.concatenate([speeds, speed]) / bounds.speed_ticks
            pieces.append((whole_field, whole_speed))
        data = self.sensitivity.of_commands(pieces, 1.0 / self._rate)
        derivatives = self.sensitivity.rows(data)
        cells = self._cells(data)

        of_offers: list[tuple[Array, Cells]] = []
        start = 0  # of the piece in the rows
        for field, _ in offers:
            stop = start + fields.size + field.size
            new = slice(start + fields.size, stop)  # without the rows of warming up
            of_offers.append((derivatives[new], cells[new]))
            start = stop
        return of_offers


def _mean_variance(squares: Array, information: Array, rows: int) -> float:
    """Variance of the effort, a mean over rows, from the squares of their derivatives, shape (k + p, k + p)."""
    return float(np.sum(squares * _inverse(information))) / rows
