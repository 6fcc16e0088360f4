"""A place is the name of a file or folder on a disk: it is reserved for one writer, and nothing takes another's place.

Two things keep it so. A reservation, a lock beside the name, is held from the look to the move, so that nobody works in
vain. The move itself refuses a name that is taken: no lock is needed for that, and not every disk has locks.
"""

from __future__ import annotations

import ctypes
import errno
import itertools
import os
import secrets
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from erclutch.errors import ErclutchError, RunError

try:
    import fcntl
except ImportError:  # Windows: a rename refuses there by itself
    fcntl = None

# --- reservations -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reservation:
    """A name that a thread keeps until it is written."""

    may_replace: Callable[[Path], bool]
    owner: tuple[int, int]  # process and thread
    lock: int | None  # descriptor of the locked file; None where the file system has no locks


_RESERVED: dict[Path, Reservation] = {}
_RESERVING = threading.Lock()
_LONGEST_NAME = 256  # bytes of a machine's name


def reserve(
    target: Path,
    may_replace: Callable[[Path], bool],
    kind: type[ErclutchError] = RunError,
    option: str = "out",
    patience: float = 0.0,
) -> None:
    """Keep a name for this thread, from the look to the move, until it is written or released.

    Another program that asks for the name meanwhile is refused before it works in vain. What a program that was killed
    left beside the name is cleared away. Where the file system has no locks, the move alone refuses.

    Args:
        target: the file or folder to be written.
        may_replace: whether what stands there may be replaced; asked again at the move.
        kind: what is raised.
        option: gave the name.
        patience: seconds to wait for another writer.

    Raises:
        ErclutchError: another program, or thread, is writing it; of the class ``kind``.
    """
    place = _place(target)
    until = time.monotonic() + patience
    while True:
        with unheard(), _RESERVING:
            holder = _RESERVED.get(place)
            if holder is not None and holder.owner == _us():
                _RESERVED[place] = replace(holder, may_replace=may_replace)
                return
            # A forked process inherits the table, not the names.
            if holder is None or holder.owner[0] != os.getpid():
                with suppress(BlockingIOError):
                    _RESERVED[place] = Reservation(may_replace, _us(), _locked(place))
                    return
        if time.monotonic() >= until:
            remedy = f"Wait until it has finished, or give --{option} another name"
            raise kind(
                "another program is writing it at this moment", where=str(target), remedy=remedy
            )
        time.sleep(0.02)


def held(target: Path) -> Reservation | None:
    """The reservation of a name by this thread."""
    reservation = _RESERVED.get(_place(target))
    return reservation if reservation is not None and reservation.owner == _us() else None


def release(target: Path) -> None:
    """Give a name free that this thread reserved."""
    reservation = held(target)
    if reservation is not None:
        with unheard(), _RESERVING:
            del _RESERVED[_place(target)]
            _unlocked(_place(target), reservation.lock)


def release_all() -> None:
    """Give all names free that this process reserved, at its end."""
    with unheard(), _RESERVING:
        for place, reservation in list(_RESERVED.items()):
            if reservation.owner[0] == os.getpid():
                del _RESERVED[place]
                _unlocked(place, reservation.lock)


@contextmanager
def unheard() -> Generator[None]:
    """A signal that ends the program is heard after this block, and none gets lost.

    What the block makes on the disk and what it keeps of that go together: a signal between both would leave a file
    that nobody knows of.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # Python hears signals in the main thread alone
        return
    heard: list[int] = []
    usual: dict[int, Any] = {}
    try:
        for name in ("SIGHUP", "SIGTERM", "SIGINT"):
            number = getattr(signal, name, None)
            handler = None if number is None else signal.getsignal(number)
            # Without a handler the system ends the program at once, or nothing does.
            if number is not None and callable(handler):
                usual[number] = handler
                signal.signal(number, lambda number, frame: heard.append(number))
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        for number in heard:
            signal.raise_signal(number)


def _us() -> tuple[int, int]:
    return os.getpid(), threading.get_ident()


def _place(target: Path) -> Path:
    """One name for a file or folder, however its parent is written."""
    return Path(os.path.realpath(target.parent)) / target.name


def is_there(target: Path) -> bool:
    """Whether the name is taken, also by a link to nothing."""
    return os.path.lexists(target)


def nothing(target: Path) -> bool:
    """That nothing may be replaced, whatever it is."""
    return False


def _lock_of(place: Path) -> Path:
    return place.with_name(f".{place.name}.writing")


def _locked(place: Path) -> int | None:
    """Lock a name for this process; None where the file system, or the system, has no locks.

    A lock file that is there already was left by a program that died. If the program ran on this machine, what it left
    is cleared away.

    Raises:
        BlockingIOError: another holds the lock.
    """
    if fcntl is None:
        return None
    lock = _lock_of(place)
    while True:
        left = lock.exists()
        try:
            try:
                handle = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
            except PermissionError:  # another user's; it can be locked all the same
                handle = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW)
        except OSError:  # whoever writes says why the folder cannot be written
            return None
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            raise
        except OSError:
            os.close(handle)
            lock.unlink(missing_ok=True)
            return None
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), lock.stat()):
                break
        os.close(handle)  # its owner gave it free and deleted it between our two steps
    with suppress(OSError):
        if left and os.read(handle, _LONGEST_NAME) == _machine():
            # The old folder that the program had moved away is put back; what else it left is deleted.
            for rest in place.parent.iterdir():
                was_moved_away = rest.name.startswith(f".{place.name}.old-")
                if was_moved_away and not is_there(place):
                    rest.rename(place)
                elif was_moved_away or rest.name.startswith(f".{place.name}.partial-"):
                    is_folder = rest.is_dir() and not rest.is_symlink()
                    shutil.rmtree(rest) if is_folder else rest.unlink()
        os.ftruncate(handle, 0)
        os.pwrite(handle, _machine(), 0)
    return handle


def _machine() -> bytes:
    """The machine's name: a network disk may know the locks of this machine alone."""
    return os.fsencode(os.uname().nodename)[:_LONGEST_NAME]


