"""Log files of test benches into Recordings: text of any dialect, MATLAB, Parquet, MCAP, or arrays in memory.

    recording = read("run1.csv", ColumnMap.from_labels({"slip": "V [cm/s]", "field": "Y [V]", "effort": "F [N]"}))

Nothing is guessed in silence: each choice, guess, conversion, gap and dropped row is a sentence in ``Recording.notes``.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from erclutch.errors import LogError, MappingError
from erclutch.logs.assemble import NEEDS, DeviceName, Invalid, assemble
from erclutch.logs.batches import Batch, parquet_batches
from erclutch.logs.mapping import ColumnChoice, ColumnMap, beside
from erclutch.logs.table import Table
from erclutch.signals import SIGNALS, Array, Recording

__all__ = [
    "NEEDS",
    "Batch",
    "ColumnChoice",
    "ColumnMap",
    "Table",
    "read",
    "read_batches",
    "read_table",
    "recording_from_arrays",
]

_LARGEST = 4 << 30  # bytes
_MCAP = b"\x89MCAP0\r\n"


def read(
    path: str | Path,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    device: DeviceName = "single",
    invalid: Invalid | None = None,
    variable: str | None = None,
    mapping_file: str | Path | None = None,
) -> Recording:
    """Read a log as a Recording in SI units.

    Args:
        path: .csv .txt .tsv .dat .asc .log (also .gz), .mat (v5 and v7.3), .parquet .pq, .mcap; the content decides.
        mapping: which column is which signal; a plain mapping is read as labels (``{"slip": "V [cm/s]"}``) or, where it
            has the keys of a mapping file (``columns``, ``time``, ``rate``, ...), as such. It wins over the mapping
            file beside the log, and that over guesses from names and units.
        device: "single" (field, slip or position, effort) or "coaxial" (E1 and E2 or E; theta or theta_dot; alpha,
            alpha_dot or alpha_raw with a lead; T).
        invalid: "error" (default) refuses missing or infinite values, "drop" cuts the log there.
        variable: which recording of a MATLAB file to take, or which topic of an MCAP file.
        mapping_file: a mapping file in place of the one beside the log.

    Raises:
        LogError: the file cannot be read as a table of finite numbers (TimingError: or its time cannot be put right).
        MappingError: signals without a column or with several (UnitError: with a unit that does not fit).
    """
    file = Path(path)
    _require_file(file)
    chosen = _as_map(mapping).over(beside(file) if mapping_file is None else ColumnMap.from_toml(mapping_file))
    table = read_table(file, variable=variable or chosen.variable)
    return assemble(table, chosen, device=device, invalid=invalid or ("drop" if chosen.invalid == "drop" else "error"))


def read_batches(
    path: str | Path,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    device: DeviceName = "single",
    invalid: Invalid | None = None,
    variable: str | None = None,
    mapping_file: str | Path | None = None,
    rows: int = 65_536,
) -> Iterator[Batch]:
    """Read a log stretch by stretch, so that a Parquet file may be larger than memory; other formats come whole.

    Columns, units, gaps and values are checked as by `read`, a stretch at a time.

    Args:
        path: see `read`.
        mapping: see `read`.
        device: see `read`.
        invalid: see `read`.
        variable: see `read`.
        mapping_file: see `read`.
        rows: of a stretch, at least 10,000.

    Raises:
        LogError, MappingError: see `read`; what is wrong with a later stretch names its rows.
        SettingError: a constant that is given by segments.
    """
    from erclutch.logs.parquet import is_parquet

    file = Path(path)
    _require_file(file)
    chosen = _as_map(mapping).over(beside(file) if mapping_file is None else ColumnMap.from_toml(mapping_file))
    how: Invalid = invalid or ("drop" if chosen.invalid == "drop" else "error")
    try:
        batchwise = is_parquet(file)
        digest = _digest(file) if batchwise else ""
    except OSError as error:
        raise _unreadable(path, error) from error
    if batchwise:
        yield from parquet_batches(file, digest, chosen, device, how, rows)
        return
    whole = assemble(read_table(file, variable=variable or chosen.variable), chosen, device=device, invalid=how)
    yield Batch(whole, np.arange(whole.rows), 0, whole.rows)


def _digest(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()


def _unreadable(path: str | Path, error: OSError) -> LogError:
    problem = f"the file cannot be read ({error.strerror})"
    return LogError(problem, remedy="Check its permissions", where=str(path))


def read_table(path: str | Path, *, variable: str | None = None) -> Table:
    """Read a log as it is: raw columns and units, nothing converted.

    Args:
        path: see `read`.
        variable: which recording of a MATLAB file to take, or which topic of an MCAP file.

    Raises:
        LogError: no such file, no permission, not a log, damaged, or without a column of numbers.
    """
    from erclutch.logs import mat, parquet, text

    file = Path(path)
    _require_file(file)
    try:
        if file.stat().st_size > _LARGEST:
            raise LogError("the file is larger than 4 GiB", remedy="Split the log", where=file.name)
        data = file.read_bytes()
    except OSError as error:
        raise _unreadable(path, error) from error
    digest = hashlib.sha256(data).hexdigest()
    suffix = file.suffix.lower()
    if not data:
        raise LogError("the file is empty", remedy="Give a log with one row a sample", where=file.name)
    if mat.version(data[:520]) or suffix == ".mat":
        return _with_columns(mat.read_mat(file.resolve(), data[:520], file.name, digest, variable))
    if data[:4] == parquet.MAGIC or suffix in {".parquet", ".pq"}:
        return _with_columns(parquet.read_parquet(data, file.name, digest))
    if data[:8] == _MCAP or suffix == ".mcap":
        from erclutch.logs import mcap

        return _with_columns(mcap.read_mcap(data, file.name, digest, variable))
    return _with_columns(text.read_text(data, file.name, digest))


def recording_from_arrays(
    signals: Mapping[str, ArrayLike],
    units: Mapping[str, str] | None = None,
    *,
    time: ArrayLike | None = None,
    rate: float | None = None,
    name: str = "arrays",
    device: DeviceName = "single",
    invalid: Invalid = "error",
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
    unknown = [signal for signal in signals if signal not in SIGNALS]
    if unknown:
        raise MappingError(f"there is no signal '{unknown[0]}'", remedy=f"Use {', '.join(SIGNALS)}", where=name)
    columns = {signal: _vector(signal, values, name) for signal, values in signals.items()}
    if time is not None and rate is None:
        columns["time"] = _vector("time", time, name)
    lengths = {signal: values.size for signal, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{signal} {size}" for signal, size in lengths.items())
        raise MappingError(f"the arrays differ in length ({listed})", remedy="Give arrays of one length", where=name)
    digest = hashlib.sha256()
    for signal, values in sorted(columns.items()):
        digest.update(signal.encode())
        digest.update(values.tobytes())
    table = Table(name, columns, {**(units or {}), "time": "s"}, digest.hexdigest())
    chosen: dict[str, Any] = {"columns": {signal: {"column": signal} for signal in signals}, "rate": rate, "lead": lead}
    return assemble(table, ColumnMap.from_dict(chosen), device=device, invalid=invalid)


def _vector(signal: str, values: ArrayLike, name: str) -> Array:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        problem = f"{signal} holds no numbers ({error})"
        raise MappingError(problem, remedy="Give an array of numbers", where=name) from error
    if array.ndim != 1:
        raise MappingError(f"{signal} has the shape {array.shape}", remedy="Give a vector", where=name)
    return array


def _require_file(file: Path) -> None:
    try:
        if file.is_dir():
            raise LogError("this is a folder, not a file", remedy="Give one log file", where=str(file))
        if not file.exists():
            raise LogError("there is no such file", remedy="Check the path", where=str(file))
        if not file.is_file():
            raise LogError("this is not a regular file", remedy="Give a log file", where=str(file))
    except (OSError, ValueError) as error:
        problem = f"the file cannot be read ({error})"
        raise LogError(problem, remedy="Check the path and its permissions", where=str(file)) from error


def _as_map(mapping: ColumnMap | Mapping[str, Any] | None) -> ColumnMap:
    if mapping is None:
        return ColumnMap()
    if isinstance(mapping, ColumnMap):
        return mapping
    labels = set(mapping) <= {*SIGNALS, "time"}
    return ColumnMap.from_labels(mapping) if labels else ColumnMap.from_dict(mapping)


def _with_columns(table: Table) -> Table:
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy="Give a log with one row a sample", where=table.name)
    return table
