from __future__ import annotations

from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from erclutch.errors import LogError, MappingError, SettingError, UnitError
from erclutch.logs import ColumnChoice, ColumnMap, read, recording_from_arrays
from erclutch.logs.columns.name_pattern import constants_of, proposed
from erclutch.signals.recording import NO_FIELD

Rows = dict[str, np.ndarray]
LABELS = {"field": "Y [V]", "slip": "V [cm/s]", "effort": "F [N]"}


@pytest.fixture
def log(tmp_path: Path) -> Callable[..., Path]:
    def write(columns: Rows, header: str | None = None, name: str = "log.csv") -> Path:
        lines = [
            ",".join(repr(float(cell)) for cell in row)
            for row in zip(*columns.values(), strict=True)
        ]
        path = tmp_path / name
        path.write_text("\n".join([header or ",".join(columns), *lines, ""]), encoding="utf-8")
        return path

    return write


def test_labels_choose_convert_and_say_so(log: Callable[..., Path], rows: Rows) -> None:
    recording = read(log(rows), LABELS)
    np.testing.assert_allclose(recording.signals["slip"], rows["V"] * 0.01, rtol=1e-15)
    assert recording.units == {"field": "V", "slip": "m/s", "effort": "N"}
    assert not recording.signals["slip"].flags.writeable
    assert recording.segments == ((0, 200),)
    assert recording.notes == (
        "field <- column Y [V] (given)",
        "slip <- column V [cm/s], converted to m/s (given)",
        "effort <- column F [N] (given)",
        "time <- column t, no unit: taken as s (guessed from its name or unit)",
    )


def test_units_and_names_are_guessed_where_they_allow(log: Callable[..., Path], rows: Rows) -> None:
    rows["Y"] = np.arange(200) // 50 % 2
    recording = read(log(rows, "time [ms],Y [V],V [cm/s],F [kN]"))
    assert recording.units == {"field": "V", "slip": "m/s", "effort": "N"}
    assert recording.period == pytest.approx(1e-6)
    assert "effort <- column F [kN], converted to N (guessed from its name)" in recording.notes
    assert "slip <- column V [cm/s], converted to m/s (guessed from its name)" in recording.notes
    recording = read(log(rows, "t,current,speed,force"))
    assert recording.units == {"field": "?", "slip": "?", "effort": "?"}
    assert (
        "effort <- column force, no unit: taken as logged (guessed from its name)"
        in recording.notes
    )


def test_v_alone_is_not_guessed(log: Callable[..., Path], rows: Rows) -> None:
    with pytest.raises(MappingError) as caught:
        read(log(rows), {"field": "Y [V]", "effort": "F [N]"})
    assert str(caught.value) == (
        "log.csv: no column for slip or position; V may be it, but its name alone can mean several things "
        '(voltage or velocity); the file has: t, Y, V, F. Give it with its unit, such as --slip "V [cm/s]".'
    )


@pytest.mark.parametrize(
    "header", ["t,V [cm/s],F [N]", "t,slip,force", "time [s],speed [rad/s],torque [N*m]"]
)
def test_no_field_is_logged(log: Callable[..., Path], rows: Rows, header: str) -> None:
    del rows["Y"]
    recording = read(log(rows, header))
    assert set(recording.signals["field"]) == {0.0}
    assert recording.units["field"] == "?"
    assert f"{NO_FIELD}: taken as one constant field, written as 0" in recording.notes


@pytest.mark.slow
def test_a_further_column_that_may_be_the_field_is_asked_about(
    log: Callable[..., Path], rows: Rows
) -> None:
    for header in ("t,Q,V [cm/s],F [N]", "t,Q [V],V [cm/s],F [N]"):
        path = log(rows, header)
        if "[V]" not in header:
            with pytest.raises(MappingError) as caught:
                read(path)
            assert "no column for field; the file has: t, Q" in str(caught.value)
            assert "or --field none if not logged" in str(caught.value)
        assert NO_FIELD in str(read(path, {"field": "none"}).notes)
    # A column of another unit, or one that was named as an input, is no field.
    assert NO_FIELD in str(read(log(rows, "t,A [m/s^2],V [cm/s],F [N]")).notes)
    named = ColumnMap.from_dict({"inputs": ["Q"]})
    assert NO_FIELD in str(read(log(rows, "t,Q,V [cm/s],F [N]"), named).notes)


