"""Calibration of the twin: a known rig is found again, a search resumes, and bad requests are refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from erclutch.errors import CheckError, ErclutchError, MappingError, RunError, SettingError
from erclutch.wings.paper.calibration.calibrate import calibrate
from erclutch.wings.paper.calibration.log_trace import LogTrace
from erclutch.wings.paper.calibration.paper_summary import (
    PaperSummary,
    Summary,
    is_held_ratio,
    summarise,
)
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.parameters_file import rig_text, write_rig
from erclutch.wings.rig.twin.scenarios import prepare
from tests.support.command import refused

Array = NDArray[np.float64]


class Bowl:
    """A target whose minimum is known: the logarithms of two parameters."""

    name = "bowl"
    digest = ""
    ordered: ClassVar[bool] = False

    def __init__(self) -> None:
        self.seen = 0
        self.most = 10**9

    def residuals(self, rig: RigParameters) -> Array:
        self.seen += 1
        if self.seen > self.most:
            raise KeyboardInterrupt
        x, y = np.log(rig.value("fluid.viscosity") / 0.1), np.log(rig.value("drive.inertia") / 5e-4)
        return np.array([20.0 * x, 20.0 * y, 5.0 * x * y])


PATHS = ("fluid.viscosity", "drive.inertia")


@pytest.mark.slow
@pytest.mark.parametrize("evaluations", [0, 480])
def test_both_searches_find_the_minimum(evaluations: int) -> None:
    found = calibrate(default_rig(), PATHS, Bowl(), evaluations=evaluations, workers=1)
    assert found.rig.value("fluid.viscosity") == pytest.approx(0.1, rel=0.02)
    assert found.rig.value("drive.inertia") == pytest.approx(5e-4, rel=0.02)
    assert found.after < found.before
    for one in found.parameters:
        assert one.low < one.value < one.high
        # The residual is 20 x the logarithm: a standard deviation of 5 %.
        assert np.log(one.high / one.low) == pytest.approx(4 * 0.05 * 0.98, rel=0.1)
        assert found.rig.entry(one.path).source == "calibrated"
        assert found.rig.entry(one.path).interval == (one.low, one.high)


def test_a_calibrated_rig_starts_where_its_calibration_did() -> None:
    once = calibrate(default_rig(), PATHS, Bowl(), workers=1)
    again = calibrate(once.rig, PATHS, Bowl(), workers=1)
    assert [c.start for c in again.parameters] == [c.start for c in once.parameters]
    assert again.rig.entries == once.rig.entries


@pytest.mark.slow
def test_a_wide_search_resumes_from_its_journal(tmp_path: Path) -> None:
    journal = tmp_path / "rig.journal"
    whole = calibrate(default_rig(), PATHS, Bowl(), evaluations=96, workers=1)
    calibrate(default_rig(), PATHS, Bowl(), evaluations=48, workers=1, journal=journal)
    journal.write_text(journal.read_text() + '{"search": "cut of')  # as after a power cut
    target = Bowl()
    resumed = calibrate(default_rig(), PATHS, target, evaluations=96, workers=1, journal=journal)
    assert resumed.rig.entries == whole.rig.entries
    assert target.seen < 48 + 8
    with pytest.raises(RunError, match="other settings"):
        calibrate(default_rig(), PATHS, Bowl(), seed=2, evaluations=96, workers=1, journal=journal)
    journal.write_text('{"nothing": 1}\n')
    with pytest.raises(RunError, match="no journal"):
        calibrate(default_rig(), PATHS, Bowl(), evaluations=96, workers=1, journal=journal)


def test_a_journal_of_another_rig_or_of_other_rows_is_refused(tmp_path: Path) -> None:
    """What it holds was taken for figures of the rig and the log that the command was given, in silence."""
    journal = tmp_path / "rig.journal"
    calibrate(default_rig(), PATHS, Bowl(), rounds=1, workers=1, journal=journal)
    changed = default_rig().changed({"screw.lead": 0.012})  # it is not varied, and not in the start
    with pytest.raises(RunError, match="other settings"):
        calibrate(changed, PATHS, Bowl(), rounds=1, workers=1, journal=journal)
    other = Bowl()
    other.digest = "a log of that name with other rows"
    with pytest.raises(RunError, match="other settings"):
        calibrate(default_rig(), PATHS, other, rounds=1, workers=1, journal=journal)


def test_rounds_of_the_local_search_go_on_from_the_journal(tmp_path: Path) -> None:
    """A search that ends in the middle of its slopes keeps each rig that it tried."""
    journal = tmp_path / "rig.journal"
    whole = Bowl()
    found = calibrate(default_rig(), PATHS, whole, rounds=6, workers=1)
    cut = Bowl()
    cut.most = whole.seen // 2
    with pytest.raises(KeyboardInterrupt):
        calibrate(default_rig(), PATHS, cut, rounds=6, workers=1, journal=journal)
    resumed = Bowl()
    again = calibrate(default_rig(), PATHS, resumed, rounds=6, workers=1, journal=journal)
    assert again.rig.entries == found.rig.entries
    assert resumed.seen <= whole.seen - cut.most + 2
    assert found.rig.value("fluid.viscosity") == pytest.approx(0.1, rel=0.05)


@pytest.mark.slow
def test_progress_counts_the_rigs_of_both_searches() -> None:
    told: list[int] = []
    calibrate(
        default_rig(),
        PATHS,
        Bowl(),
        evaluations=16,
        rounds=2,
        workers=1,
        progress=lambda done, cost: told.append(done),
    )
    assert told[0] == 16
    assert told == sorted(told)
    assert told[-1] > 16


def test_weight_zero_leaves_the_held_ratios_out() -> None:
    laws = {"bingham/forward": 2.0, "seo-seo/forward": 1.0}
    pairs = Summary({"training": laws, "zero-motion": laws}, 0.4).against_paper()
    assert pairs["training seo-seo/forward over Bingham"][:2] == pytest.approx(
        (0.5, 6.387 / 9.3285)
    )
    assert [figure for figure in pairs if is_held_ratio(figure)] == [
        "zero-motion seo-seo/forward over Bingham"
    ]


@pytest.mark.slow
def test_the_twin_is_compared_over_several_seeds() -> None:
    target = PaperSummary(seeds=(1, 2), seconds=5.0, held=0.0)
    figures = summarise(default_rig(), target.seeds, target.seconds, target.thin)
    alone = [summarise(default_rig(), [seed], target.seconds, target.thin) for seed in target.seeds]
    for run, laws in figures.errors.items():
        for law, error in laws.items():
            assert error == pytest.approx(sum(one.errors[run][law] for one in alone) / 2)
    apart = dict(zip(figures.against_paper(), target.residuals(default_rig()), strict=True))
    assert [name for name, value in apart.items() if value == 0.0] == [
        name for name in apart if is_held_ratio(name)
    ]


@pytest.mark.parametrize("paths", [(), ("fluid.viscosity", "fluid.viscosity"), ("fluid.viscosty",)])
def test_parameters_that_cannot_be(paths: tuple[str, ...]) -> None:
    with pytest.raises(SettingError):
        calibrate(default_rig(), paths, Bowl(), workers=1)


def test_a_start_outside_its_range_is_refused() -> None:
    with pytest.raises(SettingError, match="outside its range"):
        calibrate(
            default_rig().changed({"drive.ripple": 0.5}), ("drive.ripple",), Bowl(), workers=1
        )


@pytest.mark.slow
def test_a_log_that_cannot_calibrate() -> None:
    log = prepare("training", seconds=2.0).recording()
    without = {name: values for name, values in log.signals.items() if name != "motor_torque"}
    from dataclasses import replace

    with pytest.raises(MappingError, match="motor_torque is missing"):
        LogTrace(replace(log, signals=without))
    with pytest.raises(CheckError, match="Resample"):
        LogTrace(replace(log, period=2e-3))
    with pytest.raises(CheckError, match="Give a longer log"):
        LogTrace(prepare("training", seconds=0.3).recording())


@pytest.mark.slow
def test_a_rig_file_holds_all_of_a_rig(tmp_path: Path) -> None:
    rig = calibrate(default_rig(), PATHS, Bowl(), workers=1).rig
    path = write_rig(
        tmp_path / "rig.toml",
        rig,
        {"target": 'a "log"', "figures": {"ratio a/b": [1.0, 2.0]}, "seed": 1},
    )
    assert load_rig(path).entries == rig.entries
    import tomllib

    assert tomllib.loads(path.read_text())["calibration"]["figures"]["ratio a/b"] == [1.0, 2.0]
    assert rig_text(load_rig(path)) == rig_text(rig)
    assert json.dumps(load_rig(path).to_dict()) == json.dumps(rig.to_dict())
    with pytest.raises(ErclutchError, match="cannot end in"):
        write_rig(tmp_path / "rig.json", rig)
    with pytest.raises(ErclutchError, match="cannot be written"):
        write_rig(tmp_path / "none" / "rig.toml", rig)


def test_a_log_is_not_written_over_by_its_rig(tmp_path: Path) -> None:
    """With --force the rig that was found took the place of the log that it was found by."""
    (tmp_path / "log.csv").write_text("t [s],E1 [V]\n0,1\n", encoding="utf-8")
    error = refused("calibrate-twin", "log.csv", "--out", "log.csv", "--force", cwd=tmp_path)
    assert "log.csv: this is one of the logs" in error
