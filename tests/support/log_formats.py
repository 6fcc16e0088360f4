"""One log in each format that erclutch reads, written by the usual library of the format, and damage to such files."""

from __future__ import annotations

import gzip
import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

Columns = Mapping[str, tuple[str, np.ndarray]]  # name -> unit and samples


def _time(columns: Columns) -> np.ndarray:
    _, time = columns["time"]
    return time


def _signals(columns: Columns) -> list[tuple[str, str, np.ndarray]]:
    """Name, unit and samples of all columns but the time."""
    return [(name, unit, values) for name, (unit, values) in columns.items() if name != "time"]


def _labels(columns: Columns) -> list[str]:
    return [f"{name} [{unit}]" for name, (unit, _) in columns.items()]


def _rows(columns: Columns) -> list[tuple[float, ...]]:
    """All columns row by row, as Python's floats."""
    return list(zip(*(values.tolist() for _, values in columns.values()), strict=True))


def write_mdf(path: Path, columns: Columns, **options: Any) -> None:
    """MDF4 by asammdf: one channel group."""
    from asammdf import MDF, Signal

    time = _time(columns)
    signals = [
        Signal(values, time, name=name, unit=unit) for name, unit, values in _signals(columns)
    ]
    with MDF(version=options.pop("version", "4.10")) as file:
        file.append(signals, comment="run 1")
        file.save(path, overwrite=True, **options)


def write_tdms(path: Path, columns: Columns) -> None:
    """TDMS by npTDMS: one group, waveform properties."""
    from nptdms import ChannelObject, TdmsWriter

    time = _time(columns)
    clock = {"wf_increment": float(time[1] - time[0]), "wf_start_offset": float(time[0])}
    channels: list[Any] = []
    for name, unit, values in _signals(columns):
        channels.append(ChannelObject("run 1", name, values, {**clock, "unit_string": unit}))
    with TdmsWriter(path) as file:
        file.write_segment(channels)


def write_xlsx(path: Path, columns: Columns) -> None:
    """Excel by openpyxl: a row of names, a row of units."""
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("run 1")
    sheet.append(list(columns))
    sheet.append([unit for unit, _ in columns.values()])
    for row in _rows(columns):
        sheet.append(row)
    book.save(path)


def write_ods(path: Path, columns: Columns) -> None:
    """OpenDocument by hand, after the standard (OASIS ODF 1.3): no office program was at hand."""
    import zipfile

    def cell(value: object) -> str:
        kind = "string" if isinstance(value, str) else f'float" office:value="{value!r}'
        return f'<table:table-cell office:value-type="{kind}"><text:p>{value}</text:p></table:table-cell>'

    rows = [_labels(columns), *_rows(columns)]
    body = "".join(f"<table:table-row>{''.join(map(cell, row))}</table:table-row>" for row in rows)
    names = "".join(
        f' xmlns:{n}="urn:oasis:names:tc:opendocument:xmlns:{n}:1.0"'
        for n in ("office", "table", "text")
    )
    with zipfile.ZipFile(path, "w") as file:
        kind = "application/vnd.oasis.opendocument.spreadsheet"
        file.writestr("mimetype", kind)
        entry = f'<manifest:file-entry manifest:full-path="/" manifest:media-type="{kind}"/>'
        space = 'xmlns:manifest="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"'
        manifest = f'<manifest:manifest {space} manifest:version="1.3">{entry}</manifest:manifest>'
        file.writestr("META-INF/manifest.xml", manifest)
        file.writestr(
            "content.xml",
            f'<?xml version="1.0" encoding="UTF-8"?><office:document-content{names} office:version="1.3"><office:body>'
            f'<office:spreadsheet><table:table table:name="run 1">{body}</table:table></office:spreadsheet>'
            "</office:body></office:document-content>",
            zipfile.ZIP_DEFLATED,
        )


def write_hdf5(path: Path, columns: Columns, **options: Any) -> None:
    """HDF5 by h5py: one group, units as attributes."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, (unit, values) in columns.items():
            file.create_dataset(f"run 1/{name}", data=values, **options).attrs["unit"] = unit


def write_bag(path: Path, columns: Columns, storage: str = "SQLITE3") -> None:
    """A ROS 2 bag by rosbags: a folder, one topic of a message of its own with a header."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    kind = "rig/msg/Row"
    members = "".join(f"float64 {name}\n" for name, _, _ in _signals(columns))
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(f"std_msgs/Header header\n{members}", kind))
    message_of = store.types[kind]
    header_of = store.types["std_msgs/msg/Header"]
    stamp_of = store.types["builtin_interfaces/msg/Time"]
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as bag:
        topic = bag.add_connection("/rig", kind, typestore=store)
        for row, seconds in enumerate(_time(columns)):
            nanoseconds = round(seconds * 1e9)
            stamp = stamp_of(*divmod(nanoseconds, 10**9))
            numbers = [float(values[row]) for _, _, values in _signals(columns)]
            message = message_of(header_of(stamp, "rig"), *numbers)
            bag.write(
                topic, 1_700_000_000 * 10**9 + nanoseconds, store.serialize_cdr(message, kind)
            )


