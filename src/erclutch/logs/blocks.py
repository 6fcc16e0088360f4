"""Blocks give the rows of a data set some at a time, whether they are in memory or on disk.

Every fit passes over blocks, and takes nothing from a pass but sums, extremes and triangles of QR decompositions: these
add up over ranges of blocks in their order. A log in memory is one range of one block.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from erclutch.signals.array import Array

T = TypeVar("T")
U = TypeVar("U")


class Blocks(ABC, Generic[T]):
    """What is known of the rows of each block, in the order of the rows; each iteration is a pass over all of them."""

    @abstractmethod
    def __iter__(self) -> Iterator[T]: ...

    @abstractmethod
    def map(self, make: Callable[[T], U]) -> Blocks[U]:
        """What a function makes of each block."""

    @abstractmethod
    def fold(self, of: Callable[[Iterable[T]], U]) -> Iterator[U]:
        """What a function makes of the blocks of each range, in the order of the ranges; on disk a task each."""

    @abstractmethod
    def means(self, of: Callable[[T], Sequence[Array]]) -> list[float]:
        """Means over all rows of the arrays (n,) that a function makes of a block: `numpy.mean` of the whole."""


@dataclass(frozen=True)
class OneBlock(Blocks[T]):
    """All rows in one block, in memory: what a function makes of it is made once."""

    whole: T

    def __iter__(self) -> Iterator[T]:
        return iter((self.whole,))

    def map(self, make: Callable[[T], U]) -> Blocks[U]:
        """See `Blocks.map`."""
        return OneBlock(make(self.whole))

    def fold(self, of: Callable[[Iterable[T]], U]) -> Iterator[U]:
        """See `Blocks.fold`."""
        return iter((of((self.whole,)),))

    def means(self, of: Callable[[T], Sequence[Array]]) -> list[float]:
        """See `Blocks.means`."""
        return [float(np.mean(values)) for values in of(self.whole)]
