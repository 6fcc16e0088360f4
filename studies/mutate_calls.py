"""Which tests call which function: a plug-in of pytest, with which `mutate.py` runs each test once without a mutant.

A call while a test is set up counts for all tests of its file, for they share fixtures. Calls in a process of their own
are not seen.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from types import FrameType
from typing import Any

import pytest

_SOURCE, _WRITTEN = os.environ["MUTATE_SOURCE"] + "/", os.environ["MUTATE_CALLS"]
_callers: dict[tuple[str, str], set[str]] = {}
_running = [""]


def _called(frame: FrameType, event: str, argument: Any) -> None:
    code = frame.f_code
    if event == "call" and _running[0] and code.co_filename.startswith(_SOURCE):
        _callers.setdefault((code.co_filename, code.co_qualname), set()).add(_running[0])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Watch. What a test shares counts for its file."""
    _running[0] = item.nodeid.partition("::")[0]
    threading.setprofile(_called)
    sys.setprofile(_called)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    """Now the test itself runs."""
    _running[0] = item.nodeid


def pytest_runtest_teardown() -> None:
    """Stop watching."""
    sys.setprofile(None)
    _running[0] = ""


def pytest_sessionfinish() -> None:
    """Write file of tests -> function -> tests."""
    found: dict[str, dict[str, list[str]]] = {}
    for (name, function), tests in _callers.items():
        for test in sorted(tests):
            place = f"{name.removeprefix(_SOURCE)}:{function}"
            found.setdefault(test.partition("::")[0], {}).setdefault(place, []).append(test)
    with open(_WRITTEN, "w", encoding="utf-8") as file:
        json.dump(found, file)
