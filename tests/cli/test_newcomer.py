"""Where somebody stumbles who knows the README alone: narrow screens, ragged help, names of another kind of file."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from cyclopts.help import HelpEntry, HelpPanel
from cyclopts.help.inline_text import InlineText
from rich.console import Console
from rich.text import Text

from erclutch.cli.folded_help import Flowing
from erclutch.cli.terminal import estimates
from erclutch.fit.laws.fit_law import Estimate
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.runs.run_folder import Run
from tests.support.command import good, refused


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log and a run."""
    folder = tmp_path_factory.mktemp("bench")
    write_synthetic_log(folder / "log.csv", seconds=3.0)
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run", cwd=folder)
    return folder


def printed(shown: object, width: int) -> list[str]:
    """The lines of what is shown on a screen of some width."""
    said = io.StringIO()
    Console(file=said, width=width).print(shown)
    return said.getvalue().splitlines()


def test_a_text_of_the_help_fills_its_lines_wherever_its_docstring_breaks() -> None:
    told = InlineText(Text("both joined\nby + or\n    alone."))
    panel = HelpPanel(
        title="Options",
        format="parameter",
        entries=[HelpEntry(positive_names=("--models",), description=told, default="()")],
    )
    said = io.StringIO()
    console = Console(file=said, width=80)
    Flowing()(console, console.options, panel)
    assert "both joined by + or alone. " in said.getvalue()
    assert "()" not in said.getvalue()


@pytest.mark.parametrize(("width", "most"), [(80, 3), (150, 1)])
def test_a_meaning_has_room_on_a_narrow_screen(
    width: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    meaning = "effort of the bristles' damping at the reference field"
    value = Estimate("T_ldy", meaning, "N/(m/s)", 0.0, 0.0, 284.7, "lower")
    lines = printed(estimates("Parameters", [value]), width)
    body = [line for line in lines[4:] if line.strip()]
    assert len(body) <= most, lines
    assert "0 - 284.7" in "\n".join(body), "the ends of an interval stay in one line"


@pytest.mark.parametrize("unit", ["?", "?/?", "?*s/?"])
def test_a_constant_of_unknown_units_says_so(unit: str) -> None:
    value = Estimate("eta", "viscous effort per slip", unit, 0.2, 0.1, 0.3, None)
    row = printed(estimates("Parameters", [value]), 150)[4]
    assert row.split()[-2:] == ["as", "logged"]


def test_an_interval_of_one_number_is_told_by_its_bound_alone() -> None:
    value = Estimate("K", "viscous effort", "N", 0.0, 0.0, 0.0, "lower")
    row = printed(estimates("Parameters", [value]), 150)[4]
    assert "at its lower bound" in row
    assert " - " not in row


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("report", "run", "--out", "x.txt"),
            "x.txt: its name cannot end in '.txt'. Give --out a name that ends in .html",
        ),
        (
            ("report", "run", "--out", "x"),
            "x: its name has no ending, such as .html. Give --out a name that ends in .html",
        ),
        (("report", "run", "--pdf", "--out", "x.html"), "ends in .pdf"),
        (("predict", "log.csv", "--run", "run", "--out", "x"), "ends in .csv, .parquet or .mat"),
    ],
)
def test_a_name_that_says_another_kind_of_file_is_refused_before_any_work(
    words: tuple[str, ...], said: str, bench: Path
) -> None:
    assert said in refused(*words, cwd=bench)


@pytest.mark.slow
def test_a_word_too_many_is_told_with_the_way_out(bench: Path) -> None:
    said = " ".join(refused("table", "ranking", "run", cwd=bench).split())
    assert "'run': more than the command takes. erclutch table --help shows what it takes." in said


@pytest.mark.slow
def test_a_second_scale_wants_its_option(bench: Path) -> None:
    said = refused("inspect", "log.csv", "--scale", "effort=2 N*m", "field=1 A", cwd=bench)
    assert "'field=1 A': more than the command takes. Write --scale in front of each value." in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--window", "11", "--derivative", "kalman"), "--window is of savgol"),
        (("--cutoff", "20"), "Add --derivative kalman, or leave --cutoff out"),
    ],
)
def test_a_setting_of_another_filter_of_speeds_is_refused(
    words: tuple[str, ...], said: str, bench: Path
) -> None:
    """Both were taken and did nothing."""
    assert said in refused("inspect", "log.csv", *words, cwd=bench)


