"""``python -m erclutch`` and the command ``erclutch`` run the command line."""

import os
import signal
import sys
from typing import NamedTuple

#: Matrices are small here: more threads of BLAS would wait for each other, and take CPU time from all else meanwhile.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> int:
    """Run the command of this process; an interrupt while its modules are imported is told as one that comes later.

    Returns:
        The exit code; see `erclutch.cli.main`.
    """
    for pool in _ONE_THREAD:
        os.environ.setdefault(pool, "1")  # before NumPy is imported, which makes its threads then
    try:
        from erclutch.cli import main as run

        code = run()
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted; nothing was left half-written\n")
        code = 130
    _forget_interrupt()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is done: Control-C changes nothing any more
    return code


def _forget_interrupt() -> None:
    """Let this process end with its exit code, though an interrupt came.

    Python ends itself by the signal, whatever the code, where an interrupt came while it made a named tuple or a
    dataclass, as it does for many modules that are imported. It forgets the interrupt when it makes the next one.
    """
    NamedTuple("_Next", [])


if __name__ == "__main__":
    sys.exit(main())
