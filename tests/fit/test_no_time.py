"""Points of a table, none after another in time, are fitted without a lag, a memory or past samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.errors import SettingError
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.history import history
from erclutch.fit.no_time import in_no_time
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.timing import of_points


def points(rows: int = 1200) -> Dataset:
    """A curve with a field that is switched from point to point, whose effort follows the field a row later."""
    rng = np.random.default_rng(0)
    field = np.repeat(rng.integers(0, 3, rows // 4).astype(float), 4)
    slip = np.linspace(1.0, 50.0, rows)
    effort = 2.0 * np.roll(field, 1) + 0.01 * slip + 0.01 * rng.standard_normal(rows)
    signals = {"field": field, "slip": slip, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    data = build_dataset(recording_from_arrays(signals, units, rate=1.0))
    return replace(data, notes=(*data.notes, *of_points(rows, 1.0).notes))


def test_no_lag_is_offered_and_a_line_says_why() -> None:
    comparison = compare(points(), Settings(models=("bingham",)))
    assert [entry.outcome.model.structure.dynamics for entry in comparison.entries] == ["none"]
    assert any("the rows are points of a table" in str(finding) for finding in comparison.findings)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (Settings(models=("bingham",), lag="lag"), "the stages lag follow a time"),
        (Settings(models=("bingham+dahl",)), "the stages dahl follow a time"),
        (Settings(models=("fnn-2",), past=(1,)), "past samples follow a time"),
    ],
)
def test_what_needs_a_time_is_refused(asked: Settings, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        compare(points(), asked)


def test_a_history_is_not_looked_for() -> None:
    data = points()
    assert in_no_time(data)
    assert history(data) is None
