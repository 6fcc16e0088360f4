"""What the tests of the readers share: the measured data beside the project, and a small log to write and damage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

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
