"""Messages in the words of the interface that shows them: a shell's options, or arguments of Python."""

from __future__ import annotations

import ast
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import erclutch
from erclutch import errors
from erclutch.errors import (
    ErclutchError,
    LogError,
    MappingError,
    SettingError,
    SeveralRecordingsError,
    for_a_shell,
    worded,
)
from erclutch.export import ExportOptions, export_model
from tests.support.command import run

SOURCE = Path(erclutch.__file__).parent


@pytest.fixture
def python_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """Messages as a user of Python meets them."""
    monkeypatch.setattr(errors._INTERFACE, "shell", False)


@pytest.mark.usefixtures("python_words")
@pytest.mark.parametrize(
    ("shell", "python"),
    [
        ("Give --rate 1000 or --time", "Give rate=1000 or time="),
        ("Write it like --resample 1kHz.", "Write it like resample='1kHz'."),
        ("try --derivative kalman or savgol", "try derivative='kalman' or savgol"),
        ('such as --slip "w [rpm]" or "w [cm/s]"', 'such as slip="w [rpm]" or "w [cm/s]"'),
        ("Give --out another name, or --force", "Give another name, or force=True"),
        (
            "there is a folder already. Give the --out folder",
            "there is a folder already. Give the folder",
        ),
        ("Leave --field none out, or --name-pattern", "Leave field='none' out, or name_pattern="),
        ("Fit with --lag lag+dahl-2/field.", "Fit with lag='lag+dahl-2/field'."),
        ("widen --from, --until or --skip", "widen begin=, end= or skip="),
        ("Say --decimal , for 1.5", "Say decimal=',' for 1.5"),
        ("or choose --variable Torque-Speed.", "or choose variable='Torque-Speed'."),
        ("the slip -- of a brake -- rests", "the slip -- of a brake -- rests"),
    ],
)
def test_options_are_arguments_in_python(shell: str, python: str) -> None:
    assert worded(shell) == python
    with for_a_shell():
        assert worded(shell) == shell


@pytest.mark.slow
@pytest.mark.usefixtures("python_words")
def test_no_message_of_the_core_shows_an_option_in_python() -> None:
    rooms = ("arithmetic", "export", "files", "fit", "logs", "models", "runs", "signals")
    said = 0
    for path in (file for room in rooms for file in (SOURCE / room).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and re.search(r"--[a-z]", node.value)
            ):
                said += 1
                assert re.search(r"(?<![-!])--[a-z]", worded(node.value)) is None, (
                    path.name,
                    node.lineno,
                )
    assert said > 100


def frame() -> pd.DataFrame:
    """SYNTHETIC rows of a brake; the field's name is none that anyone would guess."""
    t = np.arange(2000) / 1000.0
    columns = {"time [s]": t, "x7": np.sin(t), "w": np.cos(9 * t), "torque [N*m]": 2.0 * np.sin(t)}
    return pd.DataFrame(columns)


@pytest.mark.slow
@pytest.mark.usefixtures("python_words")
def test_a_log_that_is_not_understood_is_told_in_pythons_words() -> None:
    with pytest.raises(MappingError) as caught:
        erclutch.read(frame(), slip="w [rad/s]")
    assert "field=" in str(caught.value)
    assert "--" not in str(caught.value)
    done = run("fit", "gone.csv", "--resample", "9kg")
    assert "--resample '9kg' is no sampling rate. Write it like --resample 1kHz." in done.error


@pytest.mark.slow
def test_read_takes_columns_by_keyword() -> None:
    read = erclutch.read(frame(), field="x7 [A]", slip="w [rad/s]", begin="500ms", end=1.5)
    assert read.units["field"] == "A"
    assert read.rows == 1001
    mapped = erclutch.read(frame(), {"slip": "w [rpm]", "field": "x7 [V]"}, field="x7 [A]")
    assert (mapped.units["field"], mapped.units["slip"]) == ("A", "rad/s")
    halved = erclutch.read(frame(), field="x7 [A]", slip="w [rad/s]", resample="500 Hz")
    assert halved.period == pytest.approx(0.002)
    constant = erclutch.read(frame().drop(columns="x7"), constant="field=0.5 A", slip="w [rad/s]")
    assert set(constant.signals["field"]) == {0.5}


def test_a_keyword_that_is_none_says_what_is_near() -> None:
    with pytest.raises(
        MappingError, match=r"'feild' is no signal and no option of reading\. Did you mean field\?"
    ):
        erclutch.read(frame(), feild="x7")
    with pytest.raises(SettingError, match="no time"):
        erclutch.read(frame(), field="x7 [A]", slip="w [rad/s]", begin="soon")


@pytest.mark.slow
@pytest.mark.usefixtures("python_words")
def test_words_come_back_after_a_command() -> None:
    run("laws", "--json")
    error: ErclutchError = LogError("no clock", remedy="Give --rate HZ")
    assert str(error) == "no clock. Give rate=HZ."


@pytest.mark.usefixtures("python_words")
def test_a_command_that_settles_a_log_is_a_call_in_python() -> None:
    said = (
        "with your columns: erclutch inspect 'a b.csv' --field \"V [V]\" --name-pattern "
        "x{field}A; --field none if not"
    )
    call = "erclutch.read('a b.csv', field=\"V [V]\", name_pattern='x{field}A')"
    assert worded(said) == f"with your columns: {call}; field='none' if not"


def test_a_switch_of_reading_is_true_or_false() -> None:
    with pytest.raises(SettingError, match="keep_values is 'x'"):
        erclutch.read(frame(), field="x7 [A]", slip="w [rad/s]", keep_values="x")


@pytest.mark.parametrize(
    ("taker", "values", "keywords", "said"),
    [
        (
            erclutch.Settings,
            (),
            {"modles": "bingham"},
            "Settings knows no modles. Did you mean models?",
        ),
        (
            ExportOptions,
            (),
            {"precison": "float32"},
            "ExportOptions knows no precison. Did you mean precision?",
        ),
        (
            export_model,
            (None, "c"),
            {"presicion": "float32"},
            "export_model knows no presicion. Did you mean precision",
        ),
        (
            erclutch.compare,
            (None,),
            {"settngs": None},
            "compare knows no settngs. Did you mean settings?",
        ),
        (
            erclutch.compare,
            (None,),
            {"modles": ()},
            "compare knows no modles. Did you mean models?",
        ),
        (
            erclutch.recording_from_arrays,
            ({},),
            {"sample_rate": 1.0},
            "recording_from_arrays knows no sample_rate.",
        ),
    ],
)
def test_a_misspelt_keyword_is_answered_with_the_nearest(
    taker: Callable[..., Any], values: tuple[Any, ...], keywords: dict[str, Any], said: str
) -> None:
    with pytest.raises(SettingError, match=re.escape(said)):
        taker(*values, **keywords)


def test_an_error_of_another_process_keeps_its_options() -> None:
    asked = {"remedy": "Take points", "where": "a.csv", "answers": ["--time none"]}
    error = SeveralRecordingsError("no clock", **asked, option="--variable x")
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back)) == (SeveralRecordingsError, str(error))
    assert (back.answers, back.option) == (("--time none",), "--variable x")
