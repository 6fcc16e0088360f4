"""Stretches of a log that cover its field, slip and motion as the whole log does, to be held out of a fit.

The end of a log may be a rest, or a field that nothing before had. Here a log is cut into windows. The windows that
are held out never touch each other, so each lies between rows that are fitted. The log's first one is never held out:
nobody knows what the fluid remembers there. Rows fall into cells by their field, their slip and the rate of the slip.
Windows are exchanged as long as the cells of the rows held out come nearer to those of all rows. The measured effort
has no say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array, Mask, largest_size
from erclutch.signals.device import Element

#: The word that asks for such stretches.
STRETCHES = "stretches"
#: Share of the rows that is held out, where nobody says another.
USUAL_SHARE = 0.3
_WINDOWS = 20  # of a long log
_FEWEST_WINDOWS = 7
_FEWEST_ROWS = 50  # of a window
_FEWEST_AT_A_FIELD = 4  # points of a table, on average
_SAME_FIELD = 0.02  # of the largest field: between neighbours of one level
_GOLDEN = (5**0.5 - 1) / 2
_LEVELS = 4  # of field, slip and its rate, each by its own quantiles


def covering(elements: Sequence[Element], start: int, stop: int) -> Mask:
    """The rows that are held out of the log with the rows [start, stop), shape (n,) over all rows of the elements.

    Of a log with fewer than 350 rows the end is held out.
    """
    mask = np.zeros(elements[0].field.size, np.bool_)
    rows = stop - start
    windows = min(_WINDOWS, rows // _FEWEST_ROWS)
    if windows < _FEWEST_WINDOWS:
        trained = round((1 - USUAL_SHARE) * rows)
        mask[start + trained : stop] = True
        return mask
    window = np.arange(rows) * windows // rows  # of each row

    code = np.zeros(rows, np.intp)  # of the cell of each row
    shares = np.arange(1, _LEVELS) / _LEVELS
    for element in elements:
        field = np.abs(element.field[start:stop])
        slip = element.slip[start:stop]
        rate = np.abs(np.diff(slip, prepend=slip[0]))  # a row
        for values in (field, slip, rate):
            # Levels of equally many rows each; equal values lie together.
            edges = np.unique(np.quantile(values, shares))
            level = np.searchsorted(edges, values, side="right")
            code = code * _LEVELS + level
    _, cell = np.unique(code, return_inverse=True)
    cells = int(cell.max()) + 1
    counts = np.bincount(window * cells + cell, minlength=windows * cells)
    rows_in_cells = counts.reshape(windows, cells).astype(np.float64)
    for held in _alike(rows_in_cells):
        mask[start:stop] |= window == held
    return mask


def spread_points(elements: Sequence[Element], start: int, stop: int, share: float) -> Mask:
    """A share of the points [start, stop) of a table, spread over their slips, shape (n,) over all rows.

    A table is sorted by its speeds, so that its last rows are speeds that no other row has. A point of the smallest
    and of the largest slip at each field is never held out.
    """
    mask = np.zeros(elements[0].field.size, np.bool_)
    own = [replace(e, field=e.field[start:stop], slip=e.slip[start:stop]) for e in elements]
    level = field_levels(own)
    if (int(level.max()) + 1) * _FEWEST_AT_A_FIELD > stop - start:
        level[:] = 0  # the field was not set but swept
    keys: list[Array] = []
    for element in own:
        keys += [element.field, element.slip]
    in_order = np.lexsort([*keys, level])
    inner: list[NDArray[np.intp]] = []
    for number in range(int(level.max()) + 1):
        at_a_field = in_order[level[in_order] == number]
        inner.append(at_a_field[1:-1])
    points = start + np.concatenate(inner)
    # Steps by the golden ratio never fall in with a period of the table, such as one of three fields.
    place, _ = np.modf(np.arange(1, points.size + 1) * _GOLDEN)
    count = round(share * (stop - start))
    first_places = np.argsort(place)[:count]
    mask[points[first_places]] = True
    return mask


def field_levels(elements: Sequence[Element]) -> NDArray[np.intp]:
    """The number of the field, or pair of fields, of each point, shape (n,), from the lowest.

    A measured field scatters a little about the field that was set.
    """
    level = np.zeros(elements[0].field.size, np.intp)
    for element in elements:
        order = np.argsort(element.field)
        apart = np.diff(element.field[order]) > _SAME_FIELD * largest_size(element.field)
        own = np.empty(order.size, np.intp)
        own[order] = np.concatenate([[0], np.cumsum(apart)])
        level = level * (int(own.max()) + 1) + own
    _, numbers = np.unique(level, return_inverse=True)
    return numbers.astype(np.intp)


def _alike(counts: Array) -> list[int]:
    """The windows whose rows are together most like all rows; none is the first, and no two are neighbours.

    Args:
        counts: rows of each window in each cell, shape (windows, cells).
    """
    windows = len(counts)
    wanted = USUAL_SHARE * counts.sum(axis=0)  # rows of each cell

    def unlike(some: list[int]) -> float:
        """How far the cells of some windows are from those wanted (Pearson's sum)."""
        away = counts[some].sum(axis=0) - wanted
        return float(np.sum(away**2 / (wanted + 1.0)))

    even = np.linspace(1, windows - 1, round(USUAL_SHARE * windows))
    held: list[int] = even.round().astype(int).tolist()
    best = unlike(held)
    # One window is exchanged at a time, as long as that helps.
    while True:
        exchanged: list[list[int]] = []
        for place in range(len(held)):
            before = held[:place]
            after = held[place + 1 :]
            for new in range(1, windows):
                touches = any(abs(new - other) <= 1 for other in (*before, *after))
                if not touches:
                    exchanged.append([*before, new, *after])
        nearest = min(exchanged, key=unlike)
        cost = unlike(nearest)
        if not cost < best:
            return sorted(held)
        held = nearest
        best = cost
