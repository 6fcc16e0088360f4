"""What a machine, a plug-in, a worker or a file may do: work goes on, or ends with one error."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support import hostile
from tests.support.hostile import CASES

#: Of this `tests/test_files.py` asks a few commands; all of them take a minute of CPU.
LONG = "folders that take nothing, a disk of 60 kB"


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CASES if name != LONG])
def test_it_holds(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hostile, "RUNS", 10_000)
    tries, wrong = CASES[name](tmp_path)
    assert tries > 0
    assert wrong == []
