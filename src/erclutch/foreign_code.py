"""What code of another package changes of this process is put back, and what errors of code that may be absent say.

A folder that a plug-in goes to would be the place of a run, a function of NumPy that it replaces would be that of every
law. Both would be taken in silence. What changes no number, no file and no answer is left as it is: variables of the
environment and paths of modules, by which libraries of a plug-in find each other, its threads, and random numbers that
all share, which nothing of ours draws from.
"""

from __future__ import annotations

import locale
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache, partial
from opcode import opmap
from threading import Lock
from types import ModuleType
from typing import Any, NamedTuple

_LOCK = Lock()
#: The process as it was when the first of the calls that are under way began, and how many are.
_BEFORE: dict[str, Any] = {}
_FUNCTIONS: dict[str, Mapping[str, Any]] = {}
_UNDER_WAY = [0]
#: How many of them are under way in each thread, one within the other.
_THREAD = threading.local()
#: Modules by which all numbers are computed: looked at behind each call of a plug-in.
_NUMERIC = ("builtins", "math", "numpy", "numpy.linalg", "numpy.random")
#: Packages of which a plug-in may replace nothing while it is imported.
_SHARED = ("builtins", "erclutch", "json", "math", "numpy", "scipy")
_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")
_UNSEEN_MODE = 0o077  # of a file that another thread makes at that moment: too private harms nobody


@contextmanager
def kept_process(*, imports: bool = False) -> Generator[list[str]]:
    """Puts back what decides where files lie, what is printed, what ends the program, and how numbers are computed.

    Args:
        imports: whether modules of another package are imported: these are held to more than a call is.

    Yields: a list that has the names of the functions that were replaced, when the code has run.
    """
    replaced: list[str] = []
    _environment()  # as it is before anything of others runs
    numpy: Any = sys.modules.get("numpy")  # what is read of no number needs none
    faults: Any = None if numpy is None else numpy.geterr()  # of this thread
    with _LOCK:
        if _UNDER_WAY[0] == 0:
            _BEFORE.update(_process())
            _FUNCTIONS.clear()
        # A law is asked thousands of times in a fit: what it computes with is looked at each time, the rest at the end.
        within = getattr(_THREAD, "calls", 0)
        _THREAD.calls = within + 1
        watched: Sequence[str] = _NUMERIC
        if imports:
            watched = [name for name in list(sys.modules) if name.partition(".")[0] in _SHARED]
        for name in watched:
            module = sys.modules.get(name)
            if isinstance(module, ModuleType) and name not in _FUNCTIONS:
                _FUNCTIONS[name] = dict(vars(module))
        _UNDER_WAY[0] += 1
    try:
        yield replaced
    finally:
        with _LOCK:
            _UNDER_WAY[0] -= 1
            _THREAD.calls = within
            if within == 0:
                now = _process()
                for what, before in _BEFORE.items():
                    if now.get(what) != before:
                        with suppress(Exception):
                            _PROCESS[what].put(before)
            for name in list(_FUNCTIONS) if imports else _NUMERIC:
                replaced += _put_functions_back(name)
        _compute_as_usual()
        if numpy is not None:
            numpy.seterr(**faults)


# --- what the process has one of --------------------------------------------------------------------------------------


class _Kept(NamedTuple):
    read: Callable[[], Any]
    put: Callable[[Any], object]


def _mode_of_files() -> int:
    mask = os.umask(_UNSEEN_MODE)  # nobody can read it alone
    os.umask(mask)
    return mask


def _put_streams(streams: tuple[Any, Any]) -> None:
    sys.stdout, sys.stderr = streams


def _handlers() -> Mapping[int, Any]:
    """Of the signals that end a program; those of other threads than the first are none."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    numbers = (getattr(signal, name, None) for name in _ENDING)
    return {number: signal.getsignal(number) for number in numbers if number is not None}


def _put_handlers(handlers: Mapping[int, Any]) -> None:
    for number, handler in handlers.items() if _handlers() else ():
        if handler is not None:  # None: code that is not Python's has set it
            signal.signal(number, handler)


def _put_warnings(filters: list[Any]) -> None:
    warnings.filters[:] = filters  # pyright: ignore[reportIndexIssue]
    with warnings.catch_warnings():  # which forgets what was decided by the filters before
        pass


def _printing() -> Any:
    """NumPy's way to print, by which older versions of it printed fewer digits of a number."""
    numpy = sys.modules.get("numpy")
    return None if numpy is None else numpy.get_printoptions()


def _put_printing(options: Any) -> None:
    if options is not None:
        sys.modules["numpy"].set_printoptions(**options)


#: Sets the language, or says which it is where it is given none.
_LANGUAGE = partial(locale.setlocale, locale.LC_ALL)
_PROCESS: Mapping[str, _Kept] = {
    "folder": _Kept(os.getcwd, os.chdir),
    "depth of recursion": _Kept(sys.getrecursionlimit, sys.setrecursionlimit),
    "mode of new files": _Kept(_mode_of_files, os.umask),
    "streams": _Kept(lambda: (sys.stdout, sys.stderr), _put_streams),
    "handlers of signals": _Kept(_handlers, _put_handlers),
    # By which names of months are read.
    "language": _Kept(_LANGUAGE, _LANGUAGE),
    # One that makes errors of warnings would end what only warns.
    "warnings": _Kept(lambda: list(warnings.filters), _put_warnings),
    "printed numbers": _Kept(_printing, _put_printing),
}


def _process() -> Mapping[str, Any]:
    state: dict[str, Any] = {}
    for name, kept in _PROCESS.items():
        with suppress(OSError):  # a folder that was removed has no name
            state[name] = kept.read()
    return state


# --- by what numbers are computed -------------------------------------------------------------------------------------


def _put_functions_back(name: str) -> list[str]:
    """Puts back what code replaced of a module; returns the names of that."""
    before, module = _FUNCTIONS.get(name), sys.modules.get(name)
    if before is None or module is None:
        return []
    now = vars(module)
    with suppress(Exception):  # what took the place of a function may not say whether it is equal
        # New names come behind the old ones. Whole lists are compared at once, which takes a tenth of the time.
        if list(now.values())[: len(before)] == list(before.values()):
            return []
    replaced: list[str] = []
    for called, value in before.items():
        if now.get(called) is value:
            continue
        # What is private, or a module, may come and go.
        is_a_module = isinstance(value, ModuleType) or isinstance(now.get(called), ModuleType)
        if called.startswith("_") or is_a_module:
            continue
        # Ours keep values of their own under a name; their functions and classes stay.
        if name.startswith("erclutch") and not callable(value):
            continue
        setattr(module, called, value)
        replaced.append(f"{name}.{called}")
    return replaced


@cache
def _environment() -> tuple[Callable[[Any], Any], Any] | None:
    """The function that sets this processor's way to compute, and the way in which it began; None without one."""
    try:
        import ctypes

        library = ctypes.CDLL(None)
        way = ctypes.create_string_buffer(1024)  # more than any processor's
        return (library.fesetenv, way) if library.fegetenv(way) == 0 else None
    except (ImportError, OSError, AttributeError, TypeError):  # a system that has none of this
        return None


def _compute_as_usual() -> None:
    """Sees that the least numbers are not zero and that sums are rounded to the nearest.

    A library that was compiled with ``-ffast-math`` may change that as it is loaded.
    """
    environment = _environment()
    if environment is None:
        return
    # Names and no plain numbers: of those Python would compute the sums before it runs them.
    least = 5e-324
    one = 1.0
    half_a_step = 1.1102230246251565e-16  # of the floating-point numbers above 1
    least_is_a_number = least * one > 0.0
    rounds_to_nearest = one + half_a_step == one and one + 1.01 * half_a_step > one
    if not (least_is_a_number and rounds_to_nearest):
        put, way = environment
        put(way)


def said_by(error: BaseException) -> str:
    """What an error of somebody else says of itself, on a line: that may fail too."""
    try:
        return " ".join(str(error).split())[:300] or "no reason given"
    except Exception:
        return "it cannot say why"


def asked_for_from_outside(error: BaseException) -> bool:
    """Whether a signal ends what runs now, and no line of a plug-in: Control-C, or a handler of ours."""
    place = error.__traceback__
    if isinstance(error, Exception) or place is None:
        return False
    while place.tb_next is not None:
        place = place.tb_next
    code = place.tb_frame.f_code.co_code
    ours = str(place.tb_frame.f_globals.get("__name__")).startswith("erclutch.")
    # Python takes Control-C between its steps, never within a statement `raise`.
    raises = code[place.tb_lasti] == opmap["RAISE_VARARGS"]
    return ours or (isinstance(error, KeyboardInterrupt) and not raises)


def missing_wing(error: ModuleNotFoundError, what: str) -> tuple[str, str] | None:
    """Problem and remedy where a module is in a wing whose folder is not there, else None.

    Args:
        error: that names the module.
        what: needs it, for example "the command live".
    """
    room, *below = (error.name or "").removeprefix("erclutch.").split(".")
    if room != "wings" or len(below) > 1:
        return None
    wing = below[0] if below else "all wings"
    remedy = "Install erclutch whole: its package has all wings"
    return f"{what} needs the wing {wing}, whose folder is not there", remedy
