"""Every fault of `studies/live_faults.py`, whose table is the statement; here with fewer repetitions."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import pytest

from tests.support.live_faults.core_faults import EXACT
from tests.support.live_faults.finding import CONTROLS, under
from tests.support.live_faults.loop_faults import (
    ALIKE,
    WHOLE,
    bad_configurations,
    bad_models,
    killed,
    rig_killed,
)
from tests.support.live_faults.running_loop import NeverReadyError

pytestmark = pytest.mark.timed


def _holds(fault: Callable[[], Any]) -> None:
    """What no delay of the machine excuses; times are the study's. A trip before the fault is tried again."""
    for _ in range(4):
        with contextlib.suppress(NeverReadyError):
            found = fault()
            break
    else:
        found = fault()
    assert found.holds, found


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in EXACT if not name.startswith("loss")])
def test_injected_into_the_core(name: str) -> None:
    found = EXACT[name]()
    assert found.passed, found


@pytest.mark.slow
@pytest.mark.parametrize("control", [name for name in CONTROLS if name != "equation 23"])
def test_injected_into_the_core_under_torque_and_motion_control(control: str) -> None:
    with under(control):
        for name, fault in EXACT.items():
            if name not in ALIKE and not name.startswith("loss"):
                found = fault()
                assert found.passed, found


@pytest.mark.slow
@pytest.mark.parametrize("control", [name for name in CONTROLS if name != "equation 23"])
@pytest.mark.parametrize("name", ["sigterm", "stop-50", "crash", "wall-clock", "orphan"])
def test_injected_into_the_whole_loop_under_torque_and_motion_control(
    name: str, control: str
) -> None:
    with under(control):
        _holds(WHOLE[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in EXACT if name.startswith("loss")])
def test_loss_over_a_minute(name: str) -> None:
    found = EXACT[name]()
    assert found.passed, found


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in WHOLE if name != "models"])
def test_injected_into_the_whole_loop(name: str) -> None:
    _holds(WHOLE[name])


@pytest.mark.slow
def test_damaged_models() -> None:
    found = bad_models(500)
    assert found.passed, found


@pytest.mark.slow
def test_kill_of_the_loop() -> None:
    found = killed(10)
    assert (found.injected, found.holds) == (10, True), found


@pytest.mark.slow
def test_kill_of_the_rig() -> None:
    found = rig_killed(5)
    assert (found.injected, found.holds) == (5, True), found


@pytest.mark.slow
def test_damaged_configurations() -> None:
    found = bad_configurations(100)
    assert found.passed, found
