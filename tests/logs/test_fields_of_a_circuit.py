"""Of the voltages and currents of a bench that turns one way, what was set for the coil is the field. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import read
from tests.support.command import run

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(800) / 100
LEVELS = np.repeat([0.0, 0.5, 1.0, 1.5], 200)
SPEED = 9 + 6 * np.sin(3 * TIME)
TORQUE = (0.2 + 1.8 * LEVELS) * np.tanh(SPEED) + 0.02 * SPEED
COLUMNS = {
    "coil": LEVELS,
    "volts": 10 * LEVELS,
    "motor": TORQUE / 2,
    "load": -TORQUE / 2.1,
    "supply": np.full(TIME.size, 24.0),
}


def _log(folder: Path, head: str, *columns: str) -> Path:
    values = [TIME, *(COLUMNS[each] for each in columns), TORQUE, SPEED]
    rows = "\n".join(",".join(f"{x:.6g}" for x in row) for row in zip(*values, strict=True))
    path = folder / "log.csv"
    path.write_text(f"time (s),{head},Torque (Nm),Speed (rad/s)\n{rows}\n")
    return path


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("CH1 Current,CH2 Voltage,CH2 Current", ("coil", "supply", "motor")),
        ("CH1 (V),CH1 (A),CH2 (A)", ("volts", "coil", "motor")),
        ("brake_voltage_V,brake_current_A,motor_current_A", ("volts", "coil", "motor")),
        ("U [kV],E [kV/mm]", ("volts", "coil")),
    ],
)
def test_the_current_of_the_coil_is_the_field(
    tmp_path: Path, head: str, columns: tuple[str, ...]
) -> None:
    # --field none was printed, for all of them went straight with the torque; of U and E it was printed too.
    log = read(_log(tmp_path, head, *columns))
    scale = 1e6 if "kV/mm" in head else 1.0  # V/m
    np.testing.assert_allclose(log.signals["field"], scale * LEVELS, atol=1e-6 * scale)


def test_the_current_of_a_motor_is_doubted_where_nothing_turns_its_sign(tmp_path: Path) -> None:
    # It was the field, in silence.
    path = _log(tmp_path, "I_motor,I_load", "motor", "load")
    with pytest.raises(MappingError, match="I_motor which is called like that of a drive"):
        read(path)


@pytest.mark.slow
def test_a_command_proposes_no_voltage_of_the_coil(tmp_path: Path) -> None:
    head = "coil 1 voltage [V],coil 1 current [A],coil 2 current [A]"
    path = _log(tmp_path, head, "volts", "coil", "coil")
    printed = run("inspect", path.name, cwd=tmp_path).out.splitlines()[-1]
    assert printed.endswith('--field "coil 1 current [A]"')
