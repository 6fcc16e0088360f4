"""Packed rows come back as they were, up to the rounding; coarse layers enclose them; the budget holds."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.report.html.packed_rows import Packer, channel, coarse, packed, rounded, unpacked
from erclutch.report.html.traces_section import _held_out
from erclutch.signals.clock import stretches


@pytest.mark.slow
@given(st.lists(st.integers(-32768, 32767), min_size=1, max_size=300))
def test_what_was_packed_comes_back(values: list[int]) -> None:
    array = np.array(values, np.int64)
    assert np.array_equal(unpacked(packed(array)), array)


@pytest.mark.slow
@given(
    st.lists(st.floats(-1e6, 1e6, allow_subnormal=False), min_size=1, max_size=200),
    st.floats(1e-9, 1e3),
)
def test_rounding_is_within_half_a_step_and_fits_16_bits(
    values: list[float], resolution: float
) -> None:
    array = np.array(values)
    made = channel(array, resolution)
    integers = rounded(array, made)
    assert np.abs(integers).max() <= 32767
    assert made.step >= resolution
    back = unpacked(packed(integers)) * made.step + made.middle
    assert np.abs(back - array).max() <= 0.5 * made.step + 1e-9 * np.abs(array).max()


@pytest.mark.slow
@given(st.integers(1, 400), st.integers(1, 50), st.integers(0, 2**32 - 1))
def test_a_coarse_layer_encloses_its_rows(rows: int, bucket: int, seed: int) -> None:
    values = np.random.default_rng(seed).integers(-1000, 1000, rows)
    pairs = coarse(values, 0, rows, bucket).reshape(-1, 2)
    assert len(pairs) == -(-rows // bucket)
    for k, (low, high) in enumerate(pairs):
        part = values[k * bucket : (k + 1) * bucket]
        assert (low, high) == (part.min(), part.max())


def test_the_budget_holds_and_the_most_wanted_comes_first() -> None:
    rng = np.random.default_rng(0)
    values = np.cumsum(rng.normal(size=(3, 40_000)), axis=1)
    packer = Packer(40_000, budget=110_000)
    for k, line in enumerate(values):
        packer.add(f"c{k}", line, 0.05, 500)
    got = [packer.whole(f"c{k}", 0, 40_000) for k in range(3)]
    assert got[0]
    assert not all(got)
    spent = sum(len(layer.data) for c in packer.channels.values() for layer in c.layers)
    assert spent + packer.left == 110_000
    assert packer.left >= 0


def test_a_part_that_a_longer_layer_holds_is_dropped() -> None:
    values = np.sin(np.arange(9000) / 50)
    packer = Packer(9000)
    packer.add("c", values, 1e-3, 500)
    assert packer.whole("c", 6000, 9000)
    assert packer.whole("c", 0, 9000)
    assert [(x.start, x.stop, x.bucket) for x in packer.channels["c"].layers] == [
        (0, 9000, 18),
        (0, 9000, 1),
    ]
    assert packer.has("c", 2000, 3000)


@pytest.mark.parametrize("value", [0.0, 5.0, -1e-300])
def test_a_constant_signal(value: float) -> None:
    made = channel(np.full(10, value), 0.1)
    assert np.all(rounded(np.full(10, value), made) * made.step + made.middle == value)


@pytest.mark.parametrize(
    ("stretches_held", "alone"), [(3, True), (64, True), (65, False), (4000, False)]
)
def test_points_held_out_all_over_are_packed_as_few_blocks(
    stretches_held: int, alone: bool
) -> None:
    """Of 15,000 points 4,000 were held out here and there: to pack each alone took twenty seconds."""
    test = np.zeros(15_000, np.bool_)
    test[1 : 3 * stretches_held : 3] = True
    held = _held_out(cast(Any, SimpleNamespace(rows=SimpleNamespace(test=test))))
    if alone:
        assert held == stretches(test)
        return
    assert len(held) <= 64
    assert held[0][0] == 0
    assert held[-1][1] == test.size
    assert all(stop == start for (_, stop), (start, _) in itertools.pairwise(held))
