"""Names and units out of headers, by example."""

from __future__ import annotations

import time

import pytest

from erclutch.logs.columns.labels import name_columns, own_unit, split_label, units_behind_names
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.readers.header_pairs import header_pairs, sample_period
from tests.support.pace import within
from tests.support.slow_params import slow_behind


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        (" V [cm/s] ", "V", "cm/s"),
        ("u[0]", "u[0]", None),
        ("u[ ]", "u[ ]", None),
        ("F [odd]", "F", "odd"),
        ("Force (N)", "Force", "N"),
        ("Force (left)", "Force (left)", None),
        ("time / s", "time", "s"),
        ("Weg in mm", "Weg", "mm"),
        ("a/b", "a/b", None),
        ("N_m", "N_m", None),
        ("[V]", "[V]", None),
        ("速度/(mm/s)", "速度", "mm/s"),
        ("Torque (NM)", "Torque", "N*m"),
        ("Motor torque [KNM]", "Motor torque", "kN*m"),
        ("T (NM)", "T", "N*m"),
        ("力矩（NM）", "力矩", "N*m"),
        ("Distance (NM)", "Distance (NM)", None),  # nautical miles
        ("Gap [NM]", "Gap", "NM"),
        ("Momentum (NM)", "Momentum (NM)", None),
        ("TM (NM)", "TM (NM)", None),
    ],
)
def test_labels(label: str, name: str, unit: str | None) -> None:
    assert split_label(label) == (name, unit)


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("torque_Nm", "torque", "N*m"),
        ("torque_N_m", "torque", "N*m"),
        ("Brake_Torque_NM", "Brake_Torque", "N*m"),
        ("range_NM", "range_NM", None),
        ("omega_rad_s", "omega", "rad/s"),
        ("rpm", "rpm", "rpm"),
        ("motor_rpm", "motor", "rpm"),
        ("RPM", "RPM", "rpm"),
        ("t_s", "t", "s"),
        ("i_d", "i_d", None),
        ("F_N", "F_N", None),
        ("w_rps", "w_rps", None),
        ("w_rad_s", "w", "rad/s"),
        ("coil_ma", "coil_ma", None),
        ("coil_mA", "coil", "mA"),
        ("force_n", "force", "N"),
        ("force_kN", "force", "kN"),
        ("speed", "speed", None),
        ("temp_C", "temp", "°C"),
        ("speed rpm", "speed", "rpm"),
        ("Drehzahl U/min", "Drehzahl", "rpm"),
        ("torque N m", "torque", "N*m"),
        ("Time s", "Time", "s"),
        ("coil A", "coil A", None),
        ("temp_c", "temp_c", None),
        ("T_degC", "T", "°C"),
    ],
)
def test_ends_of_names(label: str, name: str, unit: str | None) -> None:
    assert split_end(label) == (name, unit)


@pytest.mark.parametrize(
    ("name", "unit", "si", "own"),
    [
        (
            "n",
            "1/min",
            ("rad/s",),
            "turn/min",
        ),  # its symbol in ISO 80000-3: no machine turns radians a minute
        ("n_mot", "min^-1", ("rad/s",), "turn/min"),
        ("motor speed", "1/min", ("rad/s",), "turn/min"),
        ("shear rate", "1/min", ("1/s",), "1/min"),
        ("Drehzahl", "1/min", ("rad/s",), "turn/min"),
        ("motor rpm", "min^-1", ("rad/s",), "turn/min"),
        # By DIN and ISO 80000-3 a Drehzahl in 1/s counts turns; an angular velocity in 1/s does not.
        ("Drehzahl", "1/s", ("rad/s",), "turn/s"),
        ("Winkelgeschwindigkeit", "1/s", ("rad/s",), "1/s"),
        ("force_N", None, ("N",), "N"),
        ("force_N", None, ("rad/s",), None),
        ("temp_C", None, ("K",), "°C"),
        ("x", None, ("N",), None),
    ],
)
def test_the_unit_of_a_column(
    name: str, unit: str | None, si: tuple[str, ...], own: str | None
) -> None:
    assert own_unit(name, unit, si) == own


def test_names_differ_and_say_so() -> None:
    names, units, notes = name_columns(["a [V]", "a [A]", "b", "b", "b", "", "c3", "d (N)"])
    assert names == ["a [V]", "a [A]", "b", "b (2)", "b (3)", "c6", "c3", "d"]
    assert units == ["V", "A", None, None, None, None, None, "N"]
    assert notes == [
        "column 4 has the name 'b' of an earlier one: renamed 'b (2)'",
        "column 5 has the name 'b' of an earlier one: renamed 'b (3)'",
    ]
    names, units, notes = name_columns(["a [V]", "b", "c [A]"], ["mV", "N", "A"])
    assert (names, units) == (["a", "b", "c"], ["V", "N", "A"])
    assert notes == ["column 'a' has two units: V in its name is taken, mV is not"]


