"""What stood on the pages of `erclutch app` and made a newcomer stumble."""

from __future__ import annotations

from typing import Any

import pytest

from erclutch.wings.app import actions
from erclutch.wings.app.log_page import signals_of
from erclutch.wings.app.run_answers import run_row
from erclutch.wings.app.workspace import Entry


@pytest.mark.parametrize(
    ("note", "said"),
    [
        ("time <- date and time in column Uhrzeit", "date and time in column Uhrzeit"),
        (
            "time from the sampling rate of 200 Hz (given)",
            "from the sampling rate of 200 Hz (given)",
        ),
        ("field <- column I [A] (given)", "not logged"),
    ],
)
def test_a_time_that_no_column_of_numbers_is_says_where_it_comes_from(note: str, said: str) -> None:
    """The clock was read from dates, and the page said "not logged"."""
    found: dict[str, Any] = {"choices": {}, "columns": {}, "reading": [note]}
    rows = {row["name"]: row for row in signals_of(found, actions.chosen_of({}))}
    assert rows["time"]["without"] == said
    assert rows["temperature"]["without"] == "not logged"


@pytest.mark.parametrize(
    ("count", "said"), [(2, "0A.txt, 1A.txt"), (30, "30 logs, 0A.txt ... 29A.txt")]
)
def test_a_run_of_many_logs_takes_one_line_of_the_overview(count: int, said: str) -> None:
    """Thirty names filled the page, and on a phone they pushed model and error out of it."""
    logs = [{"name": f"{number}A.txt", "sha256": f"{number:064d}"} for number in range(count)]
    test = {"rmse": [1.0, 0.9, 1.1], "share": [0.3, 0.2, 0.4], "r2": [0.91, 0.9, 0.95]}
    model = {"name": "bingham", "title": "Bingham law", "sound": True, "test": test}
    body: dict[str, Any] = {
        "recommended": "bingham",
        "ranking": [model],
        "findings": [],
        "logs": logs,
        "units": {"effort": "N*m"},
        "settings": {},
    }
    assert run_row(Entry("run", 0, 0.0), body)["logs"] == said