def test_a_column_called_none_is_a_column(log: Callable[..., Path], rows: Rows) -> None:
    recording = read(log(rows, "t,none,V [cm/s],F [N]"), {"field": "none"})
    np.testing.assert_array_equal(recording.signals["field"], rows["Y"])


def test_two_candidates_are_not_guessed(log: Callable[..., Path], rows: Rows) -> None:
    with pytest.raises(MappingError) as caught:
        read(log(rows, "t,voltage,current,F [N]"), {"slip": "t"})
    message = str(caught.value)
    assert (
        "field may be any of the columns voltage, current; the file has: t, voltage, current, F [N]"
        in message
    )
    assert '--field "voltage"' in message


@pytest.mark.slow
def test_columns_of_a_coaxial_pair_point_to_its_device(
    log: Callable[..., Path], rows: Rows
) -> None:
    with pytest.raises(MappingError) as caught:
        read(log(rows, "t,E1,E2,force [N]"))
    assert "no column for field" in str(caught.value)
    assert str(caught.value).endswith(
        "; if E1 and E2 are the fields of a coaxial pair, --device coaxial."
    )
    with pytest.raises(MappingError) as caught:
        read(log(rows, "t,E1,speed,force [N]"))
    assert "coaxial" not in str(caught.value)


def test_a_missing_column_names_a_close_one(log: Callable[..., Path], rows: Rows) -> None:
    with pytest.raises(MappingError) as caught:
        read(log(rows, "t,Field,Speed,Force"), {"effort": "force_N"})
    assert str(caught.value) == (
        "log.csv: there is no column 'force_N' for effort; the file has: t, Field, Speed, Force. "
        'Did you mean Force? Give it as --effort "Force".'
    )


def test_a_unit_that_does_not_fit(log: Callable[..., Path], rows: Rows) -> None:
    with pytest.raises(UnitError) as caught:
        read(log(rows), {**LABELS, "slip": "V [kN]"})
    assert str(caught.value) == (
        "log.csv: column 'V' has the unit 'kN', which does not fit slip (allowed: rad/s, m/s, 1/s, rpm, cm/s, ...). "
        'Choose another column or give its unit, such as --slip "V [rpm]" or "V [cm/s]".'
    )


def test_an_exact_name_with_brackets_wins(log: Callable[..., Path], rows: Rows) -> None:
    path = log(rows, "t,u[0],V [cm/s],V [V]")
    recording = read(path, {"field": "V [V]", "slip": "V [cm/s]", "effort": "u[0]"})
    assert np.array_equal(recording.signals["field"], rows["F"])
    assert np.array_equal(recording.signals["effort"], rows["Y"])


def test_numbers_signs_and_scales(log: Callable[..., Path], rows: Rows) -> None:
    columns = {"field": 2, "slip": "3 [m/s]", "effort": ColumnChoice("F", "N", -2.0)}
    recording = read(log(rows), {"columns": columns})
    assert np.array_equal(recording.signals["effort"], -2 * rows["F"])
    assert "effort <- column F [N], times 2, sign turned (given)" in recording.notes
    assert np.array_equal(
        read(log(rows), {**LABELS, "effort": "-F [N]"}).signals["effort"], -rows["F"]
    )


