"""Lines that a Brookfield viscometer prints: ``RPM=60 M=LV S=40 %=24.3 mPas=1.24 N/M2=0.56 1/SEC=450 T=25.0C Z00:01``.

The instrument names each value: speed, model, spindle, torque in per cent, viscosity, stress, rate, temperature, time.
"""

from __future__ import annotations

import re
from dataclasses import replace

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers.cells import is_number
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.readers.text_table import read_cells
from erclutch.logs.table import Table

_VALUE = re.compile(
    r"(?P<name>RPM|%|mPas|cP|CP|N/M2|D/CM2|1/SEC|T)=\s*(?P<number>[^\s=]*?)(?=C?(?:\s|$))"
)
_LABELS = {
    "RPM": "Speed [rpm]",
    "%": "Torque [%]",
    "mPas": "Viscosity [mPa*s]",
    "cP": "Viscosity [cP]",
    "CP": "Viscosity [cP]",
    "N/M2": "Shear stress [Pa]",
    "D/CM2": "Shear stress [dyn/cm^2]",
    "1/SEC": "Shear rate [1/s]",
    "T": "Temperature [°C]",
}
_FIRST = re.compile(rb"^\W*RPM=\s*[\d.]+\s+M=\w+\s+S=\w+\s+%=", re.MULTILINE)


def _read(source: LogSource) -> Table:
    """The values as the rows of a table; what is above the range of the spring (EEEE) is missing."""
    rows: list[dict[str, str]] = []
    for line in decode(source.data).splitlines():
        values = {match["name"]: match["number"] for match in _VALUE.finditer(line)}
        if "RPM" in values:
            rows.append({name: number for name, number in values.items() if is_number(number, ".")})
    names = [name for name in _LABELS if any(name in row for row in rows)]
    if not names:
        raise LogError(
            "no line has values behind their names",
            remedy="Give the lines that the viscometer prints",
        )
    labels = [_LABELS[name] for name in names]
    table = read_cells(source, labels, ([row.get(name, "") for name in names] for row in rows))
    note = "each line has the names of its values, as a Brookfield prints them"
    return replace(table, notes=(note, *table.notes))


READER = LogReader((), lambda head: _FIRST.search(head) is not None, _read, tells_damage=DAMAGE)
