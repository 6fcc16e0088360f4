"""Band: how far the measured effort may lie from the estimate, by where the device stands.

A table has a cell for each class of field, slip and switching. A cell holds two half widths of the effort, in the
direction of the slip (`ahead`) and against it (`behind`), so that one table serves both ways::

    low = effort - (slip < 0 ? ahead : behind),   high = effort + (slip < 0 ? behind : ahead)

The field is the largest magnitude over the elements, the slip that of the same element. The field is switching while
it is further than a threshold from its own first-order lag. `fit.prediction_bands` finds the numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import less_select, table_entry
from erclutch.models.stages.effort_lag import EffortLag
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element

#: Edges of the field, and edges of the slip, that a band may have.
MOST_EDGES = 3
#: What follows the field.
FOLLOWER = EffortLag()


@dataclass(frozen=True)
class Band:
    """Half widths of the effort's band.

    Attributes:
        level: share of rows that the band is to hold.
        settling_s: time constant in s of the lag that follows the field.
        threshold: distance between field and lag, in the field's unit, above which the field is switching.
        field_edges: ascending magnitudes of the field between classes; a value on an edge belongs below.
        slip_edges: the same of the slip.
        behind, ahead: half widths in the effort's unit against and in the direction of the slip, one a `cell`.
    """

    level: float
    settling_s: float
    threshold: float
    field_edges: tuple[float, ...]
    slip_edges: tuple[float, ...]
    behind: tuple[float, ...]
    ahead: tuple[float, ...]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Classes of switching, field and slip; the last one changes fastest over the cells."""
        return 2, len(self.field_edges) + 1, len(self.slip_edges) + 1

    def cell(self, field: Any, slip: Any, followed: Any) -> Any:
        """The cell as a real number, from the signals of `leading` and the lag behind the field; on any operand."""
        _, fields, slips = self.shape
        switching = _class(np.abs(field - followed), (self.threshold,))
        at = switching * float(fields) + _class(field, self.field_edges)
        return at * float(slips) + _class(np.abs(slip), self.slip_edges)

    def cells(self, elements: Sequence[Element], clock: Clock) -> Array:
        """The cell of each row, shape (n,); the lag starts settled in each span."""
        field, slip = leading([e.field for e in elements], [e.slip for e in elements])
        followed = FOLLOWER.respond(field, clock, [self.settling_s], slice(None))
        return np.asarray(self.cell(field, slip, followed))

    def around(self, effort: Array, elements: Sequence[Element], clock: Clock) -> tuple[Array, Array]:
        """Low and high end of the band around an estimated effort, each (n,)."""
        _, slip = leading([e.field for e in elements], [e.slip for e in elements])
        return self.ends(effort, slip, self.cells(elements, clock))

    def ends(self, effort: Any, slip: Any, cell: Any) -> tuple[Any, Any]:
        """Low and high end in a `cell`; on any operand."""
        halves = (self.behind, self.ahead)
        back, forth = less_select(slip, 0.0, 1.0, 0.0), less_select(slip, 0.0, 0.0, 1.0)
        return effort - table_entry(halves, back, cell), effort + table_entry(halves, forth, cell)

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values."""
        tables = ("field_edges", "slip_edges", "behind", "ahead")
        return asdict(self) | {name: list(getattr(self, name)) for name in tables}


def leading(fields: Sequence[Any], slips: Sequence[Any]) -> tuple[Any, Any]:
    """Magnitude of the field, and the slip, of the element under the largest field; elementwise on any operand."""
    field, slip = np.abs(fields[0]), slips[0]
    for other, relative in zip(fields[1:], slips[1:], strict=True):
        size = np.abs(other)
        slip = less_select(field, size, relative, slip)
        field = less_select(field, size, size, field)
    return field, slip


def _class(value: Any, edges: Sequence[float]) -> Any:
    """How many edges a value is above."""
    return sum((less_select(edge, value, 1.0, 0.0) for edge in edges), 0.0)
