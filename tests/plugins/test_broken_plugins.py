"""A plug-in that is broken or lies is named where it was asked for, and stops no work that did not ask for it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.cli.log_advice import advice_on
from erclutch.cli.rheometer_points import tried_flow_command
from erclutch.errors import PluginError, SettingError
from erclutch.fit.candidate import kind_of, kinds
from erclutch.logs.log_file import read_table
from erclutch.logs.log_reader import GROUP as READERS
from erclutch.logs.log_reader import LogReader, folder_reader, log_at, log_suffixes
from erclutch.logs.outside_reader import (
    sound_extent,
    sound_names,
    sound_table,
    sound_tables,
    sound_windows,
)
from erclutch.logs.table import Table
from erclutch.models.laws import law_from_name, law_names
from erclutch.models.load import load_model
from erclutch.models.stages import stages_of
from erclutch.registry import find
from tests.support.exported_models import MODELS
from tests.support.installed_plugin import Install, install
from tests.support.pair import pair_rows

__all__ = ["install"]
BROKEN = ["1 / 0", "raise SystemExit(0)", "THING = None", "raise LogError('own words')"]
HEAD = "from erclutch.errors import LogError\n"
KIND = """
from erclutch.fit.candidate import Grown, Kind

class Odd(Kind):
    place = -5

    def means(self, model):
        return True

    def candidates(self, settings, train):
        return []
"""
READER = """
import numpy as np
from erclutch.logs.log_reader import LogReader

def odd(*_):
    1 / 0

ALL = dict(suffixes=(".odd",), claims=lambda head: head.startswith(b"ODD"), read=odd)
"""
LAW = """
from dataclasses import replace
from erclutch.models.laws.bingham import LAW as OURS

def odd(form):
    return replace(OURS.law(form), name="odd")

