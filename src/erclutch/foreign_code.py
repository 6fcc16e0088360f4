"""What code of another package changes of this process is put back, and what errors of code that may be absent say.

A folder that a plug-in goes to would be the place of a run, a function of NumPy that it replaces would be that of every
law. Both would be taken in silence.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from opcode import opmap
from threading import Lock
from types import ModuleType
from typing import Any

_LOCK = Lock()
#: The process as it was when the first of the calls that are under way began, and how many are.
_BEFORE: dict[str, Any] = {}
_UNDER_WAY = [0]
_NUMERIC = ("math", "numpy", "numpy.linalg", "numpy.random")


@contextmanager
def kept_process(*, functions: bool = False) -> Generator[list[str]]:
    """Puts back the current folder, the depth of recursion and NumPy's answer to overflow.

    Args:
        functions: whether what code replaces of NumPy and of `math` is put back too.

    Yields: a list that has the names of what was replaced of these, when the code has run.
    """
    numpy: Any = sys.modules.get("numpy")  # what is read of no number needs none
    faults: Any = None if numpy is None else numpy.geterr()  # of this thread
    with _LOCK:
        if _UNDER_WAY[0] == 0:
            _BEFORE.update(_process())
        _UNDER_WAY[0] += 1
    try:
        with _kept_functions() if functions else nullcontext[list[str]]([]) as replaced:
            yield replaced
    finally:
        with _LOCK:
            _UNDER_WAY[0] -= 1
            _put_back(_BEFORE)
        if numpy is not None:
            numpy.seterr(**faults)


def _process() -> Mapping[str, Any]:
    try:
        folder = os.getcwd()
    except OSError:  # it was removed
        folder = ""
    return {
        "folder": folder,
        "depth": sys.getrecursionlimit(),
    }


def _put_back(before: Mapping[str, Any]) -> None:
    now = _process()
    if now["folder"] != before["folder"] and before["folder"]:
        with suppress(OSError):
            os.chdir(before["folder"])
    if now["depth"] != before["depth"]:
        sys.setrecursionlimit(before["depth"])


@contextmanager
def _kept_functions() -> Generator[list[str]]:
    """Puts back what code replaces of NumPy and of `math`; the list has the names of that, when the code has run."""
    before = {name: _public(sys.modules[name]) for name in _NUMERIC if name in sys.modules}
    changed: list[str] = []
    try:
        yield changed
    finally:
        for name, values in before.items():
            now = vars(sys.modules[name])
            for called, value in values.items():
                if now.get(called) is not value:
                    setattr(sys.modules[name], called, value)
                    changed.append(f"{name}.{called}")


def _public(module: ModuleType) -> Mapping[str, Any]:
    """What a module offers, but modules and what it makes when it is first asked for."""
    return {
        name: value
        for name, value in vars(module).items()
        if not name.startswith("_") and not isinstance(value, ModuleType)
    }


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
