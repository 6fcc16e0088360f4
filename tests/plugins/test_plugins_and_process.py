"""A plug-in changes no number and no place of others: what it changes of the process is put back, or refused."""

from __future__ import annotations

import json
import locale
import os
import platform
import signal
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.arithmetic import elementary
from erclutch.arithmetic.dual import Dual
from erclutch.errors import PluginError, SpoiltError
from erclutch.export.c.compilers import natives
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.fit_progress import FitStep
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.laws import law_from_name
from erclutch.models.stages import stage_named, stages_at, stages_of
from erclutch.registry import find
from tests.support.command import run
from tests.support.installed_plugin import Install, install
from tests.support.pair import single_log

__all__ = ["install"]
LAW = """
import os, sys
from dataclasses import replace
import numpy as np
from erclutch.models.laws.bingham import LAW as OURS
{at_import}

def columns(E, w, *numbers):
    {at_work}
    return OURS.law(FORM).columns(E, w, *numbers)

def odd(form):
    global FORM
    FORM = form
    return replace(OURS.law(form), name="odd", columns=columns, **dict({of_law}))

THING = replace(OURS, law=odd, ladder={{}}, aliases=(), **dict({of_family}))
"""
STAGE = """
import copy
from erclutch.models.stages import stage_named
OURS = stage_named("lag")
THING = copy.copy(OURS)
object.__setattr__(THING, "name", "odd")
said = property(lambda stage: {text!r})
object.__setattr__(THING, "__class__", type("Odd", (type(OURS),), {{{part!r}: said}}))
"""
FAST = """
#include <xmmintrin.h>
__attribute__((constructor)) static void begin(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
"""
LONG = "ab " * 8000
HIDING = "\u202ewal a"


@pytest.fixture
def law(install: Install) -> Callable[..., None]:
    """Makes a package with the law ``odd``, which does more than a law."""

    def make(
        at_import: str = "", at_work: str = "pass", of_law: str = "", of_family: str = ""
    ) -> None:
        text = LAW.format(at_import=at_import, at_work=at_work, of_law=of_law, of_family=of_family)
        install("bench-odd", "[erclutch.laws]\nodd = bench_odd:THING\n", text)

    return make


@pytest.mark.parametrize(
    "change",
    [
        "np.tanh = lambda x: 1.2 * x",
        "np.sqrt, np.mean = np.exp, np.exp",
        "np.pi = 3",
        "import math; math.exp = abs",
        "np.linalg.lstsq = None",
        "del np.float64",
        "import builtins; builtins.sum = max",
        "import json; json.dumps = repr",
        "import erclutch.arithmetic.elementary as e; e.tanh = abs",
    ],
)
def test_a_package_that_replaces_what_all_compute_with_is_refused(
    change: str, law: Callable[..., None]
) -> None:
    def shared() -> list[object]:
        numeric = np.tanh, np.sqrt, np.mean, np.pi, np.linalg.lstsq, np.float64
        return [*numeric, sum, json.dumps, elementary.tanh]

    before = shared()
    law(at_import=change)
    with pytest.raises(PluginError, match=r"'odd' of bench-odd 1\.5 changes what all others"):
        law_from_name("odd/square")
    assert shared() == before


def test_a_package_may_add_to_numpy(law: Callable[..., None]) -> None:
    law(at_import="np.of_tests = 5")
    assert law_from_name("odd/square").name == "odd"
    del np.of_tests  # type: ignore[attr-defined]


