"""Frama-C's Eva on the interlock of the live loop and on what it believes of a sensor, by `studies/proof.py`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support import live_proof


@pytest.mark.slow
def test_the_interlock_for_any_bits(tmp_path: Path, need: Callable[..., None]) -> None:
    need("frama-c")
    said = live_proof.proved_interlock(tmp_path)
    assert said.alarms == 0
    assert said.assumed == 0
    assert said.shown == {name: [True] for name in ("never_both", "first", "second", "motor")}


@pytest.mark.slow
def test_no_impossible_torque_is_believed_and_no_sensor_adds_more_than_a_tenth_for_any_bits(
    tmp_path: Path, need: Callable[..., None]
) -> None:
    need("frama-c")
    said = live_proof.proved_plausibility(tmp_path)
    assert said.alarms == 0
    assert said.assumed == 0
    assert said.shown == {
        name: [True] for name in ("believed", "latched", "zero", "tenth", "no_more")
    }
