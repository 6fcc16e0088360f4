"""Band: how far the measured effort may lie from the estimate, by where the device stands.

A table has a cell for each class of field, slip and switching. A cell holds two half widths of the effort, in the
direction of the slip (`ahead`) and against it (`behind`), so that one table serves both ways::

    low = effort - (slip < 0 ? ahead : behind),   high = effort + (slip < 0 ? behind : ahead)

The field is that of the largest magnitude over the elements, the slip that of the same element. A grid over both, twice
as fine as that which says where training rows were (`Range.near`), says their class, so a step needs no comparison with
edges. The field is switching while it is further than a threshold from its own first-order lag. Where several logs say
how errors grow with how quickly the slip changes, half widths grow where it changes more quickly than in all of them
(`models.haste`). `fit.bands.prediction_bands` finds the numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.elementary import less_select, table_entry
from erclutch.models.covered_cells import CELLS, grid_cell
from erclutch.models.haste import FOLLOWER, Haste
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element

#: Edges of the field, and edges of the slip, that a band may have.
MOST_EDGES = 3
#: Edges of the field with those around fields that no log had.
MOST_FIELD_EDGES = 15
#: Cells of the band's grid along a side of a cell of `Range.near`.
_FINER = 2


@dataclass(frozen=True)
class Band:
    """Half widths of the effort's band.

    Attributes:
        level: share of rows that the band is to hold.
        settling_s: time constant in s of the lag that follows the field.
        threshold: distance between field and lag, in the field's unit, above which the field is switching.
        field, slip: ranges that the grid lies over.
        field_edges: ascending magnitudes of the field between classes; a cell of the grid is where its centre is.
        slip_edges: the same of the slip.
        behind, ahead: half widths in the effort's unit against and in the direction of the slip, one a cell; the class
            of the slip changes fastest over the cells, that of switching slowest.
        haste: how much wider the band is where the slip changes more quickly than in training; None: no wider.
        part: part of the estimate, by `alarms.part_of`, that residuals follow in few blocks of training rows; None:
            there were too few blocks.
    """

    level: float
    settling_s: float
    threshold: float
    field: tuple[float, float]
    slip: tuple[float, float]
    field_edges: tuple[float, ...]
    slip_edges: tuple[float, ...]
    behind: tuple[float, ...]
    ahead: tuple[float, ...]
    haste: Haste | None = None
    part: float | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """Classes of switching, field and slip."""
        return 2, len(self.field_edges) + 1, len(self.slip_edges) + 1

    @cached_property
    def classes(self) -> tuple[tuple[int, ...], ...]:
        """The class of field and slip, the slip fastest, of each cell of the grid over field and slip."""
        field_size = np.abs(centres(self.field))
        field_class = np.searchsorted(self.field_edges, field_size)
        slip_size = np.abs(centres(self.slip))
        slip_class = np.searchsorted(self.slip_edges, slip_size)
        of_slip = self.shape[2]
        both = field_class[:, None] * of_slip + slip_class
        return tuple(tuple(row) for row in both.tolist())

    def leading(self, fields: Sequence[Any], slips: Sequence[Any]) -> tuple[Any, Any, Any]:
        """Field, slip and class of the element under the largest field; elementwise on any operand."""
        rows = [grid_cell(field, self.field) for field in fields]
        columns = [grid_cell(slip, self.slip) for slip in slips]
        field, slip, row, column = leading(fields, slips, rows, columns)
        return field, slip, table_entry(self.classes, _FINER * row, _FINER * column)

    def switching(self, field: Any, followed: Any) -> Any:
        """1 where the field is far from the lag behind it, else 0; on any operand."""
        away = field - followed
        return less_select(self.threshold**2, away * away, 1.0, 0.0)

    def cells(self, elements: Sequence[Element], clock: Clock) -> NDArray[np.intp]:
        """The cell of each row, shape (n,); the lag starts settled in each span."""
        field, _, place = self._leading_of(elements)
        switched = self._switched(field, clock)
        switching, fields, slips = self.shape
        return np.ravel_multi_index((switched, place), (switching, fields * slips))

    def around(
        self,
        effort: Array,
        elements: Sequence[Element],
        clock: Clock,
    ) -> tuple[Array, Array]:
        """Low and high end of the band around an estimated effort, each (n,)."""
        field, slip, place = self._leading_of(elements)
        factor = None if self.haste is None else self.haste.factors(slip, clock)
        return self.ends(effort, slip, self._switched(field, clock), place, factor)

    def _leading_of(self, elements: Sequence[Element]) -> tuple[Any, Any, Any]:
        fields = [element.field for element in elements]
        slips = [element.slip for element in elements]
        return self.leading(fields, slips)

    def _switched(self, field: Array, clock: Clock) -> NDArray[np.intp]:
        followed = FOLLOWER.respond(field, clock, [self.settling_s], slice(None))
        return np.asarray(self.switching(field, followed)).astype(np.intp)

    def ends(
        self,
        effort: Any,
        slip: Any,
        switching: Any,
        place: Any,
        factor: Any = None,
    ) -> tuple[Any, Any]:
        """Low and high end, on any operand.

        Args:
            effort: estimated.
            slip: of `leading`.
            switching: of `switching`.
            place: of `leading`.
            factor: of the half widths, by `Haste`; None for a band without it.
        """
        behind = _by_switching(self.behind)
        ahead = _by_switching(self.ahead)
        backwards = less_select(slip, 0.0, 1.0, 0.0)

        def half_width(tables: Any) -> Any:
            """Entry of a table for slips forward or of another for slips backwards."""
            width = table_entry(tables, backwards, switching, place)
            return width if factor is None else factor * width

        low = effort - half_width((behind, ahead))
        high = effort + half_width((ahead, behind))
        return low, high

    @property
    def settled(self) -> float:
        """Half width of the widest cell under a field that is not switching."""
        cells = self.shape[1] * self.shape[2]
        return max(*self.behind[:cells], *self.ahead[:cells])

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values."""
        tables = ("field", "slip", "field_edges", "slip_edges", "behind", "ahead")
        as_lists = {name: list(getattr(self, name)) for name in tables}
        whole = asdict(self) | as_lists
        for name in ("haste", "part"):
            if whole[name] is None:
                del whole[name]
        return whole


def _by_switching(half_widths: Sequence[float]) -> tuple[tuple[float, ...], ...]:
    """Half widths of the cells under a steady field, and of those under a field that is switching."""
    cells = len(half_widths) // 2
    return tuple(half_widths[:cells]), tuple(half_widths[cells:])


def leading(fields: Sequence[Any], *signals: Sequence[Any]) -> tuple[Any, ...]:
    """The field of the largest magnitude over the elements, and further signals of that element; on any operand."""
    first, *others = zip(fields, *signals, strict=True)  # all signals of one element after another
    leader: Sequence[Any] = first
    for element in others:
        size = leader[0] * leader[0]
        other_size = element[0] * element[0]
        ahead: list[Any] = []
        for other, own in zip(element, leader, strict=True):
            ahead.append(less_select(size, other_size, other, own))
        leader = ahead
    return tuple(leader)


def centres(covered: tuple[float, float]) -> Array:
    """Centres of the cells along a range of a band, shape (32,)."""
    low, high = covered
    cells = _FINER * CELLS
    step = (high - low) / cells
    middles = np.arange(cells) + 0.5  # in cells
    return np.asarray(low + middles * step, np.float64)
