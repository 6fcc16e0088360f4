"""The command line as a user meets it: on files, with what it says and its exit codes."""

from __future__ import annotations

import io
import json
import math
import os
import platform
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.cli import main, terminal
from erclutch.fit.laws.fit_law import Estimate
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.html.printed_page import browser
from tests.support.command import good, refused
from tests.support.compared_once import compare_once

COMMAND = (sys.executable, "-m", "erclutch")
QUICK = ("--models", "quadratic", "--lag", "none")

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("made") / "log.csv"
    write_synthetic_log(path, 2.0)
    return path


@pytest.fixture
def log(made: Path, tmp_path: Path) -> Path:
    """A small log in a folder of its own, in which commands run."""
    return Path(shutil.copy(made, tmp_path / "log.csv"))


# --- good input -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_without_a_command_it_says_what_to_do(tmp_path: Path) -> None:
    """In a process of its own, as a user meets it; what others do here is done inside this process."""
    done = subprocess.run(COMMAND, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert good(cwd=tmp_path) == done.stdout
    said = done.stdout
    assert "What to do first" in said
    for command in ("inspect LOG", "fit LOG", "laws"):
        assert f"erclutch {command}" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [(), ("inspect",), ("fit",), ("report",), ("compare",), ("figure",), ("laws",)]
)
def test_help(command: tuple[str, ...], tmp_path: Path) -> None:
    assert "Usage: " in good(*command, "--help", cwd=tmp_path)


def test_version(tmp_path: Path) -> None:
    from erclutch import __version__

    first, *rest = good("--version", cwd=tmp_path).splitlines()
    assert first == __version__
    assert f"numpy {np.__version__}" in rest[1]
    assert platform.python_version() in rest[0]
    assert rest[2].startswith("C compiler: ")


def test_version_cites_what_the_file_cites(tmp_path: Path) -> None:
    listed = " ".join((ROOT / "CITATION.cff").read_text(encoding="utf-8").split())
    cited = " ".join(good("--version", cwd=tmp_path).partition("To cite:")[2].split())
    said = re.fullmatch(
        r"(.*)\. (.*), version (.*)\. Software, (.*)\. (\w+) and (\w+)\. (.*)\.", cited
    )
    assert said is not None
    authors, name, version, licence, *writers, title = said.groups()
    assert f"title: {name} version: {version} license: {licence}" in listed
    assert f"- name: {authors} " in listed
    assert f"title: {title} authors:" in listed
    assert all(f"family-names: {writer}" in listed for writer in writers)


