"""One way of reading serves commands, large fits and what a run says of other logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.cli.options import LogOptions
from erclutch.errors import MappingError, SettingError
from erclutch.fit.comparison import Settings
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.reading import Reading
from erclutch.logs.synthetic import write_synthetic_log


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("reading") / "log.csv"
    write_synthetic_log(path, 1.0)
    return path


def test_batches_refuse_what_needs_the_whole_log(log: Path) -> None:
    with pytest.raises(SettingError, match="needs the whole log in memory"):
        Reading(rate=500.0).batches(log, "single")


def test_options_of_a_run_are_understood_as_on_the_command_line() -> None:
    options = {
        "e1": "U [V]",
        "rate": "1000 Hz",
        "input": ["D"],
        "scale": ["effort=2 N/V"],
        "device": "coaxial",
    }
    found = ColumnMap.from_options(options)
    assert (found.columns["E1"].column, found.rate, found.scales) == (
        "U [V]",
        1000.0,
        {"effort": "2 N/V"},
    )
    with pytest.raises(MappingError, match="--constant 'speed' is no signal"):
        ColumnMap.from_options({"constant": ["speed=2"]})


@pytest.mark.slow
def test_a_run_scales_the_sensor_of_another_log_as_its_own(log: Path, tmp_path: Path) -> None:
    reading = LogOptions(effort="torque [V]", scale=("effort=2 N*m/V",))
    recordings = reading.read([log])
    result = erclutch.compare(reading.dataset(recordings), Settings(("quadratic",), lag="none"))
    erclutch.write_run(tmp_path / "run", result, recordings, reading=reading.to_dict())
    assert erclutch.predict(tmp_path / "run", str(log)).equals(
        erclutch.predict(tmp_path / "run", log)
    )
    rmse = erclutch.score(tmp_path / "run", log)["rmse"][0]
    predicted = result.entries[0].outcome.model.predict(result.data)
    assert rmse == pytest.approx(
        float(np.sqrt(np.mean((result.data.effort - predicted) ** 2))), rel=1e-9
    )
