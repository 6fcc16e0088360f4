"""A plug-in that is sound on a few rows and wrong on many is named, and what needs no part of it is fitted."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.errors import PluginError
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.stages import stage_named, stages_at, stages_of
from erclutch.registry import find, others_at_work
from tests.support.command import run
from tests.support.installed_plugin import Install, install
from tests.support.pair import single_log

pytestmark = pytest.mark.slow

__all__ = ["install"]
NAMED = r"'odd' of bench-odd 1\.5"
LAW = """
from dataclasses import replace
import numpy as np
from erclutch.models.laws.bingham import LAW as OURS

def columns(E, w, *numbers):
    first, second = OURS.law(FORM).columns(E, w, *numbers)
    if np.size(getattr(w, "value", w)) < 50:
        return first, second
    {on_many_rows}

def odd(form):
    global FORM
    FORM = form
    return replace(OURS.law(form), name="odd", columns=columns, **dict({further}))

THING = replace(OURS, law=odd, ladder={{}}, aliases=())
"""
STAGE = """
import copy
import numpy as np
from erclutch.models.stages import stage_named
OURS = stage_named("lag")

class Odd(type(OURS)):
    def respond(self, signal, clock, q, rows):
        given = OURS.respond(signal, clock, q, rows)
        {on_many_rows}

THING = copy.copy(OURS)
object.__setattr__(THING, "__class__", Odd)
object.__setattr__(THING, "name", "odd")
"""
KIND = """
from erclutch.fit.candidate import Grown, Kind

class Nothing:
    name = "odd"
    def fit(self, train, fitted, workers): {fits}
    def refit(self, train, kept, outcome, fitted): 1 / 0

class Odd(Kind):
    place = -5

    def means(self, model):
        return model.startswith("odd")

    def candidates(self, settings, train):
        {candidates}

    def grown(self, settings, train, fitted):
        {grown}