@pytest.mark.slow
def test_bash_completes_commands_options_and_choices(tmp_path: Path) -> None:
    script = tmp_path / "erclutch.bash"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(tmp_path))
        good("--install-completion", "--shell", "bash", "--output", script, cwd=tmp_path)
    assert str(script) in (tmp_path / ".bashrc").read_text()
    asked = {"fi": "fit", "fit log.csv --mod": "--models", "export run --precision fl": "float32"}
    for words, wanted in asked.items():
        code = (
            f". {script}; COMP_WORDS=(erclutch {words}); COMP_CWORD={len(words.split())}; _erclutch"
        )
        said = subprocess.check_output(
            ["bash", "-c", f'{code}; echo "${{COMPREPLY[@]}}"'], text=True
        )
        assert wanted in said.split(), words


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shell", "ask"),
    [
        (
            "fish",
            'source {script}; complete -C "erclutch fi"; complete -C "erclutch export run --precision fl"',
        ),
        (
            "zsh",
            "fpath=({script.parent} $fpath); autoload -Uz compinit; compinit -u; autoload +X _erclutch; functions",
        ),
    ],
)
def test_other_shells_know_commands_and_choices(shell: str, ask: str, tmp_path: Path) -> None:
    """fish is asked as a user asks it; zsh completes only in a terminal, so its function is looked at."""
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    script = tmp_path / "_erclutch"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(tmp_path))
        good("--install-completion", "--shell", shell, "--output", script, cwd=tmp_path)
        flag = ["-f"] if shell == "zsh" else []
        done = subprocess.run(
            [shell, *flag, "-c", ask.format(script=script)],
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    assert all(word in done.stdout for word in ("fit", "float32")), done.stdout + done.stderr
    assert not done.stderr


@pytest.mark.slow
def test_inspect(log: Path) -> None:
    said = good("inspect", log, cwd=log.parent)
    assert said.splitlines()[-1] == f"Understood. Fit it: erclutch fit {log} --out RUN"
    assert "log.csv: 2,000 rows, 4 columns" in said
    assert "effort <- column torque [N*m] (guessed from its name)" in said
    body = json.loads(good("inspect", log, "--json", cwd=log.parent))
    assert body["problem"] is None
    assert body["rows"] == 2000
    assert body["columns"]["torque"]["unit"] == "N*m"


@pytest.mark.slow
def test_inspect_offers_what_two_shafts_differ_by_as_a_column(tmp_path: Path) -> None:
    slip = 2.0 * np.sin(0.03 * np.arange(600))
    driving = 50.0 + 5.0 * np.sin(0.01 * np.arange(600))
    columns = zip(np.arange(600) / 100, driving, driving - slip, np.tanh(5.0 * slip), strict=True)
    rows = [",".join(map(str, row)) + "\n" for row in columns]
    (tmp_path / "log.csv").write_text(
        "time [s],n_in [rpm],n_out [rpm],torque [N*m]\n" + "".join(rows)
    )
    body = json.loads(good("inspect", "log.csv", "--json", "--field", "none", cwd=tmp_path))
    assert body["choices"]["slip"]["column"] == "n_in - n_out"
    made = body["columns"]["n_in - n_out"]
    assert made["unit"] == "rpm"
    assert made["max"] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.slow
def test_inspect_of_a_folder_shows_each_log_and_what_all_of_them_cover(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    for k, seconds in enumerate((2.0, 3.0)):
        write_synthetic_log(tmp_path / "logs" / f"day{k}.csv", seconds, seed=k)
    said = good("inspect", "logs", cwd=tmp_path)
    assert "2 logs; columns and signals are shown of the first" in said
    assert [line.split()[1] for line in said.splitlines() if line.startswith(" day")] == [
        "2,000",
        "3,000",
    ]
    body = json.loads(good("inspect", "logs/day0.csv", "logs/day1.csv", "--json", cwd=tmp_path))
    assert body["rows"] == 2000
    assert [(each["name"], each["rows"]) for each in body["further"]] == [("day1.csv", 3000)]
    (tmp_path / "logs" / "other.csv").write_text("a,b\n1,2\n2,3\n3,4\n")
    said = good("inspect", "logs", cwd=tmp_path, code=1)
    assert said.splitlines()[-1].startswith("Not understood yet: other.csv: ")
    assert [line.split()[1] for line in said.splitlines() if line.startswith(" day")] == [
        "2,000",
        "3,000",
    ]
    body = json.loads(good("inspect", "logs", "--json", cwd=tmp_path, code=1))
    assert list(body["refused"]) == ["other.csv"]


@pytest.mark.slow
def test_inspect_of_logs_in_different_units_shows_each_and_says_so(tmp_path: Path) -> None:
    for unit in ("A", "V"):
        lines = [f"{k / 100},{k % 2},{k % 7 - 3},{k % 5}\n" for k in range(60)]
        (tmp_path / f"{unit}.csv").write_text(
            f"t [s],field [{unit}],slip [rad/s],torque [N*m]\n" + "".join(lines)
        )
    said = good("inspect", "A.csv", "V.csv", cwd=tmp_path, code=1)
    assert "2 logs; columns and signals are shown of the first" in said
    # The heading has the unit of the first log: the other field says that it is in another.
    assert "field [A]" in said
    of_the_second = next(line for line in said.splitlines() if line.startswith(" V "))
    assert "0 .. 1 [V]" in of_the_second
    assert "units differ" in said.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rows", "answer"),
    [
        (72, "Understood. Fit it: erclutch fit log.csv --out RUN"),
        (
            64,
            "Understood. Fit it, and hold out less than usual, for the rows are few: erclutch fit log.csv --test 0.2",
        ),
        (
            51,
            "Understood, but nothing can be fitted to it: 51 rows are too few: a fit trains on 50",
        ),
    ],
)
def test_inspect_says_what_a_fit_of_few_rows_holds_out(
    tmp_path: Path, rows: int, answer: str
) -> None:
    lines = [f"{k / 100},{np.sin(k):.5f},{np.tanh(9 * np.sin(k)):.5f}\n" for k in range(rows)]
    (tmp_path / "log.csv").write_text("time_s,velocity_rad_s,torque_Nm\n" + "".join(lines))
    last = good("inspect", "log.csv", cwd=tmp_path).splitlines()[-1]
    assert last.startswith(answer)
    if "--test" in last:
        fit = shlex.split(last.partition(": erclutch ")[2])
        good(*fit, "--models", "bingham", cwd=tmp_path)


@pytest.mark.slow
def test_inspect_asks_about_a_guess_that_rests_on_little_and_names_the_command(
    tmp_path: Path,
) -> None:
    lines = [f"{k / 100},{0.5 + 0.4 * np.sin(k)},{k % 7 - 3},{k % 5}\n" for k in range(80)]
    (tmp_path / "log.csv").write_text("t [s],q7 [V],slip [rad/s],torque [N*m]\n" + "".join(lines))
    last = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.startswith("In doubt: field is column q7 by its unit alone")
    command = shlex.split(last.partition("say so: erclutch ")[2])
    settled = good(*command, cwd=tmp_path)
    assert "field <- column q7 [V] (given)" in settled
    assert (
        settled.splitlines()[-1]
        == "Understood. Fit it: erclutch fit log.csv --field 'q7 [V]' --out RUN"
    )


@pytest.mark.slow
def test_a_section_begins_on_the_clock_that_inspect_shows(tmp_path: Path) -> None:
    lines = [f"{100 + k / 100},{k % 2},{k % 7 - 3},{k % 5}\n" for k in range(600)]
    (tmp_path / "log.csv").write_text(
        "t [s],field [V],slip [rad/s],torque [N*m]\n" + "".join(lines)
    )
    good("inspect", "log.csv", "--plots", "drawn", "--start", "102", cwd=tmp_path)
    (numbers,) = (tmp_path / "drawn").glob("*section*.csv")
    text = numbers.read_text(encoding="utf-8")
    assert len(text.splitlines()) > 90
    assert "--start 107 s" in refused(
        "inspect", "log.csv", "--plots", "other", "--start", "107", cwd=tmp_path
    )


@pytest.mark.slow
def test_a_prediction_is_no_measurement(tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv", 2.0)
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run", cwd=tmp_path)
    for name in ("told.csv", "told.parquet"):
        good("predict", "log.csv", "--run", "run", "--out", name, cwd=tmp_path)
        said = refused("score", name, "--run", "run", cwd=tmp_path)
        assert (
            said
            == f"error: {name}: its effort is predicted, not measured. Give the measured log.\n"
        )


@pytest.mark.slow
def test_inspect_of_what_is_not_understood_yet(log: Path) -> None:
    body = json.loads(good("inspect", log, "--json", "--effort", "nope", cwd=log.parent, code=1))
    assert "there is no column 'nope'" in body["problem"]
    assert body["missing"] == ["there is no column 'nope' for effort"]
    said = good("inspect", log, "--effort", "nope", cwd=log.parent, code=1)
    assert "Not understood yet: " in said
    assert f"erclutch inspect {log} --write-mapping {log}.toml" in " ".join(said.split())


@pytest.mark.slow
def test_all_that_is_missing_is_asked_for_at_once(tmp_path: Path) -> None:
    table = np.random.default_rng(0).standard_normal((100, 4)) + [
        [5 * row, 0, 0, 0] for row in range(100)
    ]
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header="q1,q2,q3,q4", comments="")
    told = good("inspect", "log.csv", "--json", "--invalid", "drop", cwd=tmp_path, code=1)
    problem = json.loads(told)["problem"]
    assert problem.startswith(
        "log.csv: 4 things are missing: (1) no time column and no sampling rate; (2) no column"
    )
    command = problem.partition("in place of these: erclutch ")[2].partition("; --field none")[0]
    words = shlex.split(command)
    for place, column in zip(
        [k for k, word in enumerate(words) if "COLUMN" in word], range(1, 5), strict=True
    ):
        words[place] = words[place].replace("COLUMN", f"q{column}")
    assert "slip <- column q3" in good(*words, cwd=tmp_path)
    good(*words, "--write-mapping", "log.toml", cwd=tmp_path)
    assert "slip <- column q3 [cm/s], converted to m/s (log.toml)" in good(
        "inspect", "log.csv", cwd=tmp_path
    )
    again = refused(*words, "--write-mapping", "log.toml", cwd=tmp_path)
    assert "there is such a file" in again


@pytest.mark.slow
def test_a_mapping_with_something_missing_is_valid_and_says_what(tmp_path: Path) -> None:
    rows = [f"{k},{k % 7},{k % 5}" for k in range(50)]
    (tmp_path / "log.csv").write_text(
        "\n".join(["t [ms],Strom [A],Kraft (V)", *rows]), encoding="utf-8"
    )
    said = good("inspect", "log.csv", "--write-mapping", "half.toml", cwd=tmp_path, code=1)
    place = "Mapping written: half.toml; 2 to fill in. It is read once it lies beside the log as log.csv.toml"
    assert place in " ".join(said.split())
    no_option = refused("inspect", "log.csv", "--mapping", "half.toml", cwd=tmp_path)
    assert "it is read where it lies beside LOG" in no_option
    text = (tmp_path / "half.toml").read_text(encoding="utf-8")
    assert tomllib.loads(text)["columns"] == {"field": {"column": "Strom", "unit": "A"}}
    assert "# missing: no column for slip or position" in text
    words = (
        "--effort",
        "Kraft",
        "--scale",
        "effort=2 kN/V",
        "--position",
        "Strom [mm]",
        "--constant",
        "field=1 A",
    )
    said = good(
        "inspect",
        "log.csv",
        *words,
        "--from",
        "10ms",
        "--until",
        "0.03s",
        "--skip",
        "5 ms",
        cwd=tmp_path,
    )
    assert "effort <- column Kraft [V], times 2 kN/V (given)" in said
    assert "taken from 0.01 s to 0.03 s: 21 of 50 rows" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("fit",), "LOG is missing. Write: erclutch fit LOG... [OPTIONS]"),
        (
            ("predict", "log.csv", "--run", "run"),
            "--out is missing. Write: erclutch predict LOG... --run RUN --out OUT",
        ),
        (("fit", "log.csv", "--out"), "--out needs a value: see erclutch fit --help."),
    ],
)
def test_a_command_says_what_it_lacks(words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    assert said in " ".join(refused(*words, cwd=tmp_path).split())


@pytest.mark.slow
def test_fit_prints_eight_models_and_all_of_them_where_asked(
    log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both print one comparison: what is printed of it differs, not what is fitted."""
    compare_once(monkeypatch)
    short = good(
        "fit", log, "--models", "paper", "bingham/critical", "--lag", "none", cwd=log.parent
    )
    whole = good(
        "fit",
        log,
        "--models",
        "paper",
        "bingham/critical",
        "--lag",
        "none",
        "--all",
        cwd=log.parent,
    )
    rows = re.compile(r"^ [ *] +m\d+ ", re.MULTILINE)
    assert len(rows.findall(short)) == 8
    assert "more models: --all shows every one, with its notes." in short
    assert len(rows.findall(whole)) > 8
    assert "m1 is " in whole
    assert "m1 is " not in short
    # The first screen of a terminal has the verdict, the eight models and the notes; how the log was read stands below.
    screen = short.splitlines()[:24]
    verdict = " ".join(" ".join(screen[2:4]).split())  # a narrow terminal breaks it
    assert re.match(
        r"m\d+, .+, is recommended: it errs by \S+ N\*m over the rows held out", verdict
    )
    assert len(rows.findall("\n".join(screen))) == 8
    assert any("more models: --all" in line for line in screen)
    assert (
        short.index("more models")
        < short.index("How the log was read:")
        < short.index("effort <- column")
    )


@pytest.mark.slow
def test_fit_keeps_a_run(log: Path) -> None:
    said = good("fit", log, *QUICK, "--out", "run", cwd=log.parent)
    assert "fitted on 1,400 rows, scored on 600 rows held out" in said
    assert "Models on the rows held out" in said
    assert "Kept in run" in said
    assert sorted(p.name for p in (log.parent / "run").iterdir()) == [
        "models",
        "predictions.parquet",
        "run.json",
        "table.csv",
    ]
    there = refused("fit", log, *QUICK, "--out", "run", cwd=log.parent)
    assert there == "error: run: there is a run already. Give --out another name, or --force.\n"
    good("fit", log, *QUICK, "--out", "run", "--force", cwd=log.parent)


@pytest.mark.slow
def test_fit_as_json_is_run_json(log: Path) -> None:
    body: dict[str, Any] = json.loads(
        good("fit", log, *QUICK, "--out", "run", "--json", cwd=log.parent)
    )
    kept = json.loads((log.parent / "run" / "run.json").read_text())
    assert sorted(kept.pop("files")) == ["predictions.parquet", "table.csv"]
    kept.pop("digest")
    assert body == kept
    assert [entry["name"] for entry in body["ranking"]] == ["quadratic"]


@pytest.mark.slow
def test_fit_of_a_folder_and_of_logs_by_pattern(log: Path) -> None:
    folder = log.parent / "logs"
    folder.mkdir()
    for seed, name in enumerate(("a1.csv", "a2.csv", "b1.csv")):
        write_synthetic_log(folder / name, 2.0, seed)
    body = json.loads(good("fit", "logs", *QUICK, "--test", "b*", "--json", cwd=log.parent))
    assert [entry["name"] for entry in body["logs"]] == ["a1.csv", "a2.csv", "b1.csv"]
    assert (body["train_rows"], body["test_rows"]) == (4000, 2000)
    body = json.loads(good("fit", "logs/a1.csv", *QUICK, "--test", "25%", "--json", cwd=log.parent))
    assert body["test_rows"] == 500


@pytest.mark.slow
def test_several_models_by_comma_or_space(log: Path) -> None:
    for models in (("quadratic,on-off",), ("quadratic", "on-off")):
        body = json.loads(
            good("fit", log, "--lag", "none", "--json", "--models", *models, cwd=log.parent)
        )
        assert {entry["name"] for entry in body["ranking"]} == {"quadratic", "on-off"}


@pytest.mark.slow
def test_laws(tmp_path: Path) -> None:
    assert "bingham/critical" in good("laws", cwd=tmp_path)
    body = json.loads(good("laws", "--json", cwd=tmp_path))
    assert {"on-off", "quadratic", "hem", "rbfm-2"} <= {law["name"] for law in body}
    assert all(law["equation"] and law["parameters"] and law["source"] for law in body)


# --- bad input --------------------------------------------------------------------------------------------------------

HEAD = "time [s],field [V],slip [rad/s],torque [N*m]\n"


def rows_text(count: int = 200, replace: dict[tuple[int, int], str] | None = None) -> str:
    """A log, with some cells (row, column) replaced."""
    rng = np.random.default_rng(0)
    lines = []
    for k in range(count):
        cells = [
            f"{k / 1000:.3f}",
            f"{100 * (k // 10 % 7)}",
            f"{rng.normal():.4f}",
            f"{rng.normal():.4f}",
        ]
        for (row, column), text in (replace or {}).items():
            if row == k:
                cells[column] = text
        lines.append(",".join(cells) + "\n")
    return HEAD + "".join(lines)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["the file is empty", "Give a log"]),
        (
            rows_text(replace={(50, 2): "stalled"}),
            ["line 52, column slip is 'stalled'", "--invalid drop"],
        ),
        (
            rows_text(replace={(k, 3): "nan" for k in range(50, 200, 5)}),
            ["column torque has 30 values missing", "row 51", "--invalid drop"],
        ),
        (
            rows_text(replace={(50, 1): "inf"}),
            ["column field has 1 value", "infinit", "row 51", "--invalid drop"],
        ),
        (rows_text(1), ["only 1 row of data", "Give a longer log"]),
        (rows_text(60), ["42 rows to train on, at least 50", "--test"]),
        (
            rows_text(replace={(k, 2): "0" for k in range(200)}),
            ["slip is constant at 0", "right column"],
        ),
        (
            rows_text(replace={(100, 0): "0.01"}),
            ["runs backwards at data row 101", "0.01 s after 0.099 s"],
        ),
    ],
    ids=[
        "empty",
        "text",
        "nan",
        "infinity",
        "one row",
        "few rows",
        "constant slip",
        "time backwards",
    ],
)
def test_bad_logs(text: str, words: list[str], tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text(text)
    said = refused("fit", "bad.csv", *QUICK, "--out", "run", cwd=tmp_path)
    assert "bad.csv: " in said
    for word in words:
        assert word in said


@pytest.mark.slow
def test_an_error_is_a_line_in_a_process_of_its_own_too(tmp_path: Path) -> None:
    done = subprocess.run(
        [*COMMAND, "fit", "gone.csv"], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == refused("fit", "gone.csv", cwd=tmp_path)


@pytest.mark.slow
def test_random_bytes_named_mat(tmp_path: Path) -> None:
    (tmp_path / "noise.mat").write_bytes(np.random.default_rng(0).bytes(10_000_000))
    said = refused("fit", "noise.mat", *QUICK, "--out", "run", cwd=tmp_path)
    assert "noise.mat: this is neither a MATLAB v4 or v5 nor a v7.3 file" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--effort", "nope"), ["log.csv", "there is no column 'nope' for effort", "torque [N*m]"]),
        (
            ("--effort", "torque [m]"),
            ["log.csv", "unit 'm', which does not fit effort", "N*m, N, Pa"],
        ),
        (("--effort", "torque [furlong]"), ["furlong"]),
        (("--models", "binghm"), ["unknown law 'binghm'", "Did you mean bingham?"]),
        (("--models", "foo"), ["unknown law 'foo'", "rbfm-N, fnn-N, rbfn-N"]),
        (("--models", "rbfm-1"), ["1 kernels", "2 to 100"]),
        (("--models", "bingham/cube"), ["unknown yield stress 'cube'"]),
        (("--test", "1.5"), ["a test share of 1.5", "above 0 and below 0.9"]),
        (("--test", "0"), ["a test share of 0.0"]),
        (("--test", "nan"), ["a test share of nan"]),
        (("--test", "*no*"), ["the test pattern '*no*' matches none of 1 logs", "log.csv"]),
        (("--blocks", "1"), ["--blocks 1"]),
        (("--blocks", "500"), ["--blocks 500"]),
        (("--workers", "0"), ["--workers 0"]),
        (("--seed", "-1"), ["--seed -1"]),
        (("--rate", "abc"), ["rate is 'abc'", "Hz"]),
        (("--constant", "field=much"), ["field is 'much'"]),
        (
            ("--field", "field", "--constant", "field=1 V"),
            ["field is given as a column and as a constant"],
        ),
        (("--map", "nowhere.toml"), ["nowhere.toml"]),
        (("--out", "no/run"), ["no/run: its parent folder does not exist", "Make no first"]),
        (("--out", "thesis"), ["thesis: exists and is not a run", "another name"]),
        (("--out", "thesis", "--force"), ["thesis: exists and is not a run", "another name"]),
        (("--out", "log.csv", "--force"), ["log.csv: exists and is not a run"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_bad_options(arguments: tuple[str, ...], words: list[str], log: Path) -> None:
    (log.parent / "thesis").mkdir()
    (log.parent / "thesis" / "thesis.tex").write_text("mine")
    quick = QUICK if "--models" not in arguments else QUICK[2:]
    said = refused("fit", log, *quick, *arguments, cwd=log.parent)
    for word in words:
        assert word in said
    assert (log.parent / "thesis" / "thesis.tex").read_text() == "mine"


@pytest.mark.slow
def test_the_same_log_twice(log: Path) -> None:
    shutil.copy(log, log.parent / "copy.csv")
    said = refused("fit", log, log.parent / "copy.csv", *QUICK, cwd=log.parent)
    assert said == "error: copy.csv: the same file as log.csv. Give each log once.\n"


@pytest.mark.slow
def test_missing_files_and_folders_without_logs(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "notes.docx").write_text("")
    for arguments, words in (
        (("fit", "gone.csv"), "gone.csv: there is no such file"),
        (("fit", "empty"), "empty: the folder holds no log"),
        (("inspect", "empty"), "empty: the folder holds no log"),
    ):
        assert words in refused(*arguments, cwd=tmp_path)


def test_a_folder_of_folders_names_those_that_hold_logs(tmp_path: Path) -> None:
    for folder in ("raw", "smoothed", "papers"):
        (tmp_path / folder).mkdir()
    (tmp_path / "LICENSE.txt").write_text("Do as you please.\n")
    (tmp_path / "papers" / "paper.pdf").write_bytes(b"%PDF")
    for folder in ("raw", "smoothed"):
        (tmp_path / folder / "log.csv").write_text("t,c\n0,1\n1,2\n")
    assert (
        "the folder holds no log. Give one of its folders: raw, smoothed; or, where all are"
        in refused("inspect", tmp_path, cwd=tmp_path)
    )


def test_folders_that_hold_logs_are_found_at_any_depth(tmp_path: Path) -> None:
    for folder in ("0A/1Hz", "0A/2Hz", ".git/logs"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "log.csv").write_text("t,c\n0,1\n1,2\n")
    error = refused("inspect", tmp_path, cwd=tmp_path)
    assert "Give one of its folders: 0A/1Hz, 0A/2Hz; or" in error


@pytest.mark.slow
def test_a_manifest_above_folders_of_logs_is_no_log(tmp_path: Path) -> None:
    for folder in ("group_01/motor_01", "group_01/motor_02"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "capture.csv").write_text("t,c\n0,1\n1,2\n")
    (tmp_path / "manifest.json").write_text('{"mode": "identify", "files": ["a.csv", "b.csv"]}')
    error = refused("inspect", tmp_path, cwd=tmp_path)
    assert "Give one of its folders: group_01/motor_01, group_01/motor_02" in error
    (tmp_path / "group_01" / "manifest.json").write_text('{"t": [0, 1], "c": "two"}')
    said = good("inspect", tmp_path / "group_01", cwd=tmp_path, code=1)
    assert "Not understood yet: manifest.json" in said  # it has vectors, as a log has


@pytest.mark.slow
def test_logs_that_ask_the_same_are_told_once_with_one_command(tmp_path: Path) -> None:
    slips = [3 * math.sin(k / 9) for k in range(300)]
    for yielding, field in enumerate(("0x5", "1", "2"), start=1):
        efforts = [yielding * math.tanh(slip) + 0.1 * slip for slip in slips]
        rows = (
            f"{k / 100} {slip:.5f} {effort:.5f}\n"
            for k, (slip, effort) in enumerate(zip(slips, efforts, strict=True))
        )
        (tmp_path / f"{field}A.txt").write_text("".join(rows))
    said = good("inspect", tmp_path, cwd=tmp_path, code=1)
    assert said.count("things are missing") == 1
    assert "The same is asked of 2 more logs, the last 2A.txt" in said
    assert f"What settles it: erclutch inspect {tmp_path} " in said
    assert "--name-pattern '{field}A'" in said

    words = (
        "--time",
        "c1 [s]",
        "--slip",
        "c2 [rad/s]",
        "--effort",
        "c3 [N*m]",
        "--name-pattern",
        "{field}A",
    )
    said = good("inspect", tmp_path, *words, cwd=tmp_path)
    assert said.splitlines()[-1].startswith(f"Understood. Fit them: erclutch fit {tmp_path} --slip")


@pytest.mark.slow
def test_fields_in_the_names_of_files_are_asked_about_once_with_one_command_for_all(
    tmp_path: Path,
) -> None:
    slips = [3 * math.sin(k / 9) for k in range(300)]
    for field in (0.0, 0.5, 1.0):
        rows = "".join(
            f"{k / 100},{w:.5f},{(0.1 + field) * math.tanh(w):.5f}\n" for k, w in enumerate(slips)
        )
        (tmp_path / f"brake7_{field:g}A.csv").write_text(f"t [s],slip [rad/s],torque [N*m]\n{rows}")
    said = good("inspect", tmp_path, cwd=tmp_path, code=1)
    assert said.count("Not understood yet") == 1
    assert "The same is asked of 2 more logs" in said
    settled = shlex.split(said.splitlines()[-1].removeprefix("What settles it: "))
    assert settled[:3] == ["erclutch", "inspect", str(tmp_path)]
    assert "Understood. Fit them" in good(*settled[1:], cwd=tmp_path)


@pytest.mark.parametrize(
    "arguments", [("--device", "triaxial"), ("--blocks", "two"), ("--nonsense",)]
)
def test_what_the_parser_refuses(arguments: tuple[str, ...], log: Path) -> None:
    said = refused("fit", log, *arguments, cwd=log.parent)
    assert arguments[-1] in said


@pytest.mark.slow
def test_a_stage_that_is_none(log: Path) -> None:
    said = refused("fit", log, "--lag", "late", cwd=log.parent)
    assert "unknown stage 'late'. Known are " in said
    assert "lag, lugre, remanence, ripple, rise-fall, second-order, second-ripple" in said


def test_unknown_commands_and_nothing_to_fit(tmp_path: Path) -> None:
    assert "nope" in refused("nope", cwd=tmp_path)
    assert "LOG" in refused("fit", cwd=tmp_path)


class FittedError(Exception):
    """A fit was begun."""


def test_out_is_looked_at_before_the_fit(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody waits for a fit that cannot be kept."""

    def begun(*_: object) -> None:
        raise FittedError

    monkeypatch.setattr("erclutch.fit.kinds.law_alone.fit_structure", begun)
    refused("fit", log, "--out", "no/run", cwd=log.parent)


@pytest.mark.slow
def test_more_unknowns_than_rows(tmp_path: Path) -> None:
    (tmp_path / "short.csv").write_text(rows_text(80))
    good("fit", "short.csv", "--models", "rbfm-100", "--lag", "none", cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_output_that_cannot_be_written(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*COMMAND, "laws"],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
        )
    assert done.returncode == 2
    assert done.stderr == "error: the output cannot be written (No space left on device)\n"


# --- cut short --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_reader_that_goes_away(more: tuple[str, ...], log: Path) -> None:
    """``erclutch fit LOG | head -1``."""
    command = subprocess.Popen(
        [*COMMAND, "fit", str(log), *QUICK, *more],
        cwd=log.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        bufsize=1,
    )
    assert command.stdout is not None
    assert command.stderr is not None
    assert command.stdout.readline()
    command.stdout.close()
    said = command.stderr.read()
    command.stderr.close()
    command.wait(timeout=60)
    assert said == ""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("after", [1.5, 3.0])
def test_an_interrupt_during_a_fit_leaves_nothing(after: float, tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv", 120.0)
    command = subprocess.Popen(
        [*COMMAND, "fit", "log.csv", "--out", "run", "--blocks", "10"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(after)
    assert command.poll() is None, "the fit was done before the interrupt"
    command.send_signal(signal.SIGINT)
    began = time.perf_counter()
    out, said = command.communicate(timeout=60)
    assert time.perf_counter() - began < 20
    # Python ends itself by the signal where it came amid code that a library makes; a shell sees 130 then, too.
    assert command.returncode in (130, -signal.SIGINT), said
    assert "Traceback" not in said
    assert said.count("\n") <= 1
    assert out == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.csv"]


@pytest.mark.slow
def test_an_error_that_a_library_makes_of_an_interrupt_is_told_as_one(
    log: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            raise SystemError("returned a result with an exception set")  # noqa: B904

    monkeypatch.setattr("pandas.read_csv", interrupted)
    assert main(["inspect", str(log)]) == 130
    assert capsys.readouterr().err == "error: interrupted; nothing was left half-written\n"


@pytest.mark.slow
def test_an_interrupt_while_modules_are_imported_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "cyclopts.py").write_text("raise KeyboardInterrupt\n")
    own = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}
    done = subprocess.run([*COMMAND, "laws"], env=own, capture_output=True, text=True, check=False)
    assert done.returncode == 130
    assert (done.stdout, done.stderr) == ("", "error: interrupted; nothing was left half-written\n")


# --- reports ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def kept(made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of the same log, `one` and `two`, that no test changes."""
    folder = tmp_path_factory.mktemp("kept")
    shutil.copy(made, folder / "log.csv")
    good("fit", "log.csv", *QUICK, "--out", "one", cwd=folder)
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "two", cwd=folder)
    return folder


@pytest.fixture
def runs(kept: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(kept, tmp_path / "runs"))


@pytest.mark.slow
def test_report(runs: Path) -> None:
    assert good("report", "one", cwd=runs).startswith(f"one{os.sep}report.html: ")
    text = (runs / "one" / "report.html").read_text()
    assert text.startswith("<!doctype html>")
    good("report", "one", "--out", "x.html", cwd=runs)
    assert (runs / "x.html").read_text() == text


@pytest.mark.slow
def test_compare(runs: Path) -> None:
    said = good("compare", "one", "two", "--out", "c.html", cwd=runs)
    assert "600 rows that all 2 runs held out" in said
    assert "Differences to one, paired" in said
    assert "models    quadratic   bingham" in said
    assert (
        "two: Bingham law cannot be told from one: Quadratic law in E: the difference"
        in " ".join(said.split())
    )
    assert "What was done differently" in (runs / "c.html").read_text()


@pytest.mark.slow
def test_figure(runs: Path) -> None:
    assert "flow-curves" in good("figure", cwd=runs)
    if browser() is not None:
        good("report", "one", "--out", "one.pdf", cwd=runs)
        assert (runs / "one.pdf").read_bytes().startswith(b"%PDF")
    assert "parity.pdf" in good("figure", "parity", "one", cwd=runs)
    assert sorted(p.name for p in (runs / "figures").iterdir()) == [
        "parity.csv",
        "parity.pdf",
        "parity.png",
    ]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("report", "nowhere"),
            "nowhere: not a run: there is no such folder. Give the --out folder of erclutch fit",
        ),
        (("report", "log.csv"), "log.csv: not a run"),
        (
            ("report", "."),
            ".: not a run: it holds no run.json. Give one of the runs in it: one, two.",
        ),
        (("figure", "trac", "one"), "no figure 'trac'. Did you mean trace?"),
        (("verify", "nowhere"), "nowhere: not an export: there is no such folder"),
        (
            ("report", "one", "--out", "no/x.html"),
            "no/x.html: its folder does not exist. Make no first.",
        ),
        (
            ("report", "one", "--out", "log.csv"),
            "log.csv: exists and is not a report. Give --out another name",
        ),
        (("report", "one", "--out", "two"), "two: this is a folder"),
        (("compare", "one"), "a comparison needs two runs or more"),
        (("compare", "one", "one"), "the same run twice"),
        (("compare", "one", "two", "--model", "hem"), "no model 'hem'"),
        (
            ("compare", "one", "two", "--model", "a", "--model", "b", "--model", "c"),
            "3 models for 2 runs",
        ),
        (("compare", "one", "two", "--open"), "--open needs a file"),
        (("figure", "fig3", "one"), "no figure 'fig3'"),
        (("figure", "trace"), "no run was given"),
        (("figure", "trace", "one", "--start", "99"), "no rows from 99 s"),
        (("figure", "trace", "one", "--seconds", "-1"), "a section of -1 s"),
        (("figure", "parity", "one", "--out", "log.csv"), "log.csv"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_bad_reports(arguments: tuple[str, ...], words: str, runs: Path) -> None:
    assert words in refused(*arguments, cwd=runs)


def test_a_run_with_a_changed_file(runs: Path) -> None:
    (runs / "one" / "table.csv").write_text("better figures")
    (runs / "two" / "predictions.parquet").unlink()
    for arguments in (("report", "one"), ("figure", "parity", "one")):
        said = refused(*arguments, cwd=runs)
        assert "table.csv: changed after the run. Restore the file, or fit the log again." in said
    said = refused("compare", "one", "two", cwd=runs)
    assert "predictions.parquet: cannot be read: No such file or directory" in said


@pytest.mark.slow
def test_a_log_of_one_field_after_another(tmp_path: Path) -> None:
    """Inspect lists its stretches and the speed that it derived; fit holds out the end of each and says so."""
    rows = ["t [s],x [mm],F [N]"]
    for k in range(3):
        times = [k * 5 + i / 500 for i in range(500)]
        rows += [
            f"{t:.3f},{5 * math.sin(9 * t):.5f},{(k + 1) * math.tanh(9 * math.cos(9 * t)):.5f}"
            for t in times
        ]
    (tmp_path / "steps.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    more = ("--position", "x [mm]", "--effort", "F [N]", "--constant", "field=0, 0.5, 1 A")
    seen = good("inspect", "steps.csv", *more, cwd=tmp_path)
    assert "slip (derived)" in seen
    assert "Segments between gaps" in seen
    assert re.search(r"3\s+500\s+10\s+10\.998\s+1\s", seen)
    assert "field [A]" in seen
    fitted = good("fit", "steps.csv", *more, "--models", "bingham", cwd=tmp_path)
    assert "held out: the last 30 % of each stretch" in fitted


@pytest.mark.slow
@pytest.mark.parametrize("how", ["constant", "none"])
def test_a_log_of_one_field_from_reading_to_export(how: str, tmp_path: Path) -> None:
    t = np.arange(3000) / 1000
    slip = 2 * np.sin(9 * t) + np.sin(2.3 * t)
    torque = (
        12 * np.tanh(slip / 0.15)
        + 5 * slip
        + 0.3 * np.random.default_rng(0).standard_normal(t.size)
    )
    table = np.column_stack([t, slip, torque])
    header = "time [s],slip [rad/s],torque [N*m]"
    np.savetxt(tmp_path / "one.csv", table, delimiter=",", header=header, comments="", fmt="%.7g")
    given = ("--constant", "field=0.5 A") if how == "constant" else ()
    assert "field" in good("inspect", "one.csv", *given, cwd=tmp_path)
    said = good(
        "fit", "one.csv", *given, "--models", "bingham", "fnn-4", "--out", "run", cwd=tmp_path
    )
    assert "Recommended: m1, Bingham law (constant yield)" in said
    assert (
        "the field is 0.5 A in all 3000 rows" if how == "constant" else "the log has no field"
    ) in said
    good("report", "run", cwd=tmp_path)
    for model, target in (
        ("bingham/constant", "python"),
        ("fnn-4", "python"),
        ("bingham/constant", "c"),
    ):
        name = f"{target}-{model[:3]}"
        good("export", "run", "--model", model, "--to", target, "--out", name, cwd=tmp_path)
        good("verify", name, cwd=tmp_path)
    wrong = refused("fit", "one.csv", *given, "--models", "rbfm", cwd=tmp_path)
    assert "rbfm describes how the effort changes with the field" in wrong


@pytest.mark.slow
def test_past_samples_and_another_rate(log: Path) -> None:
    rate = ("--resample", "0.5 kHz")
    said = good(
        "fit",
        log,
        "--models",
        "fnn-2",
        "--lag",
        "none",
        "--past",
        "2ms",
        "4",
        *rate,
        cwd=log.parent,
    )
    said = " ".join(said.split())
    assert "logs were brought from 1000 Hz to 500 Hz by a zero-phase filter" in said
    assert (
        "past samples (--past 2ms, 4) lie 1, 4 rows back, 2, 8 ms, at the 500 Hz of these rows"
        in said
    )
    for wrong, words in (
        (("--past", "2 m"), "neither a time"),
        (("--resample", "often"), "no sampling rate"),
    ):
        assert words in refused("fit", log, "--models", "fnn-2", *wrong, cwd=log.parent)


def test_verify_of_a_run_says_how_to_export_it(runs: Path) -> None:
    failed = refused("verify", "one", cwd=runs)
    assert "erclutch export one" in failed


@pytest.mark.parametrize(
    ("value", "digits", "zeros", "text"),
    [
        (1810.0, 3, False, "1810"),
        (123.0296, 4, False, "123"),
        (123.0296, 4, True, "123.0"),
        (0.0038, 4, True, "0.003800"),
        (39799.6, 4, False, "39800"),
        (0.00001234, 3, False, "1.23e-05"),
    ],
)
def test_numbers_of_the_terminal(value: float, digits: int, zeros: bool, text: str) -> None:
    from erclutch.cli.terminal import number

    assert number(value, digits, zeros=zeros) == text


@pytest.mark.slow
@given(st.lists(st.integers(1, 30), min_size=4, max_size=4), st.integers(20, 160))
def test_a_table_leaves_columns_out_until_it_fits(wide: list[int], width: int) -> None:
    """No cell is cut while enough columns may go; none goes without need, and the less needed ones first."""
    from rich.console import Console

    from erclutch.cli.terminal import narrowed

    columns = {f"h{i}\nTWIN": ["x" * size, str(i)] for i, size in enumerate(wide)}
    heads = list(columns)
    made = narrowed("title", columns, [heads[3], heads[1]], width)
    kept = [str(column.header) for column in made.columns]
    assert kept in (heads, heads[:3], [heads[0], heads[2]])
    sizes = {head: max(4, size) + 3 for head, size in zip(heads, wide, strict=True)}
    for more, fewer in ((heads, heads[:3]), (heads[:3], [heads[0], heads[2]])):
        if kept == fewer:
            assert sum(sizes[head] for head in more) > width
    if sum(sizes[head] for head in kept) <= width:
        said = io.StringIO()
        Console(width=width, file=said).print(made)
        text = said.getvalue()
        assert all("x" * wide[heads.index(head)] in text for head in kept)
        assert "…" not in text


def test_no_unit_of_a_constant_is_cut_on_a_narrow_screen(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    unit = "N*m/(rad/s^2)"
    long = Estimate(
        "m_1", "inertia between fluid and load cell, CH1", unit, -3.221e-6, -5.083e-6, -2.957e-6
    )
    bound = Estimate("h_l", "static effort over that at high slip", "1", 5.0, 1.373, 5.0, "upper")
    terminal.tell(terminal.estimates("Parameters", [long, bound]))
    said = capsys.readouterr().out
    assert unit in said
    assert "at its upper bound" in said
