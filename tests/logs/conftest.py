"""What the tests of the readers share: the measured data beside the project, and a small log to write and damage."""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs.readers import child_process, found_recordings

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


@pytest.fixture
def read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of sound bytes are read in this process: a child costs a start of Python, and has tests of its own."""

    def run(module: str, path: Path, *arguments: str) -> child_process.Answer:
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            monkeypatch.setattr(sys, "argv", [module, str(path), folder, "0", "0", *arguments])
            code = child_process.serve(found_recordings.answer_of)
            return child_process._answer(Path(folder), code, b"", 1 << 30)

    monkeypatch.setattr(child_process, "_limit", lambda memory, seconds: None)
    monkeypatch.setattr(child_process, "run", run)