@pytest.mark.parametrize(
    ("labels", "behind"),
    [
        ("t x_m F_N u_V", {"x_m": "m", "F_N": "N", "u_V": "V"}),
        ("t_s x_mm i_A", {"t_s": "s", "x_mm": "mm", "i_A": "A"}),
        ("t M_Nm n_rpm", {"M_Nm": "N*m", "n_rpm": "rpm"}),
        ("t F_N v", {}),  # a single one may have an index
        (
            "t_s x_mm F_N F_R",
            {"t_s": "s", "x_mm": "mm"},
        ),  # a force that presses beside a force that rubs
        ("t_s x_mm F_N mu", {"t_s": "s", "x_mm": "mm"}),
        ("u_d i_d u_q i_q", {}),
        ("t U_kV omega_in omega_out M", {"U_kV": "kV"}),  # an index is one letter
        ("t x_rad y", {}),  # radial
        ("t/s x/mm F/N", {"t/s": "s", "x/mm": "mm", "F/N": "N"}),
        ("Time/s Speed/(mm/s) Force/kN", {"Time/s": "s", "Speed/(mm/s)": "mm/s", "Force/kN": "kN"}),
        ("力/kN n", {"力/kN": "kN"}),  # a Chinese or Japanese name ends where its letters do
        ("SR_1/s SS_dyne/cm2", {"SR_1/s": "1/s", "SS_dyne/cm2": "dyne/cm2"}),  # not s and cm2
        ("t/s omega_rad/s v_m/s", {"t/s": "s", "omega_rad/s": "rad/s", "v_m/s": "m/s"}),
        ("t/s x_mm/s", {"t/s": "s", "x_mm/s": "mm/s"}),
        ("t/s M_A/Nm n_A/rpm", {"t/s": "s", "M_A/Nm": "Nm", "n_A/rpm": "rpm"}),  # the A is an index
        ("t/s F_N/kN", {"t/s": "s", "F_N/kN": "kN"}),
        (
            "t_s M_Nm T_C",
            {"t_s": "s", "M_Nm": "N*m"},
        ),  # a T in degrees is no torque; it ended in an error
        ("Force/N n", {}),
        ("motor/A motor/B", {}),
        ("time rad/s N/m", {}),
        ("arm/position arm/velocity", {}),
    ],
)
def test_units_behind_names_are_read_where_a_file_has_several(
    labels: str, behind: dict[str, str]
) -> None:
    assert units_behind_names(labels.split()) == behind


def test_pairs_of_a_header() -> None:
    lines = ['# Sample rate: "100 Hz"', "Operator = Me ,;", "no pair", "Operator: You", "Date;2026"]
    assert header_pairs(lines) == {"Sample rate": "100 Hz", "Operator": "Me", "Date": "2026"}
    assert len(header_pairs(f"key{k}: 1" for k in range(300))) == 200


@pytest.mark.parametrize(
    ("pairs", "period"),
    [
        ({"Sample rate": "100 Hz"}, (0.01, "Sample rate")),
        ({"fs": "2 kHz"}, (5e-4, "fs")),
        ({"Sampling frequency [kHz]": "2"}, (5e-4, "Sampling frequency [kHz]")),
        ({"rate": "50"}, (0.02, "rate")),
        ({"dt": "2"}, None),  # 2 s or 2 ms: nobody says
        ({"dt": "2 s"}, (2.0, "dt")),
        ({"dt": "0.2"}, (0.2, "dt")),
        ({"rate": "50", "Sample interval (ms)": "4"}, (4e-3, "Sample interval (ms)")),
        ({"Delta_X": "0.1 ms"}, (1e-4, "Delta_X")),
        ({"dt": "0"}, None),
        ({"dt": "-1"}, None),
        ({"dt": "2 V"}, None),
        ({"rate": "fast", "fs": "10"}, (0.1, "fs")),
        ({"Operator": "3"}, None),
    ],
)
def test_the_period_in_a_header(pairs: dict[str, str], period: tuple[float, str] | None) -> None:
    found = sample_period(pairs)
    assert (found is None) == (period is None)
    if found and period:
        assert found[0] == pytest.approx(period[0])
        assert found[1] == period[1]


def test_the_end_of_a_quotient_in_words_is_no_unit() -> None:
    for name in ("T_per_rpm_Nm_per_rpm", "stiffness_N_per_mm", "gain_Nm_per_A"):
        assert split_end(name) == (name, None)
    assert split_end("omega_rad_per_s") == ("omega", "rad/s")


