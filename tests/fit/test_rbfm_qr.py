"""The RBFM's linear fit against a QR of all rows, where its condition is worst and where bounds bind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from tests.support.pair import pair_rows


@pytest.fixture(scope="module")
def pair() -> Dataset:
    """A pair whose torque falls with the first slip, so that a viscosity is held at zero."""
    rows = pair_rows(20.0, seed=3)
    return replace(rows, effort=rows.effort - 0.01 * rows.elements[0].slip)


def by_qr(matrix: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, float]:
    """Fitted effort by a QR of all rows, refined with residuals in extended precision, and the condition number."""
    scaled = matrix / np.linalg.norm(matrix, axis=0)
    q, r = np.linalg.qr(scaled)
    wide = scaled.astype(np.longdouble)
    gains = np.zeros(r.shape[0], np.longdouble)
    for _ in range(4):
        left = (target - wide @ gains).astype(np.float64)
        gains += np.linalg.solve(r, q.T @ left)
    return (wide @ gains).astype(np.float64), float(np.linalg.cond(r))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rbfm-5", "rbfm-10"])
def test_predictions_equal_those_of_a_full_qr(pair: Dataset, name: str) -> None:
    structure = Structure("coaxial", name, law_from_name(name, "coaxial"))
    found = fit_structure(pair, structure, intervals=False)
    columns = structure.columns(
        pair.elements, pair.clock, reference_of(pair), list(found.model.shape.values())
    )
    matrix = np.column_stack([np.broadcast_to(c, pair.effort.shape) for c in columns])
    gains = np.array(list(found.model.gains.values()))
    free = gains != 0.0
    assert not free.all(), "no bound binds in these data: the test shows nothing of them"
    peer, condition = by_qr(matrix[:, free], pair.effort)
    assert condition > 1e3
    apart = found.model.predict(pair) - peer
    assert np.linalg.norm(apart) <= 1e-6 * np.linalg.norm(peer)
    # Where a gain is held at zero, letting it in would need it negative.
    nonnegative = np.array([g.nonnegative for g in structure.gains()])
    slope = matrix[:, ~free].T @ (pair.effort - peer)
    assert np.all(nonnegative[~free])
    assert np.all(
        slope <= 1e-8 * np.linalg.norm(matrix[:, ~free], axis=0) * np.linalg.norm(pair.effort)
    )
