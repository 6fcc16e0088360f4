"""Names of variables and files hold no decimal point: 05A may be 0.5 A or 5 A, and the user is asked. SYNTHETIC."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, read_all, read_table
from erclutch.logs.columns.levels_in_names import open_field_in, stated_in, with_lost_points
from erclutch.logs.columns.name_pattern import pattern_among
from erclutch.logs.reading import Reading
from erclutch.signals.array import Array
from tests.support.command import run

TIME = np.arange(200) / 100
SLIP = np.sin(9 * TIME)
FIELDS = (0.0, 0.5, 1.0)


def effort(field: float) -> Array:
    return (50.0 + 200.0 * field) * SLIP


@pytest.mark.parametrize("name", ["F_05A", "F_0_5A", "F_1_5A", "F 025 mA", "2Hz_10mm_2_5A"])
def test_a_number_that_may_lack_its_point_states_no_field(name: str) -> None:
    assert stated_in(name) is None
    assert open_field_in(name)


@pytest.mark.parametrize(
    ("name", "field"),
    [("F_0A", 0.0), ("F_0.5A", 0.5), ("F_0p5A", 0.5), ("F_10A", 10.0), ("run_1_5A", 5.0)],
)
def test_other_numbers_state_it(name: str, field: float) -> None:
    stated = stated_in(name)
    assert stated is not None
    assert stated.number == field
    assert not open_field_in(name)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("names", [("F_0A", "F_05A", "F_1A"), ("F_0A", "F_0_5A", "F_1A")])
def test_variables_without_a_point_are_asked_about(tmp_path: Path, names: tuple[str, ...]) -> None:
    # 5 A were taken, in silence.
    efforts = dict(zip(names, map(effort, FIELDS), strict=True))
    savemat(tmp_path / "log.mat", {"t": TIME, "v": SLIP, **efforts})
    first = run("inspect", "log.mat", "--slip", "v [m/s]", cwd=tmp_path).out.splitlines()[-1]
    assert "--variable all" in first
    second = run(*shlex.split(first)[4:], cwd=tmp_path).out.splitlines()[-1]
    assert '--constant "field=0, NUMBER, 1 A"' in second
    words = shlex.split(second.replace("NUMBER", "0.5"))[4:]
    assert "Understood." in run(*words, cwd=tmp_path).out.splitlines()[-1]
    told = ColumnMap.from_options({"variable": "all", "slip": "v [m/s]"})
    told = ColumnMap(told.columns, variable="all", constants={"field": "0, 0.5, 1 A"})
    logs = read_all(tmp_path / "log.mat", told)
    assert [float(log.signals["field"][0]) for log in logs] == [*FIELDS]


@pytest.mark.slow
def test_a_file_whose_name_lacks_the_point_is_asked_about(tmp_path: Path) -> None:
    for name, field in zip(("b_0A", "b_05A", "b_1A"), FIELDS, strict=True):
        rows = "".join(
            f"{t},{v:.5g},{f:.5g}\n" for t, v, f in zip(TIME, SLIP, effort(field), strict=True)
        )
        (tmp_path / f"{name}.csv").write_text(f"t [s],v [m/s],F [N]\n{rows}", encoding="utf-8")
    alone = run("inspect", "b_05A.csv", cwd=tmp_path).out.splitlines()[-1]
    assert alone.endswith('--constant "field=NUMBER A"')
    together = run("inspect", ".", cwd=tmp_path).out.splitlines()[-1]
    assert together == 'What settles it: erclutch inspect . --write-mapping "erclutch.toml"'
    run(*shlex.split(together)[4:], cwd=tmp_path)
    written = (tmp_path / "erclutch.toml").read_text(encoding="utf-8")
    assert '"b_05A.csv" = "?"\n"b_0A.csv" = "0 A"\n"b_1A.csv" = "1 A"' in written


@pytest.mark.slow
def test_points_at_a_level_without_a_point_are_not_put_under_another_level(tmp_path: Path) -> None:
    path = tmp_path / "sheet.csv"
    rows = "".join(f"{n},{n / 9},{n / 7},{n / 5}\n" for n in range(10, 200, 10))
    path.write_text(f"speed [rpm],T_0A [Nm],T_05A [Nm],T_1A [Nm]\n{rows}", encoding="utf-8")
    assert [*read_table(path).columns] == ["speed", "T_0A", "T_05A", "T_1A"]


@pytest.mark.slow
def test_numbers_in_two_units_are_all_left_to_the_user(tmp_path: Path) -> None:
    # The unit behind the last of them would be that of all.
    fields = {"off": 0.0, "on_500mA": 0.5, "on_1A": 1.0}
    runs = {
        name: {"t": TIME.tolist(), "v_m_s": SLIP.tolist(), "F_N": effort(field).tolist()}
        for name, field in fields.items()
    }
    many = {name: {**run_of, "x_m": TIME.tolist()} for name, run_of in runs.items()}
    (tmp_path / "log.json").write_text(json.dumps(many), encoding="utf-8")
    told = ColumnMap.from_options({"variable": "all", "slip": "v_m_s [m/s]"})
    with pytest.raises(MappingError, match="field=NUMBER, NUMBER, NUMBER mA"):
        read_all(tmp_path / "log.json", told)


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (("I0", "I05", "I1", "I15"), [0.0, 0.5, 1.0, 1.5]),
        (("F I0", "F I025", "F I1"), [0.0, 0.25, 1.0]),
        (("I00", "I05", "I10"), []),  # filled up in each name
        (("I0", "I5", "I10"), []),
        (("v", "F"), []),
    ],
)
def test_numbers_that_are_not_filled_up_lack_their_points(
    names: tuple[str, ...], numbers: list[float]
) -> None:
    # The printed command gave 5 for I05 between I0 and I1.
    assert [*with_lost_points(names).values()] == numbers


@pytest.mark.parametrize(
    ("names", "pattern"),
    [
        (("current_0_0", "current_0_4", "current_1_2"), ""),
        (("I0_0", "I0_5", "I1_0"), ""),
        (("I10_a1", "I20_a1"), "I{field}_a{n2}"),
        (("pwm_50_run_1", "pwm_90_run_2"), "pwm_{field}_run_{n2}"),
    ],
)
def test_a_pattern_takes_no_whole_number_in_front_of_decimals(
    names: tuple[str, ...], pattern: str
) -> None:
    # 0, 0 and 1 were read from the first three by the command that was printed.
    assert pattern_among(names) == pattern


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    ("names", "given"),
    [
        (("test1", "test2", "test3"), "field=NUMBER, NUMBER, NUMBER A"),
        (("I0_0", "I0_5", "I1_0"), "field=NUMBER, NUMBER, NUMBER A"),
        (("pwm0", "pwm5", "pwm10"), "field=0, 5, 10"),
    ],
)
def test_the_field_of_each_recording_of_a_file_is_asked_for(
    tmp_path: Path, names: tuple[str, ...], given: str
) -> None:
    # No command was printed, or a pattern that was refused.
    logs = {
        name: {"t": TIME, "velocity": SLIP, "force": effort(field)}
        for name, field in zip(names, FIELDS, strict=True)
    }
    savemat(tmp_path / "log.mat", logs)
    answer = run("inspect", "log.mat", "--variable", "all", cwd=tmp_path).out.splitlines()[-1]
    assert f'erclutch inspect log.mat --constant "{given}"' in answer
    words = shlex.split(answer.replace("NUMBER, NUMBER, NUMBER", "0, 5, 10"))[4:]
    done = run(*words, cwd=tmp_path)
    assert done.code == 0
    assert "Understood" in done.out
    # The fields themselves: where a table shows them is another thing.
    how = Reading.from_options(
        {"variable": "all", "constant": (words[words.index("--constant") + 1],)}
    )
    read_so = how.read(tmp_path / "log.mat", None)
    assert [{*log.signals["field"].tolist()} for log in read_so] == [{0.0}, {5.0}, {10.0}]
