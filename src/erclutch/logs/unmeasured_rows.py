"""Rows in which a sensor measured nothing are told: codes that loggers write, spikes, ends of a range, stuck values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from erclutch.logs.plan import Plan
from erclutch.logs.sensor_faults import dropped, frozen, saturated, spikes, stuck
from erclutch.logs.sentinels import sentinels
from erclutch.logs.table import Table
from erclutch.signals.array import Mask


def unmeasured_rows(plan: Plan, table: Table, notes: list[str]) -> Mask:
    """Rows that are left out since a signal holds no measurement there, shape (rows of the table,).

    ``notes`` gets what was seen, the column and the number of rows; a user may ask to keep them.
    """
    keep = plan.told.values == "keep"
    unmeasured = np.zeros(table.rows, dtype=np.bool_)
    columns = dict.fromkeys(each.column for each in (*plan.signals, *plan.inputs) if each.column)
    for name in columns:
        for code, rows in sentinels(table.planned(name)).items():
            held = f"column {name} holds {code:g} in {_counted(rows)}, far from all other values"
            if keep:
                notes.append(f"{held}: kept, as asked")
            else:
                why = "what loggers write for no measurement, left out and the log cut there"
                notes.append(f"{held}: {why} (--keep-values keeps it)")
                unmeasured |= rows

    for name, fault, rows in _sensor_faults(plan, table, unmeasured):
        first = table.first_row + int(np.argmax(rows)) + 1
        done = "kept, as asked" if keep else "left out and the log cut there (--keep-values keeps them)"
        notes.append(f"{name} {fault} in {_counted(rows)}, the first in data row {first}: {done}")
        if not keep:
            unmeasured |= rows
    return unmeasured


def _counted(rows: Mask) -> str:
    many = int(rows.sum())
    return f"{many} row{'s' if many > 1 else ''}"


def _sensor_faults(plan: Plan, table: Table, unmeasured: Mask) -> Iterator[tuple[str, str, Mask]]:
    """The columns, what is wrong there, and the rows, for each fault of a sensor; rows without measurement are none."""
    columns = {each.signal: each.column for each in plan.signals if each.column}
    measured = [np.where(unmeasured, np.nan, table.planned(name)) for name in dict.fromkeys(columns.values())]
    together = f"columns {', '.join(dict.fromkeys(columns.values()))}"
    lost = dropped(measured)
    if lost.any():
        yield together, f"all hold {measured[0][np.argmax(lost)]:.6g} and jump there and back", lost
    held = frozen([np.where(lost, np.nan, values) for values in measured])
    if held.any():
        yield together, "stand still together and then jump, as where the logger repeats a row", held
    unmeasured = unmeasured | lost | held
    motion = columns.get("slip") or columns.get("position")
    for signal in ("slip", "effort", "T"):
        if signal not in columns:
            continue
        name = columns[signal]
        values = np.where(unmeasured, np.nan, table.planned(name))
        spiked = spikes(values)
        if spiked.any():
            yield f"column {name}", f"has spikes (up to {np.abs(values[spiked]).max():.4g})", spiked
            values = np.where(spiked, np.nan, values)
        if signal == "slip":
            continue

        ends = saturated(values)
        for end, rows in ends.items():
            yield f"column {name}", f"sits at an end of its sensor's range ({end:.6g})", rows
        if motion and not ends:
            held = stuck(values, table.planned(motion))
            if held.any():
                yield f"column {name}", f"is stuck at {values[np.argmax(held)]:.6g} while column {motion} moves", held
