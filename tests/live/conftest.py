from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from erclutch.live.build import build

HERE = Path(__file__).parent
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler: apt install gcc libc6-dev")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Loops that run at 1 kHz share one worker of pytest-xdist: none takes another's processor."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("live"))


@pytest.fixture(scope="session")
def bingham() -> Path:
    """The hand-written model, compiled."""
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler: apt install gcc libc6-dev")
    return build("bingham.so", [HERE / "bingham.c"], shared=True)
