"""A table of JSON names its columns in one list, as texts or as objects with a unit, and holds its rows in another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from erclutch.logs.readers.stated_units import with_units

#: What the list of names is called: the first by pandas (orient="split"), the others by programs of benches.
COLUMNS = (
    *("columns", "channels", "signals", "fields", "names", "headers", "header"),
    *("labels", "variables", "column_names", "channel_names"),
)
NAME = ("name", "label", "signal", "channel", "key", "id")
UNIT = ("unit", "units")


def table_with_columns(fields: Mapping[str, Any]) -> dict[str, list[Any]] | None:
    """The columns of a table by their labels; None where an object is no such table."""
    for key in COLUMNS:
        labels = _labels(fields.get(key))
        if labels is None:
            continue
        labels = with_units(labels, fields.get("units"))
        for other, each in fields.items():
            if other in (key, "index", "units") or not isinstance(each, list) or not each:
                continue
            rows = cast("list[Any]", each)
            lengths = {len(cast("list[Any]", row)) if isinstance(row, list) else 0 for row in rows}
            if lengths == {len(labels)}:
                return {label: [row[place] for row in rows] for place, label in enumerate(labels)}
            # A list for each column in place of a list for each row.
            if len(rows) == len(labels) > 1 == len(lengths) and 0 not in lengths:
                return dict(zip(labels, rows, strict=True))
    return None


def text_of(item: Mapping[str, Any], keys: Sequence[str]) -> str | None:
    """The text under the first of some keys that has a text."""
    in_small_letters = {key.lower(): key for key in [*item][::-1]}
    for key in keys:
        text = item.get(in_small_letters.get(key.lower(), key))
        if isinstance(text, str):
            return text
    return None


def labelled(label: str, unit: str | None) -> str:
    """``speed [rad/s]``; a label that has brackets already stays as it is."""
    return f"{label} [{unit}]" if unit and "[" not in label else label


def _labels(columns: Any) -> list[str] | None:
    """Labels of columns that have a name each, with their units; None for anything else."""
    if not isinstance(columns, list) or not columns:
        return None
    labels: list[str] = []
    for each in cast("list[Any]", columns):
        column: dict[str, Any] = {"name": each}
        if isinstance(each, dict):
            column = cast("dict[str, Any]", each)
        name = text_of(column, NAME)
        if name is None:
            return None
        with_text = {key: text for key, text in column.items() if text != ""}
        labels.append(labelled(name, text_of(with_text, UNIT)))
    return labels if len({*labels}) == len(labels) else None