def write_lvm(path: Path, columns: Columns) -> None:
    """LVM by hand, after National Instruments' specification of the file format: no LabVIEW was at hand."""
    channels = _signals(columns)
    time = _time(columns)

    def line(key: str, *values: object) -> str:
        return "\t".join([key, *map(str, values)]) + "\n"

    head = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
    head += "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nDate\t2026/01/31\nTime\t12:00:00.5\n"
    head += (
        "***End_of_Header***\t\n\t\n"
        + line("Channels", len(channels))
        + line("Samples", *[len(time)] * len(channels))
    )
    head += line("Y_Unit_Label", *(unit for _, unit, _ in channels)) + line(
        "X_Dimension", *["Time"] * len(channels)
    )
    head += line("X0", *[f"{time[0]:.16E}"] * len(channels))
    head += (
        line("Delta_X", *[f"{time[1] - time[0]:.6f}"] * len(channels)) + "***End_of_Header***\t\n"
    )
    head += line("X_Value", *(name for name, _, _ in channels), "Comment")
    rows = zip(time.tolist(), *(values.tolist() for _, _, values in channels), strict=True)
    path.write_text(head + "".join(line(*map(repr, row)) for row in rows), encoding="utf-8")  # pyright: ignore


def write_jsonl(path: Path, columns: Columns) -> None:
    """JSON Lines by Python's json."""
    labels = _labels(columns)
    lines = [json.dumps(dict(zip(labels, row, strict=True))) for row in _rows(columns)]
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def write_mcap(path: Path, columns: Columns) -> None:
    """MCAP by the library mcap: one topic of flat ROS 1 messages, with checksums."""
    import struct

    from mcap.writer import Writer

    signals = _signals(columns)
    members = "".join(f"float64 {name}\n" for name, _, _ in signals)
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=1000)
        writer.start()
        kind = writer.register_schema("rig/Row", "ros1msg", members.encode())
        topic = writer.register_channel(
            "/rig", "ros1", kind, {f"unit.{name}": unit for name, unit, _ in signals}
        )
        for row, seconds in enumerate(_time(columns)):
            nanoseconds = round(seconds * 1e9)
            message = struct.pack(f"<{len(signals)}d", *(values[row] for _, _, values in signals))
            writer.add_message(topic, nanoseconds, message, nanoseconds)
        writer.finish()


def write_text(path: Path, columns: Columns, separator: str = ",", names: bool = True) -> None:
    """Rows of numbers, with names and units or without, by hand."""
    lines = [separator.join(_labels(columns))] if names else []
    lines += [separator.join(map(repr, row)) for row in _rows(columns)]
    data = "".join(f"{line}\n" for line in lines).encode()
    path.write_bytes(gzip.compress(data, mtime=0) if path.suffix == ".gz" else data)


def write_daq(path: Path, columns: Columns) -> None:
    """An export of a data logger: a block of facts, a row of names, dates, remarks behind the first and last row."""
    signals = _signals(columns)
    names = ", ".join(f"{name} ({unit})" for name, unit, _ in signals)
    rows: list[str] = []
    for row in range(len(_time(columns))):
        numbers = ", ".join(repr(float(values[row])) for _, _, values in signals)
        rows.append(f"{row}, 05/25/2022 05:50:06.{row:03d} PM, {numbers}")
    rows[0] += ", DAQ Start"
    rows[-1] += ", DAQ Pause, DAQ Stop"
    head = ["Device: logger", "Rate: 1000 Hz", "", f"Sample, Date/Time, {names}, Events"]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def write_mat(path: Path, columns: Columns) -> None:
    """MATLAB 5 by SciPy, packed: a vector a signal."""
    from scipy.io import savemat

    savemat(path, {name: values for name, (_, values) in columns.items()}, do_compression=True)


def write_mat73(path: Path, columns: Columns) -> None:
    """MATLAB 7.3 by h5py: MATLAB's 512 bytes before an HDF5 file whose data sets say their class."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, (_, values) in columns.items():
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_(
                b"double"
            )
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def write_parquet(path: Path, columns: Columns, checksums: bool = False) -> None:
    """Parquet by pyarrow: units as metadata of the fields."""
    import pyarrow as pa
    from pyarrow import parquet

    parquet.write_table(_arrow_table(columns, pa), path, write_page_checksum=checksums)


def write_feather(path: Path, columns: Columns) -> None:
    """Feather by pyarrow: units as metadata of the fields."""
    import pyarrow as pa
    from pyarrow import feather

    feather.write_feather(_arrow_table(columns, pa), str(path))


def _arrow_table(columns: Columns, pa: Any) -> Any:
    fields = [
        pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (unit, _) in columns.items()
    ]
    return pa.table([values for _, values in columns.values()], schema=pa.schema(fields))


def write_npz(path: Path, columns: Columns) -> None:
    """NumPy's archive: an array a column, and the unit in its name."""
    arrays: dict[str, Any] = {
        f"{name}_{unit.replace('*', '').replace('/', '_')}": values
        for name, (unit, values) in columns.items()
    }
    np.savez(path, **arrays)