@pytest.mark.slow
def test_a_named_column_without_a_number_is_told_as_such(tmp_path: Path) -> None:
    rows = "\n".join(f"{i / 1000},{i % 7},{i % 5}," for i in range(60))
    (tmp_path / "log.csv").write_text(f"t [s],E [A],w [rad/s],T [N*m]\n{rows}\n")
    said = refused(
        "fit",
        "log.csv",
        "--field",
        "E [A]",
        "--slip",
        "w [rad/s]",
        "--effort",
        "T [N*m]",
        cwd=tmp_path,
    )
    assert (
        "column 'T' holds no number in any row, so it cannot be the effort; the file has: t [s], E [A]"
        in said
    )


def test_an_umlaut_in_a_log_s_name_stays_in_the_names_of_c() -> None:
    from erclutch.export.c_names import named_after

    assert named_after("Prüfstand 3") == "pruefstand_3_model"
    assert named_after("Frottement à sec") == "frottement_a_model"
    assert named_after("制动器") == "model"
    assert named_after("Damper 0.25A") == "damper_0p25a_model"
    assert named_after("LordRD8041_0.25A.steps") == "lordrd8041_model"


def test_the_export_of_several_logs_is_called_by_what_their_names_have_in_common() -> None:
    def called(*logs: str) -> str:
        return Run(Path("x.run"), {"logs": [{"name": log} for log in logs]}).c_name

    assert called("LordRD_0.25A.csv", "LordRD_0.5A.csv", "LordRD_1A.csv") == "lordrd_model"
    assert called("brake12.csv", "brake15.csv") == "brake_model"
    assert called("a.csv", "b.csv") == "a_model"
    assert called("shock 3.csv") == "shock_3_model"


@pytest.mark.slow
@pytest.mark.parametrize("still", ["speed", "torque"])
def test_inspect_says_that_nothing_can_be_fitted_where_a_signal_stands_still(
    still: str, tmp_path: Path
) -> None:
    time = np.arange(1000) / 1000.0
    speed = 20.0 * np.sin(6.0 * time)
    rows = {
        "time [s]": time,
        "speed [rad/s]": speed,
        "torque [N*m]": 0.02 * speed + 0.1 * np.sign(speed),
    }
    name = next(name for name in rows if name.startswith(still))
    rows[name] = np.full_like(time, 12.5)
    np.savetxt(
        tmp_path / "log.csv",
        np.column_stack(list(rows.values())),
        "%.6g",
        ",",
        header=",".join(rows),
        comments="",
    )

    signal = {"speed": "slip", "torque": "effort"}[still]
    last = good("inspect", "log.csv", cwd=tmp_path).splitlines()[-1]
    assert last == (
        f"Understood, but nothing can be fitted to it: log.csv: the {signal} is constant at 12.5 over 1000 rows. "
        f"Check that the right column is mapped to {signal}."
    )
    findings = json.loads(good("inspect", "log.csv", "--json", cwd=tmp_path))["findings"]
    assert any(
        f"nothing can be fitted: log.csv: the {signal} is constant at 12.5" in finding
        for finding in findings
    )


@pytest.mark.slow
def test_inspect_tells_what_its_command_confirms_beside_what_it_answers(tmp_path: Path) -> None:
    """The field is asked about, and the command takes one of several joints too: it must not do so in silence."""
    time = np.arange(1500) / 500.0
    columns = {"time": time, "aux": np.repeat([0.0, 1.0, 2.0], 500)}
    for joint in (1, 2, 3, 4):
        speed = (0.5 + 0.1 * joint) * np.sin((3.0 + 0.4 * joint) * time)
        columns |= {
            f"qd_{joint}": speed,
            f"tau_{joint}": joint * np.tanh(8.0 * speed) + 0.1 * speed,
        }
    rows = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "arm.csv", rows, "%.6g", ",", header=",".join(columns), comments="")
    said = good("inspect", "arm.csv", cwd=tmp_path, code=1)
    assert "slip is column qd_1 of one of 4 joints" in said
    assert said.splitlines()[-1].endswith('--slip "qd_1" --effort "tau_1"')


@pytest.mark.slow
@pytest.mark.parametrize("words", [("export", "c", "run"), ("export", "run", "c")])
def test_a_target_without_its_option_is_told_with_the_command(
    words: tuple[str, ...], bench: Path
) -> None:
    said = " ".join(refused(*words, cwd=bench).split())
    assert "more than the command takes. Write: erclutch export run --to c." in said
