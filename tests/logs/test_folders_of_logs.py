"""Logs of a folder that no column tells apart: by their names, their folders, or by how much effort they have."""

from __future__ import annotations

import gzip
import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnloggedFieldError
from erclutch.logs import read
from erclutch.logs.columns.name_pattern import constants_of, pattern_among
from erclutch.logs.dataset import build_dataset
from erclutch.logs.planning.tables_beside_logs import tables_beside_logs
from tests.support.command import good, refused, run
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(400) / 100


def brake(path: Path, effort: float, speed: float = 3.0) -> Path:
    """A log of a brake without its current."""
    path.parent.mkdir(exist_ok=True)
    slip = speed * np.sin(3 * TIME)
    torque = effort * np.tanh(5 * slip) + 0.01 * slip
    rows = "".join(f"{t:g},{w:.6g},{m:.6g}\n" for t, w, m in zip(TIME, slip, torque, strict=True))
    path.write_text(f"t [s],w [rad/s],torque [N*m]\n{rows}", encoding="utf-8")
    return path


def folder_of(path: Path, efforts: Mapping[str, float]) -> Path:
    for name, effort in efforts.items():
        brake(path / f"{name}.csv", effort)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "pattern"),
    slow_behind(
        1,
        [
            (("brake_PWM0", "brake_PWM25", "brake_PWM50"), "brake_PWM{field}"),
            (("current_0", "current_0.5", "current_1.5"), "current_{field}"),
            (("i=0_run1", "i=0.5_run2", "i=1_run3"), "i={field}_run{n2}"),
            (
                ("Versuch1 Strom 0", "Versuch2 Strom 1", "Versuch3 Strom 2"),
                "Versuch{n1} Strom {field}",
            ),
        ],
    ),
)
def test_logs_that_names_alone_tell_apart_are_asked_about(
    tmp_path: Path, names: tuple[str, ...], pattern: str
) -> None:
    folder_of(tmp_path / "logs", dict(zip(names, (0.1, 0.6, 1.1), strict=True)))
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == f'What settles it: erclutch inspect logs --name-pattern "{pattern}"'
    said = good("inspect", "logs", "--name-pattern", pattern, cwd=tmp_path)
    assert "Understood. Fit them" in said
    assert "at the same slip" in refused("fit", "logs", cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "pattern"),
    slow_behind(
        2,
        [
            (("current_1.0", "current_1.2", "current_1.4"), "current_{field}"),
            (("I1.0", "I1.2"), "I{field}"),
            (("PWM40", "PWM48", "PWM56"), "PWM{field}"),
            (("brake_1.0", "brake_1.2", "brake_1.4"), "brake_{field}"),
            (("1p0", "1p2"), "{field}"),
            (("test1000", "test1200", "test1400"), "test{field}"),
        ],
    ),
)
def test_fields_in_names_that_are_near_each_other_are_asked_about(
    tmp_path: Path, names: tuple[str, ...], pattern: str
) -> None:
    efforts = dict(zip(names, (1.0, 1.2, 1.4), strict=False))
    folder_of(tmp_path / "logs", efforts)
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == f'What settles it: erclutch inspect logs --name-pattern "{pattern}"'
    assert "no field is logged" in refused("fit", "logs", cwd=tmp_path)
    good("inspect", "logs", "--name-pattern", pattern, cwd=tmp_path)
    good("inspect", "logs", "--field", "none", cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [("brake_1.4", "brake_1.2", "brake_1.0"), ("run1", "run2", "run3"), ("b_1.4", "b_1.2", "b_1")],
)
def test_numbers_in_names_that_no_effort_rises_with_are_no_field(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    folder_of(tmp_path / "logs", dict(zip(names, (1.0, 1.2, 1.4), strict=True)))
    good("inspect", "logs", cwd=tmp_path)


@pytest.mark.slow
def test_logs_that_a_test_plan_alone_tells_apart_are_asked_about(tmp_path: Path) -> None:
    logs = folder_of(tmp_path / "logs", {"run1": 0.1, "run2": 0.6})
    (logs / "testplan.csv").write_text("run,current_A\n1,0\n2,0.5\n")
    said = run("inspect", "logs", cwd=tmp_path)
    assert said.code == 1
    assert "note: testplan.csv left out" in said.error
    assert "times the effort of run1.csv" in said.out
    assert "testplan.csv says run1.csv 0 A, run2.csv 0.5 A" in said.out
    for name, amperes in (("run1", 0), ("run2", 0.5)):
        (logs / f"{name}.csv.toml").write_text(f'constants.field = "{amperes} A"\n')
    assert "Understood" in run("inspect", "logs", cwd=tmp_path).out


@pytest.mark.slow
def test_the_pattern_of_a_folder_tells_the_field(tmp_path: Path) -> None:
    for name, effort in (("I0", 0.1), ("I0.5", 0.6)):
        folder_of(tmp_path / name, {"run1": effort, "run2": 1.02 * effort})
    for words in (["I0", "I0.5"], ["."]):
        last = good("inspect", *words, cwd=tmp_path, code=1).splitlines()[-1]
        pattern = '--name-pattern "I{field}/run{n2}"'
        assert last == f"What settles it: erclutch inspect {' '.join(words)} {pattern}"
    log = read(tmp_path / "I0.5" / "run1.csv", name_pattern="I{field}/run{n2}")
    assert set(log.signals["field"]) == {0.5}


@pytest.mark.parametrize("efforts", [(0.5, 0.6), (0.5, -0.6)])
def test_logs_of_like_efforts_have_one_field(tmp_path: Path, efforts: tuple[float, float]) -> None:
    logs = [
        read(brake(tmp_path / f"run{place}.csv", effort)) for place, effort in enumerate(efforts)
    ]
    assert build_dataset(logs).rows == 800


@pytest.mark.slow
def test_noise_is_no_field(tmp_path: Path) -> None:
    paths = [brake(tmp_path / f"run{place}.csv", 0.0) for place in (1, 2)]
    noise = np.random.default_rng(1).normal(size=(2, TIME.size))
    for path, own in zip(paths, noise, strict=True):
        header, *rows = path.read_text().splitlines()
        noisy = [
            f"{row.rpartition(',')[0]},{effort:g}" for row, effort in zip(rows, own, strict=True)
        ]
        path.write_text("\n".join([header, *noisy]))
    assert build_dataset(list(map(read, paths))).rows == 800


@pytest.mark.slow
def test_logs_at_other_slips_are_not_compared(tmp_path: Path) -> None:
    fast = read(brake(tmp_path / "fast.csv", 2.0, speed=90.0))
    slow = read(brake(tmp_path / "slow.csv", 0.1, speed=3.0))
    assert build_dataset([fast, slow]).rows == 800


@pytest.mark.slow
def test_who_says_that_there_is_no_field_is_not_asked(tmp_path: Path) -> None:
    paths = [brake(tmp_path / f"run{place}.csv", float(place)) for place in (1, 3)]
    assert build_dataset([read(path, field="none") for path in paths]).rows == 800
    with pytest.raises(UnloggedFieldError, match=r"run3\.csv has 3 times the effort of run1\.csv"):
        build_dataset([read(path) for path in paths])


@pytest.mark.slow
def test_logs_of_unlike_efforts_that_are_said_to_have_no_field_are_told(tmp_path: Path) -> None:
    folder_of(tmp_path / "logs", {"idle": 0.2, "loaded": 1.1})
    said = good("inspect", "logs", "--field", "none", cwd=tmp_path)
    assert "no field was given, and at the same slip loaded.csv has" in said
    folder_of(tmp_path / "alike", {"first": 0.2, "second": 0.22})
    assert "no field was given" not in good("inspect", "alike", "--field", "none", cwd=tmp_path)


@pytest.mark.parametrize(
    "names",
    [
        ("run01", "run02"),
        ("1Hz_10mm", "2Hz_10mm"),
        ("brake_25degC", "brake_60degC"),
        ("20240312", "20240313"),
        ("damper1", "damper2"),
        ("0A", "zero"),
        ("x1y2", "x3y5"),
    ],
)
def test_numbers_of_other_things_are_no_field(names: tuple[str, ...]) -> None:
    assert pattern_among(names) == ""


def test_a_unit_with_a_slash_names_no_folder() -> None:
    assert constants_of("ER_{field:kV/mm}kVmm", "ER_2kVmm.csv") == {"field": (2.0, "kV/mm")}
    assert constants_of("I{field}/run{n}", "/lab/I0.5/run3.csv") == {
        "field": (0.5, None),
        "n": (3.0, None),
    }


@pytest.mark.slow
def test_a_plan_and_a_calibration_are_no_logs(tmp_path: Path) -> None:
    logs = folder_of(tmp_path, {"0A": 0.1, "1A": 1.1, "2A": 2.1})
    (logs / "Plan.csv").write_text("file,current_A\n0A.csv,0\n1A.csv,1\n")
    (logs / "calibration.csv").write_text("mass_kg,bridge_mV\n0,0.01\n5,1.01\n10,2.02\n")
    files = sorted(logs.iterdir())
    assert {path.name for path in tables_beside_logs(files)} == {"Plan.csv", "calibration.csv"}
    said = run("inspect", tmp_path, cwd=tmp_path)
    assert "note: Plan.csv, calibration.csv left out" in said.error
    assert said.out.splitlines()[-1].endswith('--name-pattern "{field}A"')


def test_a_short_log_is_no_other_table(tmp_path: Path) -> None:
    folder_of(tmp_path, {"1A": 1.1, "2A": 2.1})
    for name, header in (("short", "t [s],w [rad/s],torque [N*m]"), ("nameless", "t [s],b,c")):
        (tmp_path / f"{name}.csv").write_text(
            f"{header}\n" + "".join(f"{k / 9},{k},{k * k}\n" for k in range(12))
        )
    assert tables_beside_logs(sorted(tmp_path.iterdir())) == []


@pytest.mark.slow
def test_a_run_at_rest_beside_logs_with_a_field_in_their_names_has_its_own_field(
    tmp_path: Path,
) -> None:
    folder_of(tmp_path / "logs", {"brake_1A": 1.1, "brake_2A": 2.1, "rest": 0.1})
    pattern = ("--name-pattern", "brake_{field}A")
    said = good("inspect", "logs", *pattern, cwd=tmp_path, code=1).splitlines()[-1]
    assert "rest.csv: the file's name does not match" in said
    assert 'constants.field = "0.5 A" in a mapping file' in said
    (tmp_path / "logs" / "rest.csv.toml").write_text('constants.field = "0 A"\n')
    assert (
        good("inspect", "logs", *pattern, cwd=tmp_path)
        .splitlines()[-1]
        .startswith("Understood. Fit them")
    )
    paths = sorted((tmp_path / "logs").glob("*.csv"))
    logs = [read(path, name_pattern="brake_{field}A") for path in paths]
    assert [set(log.signals["field"]) for log in logs] == [{1.0}, {2.0}, {0.0}]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_log_without_a_field_beside_one_with_a_field_is_named(
    tmp_path: Path, order: tuple[int, int]
) -> None:
    logs = [read(brake(tmp_path / "brake_1A.csv", 1.1), name_pattern="brake_{field}A")]
    logs.append(read(brake(tmp_path / "rest.csv", 0.1)))
    with pytest.raises(
        MappingError,
        match=r"rest\.csv has no field, and brake_1A\.csv has one in A.*field = \"0 A\"",
    ):
        build_dataset([logs[place] for place in order])


@pytest.mark.slow
def test_hidden_files_and_locks_are_no_logs_and_packed_ones_are(tmp_path: Path) -> None:
    for name, effort in (("1A.csv", 1.1), ("2A.csv", 2.1)):
        text = brake(tmp_path / "logs" / name, effort).read_bytes()
        (tmp_path / "logs" / name).unlink()
        (tmp_path / "logs" / f"{name}.gz").write_bytes(gzip.compress(text))
        (tmp_path / "logs" / f"._{name}").write_bytes(b"\0\5\x16\7Mac OS X")
    (tmp_path / "logs" / "~$plan.xlsx").write_bytes(b"\5alice")
    said = good("inspect", "logs", "--name-pattern", "{field}A", cwd=tmp_path)
    assert [line.split()[0] for line in said.splitlines() if line[:3] in (" 1A", " 2A")] == [
        "1A.csv",
        "2A.csv",
    ]


@pytest.mark.slow
def test_one_log_without_a_field_beside_others_with_a_column_is_settled_by_one_command(
    tmp_path: Path,
) -> None:
    folder_of(tmp_path / "logs", {"1A": 1.1, "2A": 2.1})
    header, *rows = (tmp_path / "logs" / "1A.csv").read_text().splitlines()
    with_field = [f"{header},current [A]", *(f"{row},1" for row in rows)]
    (tmp_path / "logs" / "1A.csv").write_text("\n".join(with_field))
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == 'What settles it: erclutch inspect logs --name-pattern "{field}A"'
    assert "Understood. Fit them" in good(
        "inspect", "logs", "--name-pattern", "{field}A", cwd=tmp_path
    )


@pytest.mark.slow
def test_logs_of_two_devices_are_told_and_each_has_its_command(tmp_path: Path) -> None:
    for device, times in (("A", 1.0), ("B", 3.0)):
        names = {f"brake{device}_{field}A": times * (0.1 + field) for field in (0, 0.5, 1)}
        folder_of(tmp_path / "logs", names)
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    logs = [f"logs/brakeA_{field}A.csv" for field in ("0.5", "0", "1")]
    assert last == (
        f'What settles it: erclutch inspect {" ".join(logs)} --name-pattern "brakeA_{{field}}A"'
    )
    pattern = ("--name-pattern", "brakeA_{field}A")
    assert "two devices" not in good("inspect", *logs, *pattern, cwd=tmp_path)
    for path in (tmp_path / "logs").iterdir():
        path.rename(path.with_name(path.name.replace("A_", "1_").replace("B_", "2_")))
    said = good("inspect", "logs", "--name-pattern", "brake{n}_{field}A", cwd=tmp_path)
    said = " ".join(said.split())
    assert "times the effort of brake1_" in said
    assert "they are of two devices, or of one that changed" in said


PLANS = {
    "plan.csv": "file,current [A]\nrun1.csv,0\nrun2.csv,0.5\n",
    "plan2.csv": "run;Strom [A];Datum\n1;0;3.5.2026\n2;0,5;3.5.2026\n",
    "README.md": "# Runs\n\n| file | current (A) |\n|---|---|\n| run1.csv | 0 |\n| run2.csv | 0.5 |\n",
    "meta.json": '{"run1.csv": {"current_A": 0}, "run2.csv": {"current_A": 0.5}}',
    "list.json": '[{"file": "run1.csv", "current": 0, "unit": "A"}, {"file": "run2.csv", "current": 0.5, "unit": "A"}]',
    "flat.json": '{"current_A": {"run1": 0, "run2": 0.5}}',
    "runs.yaml": "runs:\n  - file: run1.csv\n    current_A: 0\n  - file: run2.csv\n    current_A: 0.5\n",
    "notes.txt": "Measured in May.\n\nrun1: 0 A\nrun2: 0.5 A\n",
}


@pytest.mark.slow
@pytest.mark.parametrize("plan", slow_behind(3, PLANS))
@pytest.mark.parametrize(
    "effort", slow_behind(1, [0.6, 0.12]), ids=["far apart", "near each other"]
)
def test_the_fields_of_a_plan_beside_logs_are_offered_and_one_command_takes_them(
    tmp_path: Path, plan: str, effort: float
) -> None:
    logs = folder_of(tmp_path / "logs", {"run1": 0.1, "run2": effort})
    (logs / plan).write_text(PLANS[plan])
    said = run("inspect", "logs", cwd=tmp_path)
    assert said.code == 1
    assert f"{plan} says run1.csv 0 A, run2.csv 0.5 A" in said.out
    last = 'What settles it: erclutch inspect logs --write-mapping "logs/erclutch.toml"'
    assert said.out.splitlines()[-1] == last
    assert run("fit", "logs", cwd=tmp_path).code == 2
    settled = run("inspect", "logs", "--write-mapping", "logs/erclutch.toml", cwd=tmp_path)
    assert settled.out.splitlines()[-1] == "Understood. Fit them: erclutch fit logs --out RUN"
    fields = [set(read(logs / f"run{number}.csv").signals["field"]) for number in (1, 2)]
    assert fields == [{0.0}, {0.5}]


@pytest.mark.slow
def test_files_of_settings_that_are_called_like_logs_tell_their_fields(tmp_path: Path) -> None:
    logs = folder_of(tmp_path / "logs", {"a": 0.1, "b": 0.6})
    for name, amperes in (("a", 0), ("b", 0.5)):
        text = f'{{"coil_current_A": {amperes}, "operator": "x", "max_current_A": 2}}'
        (logs / f"{name}_meta.json").write_text(text)
    said = run("inspect", "logs", cwd=tmp_path)
    assert "a_meta.json says a.csv 0 A, b.csv 0.5 A" in said.out


@pytest.mark.slow
def test_a_mapping_file_names_the_logs_whose_fields_nothing_says(tmp_path: Path) -> None:
    logs = folder_of(tmp_path / "logs", {"low": 0.1, "high": 0.6})
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.endswith('--write-mapping "logs/erclutch.toml"')
    mapping = logs / "erclutch.toml"
    last = good(
        "inspect", "logs", "--write-mapping", "logs/erclutch.toml", cwd=tmp_path, code=1
    ).splitlines()[-1]
    assert last == "Fill in 2 fields in logs/erclutch.toml, then: erclutch inspect logs"
    assert "the field of high.csv is to be filled in" in refused("fit", "logs", cwd=tmp_path)
    filled = mapping.read_text().replace('"?"', '"0.5 A"', 1).replace('"?"', '"0 A"')
    mapping.write_text(filled)
    good("inspect", "logs", cwd=tmp_path)
    assert set(read(logs / "high.csv").signals["field"]) == {0.5}


@pytest.mark.slow
def test_fields_in_names_without_one_pattern_go_into_a_mapping_file(tmp_path: Path) -> None:
    folder_of(tmp_path / "logs", {"b_0A_slow": 0.1, "b_0.5A_fast": 0.6, "b_1A_slow": 1.1})
    # The pattern of one name was printed, which no other name has.
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == 'What settles it: erclutch inspect logs --write-mapping "logs/erclutch.toml"'
    last = good(*shlex.split(last)[4:], cwd=tmp_path).splitlines()[-1]
    assert last == "Understood. Fit them: erclutch fit logs --out RUN"
    assert '"b_0.5A_fast.csv" = "0.5 A"' in (tmp_path / "logs/erclutch.toml").read_text("utf-8")


@pytest.mark.slow
def test_a_log_whose_name_tells_nothing_has_its_field_filled_in(tmp_path: Path) -> None:
    folder_of(tmp_path / "logs", {"off": 0.1, "on_500mA": 0.6, "on_1A": 1.1})
    last = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()[-1]
    said = good(*shlex.split(last)[4:], cwd=tmp_path, code=1)
    assert said.splitlines()[-1].startswith("Fill in 1 field in logs/erclutch.toml, then:")
    written = (tmp_path / "logs/erclutch.toml").read_text("utf-8")
    assert '"off.csv" = "?"\n"on_1A.csv" = "1 A"\n"on_500mA.csv" = "500 mA"' in written


@pytest.mark.slow
def test_stretches_of_one_file_are_held_against_each_other_too(tmp_path: Path) -> None:
    # Logs at three currents that somebody put into one file: all were one log at one field.
    blocks = [
        brake(tmp_path / f"b{k}.csv", effort).read_text("utf-8")
        for k, effort in enumerate((0.1, 0.6))
    ]
    names = blocks[0].splitlines()[0]
    rows = ["\n".join(block.splitlines()[1:]) for block in blocks]
    (tmp_path / "all.csv").write_text(f"{names}\n" + "\n\n".join(rows) + "\n", encoding="utf-8")
    last = good("inspect", "all.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == 'What settles it: erclutch inspect all.csv --constant "field=NUMBER, NUMBER A"'
    words = shlex.split(last.replace("NUMBER, NUMBER", "0, 0.5"))[4:]
    assert "Understood." in good(*words, cwd=tmp_path).splitlines()[-1]
    log = read(tmp_path / "all.csv", constant="field=0, 0.5 A")
    assert sorted({*log.signals["field"].tolist()}) == [0.0, 0.5]
    assert "field=NUMBER, NUMBER A" in refused("fit", "all.csv", "--out", "run", cwd=tmp_path)
