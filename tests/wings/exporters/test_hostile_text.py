"""Foreign text in a model stays text on every target: in comments, strings and attributes, never in code."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, RunError, printable
from erclutch.export import ExportOptions, export_model, step_of
from erclutch.export.c.c_header import header
from erclutch.export.c.c_source import source
from erclutch.export.encode import c_string, comment, markup, matlab_string
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read, read_table
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.law_model import TorqueModel
from erclutch.models.load import load_model
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of
from erclutch.registry import names
from erclutch.report.html.report_page import report_html
from erclutch.report.numbers.run_material import material_of
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.device import Units
from tests.support.examples import examples

ATTACKS = (
    "*/ int z; /*",
    "/*/ int z; /*",
    "**//int z;/**//",
    "a\nint z;\n",
    "a\r#define real int\r",
    '"; int z; "',
    '"""\nimport os\n"""',
    "a\\",
    "a??/",
    "<!-- --> <script>alert(1)</script> & ]]> ?> <x/>",
    "a\u2028int z;\u2029\x85",
    "a\0b\x1b[2J\x07\x7f",
    "\u202eint\u2066z\u2069",
    "\ud800 \udfff \ufffe",
    "$(touch x) `touch x` ${x} %s %n {0} {z}",
    "'); system('touch x'); disp('",
    "%{\nint z\n%}",
    "°µΩ\u00a0🧪",
)
HOSTILE = st.one_of(
    st.sampled_from(ATTACKS), st.text(max_size=40), st.lists(st.sampled_from(ATTACKS)).map("".join)
)


@pytest.mark.slow
@given(HOSTILE)
def test_a_comment_is_one_line_that_ends_nothing(text: str) -> None:
    made = comment(text)
    assert (made.isascii(), made.isprintable()) == (True, True)
    assert not any(mark in made for mark in ("*/", "/*", "??", "--", "\\", '"'))


def test_a_plain_comment_stays_as_it_is() -> None:
    assert comment("Bingham: effort in N*m/(rad/s), ? is unknown; x' = -x") == (
        "Bingham: effort in N*m/(rad/s), ? is unknown; x' = -x"
    )


@pytest.mark.slow
@given(HOSTILE)
def test_a_string_of_c_holds_the_bytes(text: str) -> None:
    """Python reads these escapes as C does."""
    made = c_string(text)
    assert (made.isascii(), made.isprintable(), "??" in made) == (True, True, False)
    assert ast.literal_eval(f"b{made}") == text.encode("utf-8", "replace")


@pytest.mark.slow
@given(HOSTILE)
def test_markup_is_the_text(text: str) -> None:
    made = ElementTree.fromstring(f'<a b="{markup(text)}">{markup(text)}</a>')
    assert made.attrib["b"] == made.text == printable(text) or not text


@pytest.mark.slow
@given(HOSTILE)
def test_a_string_of_matlab_is_one_literal(text: str) -> None:
    assert re.fullmatch(r"'(?:[^'\n]|'')*'", matlab_string(text))


@pytest.mark.slow
@given(HOSTILE, HOSTILE)
def test_an_error_is_one_line(problem: str, remedy: str) -> None:
    assert str(ErclutchError(problem, remedy=remedy)).isprintable()


# --- files of models -------------------------------------------------------------------------------------------------


def _places(body: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the strings of a body stand, keys included."""
    entries = (
        body.items()
        if isinstance(body, dict)
        else enumerate(body)
        if isinstance(body, list)
        else ()
    )
    for key, value in entries:
        yield from [(*at, key, None)] if isinstance(key, str) else []
        yield from [(*at, key)] if isinstance(value, str) else _places(value, (*at, key))


def _with(body: dict[str, Any], place: tuple[Any, ...], text: str) -> dict[str, Any]:
    """A body with a text at a place (in place of a key: the place ends in None), its digest redone."""
    made = json.loads(json.dumps({key: value for key, value in body.items() if key != "digest"}))
    inner = made
    keys = place[:-2] if place[-1] is None else place[:-1]
    for key in keys:
        inner = inner[key]
    if place[-1] is None:
        inner[text] = inner.pop(place[-2])
    else:
        inner[place[-1]] = text
    return {**made, "digest": digest_of(made)}


@pytest.fixture
def plain(law: Callable[..., TorqueModel]) -> TorqueModel:
    return replace(law("bingham", "single", "lag", further=("temperature",)), about={"seed": "7"})


@pytest.fixture
def body(plain: TorqueModel) -> dict[str, Any]:
    return plain.to_dict()


def _code(text: str) -> str:
    """C without comments and strings, without names of the model and without the mark of the header's text."""
    text = text.replace("??/", "\\").replace("\\\n", "")
    text = re.sub(r'/\*.*?\*/|"(?:[^"\\\n]|\\.)*"', " ", text, flags=re.DOTALL)
    return re.sub(r"#define \w+_IN_\w+|\bM_H_[0-9a-f]{16}\b|\s+", " ", text)


def _read_with(body: dict[str, Any], place: tuple[Any, ...], text: str, path: Path) -> Model | None:
    """The model of a file with a text at a place, None where the file is refused in one line."""
    path.write_text(json.dumps(_with(body, place, text)), encoding="utf-8")
    try:
        return load_model(path)
    except ErclutchError as error:
        return None if str(error).isprintable() else pytest.fail(f"{error!s:.200}")


