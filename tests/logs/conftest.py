"""What the tests of the readers share: the measured data beside the project, and a small log to write and damage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.logs import log_reader
from erclutch.logs.readers import signal_files, spreadsheet
from tests.support.wings_asked import asking_tests

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "data"


@pytest.fixture
def shared() -> Path:
    """The folder of measured data that nobody here made."""
    if not SHARED.is_dir():
        pytest.skip(f"needs the measured data beside the project: {SHARED}")
    return SHARED


@pytest.fixture
def rows() -> dict[str, np.ndarray]:
    """A small log: 1 kHz, voltage, speed, force."""
    random = np.random.default_rng(7)
    count = 200
    return {
        "t": np.arange(count) * 1e-3,
        "Y": np.round(random.uniform(0, 2, count), 4),
        "V": np.round(random.normal(size=count) * 10, 5),
        "F": np.round(random.normal(size=count) * 100, 3),
    }


@pytest.fixture(autouse=True)
def nothing_for_a_reader_of_a_wing(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    """No reader of a wing takes a log of a test that does not run once more without wings, so that it need not."""
    taken = list[str]()

    def watched(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any) -> Any:
            answer = function(*given)
            plugin = answer[0] if isinstance(answer, tuple) else answer  # with notes, or alone
            if plugin is not None and plugin.source.startswith("erclutch.wings."):
                taken.append(plugin.source)
            return answer

        return call

    for place in (log_reader, signal_files, spreadsheet):
        monkeypatch.setattr(place, "reader_of", watched(place.reader_of))
    monkeypatch.setattr(log_reader, "folder_reader", watched(log_reader.folder_reader))
    yield
    # Which tests run without wings is asked where that matters: to read their sources takes most of a second.
    runs_without = not taken or request.node.originalname in asking_tests(request.path)
    assert runs_without, "this test must run without wings, too: see tests/support/wings_asked.py"
