"""Numba compiles the twin: machine code without a C compiler on the user's machine, cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function of numbers, arrays and named tuples of them; the result is kept beside the source.

    It runs without the interpreter's lock. IEEE arithmetic is kept (no fast-math), so the same seed gives the same log.
    Calls become part of their caller: passing some hundred parameters at each step, and counting the references to
    their arrays, would take a third of the time.
    """
    import numba

    compiler: Any = numba.njit(cache=True, nogil=True, forceinline=True, fastmath=False, error_model="numpy")
    return cast(F, compiler(function))
