"""Recorded numbers and their limits: whether one lies beyond them, and the number held within them."""

from __future__ import annotations

from typing import Any

from erclutch.arithmetic.elementary import less_select


def beyond(x: Any, low: Any, high: Any) -> Any:
    """Whether a recorded number lies outside two limits; a NaN does not."""
    record = x.owner
    below = record.less(x, low)
    above = record.less(high, x)
    return record.either(below, above)


def held(value: Any, low: Any, high: Any) -> Any:
    """A number within two limits; the high limit for what is not a number."""
    below = less_select(value, high, value, high)
    return less_select(low, below, below, low)


def limited(value: Any, before: Any, low: Any, high: Any) -> Any:
    """A number within two limits, and the one before where it is not finite."""
    record = value.owner
    finite = record.label(record.finite(value), "is_finite")
    at_ends = record.call("held", held, value=value, low=low, high=high)
    within = record.choose(beyond(value, low, high), at_ends, value)
    return record.choose(finite, within, before)
