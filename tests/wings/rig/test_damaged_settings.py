from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.damaged_settings import KINDS, fault_of, make_settings


@pytest.mark.slow
def test_a_damaged_rig_mapping_plan_or_model_is_read_or_refused(tmp_path: Path) -> None:
    """`make attack` tries 1,000 of each."""
    make_settings(tmp_path)
    assert [
        fault
        for kind in KINDS
        for number in range(30)
        if (fault := fault_of(kind, number, tmp_path))
    ] == []
