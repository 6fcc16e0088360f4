"""Rows of the table of `make attack`."""

from __future__ import annotations

from tests.support.attack_rows import Row, joined


def test_parts_of_a_dear_task_are_one_row() -> None:
    parts = [Row("races of demo", 50), Row("races of demo", 30, ["lost"]), Row("races of fit", 100)]
    rows = [(row.name, row.tries, row.failures) for row in joined(iter(parts))]
    assert rows == [("races of demo", 80, ["lost"]), ("races of fit", 100, [])]
    assert list(joined(iter(()))) == []


def test_a_row_says_how_many_tries_the_time_left_out() -> None:
    whole, short = Row("races of fit", 100), Row("damaged csv", 220, note="at most 164 MiB")
    whole.was_to_try(100)
    short.was_to_try(1000)
    assert whole.note == ""
    assert short.note == "the time was over after 220 of 1000; at most 164 MiB"
