"""Each figure of README and docs was printed by a command that is known, or says when and where it was measured once.

A section with a figure (a number with a unit, or a table of numbers) needs one of these:

- the words "measured once" with a date, in the section or above the first section of the page;
- the comment ``<!-- figures: NAME ... -->``: each figure below stands in ``docs/figures/NAME.txt``, which
  `studies/figures.py` writes. The name ``printed`` stands for what executed blocks of the page print;
- the comment ``<!-- figures: set -->``: the numbers below are settings, limits and definitions, or the paper's own.

A comment holds until the next one, or the next heading. Of the measurements of a decision, what stands below such a
comment is held to its file; the rest was measured once.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.support import figures as cited

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
MEASUREMENTS = sorted((ROOT / "docs" / "decisions" / "measurements").glob("*.md"))
_FENCE = re.compile(r"^```(\S+).*?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Not a statement: code, equations, addresses of links, indented commands.
_ASIDE = re.compile(r"`[^`\n]*`|\$\$?[^$]*\$\$?|\]\([^)]*\)|^ {4,}.*$", re.MULTILINE)
_MARK = re.compile(r"<!-- figures: ([\w -]+?) -->")
_ONCE = re.compile(r"measured\s+once\b[^.]*?\b20\d\d-\d\d-\d\d", re.IGNORECASE)
_VALUE = r"(?<![\w.+-])(\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?)"
_UNIT = r"%|(?:CPU )?s|N²?m?²?|N m|ms|µs|ns|[kKMG]i?B|times|instructions|bytes|mm|rad/s|ulp|k?Hz|K"
_WITH_UNIT = re.compile(rf"{_VALUE} ?(?:{_UNIT})(?![\w/])")
#: Cells that are a number, a band of two, or a number with its unit.
_CELL = re.compile(rf"^\D{{0,3}}{_VALUE}(?: - {_VALUE})?(?: ?(?:{_UNIT}))?\D{{0,3}}$")


@dataclass(frozen=True)
class Stretch:
    """Text under one mark, or before the first mark of a section."""

    heading: str
    sources: frozenset[str]
    figures: tuple[str, ...]


def figures_of(text: str) -> Iterator[str]:
    for line in text.splitlines():
        if line.startswith("|"):
            for cell in line.strip("|").split("|"):
                if found := _CELL.match(cell.strip()):
                    yield from (value for value in found.groups() if value)
        else:
            yield from _WITH_UNIT.findall(line)


def stretches(page: str) -> Iterator[Stretch]:
    plain = _ASIDE.sub(" ", _FENCE.sub("", page))
    sections = re.split(r"^(?=#+ )", plain, flags=re.MULTILINE)
    whole_page_once = any(_ONCE.search(head) for head in sections if not head.startswith("##"))
    for section in sections:
        heading, _, body = section.partition("\n")
        once = {"once"} if whole_page_once or _ONCE.search(section) else set[str]()
        first, *rest = _MARK.split(body)
        yield Stretch(heading, frozenset(once), tuple(figures_of(first)))
        for names, text in zip(rest[::2], rest[1::2], strict=True):
            yield Stretch(heading, frozenset(names.split()), tuple(figures_of(text)))


def stands_in(figure: str, values: list[float]) -> bool:
    """Whether a figure is a printed number, rounded to the figure's digits."""
    plain = figure.replace(",", "")
    digits = len(plain.partition("e")[0].partition(".")[2])
    power = int(plain.partition("e")[2] or 0)
    half = 0.5 * 10.0 ** (power - digits)
    return any(abs(float(plain) - abs(value)) <= half * (1 + 1e-9) for value in values)


def numbers(text: str) -> list[float]:
    return [float(found.replace(",", "")) for found in cited.NUMBER.findall(text)]


