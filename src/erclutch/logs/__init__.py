"""Log files of test benches become Recordings: text of any dialect, binary formats by plug-ins, or arrays in memory.

    recording = read("run1.csv", ColumnMap.from_labels({"slip": "V [cm/s]", "field": "Y [V]", "effort": "F [N]"}))

Nothing is guessed in silence: each choice, guess, conversion, gap and dropped row is a sentence in ``Recording.notes``.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from erclutch.errors import LogError, MappingError, placed
from erclutch.logs.assemble import NEEDS, Invalid, assemble
from erclutch.logs.batches import Batch, windowed_batches
from erclutch.logs.log_reader import HEAD, LogReader, LogSource, folder_reader, read_by, reader_of, require_no_run
from erclutch.logs.mapping import ColumnChoice, ColumnMap, beside
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NAMED_COLUMNS, SIGNALS, Recording

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = [
    "NEEDS",
    "Batch",
    "ColumnChoice",
    "ColumnMap",
    "Table",
    "map_over",
    "read",
    "read_all",
    "read_batches",
    "read_table",
    "recording_from_arrays",
    "recordings_in",
    "table_of",
]

_LARGEST = 4 << 30  # bytes
_ROWS_WANTED = "Give a log with one row a sample"


def read(
    path: str | Path | DataFrame,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    device: DeviceName = "single",
    invalid: Invalid | None = None,
    variable: str | None = None,
    mapping_file: str | Path | None = None,
    table: Table | None = None,
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
            alpha_dot or alpha_raw with a lead; T).
        invalid: "error" (default) refuses missing or infinite values, "drop" cuts the log there.
        variable: which recording of a file that holds several: variable, group, sheet, topic.
        mapping_file: a mapping file in place of the one beside the log.
        table: the log as `read_table` gave it, where that was called before; the file is not read again.

    Raises:
        LogError: the file cannot be read as a table of finite numbers (TimingError: or its time cannot be put right).
        MappingError: signals without a column or with several (UnitError: with a unit that does not fit).
    """
    if not isinstance(path, str | Path):
        own = None if mapping_file is None else ColumnMap.from_toml(mapping_file)
        return assemble(table_of(path), map_over(mapping, own), device=device, invalid=invalid)
    file, chosen = _file_and_map(path, mapping, mapping_file)
    table = read_table(file, variable=variable or chosen.variable) if table is None else table
    return assemble(table, chosen, device=device, invalid=invalid)


def read_all(
    path: str | Path,
    mapping: ColumnMap,
    *,
    device: DeviceName = "single",
    invalid: Invalid | None = None,
    mapping_file: str | Path | None = None,
) -> list[Recording]:
    """All recordings of a file, and all efforts of each, as logs under names of their own.

    The arguments are those of `read`; the effort may be a pattern such as ``F_* [N]``.

    Raises:
        LogError, MappingError: see `read`.
    """
    from erclutch.logs.several_efforts import logs_of

    file, chosen = _file_and_map(path, mapping, mapping_file)
    chosen, names = replace(chosen, variable=None), recordings_in(file)
    tables = {name: read_table(file, variable=name) for name in names} or {"": read_table(file)}
    found: list[Recording] = []
    for name, table, own in logs_of(tables, chosen, device):
        log = assemble(table, own, device=device, invalid=invalid)
        digest = hashlib.sha256(f"{log.digest} {name}".encode()).hexdigest()
        found.append(replace(log, name=f"{log.name}: {name}", digest=digest) if name else log)
    return found


def recordings_in(path: str | Path) -> list[str]:
    """Names of the recordings that a file holds beside each other; none where it is a recording itself.

    Raises:
        LogError: the file cannot be read.
    """
    file = _require_file(path)
    with _readable(file):
        data = file.read_bytes()
    plugin, _ = reader_of(data[:HEAD], file.suffix)
    listed = plugin.of_type(LogReader).recordings
    source = LogSource(file, data, "")
    with placed(file.name), plugin.working(f"failed on {file.name}"):
        return list(listed(source)) if listed is not None else []


def table_of(log: str | Path | DataFrame, variable: str | None = None) -> Table:
    """The table of a file, or that of a DataFrame.

    Raises:
        LogError: see `read`.
    """
    if isinstance(log, str | Path):
        return read_table(log, variable=variable)
    from erclutch.logs.data_frame import table_of_frame

    return table_of_frame(log)