def write_npy(path: Path, columns: Columns) -> None:
    """NumPy's file of one array with named fields."""
    names = [
        f"{name}_{unit.replace('*', '').replace('/', '_')}" for name, (unit, _) in columns.items()
    ]
    rows = np.array(_rows(columns), dtype=[(name, "f8") for name in names])
    np.save(path, rows)


def write_zip(path: Path, columns: Columns) -> None:
    """A ZIP archive of one text."""
    import zipfile

    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder) / "log.csv"
        write_text(text, columns)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.write(text, "run 1/log.csv")


def write_labelled(path: Path, columns: Columns) -> None:
    """Lines that a microcontroller prints, with a name in front of each number."""
    lines = [
        ", ".join(
            f"{name}: {value!r} {unit}"
            for (name, (unit, _)), value in zip(columns.items(), row, strict=True)
        )
        for row in _rows(columns)
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


#: Name of the format -> reader, name of the file or folder, its writer.
FORMATS: dict[str, tuple[str, str, Callable[[Path, Columns], None]]] = {
    "mdf": ("mdf", "a.mf4", write_mdf),
    "mdf packed": ("mdf", "b.mf4", lambda path, columns: write_mdf(path, columns, compression=2)),
    "mdf 3": ("mdf", "a.mdf", lambda path, columns: write_mdf(path, columns, version="3.30")),
    "tdms": ("tdms", "a.tdms", write_tdms),
    "xlsx": ("spreadsheet", "a.xlsx", write_xlsx),
    "ods": ("spreadsheet", "a.ods", write_ods),
    "hdf5": ("hdf5", "a.h5", write_hdf5),
    "hdf5 checked": (
        "hdf5",
        "b.h5",
        lambda path, columns: write_hdf5(path, columns, fletcher32=True),
    ),
    "bag sqlite": ("rosbag", "bag1", write_bag),
    "bag mcap": ("rosbag", "bag2", lambda path, columns: write_bag(path, columns, "MCAP")),
    "lvm": ("lvm", "a.lvm", write_lvm),
    "jsonl": ("jsonl", "a.jsonl", write_jsonl),
    "mcap": ("mcap", "a.mcap", write_mcap),
    "csv": ("text", "a.csv", write_text),
    "white space": (
        "text",
        "a.txt",
        lambda path, columns: write_text(path, columns, "  ", names=False),
    ),
    "daq": ("text", "daq.csv", write_daq),
    "csv gz": ("text", "a.csv.gz", write_text),
    "mat 5": ("mat", "a.mat", write_mat),
    "mat 7.3": ("mat", "b.mat", write_mat73),
    "parquet": ("parquet", "a.parquet", write_parquet),
    "parquet checked": (
        "parquet",
        "b.parquet",
        lambda path, columns: write_parquet(path, columns, checksums=True),
    ),
    "feather": ("feather", "a.feather", write_feather),
    "npz": ("numpy_arrays", "a.npz", write_npz),
    "npy": ("numpy_arrays", "a.npy", write_npy),
    "zip": ("zipped_texts", "a.zip", write_zip),
    "labelled lines": ("labelled_lines", "serial.txt", write_labelled),
}


def small_log(rows: int = 200) -> Columns:
    """A log to damage: 1 kHz, voltage, speed, torque."""
    random = np.random.default_rng(7)
    field = random.uniform(0, 2, rows)
    slip = 10 * random.normal(size=rows)
    effort = random.normal(size=rows)
    return {
        "time": ("s", np.arange(rows) / 1000),
        "field": ("V", field.round(4)),
        "slip": ("rad/s", slip.round(4)),
        "effort": ("N*m", effort.round(4)),
    }


def mutated(data: bytes, seed: tuple[int, ...]) -> bytes:
    """A file with a few other bytes, a part cut off at the end, set to zero, left out, or in there twice."""
    random = np.random.default_rng(seed)
    out, kind = bytearray(data), random.integers(6)
    start = int(random.integers(len(data)))
    part = slice(start, start + int(random.integers(1, max(2, len(data) // 10))))
    if kind <= 1:
        for place in random.integers(len(data), size=int(random.integers(1, 9))):
            out[place] = random.integers(256)
    elif kind == 2:
        del out[start:]
    elif kind == 3:
        out[part] = bytes(len(out[part]))
    elif kind == 4:
        del out[part]
    else:
        out[start:start] = out[part]
    return bytes(out)


def choices(name: str) -> dict[str, Any] | None:
    """Columns and units of a format that has no names or no units; None for the others."""
    if name not in ("white space", "mat 5", "mat 7.3"):
        return None
    chosen: dict[str, Any] = {}
    for place, (signal, (unit, _)) in enumerate(small_log().items(), start=1):
        column = place if name == "white space" else signal
        chosen[signal] = {"column": column, "unit": unit}
    return chosen
