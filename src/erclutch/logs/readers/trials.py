"""Arrays of MATLAB and NumPy may hold trials beside each other: the pages of an array, or the columns of matrices.

Pages are trials where names say which side of the array has the signals. Columns are trials where a field is given for
each of them: of the joints of a robot, each has a course of its own and no field.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from erclutch.logs.columns.names import spoken_name
from erclutch.signals import units

Trials = dict[str, dict[str, Any]]  # vectors by label, of each trial by its name
_MOST = 64  # trials
_FEWEST_ROWS = 10  # for each trial


def trials_in(nodes: Mapping[str, Any], texts: Sequence[Sequence[str]]) -> Trials:
    """The trials in some arrays; none where the arrays are others.

    Args:
        nodes: arrays by name; other nodes are passed over.
        texts: lists of texts beside them, which may be names and units of signals.
    """
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    for name, node in nodes.items():
        if not isinstance(node, np.ndarray):
            continue
        squeezed = cast("np.ndarray[Any, Any]", node).squeeze()
        if squeezed.dtype.kind in "biuf" and squeezed.size > 1:
            arrays[name] = squeezed
    deep = [name for name, array in arrays.items() if array.ndim == 3]
    if len(deep) == 1 == len(arrays):
        return _pages(deep[0], arrays[deep[0]], texts)

    # The columns of matrices of one shape are trials beside a field with a number for each column.
    shapes = {array.shape for array in arrays.values() if array.ndim == 2}
    if len(shapes) != 1:
        return {}
    rows, count = shapes.pop()
    levels = {name: array for name, array in arrays.items() if array.shape == (count,)}
    of_rows = ((rows,), (rows, count))
    courses = {name: array for name, array in arrays.items() if array.shape in of_rows}
    # A name of one letter is not enough: I may be an inertia.
    is_field = any(len(spoken_name(name).forms["field"] or "") > 1 for name in levels)
    are_few = count <= _MOST and rows >= _FEWEST_ROWS * count
    if not is_field or not are_few or len(levels) + len(courses) < len(arrays):
        return {}
    trials: Trials = {}
    for number in range(count):
        columns: dict[str, Any] = {}
        for name, array in courses.items():
            columns[name] = array if array.ndim == 1 else array[:, number]
        for name, array in levels.items():
            columns[name] = np.full(rows, float(array[number]))
        trials[f"trial({number + 1})"] = columns
    return trials


def _pages(name: str, array: np.ndarray[Any, Any], texts: Sequence[Sequence[str]]) -> Trials:
    """The pages of an array, one of whose sides is as long as a list of names."""
    lengths = {len(each) for each in texts}
    of_signals = [axis for axis in range(3) if array.shape[axis] in lengths]
    if len(of_signals) != 1:
        return {}
    count = array.shape[of_signals[0]]
    fitting = [each for each in texts if len(each) == count]
    lists_of_units = [each for each in fitting if all(map(units.is_unit, each))]
    names = next((each for each in fitting if each not in lists_of_units), ())
    if len({*names}) != count:
        return {}
    labels = [*names]
    if lists_of_units:
        labels = [f"{each} [{unit}]" for each, unit in zip(names, lists_of_units[0], strict=True)]
    others = [axis for axis in range(3) if axis not in of_signals]
    rows, pages = sorted(others, key=lambda axis: -array.shape[axis])
    if array.shape[pages] > _MOST or array.shape[rows] < _FEWEST_ROWS * array.shape[pages]:
        return {}
    upright = np.transpose(array, (pages, rows, of_signals[0]))
    trials: Trials = {}
    for number, page in enumerate(upright, start=1):
        trials[f"{name}({number})"] = dict(zip(labels, page.T, strict=True))
    return trials
