"""A window in time keeps the rows inside it, of a whole log and of a log in batches."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from erclutch.errors import SettingError
from erclutch.logs import recording_from_arrays
from erclutch.logs.batches import Batch
from erclutch.logs.keywords import SECONDS, number_of
from erclutch.logs.time_window import batches_within, within
from erclutch.signals.recording import Recording


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("2", 2.0),
        ("2 s", 2.0),
        ("500ms", 0.5),
        ("1 min", 60.0),
        ("-3 s", -3.0),
        ("0", 0.0),
        ("1e11", 1e11),
    ],
)
def test_times_as_people_write_them(text: str, seconds: float) -> None:
    assert number_of("from", text, SECONDS) == pytest.approx(seconds, rel=1e-15)


@pytest.mark.parametrize("text", ["soon", "", "2 V", "nan", "inf", "1e12", "1e12 s", "-1e12"])
def test_what_is_no_time(text: str) -> None:
    with pytest.raises(SettingError, match=r"--from '.*' is no time"):
        number_of("from", text, SECONDS)


@pytest.fixture
def log() -> Recording:
    """100 rows from 5 s on at 100 Hz, with a gap of a second after 40 of them."""
    time = 5.0 + 0.01 * np.arange(100)
    time[40:] += 1.0
    rows = np.arange(100.0)
    signals = {"field": rows, "slip": rows, "effort": rows}
    return recording_from_arrays(signals, {"field": "V", "slip": "m/s", "effort": "N"}, time=time)


@pytest.mark.parametrize(
    ("begin", "end", "skip", "first", "last"),
    [
        (5.1, 5.2, None, 10, 20),
        (None, 5.2, None, 0, 20),
        (5.3, None, None, 30, 99),
        (None, None, 0.2, 20, 99),
        (5.1, None, 0.2, 20, 99),
        (5.3, None, 0.2, 30, 99),
        (5.1, 5.2 - 1e-9, None, 10, 20),
        (5.1, 5.1999, None, 10, 19),
        (None, None, 0.0, 0, 99),
    ],
)
def test_the_rows_of_a_window(
    log: Recording,
    begin: float | None,
    end: float | None,
    skip: float | None,
    first: int,
    last: int,
) -> None:
    found = within(log, begin, end, skip)
    rows = np.arange(first, last + 1)
    np.testing.assert_array_equal(found.signals["effort"], rows)
    np.testing.assert_array_equal(found.time, log.time[rows])
    before = int(np.count_nonzero(rows < 40))
    cut = ((0, before), (before, rows.size)) if last >= 40 else ((0, rows.size),)
    assert found.segments == tuple((a, b) for a, b in cut if a < b)
    start, until = max(begin or 5.0, 5.0 + (skip or 0.0)), 6.99 if end is None else end
    assert found.notes[-1] == f"taken from {start:.6g} s to {until:.6g} s: {rows.size} of 100 rows"


def test_no_window_is_the_log_itself(log: Recording) -> None:
    assert within(log) is log


@pytest.mark.parametrize(
    ("window", "problem"),
    [
        ({"begin": 6.91}, "9 rows lie from 6.91 s on, 10 are needed"),
        ({"begin": 5.0, "end": 5.08}, "9 rows lie from 5 s on and up to 5.08 s, 10 are needed"),
        ({"begin": 5.5, "end": 5.9}, "0 rows lie from 5.5 s on and up to 5.9 s, 10 are needed"),
        ({"skip": -1.0}, "--skip -1 s"),
    ],
)
def test_a_window_with_too_few_rows(log: Recording, window: dict[str, float], problem: str) -> None:
    with pytest.raises(SettingError) as caught:
        within(log, **window)
    assert caught.value.problem == problem
    remedy = "The log goes from 5 s to 6.99 s: widen --from, --until or --skip"
    assert caught.value.remedy == (
        remedy if "rows" in problem else "Give the time to leave out, 0 or more"
    )
    with pytest.raises(SettingError) as caught:
        list(batches_within(in_batches(log, 25, 3), **window))
    assert caught.value.problem == problem
    assert caught.value.remedy == (
        remedy if "rows" in problem else "Give the time to leave out, 0 or more"
    )


def test_ten_rows_are_enough(log: Recording) -> None:
    assert within(log, 6.9).rows == 10


def in_batches(log: Recording, size: int, margin: int) -> list[Batch]:
    """Batches with margins, as of a file that is read stretch by stretch."""
    found: list[Batch] = []
    for start in range(0, log.rows, size):
        a, b = max(start - margin, 0), min(start + size + margin, log.rows)
        cut = sorted({a, b, *(40,) * (a < 40 < b)})
        signals = {name: values[a:b] for name, values in log.signals.items()}
        segments = tuple((i - a, j - a) for i, j in pairwise(cut))
        part = replace(log, signals=signals, time=log.time[a:b], segments=segments)
        found.append(Batch(part, np.arange(a, b), start, min(start + size, log.rows)))
    return found


@pytest.mark.parametrize(
    "window", [(5.1, 5.3, None), (None, None, 0.05), (5.2, 6.6, 0.5), (None, 6.45, None)]
)
def test_batches_keep_the_rows_that_the_whole_log_keeps(
    log: Recording, window: tuple[float | None, float | None, float | None]
) -> None:
    own = []
    for batch in batches_within(in_batches(log, 25, 3), *window):
        inside = (batch.rows >= batch.start) & (batch.rows < batch.stop)
        own.append(batch.recording.signals["effort"][inside])
        assert all(b - a <= batch.recording.rows for a, b in batch.recording.segments)
    np.testing.assert_array_equal(np.concatenate(own), within(log, *window).signals["effort"])
