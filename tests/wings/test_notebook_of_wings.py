"""What a notebook shows of a flow curve and of a fleet: a line, a small table, DataFrames, axes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.logs.synthetic import write_synthetic_log

pytestmark = pytest.mark.slow


def test_a_flow_curve_shows_itself() -> None:
    from matplotlib import pyplot

    rate = np.geomspace(0.1, 300.0, 12)
    curve = erclutch.FlowCurve("<b>starch", rate, 3.0 + 2.0 * rate**0.6)
    assert repr(curve).startswith("FlowCurve(")
    assert not re.search(r"[\x00-\x1f]", repr(curve))
    page = curve._repr_html_()
    assert "<table" in page
    assert "<b>starch" not in page
    assert not re.search(r"<script|https?://|url\(|@import", page)
    assert len(page) < 100_000
    assert "4 more: .table()" in page
    assert curve.plot().get_ylabel() == "Shear stress [Pa]"
    pyplot.close("all")


def test_a_fleet_shows_its_devices(tmp_path: Path) -> None:
    for seed, name in enumerate(("one", "two")):
        write_synthetic_log(tmp_path / f"{name}.csv", 1.2, seed)
    fleet = erclutch.fit_many(
        tmp_path, ("bingham",), out=tmp_path / "fleet", settings=erclutch.Settings(lag="none")
    )
    assert fleet.table()["device"].tolist() == ["one.csv", "two.csv"]
    assert "two.csv" in fleet._repr_html_()
    assert len(fleet.to_frame()) == len(fleet.parameters)
