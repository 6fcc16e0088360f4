"""Small files that unpack to gigabytes, and what reading each of them takes."""

from __future__ import annotations

import gzip
import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.support.pace import within

MIB = 1 << 20
#: What a file may take, as a process and its children: MiB in memory, and seconds of processor time.
MOST_MIB, MOST_SECONDS = 954, 10.0


def packed_zeros(path: Path, count: int = 100_000_000) -> None:
    """MATLAB 5: 10^8 zeros in 0.8 MB."""
    from scipy.io import savemat

    savemat(path, {"t": np.zeros(count)}, do_compression=True)


def packed_fields(path: Path) -> None:
    """MATLAB 5: zeros in the fields of a struct, whose size the head of the variable does not tell."""
    from scipy.io import savemat

    savemat(
        path, {"s": {"t": np.zeros(50_000_000), "u": np.zeros(50_000_000)}}, do_compression=True
    )


def unwritten_values(path: Path, start: str = "") -> None:
    """HDF5: 3 x 10^8 numbers that were never written."""
    import h5py

    with h5py.File(path, "w", userblock_size=512 if start else 0) as file:
        each = file.create_dataset("t", shape=(1, 300_000_000), dtype="f8", chunks=(1, 1 << 20))
        each.attrs["MATLAB_class"] = np.bytes_(b"double")
    if start:
        with path.open("r+b") as file:
            file.write(start.encode().ljust(124) + b"\x00\x02IM")


