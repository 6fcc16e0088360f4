"""A torque that a drive tells as a share of its rated torque is never taken for N m: the rated torque is asked for."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(300) / 100
SLIP = 20 * np.sin(3 * TIME)
FIELD = np.where(TIME < 1.5, 0.0, 1.0)
TORQUE = (0.3 + 1.5 * FIELD) * np.tanh(2 * SLIP)  # N m
RATED = 2.0  # N m


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "of_rated", "sensor"),
    [
        ("Actual torque (% rated)", 100.0, "%"),
        ("Torque [% of rated]", 100.0, "%"),
        ("Istmoment [% Nennmoment]", 100.0, "%"),
        ("M/M_N [%]", 100.0, "%"),
        ("torque_permille", 1000.0, "count"),
        ("Drehmoment [‰]", 1000.0, "count"),
        ("6077h:00 Torque actual value", 1000.0, "count"),
        ("0x6077", 1000.0, "count"),
        ("torque_actual_value", 1000.0, "count"),
        ("torque_pu", 1.0, "count"),
    ],
)
def test_the_rated_torque_is_asked_for(
    tmp_path: Path, name: str, of_rated: float, sensor: str
) -> None:
    shares = of_rated * TORQUE / RATED
    rows = zip(TIME, SLIP, FIELD, shares, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{share:.4f}" for t, w, i, share in rows)
    (tmp_path / "log.csv").write_text(f"t [s],slip [rad/s],coil current [A],{name}\n{text}\n")
    printed = " ".join(good("inspect", "log.csv", cwd=tmp_path, code=1).split())
    assert "of the rated torque" in printed or "is the rated torque" in printed
    assert f"effort=NUMBER N*m/{sensor}" in printed
    *_, answer = printed.rpartition("erclutch inspect log.csv ")
    filled = answer.replace("NUMBER", f"{RATED / of_rated:g}")
    words = shlex.split(filled)
    options = dict(zip(words[::2], words[1::2], strict=True))
    log = read(tmp_path / "log.csv", effort=options["--effort"], scale=options["--scale"])
    assert log.units["effort"] == "N*m"
    assert log.signals["effort"] == pytest.approx(TORQUE, abs=2e-4)


@pytest.mark.parametrize("name", ["torque actual [Nm]", "Rated torque test [Nm]", "torque_Nm"])
def test_a_torque_in_its_unit_is_no_share(tmp_path: Path, name: str) -> None:
    rows = zip(TIME, SLIP, FIELD, TORQUE, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{torque:.4f}" for t, w, i, torque in rows)
    (tmp_path / "log.csv").write_text(f"t [s],slip [rad/s],coil current [A],{name}\n{text}\n")
    assert read(tmp_path / "log.csv").units["effort"] == "N*m"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("above", "name", "of_rated"),
    [
        ("# Rated torque: 2 N.m", "torque [%]", 100.0),
        ("# Nennmoment: 2 Nm", "Drehmoment [% Nennmoment]", 100.0),
        ("# T_n: 200 N cm", "torque [%]", 100.0),
        ("# nominal torque: 2 Nm", "torque_permille", 1000.0),
        ("# Rated motor torque: 2 Nm", "torque_actual_value", 1000.0),
        ("# Couple nominal: 2 N.m", "torque_pu", 1.0),
    ],
)
def test_a_rated_torque_above_the_rows_is_put_into_the_scale(
    tmp_path: Path, above: str, name: str, of_rated: float
) -> None:
    rows = zip(TIME, SLIP, FIELD, of_rated * TORQUE / RATED, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{share:.4f}" for t, w, i, share in rows)
    head = f"{above}\nt [s],slip [rad/s],coil current [A],{name}"
    (tmp_path / "log.csv").write_text(f"{head}\n{text}\n")
    printed = " ".join(good("inspect", "log.csv", cwd=tmp_path, code=1).split())
    assert "NUMBER" not in printed
    assert f"the file says {above.removeprefix('# ').replace(':', ' =')}" in printed
    *_, answer = printed.rpartition("erclutch inspect log.csv ")
    words = shlex.split(answer)
    options = dict(zip(words[::2], words[1::2], strict=True))
    log = read(tmp_path / "log.csv", effort=options["--effort"], scale=options["--scale"])
    assert log.signals["effort"] == pytest.approx(TORQUE, abs=2e-4)


@pytest.mark.slow
def test_a_rated_speed_or_power_says_nothing_of_a_torque(tmp_path: Path) -> None:
    rows = zip(TIME, SLIP, FIELD, TORQUE, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{torque:.4f}" for t, w, i, torque in rows)
    head = (
        "# Rated speed: 2 rpm\n# Rated torque: 2 kW\nt [s],slip [rad/s],coil current [A],torque [%]"
    )
    (tmp_path / "log.csv").write_text(f"{head}\n{text}\n")
    assert "effort=NUMBER N*m/%" in good("inspect", "log.csv", cwd=tmp_path, code=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "rated", "scale"),
    [
        ("Actual Torque (%)", "Rated torque (Nm)", 100.0),
        ("torque_pct", "rated_torque_Nm", 100.0),
        ("Torque (% of rated)", "Nennmoment (Nm)", 100.0),
        ("Actual Torque (0.1 %)", "Motor rated torque (Nm)", 1000.0),
    ],
)
def test_a_rated_torque_in_a_column_is_no_effort_and_fills_the_scale(
    tmp_path: Path, share: str, rated: str, scale: float
) -> None:
    # The rated torque, 2 N m in all rows, was the effort, in silence.
    rows = zip(TIME, SLIP, FIELD, scale * TORQUE / RATED, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{part:.4f},{RATED:g}" for t, w, i, part in rows)
    names = f"t [s],slip [rad/s],coil current [A],{share},{rated}"
    (tmp_path / "log.csv").write_text(f"{names}\n{text}\n")
    printed = " ".join(good("inspect", "log.csv", cwd=tmp_path, code=1).split())
    *_, answer = printed.rpartition("erclutch inspect log.csv ")
    assert rated.partition(" (")[0] not in answer.partition("--scale")[0]
    words = shlex.split(answer)
    good("inspect", "log.csv", *words, "--write-mapping", "log.csv.toml", cwd=tmp_path)
    np.testing.assert_allclose(read(tmp_path / "log.csv").signals["effort"], TORQUE, atol=1e-4)


@pytest.mark.parametrize("rated", ["Rated torque (Nm)", "Nominal torque (Nm)", "Nennmoment [Nm]"])
def test_a_rated_torque_stands_beside_a_measured_one(tmp_path: Path, rated: str) -> None:
    rows = zip(TIME, SLIP, FIELD, TORQUE, strict=True)
    text = "\n".join(f"{t:.2f},{w:.4f},{i:g},{m:.4f},{RATED:g}" for t, w, i, m in rows)
    names = f"t [s],slip [rad/s],coil current [A],Torque (Nm),{rated}"
    (tmp_path / "log.csv").write_text(f"{names}\n{text}\n")
    np.testing.assert_allclose(read(tmp_path / "log.csv").signals["effort"], TORQUE, atol=1e-4)
