"""What a column becomes on its way to a recording: temperatures, scales, constants, inputs, spare columns, clocks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError, SettingError, UnitError
from erclutch.logs import read
from erclutch.logs.applied import apply, apply_rows, clocked_runs
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.planning.clock_planning import clock_plan
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.saved_plan import save_plan
from erclutch.logs.table import Table
from erclutch.signals.recording import Recording
from erclutch.signals.units import is_written_well

N = 60
ROWS = np.arange(float(N))
PLAIN = {"t": ROWS / 100.0, "field": np.sin(ROWS), "slip": np.cos(ROWS), "effort": np.sin(2 * ROWS)}
COAXIAL: dict[str, Any] = {
    **{"t": ROWS / 100.0, "E1": np.sin(ROWS) ** 2, "E2": np.cos(ROWS) ** 2, "theta_dot": ROWS},
    **{"alpha_dot": np.cos(ROWS), "T": np.sin(2 * ROWS)},
}


TWICE = ("torque [N*m]", "torque [N*m] (2)")


def table(columns: dict[str, Any], units: dict[str, str] | None = None, **more: Any) -> Table:
    return Table(
        "a.csv", columns, {"t": "s", **(units or {})}, "0" * 64, **{"path": "logs/a.csv", **more}
    )


def assemble(
    log: Table, told: ColumnMap, *, device: Any = "single", invalid: Any = None
) -> Recording:
    return apply(plan_of(log, told, device=device, invalid=invalid), log)


def made(
    columns: dict[str, Any], units: dict[str, str] | None = None, *, of: Any = None, **more: Any
) -> Recording:
    device = "coaxial" if "E1" in columns else "single"
    return assemble(table(columns, units, **more), ColumnMap.from_dict(of or {}), device=device)


# --- temperature, scales ----------------------------------------------------------------------------------------------


def test_fahrenheit_is_read_too() -> None:
    warm = np.linspace(68.0, 212.0, PLAIN["field"].size)
    found = made(
        {**PLAIN, "W": warm}, of={"columns": {"temperature": {"column": "W", "unit": "°F"}}}
    )
    np.testing.assert_allclose(found.extras["temperature_K"][[0, -1]], [293.15, 373.15])


@pytest.mark.parametrize(
    ("column", "option"),
    [
        ("Oil_Temp(degC)", '"Oil_Temp [degC]"'),
        ("Oil Temp (°F)", '"Oil Temp [°F]"'),
        ("温度(℃)", '"温度 [℃]"'),
        ("temp_C", '"temp_C [°C]"'),
        ("Oil temperature", '"Oil temperature [°C]", or [K]'),
        ("油温", '"油温 [°C]", or [K]'),
    ],
)
def test_a_temperature_that_no_law_uses_is_told(column: str, option: str, tmp_path: Path) -> None:
    """It was left out in silence where its unit stands in round brackets, ends its name, or is not there."""
    path = tmp_path / "log.csv"
    rows = "".join(f"{k / 100},{k // 20 % 2},{k % 7},{k % 5},{20 + k / 90}\n" for k in range(60))
    path.write_text(f"t [s],I [A],w [rad/s],M [N*m],{column}\n{rows}", encoding="utf-8")
    uses = (f"with --temperature {option} laws do", f"with --temperature {option}, laws use it")
    assert any(note.endswith(uses) for note in read(path).notes)


def test_a_head_is_found_with_its_unit_once_more_behind_it(tmp_path: Path) -> None:
    """So a run of an older version names a column whose unit stands in round brackets."""
    path = tmp_path / "log.csv"
    rows = "".join(f"{k / 100},{k // 20 % 2},{k % 7},{k % 5},{20 + k / 90}\n" for k in range(60))
    path.write_text(f"t [s],I [A],w [rad/s],M [N*m],Oil(degC)\n{rows}", encoding="utf-8")
    found = read(path, temperature="Oil(degC) [degC]")
    assert found.extras["temperature_K"][0] == pytest.approx(293.15)


def test_words_that_begin_alike_are_no_temperature(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "".join(f"{k / 100},{k // 20 % 2},{k % 7},{k % 5},{20 + k / 90}\n" for k in range(60))
    path.write_text(f"t [s],I [A],w [rad/s],M [N*m],template\n{rows}", encoding="utf-8")
    assert not any("--temperature" in note for note in read(path).notes)


@pytest.mark.parametrize(("unit", "add"), [("°C", 273.15), ("K", 0.0)])
@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_a_temperature_is_in_kelvin(unit: str, add: float, scale: float) -> None:
    warm = 300.0 + ROWS / 10 if unit == "K" else 20.0 + ROWS / 10
    columns = {"columns": {"temperature": {"column": "W", "unit": unit, "scale": scale}}}
    if unit == "K" and scale == 0.5:
        warm = 2 * warm
    found = made({**PLAIN, "W": warm}, of=columns)
    np.testing.assert_allclose(found.extras["temperature_K"], scale * warm + add)
    assert "W" not in found.spare
    assert f"temperature <- column W [{unit}], in K (given)" in found.notes


def test_a_temperature_that_no_fluid_has_is_refused_in_a_later_block_too() -> None:
    """The plan of a long log is made of its first block, and saw the temperatures of that block alone."""
    first = table({**PLAIN, "W": 20.0 + ROWS / 10})
    plan = plan_of(first, ColumnMap.from_labels({"temperature": "W [°C]"}))
    assert apply(plan, first).extras["temperature_K"][0] == 20.0 + 273.15
    warm = np.where(ROWS == 7, 900.0, 20.0 + ROWS / 10)
    with pytest.raises(LogError, match="beyond 150 to 800 K, which nothing measures") as caught:
        apply(plan, table({**PLAIN, "W": warm + ROWS}))
    assert "data row 8" in caught.value.problem


@pytest.mark.parametrize(
    ("unit", "scale", "factor", "si"),
    [
        ("V", "2.5 N/V", 2.5, "N"),
        ("mV", "2.5 N/V", 2.5e-3, "N"),
        ("mV", "2.5 kN/V", 2.5, "N"),
        ("", "3 N*m", 3.0, "N*m"),
        ("", "3", 3.0, "?"),
        ("V", "-2 N/V", -2.0, "N"),
        ("kN", "2", 2000.0, "N"),
    ],
)
def test_a_scale_makes_a_signal_of_a_sensor(unit: str, scale: str, factor: float, si: str) -> None:
    found = made(PLAIN, {"effort": unit} if unit else {}, of={"scales": {"effort": scale}})
    np.testing.assert_allclose(found.signals["effort"], factor * PLAIN["effort"])
    assert found.units["effort"] == si
    (note,) = (n for n in found.notes if n.startswith("effort"))
    assert f", times {scale}" in note
    assert (", sign turned" in note) == (factor < 0)
    assert ("no unit: taken as logged" in note) == (si == "?")


@pytest.mark.parametrize(
    ("unit", "scale", "problem"),
    [
        ("A", "2.5 N/V", "has the unit 'A', and the scale of effort is 2.5 N/V"),
        (
            "V",
            "2.5 N",
            "has the unit 'V', and the scale of effort, 2.5 N, names no unit of a sensor",
        ),
        ("V", "0 N/V", "the scale of effort is '0 N/V'"),
    ],
)
def test_a_scale_that_does_not_fit(unit: str, scale: str, problem: str) -> None:
    chosen = {
        "columns": {"effort": {"column": "effort", "unit": unit}},
        "scales": {"effort": scale},
    }
    with pytest.raises((UnitError, MappingError)) as caught:
        made(PLAIN, of=chosen)
    assert problem in str(caught.value)


# --- constants, inputs, spare columns ---------------------------------------------------------------------------------


def test_a_constant_beside_a_chosen_column_is_refused() -> None:
    with pytest.raises(MappingError, match="field is given as a column and as a constant"):
        made(PLAIN, of={"columns": {"field": "field"}, "constants": {"field": "2 A"}})
    found = made(PLAIN, of={"columns": {"field": "field"}, "constants": {"mass": "3 kg"}})
    assert dict(found.constants) == {"mass": 3.0}
    assert "mass = 3 kg (given)" in found.notes


def test_a_constant_signal_is_converted() -> None:
    found = made(
        {k: v for k, v in PLAIN.items() if k != "field"}, of={"constants": {"field": "20 mA"}}
    )
    np.testing.assert_allclose(found.signals["field"], np.full(N, 0.02))
    assert (found.units["field"], found.constants["field"]) == ("A", pytest.approx(0.02))


def test_inputs_are_named_scaled_or_asked_for() -> None:
    found = made({**PLAIN, "D": ROWS}, of={"inputs": ["-D"]})
    np.testing.assert_array_equal(found.extras["D"], -ROWS)
    with pytest.raises(MappingError, match="there is no column 'Q' for input"):
        made(PLAIN, of={"inputs": ["Q"]})


def test_a_further_input_keeps_the_unit_that_its_label_says() -> None:
    columns = {**PLAIN, "D": ROWS, "load": ROWS, "raw": ROWS, "oil": ROWS, "air": ROWS}
    labels = ["D [mm]", "-load [kg]", "raw [counts of 12 bits]", "oil [°C]", "air [℃]"]
    found = made(columns, of={"inputs": labels})
    assert [*found.extra_units.values()] == ["mm", "kg", "?", "°C", "?"]
    assert all(
        map(is_written_well, found.extra_units.values())
    )  # a saved model of them is read again
    np.testing.assert_array_equal(found.extras["load"], -ROWS)


def test_spare_columns_are_finite_change_and_are_eight_at_most() -> None:
    more = {f"x{k}": ROWS + k for k in range(12)}
    found = made({**PLAIN, "flat": np.ones(N), "hole": np.where(ROWS == 5, np.nan, ROWS), **more})
    assert list(found.spare) == [f"x{k}" for k in range(8)]
    np.testing.assert_array_equal(found.spare["x3"], ROWS + 3)


def test_what_other_models_say_of_the_effort_is_no_spare_column() -> None:
    estimates = {"PINN": 1.1 * PLAIN["effort"], "SVM": 0.9 * PLAIN["effort"]}
    assert list(made({**PLAIN, **estimates, "x": ROWS}).spare) == ["x"]


@pytest.mark.slow
def test_a_motor_torque_is_taken_where_it_is_there_and_finite() -> None:
    found = made({**COAXIAL, "motor_torque": ROWS})
    np.testing.assert_array_equal(found.signals["motor_torque"], ROWS)
    for beside in ({"motor_torque": np.where(ROWS == 5, np.nan, ROWS)}, {}):
        assert "motor_torque" not in made({**COAXIAL, **beside}).signals


def test_everything_missing_is_one_error_with_a_command() -> None:
    with pytest.raises(MappingError) as caught:
        made({"q": ROWS, "r": ROWS**2}, of={"lead": "10 mm", "constants": {"mass": "2 kg"}})
    error = caught.value
    assert error.problem.startswith(
        "4 things are missing: (1) no time column and no sampling rate; (2) no column for "
    )
    assert error.problem.endswith("; the file has: q, r")
    assert (
        'erclutch inspect logs/a.csv --lead "0.01 m" --constant "mass=2 kg" --time "COLUMN [s]"'
        in error.remedy
    )
    for option in ("--field", "--slip", "--effort"):
        assert option in error.remedy
    with pytest.raises(MappingError) as caught:
        made(
            {**COAXIAL, "q": ROWS, "T": np.full(N, np.nan)},
            {"T": "kg"},
            of={"rate": 50, "columns": {"theta_dot": "x"}},
        )
    assert (
        "erclutch inspect logs/a.csv --device coaxial --rate 50 --theta_dot" in caught.value.remedy
    )


def test_a_temperature_that_is_not_there_is_asked_for_beside_all_else() -> None:
    with pytest.raises(
        MappingError, match=r"2 things are missing.*there is no column 'oyl' for temperature"
    ) as caught:
        made({**PLAIN, "oil": ROWS}, of={"columns": {"temperature": "oyl", "slip": "speed"}})
    assert '--temperature "COLUMN [°C]"' in caught.value.remedy


def test_a_plan_is_printed_compared_and_saved_with_what_the_user_said(tmp_path: Path) -> None:
    log = table({**PLAIN, "E": ROWS}, {"effort": "N"})
    plan = plan_of(log, ColumnMap.from_dict({"columns": {"field": "none"}}))
    assert "effort <- column effort [N] (guessed from its name)" in str(plan)
    assert plan.signal("effort").sureness == "sure"  # type: ignore[union-attr]
    assert plan.signal("slip").sureness == "likely"  # type: ignore[union-attr]
    save_plan(plan, tmp_path / "log.toml")
    again = plan_of(log, ColumnMap.from_toml(tmp_path / "log.toml"))
    assert again == plan
    assert again.differences(plan) == ()
    other = plan_of(log, ColumnMap.from_dict({"columns": {"field": "E", "effort": "-effort [N]"}}))
    assert [said.partition(":")[0] for said in other.differences(plan)] == ["signals", "spare"]
    with pytest.raises(MappingError, match="there is no column 'effort', which the plan reads"):
        apply(plan, table({name: values for name, values in PLAIN.items() if name != "effort"}))


@pytest.mark.parametrize("signal", ["position", "slip"])
def test_a_guessed_column_can_be_declined(signal: str, tmp_path: Path) -> None:
    log = table({**PLAIN, "position": np.cumsum(PLAIN["slip"])})
    assert {"position", "slip"} <= {each.signal for each in plan_of(log, ColumnMap()).signals}
    plan = plan_of(log, ColumnMap.from_dict({"columns": {signal: "none"}}))
    assert plan.signal(signal) is None
    assert f"{signal}: no column is taken for it" in str(plan)
    save_plan(plan, tmp_path / "log.toml")
    assert plan_of(log, ColumnMap.from_toml(tmp_path / "log.toml")).signal(signal) is None


def test_a_needed_signal_that_is_declined_is_asked_for() -> None:
    log = table({**PLAIN, "E": ROWS % 2})
    plan = plan_of(log, ColumnMap.from_dict({"columns": {"effort": "none"}}))
    assert [question.signal for question in plan.questions] == ["effort"]


def test_a_plan_of_one_block_serves_for_the_next() -> None:
    log = table({**PLAIN, "t": 45_000.25 + 1e-6 * ROWS}, {"t": ""})
    halves = [
        replace(log, columns={n: v[at : at + 30] for n, v in log.columns.items()}) for at in (0, 30)
    ]
    plan = plan_of(halves[0], ColumnMap())
    first, second = (apply(plan, half) for half in halves)
    whole = apply(plan_of(log, ColumnMap()), log)
    np.testing.assert_allclose([*first.time, *second.time], whole.time, atol=1e-6)
    assert first.notes[:-1] == second.notes[:-1]


def test_no_such_device_or_way_with_missing_values() -> None:
    own: Any = "keep"
    with pytest.raises(SettingError, match="invalid is 'keep'"):
        assemble(table(PLAIN), ColumnMap(), device="single", invalid=own)


# --- clocks -----------------------------------------------------------------------------------------------------------


def test_a_header_with_a_rate_and_a_counter_with_a_gap() -> None:
    columns = {name: values for name, values in PLAIN.items() if name != "t"}
    counter = 7.0 + ROWS + 10.0 * (ROWS >= 20)
    found = made({**columns, "Sample Number": counter}, sample_period=0.01)
    assert found.segments == ((0, 20), (20, N))
    np.testing.assert_allclose(found.time, (counter - 7.0) / 100.0, atol=1e-12)
    assert found.period == pytest.approx(0.01)
    assert "time from the sampling period in the header: 0.01 s" in found.notes
    assert "Sample Number" not in found.spare
    broken = np.where(ROWS == 3, np.nan, counter)
    found = made({**columns, "Sample Number": broken}, sample_period=0.01)
    np.testing.assert_allclose(found.time, ROWS / 100.0)


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        ("fs", 50.0, True),
        ("Sample_Rate", 50.0, True),
        ("f", 50.0, False),
        ("fs", 0.0, False),
        ("rate", np.inf, False),
    ],
)
def test_a_rate_in_the_header(name: str, value: float, taken: bool) -> None:
    columns = {key: values for key, values in PLAIN.items() if key != "t"}
    if taken:
        assert made(columns, constants={name: value}).period == pytest.approx(0.02)
    else:
        with pytest.raises(MappingError, match="no time column and no sampling rate"):
            made(columns, constants={name: value})


@pytest.mark.parametrize(("start", "step", "days"), [(45_000.25, 1e-6, True), (45_000.25, 1.0, False),
                                                     (19_000.0, 1e-6, False), (81_000.0, 1e-6, False)])  # fmt: skip
def test_dates_of_spreadsheets_are_days(start: float, step: float, days: bool) -> None:
    stamps = {"t": start + step * ROWS}
    found = assemble(
        Table("a.csv", {**PLAIN, **stamps}, {}, "0" * 64), ColumnMap(), device="single"
    )
    assert any("taken as days" in note for note in found.notes) == days
    assert found.period == pytest.approx(step * (86_400.0 if days else 1.0), rel=1e-4)
    if days:
        assert found.time[0] == pytest.approx(0.25 * 86_400.0)


@pytest.mark.parametrize(("first", "asked"), [(ROWS / 1000, True), (5 + ROWS * 0.25, True), (ROWS, False),
                                              (-ROWS / 9, False), (np.sin(ROWS), False)])  # fmt: skip
def test_a_first_column_that_grows_by_equal_steps_is_asked_about(first: Any, asked: bool) -> None:
    columns = {"c1": first, **{name: values for name, values in PLAIN.items() if name != "t"}}
    with pytest.raises(MappingError, match="no time column") as caught:
        made(columns)
    assert ('--time "c1 [s]"' in caught.value.remedy) == asked
    with pytest.raises(MappingError, match="2 things are missing") as caught:
        made({name: values for name, values in columns.items() if name != "slip"})
    assert ('--time "c1 [s]"' in caught.value.remedy) == asked


def test_a_field_in_the_name_and_none_that_was_logged_contradict_each_other() -> None:
    columns = {name: values for name, values in PLAIN.items() if name != "field"}
    chosen = {"columns": {"field": "none"}, "name_pattern": "a{field}A"}
    log = replace(table(columns), name="a0x5A.csv")
    with pytest.raises(
        MappingError,
        match=r"field is 0\.5 A from the file's name, and it was said that none was logged",
    ):
        plan_of(log, ColumnMap.from_dict(chosen))
    assert (
        plan_of(log, ColumnMap.from_dict({"name_pattern": "a{field}A"})).constants["field"] == 0.5
    )


def test_a_time_column_in_another_unit_says_so() -> None:
    found = made({**PLAIN, "t": 10.0 * ROWS}, {"t": "ms"})
    assert found.period == pytest.approx(0.01)
    assert "time <- column t, converted from ms (guessed from its name or unit)" in found.notes
    with pytest.raises(UnitError, match="which is no unit of time"):
        made(PLAIN, of={"time": "t [V]"})


def test_steps_without_a_good_sample_cut_the_log_and_are_no_error() -> None:
    lost = (ROWS >= 20) & (ROWS < 23)
    effort = np.where(lost, np.nan, PLAIN["effort"])
    log = table({**PLAIN, "effort": effort}, unsampled=lost)
    found, rows = apply_rows(plan_of(log, ColumnMap()), log)
    assert found.segments == ((0, 20), (20, N - 3))
    np.testing.assert_array_equal(rows, np.flatnonzero(~lost))
    assert "3 steps of the loop had no good sample: left out, the log cut there" in found.notes
    effort[30] = -np.inf
    with pytest.raises(
        LogError,
        match=r"column effort has 1 value missing or infinite, the first \(-infinity\) in data row 31",
    ):
        assemble(table({**PLAIN, "effort": effort}, unsampled=lost), ColumnMap(), device="single")


@pytest.mark.parametrize("value", [1e300, -3.4e38])
def test_a_number_that_nothing_measures_is_refused(value: float) -> None:
    effort = np.where(ROWS == 30, value, PLAIN["effort"])
    with pytest.raises(
        LogError, match=r"column effort is .*e\+\d+ .*in data row 31, beyond 1e\+30"
    ):
        assemble(table({**PLAIN, "effort": effort}), ColumnMap(), device="single")


def test_a_log_whose_clock_restarts_has_a_clock_for_each_run() -> None:
    time = np.concatenate([np.arange(30), np.arange(5), np.arange(25)]) / 100.0
    log = table({**PLAIN, "t": time})
    runs, taken, notes = clocked_runs(clock_plan(seen_columns(log), ColumnMap(), ()), log)
    assert [kept.tolist() for kept, _ in runs] == [list(range(30)), list(range(35, 60))]
    assert "5 rows between two restarts of the clock left out" in notes
    assert taken == {"t"}
    with pytest.raises(MappingError, match="no time column"):
        clock_plan(seen_columns(table({"q": ROWS})), ColumnMap(), ())
    (run,), _, _ = clocked_runs(
        clock_plan(seen_columns(table(PLAIN)), ColumnMap(rate=50.0), ()), table(PLAIN)
    )
    assert run[1].period == pytest.approx(0.02)
    assert ColumnChoice("t").source == "given"


def test_rows_that_repeat_the_row_before_are_told_from_rows_with_other_values() -> None:
    twice = np.r_[0:20, 19, 20:40, 39, 40:60]
    columns = {name: values[twice].copy() for name, values in PLAIN.items()}
    columns["effort"][41] += 1.0
    columns["Sample Number"] = np.arange(62.0)
    columns["hole"] = np.full(62, np.nan)
    found = made(columns)
    assert found.rows == N
    assert any(
        note.startswith(
            "1 rows that repeat the row before were dropped; 1 rows with the t of the row before but other"
        )
        for note in found.notes
    )


def test_a_frame_is_asked_about_in_the_words_of_python() -> None:
    with pytest.raises(MappingError) as caught:
        assemble(table({"q": ROWS, "r": ROWS**2}, path=""), ColumnMap(), device="single")
    assert "in place of these: {'time': 'COLUMN [s]', 'field': 'COLUMN [A]'" in caught.value.remedy


def test_no_column_is_proposed_twice_and_a_refused_unit_is_named() -> None:
    with pytest.raises(MappingError) as caught:
        made({"V": ROWS, "F": ROWS**2}, {"F": "N"})
    assert caught.value.remedy.count('"V"') == 1
    with pytest.raises(
        MappingError, match="column speed is called so, but its unit kg does not fit"
    ):
        made({"current": ROWS, "speed": ROWS, "F": ROWS}, {"F": "N", "current": "A", "speed": "kg"})
    twice = table({"torque [N*m]": ROWS, "torque [N*m] (2)": ROWS}, {name: "N*m" for name in TWICE})
    assert twice.labels == TWICE


def test_a_file_is_asked_about_by_its_path(tmp_path: Path) -> None:
    path = tmp_path / "a b.csv"
    np.savetxt(path, np.column_stack([0.5 * ROWS, ROWS]), delimiter=",", header="q,r", comments="")
    with pytest.raises(MappingError) as caught:
        read(path)
    assert f"erclutch inspect '{path}' --time" in caught.value.remedy


def test_a_recording_of_the_loop_is_a_measurement_and_a_twin_is_none() -> None:
    from erclutch.cli.terminal import recording_lines

    log, words = made(PLAIN), "made by a computer"
    assert not any(
        words in line for line in recording_lines([replace(log, origin="RECORDING"), log])
    )
    assert "TWIN data (some of the logs): made by a computer, not a measurement" in recording_lines(
        [replace(log, origin="TWIN"), replace(log, origin="RECORDING")]
    )


@pytest.mark.slow
def test_counts_are_scaled_and_a_temperature_is_told(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(
        "t [s],u [V],w [rad/s],M [counts],oil [°C]\n"
        + "".join(f"{k / 100},1,{k % 7},{k},{20 + k / 9}\n" for k in range(60))
    )
    mapping = ColumnMap.from_dict(
        {"columns": {"field": "u [V]", "slip": "w [rad/s]", "effort": "M [counts]"}}
    )
    for scale in ("0.5 N*m", "0.5 N*m/counts"):
        found = read(path, replace(mapping, scales={"effort": scale}))
        assert found.units["effort"] == "N*m"
        assert found.signals["effort"][8] == 4.0
        assert any('--temperature "oil [°C]"' in note for note in found.notes)
    with pytest.raises(MappingError, match="Write it like"):
        read(path, replace(mapping, scales={"effort": "0.5 N*m/countz"}))