@pytest.mark.parametrize("when", ["at_import", "at_work"])
def test_folder_depth_and_answers_to_overflow_are_put_back(
    when: str, law: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    place, depth, faults = os.getcwd(), sys.getrecursionlimit(), np.geterr()
    elsewhere = str(tmp_path / "elsewhere")
    law(**{when: f"os.chdir({elsewhere!r}); sys.setrecursionlimit(900); np.seterr(all='raise')"})
    found = law_from_name("odd/square")
    found.columns(np.ones(60), np.ones(60), 0.1)
    assert (os.getcwd(), sys.getrecursionlimit(), np.geterr()) == (place, depth, faults)


def mode_of_files() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


CHANGES = {
    "mode of new files": ("os.umask(0)", mode_of_files),
    "streams": ("sys.stdout = sys.stderr = None", lambda: (sys.stdout, sys.stderr)),
    "signals": (
        "import signal; [signal.signal(number, signal.SIG_IGN) for number in (1, 2, 15)]",
        lambda: [signal.getsignal(number) for number in (1, 2, 15)],
    ),
    "language": (
        f"import locale; locale.setlocale(locale.LC_ALL, {'POSIX'!r})",
        lambda: locale.setlocale(locale.LC_ALL),
    ),
    "warnings": (
        "import warnings; warnings.simplefilter('always')",
        lambda: list(warnings.filters),
    ),
    "printed numbers": ("np.set_printoptions(legacy='1.13')", lambda: str(np.float64(1 / 3))),
}


@pytest.mark.parametrize("when", ["at_import", "at_work"])
@pytest.mark.parametrize("kind", CHANGES)
def test_what_a_process_has_one_of_is_put_back(
    kind: str, when: str, law: Callable[..., None]
) -> None:
    change, state = CHANGES[kind]
    kept, handlers = locale.setlocale(locale.LC_ALL), [signal.getsignal(n) for n in (1, 2, 15)]
    locale.setlocale(locale.LC_ALL, "C.UTF-8")
    try:
        before = state()
        law(**{when: change})
        law_from_name("odd/square").columns(np.ones(60), np.ones(60), 0.1)
        assert state() == before
    finally:
        locale.setlocale(locale.LC_ALL, kept)
        for number, handler in zip((1, 2, 15), handlers, strict=True):
            signal.signal(number, handler)


@pytest.mark.slow
def test_a_library_that_takes_the_least_numbers_for_zero_changes_no_number_of_others(
    law: Callable[..., None], tmp_path: Path
) -> None:
    """What old compilers link to programs of ``-ffast-math`` sets the processor so as they are loaded."""
    if platform.machine() != "x86_64" or not natives():
        pytest.skip("another processor has another way, and a compiler is needed")
    source = tmp_path / "fast.c"
    source.write_text(FAST, encoding="utf-8")
    natives()[0].build([source], tmp_path / "fast.so", "-shared", "-fPIC")
    law(at_import=f"import ctypes; ctypes.CDLL({str(tmp_path / 'fast.so')!r})")
    law_from_name("odd/square")
    assert np.nextafter(0.0, 1.0) * np.ones(1)[0] > 0.0


@pytest.mark.parametrize("change", ["np.tanh = np.exp", "builtins.sum = max"])
def test_a_law_that_replaces_what_all_compute_with_when_it_works_is_refused(
    change: str, law: Callable[..., None]
) -> None:
    before = np.tanh, sum
    law(at_import="import builtins", at_work=f"if np.size(w) > 50: {change}")
    found = law_from_name("odd/square")
    with pytest.raises(SpoiltError, match="changes what all others compute with"):
        found.columns(np.ones(60), np.ones(60), 0.1)
    assert (np.tanh, sum) == before


@pytest.mark.slow
def test_all_is_fitted_anew_without_a_law_that_changes_what_others_compute_with(
    law: Callable[..., None],
) -> None:
    """What others computed at that moment had another tanh."""
    law(at_work="np.tanh = np.exp if np.size(w) > 50 else np.tanh")
    steps: list[FitStep] = []
    settings = Settings(("bingham", "odd"), lag="none")
    compared = compare(build_dataset(single_log(1.0)), settings, progress=steps.append)
    (said,) = (each.message for each in compared.findings if each.subject == "left out")
    assert "changes what all others compute with, which was put back: numpy.tanh" in said
    assert [step.fitted for step in steps if step.fitted] == ["bingham", "bingham"]


@pytest.mark.slow
def test_a_run_lies_where_it_was_asked_for(
    law: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    law(at_work=f"os.chdir({str(tmp_path / 'elsewhere')!r})")
    write_synthetic_log(tmp_path / "log.csv", 1.0)
    code, _, told = run("fit", "log.csv", "--models", "odd", "--lag", "none", "--out", "run")
    assert code == 0, told
    assert (tmp_path / "run" / "run.json").is_file()
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_rows_are_given_to_a_law_to_be_read_alone(law: Callable[..., None]) -> None:
    """A law that changes them only where it may makes other numbers of the same rows."""
    law(
        at_work="w = np.multiply(w, 2, out=w) if getattr(w, 'flags', None) and w.flags.writeable else w"
    )
    found, ours = law_from_name("odd/square"), law_from_name("bingham/square")
    field, slip = np.linspace(0.0, 1.0, 60), np.linspace(-2.0, 2.0, 60)
    np.testing.assert_array_equal(
        found.columns(field, slip, 0.1), ours.columns(field, slip.copy(), 0.1)
    )
    assert slip[0] == -2.0
    seeded = Dual(np.full(60, 0.1), {0: np.ones(60)})
    for given, right in zip(
        found.columns(field, slip, seeded), ours.columns(field, slip, seeded), strict=True
    ):
        np.testing.assert_array_equal(
            getattr(given, "value", given), getattr(right, "value", right)
        )


def test_a_plug_in_that_is_refused_is_refused_again(law: Callable[..., None]) -> None:
    law(at_import="np.tanh = lambda x: 1.2 * x")
    for _ in range(2):
        with pytest.raises(PluginError, match="changes what all others"):
            find("erclutch.laws", "odd").value  # noqa: B018


@pytest.mark.parametrize("text", [LONG, HIDING, "\x1b[31m"], ids=["long", "hiding", "commanding"])
@pytest.mark.parametrize("part", ["title", "source"])
def test_what_a_law_is_called_fits_a_line(part: str, text: str, law: Callable[..., None]) -> None:
    """A title of 24,000 letters made each report as wide."""
    law(of_law=f"{part}={text!r}")
    with pytest.raises(PluginError, match="must have a title and a source: lines of up to"):
        law_from_name("odd/square")


@pytest.mark.parametrize("part", ["formula", "about", "curves"])
def test_what_is_said_of_a_law_fits_a_page(part: str, law: Callable[..., None]) -> None:
    law(of_family=f"{part}={LONG!r}")
    with pytest.raises(PluginError, match=f"as its {part}"):
        law_from_name("odd/square")


@pytest.mark.parametrize("part", ["title", "source", "equation"])
def test_what_is_said_of_a_stage_fits_a_line(part: str, install: Install) -> None:
    for kept in (stage_named, stages_of, stages_at):  # of the test before
        kept.cache_clear()
    text = STAGE.format(part=part, text=LONG)
    install("bench-odd", "[erclutch.stages]\nodd = bench_odd:THING\n", text)
    with pytest.raises(PluginError, match="lines of up to"):
        stages_of("odd")
