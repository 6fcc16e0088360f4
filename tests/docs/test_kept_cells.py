"""What the cells of a notebook's page show is kept for who comes second, and never taken for that of other cells."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from docs._ext import notebook_cells


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Sequence[str]]:
    """Cells that were run, in a project of its own with one source."""
    cells_that_ran: list[Sequence[str]] = []

    def run_cells(cells: Sequence[str], folder: Path) -> list[dict[str, Any]]:
        assert list(folder.iterdir()) == []
        cells_that_ran.append(cells)
        return [{"printed": cell, "html": None, "pictures": []} for cell in cells]

    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "law.py").write_text("gain = 1.0\n", "utf-8")
    extension = tmp_path / "notebook_cells.py"
    extension.write_bytes(Path(notebook_cells.__file__).read_bytes())
    monkeypatch.setattr(notebook_cells, "__file__", str(extension))
    monkeypatch.setattr(notebook_cells, "ROOT", tmp_path)
    monkeypatch.setattr(notebook_cells, "_KEPT", tmp_path / "build" / "notebooks")
    monkeypatch.setattr(notebook_cells, "run_cells", run_cells)
    few = list(islice(notebook_cells.metadata.distributions(), 3))  # to read all of them takes long
    monkeypatch.setattr(notebook_cells.metadata, "distributions", lambda: few)
    return cells_that_ran


def test_the_same_cells_of_the_same_sources_run_once(ran: list[Sequence[str]]) -> None:
    first = notebook_cells.cells_of("brake", ["x = 1\n", "print(x)\n"])
    again = notebook_cells.cells_of("brake", ["x = 1", "print(x)"])  # as Sphinx hands them over
    assert again == first
    assert len(ran) == 1


@pytest.mark.parametrize("changed", ["a cell", "a source", "a new source", "a package"])
def test_what_was_kept_of_others_is_not_taken(
    changed: str, ran: list[Sequence[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook_cells.cells_of("brake", ["print(1)"])
    cells = ["print(2)"] if changed == "a cell" else ["print(1)"]
    if changed == "a source":
        (tmp_path / "src" / "law.py").write_text("gain = 2.0\n", "utf-8")
    if changed == "a new source":
        (tmp_path / "src" / "stage.py").write_text("", "utf-8")
    if changed == "a package":
        monkeypatch.setattr(notebook_cells.metadata, "distributions", list)
    assert notebook_cells.cells_of("brake", cells)[0]["printed"] == cells[0]
    assert len(ran) == 2
    assert notebook_cells.cells_of("brake", cells)[0]["printed"] == cells[0]
    assert len(ran) == 2
