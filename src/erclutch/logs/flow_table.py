"""Files of flow curves: shear rate and shear stress.

Either pairs of columns, rate [1/s] and stress [Pa], with a label over the first of each pair and pairs of any
length; or one column of rates and a column of stresses for each curve, named by its header.
"""

from __future__ import annotations

import csv
from pathlib import Path

from erclutch.errors import LogError

_LARGEST = 50_000_000


def read_flow_curves(path: str | Path) -> list[tuple[str, list[float], list[float]]]:
    """Label, shear rates and shear stresses of each curve in a file.

    Raises:
        LogError: missing, empty, not text, or a cell that is no number.
    """
    path = Path(path)
    rows = _rows(path)
    header, body = rows[0][1], rows[1:]
    wide = len(header)
    if wide < 2 or not body:
        raise LogError(
            f"{len(rows)} rows of {wide} columns", where=str(path), remedy="Give a header and rate, stress pairs"
        )
    paired = wide % 2 == 0 and all(not cell.strip() for cell in header[1::2])
    firsts = range(0, wide, 2) if paired else [0] * (wide - 1)
    seconds = range(1, wide, 2) if paired else range(1, wide)
    curves: list[tuple[str, list[float], list[float]]] = []
    for rate_column, stress_column in zip(firsts, seconds, strict=True):
        label = header[rate_column if paired else stress_column].strip() or f"curve {len(curves) + 1}"
        points = [
            (_number(path, line, row, rate_column), _number(path, line, row, stress_column)) for line, row in body
        ]
        for (line, _), (rate, stress) in zip(body, points, strict=True):
            if (rate is None) != (stress is None):
                raise LogError(
                    f"row {line} of curve {label} has only one of rate and stress",
                    where=str(path),
                    remedy="Complete the pair or remove it",
                )
        whole = [(r, s) for r, s in points if r is not None and s is not None]
        curves.append((label, [r for r, _ in whole], [s for _, s in whole]))
    return curves


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line number and cells of each line that is not blank, all of one width."""
    try:
        if path.stat().st_size > _LARGEST:
            raise LogError(
                f"{path.stat().st_size} bytes, at most {_LARGEST}", where=str(path), remedy="Give a flow-curve table"
            )
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LogError(
            "not a text file", where=str(path), remedy="Give a CSV file of shear rates and stresses"
        ) from error
    except OSError as error:
        raise LogError(f"cannot be read: {error.strerror}", where=str(path), remedy="Check the path") from error
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip(" ,;\t")]
    if not lines or "\0" in text:
        raise LogError("no table of numbers", where=str(path), remedy="Give a CSV file of shear rates and stresses")
    delimiter = max(",;\t", key=lambda mark: sum(line.count(mark) for _, line in lines[:20]))
    rows = [next(csv.reader([line], delimiter=delimiter)) for _, line in lines]
    width = max(len(row) for row in rows[1:] or rows)
    if width % 2 and all(not (row[width - 1 :] and row[width - 1].strip()) for row in rows):
        width -= 1  # a trailing delimiter
    return [(i, (row + [""] * width)[:width]) for (i, _), row in zip(lines, rows, strict=True)]


def _number(path: Path, line: int, row: list[str], column: int) -> float | None:
    cell = row[column].strip()
    if not cell:
        return None
    try:
        return float(cell)
    except ValueError as error:
        raise LogError(
            f"row {line}, column {column + 1} holds {cell!r}, a number is needed",
            where=str(path),
            remedy="Correct the cell",
        ) from error