def repeated_links(path: Path) -> None:
    """HDF5: a ladder of structs, each of which holds the next eight times: 8^11 at its end."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        below = file.create_group("g0")
        below.create_dataset("t", data=np.zeros(2)).attrs["MATLAB_class"] = np.bytes_(b"double")
        for level in range(1, 12):
            above = file.create_group(f"g{level}")
            for place in range(8):
                above[f"m{place}"] = below
            below = above
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def many_sets(path: Path) -> None:
    """HDF5: 20,000 vectors."""
    import h5py

    with h5py.File(path, "w") as file:
        for place in range(20_000):
            file.create_dataset(f"n{place}", data=np.zeros(2))


def new_names(path: Path) -> None:
    """JSON: a new name in each row."""
    path.write_text(
        "".join(json.dumps({f"n{row}": row}) + "\n" for row in range(30_000)), encoding="utf-8"
    )


def sparse_names(path: Path) -> None:
    """JSON: 12,000 names, each in few of 12,000 rows."""
    rows = ({f"n{row}": row} for row in range(12_000))
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")


def long_number(path: Path, digits: str) -> None:
    """CSV: cells of 20,000 digits."""
    rows = "".join(f"{row / 1000},{digits}\n" for row in range(20))
    path.write_text("t [s],effort [N*m]\n" + rows, encoding="utf-8")


def wide_row(path: Path) -> None:
    """CSV: 500,000 columns."""
    path.write_text(("1," * 500_000 + "1\n") * 2, encoding="utf-8")


def packed_rows(path: Path) -> None:
    """CSV: 240 MB of equal rows in 0.3 MB."""
    path.write_bytes(gzip.compress(b"t,a,b\n" + b"1,1,1\n" * 40_000_000, 6))


_SHEET = '<?xml version="1.0"?><worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
_SHEET_END = "</sheetData></worksheet>"


def _workbook(path: Path, rows: Callable[[zipfile.ZipFile], None]) -> None:
    """A workbook of openpyxl whose only sheet is written anew."""
    from openpyxl import Workbook

    plain = path.with_name("plain.xlsx")
    Workbook().save(plain)
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for part in old.infolist():
            if part.filename != "xl/worksheets/sheet1.xml":
                new.writestr(part, old.read(part), zipfile.ZIP_DEFLATED)
        rows(new)
    plain.unlink()


def packed_cells(path: Path) -> None:
    """Excel: 10^7 equal cells."""

    def rows(file: zipfile.ZipFile) -> None:
        with file.open("xl/worksheets/sheet1.xml", "w") as sheet:
            sheet.write(_SHEET.encode())
            for _ in range(100):
                sheet.write(("<row>" + "<c><v>1</v></c>" * 1000 + "</row>").encode() * 100)
            sheet.write(_SHEET_END.encode())

    _workbook(path, rows)


def far_corner(path: Path) -> None:
    """Excel: two cells, in the first and the last place that a sheet has."""
    cells = '<row r="1"><c r="A1"><v>1</v></c></row><row r="1048576"><c r="XFD1048576"><v>2</v></c></row>'
    _workbook(
        path, lambda file: file.writestr("xl/worksheets/sheet1.xml", _SHEET + cells + _SHEET_END)
    )


def one_long_text(path: Path) -> None:
    """Excel: a part of 400 MB that states 10 bytes."""

    def rows(file: zipfile.ZipFile) -> None:
        file.writestr("xl/worksheets/sheet1.xml", _SHEET + " " * 400_000_000 + _SHEET_END)

    _workbook(path, rows)
    data = path.read_bytes()
    size = (len(_SHEET) + 400_000_000 + len(_SHEET_END)).to_bytes(4, "little")
    path.write_bytes(data.replace(size, (10).to_bytes(4, "little")))


def packed_columns(path: Path) -> None:
    """Parquet: 10^8 equal numbers."""
    import pyarrow as pa
    from pyarrow import parquet

    zeros = np.zeros(1_000_000)
    parquet.write_table(
        pa.table({f"c{place}": zeros for place in range(100)}), path, compression="zstd"
    )


def long_words(path: Path) -> None:
    """Parquet: one word of 64 kB in each of 100,000 rows, beside a column of numbers."""
    import pyarrow as pa
    from pyarrow import parquet

    words = pa.DictionaryArray.from_arrays(np.zeros(100_000, np.int32), ["x" * 65_536])
    parquet.write_table(
        pa.table({"t": np.arange(100_000) / 1e3, "word": words}), path, store_schema=False
    )


def packed_chunk(path: Path) -> None:
    """MCAP: a chunk of 400 MB, packed by zstd."""
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=500 << 20, compression=CompressionType.ZSTD)
        writer.start()
        schema = writer.register_schema("row", "ros1msg", b"float64 t\nfloat64 a\n")
        channel = writer.register_channel("/row", "ros1", schema)
        for place in range(400):
            writer.add_message(channel, place, bytes(1_000_000), place)
        writer.finish()


#: What is packed -> name of the file, its maker.
BOMBS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "mat zeros": ("zeros.mat", packed_zeros),
    "mat as many as allowed": ("allowed.mat", lambda path: packed_zeros(path, 26_000_000)),
    "mat fields": ("fields.mat", packed_fields),
    "mat 7.3 unwritten": (
        "unwritten.mat",
        lambda path: unwritten_values(path, "MATLAB 7.3 MAT-file"),
    ),
    "mat 7.3 links": ("links.mat", repeated_links),
    "hdf5 unwritten": ("unwritten.h5", unwritten_values),
    "hdf5 sets": ("sets.h5", many_sets),
    "json names": ("names.jsonl", new_names),
    "json sparse": ("sparse.jsonl", sparse_names),
    "csv digits": ("digits.csv", lambda path: long_number(path, "7" * 20_000)),
    "csv decimals": (
        "decimals.csv",
        lambda path: long_number(path, f"{'7' * 20_000}.{'1' * 20_000}"),
    ),
    "csv groups": ("groups.csv", lambda path: long_number(path, '"' + "7,777" * 4_000 + '"')),
    "csv columns": ("columns.csv", wide_row),
    "csv packed": ("packed.csv.gz", packed_rows),
    "xlsx cells": ("cells.xlsx", packed_cells),
    "xlsx corner": ("corner.xlsx", far_corner),
    "xlsx text": ("text.xlsx", one_long_text),
    "parquet zeros": ("zeros.parquet", packed_columns),
    "parquet words": ("words.parquet", long_words),
    "mcap chunk": ("chunk.mcap", packed_chunk),
}

_READ = """
import resource, sys
import erclutch
try:
    print("read", erclutch.read(sys.argv[1]).rows)
except erclutch.ErclutchError as error:
    print(str(error).replace(chr(10), " "))
own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
status = open("/proc/self/status").read()  # of this program; ru_maxrss is that of the process before it, too
peak = int(status.split("VmHWM:")[1].split()[0])
seconds = sum(each.ru_utime + each.ru_stime for each in (own, children))
print(max(peak, children.ru_maxrss) >> 10, seconds)
"""


class Taken(NamedTuple):
    """What came of reading a file, the most MiB of a process, and seconds of processor time of all."""

    said: str
    mib: float
    seconds: float

    @property
    def held(self) -> bool:
        """Whether it is a recording or one error, within the limits."""
        return self.said != "" and self.mib <= MOST_MIB and within(self.seconds, MOST_SECONDS)


def read_alone(path: Path, seconds: float = 240.0) -> Taken:
    """Read a log in a process of its own; what it says is empty where it broke or took longer by the clock.

    Its processor time is what counts: on a busy machine a minute of the clock may hold five seconds of that.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-c", _READ, str(path)],
            capture_output=True,
            text=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Taken("", 0.0, seconds)
    lines = done.stdout.splitlines()
    if done.returncode != 0 or len(lines) != 2:
        return Taken("", 0.0, 0.0)
    mib, used = lines[1].split()
    return Taken(lines[0], float(mib), float(used))