def test_the_command_line_beats_the_file_and_the_file_beats_guesses(
    log: Callable[..., Path], rows: Rows
) -> None:
    path = log(rows, "t,current,speed,force")
    path.with_suffix(".toml").write_text(
        'rate = 500\n[columns]\nslip = "speed [mm/s]"\neffort = {column = "force", unit = "kN", scale = -1}\n'
        "[constants]\ntemperature = 25\n",
        encoding="utf-8",
    )
    recording = read(path, {"slip": "speed [cm/s]"})
    np.testing.assert_allclose(recording.signals["slip"], rows["V"] * 0.01, rtol=1e-15)
    np.testing.assert_allclose(recording.signals["effort"], rows["F"] * -1000)
    assert recording.units["field"] == "?"
    assert recording.period == 2e-3
    assert recording.constants["temperature"] == 25
    assert "effort <- column force [kN], converted to N, sign turned (log.toml)" in recording.notes


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "slop = 1",
            "there is no key 'slop' (allowed: time, rate, lead, name_pattern, variable, invalid, decimal, values, ",
        ),
        ("[columns]\nspeed = 'V'", "there is no signal 'speed' (allowed: field, slip"),
        (
            "[columns]\nslip = {col = 'V'}",
            "there is no key of slip 'col' (allowed: column, unit, scale)",
        ),
        ("[columns]\nslip = 1.5", "the column for slip is 1.5"),
        ("rate = -1", "rate is -1"),
        ("lead = '10 kg'", "lead is '10 kg'"),
        ("invalid = 'maybe'", "invalid is 'maybe'"),
        ("columns = 3", "columns is 3"),
        ("= nonsense", "the mapping file cannot be read"),
        (f"rate = {'1' * 5000}", "a whole number in it has too many digits"),
        (
            f'[columns]\nfield = {{column = "Y", scale = 1{"0" * 400}}}',
            "a whole number in it has more than 64 bits",
        ),
        (f"inputs = 0x{'f' * 4000}", "a whole number in it has more than 64 bits"),
        ("[constants]\nfield = 'half'", "the constant field is 'half'"),
    ],
)
def test_a_mapping_file_that_says_nonsense(
    log: Callable[..., Path], rows: Rows, text: str, problem: str
) -> None:
    path = log(rows)
    path.with_name("erclutch.toml").write_text(text, encoding="utf-8")
    with pytest.raises(MappingError) as caught:
        read(path, LABELS if "constants" not in text else None)
    assert problem in str(caught.value)


def test_a_file_name_gives_constants(log: Callable[..., Path], rows: Rows) -> None:
    path = log(rows, "t,c,speed [m/s],force [N]", "25mm0x5Hz0x25A.csv")
    recording = read(path, {"name_pattern": "{amplitude}mm{frequency}Hz{field}A"})
    assert recording.constants == {"amplitude": 25.0, "frequency": 0.5, "field": 0.25}
    assert np.array_equal(recording.signals["field"], np.full(200, 0.25))
    assert recording.units["field"] == "A"
    assert "field <- constant 0.25 A (from the file's name)" in recording.notes
    with pytest.raises(MappingError, match="does not match the pattern"):
        read(path, {"name_pattern": "{field}A"})


def test_what_is_given_wins_over_a_name_that_does_not_match(
    log: Callable[..., Path], rows: Rows
) -> None:
    path = log(rows, "t,c,speed [m/s],force [N]", "renamed.csv")
    path.with_name("erclutch.toml").write_text('name_pattern = "{field}A"\n', encoding="utf-8")
    assert read(path, {"constants": {"field": "0.75 A"}}).constants["field"] == 0.75
    with pytest.raises(MappingError, match="does not match the pattern"):
        read(path)


def test_a_variable_of_a_log_that_is_one_recording_is_refused(
    log: Callable[..., Path], rows: Rows
) -> None:
    with pytest.raises(
        LogError, match="the text is one recording, so it has no 'x' for --variable"
    ):
        read(log(rows), LABELS, variable="x")
    assert read(log(rows), LABELS, variable="").rows == 200


