"""Flow curves that nobody here made: the figures that they have given so far, and no worse."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from erclutch.wings.rheology.flow_curve import fit_flow_curve
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.support.command import good

pytestmark = pytest.mark.slow

FLOW = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "flow_curves"

if not FLOW.is_dir():
    pytest.skip(f"needs the measured data beside the project: {FLOW}", allow_module_level=True)


def test_herschel_bulkley_on_every_volume_fraction_of_dekker() -> None:
    curves = read_flow_curves(FLOW / "Fig2_Dekker2018.csv").curves
    assert [curve.label for curve in curves] == [
        "0.68",
        "0.7",
        "0.72",
        "0.74",
        "0.76",
        "0.78",
        "0.8",
    ]
    for curve in curves:
        found = fit_flow_curve(curve, "herschel-bulkley")
        assert found.stop == "converged"
        assert found.log_rmse <= 0.030, curve.label
        values = {e.name: e for e in found.estimates}
        assert values["T_y"].low < values["T_y"].value < values["T_y"].high
        assert 0.3 < values["m"].value < 0.7


def test_all_eight_files_are_read() -> None:
    files = sorted(FLOW.glob("*.csv"))
    assert len(files) == 8
    for path in files:
        curves = read_flow_curves(path).curves
        assert curves
        assert all(curve.rate.size == curve.stress.size >= 4 for curve in curves), path.name
        assert all(curve.rate.min() > 0 and curve.stress.min() > 0 for curve in curves), path.name


def test_every_law_fits_every_flow_curve() -> None:
    for curve in json.loads(good("flowcurve", *sorted(FLOW.glob("*.csv")), "--json")):
        assert len(curve["fits"]) == 5
        assert curve["fits"][0]["log_rmse"] <= 0.06, (curve["file"], curve["curve"])
        errors = {f["law"]: f["log_rmse"] for f in curve["fits"]}
        assert errors["herschel-bulkley"] <= errors["bingham"] * (1 + 1e-6)
