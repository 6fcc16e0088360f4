"""A signal ends a session in order: while the session runs it is noted, and before that nothing is waited for."""

from __future__ import annotations

import signal
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def signals_told() -> Generator[list[int]]:
    """Ctrl-C, SIGTERM and a closed terminal end the session in order, instead of wherever Python happens to be."""
    told: list[int] = []

    def note(kind: int, _frame: object) -> None:
        told.append(kind)

    kinds = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as nohup has it
        kinds.append(signal.SIGHUP)
    before = {kind: signal.signal(kind, note) for kind in kinds}
    try:
        yield told
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)


def end_where_told(told: list[int]) -> None:
    """End the command where a signal came before the session runs: no sample is worth to be waited for then.

    Raises:
        KeyboardInterrupt, SystemExit: the signal was Ctrl-C, or another one.
    """
    if not told:
        return
    if told[0] == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + told[0])