@pytest.mark.parametrize(
    ("line", "pair"),
    [
        ('"Gage length, standard travel",20,"mm"', {"Gage length, standard travel": "20 mm"}),
        ('"v1";1,5;"mm/min"', {"v1": "1.5 mm/min"}),
        ("Coil current,0.5,A", {"Coil current": "0.5 A"}),
        ("Temp\t25\t°C,,", {"Temp": "25 °C"}),
        ("Sampling interval;1e-3;s", {"Sampling interval": "1e-3 s"}),
        ("Strom;1,500;A", {"Strom": "1,500;A"}),  # a thousands mark, or a decimal one
        ('"Start: 12:00",5', {"Start: 12:00": "5"}),
        ('"Extensometer",""', {"Extensometer": ""}),
        ('"time","force"', {"time": "force"}),
        ("Range,1,2", {"Range": "1,2"}),
    ],
)
def test_a_header_in_cells_states_a_number_with_its_unit(line: str, pair: dict[str, str]) -> None:
    assert header_pairs([line]) == pair


@pytest.mark.slow
@pytest.mark.parametrize("sign", slow_behind(3, ['"', "1", ".", ",", '",', "1,", "\t", "a", " "]))
def test_a_long_line_of_a_header_takes_no_long_time(sign: str) -> None:
    begun = time.process_time()
    for start in ("", '"', "key,", '"key",'):
        header_pairs([start + sign * 200_000])
    assert within(time.process_time() - begun, 2.0)


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        (["Time", "Disp. mm", "Force N", "Curr. A"], [None, None, "N", "A"]),
        (["t s", "x mm", "F N"], ["s", None, "N"]),
        (["time", "coil A", "coil B"], [None, None, None]),
        (["time", "coil A", "force"], [None, None, None]),
        (["coil A", "coil V"], [None, None]),
        (["Time/s", "T/Nm", "B/mT"], ["s", "Nm", "mT"]),
        (["t/s", "E/(kV/mm)", "F/N"], ["s", "kV/mm", "N"]),
    ],
)
def test_a_letter_is_a_unit_where_all_names_end_in_units(
    labels: list[str], expected: list[str | None]
) -> None:
    _, units, _ = name_columns(labels)
    assert units == expected


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("speed_krpm", "speed", "krpm"),
        ("n_r_min", "n", "rpm"),
        ("speed_rev_s", "speed", "turn/s"),
        ("E_kV_mm", "E", "kV/mm"),
        ("torque_kgcm", "torque", "kgf*cm"),
        ("torque_Ncm", "torque", "N*cm"),
        ("B_gauss", "B", "gauss"),
    ],
)
def test_further_units_end_a_name(name: str, stem: str, unit: str) -> None:
    assert split_end(name) == (stem, unit)


def test_what_may_be_a_time_or_a_stiffness_ends_in_no_speed_and_no_torque() -> None:
    assert split_end("time_in_s")[1] == "s"
    assert split_end("stiffness_kN_m")[1] == "m"


def test_a_number_in_the_middle_of_a_remark_is_read() -> None:
    pairs = header_pairs(["# MR damper test, dt = 0.002 s, x in m, F in N", "run 4; fs=1000 Hz"])
    assert pairs["dt"] == "0.002 s"
    assert pairs["fs"] == "1000 Hz"
    assert sample_period(pairs) == (0.002, "dt")


@pytest.mark.parametrize(
    ("label", "unit"),
    [
        ("current_ma", "mA"),
        ("CURRENT MA", "mA"),
        ("b_mt", "mT"),
        ("i_ma", "mA"),
        ("voltage_mv", "mV"),
        ("Load kips", "kip"),
        ("sign in", None),
        ("coil_ma", None),
        ("temp_ma", None),
    ],
)
def test_ends_in_letters_of_another_size_by_the_quantity(label: str, unit: str | None) -> None:
    # The command that was printed left the unit open, though the name tells it.
    assert split_end(label)[1] == unit


@pytest.mark.parametrize(
    ("label", "unit"),
    [
        ("current (ma)", "mA"),  # taken for a time: the log had no field
        ("CURRENT (MA)", "mA"),  # taken for megaamperes
        ("Force (kn)", "kN"),
        ("speed (kn)", "kn"),
        ("torque [nm]", "N*m"),
        ("current [a]", "A"),
        ("current (a)", None),
        ("age [a]", "a"),
    ],
)
def test_units_in_letters_of_another_size_by_the_quantity(label: str, unit: str | None) -> None:
    assert split_label(label)[1] == unit


def test_a_line_of_units_in_small_letters() -> None:
    names = ["time", "Current", "Load", "speed"]
    assert name_columns(names, ["s", "ma", "kn", "m/s"])[1] == ["s", "mA", "kN", "m/s"]