def _unlocked(place: Path, lock: int | None) -> None:
    if lock is not None and fcntl is not None:
        with suppress(OSError):
            _lock_of(place).unlink()
        # A forked child may hold the same lock: closing alone would not open it.
        fcntl.flock(lock, fcntl.LOCK_UN)
        os.close(lock)


# --- moves ------------------------------------------------------------------------------------------------------------


def put_new(finished: Path, target: Path) -> None:
    """Give a finished file or folder a name on the same disk that nothing has.

    Raises:
        FileExistsError: something has the name; the finished file or folder stays where it is.
        OSError: it cannot be moved.
    """
    if _renamed(finished, target, _NOREPLACE):
        return
    if os.name == "nt":
        finished.rename(target)  # refuses by itself
    elif finished.is_dir():
        target.mkdir()  # refuses what is there; the move then takes the place of this empty folder and of no other
        try:
            finished.rename(target)
        except OSError:
            target.rmdir()
            raise
    else:
        # No rename refuses here: a second name refuses, and so does making an empty file.
        try:
            os.link(finished, target)
        except FileExistsError:
            # A network share may have done it and lost its own answer.
            if not os.path.samestat(target.lstat(), finished.stat()):
                raise
        except OSError:  # FAT and some shares know no second name
            os.close(os.open(target, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
            os.replace(finished, target)
            return
        finished.unlink()


def put_beside(finished: Path, target: Path) -> Path:
    """Give a finished file or folder its name, or the next one that is free: run, run-2, run-3, ...

    Returns:
        The name that it got.

    Raises:
        OSError: it cannot be moved.
    """
    stem, suffix = (target.name, "") if finished.is_dir() else (target.stem, target.suffix)
    free = target
    for number in itertools.count(2):
        try:
            put_new(finished, free)
            break
        except FileExistsError:
            free = target.with_name(f"{stem}-{number}{suffix}")
    return free


def replaced(partial: Path, target: Path, may_replace: Callable[[Path], bool]) -> bool:
    """Put a finished file or folder in the place of an old one, which is deleted; False where that is now another."""
    if _renamed(partial, target, _EXCHANGE):
        if may_replace(partial):
            return True
        _renamed(partial, target, _EXCHANGE)
        return False
    if not partial.is_dir():
        os.replace(partial, target)
        return True
    old = target.with_name(f".{target.name}.old-{secrets.token_hex(4)}")
    target.rename(old)
    try:
        put_new(partial, target)
    except OSError:
        put_beside(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)
    return True


_NOREPLACE, _EXCHANGE = 1, 2  # of Linux' renameat2
_HERE = -100  # AT_FDCWD: paths are relative to the working folder
_NO_SUCH_RENAME = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP, errno.EPERM)


def _renamed(source: Path, target: Path, how: int) -> bool:
    """Rename and refuse, or exchange, in one step of the system; False where the system or the disk has no such step.

    Raises:
        OSError: the step is there, and refused.
    """
    rename = _renameat2()
    if rename is None or rename(_HERE, os.fsencode(source), _HERE, os.fsencode(target), how) == 0:
        return rename is not None
    number = ctypes.get_errno()
    if number in _NO_SUCH_RENAME:
        return False
    raise OSError(number, os.strerror(number), str(target))


@cache
def _renameat2() -> Callable[..., int] | None:
    if sys.platform != "linux":
        return None
    return getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
