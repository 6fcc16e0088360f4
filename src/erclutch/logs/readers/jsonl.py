"""Logs with a JSON object a line (JSON Lines), as microcontrollers and scripts write them.

Each object is a row: ``{"t [s]": 0.001, "field [A]": 0.5, "slip [rad/s]": 3.2, "effort [N m]": 0.11}``. A unit stands
in brackets behind the name.
"""

from __future__ import annotations

import json
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import text
from erclutch.logs.table import Table


def _claims(head: bytes) -> bool:
    return head.lstrip().startswith(b'{"')


def _row(line: str, number: int, name: str) -> dict[str, float]:
    where = f"{name}, line {number}"
    try:
        row: Any = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise LogError(f"the line is no JSON ({error})", remedy="Mend or delete the line", where=where) from error
    if not isinstance(row, dict):
        raise LogError("the line is no JSON object", remedy='Write rows such as {"t [s]": 0.1}', where=where)
    numbers: dict[str, float] = {}
    for label, value in cast("dict[str, object]", row).items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise LogError(f"{label} is {value!r:.40}, no number", remedy="Log numbers only", where=where)
        try:
            numbers[label] = float(value)
        except OverflowError as error:  # an integer of hundreds of digits
            raise LogError(f"{label} is too large", remedy="Mend or delete the line", where=where) from error
    return numbers


def _read(source: LogSource) -> Table:
    try:
        lines = source.data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise LogError(f"the file is no UTF-8 text ({error})", remedy="Save it as UTF-8", where=source.name) from error
    rows = [_row(line, number, source.name) for number, line in enumerate(lines, start=1) if line.strip()]
    labels = list(dict.fromkeys(label for row in rows for label in row))
    names, units, notes = name_columns(labels, [None] * len(labels))
    others = [number for number, row in enumerate(rows, start=1) if len(row) < len(labels)]
    if others:
        notes = [*notes, f"{len(others)} of {len(rows)} rows lack a name, such as row {others[0]}: read as missing"]
    columns = {
        name: np.array([row.get(label, np.nan) for row in rows]) for name, label in zip(names, labels, strict=True)
    }
    return Table(source.name, columns, dict(zip(names, units, strict=True)), source.digest, notes=tuple(notes))


READER = LogReader((".jsonl", ".ndjson"), _claims, _read, tells_damage=text.DAMAGE)
