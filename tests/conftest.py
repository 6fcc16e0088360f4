"""What all tests share: where ERCLUTCH_NO_SKIP=1 is set, a test that cannot run is a failure.

Some tests pin what they find: the fixture `pinned` compares it with the file of the test's name that ends in `.json`.
`ERCLUTCH_PIN=1 python -m pytest FILE` writes that file anew after a change that is meant.
"""

from __future__ import annotations

import gc
import json
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from xdist.scheduler import LoadScopeScheduling

from tests.support.examples import examples

# Tests run side by side: threads of one's matrix products would only wait for the processors that another one uses.
# Set before NumPy is imported, and inherited by the commands that tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Tests write thousands of small files over each other, and on a disk each of them is waited for. Programs that tests
# compile are run from there too, so a memory disk has to let them.
_MEMORY_DISK = "/dev/shm"
_ROOM = 4 * 2**30  # bytes; all tests together leave a twentieth of that


def memory_disk() -> str | None:
    """The memory disk of this machine, where it has room and runs programs; None elsewhere."""
    if not os.access(_MEMORY_DISK, os.W_OK | os.X_OK):
        return None
    disk = os.statvfs(_MEMORY_DISK)
    has_room = disk.f_bavail * disk.f_frsize >= _ROOM
    return _MEMORY_DISK if has_room and not disk.f_flag & os.ST_NOEXEC else None


if "PYTEST_DEBUG_TEMPROOT" not in os.environ and sys.platform == "linux":
    found = memory_disk()
    if found is not None:
        os.environ["PYTEST_DEBUG_TEMPROOT"] = found

