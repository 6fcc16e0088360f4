"""Without wings the core stands: a copy without them passes the core's tests, and no wing is needed for a fit."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from erclutch.logs.synthetic import write_synthetic_log
from erclutch.registry import GROUPS, plugins
from tests.support.warm_start import OF_OTHERS, WarmStart
from tests.support.wings_asked import NO_GROUP_OF_A_WING, arguments, asking_tests

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
WINGS = sorted(
    folder.name
    for folder in (ROOT / "src/erclutch/wings").iterdir()
    if (folder / "__init__.py").exists()
)
#: Commands of a wing that must be gone with it, and what the core keeps.
COMMANDS = {
    wing: {
        path.stem.replace("_", "-")
        for path in (ROOT / f"src/erclutch/wings/{wing}/commands").glob("[!_]*.py")
    }
    for wing in WINGS
}

#: What a user does with a small log, in one process.
USE = """
import sys
sys.path.insert(0, {sources!r})
from erclutch.cli import main
assert sys.modules[main.__module__].__file__.startswith({sources!r})
quick = ["--models", "bingham", "--lag", "none", "--out", "run"]
uses = (["fit", "log.csv", *quick], ["report", "run"], ["export", "run", "--out", "c"], ["laws", "--plugins"])
for words in (["--help"], [], *uses):
    print("##", *words, flush=True)
    assert main(words) == 0, words
for command in {gone!r}:
    assert main([command]) == 2, command
