"""What is said of a fitted model, whether it is sound, and which models are fitted: the parts of a comparison."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from erclutch.fit.candidate import asked, kinds, names
from erclutch.fit.choice import ranking as c
from erclutch.fit.comparison import compare
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.network_alone import constants_for, networks_for, remembered
from erclutch.fit.solver.outcome import MEANINGLESS, FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import PAPER
from erclutch.models.networks import PAPER_NETWORKS
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

N = 100


def data() -> Dataset:
    """Two stretches of 50 rows at 10 Hz: a slip of 2 m/s in the first, of 0.5 m/s in the second; efforts 0 ... 9."""
    slip = np.where(np.arange(N) < 50, 2.0, -0.5)
    clock = Clock(np.arange(N) / 10.0, (Span(0, 50, 0.1), Span(50, N, 0.1)))
    return Dataset(
        "single",
        (Element(np.ones(N), slip),),
        np.arange(float(N)) % 10,
        clock,
        Units("N", "V", "m/s"),
    )


def switched() -> Dataset:
    """A law whose field switches, SYNTHETIC."""
    rng = np.random.default_rng(0)
    field = np.repeat(rng.uniform(0, 1, 40), 10)
    slip = rng.normal(size=400)
    effort = field * np.tanh(3 * slip) + 0.1 * slip + 0.01 * rng.normal(size=400)
    clock = Clock(np.arange(400) / 1000.0, (Span(0, 400, 1e-3),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N", "V", "m/s"))


def outcome(**changes: Any) -> Any:
    made: dict[str, Any] = {
        "estimates": (),
        "weights": (),
        "stop": "tolerance",
        "rank": 3,
        "unknowns": 3,
        "condition": 10.0,
        "converged": True,
        "idle": (),
        "iterations": 7,
        "at_bounds": (),
        "model": SimpleNamespace(
            correction=None, times={}, structure=SimpleNamespace(dynamics="none")
        ),
        "unidentified": tuple(e.name for e in changes.get("estimates", ()) if e is OPEN),
    }
    return SimpleNamespace(**{**made, **changes})


def estimate(name: str, value: float, low: float, high: float, at_bound: bool = False) -> Any:
    return SimpleNamespace(name=name, value=value, low=low, high=high, at_bound=at_bound)


OPEN, SHUT = (
    estimate("eta", 1.0, -np.inf, np.inf),
    estimate("n", 1.0, -np.inf, np.inf, at_bound=True),
)


@pytest.mark.parametrize(
    ("changes", "sound"),
    [
        ({}, True),
        ({"rank": 2}, False),
        ({"converged": False}, False),
        ({"condition": MEANINGLESS}, True),
        ({"condition": 1.01 * MEANINGLESS}, False),
        ({"estimates": (OPEN,)}, False),
        ({"estimates": (SHUT,)}, True),
        ({"weights": (1,), "rank": 0, "converged": False}, True),
        ({"weights": (1,), "stop": "stalled"}, False),
    ],
)
def test_what_is_sound(changes: dict[str, Any], sound: bool) -> None:
    assert FitOutcome.sound.fget(outcome(**changes)) == sound  # pyright: ignore[reportOptionalCall]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, ()),
        (
            {"converged": False, "stop": "steps"},
            ("solver stopped before its tolerance (steps after 7 steps)",),
        ),
        ({"converged": False, "stop": "steps", "weights": (1,)}, ()),
        ({"at_bounds": ("n", "w_s")}, ("at a bound: n, w_s",)),
        ({"estimates": (OPEN, SHUT), "rank": 2}, ("not identified by these data: eta",)),
        ({"rank": 2, "condition": 1e30}, ("rank 2 of 3: parameters trade off",)),
        ({"condition": 1e30}, ("condition 1e+30: its parameters mean nothing one by one",)),
    ],
)
def test_what_is_said(changes: dict[str, Any], said: tuple[str, ...]) -> None:
    log, test = data(), np.arange(N) >= 70
    assert c.notes_on(outcome(**changes), log, log.effort, test) == said


def test_rows_far_outside_all_efforts() -> None:
    """Efforts seen are 0 to 9 around 4.5: far is 27 from there."""
    log, test = data(), np.arange(N) >= 70
    predicted = log.effort.copy()
    predicted[[70, 71, 72, 73, 10]] = 4.5 + 27.1, 4.5 - 27.1, 4.5 + 26.9, np.nan, 1e9
    assert c._wild(log, predicted, test) == 3
    said = "3 test rows are predicted far outside all efforts seen: do not extrapolate this model"
    assert c.notes_on(outcome(), log, predicted, test) == (said,)


@pytest.mark.parametrize(("share", "short"), [(0.99, 0), (1.01, 1), (3.9, 1), (4.1, 2)])
def test_stretches_that_end_before_the_start_is_forgotten(share: float, short: int) -> None:
    """The second stretch goes 49 steps of 0.05 m, the first one four times as far."""
    length = share * 49 * 0.05 / c._FORGOTTEN
    model = SimpleNamespace(
        correction=None,
        times={"r_1": length, "delay": 0.1, "r_h": 1e3},
        structure=SimpleNamespace(dynamics="lag+remanence+dahl"),
    )
    own = outcome(
        model=model,
        estimates=(
            estimate("r_1", length, 0.0, 1.0),
            estimate("delay", 0.1, 0.0, 1.0),
            estimate("r_h", 1e3, 0.0, 1.0),  # of a field, in its unit: no slip forgets it
        ),
    )
    said = (
        [f"{short} of 2 stretches are too short to forget the start of r_1 = {length:.3g}"]
        if short
        else []
    )
    assert c.too_short(own, data()) == said
    assert c.too_short(outcome(estimates=own.estimates), data()) == []


@pytest.mark.parametrize(
    ("alone", "both", "said"),
    [
        (2.0, 1.0, "50.0 % less"),
        (1.0, 1.5, "50.0 % more"),
        (0.0, 0.0, "no less"),
        (2.0, 2.0, "0.0 % less"),
    ],
)
def test_what_a_network_adds(alone: float, both: float, said: str) -> None:
    log, test = data(), np.arange(N) >= 70
    law = SimpleNamespace(predict=lambda d: d.effort + alone)
    model: Any = SimpleNamespace(law_part=law, correction=SimpleNamespace(limit=0.5))
    predicted = np.where(test, log.effort + both, 1e9)
    assert c.what_the_network_adds(model, log, predicted, test) == (
        f"test RMSE {alone:.4g} N of the law alone, {both:.4g} N with the network ({said}); "
        "the network moves the effort by at most 0.5 N"
    )


def test_which_models_are_asked_for() -> None:
    def of_all_kinds(models: tuple[str, ...], lag: str) -> list[list[tuple[str, str]]]:
        return [asked(Settings(models, lag=lag), switched(), kind) for _, kind in kinds()]

    assert of_all_kinds(
        ("bingham", "fnn-4+lag", "casson + fnn-3", "casson+fnn-3 + lag+ dahl"), "auto"
    ) == [
        [("bingham", "none"), ("bingham", "lag")],
        [("casson+fnn-3", "none"), ("casson+fnn-3", "lag"), ("casson+fnn-3", "lag+dahl")],
        [("fnn-4", "lag")],
    ]
    assert of_all_kinds(("bingham",), "none") == [[("bingham", "none")], [], []]
    paper = names(Settings(("paper", "bingham")))
    assert paper[-1] == "bingham"
    assert len(paper) == 1 + len(PAPER) + len(PAPER_NETWORKS)
    assert names(Settings(("all",)))[-2:] == ["rbfn-10", "fnn-16"]


def test_a_network_has_the_stages_that_remember() -> None:
    assert remembered("lag+dahl/field+viscous") == "lag+dahl/field"
    assert remembered("viscous") == "none"


@pytest.mark.slow
def test_a_comparison_in_which_only_a_law_beside_networks_is_fitted_for_their_lag() -> None:
    made = switched()
    (network,) = networks_for(made, Settings(("rbfn-3+lag",)))
    found = constants_for(made, network, [])
    assert set(found) == {"delay", "t"} or len(found) == 2
    assert constants_for(made, networks_for(made, Settings(("rbfn-3+none",)))[0], []) == {}


@pytest.mark.slow
def test_a_log_that_a_law_meets_to_the_last_digit_is_ranked_by_its_training_rows() -> None:
    """Rows without noise, those held out of one field: an error of nought is no divisor."""
    count = 600
    row = np.arange(count)
    field = np.where((row // 11) % 2 & (row < 420), 1.0, 0.0)
    slip = np.where((row // 7) % 2, 2.0, -1.0) * np.where((row // 5) % 3 == 0, 0.5, 1.0)
    clock = Clock(row / 100.0, (Span(0, count, 0.01),))
    rows = Dataset(
        "single",
        (Element(field, slip),),
        2.0 * slip,
        clock,
        Units("N", "A", "m/s"),
        spare={"x": np.cos(row / 100.0)},
    )
    result = compare(rows, Settings(models=("on-off", "quadratic", "fnn-2"), lag="none"))
    exact = [entry for entry in result.entries if entry.train.rmse.value == 0.0]
    assert exact
    assert result.entry(result.recommended) in exact