_HOSTILE_FILES = settings(
    deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.mark.slow
@_HOSTILE_FILES
@given(text=HOSTILE, data=st.data())
def test_text_in_a_models_file(
    body: dict[str, Any], text: str, data: st.DataObject, tmp_path: Path
) -> None:
    """A file with a text in any of its strings and keys is refused in one line, or has names that can be printed."""
    place = data.draw(st.sampled_from([p for p in _places(body) if p[0] != "digest"]))
    model = _read_with(body, place, text, tmp_path / "m.json")
    assert model is None or "".join([model.name, *model.extras, model.units.text()]).isprintable()


@pytest.mark.slow
@settings(_HOSTILE_FILES, max_examples=examples(60))
@given(text=HOSTILE)
@pytest.mark.parametrize(
    "place", [("extras", 0, "name"), ("units", "effort"), ("law",), ("about", "seed")]
)
def test_text_in_a_models_file_is_no_code(
    place: tuple[Any, ...], body: dict[str, Any], plain: TorqueModel, text: str, tmp_path: Path
) -> None:
    model = _read_with(body, place, text, tmp_path / "m.json")
    if model is None or model.name != plain.name:
        return
    made, known = (step_of(m, ExportOptions(name="m")) for m in (model, plain))
    assert _code(header(made)) == _code(header(known))
    assert _code(source(made)) == _code(source(known))


@pytest.mark.parametrize(
    "unit", ["*/ int z; /*", "N\n", "N;", "N*/m", "a" * 61, "N//m", "N \u202em", 7, None]
)
def test_a_unit_that_is_none(body: dict[str, Any], unit: Any, tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    path.write_text(json.dumps(_with(body, ("units", "effort"), unit)), encoding="utf-8")
    with pytest.raises(RunError, match="unfit entry: a unit is"):
        load_model(path)


# --- targets ---------------------------------------------------------------------------------------------------------


class _Tags(HTMLParser):
    """Tags of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.found.append(tag)


_TAGS = {"html", "head", "meta", "title", "body", "h1", "p", "table", "tr", "th", "td"}
_WARNINGS = ("-Wall", "-Wextra", "-Werror", "-trigraphs", "-fsyntax-only")


def _read(path: Path, root: Path) -> None:
    """A file of an export is read as what it is."""
    include = [f"-I{root}", f"-I{root / 'include'}", f"-I{root / 'include' / 'm'}"]
    compilers = {".c": ["gcc", "-std=c99"], ".cpp": ["g++", "-std=c++11"]}
    if path.suffix in compilers:
        done = subprocess.run(
            [*compilers[path.suffix], *_WARNINGS, *include, str(path)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr[:2000]
    elif path.suffix == ".xml":
        ElementTree.parse(path)
    elif path.suffix == ".html":
        assert set(_Tags(path.read_text(encoding="utf-8")).found) <= set(
            ["html", "head", "meta", "title", "body", "h1", "p", "table", "tr", "th", "td"]
        )
    elif path.suffix == ".py":
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert not any(
            "os" in {a.name for a in node.names}
            for node in ast.walk(tree)
            if isinstance(node, ast.Import)
        )
    elif path.suffix == ".m":
        for line in path.read_text(encoding="ascii").splitlines():
            assert line.startswith("%") or "int z" not in line
    elif path.suffix == ".fmu":
        inside = root / "fmu"
        with zipfile.ZipFile(path) as archive:
            archive.extractall(inside)
        for file in sorted(p for p in inside.rglob("*") if p.suffix in (".xml", ".html")):
            _read(file, inside)


@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("to", names("erclutch.targets"))
def test_every_target_of_a_hostile_model(
    to: str, plain: TorqueModel, tmp_path: Path, need: Callable[..., None]
) -> None:
    """Made without a file, so that nothing is refused. A controller takes no further inputs: there the units attack."""
    need("gcc", "g++")
    every = " ".join(ATTACKS)
    further = () if to.startswith("controller") else ("field", *ATTACKS)
    structure = replace(plain.structure, extras=further)
    model = replace(
        plain,
        structure=structure,
        reference=replace(plain.reference, extras=(1.7,) * len(further)),
        gains={gain.name: 0.1 for gain in structure.gains()},
        extra_ranges=((-2.5, 2.5),) * len(further),
        units=Units(every, every[::-1], every),
    )
    folder = export_model(model, tmp_path / "out", to, ExportOptions(name="m"))
    for path in sorted(
        p
        for p in folder.rglob("*")
        if p.is_file() and p.suffix != ".json" and p.name != "erc_call.c"
    ):
        _read(path, folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    "column",
    [
        "a*/b",
        "*/int z;/*",
        "x</td><script>alert(1)</script>",
        "$(touch z)`touch z`",
        "int\u202e\x07",
    ],
)
def test_a_column_of_a_log_goes_through_fit_report_and_export(
    column: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "g++")
    log = tmp_path / "log.csv"
    write_synthetic_log(tmp_path / "plain.csv", 2.0)
    lines = (tmp_path / "plain.csv").read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("time"))
    rows = (f"{line},{k % 17}" for k, line in enumerate(lines[head + 1 :]))
    log.write_text("\n".join([*lines[:head], f'{lines[head]},"{column}"', *rows]) + "\n")
    recording = read(log, {"columns": {}, "inputs": [list(read_table(log).columns)[-1]]})
    found = compare(build_dataset(recording), Settings(models=("fnn-2",), lag="none"))
    run = read_run(write_run(tmp_path / "run", found, [recording], reading={"input": [column]}))
    assert len([tag for tag in _Tags(report_html(material_of(run))).found if tag == "script"]) == 3
    model = run.model()
    assert tuple(model.extras) == (printable(column),)
    for to in ("c", "cpp"):
        folder = export_model(model, tmp_path / to, to, ExportOptions(name="m"))
        for path in sorted(p for p in folder.rglob("*") if p.suffix in (".c", ".cpp", ".xml")):
            _read(path, folder)
