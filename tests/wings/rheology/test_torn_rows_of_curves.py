"""A row of a flow curve that has cells too many is refused: no option drops it. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves


def test_a_row_with_a_cell_too_many_is_refused(tmp_path: Path) -> None:
    lines = [f"{rate:.3f},{3.0 + 0.2 * rate:.3f}" for rate in np.geomspace(1.0, 100.0, 40)]
    lines[20] += ",5,7"
    path = tmp_path / "flow.csv"
    path.write_text("\n".join(["shear rate [1/s],shear stress [Pa]", *lines, ""]))
    with pytest.raises(LogError, match="line 22 has 4 cells where 2 are expected"):
        read_flow_curves(path)
