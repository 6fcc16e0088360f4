"""Cells that hold a list of numbers, as tables of messages of robots have them, become a column for each place."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

_NUMBERS = re.compile(r"[(\[][^()\[\]'\"]*[)\]]")
_WORDS = re.compile(
    r"[(\[]\s*(?:'[^']*'|\"[^\"]*\")(?:\s*,\s*(?:'[^']*'|\"[^\"]*\"))*\s*,?\s*[)\]]"
)
_MOST = 64  # numbers of a list


def without_lists(texts: dict[str, pd.Series[Any]]) -> tuple[dict[str, Array], list[str]]:
    """Take the columns of lists out of those of texts: a column of numbers for each place, and notes.

    A list of words that is the same in all rows, of as many words as there are numbers, names the places: ``elbow`` of
    ``velocity`` becomes ``elbow.velocity``; else places are numbered from 1.
    """
    words: list[str] = []
    for cells in texts.values():
        once = [str(cell) for cell in cells.dropna().unique()[:2]]
        if len(once) == 1 and _WORDS.fullmatch(once[0].strip()):
            in_quotes = re.findall(r"'([^']*)'|\"([^\"]*)\"", once[0])
            words = ["".join(pair) for pair in in_quotes]
            break
    columns: dict[str, Array] = {}
    notes: list[str] = []
    for label in [*texts]:
        rows = _rows_of(texts[label])
        if rows is None:
            continue
        del texts[label]
        _, count = rows.shape
        if len(words) == count == len({*words}) and all(words):
            names = [f"{word}.{label}" for word in words]
        else:
            names = [f"{label}_{number}" for number in range(1, count + 1)]
        for name, column in zip(names, rows.T, strict=True):
            columns[name] = np.ascontiguousarray(column)
        notes.append(
            f"column {label} holds lists of {count} numbers: columns {names[0]} .. {names[-1]}"
        )
    return columns, notes


def _rows_of(cells: pd.Series[Any]) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """Numbers of lists of one length, shape (rows, length); None where a cell holds anything else."""
    texts = [str(cell).strip() for cell in cells]
    if not texts or not _NUMBERS.fullmatch(texts[0]):
        return None
    commas = texts[0].count(",")
    ends_in_a_comma = texts[0][:-1].rstrip().endswith(",")  # (1, 2,)
    count = commas if ends_in_a_comma else commas + 1
    if not 1 < count <= _MOST:
        return None
    rows = np.empty((len(texts), count))
    for place, text in enumerate(texts):
        if not _NUMBERS.fullmatch(text):
            return None
        parts = text[1:-1].rstrip(", ").split(",")
        if len(parts) != count:
            return None
        try:
            rows[place] = [float(part) for part in parts]
        except ValueError:
            return None
    return rows
