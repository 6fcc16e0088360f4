"""Files that belong together get their names at one moment: none of them is there before all of them are whole."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager

from erclutch.errors import ErclutchError
from erclutch.files.places import unheard


class _Group:
    """Finished files that wait for the others: how each gets its name, and what is cleared up then."""

    def __init__(self) -> None:
        self.moves: list[Callable[[], None]] = []
        self.clearing = ExitStack()


class _Open(threading.local):
    group: _Group | None = None  # of this thread


_OPEN = _Open()


@contextmanager
def together() -> Generator[None]:
    """Files that are written in this block get their names when the block ends, and none of them where it fails.

    A signal is heard before the first move or after the last one, a full disk before. A power cut, or `kill -9`, may
    come between two moves. A block in another one is a part of it.

    Raises:
        ErclutchError: the name of a file was taken meanwhile; the other files are there.
        OSError: a file cannot be moved; the other files are there.
    """
    if _OPEN.group is not None:
        yield
        return
    group = _Group()
    try:
        _OPEN.group = group
        yield
        _OPEN.group = None
        failed: list[ErclutchError | OSError] = []
        with unheard():
            for move in group.moves:
                try:
                    move()
                except (ErclutchError, OSError) as error:
                    failed.append(error)
            group.clearing.close()  # old files, whose place they took
        if failed:
            raise failed[0]
    finally:
        _OPEN.group = None
        with unheard():
            group.clearing.close()


def move_later(move: Callable[[], None], clearing: ExitStack) -> bool:
    """Leave a finished file to the group that is open in this thread; False where none is.

    Args:
        move: gives the file its name.
        clearing: what is done after the move, or in its place; the group takes it over.
    """
    group = _OPEN.group
    if group is None:
        return False
    with unheard():
        group.moves.append(move)
        group.clearing.push(clearing.pop_all())
    return True