THING = Odd()
"""


@pytest.fixture
def broken(install: Install) -> Callable[..., None]:
    """Makes a package with one plug-in called ``odd``."""

    def make(group: str, text: str) -> None:
        for kept in (stage_named, stages_of, stages_at):  # of the test before
            kept.cache_clear()
        install("bench-odd", f"[erclutch.{group}]\nodd = bench_odd:THING\n", text)

    return make


@pytest.fixture(scope="module")
def rows() -> Dataset:
    return build_dataset(single_log(1.0))


def left_out(rows: Dataset, *models: str, lag: str = "none") -> str:
    """What is said of what is left out; the first of the models is fitted."""
    compared = compare(rows, Settings(models, lag=lag))
    assert models[0] in {entry.name.partition("+")[0] for entry in compared.entries}
    assert all("odd" not in entry.name for entry in compared.entries)
    (said,) = {str(each) for each in compared.findings if each.subject == "left out"}
    return said


ON_MANY_ROWS = [
    "return first, second[:3]",
    "return first, second[:, None]",
    "return first, second * np.nan",
    "return first, second * np.inf",
    "return (first,)",
    "return [first, second]",
    "return first, 5.0",
    "return first, 1j * second",
    "return first, None",
    "1 / 0",
    "raise SystemExit(0)",
]


@pytest.mark.parametrize("on_many_rows", ON_MANY_ROWS)
def test_a_law_that_is_wrong_on_many_rows_is_left_out(
    on_many_rows: str, broken: Callable[..., None], rows: Dataset
) -> None:
    broken("laws", LAW.format(on_many_rows=on_many_rows, further=""))
    said = left_out(rows, "bingham", "odd")
    assert "the law 'odd' of bench-odd 1.5" in said
    with pytest.raises(PluginError, match=NAMED):
        compare(rows, Settings(("odd",), lag="none"))


@pytest.mark.parametrize(
    "further",
    [
        "paper_form=lambda *_: 1 / 0",
        "paper_form=lambda *_: None",
        "paper_form=lambda *_: {5: 5}",
        "paper_form=lambda *_: {'a': 'b'}",
        "paper_form=lambda: {}",
        "stimulus=lambda E: E[:3] if np.size(E) > 50 else E",
        "stimulus=lambda E: 1 / 0 if np.size(E) > 50 else E",
    ],
)
def test_a_law_whose_other_functions_are_wrong_is_left_out(
    further: str, broken: Callable[..., None], rows: Dataset
) -> None:
    broken("laws", LAW.format(on_many_rows="return first, second", further=further))
    assert "the law 'odd' of bench-odd 1.5" in left_out(rows, "bingham", "odd")


def test_a_gain_of_a_further_input_is_refused(broken: Callable[..., None], rows: Dataset) -> None:
    further = "gains=tuple(replace(gain, extra=7) for gain in OURS.law(form).gains)"
    broken("laws", LAW.format(on_many_rows="return first, second", further=further))
    with pytest.raises(PluginError, match=f"{NAMED} has the gain T_y with extra 7"):
        compare(rows, Settings(("bingham", "odd"), lag="none"))


@pytest.mark.parametrize(
    "on_many_rows",
    [
        "return given[:3]",
        "return given * np.nan",
        "return None",
        "return [given, given]",
        "1 / 0",
    ],
)
def test_a_stage_that_is_wrong_on_many_rows_is_left_out(
    on_many_rows: str, broken: Callable[..., None], rows: Dataset
) -> None:
    broken("stages", STAGE.format(on_many_rows=on_many_rows))
    assert "the stage 'odd' of bench-odd 1.5" in left_out(rows, "bingham", "bingham+odd")


@pytest.mark.parametrize(
    ("candidates", "grown", "fits"),
    [
        ("1 / 0", "return Grown()", "pass"),
        ("return [5]", "return Grown()", "pass"),
        ("return []", "1 / 0", "pass"),
        ("return []", "return None", "pass"),
        ("return []", "return Grown([5])", "pass"),
        ("return [Nothing()]", "return Grown()", "1 / 0"),
        ("return [Nothing()]", "return Grown()", "return None"),
    ],
)
@pytest.mark.parametrize("models", [("bingham",), ("bingham", "odd-3")])
def test_a_kind_of_model_that_fails_stops_no_law(
    candidates: str,
    grown: str,
    fits: str,
    models: tuple[str, ...],
    broken: Callable[..., None],
    rows: Dataset,
) -> None:
    broken("kinds", KIND.format(candidates=candidates, grown=grown, fits=fits))
    assert "the kind of model 'odd' of bench-odd 1.5" in left_out(rows, *models)


def test_where_nothing_else_is_asked_for_the_kind_is_named(
    broken: Callable[..., None], rows: Dataset
) -> None:
    broken("kinds", KIND.format(candidates="1 / 0", grown="return Grown()", fits="pass"))
    with pytest.raises(PluginError, match=f"{NAMED} failed: ZeroDivisionError"):
        compare(rows, Settings(("odd-3",), lag="none"))


@pytest.mark.parametrize(
    "law",
    [
        LAW.format(on_many_rows="pass", further="columns=lambda *_: 1 / 0"),
        LAW.format(on_many_rows="pass", further="columns=lambda E, w, *_: (w[:2], w)"),
        LAW.format(on_many_rows="pass", further="title=5"),
        "1 / 0",
        "THING = None",
    ],
)
def test_a_list_of_laws_has_all_but_the_one_that_fails_and_names_it(
    law: str, broken: Callable[..., None], tmp_path: Path
) -> None:
    broken("laws", law)
    for words in (("laws",), ("laws", "--json")):
        done = run(*words, cwd=tmp_path)
        assert done.code == 0
        assert "bingham" in done.out
        assert "OURS" not in done.out
        assert "the law 'odd' of bench-odd 1.5" in done.error


@pytest.mark.parametrize(
    "stage", [STAGE.format(on_many_rows="pass") + "THING.__dict__['name'] = 5", "1 / 0"]
)
def test_a_list_of_stages_names_the_one_that_fails(
    stage: str, broken: Callable[..., None], tmp_path: Path
) -> None:
    broken("stages", stage)
    done = run("laws", cwd=tmp_path)
    assert done.code == 0
    assert "dahl" in done.out
    assert "the stage 'odd' of bench-odd 1.5" in done.error


def test_what_a_plugin_prints_while_it_works_is_no_part_of_the_answer(
    broken: Callable[..., None], tmp_path: Path
) -> None:
    text = LAW.format(on_many_rows="print('NOISE'); return first, second", further="")
    broken("laws", text)
    write_synthetic_log(tmp_path / "log.csv", seconds=1.0)
    words = ("fit", "log.csv", "--models", "odd", "--lag", "none", "--out", "made", "--json")
    done = run(*words, cwd=tmp_path)
    assert (done.code, done.out.count("NOISE")) == (0, 0), done.error
    assert "NOISE" in done.error
    json.loads(done.out)


@pytest.mark.parametrize(("group", "aside"), [("commands", False), ("laws", True)])
def test_what_a_command_of_others_prints_is_its_answer(
    group: str, aside: bool, broken: Callable[..., None]
) -> None:
    broken(group, "def THING(): pass")
    assert find(f"erclutch.{group}", "odd").guarded(others_at_work)() is aside
    assert not others_at_work()
