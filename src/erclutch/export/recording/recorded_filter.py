"""The derivative filter of an angle is recorded here: from a measured angle to a speed, by two numbers of the state."""

from __future__ import annotations

from typing import Any

from erclutch.arithmetic.record import Record
from erclutch.export.exported_step import Filter
from erclutch.export.recording.stage_memory import kept


def filtered_speed(
    record: Record,
    gains: Filter,
    period: float,
    measured: Any,
    number: int,
    good: Any,
    going: Any,
) -> Any:
    """The speed of an angle: a prediction, corrected by the innovation.

    Args:
        record: what is recorded into.
        gains: of the filter.
        period: in s.
        measured: the angle.
        number: of the element; it ends the names of the state's numbers.
        good: whether the row is good; a bad one is predicted.
        going: whether there was a row before.
    """
    position = record.state(f"position{number}")
    speed = record.state(f"speed{number}")
    predicted = position + period * speed
    innovation = record.choose(good, _turned(record, gains, measured - predicted), 0.0)

    # In the first row the filter stands at the angle, at rest.
    first = record.choose(good, _turned(record, gains, measured), position)
    corrected = _turned(record, gains, predicted + gains.g * innovation)
    position_now = kept(record.choose(going, corrected, first))
    record.keep(f"position{number}", position_now)
    quicker = speed + gains.h * innovation / period
    speed_now = kept(record.choose(going, quicker, speed))
    record.keep(f"speed{number}", speed_now)
    return record.label(speed_now, f"speed{number}")


def _turned(record: Record, gains: Filter, angle: Any) -> Any:
    """An angle less whole turns, within half a turn of zero."""
    turn = gains.turn
    if turn is None:
        return angle

    def turned(x: Any) -> Any:
        turns = x * (1.0 / turn)
        return x - turns.record("nearest", turns) * turn

    return record.call("turned", turned, x=angle)
