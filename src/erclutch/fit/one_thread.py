"""One BLAS thread: the matrices of a fit are small, and more threads would only wait for each other."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def one_thread() -> Generator[None]:
    """Keep BLAS to one thread, which also makes its sums the same on every machine."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield
