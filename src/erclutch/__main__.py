"""``python -m erclutch`` and the command ``erclutch`` run the command line."""

import atexit
import os
import signal
import sys
from contextlib import suppress
from typing import Any, NamedTuple

#: Matrices are small here: more threads of BLAS would wait for each other, and take CPU time from all else meanwhile.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> int:
    """Run the command of this process; an interrupt while its modules are imported is told as one that comes later.

    Returns:
        The exit code; see `erclutch.cli.main`.
    """
    atexit.register(_hear_nothing)  # first registered, and so called last
    for pool in _ONE_THREAD:
        os.environ.setdefault(pool, "1")  # before NumPy is imported, which makes its threads then
    code: Any
    try:
        from erclutch.cli import main as run

        code = run()
        _end_at_once(code)
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted; nothing was left half-written\n")
        code = 130
    except SystemExit as ended:  # by another signal
        code = ended.code
    except Exception as error:
        torn = _torn_bytecode(error)
        if torn is None:
            raise
        with suppress(OSError):
            os.unlink(torn)  # Python makes it again
        problem = "Python's copy of a module is not whole, as a full disk leaves it"
        remedy = "Make room on that disk, remove this file if it is still there, and give the command again"
        sys.stderr.write(f"error: {torn}: {problem}. {remedy}.\n")
        code = 2
    _end_at_once(code)
    # Python ends itself by the signal, whatever the code, where an interrupt came while it made a named tuple or a
    # dataclass, as it does for many modules that are imported. It forgets the interrupt when it makes the next one.
    NamedTuple("_Next", [])
    # The answer is complete: what a plug-in prints as the program ends is no part of it.
    sys.stdout = sys.stderr
    return code


def _torn_bytecode(error: Exception) -> str | None:
    """The compiled module that Python could not read, if that is the error.

    Python 3.11 and earlier releases of 3.12 and 3.13 write such a file on a full disk as far as it goes, without a
    word, and each command that needs the module would end in a traceback from then on.
    """
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    if last is None or last.tb_frame.f_code.co_name != "_compile_bytecode":
        return None
    place: object = last.tb_frame.f_locals.get("bytecode_path")
    return place if isinstance(place, str) and place.endswith(".pyc") else None


def _end_at_once(code: int) -> None:
    """A signal ends this process at once and with its code: the command is done, and nothing of it is left to clear up.

    Python waits for each thread, and a plug-in's may never end; Control-C there would make a traceback.
    """

    def end(number: int, frame: object) -> None:
        os._exit(code)

    for number in _ends():
        if signal.getsignal(number) != signal.SIG_IGN:  # as nohup has it
            signal.signal(number, end)


def _hear_nothing() -> None:
    """Nothing but Python's own end is left, in which a signal would give the code of a command that failed."""
    for number in _ends():
        signal.signal(number, signal.SIG_IGN)


def _ends() -> list[int]:
    """The signals that end a program and that this system has."""
    numbers = (getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP"))
    return [number for number in numbers if number is not None]


if __name__ == "__main__":
    sys.exit(main())
