"""Arrays of MATLAB and NumPy may hold trials beside each other: the pages of an array, or the columns of matrices.

Pages are trials where names say which side of the array has the signals. Columns are trials where a field is given for
each of them: of the joints of a robot, each has a course of its own and no field.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.names import spoken_name
from erclutch.signals import units

Trials = dict[str, dict[str, Any]]  # vectors by label, of each trial by its name
_MOST = 64  # trials
_FEWEST_ROWS = 10  # for each trial
_FEWEST_SIGNALS, _MOST_SIGNALS = 3, 16  # of a matrix, the time among them
_DIGITS = re.compile(r"\d+")


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

    if len(arrays) > 1 and all(array.ndim == 2 for array in arrays.values()):
        each_a_trial = _matrices(arrays, texts)
        if each_a_trial:
            return each_a_trial

    # The columns of matrices of one shape are trials beside a field with a number for each column.
    shapes = {array.shape for array in arrays.values() if array.ndim == 2}
    if len(shapes) != 1:
        return {}
    shape = shapes.pop()
    rows, count = max(shape), min(shape)
    if shape[0] < shape[1]:  # a trial in each row
        arrays = {name: array.T for name, array in arrays.items()}
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


def _matrices(arrays: Mapping[str, np.ndarray[Any, Any]], texts: Sequence[Sequence[str]]) -> Trials:
    """A trial of each matrix, where their names differ in numbers alone and the first column of each is a time."""
    upright = {
        name: array if len(array) >= array.shape[1] else array.T for name, array in arrays.items()
    }
    widths = {array.shape[1] for array in upright.values()}
    are_alike = len({_DIGITS.sub("", name) for name in upright}) == 1
    if len(widths) != 1 or not are_alike or len(upright) > _MOST:
        return {}
    width = widths.pop()
    have_a_time = all(bool(np.all(np.diff(array[:, 0]) > 0)) for array in upright.values())
    are_long = min(map(len, upright.values())) >= _FEWEST_ROWS
    if not _FEWEST_SIGNALS <= width <= _MOST_SIGNALS or not have_a_time or not are_long:
        return {}
    labels = next((each for each in texts if len({*each}) == width), None)
    labels = labels or [f"c{number}" for number in range(1, width + 1)]
    return {name: dict(zip(labels, array.T, strict=True)) for name, array in upright.items()}


def without_names(nodes: Mapping[str, Any]) -> LogError | None:
    """The error for arrays of three sides, of which nothing beside them says which side has the signals."""
    for name, node in nodes.items():
        if not isinstance(node, np.ndarray):
            continue
        array = cast("np.ndarray[Any, Any]", node)
        if array.squeeze().ndim == 3 and array.dtype.kind in "biuf":
            sides = " x ".join(map(str, array.shape))
            no_names = "no names beside it say which side has the signals"
            example = "columns = time, current, speed, torque"
            remedy = f"Save their names in the same file, such as {example}"
            return LogError(f"array {name} is {sides}, and {no_names}", remedy=remedy)
    return None


def _pages(name: str, array: np.ndarray[Any, Any], texts: Sequence[Sequence[str]]) -> Trials:
    """The pages of an array, one of whose sides is as long as a list of names; the longest has the rows.

    Where two sides are as long, the one along which the time would rise from row to row has the signals.
    """
    rows = int(np.argmax(array.shape))
    for axis in (side for side in range(3) if side != rows):
        count = array.shape[axis]
        pages = 3 - rows - axis
        few = array.shape[pages] <= _MOST and array.shape[rows] >= _FEWEST_ROWS * array.shape[pages]
        fitting = [each for each in texts if len(each) == count]
        lists_of_units = [each for each in fitting if all(map(units.is_unit, each))]
        names = next((each for each in fitting if each not in lists_of_units), ())
        if not few or len({*names}) != count:
            continue
        upright = np.transpose(array, (pages, rows, axis))  # trials by rows by signals
        if count == array.shape[pages]:
            # The names are those of this side if the column that is called like the time rises in each trial.
            times = [place for place, each in enumerate(names) if spoken_name(each).is_time]
            if len(times) != 1 or not np.all(np.diff(upright[:, :, times[0]], axis=1) > 0):
                continue
        labels = [*names]
        if lists_of_units:
            pairs = zip(names, lists_of_units[0], strict=True)
            labels = [f"{each} [{unit}]" for each, unit in pairs]
        trials: Trials = {}
        for number, page in enumerate(upright, start=1):
            trials[f"{name}({number})"] = dict(zip(labels, page.T, strict=True))
        return trials
    return {}
