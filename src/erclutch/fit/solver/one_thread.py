"""One BLAS thread: the matrices of a fit are small, and more threads would only wait for each other."""

from __future__ import annotations

import sys
from collections.abc import Generator
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Generator[None]:
    """Keep BLAS to one thread, which also makes its sums the same on every machine."""
    with _libraries(len(sys.modules)).limit(limits=1):
        yield


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """The libraries with threads of their own. To find them takes 20 ms; a new module may have brought another."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
