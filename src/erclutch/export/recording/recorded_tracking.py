"""A gain and an offset that follow the measured effort are recorded here."""

from __future__ import annotations

from typing import Any

from erclutch.arithmetic.record import Record
from erclutch.models.gain_tracking import BASE, GainTracking, Tracked


def tracked(
    record: Record,
    tracking: GainTracking,
    effort: Any,
    measured: Any,
    started: Any,
    going: Any,
) -> tuple[Any, Any]:
    """The effort to be given out, and whether it is the adapted one; the state follows the measured effort.

    Args:
        record: what is recorded into.
        tracking: numbers of the tracking.
        effort: the estimate.
        measured: effort; NaN where there is none.
        started: whether a good row has come, this one included.
        going: whether there was one before.
    """
    names = [f"track_{name}" for name in BASE._fields]
    numbers: list[Any] = []
    for name, first in zip(names, BASE, strict=True):
        numbers.append(record.choose(going, record.state(name), first))
    before = Tracked(*numbers)

    # The adapted effort is given out while its account is worth more than it can cost.
    moved, cost = tracking.moved(before, effort)
    pays = record.less(cost, before.account)
    adapted = record.label(record.both(started, pays), "adapted")
    given = record.label(record.choose(adapted, moved, effort), "given")

    # A row without a measured effort teaches nothing.
    counts = record.label(record.both(started, record.finite(measured)), "counts")
    seen = record.choose(counts, measured, effort)
    after = tracking.after(before, effort, given, seen)
    for name, new, old in zip(names, after, before, strict=True):
        now = record.choose(counts, new, old)
        record.keep(name, record.label(now, name))
    return given, adapted
