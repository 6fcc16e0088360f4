"""A folder with a file for each signal, or several files that are named, is one log, put together by time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.cli.options import expand
from erclutch.errors import ErclutchError, LogError
from erclutch.logs import read, read_table
from tests.support.command import good
from tests.support.slow_params import slow_behind

FAST, SLOW = np.arange(2000) / 1000, np.arange(-10, 230) / 100 + 0.0003
CURRENT = np.repeat([0.0, 0.5, 1.0], 80)
SPEED, TORQUE = np.sin(9 * FAST), np.sin(9 * FAST + 0.2) ** 3


def text_of(time: np.ndarray, values: np.ndarray, head: str) -> str:
    return head + "\n" + "".join(f"{t:.9g},{v:.9g}\n" for t, v in zip(time, values, strict=True))


def folder_of(
    folder: Path,
    heads: tuple[str, str, str] = (
        "time [s],current [A]",
        "time [s],speed [rad/s]",
        "time [s],torque [N*m]",
    ),
) -> Path:
    """The same three signals, which is what is right."""
    folder.mkdir()
    signals = {"current": (SLOW, CURRENT), "speed": (FAST, SPEED), "torque": (FAST, TORQUE)}
    for (name, (time, values)), head in zip(signals.items(), heads, strict=True):
        (folder / f"{name}.csv").write_text(text_of(time, values, head), encoding="utf-8")
    return folder


def holds_the_truth(path: Path) -> None:
    log = read(path)
    np.testing.assert_allclose(log.signals["effort"], TORQUE, atol=1e-8)
    np.testing.assert_allclose(log.signals["slip"], SPEED, atol=1e-8)
    held = CURRENT[np.searchsorted(SLOW, FAST, side="right") - 1]
    np.testing.assert_array_equal(log.signals["field"], held)
    assert log.period == pytest.approx(1e-3)
    assert {name: log.units[name] for name in ("field", "slip", "effort")} == {
        "field": "A",
        "slip": "rad/s",
        "effort": "N*m",
    }


@pytest.mark.slow
def test_a_folder_with_a_file_for_each_signal(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run")
    holds_the_truth(folder)
    notes = read_table(folder).notes
    assert (
        "recordings joined at the times of file torque.csv: torque.csv, speed.csv, current.csv"
        in notes
    )
    assert "column current of current.csv: each value held until the next" in notes
    assert "column speed of speed.csv: at the same times" in notes
    assert "the clocks of the files are taken for one clock" in notes


@pytest.mark.slow
def test_files_that_are_named_are_one_log(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run")
    files = sorted(folder.iterdir())
    assert expand(files) == [folder / "current.csv + speed.csv + torque.csv"]
    assert expand([folder]) == [folder]
    holds_the_truth(expand(files)[0])


@pytest.mark.slow
def test_inspect_shows_the_log_of_several_files(tmp_path: Path) -> None:
    said = good("inspect", *sorted(folder_of(tmp_path / "run").iterdir()))
    assert "slip <- column speed [rad/s]" in said
    assert "column current of current.csv: each value held until the next" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    "heads",
    [
        ("t [s],value [A]", "t [s],value [rad/s]", "t [s],value [N*m]"),
        ("time,value [A]", "time,value [rad/s]", "time,value [N*m]"),
        ("time [s],I [A]", "time [s],omega [rad/s]", "time [s],M [Nm]"),
    ],
)
def test_a_column_without_a_name_has_that_of_its_file(
    tmp_path: Path, heads: tuple[str, str, str]
) -> None:
    holds_the_truth(folder_of(tmp_path / "run", heads))


@pytest.mark.slow
def test_times_in_other_units_are_converted(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run")
    (folder / "current.csv").write_text(
        text_of(SLOW * 1e3, CURRENT, "time [ms],current [A]"), encoding="utf-8"
    )
    holds_the_truth(folder)


@pytest.mark.slow
def test_a_time_since_1970_stays_one(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run")
    for name, time, values in (
        ("current", SLOW, CURRENT),
        ("speed", FAST, SPEED),
        ("torque", FAST, TORQUE),
    ):
        rows = "".join(f"{t + 1.79e9:.6f},{v:.9g}\n" for t, v in zip(time, values, strict=True))
        (folder / f"{name}.csv").write_text(
            f"time [s],{name} [{dict(current='A', speed='rad/s', torque='N*m')[name]}]\n" + rows
        )
    log = read(folder)
    np.testing.assert_allclose(log.signals["slip"], SPEED, atol=1e-4)
    np.testing.assert_allclose(log.signals["effort"], TORQUE, atol=1e-8)


# --- what is asked or refused -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("head", "time", "words"),
    slow_behind(
        2,
        [
            (
                "time,current [A]",
                SLOW * 1e3,
                r"the time of current.csv has no unit, and that of speed.csv is in s",
            ),
            ("time [s],current [A]", SLOW + 5, r"the files share 0 s of the 2.39 s of current.csv"),
            ("time [ms],current [A]", SLOW, r"the files share"),
            ("time [s],current [A]", SLOW[::-1], r"the files share|no time that grows"),
        ],
    ),
)
def test_times_that_do_not_fit_are_refused(
    tmp_path: Path, head: str, time: np.ndarray, words: str
) -> None:
    folder = folder_of(tmp_path / "run")
    (folder / "current.csv").write_text(text_of(time, CURRENT, head), encoding="utf-8")
    with pytest.raises(LogError, match=words):
        read_table(folder)


@pytest.mark.slow
def test_dates_are_refused_since_each_file_counts_from_its_own_first_row(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run")
    rows = "".join(f"2024-05-01 10:00:{i / 100:09.6f},{i}\n" for i in range(200))
    (folder / "current.csv").write_text("time,current [A]\n" + rows, encoding="utf-8")
    with pytest.raises(LogError, match=r"current.csv has no column of times in numbers"):
        read_table(folder / "current.csv + speed.csv + torque.csv")


@pytest.mark.slow
def test_a_cell_that_cannot_be_read_stops_the_log(tmp_path: Path) -> None:
    """A current that is left out would be a log without a field."""
    folder = folder_of(tmp_path / "run")
    text = (folder / "current.csv").read_text(encoding="utf-8").splitlines()
    text[-1] = "2.2903,what"
    (folder / "current.csv").write_text("\n".join(text), encoding="utf-8")
    with pytest.raises(ErclutchError, match="current"):
        read(folder)


WORDS = "Tests of 3 May\n\ntorque.csv is in N m.\nspeed.csv at 1000 Hz, current.csv at 100 Hz\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", slow_behind(1, ["README.txt", "Notizen.txt", "bench.log"]))
def test_words_about_the_files_of_a_folder_are_left_out_with_a_word(
    tmp_path: Path, name: str
) -> None:
    folder = folder_of(tmp_path / "test 3")
    (folder / name).write_text(WORDS, encoding="utf-8")
    holds_the_truth(folder)
    assert f"{name} holds words and no rows of numbers: left out" in read(folder).notes


def test_words_beside_logs_are_left_out_with_a_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(
        f"{t:.3f},{v:.6f},{f:.6f}\n" for t, v, f in zip(FAST, SPEED, TORQUE, strict=True)
    )
    for name in ("one.csv", "two.csv"):
        (tmp_path / name).write_text(
            f"time [s],speed [rad/s],torque [N*m]\n{rows}", encoding="utf-8"
        )
    (tmp_path / "README.txt").write_text(WORDS, encoding="utf-8")
    assert [path.name for path in expand([tmp_path])] == ["one.csv", "two.csv"]
    said, noted = capsys.readouterr()
    assert (said, noted) == ("", "note: README.txt left out: words and no rows of numbers\n")


@pytest.mark.parametrize("gap", [" ", "   ", "\t", ",", ";", " ; ", "|"])
def test_small_logs_without_names_are_no_words_whatever_divides_their_cells(
    tmp_path: Path, gap: str
) -> None:
    for number in (1, 2):
        rows = [gap.join(f"{v:.7e}" for v in (0.005 * k, 1e-3 * k, -1.2 * k)) for k in range(40)]
        (tmp_path / f"run{number}.txt").write_text("\n".join(["", *rows, ""]), encoding="utf-8")
    (tmp_path / "LICENSE.txt").write_text(
        "Taken on a rig. All rights of version 3 are kept.\n", encoding="utf-8"
    )
    assert [path.name for path in expand([tmp_path])] == ["run1.txt", "run2.txt"]


def test_a_folder_of_logs_stays_a_folder_of_logs(tmp_path: Path) -> None:
    for run in (1, 2):
        rows = "".join(
            f"{t:.9g},0.5,{v:.9g},{m:.9g}\n" for t, v, m in zip(FAST, SPEED, TORQUE, strict=True)
        )
        (tmp_path / f"run{run}.csv").write_text(
            "time [s],current [A],speed [rad/s],torque [N*m]\n" + rows
        )
    files = sorted(tmp_path.iterdir())
    assert expand([tmp_path]) == files
    assert expand(files) == files
    with pytest.raises(LogError, match="this is a folder"):
        read_table(tmp_path)


@pytest.mark.slow
def test_runs_of_one_signal_are_not_put_together(tmp_path: Path) -> None:
    for run in (1, 2):
        (tmp_path / f"run{run}.csv").write_text(
            text_of(FAST, TORQUE, "time [s],torque [N*m]"), encoding="utf-8"
        )
    files = sorted(tmp_path.iterdir())
    assert expand([tmp_path]) == files
    assert expand(files) == files


def test_what_learn_writes_beside_its_logs_is_no_log(tmp_path: Path) -> None:
    """`inspect FOLDER` of what `live --program learn` leaves asked for the field of learn.json."""
    for name in ("round1.csv", "round2.csv"):
        (tmp_path / name).write_text("time,field,slip,effort\n0,0,1,2\n1,0,1,2\n", encoding="utf-8")
    (tmp_path / "learn.json").write_text(
        '{"rig": "twin-brake", "rounds": [{"number": 1}]}', encoding="utf-8"
    )
    assert [path.name for path in expand([tmp_path])] == ["round1.csv", "round2.csv"]
