"""A sensor that is wrong drives no field of the exported controller, on the TWIN."""

from __future__ import annotations

import pytest

from tests.support.exported_controller import UNTOLD, sessions


@pytest.mark.slow
def test_a_wrong_sensor_drives_no_field_of_the_exported_controller() -> None:
    """An encoder that jumped brought field again after 11 ms, and left it too high for up to 106 ms."""
    held = {(sensor, kind): run for sensor, kind, (run,) in sessions(range(1))}
    assert len(held) == 30
    wrong = [name for name, run in held.items() if not run.held and name not in UNTOLD]
    assert wrong == []
