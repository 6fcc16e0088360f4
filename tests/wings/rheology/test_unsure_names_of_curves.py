"""A flow curve whose columns may have the names of others is asked about. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves


def test_a_flow_curve_by_such_names_is_asked_about(tmp_path: Path) -> None:
    rates = np.geomspace(1.0, 100.0, 20)
    lines = [f"{rate:.4f},{3.0 + 0.2 * rate:.4f},{rate}" for rate in rates]
    path = tmp_path / "flow.csv"
    names = "shear rate [1/s],shear stress [Pa],time [s],temperature [C],torque [mNm]"
    path.write_text("\n".join([names, *lines, ""]), encoding="utf-8")
    with pytest.raises(MappingError, match="names 5 columns, the rows have 3 cells"):
        read_flow_curves(path)
    curves = read_flow_curves(path, shear_rate="shear rate [1/s]", stress=["shear stress [Pa]"])
    assert len(curves.curves) == 1