def sources(page: str, names: frozenset[str]) -> list[float]:
    texts = (
        [body for language, body in _FENCE.findall(page) if language == "text"]
        if "printed" in names
        else []
    )
    texts += [
        (cited.KEPT / f"{name}.txt").read_text("utf-8") for name in sorted(names - {"printed"})
    ]
    return numbers("\n".join(texts))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_each_figure_has_a_source(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for part in stretches(text):
        where = f"{page.name}, {part.heading!r}"
        assert part.sources or not part.figures, (
            f"{where}: where are {part.figures} from? (see {Path(__file__).name})"
        )
        if part.sources & {"once", "set"}:
            continue
        values = sources(text, part.sources)
        missing = [figure for figure in part.figures if not stands_in(figure, values)]
        assert not missing, (
            f"{where}: {missing} are not in {sorted(part.sources)}; try python studies/figures.py"
        )


@pytest.mark.parametrize("page", MEASUREMENTS, ids=lambda page: page.stem)
def test_what_a_measurement_says_to_be_printed_is_printed(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for part in stretches(text):
        if part.sources and not part.sources & {"once", "set"}:
            values = sources(text, part.sources)
            missing = [figure for figure in part.figures if not stands_in(figure, values)]
            assert not missing, (
                f"{page.name}, {part.heading!r}: {missing} are not in {sorted(part.sources)}"
            )


@pytest.mark.slow
def test_each_file_of_figures_has_its_command_and_is_cited() -> None:
    listed = tomllib.loads(cited.LISTED.read_text(encoding="utf-8"))
    sources = {
        name
        for page in [*PAGES, *MEASUREMENTS]
        for part in stretches(page.read_text("utf-8"))
        for name in part.sources
    }
    assert (
        {file.stem for file in cited.KEPT.glob("*")}
        == set(listed)
        == sources - {"once", "set", "printed"}
    )
    for name, entry in listed.items():
        assert (cited.KEPT / f"{name}.txt").read_text("utf-8").startswith(f"$ {entry['command']}\n")


def test_records_of_decisions_say_when_they_measured() -> None:
    folder = ROOT / "docs" / "decisions"
    assert "measured once, at the commit" in (folder / "README.md").read_text(encoding="utf-8")
    for record in folder.glob("[0-9]*.md"):
        assert re.search(
            r"^Status: .*Date: 20\d\d-\d\d-\d\d", record.read_text("utf-8"), re.MULTILINE
        ), record.name


# --- the check itself -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("It takes 12.5 ms and 3 %.", ["12.5", "3"]),
        ("`--past 2 ms`, $5 \\mathrm{s}$, equation 7, [a](b/3%20s)", []),
        ("| model | 57.5 | 52 - 63 | 10.0 % |", ["57.5", "52", "63", "10.0"]),
        ("| 1.2e-5 | fnn-16 | table 3 shows it |", ["1.2e-5"]),
    ],
)
def test_figures_are_found(text: str, found: list[str]) -> None:
    plain = _ASIDE.sub(" ", text)
    assert list(figures_of(plain)) == found


def test_marks_hold_to_the_next_heading() -> None:
    page = "# A\n1 s\n<!-- figures: x y -->\n2 s\n## B\n3 s, measured once\non 2026-01-02.\n## C\n4 s\n"
    told = [
        (part.heading, set(part.sources), part.figures) for part in stretches(page) if part.figures
    ]
    assert told == [
        ("# A", set(), ("1",)),
        ("# A", {"x", "y"}, ("2",)),
        ("## B", {"once"}, ("3",)),
        ("## C", set(), ("4",)),
    ]


@pytest.mark.parametrize(
    ("figure", "same"),
    [
        ("65.8", True),
        ("66", True),
        ("65.7", False),
        ("65.80", False),
        ("1,234", True),
        ("2e-4", True),
    ],
)
def test_a_figure_is_a_printed_number_rounded(figure: str, same: bool) -> None:
    assert stands_in(figure, numbers("65.78 and -1,234.1, 1.96e-4")) is same


def test_a_command_is_run_and_shown(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("a,b\n")
    entry = {
        "command": "cat log.csv; echo; echo took 3 s; echo 12 N",
        "needs": "log.csv",
        "leave_out": " s$",
    }
    assert cited.printed(entry, tmp_path) == f"$ {entry['command']}\na,b\n12 N\n"
    with pytest.raises(SystemExit, match="--data"):
        cited.printed(entry, tmp_path / "nowhere")
    with pytest.raises(SystemExit, match="exit code 3"):
        cited.printed({"command": "exit 3"}, tmp_path)


def test_what_moved_is_told() -> None:
    old = "$ x\nbingham 198.4 N\ncasson 12 N\n"
    new = "$ x\nbingham 199.1 N\nhem 12 N\nmore\n"
    assert cited.moved(old, new) == [
        "- bingham 198.4 N",
        "- casson 12 N",
        "+ bingham 199.1 N",
        "+ hem 12 N",
        "+ more",
    ]
    assert cited.moved(old, old.replace("198.4", "199.1")) == ["bingham 199.1: 198.4 -> 199.1"]
    assert cited.moved(old, old) == []
    assert (
        cited.moved(old, old.replace("bingham ", "bingham   ")) == []
    )  # columns became wider, and no figure moved