THING = replace(OURS, law=odd, ladder={}, aliases=())
"""


@pytest.fixture
def broken(install: Install) -> Callable[..., None]:
    """Makes a package with one plug-in called ``odd``."""

    def make(group: str, text: str) -> None:
        install("bench-odd", f"[erclutch.{group}]\nodd = bench_odd:THING\n", HEAD + text)

    return make


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text("t [s],F [N]\n0,1\n0.1,2\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("text", BROKEN)
def test_a_broken_kind_stops_no_law_and_no_model(
    text: str, broken: Callable[..., None], tmp_path: Path
) -> None:
    broken("kinds", text)
    assert all(plugin.own for plugin, _ in kinds())
    assert not kind_of("bingham+lag").means.__qualname__.startswith("OutsideKind")
    with pytest.raises(PluginError, match=r"nobody knows the model 'nosuch', and .*'odd' of bench"):
        kind_of("nosuch")
    path = tmp_path / "model.json"
    path.write_text(json.dumps(MODELS["bingham, single"].to_dict()))
    assert load_model(path).name == "bingham"


@pytest.mark.slow
def test_a_kind_of_others_takes_no_name_of_ours(broken: Callable[..., None]) -> None:
    broken("kinds", KIND + "THING = Odd()")
    for name in ("bingham", "bingham+lag", "rbfm-5", "fnn-3", "hb/critical"):
        assert kind_of(name) in [kind for plugin, kind in kinds() if plugin.own], name
    assert kind_of("mine") not in [kind for plugin, kind in kinds() if plugin.own]


@pytest.mark.slow
@pytest.mark.parametrize(
    "part",
    [
        "place = 'x'",
        "readers = None",
        "work = 5",
        "def means(self, model): 1 / 0",
        "def candidates(self, *_): return [5]",
        "def candidates(self, *_): return None",
        "def grown(self, *_): return 5",
    ],
)
def test_what_a_kind_answers_is_looked_at(part: str, broken: Callable[..., None]) -> None:
    broken("kinds", f"{KIND}\nclass Odder(Odd):\n    {part}\nTHING = Odder()")

    def ask() -> None:
        mine: Any = kind_of("mine")
        mine.candidates(None, None)
        mine.grown(None, None, [])

    with pytest.raises(PluginError, match=r"'odd' of bench-odd 1\.5"):
        ask()


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", [*BROKEN, "def THING(rows): return None", "def THING(rows): return 'abc'"]
)
def test_broken_advice_costs_its_own_lines(text: str, broken: Callable[..., None]) -> None:
    broken("advice", text)
    (said,) = [line for line in advice_on(pair_rows(0.5)) if "left out" in line]
    assert "the advice 'odd' of bench-odd 1.5" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", [*BROKEN, "def THING(path, given): return 5", "def THING(path, given): 1 / 0"]
)
def test_a_broken_reading_of_points_stops_no_other(
    text: str, broken: Callable[..., None], tmp_path: Path
) -> None:
    rates = [0.1 * 2**k for k in range(12)]
    points = tmp_path / "flow.csv"
    rows = "".join(f"{rate},{5 + rate}\n" for rate in rates)
    points.write_text(f"Shear rate [1/s],Shear stress [Pa]\n{rows}", encoding="utf-8")
    broken("points", text)
    command = f"erclutch flowcurve {points}"
    assert tried_flow_command(str(points), {}) in (command, "")  # "" where the wing is not there


@pytest.mark.slow
@pytest.mark.parametrize(
    "part",
    [
        "suffixes=None",
        "suffixes='.csv'",
        "suffixes=(5,)",
        "claims=None",
        "claims=odd",
        "claims=lambda head: np.array([1, 2])",
        "read=None",
        "takes=5",
        "takes=odd",
        "joins=5",
        "joins=odd",
        "parts=5",
        "folder=5",
        "folder='/'",
        "folder='x\\0'",
        "tells_damage=None",
        "extent=5",
        "recordings=5",
    ],
)
def test_a_broken_reader_stops_no_other(part: str, broken: Callable[..., None], log: Path) -> None:
    broken("readers", f"{READER}\nTHING = LogReader(**{{**ALL, **dict({part})}})")
    assert read_table(log).rows == 2
    assert ".csv" in log_suffixes()
    assert folder_reader(log.parent) is None
    assert find(READERS, log_at(log).plugin.name).own


TABLE = Table("odd", {"a": np.zeros(3), "b": np.ones(3)}, {"a": "V"}, "")


@pytest.mark.parametrize(
    "part",
    [
        {"columns": {"a": np.zeros(3), "b": np.zeros(4)}},
        {"columns": {"a": np.zeros((3, 1))}},
        {"columns": {"a": np.zeros(3) + 1j}},
        {"columns": {5: np.zeros(3)}},
        {"columns": 5},
        {"units": {"a": 5}},
        {"units": None},
        {"digest": None},
        {"notes": (5,)},
        {"notes": "abc"},
        {"numbers": {"a": "x"}},
        {"sample_period": -1.0},
        {"sample_period": np.nan},
        {"clock": np.zeros(2)},
        {"clock": [0, 1, 2]},
        {"constants": {"a": np.inf}},
        {"metadata": {"erclutch": 5}},
        {"unsampled": np.zeros(3)},
        {"first_row": -1},
        {"breaks": (-1,)},
        {"row_names": ("a",)},
        {"words": {"a": 5}},
        {"sweeps": np.zeros(3)},
    ],
)
def test_what_a_reader_gives_is_looked_at(
    part: dict[str, Any], broken: Callable[..., None]
) -> None:
    broken("readers", READER + "THING = LogReader(**ALL)")
    with pytest.raises(PluginError, match=r"the reader 'odd' of bench-odd 1\.5"):
        sound_table(Table(**{**vars(TABLE), **part}), find(READERS, "odd"))


@pytest.mark.slow
def test_a_column_without_a_unit_has_none(broken: Callable[..., None]) -> None:
    broken("readers", READER + "THING = LogReader(**ALL)")
    assert sound_table(TABLE, find(READERS, "odd")).units == {"a": "V", "b": None}


@pytest.mark.parametrize(
    "windows",
    [[(0, 3, None)], [5], [(1, 3, TABLE)], [(0, 9, TABLE)], [(0, 3, TABLE), (0, 3, TABLE)]],
)
def test_a_reader_that_lies_about_its_rows_is_named(
    windows: list[Any], broken: Callable[..., None]
) -> None:
    broken("readers", READER + "THING = LogReader(**ALL)")
    plugin, source = find(READERS, "odd"), Any
    with pytest.raises(PluginError, match=r"the reader 'odd' of bench-odd 1\.5"):
        list(sound_windows(lambda *_: iter(windows), plugin)(source, 10, 0, 0, None))  # pyright: ignore[reportArgumentType]
    for check, given in ((sound_extent, (-1, 2)), (sound_extent, 5), (sound_names, [1])):
        with pytest.raises(PluginError, match="bench-odd"):
            check(given, plugin)
    for check, given in ((sound_names, ["a", "a"]), (sound_tables, {"a": None})):
        with pytest.raises(PluginError, match="bench-odd"):
            check(given, plugin)


def test_a_reader_that_fails_is_named(broken: Callable[..., None], log: Path) -> None:
    broken("readers", READER + "THING = LogReader(**ALL)")
    log.write_bytes(b"ODD 1")
    plugin = log_at(log).plugin
    assert isinstance(plugin.value, LogReader)
    with pytest.raises(PluginError, match=r"'odd' of bench-odd 1\.5 failed on log\.csv: Zero"):
        read_table(log)


@pytest.mark.parametrize("text", [*BROKEN, LAW + "THING = replace(THING, aliases=None)"])
def test_a_broken_law_stops_no_list_of_laws(text: str, broken: Callable[..., None]) -> None:
    broken("laws", text)
    assert "odd" not in law_names()
    assert "bingham" in law_names()
    with pytest.raises(SettingError, match="unknown law 'nosuch'"):
        law_from_name("nosuch")
    with pytest.raises(PluginError, match=r"the law 'odd' of bench-odd 1\.5"):
        law_from_name("odd")


@pytest.mark.parametrize(
    "part",
    [
        "title=5",
        "shape=5",
        "columns=None",
        "gains=(5,)",
        "paper_form=5",
        "shape=(OURS.law, 5)",
    ],
)
def test_the_parts_of_a_law_are_looked_at(part: str, broken: Callable[..., None]) -> None:
    text = f"{LAW}\ndef odder(form):\n    return replace(odd(form), {part})\n"
    broken("laws", f"{text}THING = replace(THING, law=odder)")
    with pytest.raises(PluginError, match=r"the law 'odd' of bench-odd 1\.5"):
        law_from_name("odd")


@pytest.mark.parametrize(("low", "high"), [("1.0", "0.0"), ("float('nan')", "1.0"), ("0.0", "'x'")])
def test_bounds_that_no_search_can_use_are_refused(
    low: str, high: str, broken: Callable[..., None]
) -> None:
    text = f"""{LAW}