def map_over(mapping: ColumnMap | Mapping[str, Any] | None, base: ColumnMap | None) -> ColumnMap:
    """What is given as a mapping (see `read`), over another one.

    Raises:
        MappingError: an unknown key or signal.
    """
    if not isinstance(mapping, ColumnMap):
        labels = set(mapping or ()) <= {*NAMED_COLUMNS, "time"}
        mapping = ColumnMap.from_labels(mapping or {}) if labels else ColumnMap.from_dict(mapping or {})
    return mapping if base is None else mapping.over(base)


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

    Columns, units, gaps and values are checked as by `read`, a stretch at a time. All arguments but ``rows``, of a
    stretch and at least 10,000, are those of `read`.

    Raises:
        LogError, MappingError: see `read`; what is wrong with a later stretch names its rows.
        SettingError: a constant that is given by segments.
    """
    file, chosen = _file_and_map(path, mapping, mapping_file)
    plugin = folder_reader(file)
    if plugin is None:
        with _readable(file), file.open("rb") as content:
            plugin = reader_of(content.read(HEAD), file.suffix)[0]
    windows = plugin.of_type(LogReader).windows
    if windows:
        with _readable(file), file.open("rb") as content:
            digest = hashlib.file_digest(content, "sha256").hexdigest()
        with placed(file.name), plugin.working(f"failed on {file.name}"):
            yield from windowed_batches(windows, file, digest, chosen, device, invalid, rows)
        return
    table = read_table(file, variable=variable or chosen.variable)
    whole = assemble(table, chosen, device=device, invalid=invalid)
    yield Batch(whole, np.arange(whole.rows), 0, whole.rows)


def read_table(
    path: str | Path, *, variable: str | None = None, told: Callable[[int, int], None] = lambda done, total: None
) -> Table:
    """Read a log as it is: raw columns and units, nothing converted.

    Args:
        path: see `read`.
        variable: which recording of a file that holds several: variable, group, sheet, topic.
        told: called with how many bytes of a long text were read, and of how many.

    Raises:
        LogError: no such file, no permission, not a log, damaged, or without a column of numbers.
    """
    file = _require_file(path)
    plugin = folder_reader(file)
    with placed(file.name):
        data = b"" if plugin else _bytes(file)
        digest = _folder_digest(file) if plugin else hashlib.sha256(data).hexdigest()
    plugin, notes = (plugin, list[str]()) if plugin else reader_of(data[:HEAD], file.suffix)
    table = read_by(plugin, LogSource(file, data, digest, variable, told))
    if not table.columns or not table.rows:
        raise LogError("the file has no rows of numbers", remedy=_ROWS_WANTED, where=table.name)
    return replace(table, notes=(*table.notes, *notes), path=str(path))


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
    with placed(name):
        columns = _columns(signals, None if rate is not None else time)
    digest = hashlib.sha256()
    for signal, values in sorted(columns.items()):
        digest.update(signal.encode())
        digest.update(values.tobytes())
    table = Table(name, columns, {**(units or {}), "time": "s"}, digest.hexdigest())
    chosen: dict[str, Any] = {"columns": {signal: {"column": signal} for signal in signals}, "rate": rate, "lead": lead}
    return assemble(table, ColumnMap.from_dict(chosen), device=device, invalid=invalid)


def _columns(signals: Mapping[str, ArrayLike], time: ArrayLike | None) -> dict[str, Array]:
    """The signals and the time as vectors of one length."""
    unknown = [signal for signal in signals if signal not in SIGNALS]
    if unknown:
        raise MappingError(f"there is no signal '{unknown[0]}'", remedy=f"Use {', '.join(SIGNALS)}")
    columns = {signal: _vector(signal, values) for signal, values in signals.items()}
    if time is not None:
        columns["time"] = _vector("time", time)
    if len({values.size for values in columns.values()}) > 1:
        listed = ", ".join(f"{signal} {values.size}" for signal, values in columns.items())
        raise MappingError(f"the arrays differ in length ({listed})", remedy="Give arrays of one length")
    return columns


def _vector(signal: str, values: ArrayLike) -> Array:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MappingError(f"{signal} holds no numbers ({error})", remedy="Give an array of numbers") from error
    if array.ndim != 1:
        raise MappingError(f"{signal} has the shape {array.shape}", remedy="Give a vector")
    return array


def _file_and_map(
    path: str | Path, mapping: ColumnMap | Mapping[str, Any] | None, mapping_file: str | Path | None
) -> tuple[Path, ColumnMap]:
    """The file, which is there, and the mapping over what the mapping file says."""
    file = _require_file(path)
    return file, map_over(mapping, beside(file) if mapping_file is None else ColumnMap.from_toml(mapping_file))


def _require_file(path: str | Path) -> Path:
    file = Path(path)
    with placed(str(path)):
        try:
            require_no_run(file)
            if file.is_dir() and folder_reader(file) is None:
                raise LogError("this is a folder, not a file", remedy="Give one log file")
            if not file.exists():
                raise LogError("there is no such file", remedy="Check the path")
            if not (file.is_file() or file.is_dir()):
                raise LogError("this is not a regular file", remedy="Give a log file")
        except (OSError, ValueError) as error:
            problem = f"the file cannot be read ({error})"
            raise LogError(problem, remedy="Check the path and its permissions") from error
    return file


def _bytes(file: Path) -> bytes:
    with _readable(file):
        if file.stat().st_size > _LARGEST:
            raise LogError("the file is larger than 4 GiB", remedy="Split the log")
        data = file.read_bytes()
    if not data:
        raise LogError("the file is empty", remedy=_ROWS_WANTED)
    return data


def _folder_digest(folder: Path) -> str:
    """SHA-256 over names and SHA-256 of the files in a folder, by name."""
    digest = hashlib.sha256()
    with _readable(folder):
        inside = sorted(path for path in folder.iterdir() if path.is_file())
        if sum(path.stat().st_size for path in inside) > _LARGEST:
            raise LogError("the files of the folder are larger than 4 GiB", remedy="Split the log")
        for path in inside:
            with path.open("rb") as content:
                digest.update(f"{path.name}\0{hashlib.file_digest(content, 'sha256').hexdigest()}\0".encode())
    return digest.hexdigest()


@contextmanager
def _readable(file: Path) -> Generator[None]:
    try:
        yield
    except OSError as error:
        problem = f"the file cannot be read ({error.strerror})"
        raise LogError(problem, remedy="Check its permissions", where=str(file)) from error
