"""Each joint of a robot is fitted as a device of its own, by the command that inspect prints."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from erclutch.cli import main
from erclutch.errors import MappingError
from erclutch.logs.reading import Reading
from erclutch.wings.fleet.fleet import fit_many
from erclutch.wings.fleet.joints_as_devices import logs_of_joints

pytestmark = pytest.mark.slow

_FRICTIONS = {"waist": 2.0, "shoulder": 5.0, "elbow": 1.0}  # N m


def write_robot(
    path: Path, seed: int = 0, effort: str = "effort", rows: int = 1500, step: float = 0.01
) -> Path:
    """A SYNTHETIC log of three joints with a dry and a viscous friction each."""
    random = np.random.default_rng(seed)
    time = step * np.arange(float(rows))
    columns = {"time [s]" if step < 1.0 else "time": time}
    for place, (joint, friction) in enumerate(_FRICTIONS.items(), start=1):
        rate = np.sin((1.0 + 0.3 * place) * time) + 0.5 * np.sin(0.7 * place * time + seed)
        torque = friction * np.tanh(50.0 * rate) + 0.4 * rate
        columns[f"{joint}_vel [rad/s]"] = rate
        columns[f"{joint}_{effort} [N*m]"] = torque + 0.02 * random.standard_normal(time.size)
    table = np.column_stack([*columns.values()])
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.6f")
    return path


@pytest.fixture
def inspected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> str:
    """What inspect prints of a robot's log, which lies in the working folder as arm.csv."""
    monkeypatch.chdir(tmp_path)
    write_robot(Path("arm.csv"))
    assert main(["inspect", "arm.csv"]) == 0
    return capsys.readouterr().out


def test_the_printed_command_fits_each_joint(
    inspected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    last = inspected.strip().splitlines()[-1]
    command = last.partition("Fit each joint: ")[2]
    assert "3 joints" in inspected
    assert command == "erclutch fit-many arm.csv --by joint --out RUNS"
    assert main([*shlex.split(command)[1:], "--models", "bingham", "--lag", "none", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["devices"] == len(_FRICTIONS)

    # The joints of one robot have frictions of their own: each is found.
    read: Any = pq.read_table
    found: dict[str, float] = {}
    for row in read("RUNS/parameters.parquet").to_pylist():
        if row["parameter"] in ("T_y", "T_f"):
            found[row["device"]] = found.get(row["device"], 0.0) + row["value"]
    assert found == pytest.approx(_FRICTIONS, rel=0.02)


def test_the_printed_command_fits_the_first_joint_alone(
    inspected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (line,) = [line for line in inspected.splitlines() if line.startswith("Of one joint")]
    words = shlex.split(line.partition("alone: ")[2])[1:]
    assert main([*words, "--models", "bingham", "--lag", "none"]) == 0
    assert "waist_vel" in capsys.readouterr().out


def test_json_names_the_joints_and_ends_with_0(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_robot(tmp_path / "arm.csv")
    assert main(["inspect", str(log), "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    assert body["joints"] == [
        {"name": joint, "slip": f"{joint}_vel", "effort": f"{joint}_effort"} for joint in _FRICTIONS
    ]


def test_a_joint_is_fitted_to_all_logs_of_the_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    write_robot(logs / "first.csv")
    write_robot(logs / "second.csv", 1)
    assert main(["inspect", str(logs)]) == 0
    assert f"fit-many {logs} --by joint" in capsys.readouterr().out
    joints = logs_of_joints(sorted(logs.iterdir()), Reading(), "single")
    assert {name: len(each.paths) for name, each in joints.items()} == dict.fromkeys(_FRICTIONS, 2)


def test_a_log_of_other_columns_is_refused(tmp_path: Path) -> None:
    files = [
        write_robot(tmp_path / "first.csv"),
        write_robot(tmp_path / "second.csv", effort="torque"),
    ]
    with pytest.raises(MappingError, match=r"waist has other columns than in first\.csv"):
        logs_of_joints(files, Reading(), "single")


def test_a_log_without_joints_is_refused_with_what_helps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "brake.csv"
    slip = np.sin(0.05 * np.arange(400.0))
    np.savetxt(
        log,
        np.column_stack([slip, np.tanh(9.0 * slip)]),
        delimiter=",",
        header="slip [rad/s],effort [N*m]",
        comments="",
    )
    words = ["fit-many", str(log), "--by", "joint", "--rate", "100 Hz", "--field", "none"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 2
    error = capsys.readouterr().err
    assert "brake.csv: no joints are told apart in it" in error
    assert "--by joint" in error
    assert not (tmp_path / "run").exists()


def test_a_joint_beside_another_question_is_refused_in_the_words_of_that_question(
    tmp_path: Path,
) -> None:
    """Stamps that grow by 1 a row may be ms: joints are told apart, and the clock is in doubt."""
    log = write_robot(tmp_path / "arm.csv", step=1.0)
    with pytest.raises(MappingError, match="though it has no unit") as refused:
        logs_of_joints([log], Reading(), "single")
    assert refused.value.where == "arm.csv"


def test_what_is_asked_about_names_the_file(tmp_path: Path) -> None:
    log = write_robot(tmp_path / "arm.csv")
    text = log.read_text()
    log.write_text(text.replace("elbow_effort", "elbow_weight").replace("waist_vel", "waist"))
    with pytest.raises(MappingError) as refused:
        logs_of_joints([log], Reading(), "single")
    assert refused.value.where == "arm.csv"


def printed(log: Path, capsys: pytest.CaptureFixture[str], *options: str) -> list[str]:
    """The last two lines of inspect, which holds the log for understood."""
    assert main(["inspect", str(log), *options]) == 0
    return capsys.readouterr().out.strip().splitlines()[-2:]


def test_the_printed_commands_keep_what_was_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_robot(tmp_path / "arm.csv")
    alone, each = printed(log, capsys, "--skip", "1 s")
    assert "--skip '1 s'" in alone
    assert "--skip '1 s'" in each


def test_of_few_rows_less_is_held_out_by_the_printed_commands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone, each = printed(write_robot(tmp_path / "arm.csv", rows=60), capsys)
    assert "--test 0.15 --out RUN" in alone
    assert "--by joint --test 0.15 --out RUNS" in each


def test_of_too_few_rows_no_fit_is_offered(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = printed(write_robot(tmp_path / "arm.csv", rows=24), capsys)
    assert "nothing can be fitted" in lines[-1]


def test_processes_give_the_same_table(tmp_path: Path) -> None:
    log = write_robot(tmp_path / "arm.csv")
    here = fit_many(log, ("bingham",), out=tmp_path / "here", by="joint")
    there = fit_many(log, ("bingham",), out=tmp_path / "there", by="joint", cluster="processes")
    assert there.digest == here.digest
