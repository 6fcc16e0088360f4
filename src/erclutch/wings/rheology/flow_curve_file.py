"""Files of flow curves hold shear rate and shear stress.

Either pairs of columns, rate [1/s] and stress [Pa], with a label over the first of each pair and pairs of any
length; or one column of rates and a column of stresses for each curve, named by its header.
"""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

from erclutch.errors import LogError, placed

_LARGEST = 50_000_000
_STRESS, _RATE = re.compile(r"stress|tau|\bk?pa\b|τ"), re.compile(r"rate|gamma|1/s|s\^?-1|γ")


def read_flow_curves(path: str | Path) -> list[tuple[str, list[float], list[float]]]:
    """Label, shear rates and shear stresses of each curve in a file.

    Raises:
        LogError: missing, empty, not text, or a cell that is no number.
    """
    with placed(str(path)):
        (_, header), *body = _rows(Path(path))
        wide = len(header)
        if wide < 2 or not body:
            problem = f"{len(body) + 1} rows of {wide} columns"
            raise LogError(problem, remedy="Give a header and rate, stress pairs")
        _refuse_unlabelled(header)
        paired = wide % 2 == 0 and not any(cell.strip() for cell in header[1::2])
        curves: list[tuple[str, list[float], list[float]]] = []
        for stress in range(1, wide, 2 if paired else 1):
            rate = stress - 1 if paired else 0
            label = header[rate if paired else stress].strip() or f"curve {len(curves) + 1}"
            points = [point for line, row in body for point in _point(line, row, rate, stress, label)]
            curves.append((label, [r for r, _ in points], [s for _, s in points]))
        return curves


def _refuse_unlabelled(header: list[str]) -> None:
    """Without a row of labels, and with stresses ahead of rates, numbers would be taken for something else."""
    labels = [cell.strip().lower() for cell in header[:2]]
    if all(_is_number(label) for label in labels):
        problem = f"row 1 holds the numbers {labels[0]} and {labels[1]} where labels are expected"
        raise LogError(problem, remedy="Put a row of labels above: one over the rates of each pair, or one a column")
    if _STRESS.search(labels[0]) and _RATE.search(labels[1]):
        problem = f"the columns are {header[0].strip()!r}, {header[1].strip()!r}: stresses come ahead of their rates"
        raise LogError(problem, remedy="Put the rates into the first column")


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line number and cells of each line that is not blank, all of one width."""
    table = "Give a CSV file of shear rates and stresses"
    try:
        if path.stat().st_size > _LARGEST:
            raise LogError(f"{path.stat().st_size} bytes, at most {_LARGEST}", remedy="Give a flow-curve table")
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LogError("not a text file", remedy=table) from error
    except OSError as error:
        raise LogError(f"cannot be read: {error.strerror}", remedy="Check the path") from error
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip(" ,;\t")]
    if not lines or "\0" in text:
        raise LogError("no table of numbers", remedy=table)
    delimiter = max(",;\t", key=lambda mark: sum(line.count(mark) for _, line in lines[:20]))
    rows = [next(csv.reader([line], delimiter=delimiter)) for _, line in lines]
    width = max(len(row) for row in rows[1:] or rows)
    if width % 2 and all(not (row[width - 1 :] and row[width - 1].strip()) for row in rows):
        width -= 1  # a trailing delimiter
    return [(i, (row + [""] * width)[:width]) for (i, _), row in zip(lines, rows, strict=True)]


def _point(line: int, row: list[str], rate: int, stress: int, label: str) -> list[tuple[float, float]]:
    """Rate and stress of a row, or nothing where both cells are empty."""
    pair = [_number(line, row[column].strip(), column) for column in (rate, stress) if row[column].strip()]
    if len(pair) == 1:
        problem = f"row {line} of curve {label} has only one of rate and stress"
        raise LogError(problem, remedy="Complete the pair or remove it")
    return [(pair[0], pair[1])] if pair else []


def _number(line: int, cell: str, column: int) -> float:
    try:
        return float(cell)
    except ValueError as error:
        problem = f"row {line}, column {column + 1} holds {cell!r}, a number is needed"
        raise LogError(problem, remedy="Correct the cell") from error