# Whether a test passes does not depend on how busy the machine is. CI says the same of a commit each time, so that a
# change is not refused for what another one brought; elsewhere each run draws new examples, and finds it.
settings.register_profile(
    "any machine",
    deadline=None,
    max_examples=examples(100),
    derandomize=os.environ.get("ERCLUTCH_NO_SKIP") == "1",
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("any machine")

#: Files and folders whose tests share what is slow to make (a fit, a long log, parsed sources, the compiled twin, an
#: installed wheel, a browser), or keep time at 1 kHz. `--dist loadgroup` runs each group in one process.
TOGETHER = {
    "tests/test_files.py": "files",
    "tests/fit/test_comparison.py": "comparison",
    "tests/docs/test_site.py": "site",
    "tests/cli/test_cli.py": "cli",
    "tests/fit/test_centroids.py": "centroids",
    "tests/fit/test_hard_logs.py": "hard logs",
    "tests/fit/test_one_field.py": "one field",
    "tests/fit/test_real_recordings.py": "real recordings",
    "tests/wings/live/": "live",
    "tests/models/networks/test_residual.py": "residual",
    "tests/wings/paper/test_online.py": "online",
    "tests/plugins/test_examples.py": "plugins",
    "tests/report/test_bad_runs.py": "report",
    "tests/report/test_diagnostics.py": "report",
    "tests/report/test_in_browser.py": "report",
    "tests/report/test_latex.py": "report",
    "tests/report/test_model_section.py": "report",
    "tests/report/test_loops.py": "report",
    "tests/report/test_notebook.py": "report",
    "tests/report/test_painters.py": "report",
    "tests/report/test_printed_table.py": "report",
    "tests/report/test_report.py": "report",
    "tests/report/test_run_figures.py": "report",
    "tests/report/test_printed_page.py": "report",
    "tests/wings/rig/": "twin",
    "tests/runs/test_every_row.py": "every-row",
    "tests/house/test_house.py": "house",
    "tests/house/test_supply_chain.py": "wheel",
    "tests/house/test_wings_off.py::test_without_one_wing": "one wing",
    "tests/export/test_self_check.py": "self-check",
    "tests/wings/exporters/test_targets.py::test_a_plain_c_host": "fmus",
    "tests/wings/exporters/test_targets.py::test_zig_builds": "fmus",
    "tests/wings/exporters/test_targets.py::test_a_host_on_windows": "fmus",
    "tests/runs/test_run_json.py": "run.json",
    "tests/fit/test_final_fit.py": "final fit",
    "tests/report/test_other_logs.py": "other logs",
    "tests/wings/app/test_app_road.py": "app road",
    "tests/wings/fleet/test_fleet.py": "fleet",
    "tests/wings/paper/test_experiments.py": "experiments",
    "tests/wings/rheology/test_flowcurve.py::test_held_out_rates_judge": "all laws on a curve",
    "tests/wings/rheology/test_flowcurve.py::test_the_yield_stress_that": "all laws on a curve",
}
#: Slow tests that take a minute or more: they come before the others, so that no processor waits for them at the end.
LONGEST = (
    "tests/house/test_wings_off.py::test_without_all_wings",
    "tests/wings/design/test_excite.py::test_of_ten_thousand_sequences",
    "tests/wings/rheology/test_measured_flow_curves.py::test_every_law",
    "tests/docs/test_blocks.py::test_every_block_of_the_page_runs",
)
#: Where files are read as a user reads them: in a child process, which is tested here or held by no test alone.
IN_A_CHILD = ("tests/logs/", "tests/runs/", "tests/test_files.py")
#: Tests of one exported model: its step, its C and its test vectors are made once.
EXPORTED = re.compile(r"tests/(?:export|wings/exporters)/.*\[(?P<label>.*?, (single|coaxial))")


@cache
def group_of(nodeid: str, by_file: bool) -> str:
    """The group of a test; where it stands in none its file, or the test itself."""
    group = next((group for place, group in TOGETHER.items() if nodeid.startswith(place)), None)
    if group is not None:
        return group
    exported = EXPORTED.match(nodeid)
    if exported:
        return exported["label"]
    return nodeid.partition("::")[0] if by_file else nodeid


class _Places(list[str]):
    """Names of tests, and the place of each: a list looks through its thousands of names for one of them."""

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__(names)
        self._place = {name: place for place, name in enumerate(names)}

    def index(self, name: str, *_: Any) -> int:
        return self._place[name]


class GroupsByFile(LoadScopeScheduling):
    """Groups as in `TOGETHER`. The mark ``xdist_group`` does nothing with pytest 9.2 and pytest-xdist 3.8."""

    def _split_scope(self, nodeid: str) -> str:
        # Fast tests of a file take seconds together, and share what the file makes; a slow test may take a minute.
        by_file = str(self.config.getoption("markexpr")).startswith("not slow")
        return group_of(nodeid, by_file)

    def add_node_collection(self, node: Any, collection: Sequence[str]) -> None:
        """Keep the tests of a process so that each is found at once."""
        super().add_node_collection(node, collection)
        self.registered_collections[node] = _Places(collection)

    def mark_test_complete(self, node: Any, item_index: int, duration: float = 0) -> None:
        """Drop a group that has ended: its tests were counted again after each of thousands of later tests."""
        super().mark_test_complete(node, item_index, duration)
        groups = self.assigned_work[node]
        ended = self._split_scope(self.registered_collections[node][item_index])
        if all(groups[ended].values()):
            del groups[ended]


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> GroupsByFile | None:
    """Hand out tests by group, where that is asked for."""
    return GroupsByFile(config, log) if config.getvalue("dist") == "loadgroup" else None


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Files that hold no test of those that are asked for are not imported, which takes seconds of each process."""
    named = {config.invocation_params.dir / argument.partition("::")[0] for argument in config.args}
    if not collection_path.match("test_*.py") or collection_path in named:
        return None
    asked = str(config.getoption("markexpr"))
    if asked.startswith("timed"):
        return None if _says(collection_path, _TIMED) else True
    if asked in ("slow", "not timed and (slow)"):
        return None if _says(collection_path, _SLOW) else True
    if asked.startswith("not slow"):
        return True if _says(collection_path, _ALL_SLOW) else None
    return None


#: What a file says that has tests with a mark. Tests with an argument ``model`` are slow for most models.
_TIMED = re.compile(r"mark\.timed")
_SLOW = re.compile(r"mark\.slow|slow_but|slow_behind|\bmodel: ")
#: What a file says that has no other tests.
_ALL_SLOW = re.compile(r"^pytestmark = (?:\[\n    )?pytest\.mark\.slow\b", re.MULTILINE)


@cache
def _says(path: Path, words: re.Pattern[str]) -> bool:
    return words.search(path.read_text("utf-8")) is not None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest tests first, where tests are handed out to several processes; no timed or slow test is missed."""
    for item in items:
        for mark, words in (("timed", _TIMED), ("slow", _SLOW)):
            if item.get_closest_marker(mark) and not _says(item.path, words):
                raise pytest.UsageError(
                    f"{item.nodeid}: write pytest.mark.{mark} in its file, or `make test-slow` misses it"
                )
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: not item.nodeid.startswith(LONGEST))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, Any, Any]:
    """What is imported and collected stays: the garbage collector took a quarter of the time to look through it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish() -> None:
    """Let tests share what is the same for all of them: options of commands, and objects that no test lets go.

    The garbage collector passes over modules, test items, cached models. To look through these again and again took a
    twentieth of the time of all tests.
    """
    if "erclutch.cli" in sys.modules:
        from tests.support.options_once import build_options_once

        build_options_once()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


def _strict() -> bool:
    return os.environ.get("ERCLUTCH_NO_SKIP") == "1"


def _fail(report: Any) -> None:
    """Turn a skip into a failure. An expected failure is no skip."""
    if not report.skipped or hasattr(report, "wasxfail"):
        return
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    report.outcome = "failed"
    report.longrepr = f"ERCLUTCH_NO_SKIP=1 allows no skip: {reason}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, Any, Any]:
    report = yield
    if _strict():
        _fail(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    report = yield
    if _strict():
        _fail(report)
    return report


_NUMBER = re.compile(r"([-+]?(?:\d[\d,]*\.?\d*(?:e[-+]?\d+)?|\bnan\b|\binf\b))", re.IGNORECASE)


def _same(found: Any, expected: Any, rel: float, least: float) -> bool:
    """Whether two JSON values are alike; numbers, those inside texts too, may differ by a share."""
    if isinstance(expected, dict):
        alike = isinstance(found, dict) and found.keys() == expected.keys()
        return alike and all(_same(found[k], v, rel, least) for k, v in expected.items())
    if isinstance(expected, list):
        return len(found) == len(expected) and all(
            _same(f, e, rel, least) for f, e in zip(found, expected, strict=True)
        )
    if isinstance(expected, float) and isinstance(found, int | float):
        return found == pytest.approx(expected, rel=rel, abs=least, nan_ok=True)
    if isinstance(expected, str) and isinstance(found, str) and found != expected:
        parts = [_NUMBER.split(text) for text in (found, expected)]
        if parts[0][::2] != parts[1][::2]:
            return False
        numbers = [[float(x.replace(",", "")) for x in one[1::2]] for one in parts]
        return numbers[0] == pytest.approx(numbers[1], rel=rel, abs=least, nan_ok=True)
    return type(found) is type(expected) and found == expected


def _in_json(value: Any) -> Any:
    """Arrays and numbers of NumPy as those of Python."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


