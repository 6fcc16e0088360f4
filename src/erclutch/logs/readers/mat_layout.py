"""A MATLAB file holds its recording in dSPACE structures, structs and matrices, or plain vectors of the workspace."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from collections.abc import Container, Sequence
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.logs.readers.found_recordings import (
    ALL,
    JOINT,
    TIME,
    WORKSPACE,
    Found,
    RecordingNames,
    gathered,
    join_hint,
    joined_by_time,
    listed,
    time_of,
    told_apart,
)
from erclutch.logs.readers.header_pairs import is_called_a_rate
from erclutch.logs.readers.mat_cells import all_of, opened, signal_in
from erclutch.logs.readers.mat_dspace import dspace, structs_of
from erclutch.logs.readers.told_units import take_told_units, texts_in
from erclutch.logs.readers.trials import trials_in
from erclutch.logs.readers.vectors import matrix_of, of_vectors, vector

_DEEPEST = 6  # structs inside of structs
_LAST_RESULT = "ans"  # of MATLAB, which nobody gave a name; Simulink's To File calls its matrix so


def choose(tree: dict[str, Any], variable: str | None) -> Found:
    """The only recording of the file, or the one that ``variable`` names.

    Single numbers beside the recordings, such as a sampling rate, hold for each of them.

    Raises:
        LogError: none, several without a choice, or no variable of that name.
    """
    recording = _chosen(tree, variable)
    beside: dict[str, float] = {}
    for name, node in tree.items():
        number = vector(node)
        if number is not None and number.size == 1:
            beside[name] = float(number[0])
    # A rate may stand in a struct of settings, or in the struct of each channel.
    rates = {name: values.pop() for name, values in _rates_in(tree).items() if len(values) == 1}
    recording.constants = {**rates, **beside, **recording.constants}
    take_told_units(recording, texts_in(tree))
    return recording


def _rates_in(node: Any, depth: int = 0) -> dict[str, set[float]]:
    """Sampling rates and periods inside of structs, by the last words of their names."""
    rates: dict[str, set[float]] = {}
    if isinstance(node, list) and depth < _DEEPEST:
        for item in cast("list[Any]", node):
            for name, values in _rates_in(item, depth + 1).items():
                rates.setdefault(name, set()).update(values)
    if not isinstance(node, dict) or depth >= _DEEPEST:
        return rates
    for name, field in cast("dict[str, Any]", node).items():
        number = vector(field) if is_called_a_rate(name) else None
        if number is not None and number.size == 1:
            rates.setdefault(name, set()).add(float(number[0]))
        for inner, values in _rates_in(field, depth + 1).items():
            rates.setdefault(inner, set()).update(values)
    return rates


def _chosen(tree: dict[str, Any], variable: str | None) -> Found:
    """The recording that is asked for; see `choose`."""
    asked = [name.strip() for name in (variable or "").split(JOINT)]
    notes: list[str] = []
    if _LAST_RESULT in tree and variable in (None, ALL):
        tree, notes = _without_last_result(tree)
    texts = [cast("list[str]", node) for node in tree.values() if all_of(node, str)]
    trials = trials_in(tree, texts)
    if variable not in tree or variable in trials:
        tree = trials or _with_signals(tree)
    variables = _variables(tree, variable, asked)
    if variable == ALL:
        raise RecordingNames(_recordings_in(variables))
    if variable is not None:
        return _named(variables, variable, asked)

    recordings = _recordings_in(variables)
    loose = _loose(variables, recordings)
    everything = {**recordings, WORKSPACE: loose} if loose else recordings
    of_parts = gathered(everything)
    if len(of_parts) == 1 < len(everything):
        recordings = everything = of_parts
        loose = None
    for recording in everything.values():
        recording.notes += notes

    # The vectors of the workspace are the recording where they are all there is, or more than any struct holds.
    if loose is not None and not recordings:
        return loose
    if loose is not None and time_of(loose):
        most_in_a_struct = max(len(recording.columns) for recording in recordings.values())
        if len(loose.columns) > most_in_a_struct:
            others = ", ".join(recordings)
            loose.notes.insert(
                0, f"recording read from the vectors of the workspace; --variable takes {others}"
            )
            return loose
    if len(everything) == 1:
        name, recording = next(iter(recordings.items()))
        recording.notes.insert(0, f"recording read from variable {name}")
        return recording
    if recordings:
        option = f"--variable {shlex.quote(next(iter(recordings)))}"
        remedy = f"Choose one, such as {option}, or --variable all{join_hint(recordings)}"
        of_loose = f" (the vectors {listed(loose.columns)})" if loose else ""
        problem = f"the file holds several recordings: {', '.join(everything)}{of_loose}"
        raise SeveralRecordingsError(problem, remedy=remedy, option=option)

    problem = f"no recording in the variables {listed(variables)}"
    if any(node is None for node in variables.values()):
        problem += " (objects of these classes cannot be read: save their numbers as vectors, such as obj.Data)"
    raise LogError(problem, remedy="Save a struct of vectors, or vectors of one length")


def _variables(
    tree: dict[str, Any],
    variable: str | None,
    asked: Sequence[str],
) -> dict[str, Any]:
    """The variables among which is chosen: those of the file, or what is inside of its structs and cells."""
    at_top = _has_recording(tree) or _workspace(tree) is not None
    within = _within(tree)
    asked_within = any(name in within and name not in tree for name in asked)
    if not at_top or asked_within:
        tree = within
    without_cells = _within(opened(tree))
    # A matrix below names that another matrix has too.
    has_names = isinstance(without_cells.get(variable or ""), dict)
    if variable in tree and not (has_names and isinstance(tree[variable], np.ndarray | list)):
        return tree
    # Beside a struct that is a recording, cells and struct arrays are what somebody kept with it.
    return without_cells if variable in without_cells or not _has_recording(tree) else tree


def _without_last_result(tree: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The variables without ``ans`` beside a recording; alone it may be that of Simulink: the time, then signals."""
    others = {name: node for name, node in tree.items() if name != _LAST_RESULT}
    beside = _workspace(others)
    vectors_beside = len(beside.columns) if beside is not None else 0
    if _has_recording(others) or vectors_beside > 1:
        return others, [
            f"variable {_LAST_RESULT}, MATLAB's last result without a name, is left out"
        ]
    matrix = matrix_of(tree[_LAST_RESULT])
    if matrix is None:
        return tree, []
    height, width = matrix.shape
    first_row_rises = bool(np.all(np.diff(matrix[0]) > 0))
    if height > width or not first_row_rises:
        return tree, []
    rows: dict[str, Any] = {"time": matrix[0]}
    for number, row in enumerate(matrix[1:], start=2):
        rows[f"{_LAST_RESULT}_{number}"] = row
    note = f"the first row of matrix {_LAST_RESULT} rises: taken for the time, as Simulink's To File writes it"
    return {**others, **rows}, [note]


