"""The first bytes of a file that no reader claims name its format, so that the error can say how to go on."""

from __future__ import annotations

import re

_CSV = "Export it as CSV"
_OTHERS = "Export it as CSV, or give a .mat (MATLAB) or .parquet file"
#: First bytes (a pattern at the beginning), what the file is, and the remedy.
_FORMATS = (
    (rb"TDSh", "the index of a TDMS log (.tdms_index)", "Give the .tdms file beside it"),
    (
        rb"LOGG",
        "a Vector bus log (.blf)",
        "Decode it with its DBC file and save it as MDF4 or CSV, with asammdf for example",
    ),
    (rb"SQLite format 3\0", "a SQLite database", "Name a ROS 2 bag .db3; export a table as CSV"),
    (rb"#ROSBAG", "a bag of ROS before 1.2", "Convert it: rosbag fix FILE NEW"),
    (rb"PK\x03\x04", "a zip archive", "Unpack it and give the log in it"),
    (
        rb"7z\xbc\xaf\x27\x1c|Rar!|BZh[1-9]|\xfd7zXZ|\x28\xb5\x2f\xfd",
        "a packed archive",
        "Unpack it and give the log in it",
    ),
    (rb"%PDF", "a PDF", _CSV),
    (rb"\x89PNG|\xff\xd8\xff|GIF8|II\*\0|MM\0\*", "a picture", "Give the log that it shows"),
    (rb"\x0e\x03\x13\x01", "HDF4", "Convert it to HDF5 with h4toh5"),
    (rb"CDF[\x01\x02\x05]", "NetCDF 3", "Convert it to NetCDF 4: nccopy -k netCDF-4 FILE NEW.nc"),
    (
        rb"FEA1",
        "Feather before Arrow 0.17",
        "Save it as Parquet: pandas.read_feather(FILE).to_parquet(NEW)",
    ),
    (rb"ORC", "Apache ORC", "Save it as Parquet: pandas.read_orc(FILE).to_parquet(NEW)"),
    (
        rb"\x80[\x02-\x05][\x95\]}(c]",
        "a Python pickle, which may run programs and is never opened",
        "Save it as Parquet",
    ),
    (rb"RIFF....WAVE", "sound (.wav)", "Save it as CSV"),
    (
        rb"ULog\x01\x12\x35",
        "a log of PX4 (.ulg)",
        "Make CSV of it: ulog2csv FILE (pip install pyulog)",
    ),
    (rb"\x1f\x8b", "gzip in gzip", "Unpack it and give the log in it"),
)
#: The same for formats of text, which have numbers but no table.
_TEXTS = (
    (
        r"\s*<\?xml[^<]*<(?:\w+:)?tdm",
        "the header of a DIAdem log (.tdm)",
        "Save it as TDMS, or export it as CSV",
    ),
    (r"\s*<(?:\?xml|!doctype|html|!--)", "XML or HTML", _CSV),
    (
        r"date [^\n]*\n\s*base (?:hex|dec)",
        "a Vector bus log (.asc)",
        "Decode it with its DBC file and export it as CSV",
    ),
    # The first set of a universal file: a line with -1, one with its number, and one with a name or a unit.
    (
        r" {4}-1 *\r?\n {2,4}\d{2,4}b?[^\n]*\n[^\n]*[A-Za-z]",
        "a universal file (UFF)",
        f"{_CSV}, with pyuff for example",
    ),
    (r"%PDF", "a PDF", _CSV),
    (r"\{\\rtf", "a text of Word (.rtf)", _CSV),
)


def named(data: bytes) -> tuple[str, str]:
    """What binary data are, "binary data" where the first bytes do not tell, and the remedy."""
    for pattern, name, remedy in _FORMATS:
        if re.match(pattern, data[:1024], re.DOTALL):
            return name, remedy
    return "binary data", _OTHERS


def named_text(text: str) -> tuple[str, str] | None:
    """What a text is that is no table, and the remedy; None for all others."""
    head = text[:1024]
    for pattern, name, remedy in _TEXTS:
        if re.match(pattern, head, re.IGNORECASE):
            return name, remedy
    return None