"""


@pytest.fixture(scope="module")
def warm() -> Iterator[WarmStart]:
    """Python with what erclutch imports of others, which takes as long as the use; of erclutch it has nothing."""
    with (
        tempfile.TemporaryDirectory(prefix="erclutch-") as folder,
        WarmStart(Path(folder), OF_OTHERS) as made,
    ):
        yield made


def run(
    folder: Path, *words: object, python: object = sys.executable
) -> subprocess.CompletedProcess[str]:
    """Python with the sources of a folder, in that folder."""
    own = {**os.environ, "PYTHONPATH": f"{folder / 'src'}{os.pathsep}{folder}", "COLUMNS": "100"}
    own["ERCLUTCH_FEW_EXAMPLES"] = "1"  # with the wings, all of them are drawn
    command = [str(python), *map(str, words)]
    return subprocess.run(
        command, cwd=folder, env=own, capture_output=True, text=True, timeout=1500, check=False
    )


@pytest.fixture
def without(tmp_path: Path) -> Callable[..., Path]:
    """Makes a copy of the sources, and of further folders, without some wings."""

    def made(wings: list[str], *further: str) -> Path:
        gone = [
            ROOT / place / wing for place in ("src/erclutch/wings", "tests/wings") for wing in wings
        ]
        for name in ("src", *further):
            shutil.copytree(
                ROOT / name,
                tmp_path / name,
                ignore=lambda at, names: {n for n in names if Path(at, n) in gone},
            )
        return tmp_path

    return made


def listed(said: str) -> set[str]:
    """First words of the entries of a help page, two spaces from its edge."""
    return {line.split()[0] for line in said.splitlines() if re.match(r"  \S", line)}


@pytest.mark.parametrize("wing", WINGS)
def test_without_one_wing_a_log_is_fitted_and_reported(
    wing: str, without: Callable[..., Path], warm: WarmStart
) -> None:
    folder = without([wing])
    write_synthetic_log(folder / "log.csv", 2.0)
    use = folder / "use.py"
    use.write_text(USE.format(sources=str(folder / "src"), gone=sorted(COMMANDS[wing])))
    done = run(folder, use, python=warm.folder / "warm-python")
    assert done.returncode == 0, done.stdout + done.stderr
    page = done.stdout.partition("What to do first")[0]
    kept = set[str]().union(*(COMMANDS[other] for other in WINGS if other != wing))
    assert kept <= listed(page)
    assert not COMMANDS[wing] & listed(page)
    assert (folder / "run" / "report.html").exists()
    for command in COMMANDS[wing]:
        assert f"there is no command '{command}'" in done.stderr
        assert f"  erclutch {command} " not in done.stdout


@pytest.mark.parametrize(
    ("wing", "command"), [("rig", ("live", "--seconds", "1")), ("rig", ("reproduce", "table2"))]
)
def test_what_needs_a_missing_wing_says_so_in_one_line(
    wing: str, command: tuple[str, ...], without: Callable[..., Path]
) -> None:
    done = run(without([wing]), "-m", "erclutch", *command)
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stderr == (
        f"error: the command {command[0]!r} needs the wing {wing}, whose folder is not there. "
        "Install erclutch whole: its package has all wings.\n"
    )


def test_these_rooms_look_up_nothing_that_a_wing_brings() -> None:
    """But for the readers of logs, for which `tests/logs/conftest.py` looks at each test."""
    wings = ROOT / "src/erclutch/wings"
    brought = {
        group for group in GROUPS for _ in wings.glob(f"*/{group.rpartition('.')[2]}/[!_]*.py")
    }
    assert brought >= {"erclutch.commands", "erclutch.readers", "erclutch.targets"}
    for room in (*NO_GROUP_OF_A_WING, "files"):
        for path in (ROOT / "src/erclutch" / room).rglob("*.py"):
            allowed = {"erclutch.readers"} if path.name == "log_reader.py" else set[str]()
            named = set(re.findall(r"erclutch\.\w+", path.read_text("utf-8")))
            assert not named & {*brought, "erclutch.wings"} - allowed, path
    readers = [
        plugin
        for plugin in plugins("erclutch.readers")
        if plugin.source.startswith("erclutch.wings.")
    ]
    assert readers
    assert [
        plugin.name for plugin in readers if plugin.value.suffixes
    ] == []  # or folders would have other logs


def test_a_test_is_asked_that_leads_to_a_wing_by_a_helper_a_fixture_or_a_name_in_a_text(
    tmp_path: Path,
) -> None:
    made = """
        import subprocess
        import pytest
        RUN = subprocess.run
        def started(): return RUN(["true"])
        @pytest.fixture
        def done(): return started()
        def test_by_a_helper(): started()
        def test_by_a_fixture(done): assert done
        def test_by_a_name_in_a_text(request): request.getfixturevalue("done")
        def test_alone(tmp_path): assert tmp_path
    """
    file = tmp_path / "test_made.py"
    file.write_text(textwrap.dedent(made))
    assert asking_tests(file) == {
        "test_by_a_helper",
        "test_by_a_fixture",
        "test_by_a_name_in_a_text",
    }
    assert f"{file}::test_alone" not in arguments(file)
    other = tmp_path / "test_other.py"
    other.write_text("def test_alone(): pass\n# subprocess, main( and other words of a comment\n")
    assert arguments(other) == []


def test_without_all_wings_the_tests_of_the_core_pass(without: Callable[..., Path]) -> None:
    """All but those that cannot tell whether wings are there: of the rooms above, what no word may lead to a wing."""
    folder = without(WINGS, "tests", "studies", "examples")
    for name in ("pyproject.toml", "CITATION.cff"):
        shutil.copy(ROOT / name, folder)
    if (
        ROOT.parent / "shared"
    ).is_dir():  # recordings that tests of the core read stand beside the project
        folder = folder.rename(folder.with_name("project"))
        (folder.parent / "shared").symlink_to(ROOT.parent / "shared")
    of_files = ROOT / "tests/test_files.py"  # the room `files` stands below all others
    elsewhere = ("house", "docs", "wings", of_files.name, *NO_GROUP_OF_A_WING)
    rooms = [path for path in sorted((folder / "tests").iterdir()) if path.name not in elsewhere]
    below = [of_files]
    for room in NO_GROUP_OF_A_WING:
        below += sorted((ROOT / "tests" / room).rglob("test_*.py"))
    asking = [Path(argument).relative_to(ROOT) for path in below for argument in arguments(path)]
    asked = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow", *asking)
    done = run(
        folder, *asked, *(path for path in rooms if path.is_dir() or path.name.startswith("test_"))
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-2000:]
