"""Options of all commands: one meaning a name, quantities in any unit, tables also as JSON, headings of the help."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from functools import cache
from importlib import import_module
from inspect import getsource, signature
from pathlib import Path
from typing import Any, get_args

import pytest

from erclutch import registry
from erclutch.cli import app
from erclutch.cli.command_list import OF_OTHERS, PANELS, commands
from erclutch.cli.commands.fit import fit
from erclutch.errors import PluginError, SettingError
from erclutch.fit.fit_settings import Settings
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import good, refused, run
from tests.support.installed_plugin import Install

#: Their unit is that of a rig's field, which no option knows; or they are shares of one, such as field per rad.
PLAIN = {"--k-p", "--k-d", "--torque-p", "--torque-i", "--field-limit", "--largest", "--field-rate"}
#: Of a rig's motion: in rad of a brake, in m of a damper.
PLAIN |= {
    "--speed",
    "--acceleration",
    "--stroke",
    "--largest-effort",
    "--idle-effort",
    "--slow-effort",
    "--exponent",
}
#: A weight.
PLAIN |= {"--held"}
#: A name may be one of several, or a choice of few.
SAME = {
    "--as": "a format of what is written",
    "--derivative": "a filter; only causal ones run in an export",
    "--device": "single or coaxial; excite asks whether a brake, a clutch or a damper",
    "--rate": "a rate in Hz; align takes those of two logs",
    "--time": "a column; align takes those of two logs",
    "--seconds": "a time, with a default or without",
    "--workers": "a count",
    "--test": "a share held out; fit also takes patterns of names",
}
#: They print tables of rounded cells and write the same numbers as CSV or TOML.
WRITE_NUMBERS = {"figure"}


@cache
def options() -> dict[str, dict[str, Any]]:
    """Each option's arguments by command."""
    found: dict[str, dict[str, Any]] = defaultdict(dict)
    for command in commands():
        for argument in app[command.name].assemble_argument_collection():
            for name in argument.names:
                if name.startswith("--") and argument.show:
                    found[name][command.name] = argument
    return found


def element(hint: Any) -> str:
    """A type without None and without the tuple around it."""
    inner = [each for each in get_args(hint) if each not in (type(None), ...)]
    return element(inner[0]) if inner and getattr(hint, "__name__", "") != "Literal" else str(hint)


@pytest.mark.slow
def test_an_option_means_one_thing_in_all_commands() -> None:
    kinds = {
        name: {element(each.hint) for each in used.values()} for name, used in options().items()
    }
    assert {name: seen for name, seen in kinds.items() if len(seen) > 1 and name not in SAME} == {}
    assert kinds["--model"] == {"<class 'str'>"}
    assert kinds["--run"] == {"<class 'pathlib.Path'>"}


@pytest.mark.slow
def test_a_number_with_a_unit_is_a_quantity() -> None:
    bare = {
        f"{command} {name}"
        for name, used in options().items()
        for command, argument in used.items()
        if element(argument.hint) == str(float)
        and name not in PLAIN
        and argument.parameter.converter is None
    }
    assert bare == set()


@pytest.mark.slow
def test_commands_are_few_and_under_known_headings() -> None:
    ours = [command for command in commands() if command.plugin.own]
    assert len(ours) <= 24
    assert {command.panel for command in ours} <= set(PANELS)


def test_a_command_of_ours_says_what_help_shows_in_one_line_or_several(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        registry,
        "own_text",
        lambda _: 'COMMAND = {"help": "Greet.", "panel": "About", "place": 1}\n',
    )
    assert {command.help for command in commands() if command.plugin.own} == {"Greet."}
    monkeypatch.setattr(registry, "own_text", lambda _: 'COMMAND = {\n    "help": "Greet.",\n}\n')
    with pytest.raises(PluginError, match="a literal with help, panel and place"):
        commands()


