"""Numbers, switches, sentinels, units and clocks of files that strangers write: read right, or asked about."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.errors import ErclutchError, LogError, MappingError, TimingError
from erclutch.logs import read_table
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.log_writer import write_log
from erclutch.logs.readers.numerals import is_grouped, ungrouped, weigh
from erclutch.logs.rows.unmeasured_rows import sentinels
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from tests.support.slow_params import slow_behind, slow_but

Written = Callable[..., Path]
ROWS = 60
TIME = np.arange(ROWS) * 0.01
FIELD = np.resize([0.0, 500.0, 1000.0, 1500.0], ROWS)
SPEED = 900.0 + 5.0 * np.arange(ROWS)  # rpm, beyond a thousand from row 20 on
TORQUE = 0.1 * np.arange(ROWS)


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(text: str, name: str = "log.csv", encoding: str = "utf-8") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        return path

    return write


def table(between: str, form: Callable[[float, int], str], head: str = "") -> str:
    """The log above, each number written by ``form(number, decimals)``."""
    head = head or between.join(("time [s]", "field [V]", "speed [rpm]", "torque [N*m]"))
    lines = [head]
    for row in zip(TIME, FIELD, SPEED, TORQUE, strict=True):
        lines.append(
            between.join(
                form(value, digits) for value, digits in zip(row, (3, 0, 0, 3), strict=True)
            )
        )
    return "\n".join(lines) + "\n"


def grouped_by(thousands: str, decimal: str, quote: str = "") -> Callable[[float, int], str]:
    def form(value: float, digits: int) -> str:
        text = (
            f"{value:,.{digits}f}".replace(",", "_").replace(".", decimal).replace("_", thousands)
        )
        return f"{quote}{text}{quote}"

    return form


def is_the_log(recording: Recording) -> bool:
    rad_s = SPEED * 2 * np.pi / 60
    wanted = {"field": FIELD, "slip": rad_s, "effort": TORQUE}
    return all(
        np.allclose(recording.signals[name], values, rtol=1e-9) for name, values in wanted.items()
    )


# --- decimal marks and thousands --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("between", "thousands", "decimal", "quote"),
    [
        (";", ".", ",", ""),  # German
        (";", " ", ",", ""),  # French
        (";", "\u00a0", ",", ""),
        (";", "'", ".", ""),  # Swiss
        ("\t", ".", ",", ""),
        ("\t", ",", ".", ""),
        (";", ",", ".", ""),
        (",", ",", ".", '"'),  # a spreadsheet in the United States
        (",", ".", ",", '"'),
        (",", "", ".", ""),
        (";", "", ",", ""),
    ],
)
def test_numbers_are_read_by_what_the_whole_file_says(
    written: Written, between: str, thousands: str, decimal: str, quote: str
) -> None:
    recording = erclutch.read(written(table(between, grouped_by(thousands, decimal, quote))))
    assert is_the_log(recording)
    told = [note for note in recording.notes if "between their thousands" in note]
    assert len(told) == bool(thousands)


def test_plain_whole_numbers_tell_what_a_point_is(written: Written) -> None:
    """Without any decimals in the file, 500 beside 1.500 says that the point groups digits."""
    lines = [f"{i};{('500', '1.500')[i % 2]};{('900', '1.058')[i % 2]};{i}" for i in range(ROWS)]
    path = written("time [ms];field [V];speed [rpm];torque [N*m]\n" + "\n".join(lines) + "\n")
    recording = erclutch.read(path)
    assert set(recording.signals["field"]) == {500.0, 1500.0}


def test_six_significant_digits_are_no_thousands() -> None:
    """-177.778 beside -100 was read as -177778: both are what %g prints."""
    lines = [f"{50 * k},{-100 - 700 / 9 * k:.6g},{80 + 520 / 9 * k:.6g}" for k in range(10)]
    rows = "\n".join(lines)
    assert "," + "-177.778," in rows
    with_commas = weigh(rows, ",", ".")
    assert (with_commas.decimal, with_commas.thousands) == (".", "")
    with pytest.raises(LogError, match=r"-177\.778 may be -177\.778 or -177778"):
        weigh(rows.replace(",", "\t"), "\t", ".")


@pytest.mark.slow
def test_a_tie_is_asked_about_with_both_readings(written: Written) -> None:
    lines = [f"{1 + i}.000;{1 + i % 3}.500;1.{100 + i};2.{200 + i}" for i in range(40)]
    path = written("time [s];field [V];speed [rad/s];torque [N*m]\n" + "\n".join(lines) + "\n")
    with pytest.raises(
        LogError, match=r"1\.000 may be 1 or 1000.*--decimal \. for 1, --decimal , for 1000"
    ):
        erclutch.read(path)
    assert erclutch.read(path, {"decimal": "."}).signals["field"][0] == 1.5
    assert erclutch.read(path, {"decimal": ","}).signals["field"][0] == 1500.0
    with pytest.raises(MappingError, match="decimal is ';'"):
        erclutch.read(path, {"decimal": ";"})


def test_two_decimal_marks_in_one_file_are_refused() -> None:
    with pytest.raises(LogError, match=r"0\.5 has a decimal point and 0,25 a decimal comma"):
        weigh("1;0.5;0,25\n2;0.6;0,35\n", ";", ".")


@pytest.mark.parametrize(
    ("delimiter", "commas"), [(";", "ab"), ("\t", "c"), (";", "a"), (" ", "bc")]
)
def test_two_decimal_marks_are_read_where_each_column_keeps_to_one(
    written: Written, delimiter: str, commas: str
) -> None:
    courses = {
        "a": np.arange(ROWS) / 100,
        "b": 2.1 * np.sin(np.arange(ROWS)),
        "c": 0.25 * np.cos(np.arange(ROWS)),
    }
    cells = {name: [f"{value:.4f}" for value in values] for name, values in courses.items()}
    for name in commas:
        cells[name] = [cell.replace(".", ",") for cell in cells[name]]
    lines = [delimiter.join(row) for row in zip(*cells.values(), strict=True)]
    table = read_table(written(delimiter.join(courses) + "\n" + "\n".join(lines) + "\n"))
    for name, values in courses.items():
        np.testing.assert_allclose(table.columns[name], values, atol=6e-5)
    assert any(f"decimal comma in column {', '.join(commas)}," in note for note in table.notes)


@pytest.mark.parametrize(
    "rows",
    [
        ["{n};0,{m}1;0.{m}1;1", "{n};0,{m}1;0,{m}1;1"],  # the third column has both
        ["{n};1,50{m};0.{m}1;0,{m}5", "{n};2,50{m};0.{m}2;0,{m}5"],  # the second may have thousands
        ["{n};1.234,{m}5;1,234.{m}5;1", "{n};1.235;1,235.{m}5;1"],
    ],
)
def test_two_decimal_marks_in_one_column_or_beside_doubtful_numbers_are_refused(
    written: Written, rows: list[str]
) -> None:
    lines = [rows[n % 2].format(n=n, m=n % 10) for n in range(20)]
    path = written("t [s];a;b;c\n" + "\n".join(lines) + "\n")
    with pytest.raises(LogError, match="has a decimal point and"):
        read_table(path)


@pytest.mark.parametrize(
    ("cell", "decimal", "plain"),
    [
        ("1.234.567,5", ",", "1234567.5"),
        ("-1,234.5", ".", "-1234.5"),
        ("1 000", ",", "1000"),
        ("1'000.25", ".", "1000.25"),
        ("1.0D+03", ".", "1.0e+03"),
        ("2d-1", ".", "2e-1"),
        ("0,5", ",", "0.5"),
        ("12.05.2024", ",", "12.05.2024"),  # a date stays a date
        ("1,23", ".", "1,23"),
    ],
)
def test_one_number(cell: str, decimal: str, plain: str) -> None:
    assert ungrouped(cell, decimal) == plain


@pytest.mark.parametrize("cell", ["0.123", "1234.567", "1.23", "01.234", "1..234", "1.2345", ""])
def test_what_is_no_group(cell: str) -> None:
    assert not is_grouped(cell, ",")


@pytest.mark.slow
def test_fortran_writes_d(written: Written) -> None:
    form = lambda value, digits: f"{value:.10e}".replace("e", "D")  # noqa: E731
    assert is_the_log(erclutch.read(written(table(",", form))))


def test_r_names_no_column_of_row_names(written: Written) -> None:
    lines = table(",", grouped_by("", ".")).splitlines()
    rows = [f'"{number}",{line}' for number, line in enumerate(lines[1:], start=1)]
    assert is_the_log(erclutch.read(written("\n".join([lines[0], *rows]) + "\n")))


@pytest.mark.slow
def test_a_cell_of_thousands_of_digits_takes_linear_time(written: Written) -> None:
    path = written(
        f"time [s],field [A],slip [rad/s],torque [N*m]\n{'1' * 20_000},1,2,3\n" + "2,1,2,3\n" * 20
    )
    with pytest.raises(ErclutchError):
        erclutch.read(path)


# --- columns of text --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("off", "on"), [("OFF", "ON"), ("false", "True"), ("aus", "ein"), ("no", "yes")]
)
def test_switches_are_ones_and_zeros(written: Written, off: str, on: str) -> None:
    lines = [f"{0.01 * i:.2f},{(off, on)[i % 4 > 1]},{i},{0.1 * i:.1f}" for i in range(ROWS)]
    recording = erclutch.read(
        written("time [s],field,slip [rad/s],torque [N*m]\n" + "\n".join(lines) + "\n")
    )
    assert recording.signals["field"][:4].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert any("column field holds" in note and "read as 1" in note for note in recording.notes)


def with_a_word(column: int, rows: tuple[int, ...] = (30,), name: str = "") -> str:
    lines = table(",", grouped_by("", ".")).splitlines()
    for row in rows:
        cells = lines[1 + row].split(",")
        cells[column] = "fault"
        lines[1 + row] = ",".join(cells)
    lines = [f"{line},{i}" for i, line in enumerate(lines)]
    lines[0] = lines[0].rpartition(",")[0] + f",{name or 'remark'}"
    return "\n".join(lines) + "\n"


def test_a_word_in_a_column_that_nobody_asked_for_stops_nothing(written: Written) -> None:
    text = with_a_word(0, ()).splitlines()
    text[20] = text[20].rpartition(",")[0] + ",fault"
    recording = erclutch.read(written("\n".join(text) + "\n"))
    assert is_the_log(recording)
    assert any(
        "column remark is left out: line 21, column remark is 'fault'" in note
        for note in recording.notes
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "meant"), [(0, "time"), (1, "field"), (2, "slip"), (3, "effort")]
)
@pytest.mark.parametrize("rows", [(30,), tuple(range(ROWS))])
def test_a_column_that_is_needed_stops_the_reading(
    written: Written, column: int, meant: str, rows: tuple[int, ...]
) -> None:
    # A single word is asked about, as its row may be dropped; a column of words cannot be read at all.
    alone = "is 'fault' where a number is expected. Leave such rows out: --invalid drop"
    told = alone if len(rows) == 1 else f"and it is called like the {meant}"
    with pytest.raises((LogError, MappingError), match=told):
        erclutch.read(written(with_a_word(column, rows)))


@pytest.mark.slow
def test_a_column_that_is_named_stops_the_reading(written: Written) -> None:
    path = written(with_a_word(1))
    with pytest.raises(
        MappingError, match="line 32, column field is 'fault' where a number is expected"
    ):
        erclutch.read(path, {"field": "field [V]"})
    assert erclutch.read(path, {"field": "none"}).rows == ROWS


# --- names and units --------------------------------------------------------------------------------------------------


def test_a_row_of_oddly_written_units(written: Written) -> None:
    lines = [
        f"{0.01 * i:.2f}, {0.2 * (i % 3):.1f}, {2 * i}, {i % 7}, {1000 * i}" for i in range(ROWS)
    ]
    text = (
        "Time, Coil current, Power, Speed, Torque\ns, A, W, rad.s, N.mm\n" + "\n".join(lines) + "\n"
    )
    recording = erclutch.read(written(text))
    assert recording.signals["slip"][:8].tolist() == [0, 1, 2, 3, 4, 5, 6, 0]
    assert recording.signals["effort"][3] == pytest.approx(3.0)
    assert recording.units["slip"] == "rad/s"


def test_power_is_no_slip(written: Written) -> None:
    lines = [f"{0.01 * i:.2f},{0.2 * (i % 3):.1f},{i},{0.1 * i:.1f}" for i in range(ROWS)]
    path = written("t,A,W,Nm\n" + "\n".join(lines) + "\n")
    with pytest.raises(MappingError, match="no column for slip or position"):
        erclutch.read(path)


@pytest.mark.parametrize(
    ("unit", "newton_metres"),
    [
        ("oz-in", 0.00706155),
        ("kgf-cm", 0.0980665),
        ("Kg-cm", 0.0980665),
        ("Kgf.cm", 0.0980665),
        ("gf-cm", 0.0000980665),
        ("dyn-cm", 1e-7),
        ("ozf·in", 0.00706155),
        ("in-oz", 0.00706155),
        ("in-lb", 0.1129848),
        ("lbf*in", 0.1129848),
        ("ft-lb", 1.3558179),
        ("lb ft", 1.3558179),
        ("N.mm", 1e-3),
        ("FT-LB", 1.3558179),
        ("IN-LBS", 0.1129848),
    ],
)
def test_units_of_torque(unit: str, newton_metres: float) -> None:
    found = units.fits(unit, ("N*m",))
    assert found is not None
    assert found[0] == pytest.approx(newton_metres, rel=1e-5)


@pytest.mark.parametrize(
    ("unit", "si", "factor"),
    [
        ("LB", "N", 4.4482216),
        ("Lbs", "N", 4.4482216),
        ("LBF", "N", 4.4482216),
        ("KN", "N", 1000.0),
        ("MM", "m", 1e-3),
        ("IN/SEC", "m/s", 0.0254),
        ("MM/S", "m/s", 1e-3),
        ("DEG/S", "rad/s", np.pi / 180),
        ("SEC", "s", 1.0),
    ],
)
def test_units_of_machines_that_write_in_capitals(unit: str, si: str, factor: float) -> None:
    found = units.fits(unit, (si,))
    assert found is not None
    assert found[0] == pytest.approx(factor, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("ShearRate_1_s", "1/s"),
        ("rate_per_s", "1/s"),
        ("Viscosity_Pa_s", "Pa*s"),
        ("acc_m_s2", "m/s^2"),
        ("force_lbf", "lbf"),
        ("torque_ft_lb", "ft*lbf"),
        ("time_s", "s"),
        ("act_vel_deg_per_s_1", "deg/s"),
        ("torque_Nm_2", "N*m"),
        ("torque_N_m", "N*m"),
    ],
)
def test_the_longest_unit_that_ends_a_name_is_its_unit(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.parametrize("name", ["torque_1", "q_12", "i_d_1", "F_N_1", "joint_1_vel"])
def test_a_joint_s_number_alone_brings_no_unit(name: str) -> None:
    assert split_end(name) == (name, None)


def test_a_shear_rate_per_second_is_no_time(written: Written) -> None:
    lines = [f"{0.1 * i:.2f},{10 + i},{100 / (1 + i):.3f}" for i in range(ROWS)]
    path = written("ShearRate_1_s,Stress_Pa,Viscosity_Pa_s\n" + "\n".join(lines) + "\n")
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        erclutch.read(path, field="none")


# --- sentinels --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", [-999.0, -9999.0, 9999.0, 65535.0, 1e30])
@pytest.mark.parametrize("column", [1, 2, 3])
@pytest.mark.parametrize("rows", slow_but([(30,)], [(30,), (12, 13, 14, 40)]))
def test_codes_for_no_measurement_are_left_out_and_told(
    written: Written, code: float, column: int, rows: tuple[int, ...]
) -> None:
    values = np.column_stack((TIME, 0.5 * (FIELD > 0), np.sin(9 * TIME), np.cos(9 * TIME)))
    values[list(rows), column] = code
    head = "time [s],field [A],slip [rad/s],torque [N*m]\n"
    path = written(head + "\n".join(",".join(f"{v:.6g}" for v in row) for row in values) + "\n")
    recording = erclutch.read(path)
    assert recording.rows == ROWS - len(rows)
    assert max(float(np.abs(signal).max()) for signal in recording.signals.values()) <= 1.0
    name = head.strip().split(",")[column].partition(" ")[0]
    assert any(
        f"column {name} holds {code:g} in {len(rows)} row" in note for note in recording.notes
    )
    if abs(code) < 1e30:
        kept = erclutch.read(path, {"values": "keep"})
        assert kept.rows == ROWS
        assert any(note.endswith("kept, as asked") for note in kept.notes)


def test_measurements_are_no_sentinels() -> None:
    ramp = np.linspace(-1200.0, 1200.0, 500)
    assert sentinels(np.round(ramp)) == {}  # -999 in the middle of what is measured
    saturated = np.clip(70_000.0 * np.sin(np.arange(500) / 9), -65535.0, 65535.0)
    assert sentinels(saturated) == {}  # the end of what a converter can say
    assert sentinels(np.where(np.arange(500) == 77, 412.3, np.sin(np.arange(500)))) == {}  # a spike
    assert (
        list(sentinels(np.where(np.arange(500) < 400, -999.0, np.sin(np.arange(500))))) == []
    )  # most of the log
    torque = 300.0 * np.sin(np.arange(500) / 50)
    torque[70] = -999.0
    assert list(sentinels(torque)) == [-999.0]


# --- clocks -----------------------------------------------------------------------------------------------------------


def stamped(stamps: Array, rows: Array | None = None) -> Recording:
    kept = np.arange(stamps.size) if rows is None else rows
    signals = {
        "slip": np.sin(kept / 50.0),
        "field": np.zeros(kept.size),
        "effort": np.cos(kept / 50.0),
    }
    return erclutch.recording_from_arrays(signals, {"slip": "rad/s", "effort": "N*m"}, time=stamps)


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.05, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("seed", slow_behind(1, range(3)))
def test_late_stamps_of_a_busy_logger_cut_nothing(spread: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    steady = np.arange(4000) * 1e-3
    for stamps in (
        np.sort(steady + 1e-3 * spread * rng.standard_normal(steady.size)),
        np.maximum.accumulate(steady + 1e-3 * spread * rng.exponential(size=steady.size)),
    ):
        recording = stamped(np.round(stamps, 9))
        assert recording.segments == ((0, 4000),)
        assert recording.uniform
        assert recording.period == pytest.approx(1e-3, rel=1e-4)
        assert any("put on the regular grid" in note for note in recording.notes)


@pytest.mark.parametrize("spread", [0.0, 0.1, 0.2])
def test_rows_that_are_lost_still_cut(spread: float) -> None:
    rng = np.random.default_rng(0)
    steady = np.delete(np.arange(4000), [1000, 2500, 2501]) * 1e-3
    stamps = np.sort(steady + 1e-3 * spread * rng.standard_normal(steady.size))
    recording = stamped(stamps)
    assert len(recording.segments) == 3
    assert [start for start, _ in recording.segments] == pytest.approx([0, 1000, 2499], abs=1)


def test_one_unequal_last_step_is_no_other_clock() -> None:
    stamps = np.array([1e-3 * row for row in range(500)])
    stamps[-1] += 4e-4
    recording = stamped(stamps)
    assert recording.uniform
    assert len(recording.segments) == 1


@pytest.mark.slow
def test_rows_at_any_time_keep_their_stamps() -> None:
    stamps = np.cumsum(np.random.default_rng(0).exponential(1e-3, 2000))
    recording = stamped(np.round(stamps, 9))
    assert not recording.uniform


def test_seconds_since_1970_survive_a_writer(tmp_path: Path) -> None:
    stamps = np.array([1.79e9 + 1e-3 * row for row in range(100)])
    rows: Array = np.column_stack((stamps, np.ones(100)))
    path = write_log(tmp_path / "log.csv", (("time", "s"), ("slip", "rad/s")), [rows], {}, rows=100)
    assert np.allclose(erclutch.read_table(path).columns["time"], stamps, rtol=0, atol=1e-6)


def test_times_that_no_clock_counts_are_one_line(written: Written) -> None:
    lines = [f"{i}e300,1,{i % 5},{i % 3}" for i in range(ROWS)]
    with pytest.raises(TimingError, match=r"column time goes up to 5\.9e\+301 s"):
        erclutch.read(
            written("time [s],field [A],slip [rad/s],torque [N*m]\n" + "\n".join(lines) + "\n")
        )


@pytest.mark.parametrize(
    ("digits", "point", "thousands"),
    [
        ("٠١٢٣٤٥٦٧٨٩", "٫", "٬"),
        ("۰۱۲۳۴۵۶۷۸۹", "٫", ""),
        ("０１２３４５６７８９", "．", ""),
        ("०१२३४५६७८९", ".", ""),
    ],
)
def test_digits_of_other_scripts_are_numbers(
    written: Written, digits: str, point: str, thousands: str
) -> None:
    signs = str.maketrans("0123456789._", f"{digits}{point}_")

    def form(value: float, places: int) -> str:
        grouped = f"{value:,.{places}f}" if thousands else f"{value:.{places}f}"
        return grouped.replace(",", "_").translate(signs).replace("_", thousands)

    assert is_the_log(erclutch.read(written(table(";", form))))


def test_a_column_of_decimal_commas_may_have_points_between_its_thousands(written: Written) -> None:
    lines = ["time [s];field [V];speed [rpm];torque [N*m]"]
    for time, field, speed, torque in zip(TIME, FIELD, SPEED, TORQUE, strict=True):
        german = f"{speed:,.1f}".replace(",", "_").replace(".", ",").replace("_", ".")
        lines.append(f"{time:.2f};{field:,.2f};{german};{torque:.3f}")
    assert is_the_log(erclutch.read(written("\n".join(lines) + "\n")))


@pytest.mark.parametrize(
    ("name", "option"),
    [
        ("torque x 10^3 (N*m)", "torque x 10^3 [0.001 N*m]"),
        ("torque ×10⁻³ [N*m]", "torque ×10⁻³ [1000 N*m]"),
        ("10^2 torque [N*m]", "10^2 torque [0.01 N*m]"),
    ],
)
def test_a_power_of_ten_beside_the_name_of_a_signal_is_asked_about(
    written: Written, name: str, option: str
) -> None:
    path = written(
        table(";", lambda value, digits: f"{value:.{digits}f}").replace("torque [N*m]", name)
    )
    with pytest.raises(MappingError, match="may be times it, or over it") as asked:
        erclutch.read(path)
    assert option in asked.value.remedy
    scale = float(option.partition("[")[2].split()[0])
    assert np.allclose(erclutch.read(path, effort=option).signals["effort"], scale * TORQUE)


@pytest.mark.parametrize("name", ["torque (×10⁻³ N*m)", "torque [10^-3 N*m]"])
def test_a_power_of_ten_within_the_unit_of_a_signal_is_of_the_unit(
    written: Written, name: str
) -> None:
    path = written(
        table(";", lambda value, digits: f"{value:.{digits}f}").replace("torque [N*m]", name)
    )
    assert np.allclose(erclutch.read(path).signals["effort"], 1e-3 * TORQUE)
