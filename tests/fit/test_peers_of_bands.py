"""Bands of independent errors are those of `crepes` and of MAPIE, to the last bit (SYNTHETIC).

Both know no clumps of errors and no direction of the slip, so rows here are independent and errors are given in the
direction of the slip already. Each test imports its peer: each process that collects tests would wait for all of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from erclutch.fit.bands.prediction_bands import LEVEL, calibrated
from erclutch.logs.dataset import Dataset
from erclutch.models.band import Band
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

pytestmark = pytest.mark.slow

PERIOD = 1e-3


def _rows(seed: int, rows: int) -> tuple[Dataset, Array]:
    """Rows, and errors of which every twentieth is large: as far apart as it goes, so that none counts as a clump."""
    rng = np.random.default_rng(seed)
    field = np.repeat(rng.choice([0.0, 30.0, 70.0, 100.0], -(-rows // 100)), 100)[:rows]
    slip = rng.standard_normal(rows)
    size = np.sort(rng.exponential(size=rows))
    few = -(-rows // 20)
    error = np.empty(rows)
    late = np.arange(rows) % 20 == 0
    error[late], error[~late] = (
        rng.permutation(size[rows - few :]),
        rng.permutation(size[: rows - few]),
    )
    error *= rng.choice([-1.0, 1.0], rows, p=[0.3, 0.7]) * np.sign(slip)
    clock = Clock(PERIOD * np.arange(float(rows)), (Span(0, rows, PERIOD),))
    return Dataset("single", (Element(field, slip),), error, clock, Units("N", "V", "m/s")), error


def own_errors(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Cells with so many rows that they borrow none."""
    return np.flatnonzero(np.bincount(cells) >= 100)


@pytest.fixture(params=[(0, 20_000), (1, 20_000), (2, 7_001)], ids=str)
def calibration(request: pytest.FixtureRequest) -> tuple[Band, float, Array, NDArray[np.intp]]:
    """A band, the width of its plain band, errors in the direction of the slip, and the cell of each."""
    data, error = _rows(*request.param)
    found = calibrated(data, np.ones(data.rows, np.bool_), [error], [0])[0]
    assert found is not None
    cells = found[0].cells(data.elements, data.clock)
    (element,) = data.elements
    assert own_errors(cells).size >= 20
    return found[0], found[1], np.where(element.slip < 0.0, -error, error), cells


def test_crepes_gives_each_cell_the_same_half_widths(
    calibration: tuple[Band, float, Array, NDArray[np.intp]],
) -> None:
    from crepes import ConformalRegressor

    band, _, directed, cells = calibration
    own = own_errors(cells)
    some = np.isin(cells, own)
    for sign, widths in ((1.0, band.ahead), (-1.0, band.behind)):
        peer = ConformalRegressor()
        peer.fit(np.maximum(sign * directed[some], 0.0), bins=cells[some])
        ends = peer.predict_int(np.zeros(own.size), bins=own, confidence=0.5 * (1.0 + LEVEL))
        assert np.array_equal(np.array(widths)[own], ends[:, 1])


def test_mapie_gives_each_cell_the_same_half_widths(
    calibration: tuple[Band, float, Array, NDArray[np.intp]],
) -> None:
    from mapie.conformity_scores import AbsoluteConformityScore
    from mapie.regression import SplitConformalRegressor
    from sklearn.dummy import DummyRegressor

    band, _, directed, cells = calibration
    for cell in own_errors(cells):
        own = directed[cells == cell]
        none = np.zeros((own.size, 1))
        zero = DummyRegressor(strategy="constant", constant=0.0).fit(none, own)
        peer = SplitConformalRegressor(zero, LEVEL, AbsoluteConformityScore(sym=False), prefit=True)
        low, high = peer.conformalize(none, own).predict_interval(none[:1])[1].ravel()
        assert (band.behind[cell], band.ahead[cell]) == (-low, high)


def test_the_plain_band_is_that_of_crepes_and_mapie(
    calibration: tuple[Band, float, Array, NDArray[np.intp]],
) -> None:
    from crepes import ConformalRegressor
    from mapie.regression import SplitConformalRegressor
    from sklearn.dummy import DummyRegressor

    _, plain, directed, _ = calibration
    crepes = ConformalRegressor()
    crepes.fit(np.abs(directed))
    assert plain == np.ptp(crepes.predict_int(np.zeros(1), confidence=LEVEL))
    none = np.zeros((directed.size, 1))
    zero = DummyRegressor(strategy="constant", constant=0.0).fit(none, directed)
    mapie = SplitConformalRegressor(zero, LEVEL, prefit=True).conformalize(none, directed)
    assert plain == np.ptp(mapie.predict_interval(none[:1])[1])
