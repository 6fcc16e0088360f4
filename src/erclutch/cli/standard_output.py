"""Standard output may fail, and the work goes on: what a command makes is worth more than what it says of it."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from erclutch.registry import others_at_work

#: Signs of pictures and tables in signs that every encoding has.
_PLAIN = str.maketrans("·░▒▓█─│╭╮╰╯…–µ°²³", ".:+x#-|....~-ud23")


class _Unfailing:
    """A standard stream that never raises: its first failure is kept, and what comes after is dropped.

    Args:
        stream: of the process; None where it was started without one.

    Attributes:
        failure: why nothing can be written any more.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text, or drop it; returns its length."""
        if self._stream is None:
            self.failure = self.failure or OSError(errno.EBADF, "standard output is closed")
        elif self.failure is None:
            with self._kept():
                try:
                    self._stream.write(text)
                except UnicodeEncodeError:
                    # The encoding lacks some signs: like signs take their place, a question mark that of the rest.
                    encoding = self._stream.encoding
                    encoded = text.translate(_PLAIN).encode(encoding, "replace")
                    self._stream.write(encoded.decode(encoding))
        return len(text)

    def flush(self) -> None:
        """Write what waits, or drop it."""
        if self._stream is not None and self.failure is None:
            with self._kept():
                self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @property
    def unheard(self) -> bool:
        """Whether the reader of the output went away, as ``| head`` does: that is no error of ours."""
        return isinstance(self.failure, BrokenPipeError)

    @contextmanager
    def _kept(self) -> Generator[None]:
        try:
            yield
        except OSError as error:
            self.failure = error
            self._drop()
        except ValueError as error:  # somebody closed it
            self.failure = OSError(errno.EBADF, str(error))

    def _drop(self) -> None:
        """What waits in the stream goes nowhere, so that the interpreter can end."""
        assert self._stream is not None
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


class StandardOutput(_Unfailing):
    """Standard output that never raises; what a plug-in prints while it works goes to standard error."""

    def write(self, text: str) -> int:
        """Write a text, or drop it; returns its length."""
        if others_at_work() and sys.stderr is not None:
            return sys.stderr.write(text)
        return super().write(text)


@contextmanager
def standard_output() -> Generator[StandardOutput]:
    """Take the place of the process's standard output for a command, and see that standard error never raises."""
    before = sys.stdout, sys.stderr
    output = StandardOutput(sys.stdout)
    sys.stdout = output  # pyright: ignore[reportAttributeAccessIssue]
    if sys.stderr is not None:
        sys.stderr = _Unfailing(sys.stderr)  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield output
        output.flush()
    finally:
        sys.stdout, sys.stderr = before
