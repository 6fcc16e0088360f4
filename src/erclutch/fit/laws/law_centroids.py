"""Laws are fitted on centroids: a pair driven one clutch at a time has three inputs, a single element has two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.fit.solver.centroids import Centroids
from erclutch.fit.solver.variable_projection import Separable
from erclutch.models.laws import ShapeParameter
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element

_NARROW = 0.003  # slip, over its root mean square, below which cells are equally wide


def signed_rows(elements: Sequence[Element]) -> Array:
    """The field, of a pair the difference of both, and each slip: shape (1 + elements, n)."""
    signed = elements[0].field
    if len(elements) > 1:
        signed = signed - elements[1].field
    return np.array([signed, *(element.slip for element in elements)])


def spaced_rows(rows: Array, reference: Reference) -> Array:
    """What the grid is over: laws bend most where the slip is small, so cells narrow towards zero."""
    field = rows[0]
    slips = rows[1:]
    narrow = _NARROW * reference.slip
    return np.array([field, *np.arcsinh(slips / narrow)])


def on_cells(
    cells: Centroids,
    structure: Structure,
    reference: Reference,
    shapes: tuple[ShapeParameter, ...],
) -> Separable:
    """The problem on weighted centroids of `signed_rows`."""
    signed, *slips = cells.x
    fields = [signed]
    if structure.elements > 1:  # of a pair one clutch at a time is under field: the sign says which
        fields = [np.maximum(signed, 0.0), np.maximum(-signed, 0.0)]
    elements = [Element(field, slip) for field, slip in zip(fields, slips, strict=True)]
    # Laws remember nothing: the times of cells do not count.
    clock = Clock(np.arange(float(cells.y.size)), ())
    root = np.sqrt(cells.count)

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return [column * root for column in structure.columns(elements, clock, reference, q)]

    return Separable(columns, cells.y * root, shapes, structure.gains())
