"""Exports of Chandler Engineering's rheometers (5550 and kin): sections under headings such as "-- Raw Data --".

The first table is the calibration by an oil of known viscosity, and the second holds what the instrument fitted: only
the raw data are of the sample.
"""

from __future__ import annotations

import re

from erclutch.errors import LogError
from erclutch.logs.readers.cells import is_numeric
from erclutch.wings.rheology.rheometer_blocks import Block, cells, delimiter_of, reader_of_blocks

_HEADING = re.compile(r"\s*-- (?P<section>[^|]+?) --[\s,;]*")
_SAMPLE = "Raw Data"  # the section of the sample
_FEWEST = 3  # columns of a table


def _blocks(content: str) -> list[Block]:
    """The table of the sample; a test that was stopped and begun again has several."""
    blocks: list[Block] = []
    section = ""
    names: list[str] = []
    units: list[str] = []
    rows: list[list[str]] = []
    delimiter = ","
    for number, line in enumerate([*content.splitlines(), ""], start=1):
        heading = _HEADING.fullmatch(line)
        row = cells(line, delimiter)
        is_filled = sum(map(bool, row)) >= _FEWEST
        if rows and not is_filled:  # the table ends here
            blocks.append(Block(section, names, units, rows, number - len(rows)))
            rows = []
            names = []
        if heading:
            section = heading["section"]
            names = []
        elif section != _SAMPLE or not line.strip():
            continue
        elif not names:
            delimiter = delimiter_of(line)
            names = cells(line, delimiter)
            units = []
        elif not units and row[0].startswith("("):
            units = row
        elif is_filled and any(map(is_numeric, row)):
            rows.append(row)
    if not blocks:
        problem = f"the export has no rows under its heading {_SAMPLE!r}: what it holds is the calibration"
        raise LogError(problem, remedy="Export the raw data of the test")
    return blocks


READER = reader_of_blocks(
    lambda text: "Chandler Engineering" in text and "Rheometer" in text,
    _blocks,
    "table",
    note="the table of the calibration, by an oil and not the sample, is left out",
)
