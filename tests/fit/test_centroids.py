"""A law's fit on the weighted centroids of a long log against one on all of its rows (SYNTHETIC)."""

from __future__ import annotations

import pytest

from erclutch.fit.laws.fit_law import MANY_ROWS, fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from tests.support.pair import pair_rows


@pytest.fixture(scope="module")
def long_log() -> Dataset:
    return pair_rows(290.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bingham", "ss", "hem", "ccj", "herschel-bulkley"])
def test_centroids_cost_next_to_nothing(long_log: Dataset, name: str) -> None:
    assert long_log.rows >= MANY_ROWS
    structure = Structure("coaxial", name, law_from_name(name, "coaxial"))
    on_centroids, on_rows = (
        fit_structure(long_log, structure, intervals=False, polish=p) for p in (False, True)
    )
    assert on_centroids.model.shape != on_rows.model.shape, (
        "both were fitted on all rows: the test shows nothing"
    )
    assert (
        on_rows.train_cost * (1 - 1e-9)
        <= on_centroids.train_cost
        <= on_rows.train_cost * (1 + 2e-5)
    )
