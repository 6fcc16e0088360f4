"""No field is no safety where a field releases a device: the exported controller refuses its model."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, export_model
from erclutch.export.monotone import releases
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from tests.fit.test_releasing_field import brake


@pytest.mark.slow
def test_no_controller_takes_a_device_for_safe_that_no_field_makes_hold(tmp_path: Path) -> None:
    data = brake()
    law = law_from_name("bingham/falling", "single")
    model = fit_structure(data, Structure("single", "bingham/falling", law, friction=True)).model
    assert releases(model)
    with pytest.raises(ExportError, match="way to safety is no field"):
        export_model(model, tmp_path / "out", "controller", ExportOptions("brake"))
    export_model(model, tmp_path / "c", "c", ExportOptions("brake"))
