"""Inputs of a network from the rows of a data set: equations (18) and (20), past samples, further logged signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from erclutch.device import Element
from erclutch.dynamics import Clock, respond
from erclutch.errors import MappingError
from erclutch.exact import exact
from erclutch.networks import NetworkStructure

Array = NDArray[np.float64]


def inputs_of(
    structure: NetworkStructure,
    elements: Sequence[Element],
    clock: Clock,
    extras: Mapping[str, Array],
    dynamics: Mapping[str, float],
) -> Array:
    """Inputs in the data's units, shape (inputs, n).

    Args:
        structure: which inputs.
        elements: field and slip of each element.
        clock: time and spans.
        extras: further logged inputs by name.
        dynamics: delay and time constants in s; empty for none.

    Raises:
        MappingError: a further input is not there.
    """
    fields = [_in_fluid(e.field, clock, dynamics) for e in elements]
    base = _base(structure, fields, [e.slip for e in elements])
    rows = [*base, *(_before(x, clock, k) for k in structure.past for x in base)]
    for name in structure.extras:
        if name not in extras:
            known = ", ".join(extras) or "none"
            raise MappingError(
                f"the network's input {name!r} is not in these rows (further inputs here: {known})",
                remedy=f"Read the log with --input {name!r}",
            )
        rows.append(extras[name])
    return np.array(rows, np.float64)


def _in_fluid(field: Array, clock: Clock, dynamics: Mapping[str, float]) -> Array:
    if not dynamics:
        return field
    fall = dynamics.get("tau_fall")
    rise = dynamics["tau"] if fall is None else dynamics["tau_rise"]
    return np.asarray(respond(exact(field), clock, delay=dynamics["delay"], rise=rise, fall=fall), np.float64)


def _base(structure: NetworkStructure, fields: Sequence[Array], slips: Sequence[Array]) -> list[Array]:
    if structure.device == "single":
        return [fields[0], slips[0]]
    signed = fields[0] - fields[1]
    if structure.kind == "rbfn":
        return [signed, slips[0], slips[1]]
    return [signed, 0.5 * (slips[0] - slips[1]), -0.5 * (slips[0] + slips[1])]


def _before(x: Array, clock: Clock, rows: int) -> Array:
    """The signal some rows earlier; at a stretch's start its first value."""
    out = x.copy()
    for span in clock.spans:
        part = x[span.start : span.stop]
        k = min(rows, part.size)
        out[span.start : span.start + k] = part[0]
        out[span.start + k : span.stop] = part[: part.size - k]
    return out
