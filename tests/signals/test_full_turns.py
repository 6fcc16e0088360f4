"""An angle that starts again after a full turn jumps within a stretch of rows, and not from one stretch to the next."""

from __future__ import annotations

import numpy as np

from erclutch.signals.full_turns import FULL_TURNS, starts_again


def test_a_jump_over_a_gap_is_none() -> None:
    in_rad, *_ = FULL_TURNS
    turned = np.mod(np.arange(0.0, 20.0, 0.5), in_rad)
    jumps = np.flatnonzero(np.abs(np.diff(turned)) > np.pi)
    assert starts_again(turned, in_rad) == jumps.size == 3
    behind_the_first = int(jumps[0]) + 1
    parted = [(0, behind_the_first), (behind_the_first, turned.size)]
    assert starts_again(turned, in_rad, parted) == 2


def test_an_angle_beyond_a_full_turn_starts_again_nowhere() -> None:
    in_rad, *_ = FULL_TURNS
    angle = np.array([0.0, 3.0, 6.0, 9.0, 1.0])
    assert starts_again(angle, in_rad) == 0
