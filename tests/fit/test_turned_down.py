"""A model that does better on the rows held out than the recommended one is told, with why it is not recommended."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from erclutch.cli.ranking_table import verdict
from erclutch.fit.choice.ranking import with_reasons
from erclutch.fit.choice.turned_down import NOT_IDENTIFIED, what_speaks_against
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import build_dataset
from erclutch.report.html.verdict_section import choice
from erclutch.report.numbers.run_material import material_of
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording


def errors_of(*sizes: float) -> list[Array]:
    """Errors of these sizes on parts of 40 rows."""
    return [size * np.tile([1.0, -1.0], 20) for size in sizes]


def test_a_freer_model_is_told_the_part_on_which_it_loses_most_to_the_best_law() -> None:
    errors = {
        "casson+lag": errors_of(1.0, 1.0, 1.0),
        "worse": errors_of(2.0, 2.0, 2.0),
        "network": errors_of(0.5, 1.4),
    }
    worth = {"casson+lag": 0, "worse": 0}
    assert what_speaks_against({"network": 2}, errors, worth, "N") == {
        "network": "on a part of the training rows that its fit had not seen it errs by 1.4 N, "
        "Casson law with a lag by 1"
    }


def test_a_gain_that_is_too_little_is_told_over_all_parts() -> None:
    errors = {"bingham": errors_of(1.0, 1.0), "network": errors_of(0.98, 0.98)}
    why = what_speaks_against({"network": 2}, errors, {"bingham": 0}, "N")["network"]
    assert why.startswith("its gain on parts")
    assert why.endswith("it errs by 0.98 N, Bingham law by 1")


def test_a_model_that_was_not_in_question_has_no_errors_to_tell() -> None:
    against = what_speaks_against({"other": 0, "third": 0}, {"law": errors_of(1.0)}, {"law": 0}, "")
    assert set(against) == {"other", "third"}
    assert all("err by less on the training rows" in why for why in against.values())


@cache
def logged() -> Recording:
    """A log of Bingham's law and noise."""
    rng = np.random.default_rng(0)
    t: Array = 2e-3 * np.arange(3000.0)
    field = 0.5 + 0.5 * np.tanh(3.0 * np.sin(1.7 * t))
    slip = 3.0 * np.sin(4.4 * t) + 2.0 * np.sin(11.9 * t)
    effort = (
        (0.1 + 0.8 * field**1.5) * np.tanh(slip / 0.3)
        + 0.05 * slip
        + 0.02 * rng.standard_normal(t.size)
    )
    signals = {"field": field, "slip": slip, "effort": effort}
    return recording_from_arrays(
        signals, {"field": "A", "slip": "rad/s", "effort": "N*m"}, rate=500.0
    )


@cache
def compared() -> Comparison:
    """Bingham's law, which is recommended, and a switch."""
    return compare(build_dataset(logged()), Settings(("bingham", "on-off"), lag="none"))


def with_a_better_row(sound: bool) -> Comparison:
    """As if the switch erred by half as much on the rows held out, and more on the training rows."""
    comparison = compared()
    bingham, on_off = (comparison.entry(name) for name in ("bingham", "on-off"))
    half = replace(on_off.test, rmse=replace(on_off.test.rmse, value=0.5 * bingham.test.rmse.value))
    better = replace(on_off, test=half, sound=sound)
    entries = with_reasons([better, bingham], "bingham", {"on-off": "it is worse elsewhere"})
    return replace(comparison, entries=tuple(entries), best="on-off")


@pytest.mark.slow
def test_a_row_that_is_no_better_is_not_told() -> None:
    comparison = compared()
    assert comparison.recommended == "bingham"
    assert not any(entry.turned_down for entry in comparison.entries)
    assert "not recommended" not in verdict(comparison)


@pytest.mark.slow
@pytest.mark.parametrize("sound", [True, False])
def test_the_verdict_tells_a_better_row_and_why_it_is_not_recommended(sound: bool) -> None:
    told = verdict(with_a_better_row(sound))
    assert "m1, " in told
    reason = "it is worse elsewhere" if sound else NOT_IDENTIFIED
    assert told.endswith(f"there and is not recommended: {reason}.")


@pytest.mark.slow
def test_the_report_tells_a_better_row_too(tmp_path: Path) -> None:
    run = read_run(write_run(tmp_path / "run", with_a_better_row(True), [logged()]))
    assert choice(material_of(run)).endswith("there and is not recommended: it is worse elsewhere.")
