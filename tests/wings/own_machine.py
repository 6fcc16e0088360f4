"""FMUs get the binary of this machine alone."""

from __future__ import annotations

import pytest

from erclutch.wings.exporters.fmu import fmu_binaries


@pytest.fixture
def own_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """FMUs get the binary of this machine alone, the only one that is run here: others cost seconds and have tests."""
    builders = fmu_binaries.builders
    monkeypatch.setattr(
        fmu_binaries, "builders", lambda version: (b for b in builders(version) if b.needed)
    )
