"""Log files of test benches become Recordings: text of any dialect, binary formats by plug-ins, or arrays in memory.

    recording = read("run1.csv", ColumnMap.from_labels({"slip": "V [cm/s]", "field": "Y [V]", "effort": "F [N]"}))

A reader gives a `Table`, `plan_of` makes a `Plan` of it, and `apply` carries the plan out; `read` does all three.
Nothing is guessed in silence: each choice, guess, conversion, gap and dropped row is a sentence in ``Recording.notes``.

Names are looked up when they are first used: the child in which a reader works needs the reader and no plan.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from erclutch.logs.applied import apply
    from erclutch.logs.batches import Batch, RowRange
    from erclutch.logs.log_file import read_table, recordings_in
    from erclutch.logs.mapping import ColumnChoice, ColumnMap, map_over
    from erclutch.logs.plan import NEEDS, Plan
    from erclutch.logs.planning.recording_choice import table_of_log
    from erclutch.logs.planning.whole_plan import plan_of
    from erclutch.logs.read_logs import (
        extent_of,
        read,
        read_all,
        read_batches,
        recording_from_arrays,
    )
    from erclutch.logs.table import Table

_HOMES = {
    "applied": ("apply",),
    "batches": ("Batch", "RowRange"),
    "log_file": ("read_table", "recordings_in"),
    "mapping": ("ColumnChoice", "ColumnMap", "map_over"),
    "plan": ("NEEDS", "Plan"),
    "planning.recording_choice": ("table_of_log",),
    "planning.whole_plan": ("plan_of",),
    "read_logs": ("extent_of", "read", "read_all", "read_batches", "recording_from_arrays"),
    "table": ("Table",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "NEEDS",
    "Batch",
    "ColumnChoice",
    "ColumnMap",
    "Plan",
    "RowRange",
    "Table",
    "apply",
    "extent_of",
    "map_over",
    "plan_of",
    "read",
    "read_all",
    "read_batches",
    "read_table",
    "recording_from_arrays",
    "recordings_in",
    "table_of_log",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'erclutch.logs' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"erclutch.logs.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