def _loose(variables: dict[str, Any], recordings: Container[str]) -> Found | None:
    """The vectors beside the structs that are recordings, as a recording; None where there are none."""
    return _vectors({name: node for name, node in variables.items() if name not in recordings})


def _has_recording(variables: dict[str, Any]) -> bool:
    """Whether a struct is a recording."""
    return any(_structure(name, node) is not None for name, node in variables.items())


def _recordings_in(variables: dict[str, Any]) -> dict[str, Found]:
    """Structs that are a recording, by name."""
    recordings: dict[str, Found] = {}
    for name, node in variables.items():
        recording = _structure(name, node)
        if recording is not None:
            recordings[name] = recording
    return recordings


def _named(variables: dict[str, Any], variable: str, asked: Sequence[str]) -> Found:
    """The recording that ``variable`` names, or those that it names together, joined by time."""
    if variable not in variables:
        loose = _loose(variables, _recordings_in(variables)) if variable == WORKSPACE else None
        if loose is not None:
            return loose
        recordings = _recordings_in({name: variables[name] for name in asked if name in variables})
        if len(asked) > 1 and len(recordings) == len({*asked}):
            return joined_by_time(recordings, "variable")
        problem = f"there is no variable '{variable}' (there are: {listed(variables)})"
        raise LogError(problem, remedy="Give one of these as --variable")

    node = variables[variable]
    # A cell of texts beside a matrix names its columns.
    headings = {name: texts for name, texts in variables.items() if all_of(texts, str)}
    recording = _structure(variable, node) or _workspace({**headings, variable: node})
    if recording is None:
        remedy = f"Give another as --variable ({listed(variables)})"
        raise LogError(f"variable '{variable}' holds no recording", remedy=remedy)
    return recording


def _within(tree: dict[str, Any], depth: int = 0) -> dict[str, Any]:
    """The variables, and in place of structs that hold structs, texts and numbers what is in them: ``log.speed``."""
    within: dict[str, Any] = {}
    for name, node in tree.items():
        structs: dict[str, Any] = {}
        holds_others = False
        fields = cast("dict[str, Any]", node) if isinstance(node, dict) else {}
        for key, field in fields.items():
            is_number = isinstance(field, np.ndarray) and field.size < 2
            if isinstance(field, dict) or all_of(field, dict):
                structs[f"{name}.{key}"] = field
            elif not isinstance(field, str) and not is_number:
                holds_others = True
        is_a_shell = structs and not holds_others and depth < _DEEPEST
        if is_a_shell and _structure(name, node) is None:
            within |= _within(structs, depth + 1)
        else:
            within[name] = node
    return within


