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


def for_arguments_like(function: F, *arguments: Any) -> F:
    """The machine code of a compiled function for arguments of these types alone.

    A call of the function itself looks at the type of each of some hundred parameters, which takes three times as long
    as a step of the twin.
    """
    import numba

    library: Any = numba  # which tells no types of its own
    compile_for = getattr(function, "compile", None)
    if compile_for is None:  # NUMBA_DISABLE_JIT
        return function
    return compile_for(tuple(library.typeof(argument) for argument in arguments))