@pytest.mark.slow
def test_a_command_that_prints_a_table_also_prints_json() -> None:
    for command in commands():
        if not command.plugin.own or command.name in WRITE_NUMBERS | {"table"}:
            continue
        module = import_module(command.plugin.source.partition(":")[0])
        if "terminal.table(" in getsource(module) or "narrowed(" in getsource(module):
            assert command.name in options()["--json"], command.name


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log and a run of one model."""
    folder = tmp_path_factory.mktemp("bench")
    write_synthetic_log(folder / "log.csv", 2.0)
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run", cwd=folder)
    return folder


def limits_in(code: str) -> tuple[float, ...]:
    """The limits of the effort in exported C."""
    written = re.search(r"limited\(unlimited, state->effort, (\S+), (\S+)\)", code)
    assert written is not None
    return tuple(
        float.fromhex(number) if "x" in number else float(number) for number in written.groups()
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "limits"),
    [
        (("--limits", "-2,2"), (-2.0, 2.0)),
        (("--limits=-2,2",), (-2.0, 2.0)),
        (("--limits", "-500,500 mN*m"), (-0.5, 0.5)),
        (("--limits", "-500 mN*m,2"), (-0.5, 2.0)),
    ],
)
def test_limits_take_a_minus_and_a_unit(
    words: tuple[str, ...], limits: tuple[float, float], bench: Path, tmp_path: Path
) -> None:
    good("export", bench / "run", *words, "--out", "c", cwd=tmp_path)
    assert limits_in((tmp_path / "c" / "log_model.c").read_text()) == limits


@pytest.mark.slow
def test_a_period_takes_a_unit(bench: Path, tmp_path: Path) -> None:
    for at, period in enumerate(("1ms", "0.001", "1000us", "1 ms")):
        good("export", bench / "run", "--period", period, "--out", f"c{at}", cwd=tmp_path)
    written = {(tmp_path / f"c{at}" / "log_model.c").read_text() for at in range(4)}
    assert len(written) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("export", "run", "--period", "2kg"),
            "--period '2kg' is no quantity in s. Write it like --period 2s.",
        ),
        (("export", "run", "--limits", "1"), "'1' are no two efforts"),
        (("export", "run", "--limits", "1,2 V"), "'1,2 V' are no two efforts"),
        (
            ("recalibrate", "run", "log.csv", "--share", "x"),
            "--share 'x' is no number or share in %",
        ),
        (("fit", "log.csv", "--memory", "2m"), "--memory '2m' is no quantity in GB"),
        (("inspect", "log.csv", "--plots", "p", "--seconds=-1s"), "--seconds -1"),
    ],
)
def test_what_is_no_quantity_is_told_with_an_example(
    words: tuple[str, ...], said: str, bench: Path
) -> None:
    assert said in refused(*words, cwd=bench)


@pytest.mark.slow
def test_times_before_zero_need_no_sign_of_equality(bench: Path) -> None:
    said = good("inspect", "log.csv", "--from", "-1s", cwd=bench)
    assert "--from -1s --out RUN" in said, "the last line repeats the options as they were given"
    assert said.replace("--from -1s", "--from -1") == good(
        "inspect", "log.csv", "--from=-1", cwd=bench
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "option"),
    [
        (("--models", "bingham", "casson"), "--models"),
        (("--lag", "none", "--test", "0.3"), "--test"),
    ],
)
def test_a_list_that_has_taken_the_log_says_so(
    words: tuple[str, ...], option: str, bench: Path
) -> None:
    done = run("fit", *words, "log.csv", cwd=bench)
    said = " ".join(done.error.split())
    assert done.code == 2
    assert (
        f"{option} takes all words up to the next option, log.csv too. Write log.csv before {option}."
        in said
    )


@pytest.mark.slow
def test_score_and_compare_as_json_hold_the_numbers_of_their_tables(bench: Path) -> None:
    write_synthetic_log(bench / "other.csv", 2.0, seed=1)
    scored = json.loads(good("score", "other.csv", "--run", "run", "--json", cwd=bench))
    table = good("score", "other.csv", "--run", "run", cwd=bench)
    (model,) = scored["models"]
    assert f"{model['rmse']:.4g}" in table
    assert scored["unit"] == "N*m"
    good("fit", "log.csv", "--models", "quadratic", "--lag", "none", "--out", "second", cwd=bench)
    first, second = json.loads(good("compare", "run", "second", "--json", cwd=bench))["runs"]
    assert first["difference"] is None
    assert second["rmse"][0] - first["rmse"][0] == pytest.approx(second["difference"][0])
    adapted = json.loads(
        good("recalibrate", "run", "other.csv", "--share", "70%", "--json", cwd=bench)
    )
    assert adapted["train_rows"] == pytest.approx(
        0.7 * (adapted["train_rows"] + adapted["test_rows"]), abs=2
    )


@pytest.mark.slow
def test_another_package_names_its_heading(install: Install) -> None:
    groups = {
        "erclutch.commands.more_logs": "theirs",
        "erclutch.commands.metrology": "own",
        "erclutch.commands": "none",
    }
    for at, (group, name) in enumerate(groups.items()):
        install(f"their-{at}", f"[{group}]\n{name} = their_{at}:command\n", "def command(): pass\n")
    headings = {command.name: command.panel for command in commands()}
    assert headings["theirs"] == "More logs"
    assert headings["own"] == "Metrology"
    assert headings["none"] == OF_OTHERS


def test_a_folder_given_as_a_model_is_told(bench: Path) -> None:
    assert "no model 'run'" in refused(
        "predict", "log.csv", "--run", "run", "--model", "run", "--out", "p.csv", cwd=bench
    )


def test_settings_of_python_are_as_strict() -> None:
    from erclutch.cli.quantities import quantity_in

    assert quantity_in("--share", "70%", "", "") == pytest.approx(0.7)
    assert quantity_in("--memory", "500MB", "GB", "") == pytest.approx(0.5)
    assert quantity_in("--theta-wrap", "360deg", "rad", "") == pytest.approx(6.283185307)
    with pytest.raises(SettingError, match="no quantity in Hz"):
        quantity_in("--cutoff", "150 rad/s", "Hz", "")


def test_the_command_of_a_report_has_options_that_there_are() -> None:
    from dataclasses import fields

    from erclutch.cli.options import LogOptions
    from erclutch.report.html.provenance_section import command_of

    reading = {field.name: "x" for field in fields(LogOptions)}
    body = {
        "reading": reading,
        "logs": [],
        "recalibration": {"run": "r", "model": "m", "share": 0.5, "stretches": 1},
    }
    known = options()
    given = [word.partition("=")[0] for word in command_of(body).split() if word.startswith("--")]
    assert [word for word in given if word not in known and word != "--out"] == []


@pytest.mark.slow
def test_help_folds_what_few_need_and_help_all_shows_each_option() -> None:
    for command in commands():
        if not command.plugin.own:
            continue
        whole = good(command.name, "--help-all")
        hidden = {
            name for name, used in options().items() if command.name in used and name not in whole
        }
        assert hidden == set(), command.name


@pytest.mark.slow
def test_help_is_as_wide_as_the_terminal_is_now(monkeypatch: pytest.MonkeyPatch) -> None:
    widths = []
    for columns in ("30", "100"):
        monkeypatch.setenv("COLUMNS", columns)
        frame = next(line for line in good("score", "--help").splitlines() if line.startswith("╭"))
        widths.append(len(frame))
    assert widths == [30, 100]


@pytest.mark.slow
def test_help_names_files_first_and_shows_no_values_of_python() -> None:
    assert "Usage: erclutch score LOG... --run RUN [OPTIONS]" in good("score", "--help")
    said = good("figure", "--help")
    assert "[default: pdf png]" in said
    assert "False" not in said
    assert "--LOG" not in good("fit", "--help")


def test_the_options_of_a_fit_begin_as_its_settings_do() -> None:
    options, settings = signature(fit).parameters, Settings()
    assert options["models"].default == settings.models
    assert options["lag"].default == settings.lag
    assert options["test"].default == (settings.test,)
    assert options["blocks"].default == settings.blocks
    for name in ("friction", "offset", "seed", "past", "polish", "workers"):
        assert options[name].default == getattr(settings, name)
