"""A limit of processor time that holds on any machine: it is that of a usual machine, at the pace of this one."""

from __future__ import annotations

from time import process_time

#: Processor seconds of `_work` on the machine where the limits of the tests were chosen.
_USUAL = 0.06
#: The quickest of so many goes is the pace: another process may slow any one of them.
_GOES = 5


def within(took: float, limit: float) -> bool:
    """Whether work that took some processor seconds here takes less than a limit on a usual machine.

    The pace is measured only where the limit is passed, so a quick machine measures nothing.
    """
    return took <= limit or took <= limit * _slowness()


def _slowness() -> float:
    """How many times the time of a usual machine this one takes, at least 1: a quick machine makes no limit tighter."""
    return max(1.0, min(_work() for _ in range(_GOES)) / _USUAL)


def _work() -> float:
    """Processor seconds of a loop of Python."""
    began = process_time()
    sum(number * number for number in range(1_000_000))
    return process_time() - began
