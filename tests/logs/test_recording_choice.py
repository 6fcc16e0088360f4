"""Of several recordings in a file the only log of a device is taken; several logs are asked about, with the command."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, log_file, read, table_of_log
from erclutch.logs.reading import Reading
from tests.support.command import good

ROWS: list[dict[str, Any]] = [
    {"t [s]": k / 100, "speed [rad/s]": (k % 7) - 3.0, "torque [N*m]": (k % 5) - 2.0}
    for k in range(60)
]
RESULTS = [{"k": k, "tau_y [Pa]": 2.0 + k, "R2": 0.9} for k in range(60)]


def written(folder: Path, **recordings: list[dict[str, Any]]) -> Path:
    path = folder / "log.json"
    path.write_text(json.dumps(recordings), encoding="utf-8")
    return path


@pytest.mark.slow
def test_the_only_recording_with_a_motion_and_an_effort_is_the_log(tmp_path: Path) -> None:
    path = written(tmp_path, fits=RESULTS, measured=ROWS, settings=RESULTS[:20])
    table = table_of_log(path, ColumnMap(), None)
    assert "speed" in table.columns
    assert (
        table.notes[0]
        == "recording measured: no other has columns of a motion and an effort (fits, settings)"
    )
    assert read(path).rows == 60


@pytest.mark.slow
def test_several_logs_of_a_file_are_asked_about_with_the_option_that_takes_them(
    tmp_path: Path,
) -> None:
    path = written(tmp_path, run1=ROWS, run2=ROWS[:40], fits=RESULTS)
    with pytest.raises(
        LogError, match=r"2 of 3 recordings of the file are logs: run1, run2.*--variable all; or"
    ):
        table_of_log(path, ColumnMap(), None)
    said = good("inspect", "log.json", cwd=tmp_path, code=1)
    assert said.splitlines()[-1] == "What settles it: erclutch inspect log.json --variable all"
    assert "run2" in good("inspect", "log.json", "--variable", "all", cwd=tmp_path)


@pytest.mark.slow
def test_several_logs_with_one_question_are_settled_by_one_command(tmp_path: Path) -> None:
    rows = [{**row, "mode": k // 20} for k, row in enumerate(ROWS)]
    written(tmp_path, run1=rows, run2=rows, fits=RESULTS)
    last = good("inspect", "log.json", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == 'What settles it: erclutch inspect log.json --variable all --field "mode"'


@pytest.mark.slow
def test_a_question_keeps_the_recording_and_the_window_that_were_given(tmp_path: Path) -> None:
    """Without them the command that settles the one question asks the other one again, for ever."""
    rows = [{**row, "torque 2 [N*m]": (k % 9) - 4.0, "mode": k // 20} for k, row in enumerate(ROWS)]
    written(tmp_path, run1=rows, run2=rows[:40])
    words = ("--variable", "run1", "--from", "0.05s")
    last = good("inspect", "log.json", *words, cwd=tmp_path, code=1).splitlines()[-1]
    command = shlex.split(last.removeprefix("What settles it: erclutch "))
    assert command[-4:] == [*words]
    last = good(*command, cwd=tmp_path).splitlines()[-1]
    assert last.startswith("Understood.")
    assert "erclutch fit log.json --field mode --from 0.05s --variable run1" in last


@pytest.mark.slow
def test_a_file_without_any_log_is_refused_as_before(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="several recordings: fits, more"):
        table_of_log(written(tmp_path, fits=RESULTS, more=RESULTS), ColumnMap(), None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("header", "command"),
    [
        ("t [s],speed [rad/s],torque [N*m],q17", "erclutch inspect log.csv --field none"),
        ("torque [N*m],speed [rad/s],acc,T [°C]", "erclutch inspect log.csv --time none"),
        # Five numbers of an unknown column might be conditions, which are asked about.
        (
            "Shear rate [1/s],Shear stress [Pa],Normal force [N],T [°C]",
            "erclutch flowcurve log.csv",
        ),
        ("t [s],speed [rad/s],acc,T [°C]", 'erclutch inspect log.csv --effort "COLUMN [N*m]"'),
    ],
)
def test_the_last_line_of_inspect_is_the_command_that_settles_it(
    tmp_path: Path, header: str, command: str
) -> None:
    rows = "".join(f"{k / 10},{k % 7 + 0.5},{k % 5 + 0.1},{k * k}\n" for k in range(60))
    (tmp_path / "log.csv").write_text(f"{header}\n{rows}", encoding="utf-8")
    said = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert said.splitlines()[-1] == f"What settles it: {command}"


@pytest.mark.slow
def test_recordings_of_the_same_columns_are_several_logs_at_once(tmp_path: Path) -> None:
    other = [{**row, "speed [rad/s]": (k % 11) - 5.0} for k, row in enumerate(ROWS)]
    path = written(tmp_path, run1=ROWS, run2=other, fits=RESULTS)
    said = good("inspect", "log.json", cwd=tmp_path)
    assert "log.json: run2" in said
    assert said.splitlines()[-1].startswith("Understood. Fit it: erclutch fit log.json --out")
    assert [log.name for log in Reading().read(path, None)] == ["log.json: run1", "log.json: run2"]
    with pytest.raises(LogError, match="--variable all"):  # a single recording is wanted
        read(path)


@pytest.mark.parametrize(
    "other",
    [
        [
            {"t [s]": row["t [s]"], "speed [rpm]": k % 11 - 5.0, "torque [N*m]": 1.0 * k}
            for k, row in enumerate(ROWS)
        ],
        [
            {**row, "torque [N*m]": row["torque [N*m]"] / 2} for row in ROWS
        ],  # one motion twice: filtered, say
    ],
)
def test_recordings_in_other_units_and_copies_of_one_motion_are_asked_about(
    tmp_path: Path, other: Any
) -> None:
    with pytest.raises(LogError, match="2 of 2 recordings of the file are logs"):
        Reading().read(written(tmp_path, run1=ROWS, run2=other), None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beside", "answer"),
    [
        ({}, "--time none"),
        ({"t [s]": None, "mode": None}, '--field "mode"'),
    ],
)
def test_the_command_for_one_recording_of_several_answers_what_is_asked_about_it(
    tmp_path: Path, beside: dict[str, None], answer: str
) -> None:
    rows = [{**row, "mode": k // 20} for k, row in enumerate(ROWS)]
    wanted = [*beside, "speed [rad/s]", "torque [N*m]"]
    first = [{name: row[name] for name in wanted} for row in rows]
    other = [{**row, "speed [rad/s]": None, "speed [rpm]": k % 7} for k, row in enumerate(first)]
    for row in other:
        del row["speed [rad/s]"]
    written(tmp_path, run1=first, run2=other)
    last = good("inspect", "log.json", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.startswith("What settles it: erclutch inspect log.json ")
    assert answer in last
    assert "--variable" in last
    command = shlex.split(last.removeprefix("What settles it: erclutch "))
    assert good(*command, cwd=tmp_path).splitlines()[-1].startswith("Understood.")


@pytest.mark.slow
def test_without_a_log_the_recording_nearest_to_one_is_named(tmp_path: Path) -> None:
    # Nothing in any recording is called like an effort.
    nearest = [{key: value for key, value in row.items() if "torque" not in key} for row in ROWS]
    path = written(tmp_path, settings=RESULTS[:20], short=nearest[:30], rows=nearest)
    with pytest.raises(LogError, match="Choose one, such as --variable rows, or"):
        table_of_log(path, ColumnMap(), None)


@pytest.mark.slow
def test_of_very_many_recordings_the_first_are_looked_into_and_one_is_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_file, "_MOST", 5)
    monkeypatch.setattr(log_file, "_FIRST_OF_MANY", 3)
    rows = [{**row, "mode": k // 20} for k, row in enumerate(ROWS)]
    others = {f"run{number}": rows for number in range(9)}
    path = written(tmp_path, settings=RESULTS[:20], **others)
    with pytest.raises(LogError, match="Choose one, such as --variable run0, or"):
        table_of_log(path, ColumnMap(), None)
    last = good("inspect", "log.json", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.endswith("--variable run0") or '--variable "run0"' in last
    command = shlex.split(last.removeprefix("What settles it: erclutch "))
    assert good(*command, cwd=tmp_path).splitlines()[-1].startswith("Understood.")
    assert log_file.looked_into(["a"] * 6) == ["a"] * 3
    assert log_file.looked_into(["a"] * 5) == ["a"] * 5
