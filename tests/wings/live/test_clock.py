"""The loop's clock is the one that Python shows, and a sleep ends after its time and not before."""

from __future__ import annotations

import ctypes
import time

import pytest

from erclutch.wings.live.c_build import SOURCES, build


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    made = ctypes.CDLL(
        str(build("erclutch-test-clock.so", [SOURCES / "erc_realtime.c"], shared=True))
    )
    made.erc_now.restype = ctypes.c_uint64
    return made


@pytest.mark.slow
def test_the_clock_is_pythons(library: ctypes.CDLL) -> None:
    seen = [
        time.monotonic_ns(),
        library.erc_now(),
        time.monotonic_ns(),
        library.erc_now(),
        time.monotonic_ns(),
    ]
    assert seen == sorted(seen)


@pytest.mark.parametrize("ahead", [-5_000_000, 0, 2_000_000])
def test_a_sleep_ends_after_its_time(library: ctypes.CDLL, ahead: int) -> None:
    wanted = time.monotonic_ns() + ahead
    library.erc_sleep_until(ctypes.c_uint64(wanted))
    assert time.monotonic_ns() >= wanted
