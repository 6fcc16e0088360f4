"""Arrays in memory become a Table, as a file does."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from erclutch.errors import MappingError, placed
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS


def table_of_arrays(
    name: str,
    signals: Mapping[str, ArrayLike],
    units: Mapping[str, str],
    time: ArrayLike | None,
) -> Table:
    """A table with a column for each signal.

    Args:
        name: what the table is called.
        signals: signal name -> samples, each of shape (n,).
        units: signal name -> unit.
        time: stamps in s, shape (n,), or None.

    Raises:
        MappingError: unknown names, no numbers, arrays of different lengths.
    """
    with placed(name):
        unknown = [signal for signal in signals if signal not in SIGNALS]
        if unknown:
            raise MappingError(
                f"there is no signal '{unknown[0]}'", remedy=f"Use {', '.join(SIGNALS)}"
            )
        columns = {signal: _vector(signal, values) for signal, values in signals.items()}
        if time is not None:
            columns["time"] = _vector("time", time)
        if len({values.size for values in columns.values()}) > 1:
            listed = ", ".join(f"{signal} {values.size}" for signal, values in columns.items())
            raise MappingError(
                f"the arrays differ in length ({listed})", remedy="Give arrays of one length"
            )
    digest = hashlib.sha256()
    for signal, values in sorted(columns.items()):
        digest.update(signal.encode())
        digest.update(values.tobytes())
    return Table(name, columns, {**units, "time": "s"}, digest.hexdigest())


def _vector(signal: str, values: ArrayLike) -> Array:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MappingError(
            f"{signal} holds no numbers ({error})", remedy="Give an array of numbers"
        ) from error
    if array.ndim != 1:
        raise MappingError(f"{signal} has the shape {array.shape}", remedy="Give a vector")
    return array
