"""How two clocks are matched, and every word that is said of it, stays as it is kept beside this file (SYNTHETIC)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from erclutch.signals.array import Array
from erclutch.wings.align.aligned_logs import align
from erclutch.wings.align.clock_line import overlap_of
from erclutch.wings.align.clock_match import match_clocks
from erclutch.wings.align.coarse_search import search_of_all, width_of
from erclutch.wings.align.track import track_of
from tests.support.pinning import Pinned, summed, told

pytestmark = pytest.mark.slow


@cache
def _signal() -> Array:
    return np.asarray(lfilter([1.0], [1.0, -0.97], np.random.default_rng(8).normal(size=40_000)))


def logged(rows: int, period: float = 0.01, offset: float = 0.0, drift: float = 0.0) -> Any:
    """A made-up signal and its clock."""
    fine, time = _signal(), period * np.arange(rows)
    return (1.0 + drift) * time + offset, np.interp(5.0 + time, 0.01 * np.arange(fine.size), fine)


#: Rows, period, offset and drift of B against A, and what the user says.
MATCHES: dict[str, tuple[int, float, float, float, float | None]] = {
    "same rate": (3000, 0.01, 0.123, 2e-5, None),
    "faster": (6000, 0.005, -2.5, -5e-5, None),
    "slower": (1200, 0.03, 1.7, 1e-4, None),
    "short": (150, 0.01, 0.02, 0.0, None),
    "said": (3000, 0.01, 0.5, 0.0, 0.4),
}


@pytest.mark.parametrize("name", list(MATCHES))
def test_clocks(name: str, pinned: Pinned) -> None:
    rows, period, offset, drift, near = MATCHES[name]
    a, values = (
        track_of(logged(3000)[0], logged(3000)[1], 0.01),
        logged(rows, period, offset, drift),
    )
    b = track_of(
        values[0], np.where(np.arange(rows) % 997 < 3, np.nan, 2.0 * values[1] + 1.0), period
    )

    def found() -> Any:
        match = match_clocks(a, b, near=near)
        names = (
            "origin",
            "offset",
            "offset_interval",
            "drift",
            "drift_interval",
            "overlap",
            "gain",
            "correlation",
        )
        own = [getattr(match, name) for name in (*names, "independent")]
        return [*own, summed(match.centres), summed(1e6 * match.residuals)]

    def searched() -> Any:
        line, width, independent = search_of_all(a, b, near, 1.0)
        return [
            line.at,
            line.middle,
            line.drift,
            width,
            independent,
            overlap_of(a, b, line),
            width_of(b, period, 20.0),
        ]

    pinned([told(found), told(searched)], rel=1e-4)


def test_clocks_that_do_not_match(pinned: Pinned) -> None:
    time: Any = 0.01 * np.arange(2000)
    periodic, other = np.sin(7.0 * time), np.random.default_rng(1).normal(size=2000)
    a, b, c = (track_of(time, values, 0.01) for values in (periodic, logged(2000)[1], other))
    flat, short = track_of(time, np.ones(2000), 0.01), track_of(time[:40], periodic[:40], 0.01)
    later = replace(a, time=a.time + 0.3)
    pairs = {
        "noise": (b, c),
        "periodic": (a, later),
        "flat": (a, flat),
        "flat A": (flat, a),
        "short": (short, a),
    }
    words = {
        name: told(lambda x=x, y=y: match_clocks(x, y).offset) for name, (x, y) in pairs.items()
    }
    words["periodic"] = words["periodic"].rpartition(" ms: ")[
        2
    ]  # which of equal offsets are named is chance
    for near in (0.3, 0.75, 1.2):
        words[f"near {near}"] = told(lambda near=near: match_clocks(a, later, near=near).offset)
    pinned(words, rel=1e-4)


def test_two_logs_joined(tmp_path: Path, pinned: Pinned) -> None:
    paths = tmp_path / "a.csv", tmp_path / "b.csv"
    for path, (time, values), more in zip(
        paths, (logged(3000), logged(2500, 0.012, 0.25, 3e-5)), ("u", "w [N]"), strict=True
    ):
        rows = np.column_stack([time, values, np.cos(time)])
        np.savetxt(path, rows, "%.9f", ",", header=f"t [s],both,{more}", comments="")
    both = align(*paths)
    joined = both.joined
    assert joined.clock is None
    table = {
        "columns": {name: summed(values) for name, values in joined.columns.items()},
        "clock": None,
    }
    table |= {
        name: getattr(joined, name)
        for name in ("units", "numbers", "sample_period", "clock_name", "constants")
    }
    own = [
        both.signal,
        both.offset,
        both.drift_ppm,
        [len(track.values) for track in both.traces[1]],
    ]
    words = [
        told(lambda: align(*paths, on="u").notes),
        told(lambda: align(*paths, near=9.0).signal),
    ]
    pinned([table, sorted(joined.metadata), own, words], rel=1e-4, least=1e-6)