@pytest.fixture
def pinned(request: pytest.FixtureRequest) -> Callable[..., None]:
    """``pinned(found, rel=1e-6)`` fails where a value differs from the one that is kept for this test.

    Numbers may differ by a share ``rel``, or by ``least`` where they are that small.
    """
    path, key = Path(str(request.node.path)).with_suffix(".json"), request.node.name

    def check(found: Any, rel: float = 1e-6, least: float = 1e-300) -> None:
        found = json.loads(json.dumps(found, default=_in_json))
        kept = json.loads(path.read_text("utf-8")) if path.exists() else {}
        if os.environ.get("ERCLUTCH_PIN") and not _same(found, kept.get(key), rel, least):
            kept[key] = found
            lines = ",\n".join(f"{json.dumps(k)}: {json.dumps(v)}" for k, v in sorted(kept.items()))
            path.write_text(f"{{\n{lines}\n}}\n", "utf-8")
        if not _same(found, kept[key], rel, least):
            assert found == kept[key]  # pytest shows where they differ

    return check


@pytest.fixture(scope="session", autouse=True)
def messages_as_written() -> Generator[None, Any, Any]:
    """Messages are written with a shell's options, and tests look at them so; `tests/test_errors.py` at Python's."""
    from erclutch.errors import for_a_shell

    with for_a_shell():
        yield


@pytest.fixture
def compiled_plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exports are compiled without optimisation, which takes most of the time and changes no bit.

    `tests/export/test_conformance.py` shows that for every model, compiler and level.
    """
    from erclutch.export.c.compilers import Compiler

    build = Compiler.build

    def plainly(self: Compiler, sources: Sequence[Path], out: Path, *flags: str) -> None:
        build(self, sources, out, *("-O0" if flag in ("-O2", "-O3") else flag for flag in flags))

    monkeypatch.setattr(Compiler, "build", plainly)


@pytest.fixture(scope="module", autouse=True)
def as_this_room_reads(request: pytest.FixtureRequest) -> Generator[None, Any, Any]:
    """Most rooms take it as given that a log or a run's rows can be read: there no child is started for each."""
    with pytest.MonkeyPatch.context() as patch:
        if not request.node.nodeid.startswith(IN_A_CHILD):
            _read_here(patch)
        yield


@pytest.fixture
def read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of sound bytes are read in this process: a child costs a start of Python, and has tests of its own."""
    # A test may put in something else by the same patch: both are undone in the right order.
    _read_here(monkeypatch)


def _read_here(patch: pytest.MonkeyPatch) -> None:
    from erclutch.logs.readers import child_process, reader_in_child
    from erclutch.runs import kept_columns

    def run(
        module: str, path: Path, *arguments: str, memory: int | None = None
    ) -> child_process.Answer:
        with (
            tempfile.TemporaryDirectory() as folder,
            warnings.catch_warnings(),
            pytest.MonkeyPatch.context() as of_child,
        ):
            warnings.simplefilter("ignore")
            of_child.setattr(sys, "argv", [module, str(path), folder, "0", "0", *arguments])
            of_run = module == kept_columns.__name__
            code = child_process.serve(
                kept_columns.decoded if of_run else reader_in_child.answer_of
            )
            return child_process._answer(Path(folder), code, b"", 1 << 30)

    def stream(
        module: str, path: Path, *arguments: str, memory: int | None = None
    ) -> Iterator[child_process.Answer]:
        yield from import_module(module)._asked(str(path), *arguments)

    patch.setattr(child_process, "limit_process", lambda memory, seconds: None)
    patch.setattr(child_process, "run", run)
    patch.setattr(child_process, "stream", stream)
