"""A law of another package is checked before it is used, and the package is named where the law fails."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from erclutch.arithmetic.dual import Dual
from erclutch.models.laws.law import Law, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP
from erclutch.registry import Plugin

#: Where a law is tried: without field, in the middle, at the reference; moving either way and at rest.
_FIELDS = np.array([0.0, 0.5, 1.0, 1.0])
_SLIPS = np.array([0.0, -1.0, 1.0, 0.0])
# A law that changes what it is given changes the log's own rows: here it fails.
_FIELDS.setflags(write=False)
_SLIPS.setflags(write=False)


def checked(law: Any, plugin: Plugin) -> Law:
    """The law with its plug-in, its functions guarded: whatever they raise names the plug-in.

    Raises:
        PluginError: it is no law, calls itself otherwise than its entry point, or its columns are not what it says.
    """
    if not isinstance(law, Law):
        raise plugin.fault(
            f"gives a {type(law).__name__}, it must be a Law of erclutch.models.laws.law"
        )
    if law.name != plugin.name and law.name.rpartition("-")[0] != plugin.name:
        raise plugin.fault(
            f"calls itself {law.name!r}; its Law.name and its entry point must agree"
        )
    if law.shape[:1] != (TRANSITION_SLIP,):
        raise plugin.fault(
            "must have TRANSITION_SLIP of erclutch.models.laws.smooth as its first shape parameter"
        )
    own = replace(
        law,
        columns=plugin.guarded(law.columns),
        stimulus=None if law.stimulus is None else plugin.guarded(law.stimulus),
        paper_form=None if law.paper_form is None else plugin.guarded(law.paper_form),
        plugin=plugin,
    )
    # The law is tried out: its columns must be what its gains say.
    names = [number.name for number in (*own.stimulus_shape, *own.shape, *own.gains)]
    if len(set(names)) < len(names):
        raise plugin.fault(f"has two parameters of one name: {', '.join(names)}")
    field = _FIELDS
    if own.stimulus is not None:
        field = own.stimulus(_FIELDS, *map(typical, own.stimulus_shape))
        if isinstance(field, np.ndarray):
            field.setflags(write=False)
    shape = [typical(number) for number in own.shape]
    columns: Any = own.columns(field, _SLIPS, *shape)
    given = type(columns).__name__
    if type(columns) is tuple:
        count = len(cast("tuple[Any, ...]", columns))
        given = f"{count} columns"
    if given != f"{len(own.gains)} columns":
        gains = ", ".join(gain.name for gain in own.gains)
        raise plugin.fault(
            f"must return a tuple with a column for each of its gains ({gains}), it returns {given}"
        )
    for gain, column in zip(own.gains, cast("tuple[Any, ...]", columns), strict=True):
        if (
            np.shape(column) != _SLIPS.shape
            or np.iscomplexobj(column)
            or not np.isfinite(column).all()
        ):
            raise plugin.fault(
                f"returns for the gain {gain.name} what is no finite array of the rows: {column}"
            )
    if not np.array_equal(cast("tuple[Any, ...]", columns), own.columns(field, _SLIPS, *shape)):
        raise plugin.fault("returns other numbers for the same rows when it is asked again")
    # Derivatives run through the same function.
    derived = own.columns(field, _SLIPS, *(Dual(x, {place: 1.0}) for place, x in enumerate(shape)))
    for gain, column in zip(own.gains, derived, strict=True):
        if np.asarray(getattr(column, "value", column)).dtype.kind not in "fiu":
            what = f"loses the derivatives for the gain {gain.name}: it may use operators and NumPy's functions alone"
            raise plugin.fault(f"{what}, and not np.asarray, np.array or float")
    return own


def typical(shape: ShapeParameter) -> float:
    """A number from the middle of the usual range of a parameter."""
    low, high = shape.scanned
    if shape.scale == "log":
        return float(np.sqrt(low * high))
    return 0.5 * (low + high)
