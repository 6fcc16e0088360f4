"""Cells and struct arrays of MATLAB are opened: each vector and struct in them is a variable of its own."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from erclutch.logs.readers.found_recordings import told_apart
from erclutch.logs.readers.vectors import matrix_of, vector
from erclutch.signals import units

_LONGEST_NAME = 60  # characters
_OF_UNITS = re.compile(r"unit|einheit", re.IGNORECASE)  # in the name of a variable
#: Variables that name or describe the columns of a matrix in one text.
_OF_COLUMNS = re.compile(
    r"(?:.*_)?(?:columns?|names?|labels?|headers?|channels?|variables?|fields?|signals?|units?)",
    re.IGNORECASE,
)


def opened(nodes: dict[str, Any], *, as_structs: bool = True) -> dict[str, Any]:
    """Cells and struct arrays opened: several structs are name(1), name(2), ..., and vectors name_1, name_2, ...

    A cell of as many texts as a cell has vectors, or a matrix has columns, gives their names. Where another variable
    has parts of the same names, as two runs below one line of names, the parts stay together as a struct, or are called
    ``run1.speed`` and so on.
    """
    headings: dict[str, list[str]] = {}  # texts by the name of their variable
    for name, node in nodes.items():
        if all_of(node, str):
            headings[name] = cast("list[str]", node)
        elif isinstance(node, str) and "," in node and _OF_COLUMNS.fullmatch(name):
            headings[name] = [part.strip() for part in node.split(",")]
        elif isinstance(node, str) and "\n" in node:
            # An array of characters has lines, which are filled up to one length.
            lines = [line.strip() for line in node.split("\n")]
            if max(map(len, lines)) <= _LONGEST_NAME:
                headings[name] = lines
    parts_of: dict[str, dict[str, Any]] = {}  # of each variable
    for name, node in nodes.items():
        if all_of(node, str):
            continue
        if all_of(node, dict):
            parts_of[name] = _opened_structs(name, cast("list[dict[str, Any]]", node))
            continue

        items = cast("list[Any]", node) if all_of(node, np.ndarray) else []
        if items and all(vector(item) is not None for item in items):
            whole = {key: texts for key, texts in headings.items() if all(texts)}
            texts = heads_of(len(items), whole)
            names = texts or [f"{name}_{place}" for place in range(1, len(items) + 1)]
            parts_of[name] = dict(zip(names, items, strict=True))
            continue

        matrix = matrix_of(node)
        texts = heads_of(matrix.shape[1], headings) if matrix is not None else None
        if matrix is None or texts is None:
            parts_of[name] = {name: node}
            continue
        names = [text or f"{name}_{number}" for number, text in enumerate(texts, start=1)]
        parts_of[name] = dict(zip(names, matrix.T, strict=True))

    uses = Counter(label for parts in parts_of.values() for label in parts)
    variables: dict[str, Any] = {}
    for name, parts in parts_of.items():
        no_other_has_them = all(uses[label] == 1 for label in parts)
        if no_other_has_them or [*parts] == [name]:
            variables |= parts
        elif as_structs:
            variables[name] = parts
        else:
            variables |= {f"{name}.{label}": part for label, part in parts.items()}
    return variables


def heads_of(count: int, headings: Mapping[str, list[str]]) -> list[str] | None:
    """The one cell of as many different texts, with the units of a cell of as many; None where two cells may be it."""
    fitting = {key: texts for key, texts in headings.items() if len(texts) == count}
    if len(fitting) > 1:
        of_units = [key for key in fitting if _OF_UNITS.search(key)]
        if not of_units:
            for key, texts in fitting.items():
                # A signal without a unit has an empty text or a line.
                written = [text for text in texts if text.strip(" -")]
                if written and all(map(units.is_unit, written)):
                    of_units.append(key)
    else:
        of_units = []
    names = [texts for key, texts in fitting.items() if key not in of_units]
    if len(names) != 1 or len(of_units) > 1 or len({*names[0]}) < count:
        return None
    if not of_units:
        return names[0]
    labels: list[str] = []
    for name, unit in zip(names[0], fitting[of_units[0]], strict=True):
        wants_unit = name and unit.strip(" -") and "[" not in name
        labels.append(f"{name} [{unit}]" if wants_unit else name)
    return labels


def _opened_structs(name: str, items: list[dict[str, Any]]) -> dict[str, Any]:
    """Structs that are a signal each under the names of their signals; else each struct under its place.

    The elements of a data set of Simulink are called by their names.
    """
    signals: list[tuple[str, Any]] = []
    for place, item in enumerate(items, start=1):
        signal = signal_in(item, f"{name}_{place}")
        if signal is not None:
            signals.append(signal)
    if len(signals) == len(items):
        labels = told_apart([label for label, _ in signals])
        return dict(zip(labels, (numbers for _, numbers in signals), strict=True))
    if len(items) == 1:
        return {name: items[0]}

    elements: dict[str, Any] = {}
    for item in items:
        names: list[str] = []
        structs: list[dict[str, Any]] = []
        for key, node in item.items():
            if key.lower() == "name" and isinstance(node, str) and node:
                names.append(node)
            if isinstance(node, dict):
                structs.append(cast("dict[str, Any]", node))
        if len(names) == len(structs) == 1:
            (values,) = structs
            if {key.lower() for key in values} >= {"time", "data"}:
                elements[names[0]] = values
    if len(elements) == len(items):
        return elements
    return {f"{name}({place})": item for place, item in enumerate(items, start=1)}


def signal_in(item: dict[str, Any], usual: str) -> tuple[str, Any] | None:
    """Label and numbers of a struct that is one signal: one vector, with its name and its unit as texts."""
    vectors: list[Any] = []
    texts: dict[str, str] = {}
    for key, node in item.items():
        if isinstance(node, dict | list):
            return None
        numbers = vector(node)
        if numbers is not None and numbers.size > 1:
            vectors.append(node)
        if isinstance(node, str) and node.strip():
            texts[key.lower()] = node
    if len(vectors) != 1:
        return None
    names = [texts[key] for key in ("name", "label", "signal", "channel") if key in texts]
    label = names[0] if names else usual
    unit = texts.get("unit") or texts.get("units")
    return f"{label} [{unit}]" if unit else label, vectors[0]


def all_of(node: Any, kind: type) -> bool:
    """Whether a node is a cell or a struct array of one kind, and not empty."""
    items = cast("list[Any]", node) if isinstance(node, list) else []
    return bool(items) and all(isinstance(item, kind) for item in items)