from erclutch.models.laws.law import ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP
def odder(form):
    number = ShapeParameter("q", "anything", {low}, {high})
    return replace(odd(form), shape=(TRANSITION_SLIP, number))
"""
    broken("laws", f"{text}THING = replace(THING, law=odder)")
    with pytest.raises(PluginError, match="has a parameter q from"):
        law_from_name("odd")


@pytest.mark.parametrize(
    "part",
    [
        "name = 5",
        "title = None",
        "place = []",
        "parameters = lambda *_: 5",
        "parameters = lambda *_: (5,)",
        "parameters = lambda *_: 1 / 0",
    ],
)
def test_the_parts_of_a_stage_are_looked_at(part: str, broken: Callable[..., None]) -> None:
    text = "from erclutch.models.stages import stage_named\n"
    text += "OURS = type(stage_named('lag'))\nclass Odd(OURS):\n    name = 'odd'\n"
    broken("stages", f"{text}    {part}\nTHING = object.__new__(Odd)")
    with pytest.raises(PluginError, match=r"the stage 'odd' of bench-odd 1\.5"):
        stages_of("odd")


@pytest.mark.slow
def test_what_a_package_prints_as_it_is_imported_is_in_no_table(
    broken: Callable[..., None], capsys: pytest.CaptureFixture[str], log: Path
) -> None:
    broken("readers", f"print('noise')\n{READER}\nTHING = LogReader(**ALL)")
    read_table(log)
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "noise" in printed.err
