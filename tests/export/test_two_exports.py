"""Two exports in one program of C: each has its own numbers, and two of one name are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.include_guard import once
from erclutch.export.step_numbers import run
from erclutch.export.targets.c import write_core
from erclutch.models.model import Model
from tests.support.two_exports import effort_of, program

ROW = (700.0, 0.5)
LABELS = ("casson+lag, single", "fnn-3+rise-fall, single")


def exported(
    models: dict[str, Model], folder: Path, names: tuple[str, str], labels: tuple[str, str] = LABELS
) -> tuple[list[Path], list[Path], list[str], list[float]]:
    """Sources, headers, C that prints the effort of a row, and the effort of each by NumPy."""
    sources: list[Path] = []
    body: list[str] = []
    efforts: list[float] = []
    for place, (name, label) in enumerate(zip(names, labels, strict=True)):
        home = folder / str(place)
        home.mkdir()
        step = step_of(models[label], ExportOptions(name, "float64", 1e-3))
        sources += write_core(step, home)
        body.append(effort_of(step, ROW))
        efforts.append(float(run(step, np.array([ROW]))[0][0]))
    return sources, [source.with_suffix(".h") for source in sources], body, efforts


@pytest.mark.slow
@pytest.mark.parametrize("names", [("one", "two"), ("m", "m_step"), ("m_in", "m")])
@pytest.mark.parametrize("one_file", [False, True])
def test_each_of_two_models_in_one_program_has_its_own_numbers(
    models: dict[str, Model],
    names: tuple[str, str],
    one_file: bool,
    tmp_path: Path,
    need: Callable[..., None],
) -> None:
    need("gcc")
    sources, headers, body, efforts = exported(models, tmp_path, names)
    built = program(tmp_path, sources, headers, body, one_file=one_file)
    assert built.refused == ""
    assert [float.fromhex(line) for line in built.printed.split()] == efforts
    assert efforts[0] != efforts[1]


@pytest.mark.slow
@pytest.mark.parametrize("names", [("m", "m"), ("Pump", "pump")])
def test_two_models_of_one_name_are_refused_by_the_second_header(
    models: dict[str, Model], names: tuple[str, str], tmp_path: Path, need: Callable[..., None]
) -> None:
    """The second header was skipped; where its library was not the first one either, the wrong model answered."""
    need("gcc")
    sources, headers, body, _ = exported(models, tmp_path, names)
    built = program(tmp_path, sources[:1], headers, body[:1], one_file=False)
    assert "two headers of one name, which say different things" in built.refused


@pytest.mark.slow
def test_a_header_may_be_included_twice(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc")
    sources, headers, body, efforts = exported(models, tmp_path, ("one", "two"))
    built = program(tmp_path, sources, [*headers, *headers], body, one_file=False)
    assert [float.fromhex(line) for line in built.printed.split()] == efforts


def test_a_guard_tells_headers_apart_by_what_they_say() -> None:
    first, again, other = (once("M_H", text) for text in ("int x;\n", "int x;\n", "int y;\n"))
    assert first == again
    assert first.splitlines()[:2] == other.splitlines()[:2]
    assert first.splitlines()[2] != other.splitlines()[2]
