"""A log becomes a Recording: its table is read, a plan of it is made, and the plan is carried out.

`read` does so for one log, `read_all` for all recordings of a file, `read_batches` for a file larger than memory.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from erclutch.errors import LogError, keywords_checked, placed
from erclutch.files.given_files import opened_plainly
from erclutch.logs.applied import apply
from erclutch.logs.arrays import table_of_arrays
from erclutch.logs.batches import WHOLE_FILE, Batch, RowRange, one_batch, windowed_batches
from erclutch.logs.clock.resample import resampled
from erclutch.logs.keywords import all_options, options_of, window_and_rate
from erclutch.logs.log_file import group_of, recordings_in, tables_in
from erclutch.logs.log_reader import (
    LogReader,
    LogSource,
    States,
    Windows,
    log_at,
    readable,
    states_of,
    unchanged,
)
from erclutch.logs.mapping import ColumnMap, file_mapping, map_over, told_of
from erclutch.logs.plan import Invalid
from erclutch.logs.planning.recording_choice import table_of_log
from erclutch.logs.planning.whole_plan import plan_of, plans_of_logs, sure_plan_of
from erclutch.logs.table import Table
from erclutch.logs.time_window import within
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording

if TYPE_CHECKING:
    from pandas import DataFrame


def read(
    path: str | Path | DataFrame,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    device: DeviceName | None = None,
    invalid: Invalid | None = None,
    variable: str | None = None,
    mapping_file: str | Path | None = None,
    table: Table | None = None,
    **options: Any,
) -> Recording:
    """Read a log as a Recording in SI units.

    Args:
        path: text (also .gz), .mat (v5 and v7.3), .parquet, .mcap, .mf4, .tdms, .xlsx, .ods, .h5, .lvm, .jsonl, a ROS 2
            bag (its folder or its file), or what a plug-in reads; the content decides. Or a pandas DataFrame, with
            units in its column names or in the mapping, and the time in a column or its index.
        mapping: which column is which signal; a plain mapping is read as labels (``{"slip": "V [cm/s]"}``) or, where it
            has the keys of a mapping file (``columns``, ``time``, ``rate``, ...), as such. It wins over the mapping
            file beside the log, and that over guesses from names and units.
        device: "single" (field, slip or position, effort) or "coaxial" (E1 and E2 or E; theta or theta_dot; alpha,
            alpha_dot or alpha_raw with a lead; T). None: what a recording of the live loop says, else "single".
        invalid: "error" refuses missing or infinite values, "drop" cuts the log there. None: a few missing values cut
            it, more of them and infinite ones are refused.
        variable: which recording of a file that holds several: variable, group, sheet, topic; or ``COLUMN=WORD``, the
            rows in which a column has a word.
        mapping_file: a mapping file in place of the one beside the log.
        table: the log as `read_table` gave it, where that was called before; the file is not read again.
        **options: what the options of ``erclutch fit`` say, by their names: a column for a signal or the time
            (``field="current [A]"``), and rate, lead, constant, scale, input, name_pattern, decimal, keep_values; also
            begin, end and skip of a window in time, and resample. They win over the mapping.

    Raises:
        SettingError: a window or a rate that the log cannot have.
        LogError: the file cannot be read as a table of finite numbers (TimingError: or its time cannot be put right).
        MappingError: signals without a column or with several (UnitError: with a unit that does not fit).
    """
    said = options_of(options)
    repeated = all_options(mapping, said)  # so that the next logs may be read alike
    window, rate = window_and_rate(said)
    told = told_of(path, mapping, said, mapping_file)
    told = replace(told, variable=variable or told.variable)
    if table is None:
        table = table_of_log(path, told, device, told.variable)
    plan = sure_plan_of(table, told, device, invalid)
    log = within(apply(plan, table), *window)
    log = replace(log, told=repeated)
    return log if rate is None else resampled(log.without_jumps(), rate)


def read_all(
    path: str | Path,
    mapping: ColumnMap,
    *,
    device: DeviceName | None = None,
    invalid: Invalid | None = None,
    mapping_file: str | Path | None = None,
) -> list[Recording]:
    """All recordings of a file, and all efforts of each, as logs under names of their own.

    The arguments are those of `read`; the effort may be a pattern such as ``F_* [N]``.

    Raises:
        LogError, MappingError: see `read`.
    """
    from erclutch.logs.planning.several_efforts import logs_of

    file = log_at(path).path
    told = mapping.over(file_mapping(file, mapping_file))
    names = recordings_in(file, told.variable)
    tables: dict[str, Table] = {}
    for name, table in tables_in(file, names or [""], told.decimal).items():
        if isinstance(table, LogError):
            raise table
        tables[name] = table
    logs: list[Recording] = []
    parts = logs_of(tables, replace(told, variable=None), device)
    plans = [
        (name, table, plan_of(table, own, device=device, invalid=invalid))
        for name, table, own in parts
    ]
    # A sheet of settings or results beside sheets of rows has no motion with its effort: it is no log.
    of_logs = plans_of_logs(parts, device)
    others = [name for name, _, _ in parts if name not in of_logs]
    others = others if len(others) < len(plans) else []
    for name, table, plan in plans:
        if name in others:
            continue
        if others and not logs:
            left = f"{', '.join(others)} left out: no columns of a motion and an effort in there"
            plan = replace(plan, notes=(*plan.notes, left))
        plan.require_sureness()
        log = apply(plan, table)
        if name:
            digest = hashlib.sha256(f"{log.digest} {name}".encode()).hexdigest()
            log = replace(log, name=f"{log.name}: {name}", digest=digest)
        logs.append(log)
    return logs


def read_batches(
    path: str | Path,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    device: DeviceName | None = None,
    invalid: Invalid | None = None,
    variable: str | None = None,
    mapping_file: str | Path | None = None,
    rows: int = 65_536,
    part: RowRange = WHOLE_FILE,
) -> Iterator[Batch]:
    """Read a log stretch by stretch, so that a Parquet or text file may be larger than memory; others come whole.

    Columns, units, gaps and values are checked as by `read`, a stretch at a time. All arguments are those of `read`,
    but for ``rows``, of a stretch and at least 10,000, and ``part``, the rows of the file that are read.

    Raises:
        LogError, MappingError: see `read`; what is wrong with a later stretch names its rows.
        SettingError: a constant that is given by segments.
    """
    log = log_at(path)
    file = log.path
    plugin = log.plugin
    told = map_over(mapping, file_mapping(file, mapping_file))
    windows = plugin.of_type(LogReader).windows
    if windows and group_of(variable or told.variable) is None:
        before = states_of([file])  # ahead of the digest
        with unchanged(before), readable(file), opened_plainly(file) as content:
            digest = (
                hashlib.file_digest(content, "sha256").hexdigest() if part == WHOLE_FILE else ""
            )
        source = LogSource(file, b"", digest, decimal=told.decimal)
        with placed(file.name), plugin.working(f"failed on {file.name}", alone=False):
            yield from windowed_batches(
                _unchanged_windows(windows, before), source, told, device, invalid, rows, part
            )
        return
    table = table_of_log(file, told, device, variable or told.variable)
    plan = sure_plan_of(table, told, device, invalid)
    yield one_batch(apply(plan, table))


def extent_of(path: str | Path) -> tuple[int, int] | None:
    """About how many rows and columns a log has that can be read in blocks; None for a log that is read whole.

    Raises:
        LogError: the file cannot be read.
    """
    log = log_at(path)
    file = log.path
    plugin = log.plugin
    extent = plugin.of_type(LogReader).extent
    if extent is None:
        return None
    with placed(file.name), plugin.working(f"failed on {file.name}"):
        return extent(file)


@keywords_checked
def recording_from_arrays(
    signals: Mapping[str, ArrayLike],
    units: Mapping[str, str] | None = None,
    *,
    time: ArrayLike | None = None,
    rate: float | None = None,
    name: str = "arrays",
    device: DeviceName = "single",
    invalid: Invalid | None = None,
    lead: float | None = None,
) -> Recording:
    """A Recording of data that is already in memory, through the same checks as a file.

    Args:
        signals: signal name -> samples, each of shape (n,).
        units: signal name -> unit; a signal without one is treated like a column without one.
        time: stamps in s, shape (n,); or ``rate`` in Hz.
        rate: sampling rate in Hz, instead of ``time``.
        name: what the recording is called.
        device: see `read`.
        invalid: see `read`.
        lead: lead of the screw in m, for alpha_raw.

    Raises:
        MappingError: unknown names, arrays of different lengths, neither time nor rate.
        LogError, TimingError: see `read`.
    """
    table = table_of_arrays(name, signals, units or {}, None if rate is not None else time)
    columns = {signal: {"column": signal} for signal in signals}
    told = ColumnMap.from_dict({"columns": columns, "rate": rate, "lead": lead})
    return apply(plan_of(table, told, device=device, invalid=invalid), table)


def _unchanged_windows(windows: Windows, before: States) -> Windows:
    """The same windows, as long as the file has its state of an earlier look."""

    def checked(
        source: LogSource, rows: int, margin: int, first: int, last: int | None
    ) -> Iterator[tuple[int, int, Table]]:
        with unchanged(before):
            each = iter(windows(source, rows, margin, first, last))
        while True:
            with unchanged(before):
                window = next(each, None)
            if window is None:
                return
            yield window

    return checked
