"""Numba compiles the twin: machine code without a C compiler on the user's machine, cached on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from erclutch.arithmetic.recursion import machine_code

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function of numbers, arrays and named tuples of them; the result is kept beside the source.

    It runs without the interpreter's lock. IEEE arithmetic is kept (no fast-math), so the same seed gives the same log.
    Calls become part of their caller: passing some hundred parameters at each step, and counting the references to
    their arrays, would take a third of the time.
    """
    return machine_code(function, inline=True)
