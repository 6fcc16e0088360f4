"""Every reader delivers this table: columns and units as in the file, before any of them is called a signal."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError, MappingError, listed
from erclutch.signals.array import Array
from erclutch.signals.channels import device_of_channels
from erclutch.signals.device import DEVICES, DeviceName

WIDEST = 1000  # columns of a log; more, and fewer rows, lie on their side, whether the rows have names or not
A_COLUMN_EACH = "Give a table with a column for each signal"
#: Between two columns whose difference is meant.
MINUS = " - "


#: Labels of the files that erclutch makes.
_ORIGINS = ("TWIN", "SYNTHETIC", "PREDICTED")


@dataclass(frozen=True)
class WordColumn:
    """A column of a few words, which part the rows: by material, by test, by direction.

    Attributes:
        words: each once, in the order of the file.
        of_row: number of each row's word, shape (n,); -1 for an empty cell.
    """

    words: tuple[str, ...]
    of_row: NDArray[np.int32]


@dataclass(frozen=True)
class Table:
    """Columns of numbers as a file holds them.

    Attributes:
        name: the file's name.
        columns: column name -> samples, shape (n,), float64; NaN where a cell was empty.
        units: column name -> unit as written in the file, or None.
        digest: SHA-256 of the file's bytes, hexadecimal.
        numbers: column name -> its place in the file, counted from 1 (columns left out count too).
        sample_period: sampling period in s where a header states it.
        clock: seconds since the first row, shape (n,), from a date or time-of-day column.
        clock_name: the name of that column.
        constants: numbers given once for the whole file (a column filled in its first row only, a scalar variable).
        metadata: texts of the header block, of a MATLAB structure or of a Parquet file.
        notes: what was dropped, renamed or assumed while reading, one sentence each.
        unsampled: rows of a live recording in which no good sample came, shape (n,); None in all other files.
        damage: what the format does about damaged bytes, see `LogReader.tells_damage`.
        first_row: place in the file of the first row, counted from 0, where the table is a stretch of a longer log.
        unreadable: columns of the file that are no numbers, with what is wrong: whoever needs one of them says so.
        torn: those of them of which a few cells are no numbers, shape (n,), NaN there.
        torn_rows: what is wrong with rows that have more cells than there are columns, and NaN in each; "" for none.
        hollow: columns of the file that hold no number in any row, and were left out.
        path: of the file, as the user gave it; "" for a table that is not of a file.
        breaks: rows above which a text has a blank line or a comment, where these part its rows into a few blocks.
        words: columns of words that part the rows, by name; none in a table that holds the rows of one word.
        row_names: what the first column of texts calls each row, where a file has few rows; empty for others.
        sweeps: number of the sweep of each row, shape (n,), where columns of several sweeps stood beside each other and
            their rows stand one after another now; None where none did.
        unsure_names: why the names of the columns may be those of others; "" for names that stand over their columns.
        made: columns that stand in no file: differences of two that do, as ``n_in - n_out``.
    """

    name: str
    columns: Mapping[str, Array]
    units: Mapping[str, str | None]
    digest: str
    numbers: Mapping[str, int] = field(default_factory=dict[str, int])
    sample_period: float | None = None
    clock: Array | None = None
    clock_name: str = ""
    constants: Mapping[str, float] = field(default_factory=dict[str, float])
    metadata: Mapping[str, str] = field(default_factory=dict[str, str])
    notes: tuple[str, ...] = ()
    unsampled: NDArray[np.bool_] | None = None
    damage: str = ""
    first_row: int = 0
    path: str = ""
    unreadable: Mapping[str, str] = field(default_factory=dict[str, str])
    torn: Mapping[str, Array] = field(default_factory=dict[str, Array])
    torn_rows: str = ""
    hollow: tuple[str, ...] = ()
    breaks: tuple[int, ...] = ()
    words: Mapping[str, WordColumn] = field(default_factory=dict[str, WordColumn])
    row_names: tuple[str, ...] = ()
    sweeps: NDArray[np.intp] | None = None
    unsure_names: str = ""
    made: tuple[str, ...] = ()

    @property
    def origin(self) -> str:
        """Label that a file made by erclutch gives itself, such as TWIN; "" for all others."""
        for key in ("erclutch", "erclutch_about"):
            label = self._about(key).get("label")
            if isinstance(label, str):
                return label
        return next((label for label in _ORIGINS if label in self.metadata), "")

    @property
    def simulated_device(self) -> DeviceName | None:
        """The device that a log of the TWIN says it is of; None for all other files."""
        for key in ("erclutch", "erclutch_about", "TWIN"):
            about = self._about(key)
            device = about.get("device")
            if about.get("label") == "TWIN" and device in DEVICES:
                return device
        return None

    def _about(self, key: str) -> dict[str, Any]:
        """What a file made by erclutch says of itself as JSON, under a key of its metadata; nothing for all others."""
        try:
            about: Any = json.loads(self.metadata.get(key, "{}"))
        except (ValueError, RecursionError):
            return {}
        return cast("dict[str, Any]", about) if isinstance(about, dict) else {}

    @property
    def device(self) -> DeviceName | None:
        """The device that a recording of the live loop names by its channels; None for all other files."""
        keys = self._about("erclutch")
        return device_of_channels(
            key.removeprefix("channel.") for key in keys if key.startswith("channel.")
        )

    @property
    def truths(self) -> list[str]:
        """Columns of the TWIN that no sensor gives."""
        if self.origin == "TWIN":
            return [name for name in self.columns if name.startswith("true_")]
        return []

    @property
    def rows(self) -> int:
        """Number of rows."""
        return next((int(values.size) for values in self.columns.values()), 0)

    @property
    def lying(self) -> str:
        """What is wrong with a table that is wider than any log, and has more columns than rows; "" for others."""
        if len(self.columns) <= max(WIDEST, self.rows):
            return ""
        return f"{self.rows} rows of {len(self.columns):,} columns: a log has one row a sample"

    def planned(self, name: str) -> Array:
        """The samples of a column that a plan reads, shape (n,).

        Raises:
            MappingError: the table has no such column. LogError: its cells are no numbers.
        """
        torn = self.torn.get(name)
        if torn is not None and torn.size == self.rows:
            return torn
        if name in self.unreadable:
            raise LogError(
                self.unreadable[name], remedy="Correct its cells, or make a plan of this log"
            )
        parts = self.parts_of(name)
        if parts is not None:
            minuend, subtrahend = parts
            return self.columns[minuend] - self.columns[subtrahend]
        if name not in self.columns:
            problem = (
                f"there is no column '{name}', which the plan reads; the file has: {self.listed}"
            )
            raise MappingError(
                problem, remedy="Give a log with these columns, or make a plan of this log"
            )
        return self.columns[name]

    def parts_of(self, name: str) -> tuple[str, str] | None:
        """The two columns whose difference a name such as ``n_in - n_out`` says; None for any other name."""
        if name in self.columns and name not in self.made:
            return None
        words = name.split(MINUS)
        for count in range(1, len(words)):
            parts = MINUS.join(words[:count]), MINUS.join(words[count:])
            if self.columns.keys() >= {*parts}:
                return parts
        return None

    def numbered(self, number: int) -> str | None:
        """The column at a place in the file, counted from 1, or None."""
        numbers = self.numbers or {name: place for place, name in enumerate(self.columns, start=1)}
        return next((name for name, place in numbers.items() if place == number), None)

    @property
    def labels(self) -> tuple[str, ...]:
        """Column names with their units, as a user would write them: ``V [cm/s]``."""
        return tuple(self.label(name) for name in self.columns if name not in self.made)

    @property
    def listed(self) -> str:
        """The columns with their units, for messages."""
        return listed(self.labels)

    def label(self, name: str, likely: str = "") -> str:
        """A column's name with its unit, or with a likely one; a name that holds the unit already stays."""
        unit = self.units.get(name) or likely
        return f"{name} [{unit}]" if unit and f"[{unit}]" not in name else name


def of_arrow(column: Any) -> NDArray[Any]:
    """Numbers of an Arrow column without missing values, shape (n,).

    Arrow's own `to_numpy` imports pandas, takes a third of a second for it, and loses a Ctrl-C meanwhile.
    """
    numbers: NDArray[Any] = np.from_dlpack(column.combine_chunks())
    return numbers.copy()
