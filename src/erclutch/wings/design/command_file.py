"""Commands for a rig are written as a log that `erclutch.read` opens, or as a table of C."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.export.c.include_guard import once
from erclutch.export.encode import comment
from erclutch.files import whole_file
from erclutch.logs.log_writer import LabelledColumns, write_log
from erclutch.signals.array import Array
from erclutch.wings.design.courses import Commands
from erclutch.wings.design.limits import DeviceKind

_TABLE = """\
#define ERCLUTCH_COMMANDS_ROWS {rows}
#define ERCLUTCH_COMMANDS_COLUMNS {columns}

/* {names} */
static const double erclutch_commands[ERCLUTCH_COMMANDS_ROWS][ERCLUTCH_COMMANDS_COLUMNS] = {{
{table}
}};
"""


def columns_of(
    commands: Commands,
    device: DeviceKind,
    rate: float,
    field_unit: str,
) -> tuple[LabelledColumns, Array]:
    """Names and units of the columns, and the rows, shape (n, columns)."""
    time = np.arange(commands.speed.size) / rate
    if device == "pair":
        names = (
            ("time", "s"),
            ("E1", field_unit),
            ("E2", field_unit),
            ("theta_dot", "rad/s"),
            ("theta", "rad"),
        )
        fields = (np.maximum(commands.field, 0.0), np.maximum(-commands.field, 0.0))
    else:
        unit = motion_unit(device)
        names = (("time", "s"), ("field", field_unit), ("slip", f"{unit}/s"), ("position", unit))
        fields = (commands.field,)
    return names, np.column_stack([time, *fields, commands.speed, commands.position])


def motion_unit(device: DeviceKind) -> str:
    """The unit of a device's way: m of a damper, else rad."""
    return "m" if device == "damper" else "rad"


def write_commands(
    path: Path,
    columns: LabelledColumns,
    rows: Array,
    about: Mapping[str, Any],
) -> Path:
    """Write rows of commands: .csv, .parquet or .mat as a log, .h as a table of C.

    Raises:
        RunError: another ending, or it cannot be written.
    """
    if path.suffix.lower() != ".h":
        return write_log(path, columns, [rows], about, rows=len(rows))
    lines: list[str] = []
    for row in rows.tolist():
        numbers = ", ".join(f"{number:.9g}" for number in row)
        lines.append(f"  {{{numbers}}}")
    text = _TABLE.format(
        rows=len(rows),
        columns=len(columns),
        names=comment(", ".join(f"{name} [{unit or 1}]" for name, unit in columns)),
        table=",\n".join(lines),
    )
    headline = comment(f"{about['label']}: {dict(about)}")
    guarded = once("ERCLUTCH_COMMANDS_H", text)
    with whole_file(path) as unfinished:
        unfinished.write_text(f"/* {headline} */\n{guarded}", encoding="utf-8")
    return path
