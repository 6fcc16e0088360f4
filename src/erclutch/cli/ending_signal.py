"""A signal ends a command as an exception does, and only once: what is half-written is taken away in peace."""

from __future__ import annotations

import signal
import sys
import threading
import time
from typing import Any

#: s after a signal in which no further one is heard. Shells and service managers send several, a hurried user too.
_CLEARS_UP = 5.0
#: s after which a signal comes again that was lost.
_COMES_AGAIN = 0.05
#: What Python does with the signals that end a program.
_USUAL = {
    "SIGINT": signal.default_int_handler,
    "SIGTERM": signal.SIG_DFL,
    "SIGHUP": signal.SIG_DFL,
}


class EndingSignal:
    """The signal that ends this command, if one has come.

    Attributes:
        number: of the signal; 0: none has come.
    """

    def __init__(self) -> None:
        self.number = 0
        self._at = 0.0
        self._over = False
        self._unraisable: Any = sys.__unraisablehook__

    @property
    def interrupted(self) -> bool:
        """Whether it was Control-C."""
        return self.number == signal.SIGINT

    def begin(self) -> None:
        """A command begins: Control-C, a closed terminal and `kill` end it from now on.

        What the caller has set already, such as nohup, stays. Commands that go on until told have their own way.
        """
        self.number = 0
        self._over = False
        if sys.unraisablehook != self._hear_again:
            self._unraisable = sys.unraisablehook
            sys.unraisablehook = self._hear_again
        for name, handler in _USUAL.items():
            number = getattr(signal, name, None)
            try:
                if number is not None and signal.getsignal(number) is handler:
                    signal.signal(number, self._hear)
            except ValueError:
                return  # not in the main thread: whoever started this one decides

    def end(self) -> None:
        """The command is done: what comes now changes nothing of its result, and finds nobody clearing up."""
        self._over = True
        if sys.unraisablehook == self._hear_again:
            sys.unraisablehook = self._unraisable

    def give_back(self) -> None:
        """Each signal is the caller's again: a program that goes on behind a command can be ended."""
        for name, handler in _USUAL.items():
            number = getattr(signal, name, None)
            try:
                if number is not None and signal.getsignal(number) == self._hear:
                    signal.signal(number, handler)
            except ValueError:
                return

    def _hear(self, number: int, frame: object) -> None:
        now = time.monotonic()
        answered = self.number != 0 and now - self._at < _CLEARS_UP
        if self._over or answered:
            return
        self.number = number
        self._at = now
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        raise SystemExit(128 + number)

    def _hear_again(self, unraisable: Any) -> None:
        """Where nothing can be raised, as in what a library calls back, the signal comes once more."""
        if (
            self.number
            and not self._over
            and isinstance(unraisable.exc_value, KeyboardInterrupt | SystemExit)
        ):
            number = self.number
            self.number = 0
            # A signal to this thread from another one is heard when this function, too, is left.
            threading.Timer(
                _COMES_AGAIN, signal.pthread_kill, (threading.get_ident(), number)
            ).start()
        else:
            self._unraisable(unraisable)
