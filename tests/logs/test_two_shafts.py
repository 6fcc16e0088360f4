"""The slip of a clutch between two shafts is what their speeds differ by; a gear has two shafts too, so it is asked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Plan, Table, apply, plan_of, read, read_batches
from erclutch.logs.saved_plan import save_plan
from erclutch.signals.array import Array

TIME = np.arange(800) / 100
TURNS = 2.0 * np.sin(3.0 * TIME)  # to and fro
FIELD = np.repeat([0.0, 0.5, 1.0, 1.5], 200)
DRIVING = 50.0 + 5.0 * np.sin(TIME)


def columns_of(driving: str, driven: str, slip: Array, effort: str = "torque") -> dict[str, Array]:
    torque = (0.1 + FIELD) * np.tanh(5.0 * slip)
    return {
        "time": TIME,
        driving: DRIVING,
        driven: DRIVING - slip,
        effort: torque,
        "current": FIELD,
    }


def planned(columns: dict[str, Array], name: str = "a.csv", **labels: str) -> Plan:
    return plan_of(Table(name, columns, {}, "0" * 64), ColumnMap.from_labels(labels))


PAIRS = [
    ("input_speed", "output_speed"),
    ("n_in_rpm", "n_out_rpm"),
    ("n_in", "n_out"),
    ("omega_in", "omega_out"),
    ("Drehzahl Antrieb", "Drehzahl Abtrieb"),
    ("n_an", "n_ab"),
    ("Antriebsdrehzahl", "Abtriebsdrehzahl"),
    ("driving omega", "driven omega"),
    ("motor_speed", "load_speed"),
    ("输入转速", "输出转速"),
    ("vitesse entree", "vitesse sortie"),
]


@pytest.mark.parametrize(("driving", "driven"), PAIRS)
def test_the_slip_is_the_difference_where_the_effort_keeps_to_its_sign(
    driving: str, driven: str
) -> None:
    columns = columns_of(driving, driven, TURNS)
    plan = planned(columns)
    slip = plan.signal("slip")
    assert slip is not None
    assert slip.column == f"{driving} - {driven}"
    assert plan.questions == ()
    recording = apply(plan, Table("a.csv", columns, {}, "0" * 64))
    np.testing.assert_allclose(recording.signals["slip"] / slip.factor, TURNS, atol=1e-12)


@pytest.mark.parametrize(("driving", "driven"), PAIRS)
def test_it_is_asked_about_where_nothing_tells_a_clutch_from_a_gear(
    driving: str, driven: str
) -> None:
    columns = columns_of(driving, driven, 3.0 + TURNS)
    plan = planned(columns)
    assert [question.signal for question in plan.questions] == ["slip"]
    assert plan.examples == (f'--slip "{driving} - {driven}"',)
    assert planned(columns, slip=driven).questions == ()


@pytest.mark.parametrize("place", ["name", "column", "header"])
def test_the_word_clutch_settles_it(place: str) -> None:
    columns = columns_of(
        "n_in", "n_out", 3.0 + TURNS, "clutch torque" if place == "column" else "torque"
    )
    table = Table("Kupplung 3.csv" if place == "name" else "a.csv", columns, {}, "0" * 64)
    if place == "header":
        table = replace(table, metadata={"Prüfling": "MR-Kupplung"})
    slip = plan_of(table, ColumnMap()).signal("slip")
    assert slip is not None
    assert slip.column == "n_in - n_out"


@pytest.mark.slow
def test_a_difference_is_named_with_a_sign_and_a_unit(tmp_path: Path) -> None:
    log = tmp_path / "pair.csv"
    rows = np.column_stack([TIME, DRIVING, DRIVING - TURNS, np.tanh(TURNS), FIELD])
    np.savetxt(log, rows, delimiter=",", header="t,a,b,torque,current", comments="")
    recording = read(log, slip="-a - b [rpm]", effort="torque", field="current")
    np.testing.assert_allclose(recording.signals["slip"], -TURNS * np.pi / 30, atol=1e-9)
    with_units = read(log, slip="a [rpm] - b [rpm]", effort="torque", field="current")
    np.testing.assert_allclose(with_units.signals["slip"], TURNS * np.pi / 30, atol=1e-9)
    with pytest.raises(
        MappingError, match=r"pair.csv: .*difference of two units, rpm and rad/s.*one unit"
    ):
        read(log, slip="a [rpm] - b [rad/s]", effort="torque", field="current")
    with pytest.raises(MappingError, match="there is no column 'a - c' for slip"):
        read(log, slip="a - c", effort="torque", field="current")


def test_a_saved_plan_makes_the_difference_again(tmp_path: Path) -> None:
    columns = columns_of("n_in", "n_out", TURNS)
    plan = planned(columns)
    mapping = tmp_path / "map.toml"
    save_plan(plan, mapping)
    again = plan_of(Table("a.csv", columns, {}, "0" * 64), ColumnMap.from_toml(mapping))
    assert again.signal("slip") == plan.signal("slip")


def test_a_column_of_that_very_name_goes_before_a_difference() -> None:
    columns = {**columns_of("a", "b", TURNS), "a - b": 7.0 * TURNS}
    table = Table("a.csv", columns, {}, "0" * 64)
    recording = apply(plan_of(table, ColumnMap.from_labels({"slip": "a - b"})), table)
    np.testing.assert_array_equal(recording.signals["slip"], 7.0 * TURNS)


def test_codes_for_no_measurement_in_both_shafts_are_left_out() -> None:
    columns = columns_of("n_in", "n_out", TURNS)
    for name in ("n_in", "n_out"):
        columns[name] = columns[name].copy()
        columns[name][100:105] = -999.0
    table = Table("a.csv", columns, {}, "0" * 64)
    recording = apply(plan_of(table, ColumnMap()), table)
    assert recording.rows == TIME.size - 5


def test_the_file_is_said_to_have_its_own_columns_alone() -> None:
    plan = planned(columns_of("n_in", "n_out", 3.0 + TURNS))
    _, _, listed = plan.questions[0].problem.partition("the file has: ")
    assert listed == "time, n_in, n_out, torque, current"
    assert "n_in - n_out" not in plan.spare


@pytest.mark.slow
@given(
    st.lists(
        st.sampled_from(["a", "b", "a - b", "b - a", "c"]), min_size=1, max_size=5, unique=True
    )
)
def test_parts_are_two_columns_of_the_file(names: list[str]) -> None:
    columns = {name: np.full(3, float(place)) for place, name in enumerate(names)}
    table = Table("a.csv", columns, {}, "0" * 64)
    for label in ("a - b", "b - a", "a - b - c", "a - c"):
        parts = table.parts_of(label)
        if label in names:
            assert parts is None
        elif parts is not None:
            assert " - ".join(parts) == label
            np.testing.assert_array_equal(
                table.planned(label), columns[parts[0]] - columns[parts[1]]
            )


def test_the_angles_of_two_shafts_differ_by_the_angle_of_the_slip() -> None:
    angle = np.cumsum(TURNS) / 100
    columns = columns_of("theta_in", "theta_out", TURNS)
    columns |= {"theta_in": np.cumsum(DRIVING) / 100, "theta_out": np.cumsum(DRIVING) / 100 - angle}
    plan = planned(columns)
    position = plan.signal("position")
    assert position is not None
    assert position.column == "theta_in - theta_out"
    assert plan.questions == ()


@pytest.mark.slow
def test_two_numbered_ends_are_one_device_where_the_file_has_one_effort() -> None:
    columns = columns_of("n1", "n2", TURNS)
    slip = planned(columns).signal("slip")
    assert slip is not None
    assert slip.column == "n1 - n2"
    asked = planned(columns_of("n1", "n2", 3.0 + TURNS))
    assert asked.examples == ('--slip "n1 - n2"',)
    # Of two joints each has its effort, and of three speeds no two are ends.
    joints = {**columns_of("qd1", "qd2", TURNS, "tau1"), "tau2": TURNS}
    assert " - " not in " ".join(planned(joints).examples)
    three = {**columns, "n3": 0.1 * TURNS}
    assert " - " not in " ".join(planned(three).examples)


@pytest.mark.parametrize("ratio", [1.0, 5.0])
def test_shafts_that_turn_as_one_are_those_of_a_gear(ratio: float) -> None:
    columns = columns_of("motor_speed", "output_speed", TURNS)
    columns |= {"motor_speed": ratio * columns["output_speed"] + 0.001 * np.sin(50 * TIME)}
    plan = planned(columns)
    assert " - " not in str(plan)
    assert " - " not in " ".join(plan.examples)


@pytest.mark.parametrize("other", ["slip", "omega", "speed_rpm", "Drehzahl"])
def test_a_slip_that_is_logged_beside_two_shafts_is_taken(other: str) -> None:
    for pair in (("n_in", "n_out"), ("v1", "v2")):
        columns = {**columns_of(*pair, TURNS), other: TURNS}
        plan = planned(columns)
        slip = plan.signal("slip")
        assert slip is not None
        assert slip.column == other


@pytest.mark.slow
def test_a_log_in_blocks_has_the_difference_of_a_log_read_whole(tmp_path: Path) -> None:
    rows = 25_000
    time = np.arange(rows) / 1000
    slip = 2.0 * np.sin(3.0 * time)
    driving = 50.0 + 5.0 * np.sin(time)
    columns = np.column_stack([time, driving, driving - slip, np.tanh(5.0 * slip), time // 5 % 2])
    log = tmp_path / "long.csv"
    head = "time [s],n_in [rpm],n_out [rpm],torque [N*m],current [A]"
    np.savetxt(log, columns, delimiter=",", header=head, comments="")
    whole = read(log).signals["slip"]
    blocks: list[Array] = []
    for batch in read_batches(log, rows=10_000):
        inside = (batch.rows >= batch.start) & (batch.rows < batch.stop)
        blocks.append(batch.recording.signals["slip"][inside])
    assert len(blocks) > 1
    np.testing.assert_array_equal(np.concatenate(blocks), whole)


@pytest.mark.parametrize(
    ("driving", "driven", "torques"),
    [
        ("Motor Drehzahl", "Abtrieb Drehzahl", ("Motor Moment", "Abtrieb Moment")),
        ("motor_speed", "shaft_speed", ("motor_torque", "shaft_torque")),
    ],
)
def test_the_difference_of_two_shafts_takes_the_torque_of_neither(
    driving: str, driven: str, torques: tuple[str, str]
) -> None:
    columns = columns_of(driving, driven, TURNS, torques[0])
    columns[torques[1]] = 1.05 * columns[torques[0]] + 0.02
    plan = planned(columns, slip=f"{driving} - {driven}")
    assert [question.signal for question in plan.questions] == ["effort"]


@pytest.mark.parametrize(("driving", "driven"), PAIRS[:3])
@pytest.mark.parametrize("name", ["gear.csv", "clutch.csv"])
def test_speeds_of_shafts_that_turn_against_each_other_are_asked_about_one_by_one(
    driving: str, driven: str, name: str
) -> None:
    columns = columns_of(driving, driven, 3.0 + TURNS)
    columns[driven] = -columns[driven]  # counted the other way round
    plan = planned(columns, name)
    assert [question.signal for question in plan.questions] == ["slip"]
    assert plan.examples == (f'--slip "{driven}"',)
