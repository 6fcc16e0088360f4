"""Every fault of `studies/live_faults.py`, whose table is the statement; here with fewer repetitions."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import pytest

from studies import live_faults as study


def _holds(fault: Callable[[], Any]) -> None:
    """What no delay of the machine excuses; times are the study's. A trip before the fault is tried again."""
    for _ in range(4):
        with contextlib.suppress(study.NeverReadyError):
            found = fault()
            break
    else:
        found = fault()
    assert found.holds, found


@pytest.mark.parametrize("name", [name for name in study.EXACT if not name.startswith("loss")])
def test_injected_into_the_core(name: str) -> None:
    found = study.EXACT[name]()
    assert found.passed, found


@pytest.mark.parametrize("control", [name for name in study.CONTROLS if name != "equation 23"])
def test_injected_into_the_core_under_torque_and_motion_control(control: str) -> None:
    with study.under(control):
        for name, fault in study.EXACT.items():
            if name not in study.ALIKE and not name.startswith("loss"):
                found = fault()
                assert found.passed, found


@pytest.mark.slow
@pytest.mark.parametrize("control", [name for name in study.CONTROLS if name != "equation 23"])
@pytest.mark.parametrize("name", ["sigterm", "stop-50", "crash", "wall-clock", "orphan"])
def test_injected_into_the_whole_loop_under_torque_and_motion_control(name: str, control: str) -> None:
    with study.under(control):
        _holds(study.WHOLE[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in study.EXACT if name.startswith("loss")])
def test_loss_over_a_minute(name: str) -> None:
    found = study.EXACT[name]()
    assert found.passed, found


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in study.WHOLE if name != "models"])
def test_injected_into_the_whole_loop(name: str) -> None:
    _holds(study.WHOLE[name])


def test_damaged_models() -> None:
    found = study.bad_models(500)
    assert found.passed, found


@pytest.mark.slow
def test_kill_of_the_loop() -> None:
    found = study.killed(10)
    assert (found.injected, found.holds) == (10, True), found


@pytest.mark.slow
def test_kill_of_the_rig() -> None:
    found = study.rig_killed(5)
    assert (found.injected, found.holds) == (5, True), found


@pytest.mark.slow
def test_damaged_configurations() -> None:
    found = study.bad_configurations(100)
    assert found.passed, found
