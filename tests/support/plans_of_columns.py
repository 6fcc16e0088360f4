"""Plans of tables whose columns a test writes down by their labels."""

from __future__ import annotations

from collections.abc import Mapping

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.labels import name_columns
from erclutch.signals.array import Array


def table(columns: Mapping[str, Array]) -> Table:
    """A table of columns by their labels, such as ``w [rad/s]``."""
    split = {label: label.rstrip("]").partition(" [") for label in columns}
    values = {split[label][0]: column for label, column in columns.items()}
    return Table(
        "a.csv",
        values,
        {name: unit or None for name, _, unit in split.values()},
        "0" * 64,
        path="a.csv",
    )


def planned(columns: Mapping[str, Array], **labels: str) -> Plan:
    """The plan of such a table, where a user says ``slip="w [rad/s]"``."""
    return plan_of(table(columns), ColumnMap.from_labels(labels))


def planned_by_letters(numbers: Mapping[str, Array], header: str) -> tuple[Plan, dict[str, str]]:
    """The plan of a table, and the letter of each of its columns; these are written as LETTER:LABEL.

    Args:
        numbers: of a column, by its letter.
        header: ``t:Time [s]; v:Speed [rpm]``.
    """
    letters, labels = zip(*(part.split(":", 1) for part in header.split("; ")), strict=True)
    names, own, _ = name_columns(list(labels))
    columns = {name: numbers[letter].copy() for name, letter in zip(names, letters, strict=True)}
    table = Table("a.csv", columns, dict(zip(names, own, strict=True)), "0" * 64, path="a.csv")
    return plan_of(table, ColumnMap()), dict(zip(names, letters, strict=True))
