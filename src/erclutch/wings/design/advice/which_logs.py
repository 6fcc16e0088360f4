"""Of several logs: which teach nothing new, and which field and motion no log has, in the words of the rig."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array, largest_size
from erclutch.signals.percent import percent

ADVICE = "which logs teach nothing new, and what no log has"

_FIELD_BANDS, _SLIP_BANDS = 4, 6
_MOST_LINES = 4  # about what is missing
_NAMES = 8  # of logs that repeat
#: Beyond, every so many rows are looked at for what is missing, and no law is fitted.
_MOST_ROWS = 1_000_000
_FEWEST_ROWS = 200
_STEADY = 0.02  # share of the largest field below which a log's field does not change


def which_logs(rows: Dataset) -> list[str]:
    """Sentences about the logs; nothing where there is nothing to say.

    Args:
        rows: of all logs.
    """
    from erclutch.fit.laws.fit_law import fit_structure
    from erclutch.fit.solver.one_thread import one_thread
    from erclutch.models.laws import law_from_name
    from erclutch.models.structure import Structure
    from erclutch.wings.design.lessons import lessons_of

    advice: list[str] = []
    # Which logs repeat what the others show, by Bingham's law.
    moves = any(np.ptp(element.slip) > 0.0 for element in rows.elements)
    tells_a_law = moves and not rows.one_field and _FEWEST_ROWS <= rows.rows <= _MOST_ROWS
    if len(rows.sources) > 1 and tells_a_law:
        law = law_from_name("bingham", rows.device)
        structure = Structure(rows.device, "bingham", law, "none", False, False)
        with one_thread():
            model = fit_structure(rows, structure, intervals=False).model
            lessons = lessons_of(model, rows)
        count = len(lessons.teach) + len(lessons.repeat)
        if lessons.repeat:
            advice.append(
                f"Of {count} logs {len(lessons.repeat)} teach nothing new about field and motion: "
                f"{_named(lessons.repeat)}. Without them no interval of Bingham's law grows by more than "
                f"{percent(lessons.growth - 1.0)}."
            )
        if lessons.surer:
            advice.append(
                f"Other logs have the field and the motion of {_named(lessons.surer)} too: such a log shows nothing "
                "new, it only makes the intervals of Bingham's law narrower."
            )
        if not advice:
            advice.append(f"Each of the {count} logs shows what the others do not.")

    advice += _missing(rows)
    is_switched = rows.one_field  # then there is nothing to say of it
    for element in rows.elements:
        steady = _STEADY * largest_size(element.field)
        for start, stop in rows.source_rows:
            if stop > start and np.ptp(element.field[start:stop]) > steady:
                is_switched = True
    if not is_switched:
        advice.append(
            "The field changes in no log, so the delay of the device stays unknown: log steps of the field while the "
            "slip moves."
        )
    return advice


def _named(logs: Sequence[str]) -> str:
    more = f" and {len(logs) - _NAMES} more" if len(logs) > _NAMES else ""
    return ", ".join(logs[:_NAMES]) + more


def _missing(rows: Dataset) -> list[str]:
    """Which field and motion no log has, between the least and the most of what the logs have; the largest first."""

    def size(gap: tuple[int, int, int, int]) -> int:
        """Cells of a gap."""
        lowest, highest, first, last = gap
        return (highest - lowest + 1) * (last - first + 1)

    every = -(-rows.rows // _MOST_ROWS)
    sentences: list[str] = []
    for number, element in enumerate(rows.elements):
        field = np.abs(element.field[::every])
        slip = element.slip[::every]
        if np.ptp(field) == 0.0 or np.ptp(slip) == 0.0:
            continue
        field_edges = _edges(field, _FIELD_BANDS)
        slip_edges = _edges(slip, _SLIP_BANDS)
        counts: Array = np.histogram2d(field, slip, (field_edges, slip_edges))[0]

        # A gap is a region without a row: first and last band of the field, first and last band of the slip.
        gaps: list[tuple[int, int, int, int]] = []
        for band in range(_FIELD_BANDS):
            runs: list[tuple[int, int]] = []  # first and last of each run of empty neighbours
            for cell in range(_SLIP_BANDS):
                if counts[band, cell]:
                    continue
                if runs and runs[-1][1] == cell - 1:
                    runs[-1] = (runs[-1][0], cell)
                else:
                    runs.append((cell, cell))
            for first, last in runs:
                below = [gap for gap in gaps if gap[1:] == (band - 1, first, last)]
                start = below[0][0] if below else band
                gaps = [gap for gap in gaps if gap not in below] + [(start, band, first, last)]

        which = f" of clutch {number + 1}" if len(rows.elements) > 1 else ""
        for lowest, highest, first, last in sorted(gaps, key=size, reverse=True):
            fields = _range(field_edges[lowest], field_edges[highest + 1], rows.units.field)
            slips = _range(slip_edges[first], slip_edges[last + 1], rows.units.slip)
            sentences.append(f"No log has field {fields} with slip {slips}{which}.")
    if len(sentences) > _MOST_LINES:
        more = len(sentences) - _MOST_LINES
        sentences = [*sentences[:_MOST_LINES], f"{more} more regions hold no row."]
    return sentences


def _edges(values: Array, bands: int) -> list[float]:
    """From the least to the most value, both included, shape (bands + 1,)."""
    low = float(values.min())
    high = float(values.max())
    edges = [low + (high - low) * band / bands for band in range(bands)]
    return [*edges, high]


def _range(low: float, high: float, unit: str) -> str:
    known = "" if unit in ("", "?") else f" {unit}"
    return f"{low:.3g} .. {high:.3g}{known}"