def test_name_patterns() -> None:
    assert constants_of("{a [kV]}_{b:mm}", "2x5_-3.csv") == {"a": (2.5, "kV"), "b": (-3.0, "mm")}
    assert constants_of("run{n}", "run7.tar.gz") == {"n": (7.0, None)}
    for pattern in ("nothing", "{a}{a}", "{a", "{1a}"):
        with pytest.raises(MappingError, match="not a template"):
            constants_of(pattern, "1.csv")


COAXIAL = {
    "E1": [0.0, 0.5],
    "E2": [0.5, 0.0],
    "theta": [0.0, 1.0],
    "alpha_raw": [0.0, 0.01],
    "T": [0.1, 0.2],
}


def coaxial(**changes: list[float] | None) -> dict[str, Any]:
    signals = {
        name: values for name, values in {**COAXIAL, **changes}.items() if values is not None
    }
    return {name: np.resize(values, 20) for name, values in signals.items()}


def test_coaxial_logs_without_units_are_si() -> None:
    recording = recording_from_arrays(coaxial(), rate=1000, device="coaxial", lead=0.01)
    assert recording.units == {"E1": "", "E2": "", "theta": "rad", "T": "N*m", "alpha": "rad"}
    np.testing.assert_allclose(recording.signals["alpha"][:2], [0, 2 * pi])
    assert "T <- column T, no unit: assumed N*m (given)" in recording.notes
    assert "alpha = alpha_raw * 2 pi / lead with a lead of 0.01 m" in recording.notes


def test_coaxial_needs() -> None:
    with pytest.raises(MappingError, match="whose lead is not given"):
        recording_from_arrays(coaxial(), rate=1000, device="coaxial")
    with pytest.raises(MappingError, match="no column for E1 and E2 or E"):
        recording_from_arrays(coaxial(E1=None), rate=1000, device="coaxial", lead=0.01)
    with pytest.raises(MappingError, match="no column for T"):
        recording_from_arrays(coaxial(T=None), rate=1000, device="coaxial", lead=0.01)
    with pytest.raises(MappingError, match="'E1' is no signal of a single device"):
        recording_from_arrays(coaxial(), rate=1000)
    volts = recording_from_arrays(coaxial(E1=[0.0, 2000.0]), rate=1000, device="coaxial", lead=0.01)
    assert volts.units["E1"] == "?"


def test_speed_and_position_are_both_delivered() -> None:
    signals = coaxial(theta_dot=[1.0, 2.0], alpha=[0.0, 1.0], alpha_dot=[3.0, 4.0])
    recording = recording_from_arrays(signals, rate=1000, device="coaxial", lead=0.01)
    assert {"theta", "theta_dot", "alpha", "alpha_dot"} <= set(recording.signals)
    assert "alpha_raw" not in recording.signals


def test_a_coaxial_file_is_guessed_by_its_names(log: Callable[..., Path]) -> None:
    columns = {"t": np.arange(20) / 100, **coaxial(alpha_raw=None, alpha_dot=[1.0, 2.0])}
    recording = read(
        log(columns, "Time,E1,E2,theta [deg],T [mNm],alpha_dot [rpm]"), device="coaxial"
    )
    assert set(recording.signals) == {"E1", "E2", "theta", "T", "alpha_dot"}
    np.testing.assert_allclose(recording.signals["alpha_dot"][1], 4 * pi / 60)


def test_arrays_go_through_the_same_checks() -> None:
    signals = {"field": np.ones(20), "slip": np.arange(20.0), "effort": np.arange(20.0)}
    recording = recording_from_arrays(
        signals, {"slip": "rpm", "effort": "Nm", "field": "kV"}, time=np.arange(20) * 0.01
    )
    assert recording.units == {"slip": "rad/s", "effort": "N*m", "field": "V"}
    assert recording.period == 0.01
    assert len(recording.digest) == 64
    with pytest.raises(MappingError, match="there is no signal 'speed'"):
        recording_from_arrays({"speed": np.ones(20)}, rate=1)
    with pytest.raises(MappingError, match=r"differ in length \(field 20, slip 19"):
        recording_from_arrays({**signals, "slip": np.ones(19)}, rate=1)
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        recording_from_arrays(signals)
    with pytest.raises(MappingError, match="holds no numbers"):
        recording_from_arrays({**signals, "slip": ["fast"] * 20}, rate=1)
    with pytest.raises(MappingError, match=r"has the shape \(20, 1\)"):
        recording_from_arrays({**signals, "slip": np.ones((20, 1))}, rate=1)
    with pytest.raises(SettingError, match="there is no device 'triple'"):
        recording_from_arrays(signals, rate=1, device="triple")  # type: ignore[arg-type]


