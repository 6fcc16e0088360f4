"""The library holds what the Arduino IDE looks for, and its C gives the model's bits."""

from __future__ import annotations

from pathlib import Path

from erclutch.export import export_model, verify_export
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.model import Range
from erclutch.models.structure import Reference, Structure
from erclutch.signals.device import Units


def test_a_library_that_gives_the_models_bits(tmp_path: Path) -> None:
    model = TorqueModel(
        Structure("single", "bingham", law_from_name("bingham")),
        Reference(1.0, 10.0, 1e-3),
        {"w_s": 0.1, "n": 1.7},
        {"T_y": 0.9, "eta": 0.013},
        Units("N*m", "A", "rad/s"),
        Range((0.0, 1.0), (-20.0, 20.0), (-1.0, 1.0)),
    )
    folder = export_model(model, tmp_path / "out", "arduino")
    assert "includes=bingham.h" in (folder / "library.properties").read_text()
    assert "bingham_step(&state" in (folder / "examples" / "bingham" / "bingham.ino").read_text()
    checks = verify_export(folder)
    assert checks
    assert all(check.passed and check.other_bits == 0 for check in checks)
