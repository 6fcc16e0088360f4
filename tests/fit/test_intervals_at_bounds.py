"""Intervals beside parameters at bounds, and beside parameters that rows do not identify, hold a known truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.laws.profile_intervals import Optimum, interval_ends
from erclutch.fit.solver.intervals import uncertainty
from erclutch.fit.solver.levenberg_marquardt import minimise
from erclutch.fit.solver.variable_projection import Separable, jacobian, outer_problem
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import build_dataset
from erclutch.models.laws import Gain, ShapeParameter, law_from_name
from erclutch.models.laws.law import EFFORT
from erclutch.models.structure import Structure
from tests.support.examples import examples

ROWS = 500
TIME = np.linspace(0.0, 10.0, ROWS)  # [s]
EXPONENT = ShapeParameter("n", "exponent of the field", 0.2, 4.0)
LAG = ShapeParameter("lag", "time of the lag", 0.005, 1.0, scale="log")
DELAY = ShapeParameter("delay", "dead time", 0.0, 0.5)
SECOND = ShapeParameter("second", "time of a second lag", 1e-6, 1.0, scale="log")
INDEX = ShapeParameter("m", "flow index", 0.1, 3.0)
GAIN = Gain("c", "yield effort", EFFORT, nonnegative=True)
LARGE = Gain("K", "consistency", EFFORT, nonnegative=True)
FRICTION = Gain("T_f", "friction", EFFORT, nonnegative=True)


def steps(late: Any) -> Any:
    """Steps of a field, smooth, from 0.1 to 1, so many seconds late."""
    return 0.55 + 0.45 * np.tanh(4.0 * np.sin(2.0 * (TIME - late)))


def lagged(shapes: tuple[ShapeParameter, ...], target: Any) -> Separable:
    """A yield effort behind a lag and, of these shapes, further ones that no row tells from it."""

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        late = q[1]
        for further in q[2:]:
            late = late + further
        return [np.exp(q[0] * np.log(steps(late)))]

    return Separable(columns, target, shapes, (GAIN,))


def creeping(with_index: bool, target: Any) -> Separable:
    """A yield effort behind a lag, friction and a consistency at a slip that hardly changes."""
    slip = 1.0 + 1e-3 * np.sin(5.0 * TIME)
    shapes = (EXPONENT, LAG, INDEX) if with_index else (EXPONENT, LAG)

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        consistency = np.exp(q[2] * np.log(slip)) if with_index else slip
        return [np.exp(q[0] * np.log(steps(q[1]))), consistency, np.ones(ROWS)]

    return Separable(columns, target, shapes, (GAIN, LARGE, FRICTION))


def intervals(problem: Separable, start: Sequence[float]) -> tuple[Any, Any, Any]:
    """Ends and estimates of a fit by least squares."""
    minimum = minimise(outer_problem(problem), np.asarray(start, float))
    columns, slopes, projection = jacobian(problem, minimum.point)
    whole = np.column_stack([slopes, columns])
    residual = problem.target - columns @ projection.gains
    moving = ~(minimum.at_lower | minimum.at_upper)
    optimum = Optimum(
        point=np.concatenate([minimum.point, projection.gains]),
        slopes=whole,
        residual=residual,
        free=np.concatenate([moving, ~projection.held]),
        live=np.ones(whole.shape[1], np.bool_),
    )
    spread = uncertainty(whole[:, optimum.free], residual, ordered=False)
    low, high = interval_ends(problem, optimum, spread, ordered=False)
    return low, high, optimum.point


def noisy(exponent: float, late: float, noise: float, seed: int) -> Any:
    scatter = noise * np.random.default_rng([3, seed]).standard_normal(ROWS)
    return np.exp(exponent * np.log(steps(late))) + scatter


@pytest.mark.slow
@settings(max_examples=examples(10), deadline=None)
@given(st.floats(1.0, 2.5), st.floats(0.005, 0.1), st.floats(0.01, 0.1), st.integers(0, 1000))
def test_parameters_at_bounds_narrow_no_interval(
    exponent: float, late: float, noise: float, seed: int
) -> None:
    target = noisy(exponent, late, noise, seed)
    few = (EXPONENT, LAG)
    low, high, point = intervals(lagged(few, target), [exponent, np.log(late)])
    both_low, both_high, both = intervals(
        lagged((*few, DELAY, SECOND), target), [exponent, np.log(late), 0.0, np.log(1e-6)]
    )
    slack = 0.1 * (high - low)
    for narrow, wide in ((0, 0), (1, 1), (2, 4)):
        if both[wide] == pytest.approx(point[narrow], abs=0.02 * (high - low)[narrow]):
            assert both_low[wide] <= low[narrow] + slack[narrow]
            assert both_high[wide] >= high[narrow] - slack[narrow]


@pytest.mark.slow
@settings(max_examples=examples(10), deadline=None)
@given(st.floats(1.0, 2.5), st.floats(0.02, 0.1), st.floats(0.01, 0.1), st.integers(0, 1000))
@example(
    2.125, 0.03125, 0.015625, 85
)  # the gain of the index ends at nought, so that nothing moves the index
def test_an_index_that_no_row_tells_spoils_no_lag(
    exponent: float, late: float, noise: float, seed: int
) -> None:
    target = noisy(exponent, late, noise, seed) + 0.3
    low, high, _ = intervals(creeping(False, target), [exponent, np.log(late)])
    with_low, with_high, _ = intervals(creeping(True, target), [exponent, np.log(late), 1.0])
    for shape in (0, 1):
        assert np.isfinite(with_low[shape])
        width = high[shape] - low[shape]
        assert with_low[shape] == pytest.approx(low[shape], abs=0.25 * width)
        assert with_high[shape] == pytest.approx(high[shape], abs=0.25 * width)


@pytest.mark.slow
def test_intervals_with_parameters_at_bounds_hold_the_truth() -> None:
    """The truth has neither dead time nor second lag: both end at their bounds in about half of 100 logs."""
    inside = np.zeros(3)
    at_bounds = 0
    truth = np.array([1.5, np.log(0.05), 1.0])
    shapes = (EXPONENT, LAG, DELAY, SECOND)
    for seed in range(100):
        target = noisy(1.5, 0.05, 0.05, seed)
        low, high, point = intervals(lagged(shapes, target), [1.5, np.log(0.05), 0.0, np.log(1e-6)])
        at_bounds += point[2] == 0.0
        places = [0, 1, 4]
        inside += (low[places] <= truth) & (truth <= high[places])
    assert at_bounds >= 20
    # 95 % less twice the standard error of a share in 100 logs (2.2 points).
    assert inside.min() >= 95 - 4.4, inside


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3])
def test_an_index_at_its_bound_leaves_the_consistency_an_interval_on_both_sides(seed: int) -> None:
    """The slip has one size, so no row tells the index, which ends at a bound: the interval ended at the estimate."""
    rng = np.random.default_rng(seed)
    period = 0.002  # [s]
    time = np.arange(0.0, 20.0, period)
    field = rng.choice([0.0, 0.2, 0.4, 0.6], size=60)[(time / 0.4).astype(int)]
    slip = np.where(np.sin(0.4 * np.pi * time) > 0, 10.0, -10.0)
    settled = np.empty_like(field)
    state = field[0]
    decay = np.exp(-period / 0.02)
    for row, command in enumerate(field):
        state = decay * state + (1.0 - decay) * command
        settled[row] = state
    friction = 0.2 if seed == 3 else 0.0
    effort = 5.0 * settled * np.tanh(slip / 0.05) + 0.02 * slip + friction * np.sign(slip)
    effort += 0.03 * rng.standard_normal(time.size)
    log = recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort},
        {"field": "A", "slip": "rad/s", "effort": "N*m"},
        time=time,
        name="one size of slip",
    )
    structure = Structure("single", "herschel-bulkley", law_from_name("herschel-bulkley"), "lag")
    outcome = fit_structure(build_dataset(log, device="single"), structure)
    estimates = {estimate.name: estimate for estimate in outcome.estimates}
    assert estimates["m"].at_bound
    consistency = estimates["K"]
    below = consistency.value - consistency.low
    above = consistency.high - consistency.value
    assert 0.5 < above / below < 2.0
    assert estimates["tau"].low < 0.02 < estimates["tau"].high