def test_missing_values_are_an_error_or_gaps() -> None:
    slip = np.arange(30.0)
    slip[[7, 8]], slip[20] = np.nan, np.inf
    signals = {"field": np.ones(30), "slip": slip, "effort": np.ones(30)}
    with pytest.raises(LogError) as caught:
        recording_from_arrays(signals, rate=100)
    assert str(caught.value) == (
        "arrays: column slip has 3 values missing or infinite, the first (nan) in data row 8. "
        "Correct them, or cut the log there with --invalid drop."
    )
    recording = recording_from_arrays(signals, rate=100, invalid="drop")
    assert recording.segments == ((0, 7), (7, 18), (18, 27))
    assert recording.time[7] == pytest.approx(0.09)
    assert any("3 rows dropped, the log cut there" in note for note in recording.notes)


def test_a_stamp_that_is_missing() -> None:
    time = np.arange(30) * 0.01
    time[4] = np.nan
    signals = {"field": np.ones(30), "slip": np.ones(30), "effort": np.ones(30)}
    with pytest.raises(LogError, match="column time has 1 value missing"):
        recording_from_arrays(signals, time=time)
    assert recording_from_arrays(signals, time=time, invalid="drop").segments == ((0, 4), (4, 29))


def test_merging_mappings() -> None:
    base = ColumnMap.from_dict(
        {"time": "t", "columns": {"slip": "a", "effort": "b"}, "constants": {"field": "1 A"}},
        "x.toml",
    )
    over = ColumnMap.from_labels({"slip": "c", "field": "d"}, rate=10).over(base)
    assert over.columns["slip"].column == "c"
    assert over.columns["effort"].source == "x.toml"
    assert dict(over.constants) == {}
    assert over.time is None


def test_a_given_column_stays_where_another_would_be_guessed(
    log: Callable[..., Path], rows: Rows
) -> None:
    path = log({**rows, "G": -rows["Y"]}, "t,Y,speed [m/s],force [N],field")
    recording = read(path, {"field": "Y"})
    assert np.array_equal(recording.signals["field"], rows["Y"])
    assert "field <- column Y, no unit: taken as logged (given)" in recording.notes


def test_a_signed_field_that_is_given_stands_for_both_fields(log: Callable[..., Path]) -> None:
    columns = {"t": np.arange(20) / 100, **coaxial(alpha_raw=None, alpha=[0.0, 0.1], E=[0.5, -0.5])}
    recording = read(log(columns), {"E": "E"}, device="coaxial")
    assert np.array_equal(recording.signals["E"], columns["E"])
    assert not {"E1", "E2"} & set(recording.signals)


@pytest.mark.parametrize(("number", "unit"), [("0.4", ""), ("400", "?")])
def test_a_constant_field_of_a_pair_is_a_plain_number_or_unknown(
    log: Callable[..., Path], number: str, unit: str
) -> None:
    columns = {
        "t": np.arange(20) / 100,
        **coaxial(alpha_raw=None, alpha=[0.0, 0.1], E1=None, E2=None),
    }
    recording = read(log(columns), {"constants": {"E1": number, "E2": "0"}}, device="coaxial")
    assert recording.units["E1"] == unit
    assert np.array_equal(recording.signals["E1"], np.full(20, float(number)))


