"""A unit behind the word for its quantity is read, whatever mark stands between them; a letter or a word is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read, read_table
from erclutch.logs.columns.labels import name_columns, own_unit
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.unit_behind_word import split_behind_word

MARKS = ["{}, {}", "{}: {}", "{} - {}", "{} {}", "{}_{}", "{}.{}", "{}={}"]
TIME = np.arange(600) / 200.0
SPEED = 6.0 * np.sin(5.0 * TIME) + 2.0 * np.sin(13.2 * TIME + 1.0)  # rad/s
CURRENT = np.repeat([0.0, 1.0, 0.5, 2.0, 1.5, 0.0], 100)  # A
TORQUE = (0.2 + CURRENT) * np.tanh(3.0 * SPEED) + 0.05 * SPEED  # N m


@pytest.mark.parametrize("mark", MARKS)
@pytest.mark.parametrize(
    ("word", "unit"),
    [
        ("Velocity", "mm.s-1"),
        ("Velocity", "mm s^-1"),
        ("Vitesse du piston", "mm/s"),
        ("Kolbengeschwindigkeit", "mm·s⁻¹"),
        ("скорость", "мм/с"),
        ("ピストン速度", "毫米/秒"),
        ("Angular velocity", "°/s"),
        ("Drehzahl", "min⁻¹"),
        ("Brake torque", "N·mm"),
        ("Torque", "Newton meters"),
        ("Bremsmoment", "kgf·cm"),
        ("par", "ft-lb"),
        ("trq", "oz-in"),
        ("крутящий момент", "Н·м"),
        ("Сила", "кН"),
        ("阻尼力", "千牛"),
        ("Ток", "мА"),
        ("Current", "Ampere"),
        ("Strom", "milliamperes"),
        ("Winkel", "Grad"),
    ],
)
def test_a_word_bears_the_unit_behind_it_out(mark: str, word: str, unit: str) -> None:
    assert split_behind_word(mark.format(word, unit)) == (word, unit)


@pytest.mark.parametrize(
    "label",
    [
        *("stiffness N/mm", "Torque N/mm", "Force N·m/s", "power N·m/s", "damping, N·s/m"),
        *("Current, A", "coil A", "Current: B", "I=0.5A", "Force=2 kN", "Torque 5 N·m", "Ток А"),
        *("Force raw", "Torque_ref/act", "velocity_t-0.010", "speed L/R", "Position x-y", "Angle deg/s"),
        *("Torque, MN-cycles", "viscosity, N·m", "Speed", "", ", N·m", "_", "Force-"),
    ],
)  # fmt: skip
def test_what_no_word_bears_out_is_no_unit(label: str) -> None:
    assert split_behind_word(label) == (label.strip(), None)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Torque Newton meters", "Newton meters"),  # the meters alone were read
        ("Speed_r.p.m.", "r.p.m."),  # was a position in m
        ("Torque ft.lbs", "ft.lbs"),  # was a force
        ("Speed degrees/s", "degrees/s"),  # was a time
        ("Torque_daNm", "daN*m"),  # was N m, a tenth
        ("Torque=dNm", "dN*m"),
        ("Torque=daNm", "daN*m"),
    ],
)
def test_of_two_ends_that_are_units_the_longer_is_the_unit(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.slow
@pytest.mark.parametrize("mark", MARKS)
@pytest.mark.parametrize(
    ("signal", "word", "unit", "factor"),
    [
        ("slip", "Speed", "1/min", np.pi / 30.0),
        ("slip", "Speed", "deg·s⁻¹", np.pi / 180.0),
        ("slip", "Drehzahl", "min-1", np.pi / 30.0),
        ("slip", "Обороты", "об/мин", np.pi / 30.0),
        ("effort", "Torque", "N*m", 1.0),
        ("effort", "Torque", "N.mm", 1e-3),
        ("effort", "Torque", "daNm", 10.0),
        ("effort", "Момент", "кгс·м", 9.80665),
        ("effort", "Torque", "lbf·ft", 1.3558179483),
        ("field", "Current", "мА", 1e-3),
        ("field", "Strom", "µA", 1e-6),
        ("time", "Zeit", "мс", 1e-3),
        ("time", "Время", "мин", 60.0),
    ],
)
def test_a_log_is_read_in_the_units_behind_its_words(
    signal: str, word: str, unit: str, factor: float, mark: str, tmp_path: Path
) -> None:
    labels = {"time": "t [s]", "slip": "w [rad/s]", "effort": "T [N*m]", "field": "I [A]"}
    columns = {"time": TIME, "slip": SPEED, "effort": TORQUE, "field": CURRENT}
    labels[signal] = mark.format(word, unit)
    written = np.column_stack(
        [columns[name] / (factor if name == signal else 1.0) for name in labels]
    )
    path = tmp_path / "log.csv"
    np.savetxt(path, written, "%.9g", ";", header=";".join(labels.values()), comments="", encoding="utf-8")  # fmt: skip
    recording = read(path)
    for name, values in recording.signals.items():
        np.testing.assert_allclose(values, columns[name], rtol=1e-6, atol=1e-7)
    assert recording.duration == pytest.approx(TIME[-1], rel=0.01)


def test_letters_behind_any_mark_are_units_where_all_names_end_in_units() -> None:
    units = {"Time": "s", "Velocity": "m/s", "Force": "N", "Current": "A"}
    for mark in (".", "=", " - "):
        labels = [f"{word}{mark}{unit}" for word, unit in units.items()]
        assert name_columns(labels)[1] == [*units.values()]


def test_a_label_of_many_marks_takes_linear_time() -> None:
    for part in ("Torque, ", "N·m ", "_/", "м", "-1 ", "speed:"):
        assert split_behind_word(part * 10_000)[1] is None


@pytest.mark.parametrize(
    "own_units",
    [
        ["мин", "min-1", "uNm", "Amp"],
        ["秒", "об/мин", "N-m", "A"],
        ["ms", "kph", "MN", "kA"],
        ["seconds", "rev/min", "oz-in", "amps"],
    ],
)
def test_a_row_of_units_that_the_names_above_bear_out_gives_no_names(
    own_units: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "log.csv"
    columns = np.column_stack([60.0 * TIME, SPEED, TORQUE, CURRENT])
    header = f"Time;Speed;Torque;Current\n{';'.join(own_units)}"
    if "MN" in own_units:
        header = header.replace("Torque", "Force")
    np.savetxt(path, columns, "%.9g", ";", header=header, comments="", encoding="utf-8")
    table = read_table(path)
    assert [*table.columns][:2] == ["Time", "Speed"]
    assert [*table.units.values()] == own_units


@pytest.mark.parametrize("name", ["Slip", "Schlupf", "Rotação"])
def test_a_speed_a_minute_counts_turns(name: str) -> None:
    for unit in ("1/min", "min-1", "min⁻¹"):
        assert own_unit(name, unit, ("rad/s",)) == "turn/min"
        assert own_unit(f"{name}: {unit}", unit, ("rad/s",)) == "turn/min"
    for rate in ("strain rate", "omega"):
        assert own_unit(rate, "1/min", ("1/s",)) == "1/min"


@pytest.mark.parametrize("unit", ["Umdrehungen", "обороты", "tours", "giri", "vueltas", "圈"])
def test_an_angle_in_turns_is_no_speed(unit: str, tmp_path: Path) -> None:
    """Their words are names of a speed as well: an angle was read as a slip, in silence."""
    turns = np.cumsum(SPEED) * (TIME[1] - TIME[0]) / (2.0 * np.pi)
    path = tmp_path / "log.csv"
    columns = np.column_stack([TIME, turns, TORQUE, CURRENT])
    header = f"Time [s];Angle ({unit});Torque [Nm];Current [A]"
    np.savetxt(path, columns, "%.9g", ";", header=header, comments="", encoding="utf-8")
    recording = read(path)
    np.testing.assert_allclose(recording.signals["position"], 2.0 * np.pi * turns, atol=1e-6)
