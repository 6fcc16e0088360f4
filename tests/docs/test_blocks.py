"""Every block of code in the documentation runs, in order, page by page, in a folder of its own, as a reader would.

Before a block a Markdown comment may say ``% file: NAME`` (the block is written to that file). After a block of shell
or Python a block of text is its output, where ``...`` stands for anything. On top of a page ``% needs: FOLDER/FILE``
names the recording that it is about, ``% tools: NAME NAME`` the programs that its blocks run. The Python blocks of a
page below ``notebooks`` are cells of one session.
"""

from __future__ import annotations

import os
import pkgutil
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from docs._ext.notebook_cells import FOLDER, cells_of
from tests.support.warm_start import WarmStart

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
RECORDINGS = ROOT.parent / "shared" / "data"
PAGES = sorted(page for page in DOCS.rglob("*.md") if "decisions" not in page.parts)
_BLOCK = re.compile(
    r"(?:^% file: (?P<file>\S+)\n)?^```(?P<language>\S+).*?\n(?P<body>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
#: Directives; the build itself runs the commands of a picture.
_DIRECTIVE = re.compile(r"^\{\w")


@dataclass(frozen=True)
class Block:
    language: str
    body: str
    file: str | None


def blocks_of(text: str) -> Iterator[Block]:
    for found in _BLOCK.finditer(text):
        if not _DIRECTIVE.match(found["language"]):
            yield Block(found["language"], found["body"], found["file"])


def runs(text: str) -> bool:
    return any(block.language in {"sh", "python"} for block in blocks_of(text))


@pytest.fixture(scope="module")
def warm() -> Iterator[WarmStart]:
    """`erclutch` and `python` without the second that each start of them takes."""
    with tempfile.TemporaryDirectory(prefix="erclutch-") as folder, WarmStart(Path(folder)) as made:
        yield made


def run(block: Block, folder: Path, warm: WarmStart) -> str:
    if block.language == "sh":
        command = ["bash", "-eu", "-o", "pipefail", "-c", block.body]
    else:
        script = folder / "block.py"
        script.write_text(block.body, encoding="utf-8")
        command = [warm.folder / "warm-python", script]
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    surroundings = {
        **os.environ,
        "PATH": path,
        "COLUMNS": "100",
        "NO_COLOR": "1",
        "PYTHONUTF8": "1",
    }
    surroundings = warm.environment(surroundings)
    done = subprocess.run(
        command,
        cwd=folder,
        env=surroundings,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, f"{block.body}\nfailed:\n{done.stdout}"
    return done.stdout


def _squeezed(text: str) -> str:
    """Without blank lines and with single spaces: a table's padding says nothing."""
    lines = (" ".join(line.split()) for line in text.splitlines())
    return "\n".join(line for line in lines if line)


def matches(shown: str, printed: str) -> bool:
    parts = [re.escape(part) for part in _squeezed(shown).split("...")]
    return re.fullmatch(".*?".join(parts), _squeezed(printed), re.DOTALL) is not None


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [p for p in PAGES if runs(p.read_text("utf-8"))], ids=lambda p: p.stem
)
def test_every_block_of_the_page_runs_and_prints_what_is_shown(
    page: Path, tmp_path: Path, warm: WarmStart
) -> None:
    text = page.read_text("utf-8")
    needs = re.search(r"^% needs: (\S+)$", text, re.MULTILINE)
    if needs:
        recording = RECORDINGS / needs[1]
        if not recording.is_file():
            pytest.skip(f"needs the recording beside the project: {recording}")
        shutil.copy(recording, tmp_path)
    tools = re.search(r"^% tools: (.+)$", text, re.MULTILINE)
    if tools and not all(map(shutil.which, tools[1].split())):
        pytest.skip(f"needs {tools[1]}")
    cells = [block.body for block in blocks_of(text) if block.language == "python"]
    session = iter(cells_of(page.stem, cells) if page.parent.name == FOLDER else ())
    printed: str | None = None
    for block in blocks_of(text):
        if block.file:
            (tmp_path / block.file).write_text(block.body, encoding="utf-8")
            printed = None
        elif block.language in {"sh", "python"}:
            printed = (
                next(session)["printed"]
                if page.parent.name == FOLDER
                else run(block, tmp_path, warm)
            )
        else:
            assert printed is not None
            assert matches(block.body, printed), (
                f"{page.name} shows\n{block.body}\nbut this was printed:\n{printed}"
            )
            printed = None


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_every_block_is_code_that_runs_a_file_or_output(page: Path) -> None:
    """Nothing in the pages looks like code and is not run."""
    before: Block | None = None
    for block in blocks_of(page.read_text("utf-8")):
        if block.file is None:
            assert block.language in {"sh", "python", "text"}, (
                f"{page.name}: a {block.language} block that no test runs"
            )
            if block.language == "text":
                assert before is not None, f"{page.name}: output without code"
                assert before.language in {"sh", "python"}, f"{page.name}: output without code"
        before = None if block.file else block


def test_all_pages_are_looked_at() -> None:
    pages = {
        "tour",
        "your-log",
        "good-log",
        "laws",
        "lag",
        "networks",
        "twin",
        "wrong",
        "report",
        "checks",
        "glossary",
    }
    assert pages <= {p.stem for p in PAGES}
    for page in PAGES:
        fences = re.findall(r"^```", page.read_text("utf-8"), re.MULTILINE)
        assert len(fences) == 2 * len(_BLOCK.findall(page.read_text("utf-8"))), (
            f"{page.name}: a fence that is not read"
        )


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a  b\n...\nc", "a b\n\nx\ny\nc\n", True),
        ("took ... s", "took 1.2 s", True),
        ("a\n...", "b\n", False),
        ("0.41", "0.42", False),
    ],
)
def test_output_matches_only_itself(shown: str, printed: str, same: bool) -> None:
    assert matches(shown, printed) is same


_SAID = re.compile(
    r"((?:`\w+(?:\([^`]*\))?`(?:, | or | and )?)*)(?:`\w+` )?(?: in | of |)`(erclutch(?:\.\w+)+)`"
)
#: Names of files and of groups of entry points, which are no modules.
_NO_MODULES = {
    "erclutch.advice",
    "erclutch.commands",
    "erclutch.kinds",
    "erclutch.toml",
    "erclutch.laws",
    "erclutch.points",
    "erclutch.readers",
    "erclutch.stages",
    "erclutch.targets",
    "erclutch.rigs",
}


@pytest.mark.slow
def test_every_module_and_name_that_a_page_gives_exists() -> None:
    pages = [*PAGES, ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md"]
    seen: list[str] = []
    for page in pages:
        for names, place in _SAID.findall(re.sub(r"\s+", " ", page.read_text(encoding="utf-8"))):
            if place in _NO_MODULES or place.startswith("erclutch.commands."):
                continue
            found = pkgutil.resolve_name(place)
            for name in re.findall(r"`(\w+)", names):
                seen.append(f"{place}.{name}")
                assert hasattr(found, name), f"{page.name}: {place} has no {name}"
    assert {"erclutch.export.target_check.near", "erclutch.export.encode.markup"} <= set(seen)
