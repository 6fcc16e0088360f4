"""A package with entry points, for tests in this process."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from pathlib import Path

import pytest

from erclutch import registry

Install = Callable[[str, str, str], None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Install, None, None]:
    """Makes a package with a module and entry points, as pip would."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(package: str, points: str, text: str) -> None:
        module = package.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
        about = tmp_path / f"{module}-1.5.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.5\n", encoding="utf-8"
        )
        (about / "entry_points.txt").write_text(points, encoding="utf-8")
        registry._others.cache_clear()
        monkeypatch.delitem(sys.modules, module, raising=False)

    yield make
    monkeypatch.undo()
    registry._others.cache_clear()