def test_a_constant_rate_in_the_log_is_its_clock(log: Callable[..., Path], rows: Rows) -> None:
    columns = {name: values for name, values in rows.items() if name != "t"}
    path = log(columns)
    first, *rest = path.read_text(encoding="utf-8").splitlines()[1:]
    lines = [",".join([*columns, "fs"]), f"{first},250.0", *(f"{line}," for line in rest)]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    recording = read(path, LABELS)
    assert recording.constants == {"fs": 250.0}
    assert recording.period == 0.004


def test_the_time_may_be_an_input_too(log: Callable[..., Path], rows: Rows) -> None:
    recording = read(log(rows), ColumnMap.from_dict({"columns": LABELS, "inputs": ["t"]}))
    np.testing.assert_allclose(recording.extras["t"], recording.time)


@pytest.mark.parametrize(
    ("text", "rate"), [("500", 500.0), ("1kHz", 1000.0), ("2.5 kHz", 2500.0), ("100 Hz", 100.0)]
)
def test_a_rate_has_a_unit(text: str, rate: float) -> None:
    assert ColumnMap.from_dict({"rate": text}).rate == pytest.approx(rate)
    with pytest.raises(MappingError, match="positive number in Hz"):
        ColumnMap.from_dict({"rate": f"{text} m"})


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("5mm3Hz0x25A.txt", "{amplitude}mm{frequency}Hz{field}A"),
        ("run 12_1.5kV.csv", "run {number1}_{field}kV"),
        ("test-0.5A-3Hz.csv", "test-{field}A-{frequency}Hz"),  # no -0.5 A
        ("test_-2A.csv", "test_{field}A"),
        ("ramp1A2A.csv", ""),  # which of the two is the field?
        ("run12.csv", ""),
        ("log", ""),
    ],
)
def test_a_pattern_is_proposed_where_a_name_holds_a_field(name: str, pattern: str) -> None:
    assert proposed(name) == pattern
    assert not pattern or "field" in constants_of(pattern, name)


def with_holes(where: np.ndarray, rows: int = 200) -> dict[str, np.ndarray]:
    """Columns of a log, in which the torque lacks the numbers of some rows."""
    k = np.arange(rows, dtype=np.float64)
    torque = np.sin(k / 9.0)
    torque[where] = np.nan
    return {
        "t [s]": k * 0.01,
        "field [A]": k % 7,
        "slip [rad/s]": np.cos(k / 9.0),
        "torque [N*m]": torque,
    }


@pytest.mark.slow
@pytest.mark.parametrize("where", [[20], [0, 1], [199], [20, 21, 90], [*range(10, 200, 20)]])
def test_a_log_is_cut_where_a_few_values_are_missing(where: list[int]) -> None:
    columns = with_holes(np.array(where))
    log = read(pd.DataFrame(columns))
    kept = np.delete(np.arange(200), where)
    np.testing.assert_array_equal(log.signals["effort"], columns["torque [N*m]"][kept])
    assert log.segments == read(pd.DataFrame(columns), invalid="drop").segments
    assert any("dropped, the log cut there" in note for note in log.notes)
    with pytest.raises(LogError, match="missing or infinite"):
        read(pd.DataFrame(columns), invalid="error")


@pytest.mark.parametrize(
    ("where", "rows"),
    [([*range(21)], 200), ([*range(0, 200, 10)], 200), ([3, 7, 12], 40)],
    ids=["more than a tenth", "stretches of nine rows", "short stretches"],
)
def test_where_more_is_missing_the_user_is_asked(where: list[int], rows: int) -> None:
    with pytest.raises(LogError, match=r"missing or infinite.*--invalid drop"):
        read(pd.DataFrame(with_holes(np.array(where), rows)))


def test_an_infinite_value_is_asked_about() -> None:
    columns = with_holes(np.array([20]))
    columns["torque [N*m]"][50] = np.inf
    with pytest.raises(LogError, match=r"2 values missing or infinite.*--invalid drop"):
        read(pd.DataFrame(columns))
