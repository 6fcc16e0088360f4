"""Units in unusual places of names, tables of plant historians, and units in capitals are read. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from erclutch.logs import read
from erclutch.logs.columns.label_forms import in_usual_form
from erclutch.logs.columns.labels import name_columns
from erclutch.signals import units
from tests.support.pace import within

TIME = np.arange(300) / 100
CURRENT = np.repeat([0.0, 0.5, 1.0], 100)
SPEED = 15 * np.sin(10.7 * TIME)  # rad/s
TORQUE = (0.8 + 4.2 * CURRENT) * np.tanh(SPEED / 2) + 0.2 * SPEED
IN_ORDER = (CURRENT, SPEED, TORQUE)


def assert_read_in_si(path: Path) -> None:
    log = read(path)
    assert log.period == pytest.approx(0.01)
    assert log.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    for signal, numbers in zip(("field", "slip", "effort"), IN_ORDER, strict=True):
        np.testing.assert_allclose(log.signals[signal], numbers, rtol=1e-5, atol=1e-5)


def written(path: Path, head: str, columns: Sequence[np.ndarray], stamp: str = "") -> Path:
    rows = [",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns, strict=True)]
    if stamp:
        rows = [f"{stamp}{t:06.3f},{row}" for t, row in zip(TIME, rows, strict=True)]
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "head",
    [
        "[s] Time,[mA] Current,[rad/s] Speed,[mNm] Torque",
        "Time:s,Current:mA,Speed:rad/s,Torque:mNm",
        "Time-s,Current-mA,Speed-rad/s,Torque-mNm",
        "\"('Time', 's')\",\"('Current', 'mA')\",\"('Speed', 'rad/s')\",\"('Torque', 'mNm')\"",
        "Time,Current {unit=mA},Speed {unit=rad/s},Torque {unit=mNm}",
        "time [s],Model Root/I_coil [mA]/Out1,Model Root/speed [rad/s]/Out1,Model Root/M [mNm]/Out1",
    ],
)
def test_units_in_unusual_places(tmp_path: Path, head: str) -> None:
    # They were taken as logged, mN m as well as N m; of a block's name "s]" was left.
    columns = (TIME, 1e3 * CURRENT, SPEED, 1e3 * TORQUE)
    assert_read_in_si(written(tmp_path / "log.csv", head, columns))


def test_a_head_in_capitals(tmp_path: Path) -> None:
    # MA was read as megaamperes.
    head = "TIME [SEC],COIL CURRENT [MA],SPEED [RAD/S],TORQUE [NM]"
    assert_read_in_si(written(tmp_path / "log.csv", head, (TIME, 1e3 * CURRENT, SPEED, TORQUE)))


@pytest.mark.parametrize(
    "labels",
    [
        ["motor:A", "motor:B", "time"],
        ["time", "v-ref", "F-m"],
        ["Phase:A", "Coil:A"],
        ["[1] first", "[2] second"],
        ["t [s]", "F [N]"],
        ["x-y", "y-z"],
    ],
)
def test_names_of_other_forms_stay(labels: list[str]) -> None:
    assert in_usual_form(labels) == labels


@pytest.mark.slow
def test_tables_of_a_plant_historian(tmp_path: Path) -> None:
    tags = (("Coil.Current", "A"), ("Shaft.Speed", "rad/s"), ("Brake.Torque", "Nm"))
    lines = ["TagName;DateTime;Value;EngUnits;Quality"]
    for t, *numbers in zip(TIME, *IN_ORDER, strict=True):
        for (tag, unit), number in zip(tags, numbers, strict=True):
            lines.append(f"{tag};2023-05-04 12:00:{t:06.3f};{number:.9g};{unit};Good")
    (tmp_path / "log.csv").write_text("\n".join(lines))
    assert_read_in_si(tmp_path / "log.csv")


def test_a_date_that_rests_is_no_time(tmp_path: Path) -> None:
    # The time of the start was taken, and the command that was printed took rows as points.
    start = "2023-05-04T12:00:00"
    head = "start,time,current_A,speed_rad_s,torque_Nm"
    path = written(tmp_path / "log.csv", head, IN_ORDER, f"{start},2023-05-04T12:00:")
    assert_read_in_si(path)


def test_cells_with_powers_in_their_units(tmp_path: Path) -> None:
    rows = zip(TIME, *IN_ORDER, strict=True)
    lines = [f"{t:g} s,{c:g} A,{w:.9g} rad s^-1,{m:.9g} Nm" for t, c, w, m in rows]
    (tmp_path / "log.csv").write_text("\n".join(["t,I,omega,torque", *lines]))
    assert_read_in_si(tmp_path / "log.csv")


@pytest.mark.parametrize(
    ("unit", "usual"),
    [("AMPS", "A"), ("M/S", "m/s"), ("N*M", "N*m"), ("MS", "ms"), ("GAUSS", "gauss")],
)
def test_units_in_capitals(unit: str, usual: str) -> None:
    # AMPS were attomiles a second, and a column of currents no field, in silence.
    read_as, meant = units.parse(unit), units.parse(usual)
    assert (read_as.factor, read_as.dimension) == (meant.factor, meant.dimension)


@pytest.mark.parametrize("sign", "[(:-'{ ")
def test_long_labels_take_no_long_time(sign: str) -> None:
    begin = process_time()
    name_columns([sign * 190, "x" + sign * 190, "[" + sign * 190])
    in_usual_form([sign * 20_000, "a" + sign * 20_000])
    assert within(process_time() - begin, 0.5)
