"""scikit-learn's own checks on every estimator, and the uses that they are for.

A fixture imports the estimators, and each test what it needs of scikit-learn: its import takes half a second of each
process that collects all tests.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from erclutch.errors import SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks import fit_fnn
from erclutch.fit.networks import fit_network as fit_network_module
from erclutch.fit.networks.fit_fnn import schedule_for
from erclutch.fit.networks.fit_network import fit_network
from erclutch.models.laws import ladder, law_from_name
from erclutch.models.networks import network_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from tests.support.pair import pair_rows

#: Estimators by the name of their class and its arguments.
Named = tuple[str, tuple[Any, ...]]
LAWS: list[Named] = [("LawRegressor", (law,)) for law in ladder()]
NETWORKS: list[Named] = [
    ("FnnRegressor", ((2,),)),
    ("RbfnRegressor", (8,)),
    ("RbfnRegressor", (40, "kmeans")),
    ("RbfnRegressor", (8, "refined")),
    ("RbfnRegressor", (8, "spreads")),
]


@pytest.fixture
def estimator(request: pytest.FixtureRequest) -> Any:
    from erclutch import estimators

    name, arguments = request.param
    return getattr(estimators, name)(*arguments)


#: Laws whose fits make intervals in scikit-learn's checks: without shapes, with one, with many gains.
WITH_INTERVALS = ("on-off", "bingham", "rbfm-5")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:the columns .* look standardised")  # scikit-learn's rows are
@pytest.mark.parametrize("estimator", [*LAWS, *NETWORKS], ids=str, indirect=True)
def test_scikit_learns_own_checks(estimator: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """All but the check of the array API, which is for estimators that claim to take other arrays than NumPy's.

    Intervals take half the time of a law's fit, and no check asks for them. Nor does one ask for the best of ten starts
    of a network.
    """
    from sklearn.utils.estimator_checks import estimator_checks_generator

    def two_starts(*given: Any, **named: Any) -> fit_fnn.Schedule:
        whole = schedule_for(*given, **named)
        rounds = tuple(replace(each, kept=min(each.kept, 2)) for each in whole.rounds)
        return replace(whole, starts=2, rounds=rounds)

    monkeypatch.setattr(fit_network_module, "schedule_for", two_starts)

    if getattr(estimator, "law", "on-off") not in WITH_INTERVALS:
        monkeypatch.setattr(
            "erclutch.estimators.fit_structure", partial(fit_structure, intervals=False)
        )
    for one, check in cast(Any, estimator_checks_generator(estimator)):
        if "array_api" not in str(check):
            check(one)


@pytest.fixture(scope="module")
def rows() -> tuple[np.ndarray, np.ndarray, Any]:
    data = pair_rows(20.0)
    first, second = data.elements
    columns = [
        first.field,
        second.field,
        0.5 * (first.slip - second.slip),
        -0.5 * (first.slip + second.slip),
    ]
    return np.column_stack(columns), data.effort, data


@pytest.mark.slow
def test_a_law_is_that_of_the_comparison(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from erclutch.estimators import LawRegressor

    X, y, data = rows
    mine = LawRegressor("hem/forward", "coaxial").fit(X, y)
    theirs = fit_structure(
        data, Structure("coaxial", "hem/forward", law_from_name("hem/forward", "coaxial"))
    )
    np.testing.assert_allclose(mine.predict(X), theirs.model.predict(data), rtol=1e-6, atol=1e-9)
    assert mine.score(X, y) == pytest.approx(1 - theirs.train_cost / np.sum((y - y.mean()) ** 2))


@pytest.mark.slow
def test_a_law_with_memory_is_that_of_the_comparison(
    rows: tuple[np.ndarray, np.ndarray, Any],
) -> None:
    from sklearn.base import clone

    from erclutch.estimators import LawRegressor

    X, y, data = rows
    X, y, part = X[:4000], y[:4000], data.clock.spans[0]
    assert part.stop >= 4000
    mine = LawRegressor("bingham", "coaxial", "lag+dahl/field").fit(X, y)
    plain = LawRegressor("bingham", "coaxial", "lag").fit(X, y)
    assert mine.model_.name == "bingham+lag+dahl/field"
    assert mine.score(X, y) > plain.score(X, y)
    effort = mine.model_.effort(
        mine._rows(X, y).elements,
        Clock(np.arange(4000, dtype=np.float64) * 1e-3, (Span(0, 4000, 1e-3),)),
    )
    np.testing.assert_array_equal(mine.predict(X), effort)
    np.testing.assert_array_equal(cast(Any, clone(mine)).fit(X, y).predict(X), effort)
    with pytest.raises(SettingError, match="dahl-x"):
        LawRegressor("bingham", "coaxial", "lag+dahl-x").fit(X, y)


@pytest.mark.slow
def test_a_network_is_that_of_the_comparison(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from erclutch.estimators import FnnRegressor

    X, y, data = rows
    inputs = np.column_stack([X[:, 0] - X[:, 1], X[:, 2], X[:, 3]])
    mine = FnnRegressor((6,), seed=3).fit(inputs, y)
    theirs = fit_network(data, network_from_name("fnn-6"), seed=3)
    # The comparison knows which inputs are slips and makes its cells narrow there; the estimator does not.
    assert mine.score(inputs, y) == pytest.approx(
        1 - theirs.train_cost / np.sum((y - y.mean()) ** 2), abs=0.03
    )


@pytest.mark.slow
def test_columns_of_a_frame_are_taken_by_name(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from erclutch.estimators import FnnRegressor, LawRegressor

    X, y, _ = rows
    X, y = X[:2000], y[:2000]
    names = ["E1", "E2", "theta_dot [rad/s]", "alpha_dot [rad/s]"]
    frame = pd.DataFrame(X, columns=names)
    swapped = frame[[names[2], names[1], names[3], names[0]]].assign(note="b")
    by_place, by_name = (LawRegressor("bingham", "coaxial").fit(given, y) for given in (X, swapped))
    np.testing.assert_array_equal(by_name.predict(swapped), by_place.predict(X))
    np.testing.assert_array_equal(by_name.predict(frame), by_place.predict(X))
    with pytest.raises(SettingError, match="no column alpha_dot beside E1, E2, theta_dot"):
        by_name.predict(frame[names[:3]])
    network = FnnRegressor((2,)).fit(frame, y)
    with pytest.raises(ValueError, match="feature names"):
        network.predict(swapped[names[::-1]])


@pytest.mark.slow
def test_standardised_columns_are_told(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import MinMaxScaler, StandardScaler

    from erclutch.estimators import LawRegressor

    X, y, _ = rows
    X, y = X[:2000], y[:2000]
    with pytest.warns(UserWarning, match="look standardised"):
        make_pipeline(StandardScaler(), LawRegressor("bingham", "coaxial")).fit(X, y)
    with pytest.warns(UserWarning, match=r"scaled to 0 \.\. 1"):
        make_pipeline(MinMaxScaler(), LawRegressor("bingham", "coaxial")).fit(X, y)
    frame = pd.DataFrame(X, columns=["E1", "E2", "theta_dot", "alpha_dot"])
    law = LawRegressor("bingham", "coaxial").fit(frame, y)
    assert vars(law)["feature_names_in_"].tolist() == list(frame.columns)
    scaler = StandardScaler().set_output(
        transform="pandas"
    )  # keeps the names, so only the values give it away
    with pytest.warns(UserWarning, match="look standardised"):
        law.predict(scaler.fit_transform(frame))


@pytest.mark.slow
def test_grid_search_over_blocks_in_time(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from sklearn.model_selection import GridSearchCV, TimeSeriesSplit, cross_val_score
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer

    from erclutch.estimators import FnnRegressor, LawRegressor

    X, y, _ = rows
    split = TimeSeriesSplit(3)
    laws = {"law": ["on-off", "rbfm-5/forward"]}
    grid = GridSearchCV(LawRegressor(device="coaxial"), laws, cv=split).fit(X, y)
    by_hand = {
        law: cross_val_score(LawRegressor(law, "coaxial"), X, y, cv=split).mean()
        for law in laws["law"]
    }
    assert grid.best_params_["law"] == max(by_hand, key=lambda law: by_hand[law])
    assert grid.best_score_ == pytest.approx(max(by_hand.values()))
    signed = FunctionTransformer(lambda X: np.column_stack([X[:, 0] - X[:, 1], X[:, 2], X[:, 3]]))
    pipeline = make_pipeline(signed, FnnRegressor((6,)))
    assert pipeline.fit(X, y).score(X, y) > 0.5


@pytest.mark.slow
def test_workers_and_clones_change_nothing(rows: tuple[np.ndarray, np.ndarray, Any]) -> None:
    from sklearn.base import clone

    from erclutch.estimators import FnnRegressor

    X, y, _ = rows
    one = FnnRegressor((5,), seed=1).fit(X, y)
    two = cast(Any, clone(one)).set_params(n_jobs=2).fit(X, y)
    np.testing.assert_array_equal(one.predict(X), two.predict(X))


@pytest.mark.parametrize(
    "estimator",
    [
        ("FnnRegressor", ((0,),)),
        ("FnnRegressor", ((100_000,),)),
        ("FnnRegressor", ((),)),
        ("RbfnRegressor", (0,)),
        ("RbfnRegressor", (5, "magic")),
        ("LawRegressor", ("hme",)),
        ("LawRegressor", ("bingham", "triple")),
    ],
    ids=str,
    indirect=True,
)
def test_settings_that_cannot_be(estimator: Any) -> None:
    with pytest.raises(SettingError):
        estimator.fit(np.random.default_rng(0).normal(size=(100, 4)), np.arange(100.0))