def _structure(name: str, node: Any) -> Found | None:
    """A recording inside one struct, or None."""
    if not isinstance(node, dict):
        return None
    fields = cast("dict[str, Any]", node)
    signals = structs_of(fields.get("Y")) if "X" in fields else []
    if signals and all({"Name", "Data"} <= signal.keys() for signal in signals):
        return dspace(fields, signals)
    # Some scripts keep the numbers alone.
    axes = structs_of(fields.get("X")) if signals else []
    if axes and all("Data" in each for each in (*axes, *signals)):
        named = [{"Name": f"Y_{k}", **signal} for k, signal in enumerate(signals, start=1)]
        return dspace(fields, named)
    own_name = name.rpartition(".")[2]

    # Simulink's structure with time: one signal is called as the structure is.
    if isinstance(fields.get("signals"), dict | list):
        labels = ["time"] if "time" in fields else []
        values = [fields["time"]] if "time" in fields else []
        logged = structs_of(fields["signals"])
        for number, signal in enumerate(logged, start=1):
            label: Any = signal.get("label")
            if not isinstance(label, str) or not label:
                label = f"signal{number}" if len(logged) > 1 else own_name
            labels.append(label)
            values.append(signal.get("values"))
        return _workspace(dict(zip(told_apart(labels), values, strict=True)))

    # The fields of a timeseries that was made a struct: its numbers are called as the struct is.
    lower = {key.lower(): value for key, value in fields.items()}
    time = lower.get("time")
    data = lower.get("data")
    if data is None and sum(map(_is_vectors, fields.values())) == 2:
        data = next((lower[key] for key in ("values", "value") if key in lower), None)
    if isinstance(time, np.ndarray) and isinstance(data, np.ndarray):
        unit = lower.get("units") or lower.get("unit")
        has_unit = isinstance(unit, str) and unit
        label = f"{own_name} [{unit}]" if has_unit else own_name
        return _workspace({"time": time, label: data})

    # A table that was made a struct: its properties give the units of its variables in their order.
    held = fields.get("Properties")
    properties = cast("dict[str, Any]", held) if isinstance(held, dict) else {}
    names: Any = properties.get("VariableNames")
    units: Any = properties.get("VariableUnits")
    unit_of: dict[str, str] = {}
    if all_of(names, str) and all_of(units, str) and len(names) == len(units):
        unit_of = dict(zip(names, units, strict=True))
    labelled: dict[str, Any] = {}
    for key, node in fields.items():
        unit = unit_of.get(key)
        labelled[f"{key} [{unit}]" if unit else key] = node
    return _workspace(_with_inner(_with_signals(labelled)))


def _with_signals(fields: dict[str, Any]) -> dict[str, Any]:
    """The fields, in which structs of one vector and its unit each, as ``Force.data`` and ``Force.units``, are vectors.

    They are signals of one recording where they have one length, and a unit or a time tells that they are signals.
    """
    signals: dict[str, tuple[str, Any]] = {}  # label and numbers, by field
    for key, node in fields.items():
        signal = signal_in(cast("dict[str, Any]", node), key) if isinstance(node, dict) else None
        if signal is not None:
            signals[key] = signal
    lengths = {int(numbers.size) for _, numbers in signals.values()}
    labels = {label for label, _ in signals.values()}
    tells = any(label.endswith("]") or TIME.fullmatch(label) for label in labels)
    if len(signals) < 2 or len(lengths) > 1 or len(labels) < len(signals) or not tells:
        return fields
    flat: dict[str, Any] = {}
    for key, node in fields.items():
        label, numbers = signals.get(key, (key, node))
        flat[label] = numbers
    return flat


def _with_inner(fields: dict[str, Any]) -> dict[str, Any]:
    """The fields of a struct with vectors, and those of the structs beside them that have no time of their own.

    What is inside is called by its last word where no other one is: ``dq`` of ``state.dq``, but ``hip.angle``.
    """
    if not any(_is_vectors(node) for node in fields.values()):
        return fields
    inner: dict[str, Any] = {}  # by the whole name: hip.angle
    for key, node in fields.items():
        if not isinstance(node, dict):
            continue
        parts = _with_inner(cast("dict[str, Any]", node))
        vectors = {each: part for each, part in parts.items() if _is_vectors(part)}
        if not any(TIME.fullmatch(each) for each in vectors):
            inner |= {f"{key}.{each}": part for each, part in vectors.items()}
    last_words = {whole: whole.rpartition(".")[2] for whole in inner}
    counts = Counter([*fields, *last_words.values()])
    flat = dict(fields)
    for whole, part in inner.items():
        last = last_words[whole]
        flat[last if counts[last] == 1 else whole] = part
    return flat


def _is_vectors(node: Any) -> bool:
    """Whether a node is numbers in rows."""
    array = cast("np.ndarray[Any, Any]", node) if isinstance(node, np.ndarray) else None
    return array is not None and array.size > 1 and array.dtype.kind in "biuf"


def _workspace(nodes: dict[str, Any]) -> Found | None:
    """Vectors of the workspace, of cells and of struct arrays in it."""
    return _vectors(opened(nodes, as_structs=False))


def _vectors(nodes: dict[str, Any]) -> Found | None:
    """Vectors of the workspace, with the units that erclutch writes beside its own."""
    recording = of_vectors(nodes)
    if recording is None:
        return None
    try:
        units: Any = json.loads(recording.metadata.get("erclutch_units", "{}"))
    except (ValueError, RecursionError):
        return recording
    if isinstance(units, dict):
        pairs = cast("dict[str, Any]", units)
        recording.units |= {name: unit for name, unit in pairs.items() if isinstance(unit, str)}
    return recording
