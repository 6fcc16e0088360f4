"""A law is fitted to rows on disk as to the same rows in memory: on centroids, and with a memory on windows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.errors import CheckError, SettingError
from erclutch.fit.laws import fit_law
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.laws.law_centroids import signed_rows, spaced_rows
from erclutch.logs import read, read_batches
from erclutch.logs.dataset import build_dataset
from erclutch.logs.disk_rows import DiskRows
from erclutch.models.law_model import Reference, Structure
from erclutch.models.laws import law_from_name
from erclutch.signals.device import Element
from erclutch.signals.speed import Derivative

N = 24_000  # more than two batches


def write(path: Path, *, both: int = 0) -> Path:
    """A pair under one field at a time, or in some rows under both."""
    rng, t = np.random.default_rng(0), np.arange(N) * 1e-3
    signed = 0.45 * np.sin(2.1 * t) * np.sin(0.37 * t + 1.0)
    one, two = np.maximum(signed, 0.0), np.maximum(-signed, 0.0)
    two[:both] = one[:both] = 0.2
    w, v = 30.0 + 6.0 * np.cos(3.0 * t), 10.4 * np.cos(1.3 * t)
    torque = 0.1 * one**1.2 * np.tanh((w - v) / 9.0) + 0.1 * two**1.2 * np.tanh((-w - v) / 9.0)
    torque += 1e-3 * (one * (w - v) + two * (-w - v)) - 4e-4 * v + 1e-3 * rng.standard_normal(N)
    columns = {"time [s]": np.round(t, 6), "E1": one, "E2": two, "theta_dot": w, "alpha_dot": v, "T": torque}
    pq.write_table(pa.table(columns), path, row_group_size=8000)
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("disk") / "log.parquet")


def spooled(path: Path) -> DiskRows:
    spool = DiskRows()
    device: Any = "coaxial"
    spool.add(read_batches(path, device=device, rows=10_000), device, Derivative())
    return spool


def structure(name: str, dynamics: str = "none") -> Structure:
    return Structure("coaxial", name, law_from_name(name, "coaxial"), dynamics)


@pytest.mark.parametrize(
    ("name", "dynamics"),
    [("bingham", "none"), ("quadratic", "none"), pytest.param("bingham", "lag", marks=pytest.mark.slow)],
)
def test_the_same_numbers(log: Path, monkeypatch: pytest.MonkeyPatch, name: str, dynamics: str) -> None:
    monkeypatch.setattr(fit_law, "MANY_ROWS", 10_000)
    data = build_dataset(read(log, device="coaxial"), device="coaxial")
    with spooled(log) as spool:
        one = fit_structure(data, structure(name, dynamics), intervals=False)
        other = fit_structure(spool, structure(name, dynamics))
    assert dict(other.model.shape) == pytest.approx(dict(one.model.shape), rel=1e-4 if dynamics != "none" else 1e-8)
    assert dict(other.model.gains) == pytest.approx(dict(one.model.gains), rel=1e-4)
    assert other.train_cost == pytest.approx(one.train_cost, rel=1e-6)
    assert (other.rank, other.unknowns, other.train_rows) == (one.rank, one.unknowns, one.train_rows)
    assert other.model.trained_on == one.model.trained_on
    assert other.model.reference == one.model.reference
    assert all(np.isnan(e.low) and np.isnan(e.high) for e in other.estimates)


def test_what_cannot_be_fitted_to_rows_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit_law, "MANY_ROWS", 10_000)
    with spooled(write(tmp_path / "b.parquet", both=7)) as spool:
        assert spool.under_both_fields == 7
        with pytest.raises(CheckError, match="7 rows"):
            fit_structure(spool, structure("hem"))
    with pytest.raises(SettingError, match="its stimulus steps or saturates inside cells"):
        fit_law.require_no_stimulus(structure("on-off"))


def test_rows_as_centroids_see_them() -> None:
    first = Element(np.array([1.0, 0.0]), np.array([2.0, -3.0]))
    second = Element(np.array([0.0, 4.0]), np.array([5.0, 6.0]))
    np.testing.assert_array_equal(signed_rows((first, second)), [[1.0, -4.0], [2.0, -3.0], [5.0, 6.0]])
    np.testing.assert_array_equal(signed_rows((first,)), [[1.0, 0.0], [2.0, -3.0]])
    reference = Reference(1.0, 10.0, 1e-3)
    spaced = spaced_rows(signed_rows((first,)), reference)
    assert np.argsort(spaced[1]).tolist() == [1, 0]
    np.testing.assert_array_equal(spaced[0], [1.0, 0.0])
