"""Files and folders are there whole or not at all; this module writes them, and knows the user's cache."""

from __future__ import annotations

import errno
import glob
import hashlib
import os
import shutil
import tempfile
import time
import tomllib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from json import JSONDecodeError
from pathlib import Path
from typing import Any, cast

from erclutch.errors import ErclutchError, RunError


def cache_folder() -> Path:
    """Where what can be made again is kept: ``$ERCLUTCH_CACHE``, or ``erclutch`` in the user's cache folder."""
    given = os.environ.get("ERCLUTCH_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "erclutch"


def plain_words(error: Exception) -> str:
    """What is wrong with a file that cannot be read, without the words of Python."""
    if isinstance(error, UnicodeDecodeError):
        return "it is no UTF-8 text"
    if isinstance(error, JSONDecodeError):
        return f"it is no JSON from line {error.lineno} on"
    if isinstance(error, RecursionError):
        return "it is nested too deep"
    if "integer string conversion" in str(error):  # what Python says of thousands of digits
        return "a whole number in it has too many digits"
    missing = isinstance(error, FileNotFoundError)
    return "there is no such file" if missing else getattr(error, "strerror", None) or str(error)


def toml_of(content: bytes) -> dict[str, Any]:
    """What a TOML file holds; its whole numbers have 64 bits at most, so that each can be a float and be printed.

    Raises:
        ValueError, RecursionError: it is no such file; `plain_words` says why.
    """
    body = tomllib.loads(content.decode("utf-8-sig"))
    if not _fits(body):
        raise ValueError("a whole number in it has more than 64 bits")
    return body


def _fits(value: object) -> bool:
    if isinstance(value, dict):
        return all(map(_fits, cast(dict[str, object], value).values()))
    if isinstance(value, list):
        return all(map(_fits, cast(list[object], value)))
    return not isinstance(value, int) or -(2**63) <= value < 2**63


def unwritable(
    path: Path,
    error: OSError,
    problem: str = "cannot be written",
    remedy: str = "Give another place",
    kind: type[ErclutchError] = RunError,
) -> ErclutchError:
    """The error of a file or folder that cannot be written."""
    return kind(f"{problem}: {error.strerror or error}", where=str(path), remedy=remedy)


def may_write(
    folder: Path, force: bool, marker: str, what: str = "a run", kind: type[ErclutchError] = RunError
) -> None:
    """Say before any work whether a folder may be made, or replaced, and claim its place.

    Args:
        folder: its name.
        force: whether an old one may be replaced.
        marker: a file in it that tells it from others, which are never replaced.
        what: what it is called.
        kind: what is raised.

    Raises:
        ErclutchError: it may not, or its parent is missing or cannot be written; of the class ``kind``.
    """
    if not folder.parent.is_dir():
        raise kind("its parent folder does not exist", where=str(folder), remedy=f"Make {folder.parent} first")
    if not os.access(folder.parent, os.W_OK):
        raise kind("its parent folder cannot be written", where=str(folder), remedy="Give --out another place")
    claim(folder, kind)
    if not os.path.lexists(folder):
        return
    try:
        if not (folder / marker).is_file():
            raise kind(f"exists and is not {what}", where=str(folder), remedy="Give --out another name")
        if not force:
            raise kind(f"there is {what} already", where=str(folder), remedy="Give --out another name, or --force")
    except ErclutchError:
        _release(folder)
        raise


def may_write_file(path: Path | None, force: bool, option: str = "out") -> None:
    """Say before any work whether a file may be made, or replaced, and claim its place; None is no file.

    Raises:
        RunError: there is a file of this name, and it may not be replaced; ``option`` gave the name.
    """
    if path is None:
        return
    if os.path.lexists(path) and not force:
        raise RunError("there is a file already", where=str(path), remedy=f"Give --{option} another name, or --force")
    claim(path)


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --- one place that writes --------------------------------------------------------------------------------------------
#
# Three things keep two commands from taking each other's place. A command claims the place before its work, so that a
# second one is told at once and not after an hour. The finished file or folder is moved by a rename that refuses an
# occupied place. And what loses that race all the same, on a network disk say, is kept beside under a free name.

#: Places that this process has claimed, each with the descriptor that holds the lock.
_claims: dict[Path, int] = {}
_ABANDONED = 3600.0  # s without a change
_NO_REPLACE, _EXCHANGE = 1, 2  # flags of renameat2(2)


def claim(path: Path, kind: type[ErclutchError] = RunError) -> None:
    """Keep other commands of this user from writing to a place, until it is written or this process ends.

    The kernel frees a claim when its process dies, however it dies. Where there are no locks nothing is claimed, and
    the move at the end still refuses an occupied place.

    Raises:
        ErclutchError: another process writes there; of the class ``kind``.
    """
    place = Path(os.path.abspath(path))
    if place in _claims:
        return
    try:
        import fcntl

        folder = Path(tempfile.gettempdir()) / f"erclutch-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        if folder.stat().st_uid != os.getuid() or folder.is_symlink():
            return
        name = hashlib.sha256(os.fsencode(place)).hexdigest()[:32]
        lock = os.open(folder / f"{name}.lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except (ImportError, AttributeError, OSError):
        return
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(lock)
        remedy = "Wait until it has ended, or give another name"
        raise kind("another command is writing to this place", where=str(path), remedy=remedy) from error
    except OSError:
        os.close(lock)
        return
    _claims[place] = lock


def _sweep(target: Path) -> None:
    """Take away what a command that was killed has left of this place; old enough that no command writes it still."""
    if Path(os.path.abspath(target)) not in _claims:
        return
    for ending in ("partial", "old"):
        for left in target.parent.glob(f".{glob.escape(target.name)}.{ending}-*"):
            try:
                state = left.lstat()
            except OSError:
                continue
            if state.st_uid != os.getuid() or time.time() - state.st_mtime < _ABANDONED:
                continue
            if left.is_dir() and not left.is_symlink():
                shutil.rmtree(left, ignore_errors=True)
            else:
                left.unlink(missing_ok=True)


def _release(path: Path) -> None:
    lock = _claims.pop(Path(os.path.abspath(path)), None)
    if lock is not None:
        os.close(lock)


@contextmanager
def whole_file(
    target: Path,
    unwritable: Callable[[Path, OSError], ErclutchError] = unwritable,
    *,
    replace: bool | None = None,
) -> Generator[Path]:
    """A file to write that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Args:
        target: its name.
        unwritable: the error to raise when it cannot be written.
        replace: whether an old file of that name is replaced; None: one that is there when writing begins is.

    Raises:
        RunError: a file of that name came meanwhile; the new one is kept under another name, which the error tells.
    """
    replace = os.path.lexists(target) if replace is None else replace
    _sweep(target)
    partial: Path | None = None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.partial-", suffix=target.suffix, dir=target.parent)
        os.close(handle)
        partial = Path(name)
        yield partial
        partial.chmod(0o644)
        if replace:
            os.replace(partial, target)
        else:
            _to_free_place(partial, target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)
        _release(target)


@contextmanager
def whole_folder(
    target: Path, unwritable: Callable[[Path, OSError], ErclutchError], *, replace: bool | None = None
) -> Generator[Path, None, None]:
    """A folder to fill that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Args:
        target: its name.
        unwritable: the error to raise when it cannot be written.
        replace: whether an old folder of that name is deleted once the new one is there; None: one that is there when
            writing begins is.

    Raises:
        RunError: a folder of that name came meanwhile; the new one is kept under another name, which the error tells.
    """
    replace = os.path.lexists(target) if replace is None else replace
    _sweep(target)
    try:
        partial = Path(tempfile.mkdtemp(prefix=f".{target.name}.partial-", dir=target.parent))
    except OSError as error:
        raise unwritable(target, error) from error
    try:
        partial.chmod(0o755)
        yield partial
        if replace:
            _replace_folder(partial, target)
        else:
            _to_free_place(partial, target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        _release(target)


def _to_free_place(partial: Path, target: Path) -> None:
    """Give a finished file or folder its name; where another has it, the next free name, and say so.

    Raises:
        RunError: another has the name.
    """
    try:
        _move_new(partial, target)
        return
    except FileExistsError:
        pass
    for number in range(2, 10_000):
        beside = target.with_name(f"{target.stem}-{number}{target.suffix}")
        try:
            _move_new(partial, beside)
        except FileExistsError:
            continue
        remedy = f"What this command made is kept as {beside.name}"
        raise RunError("another command has made this meanwhile", where=str(target), remedy=remedy)
    raise FileExistsError(errno.EEXIST, "the names beside it are taken too")


def _move_new(source: Path, target: Path) -> None:
    """Rename a file or folder to a name that nothing has.

    Raises:
        FileExistsError: something has it.
    """
    if _renameat2(source, target, _NO_REPLACE):
        return
    if source.is_dir():
        # An empty folder reserves the name, and a rename takes its place in one step.
        os.mkdir(target)
        os.rename(source, target)
    else:
        os.link(source, target)
        source.unlink()


def _replace_folder(partial: Path, target: Path) -> None:
    """Put a folder in the place of another; where two do so at once, each is whole and the last one stays."""
    while True:
        try:
            _move_new(partial, target)
            return
        except FileExistsError:
            pass
        try:
            if _renameat2(partial, target, _EXCHANGE):
                return  # the old folder has the partial's name now, and goes with it
            old = Path(tempfile.mkdtemp(prefix=f".{target.name}.old-", dir=target.parent))
            try:
                os.rename(target, old / target.name)
            finally:
                shutil.rmtree(old, ignore_errors=True)
        except FileNotFoundError:
            continue  # another command has taken the old one away


def _renameat2(source: Path, target: Path, flag: int) -> bool:
    """Rename with a flag of Linux; False where the system or the disk has no such call.

    Raises:
        OSError: the rename failed, FileExistsError where the name is taken.
    """
    import ctypes

    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is None:
        return False
    here = -100  # AT_FDCWD: paths are relative to the current folder
    if call(here, os.fsencode(source), here, os.fsencode(target), ctypes.c_uint(flag)) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
        return False
    raise OSError(number, os.strerror(number), str(target))
