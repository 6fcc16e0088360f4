"""What a machine, a plug-in, a worker or a file may do: work goes on, or ends with one error."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support import hostile
from tests.support.hostile import CASES

#: What another test states, and more: `tests/runs/test_cluster.py`, without the minute that the case waits.
ELSEWHERE = ("worker of Dask that stands still",)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CASES if name not in ELSEWHERE])
def test_it_holds(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hostile, "RUNS", 10_000)
    tries, wrong = CASES[name](tmp_path)
    assert tries > 0
    assert wrong == []
