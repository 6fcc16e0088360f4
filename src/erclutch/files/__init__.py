"""Files and folders are there whole or not at all, and take nobody's place; this module writes them.

A command reserves a name when it looks at it, before any work, and holds the name until the finished file or folder is
moved there (`erclutch.files.places`).
"""

from __future__ import annotations

import errno
import functools
import os
import secrets
import shutil
from collections.abc import Callable, Generator, Iterable
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from erclutch.errors import ErclutchError, RunError
from erclutch.files.groups import move_later
from erclutch.files.places import (
    Reservation,
    held,
    is_there,
    nothing,
    put_beside,
    put_new,
    release,
    replaced,
    reserve,
    unheard,
)

LOG_ENDINGS = (".csv", ".parquet", ".mat")  # of the logs that are written


def cache_folder() -> Path:
    """Where what can be made again is kept: ``$ERCLUTCH_CACHE``, or ``erclutch`` in the user's cache folder."""
    given = os.environ.get("ERCLUTCH_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "erclutch"


def unwritable(
    path: Path,
    error: OSError,
    problem: str = "cannot be written",
    remedy: str = "Give another place",
    kind: type[ErclutchError] = RunError,
) -> ErclutchError:
    """The error of a file or folder that cannot be written."""
    return kind(f"{problem}: {error.strerror or error}", where=str(path), remedy=remedy)


# --- the look before any work, which also reserves the name -----------------------------------------------------------


def may_write(
    folder: Path,
    force: bool,
    marker: str,
    what: str = "a run",
    kind: type[ErclutchError] = RunError,
) -> None:
    """Say before any work whether a folder may be made, or replaced; the name is then reserved, see `reserve`.

    Args:
        folder: its name.
        force: whether an old one may be replaced.
        marker: a file in it that tells it from others, which are never replaced.
        what: what it is called.
        kind: what is raised.

    Raises:
        ErclutchError: it may not, or its parent is missing or cannot be written; of the class ``kind``.
    """

    def ours(place: Path) -> bool:
        return (place / marker).is_file()

    if not folder.parent.is_dir():
        raise kind(
            "its parent folder does not exist",
            where=str(folder),
            remedy=f"Make {folder.parent} first",
        )
    require_room(folder, kind=kind)
    reserve(folder, ours if force else nothing, kind)
    if not is_there(folder) or (force and ours(folder)):
        return
    release(folder)
    if not ours(folder):
        raise kind(f"exists and is not {what}", where=str(folder), remedy="Give --out another name")
    raise kind(
        f"there is {what} already", where=str(folder), remedy="Give --out another name, or --force"
    )


def may_fill(folder: Path, option: str = "out") -> None:
    """Say before any work whether files may be put into a folder, which is made with the first of them.

    Raises:
        RunError: it cannot be made, or takes no file. ``option`` gave the name.
    """
    if is_there(folder) and not folder.is_dir():
        problem = "cannot be made: there is a file of that name"
        raise RunError(problem, where=str(folder), remedy=f"Give --{option} another name")
    if not folder.is_dir():
        require_room(folder, option)
    elif not takes_files(folder):
        raise RunError(
            "no file can be put there", where=str(folder), remedy=f"Give --{option} another place"
        )


def require_room(target: Path, option: str = "out", kind: type[ErclutchError] = RunError) -> None:
    """Say before any work whether the folder of a name takes files, or can be made where it is missing.

    Raises:
        ErclutchError: it does not, or cannot; of the class ``kind``. ``option`` gave the name.
    """
    # The root is there, and "." is.
    folder = next(parent for parent in target.parents if is_there(parent))
    missing = folder != target.parent
    remedy = f"Give --{option} another place"
    if not folder.is_dir():
        raise kind(
            f"{folder} is no folder, so nothing can be put there", where=str(target), remedy=remedy
        )
    if not takes_files(folder):
        problem = (
            f"its folder cannot be made in {folder}"
            if missing
            else "its parent folder cannot be written"
        )
        raise kind(problem, where=str(target), remedy=remedy)


def takes_files(folder: Path) -> bool:
    """Whether a file can be made in a folder; it is made and taken away, as rights alone do not tell, /proc for one."""
    if not os.access(folder, os.W_OK | os.X_OK):
        return False
    with suppress(OSError, AttributeError):  # without a name, so that nothing can leave it there
        os.close(os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o600))
        return True
    probe = folder / f".{secrets.token_hex(8)}"
    try:
        with unheard():  # a signal between both would leave the probe
            probe.touch(exist_ok=False)
            probe.unlink()
    except OSError as error:
        # Whoever writes says why.
        return error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE)
    return True


def may_write_file(
    path: Path | None, force: bool, option: str = "out", endings: tuple[str, ...] = ()
) -> None:
    """Say before any work whether a file may be made, or replaced; the name is then reserved. None is no file.

    Raises:
        RunError: there is a file of this name, and it may not be replaced; or its ending is none of those that may be,
            where ``endings`` tells some; or its folder takes no file. ``option`` gave the name.
    """
    if path is None:
        return
    if endings:
        refuse_ending(path, endings, option)
    require_room(path, option)
    reserve(path, is_plain_file if force else nothing, option=option)
    if not is_there(path) or (force and is_plain_file(path)):
        return
    release(path)
    if path.is_dir():
        raise RunError(
            "this is a folder", where=str(path), remedy=f"Give --{option} the name of a file"
        )
    if not is_plain_file(path):
        raise RunError(
            "this is no plain file", where=str(path), remedy=f"Give --{option} the name of a file"
        )
    raise RunError(
        "there is a file already",
        where=str(path),
        remedy=f"Give --{option} another name, or --force",
    )


def spare_logs(logs: Iterable[Path], written: Iterable[Path], options: str = "--out") -> None:
    """Refuse to write over a log that is read, whatever may be replaced: nobody could read it again.

    Args:
        logs: that are read.
        written: files that are to be written.
        options: that give their names.

    Raises:
        RunError: a file would take the place of a log.
    """
    read = {log.resolve() for log in logs}
    for path in written:
        if path.resolve() in read:
            problem = "this is one of the logs, and would be written over"
            raise RunError(problem, where=str(path), remedy=f"Give {options} another name")


def refuse_ending(path: Path, endings: tuple[str, ...], option: str = "out") -> None:
    """Refuse the name of a file whose ending says another kind of file than is written, or none.

    Raises:
        RunError: its ending is none of ``endings``; ``option`` gave the name.
    """
    if path.suffix.lower() in endings:
        return
    *some, last = endings
    allowed = f"{', '.join(some)} or {last}" if some else last
    problem = (
        f"its name cannot end in {path.suffix!r}"
        if path.suffix
        else "its name has no ending, such as " + last
    )
    raise RunError(
        problem, where=str(path), remedy=f"Give --{option} a name that ends in {allowed}"
    )


def is_plain_file(path: Path) -> bool:
    """Whether it is a file that may be replaced by a file: no folder, no device, no pipe."""
    return path.is_file()


@contextmanager
def scratch_folder(prefix: str = "erclutch-", beside: Path | None = None) -> Generator[str]:
    """A temporary folder, or one beside a file, that is taken away; no signal can come between both."""
    folder = None
    try:
        with unheard():
            place = None if beside is None else beside.parent
            folder = TemporaryDirectory(prefix=prefix, dir=place, ignore_cleanup_errors=True)
        yield folder.name
    finally:
        if folder is not None:
            with unheard():  # half of it would stay
                folder.cleanup()


# --- the one place that writes ----------------------------------------------------------------------------------------


@contextmanager
def whole_file(
    target: Path,
    unwritable: Callable[[Path, OSError], ErclutchError] = unwritable,
    may_replace: Callable[[Path], bool] = is_plain_file,
) -> Generator[Path]:
    """A file to write that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Within `erclutch.files.groups.together` it gets its name with the others.

    Args:
        target: its name.
        unwritable: the error to raise when it cannot be written.
        may_replace: whether a file that stands there may be replaced; a reservation, see `reserve`, says so itself.

    Raises:
        ErclutchError: it cannot be written; or its name was taken meanwhile, and the file is kept under another name.
    """
    with ExitStack() as clearing:
        reservation = clearing.enter_context(_mine(target, unwritable, may_replace))
        partial = _partial(target, target.suffix)
        clearing.callback(partial.unlink, missing_ok=True)
        # Less what the umask takes.
        os.close(os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield partial
        move = functools.partial(_put, partial, target, reservation.may_replace, unwritable)
        if not move_later(move, clearing):
            with unheard():  # an old file that it takes the place of stands here then, and goes
                move()
                clearing.close()


@contextmanager
def whole_folder(
    target: Path, unwritable: Callable[[Path, OSError], ErclutchError]
) -> Generator[Path]:
    """A folder to fill that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Args:
        target: its name. An old folder of that name is replaced where a reservation, see `reserve`, allows it.
        unwritable: the error to raise when it cannot be written.

    Raises:
        ErclutchError: it cannot be written; or its name was taken meanwhile, and the folder is kept under another name.
    """
    with _mine(target, unwritable, nothing) as reservation:
        partial = _partial(target)
        try:
            partial.mkdir()
            yield partial
            with unheard():  # an old folder that it takes the place of stands here then, and goes
                _put(partial, target, reservation.may_replace, unwritable)
                shutil.rmtree(partial, ignore_errors=True)
        finally:
            shutil.rmtree(partial, ignore_errors=True)


def _partial(target: Path, suffix: str = "") -> Path:
    """A name beside a target, for what is not whole yet; nobody else has it."""
    return target.with_name(f".{target.name}.partial-{secrets.token_hex(4)}{suffix}")


def _put(
    partial: Path,
    target: Path,
    may_replace: Callable[[Path], bool],
    unwritable: Callable[[Path, OSError], ErclutchError],
) -> None:
    while True:
        try:
            put_new(partial, target)
            return
        except FileExistsError as error:
            if not may_replace(target):
                kept = put_beside(partial, target)
                kind = type(unwritable(target, error))
                problem = "another program made it meanwhile, and it may not be replaced"
                raise kind(
                    problem, where=str(target), remedy=f"Take what was made here from {kept}"
                ) from error
        with suppress(FileNotFoundError):  # what stood there went away: the name is free after all
            if replaced(partial, target, may_replace):
                return


_PATIENCE = 60.0  # [s] for a name that nobody reserved for long: a report, a file of a cache


@contextmanager
def _mine(
    target: Path,
    unwritable: Callable[[Path, OSError], ErclutchError],
    may_replace: Callable[[Path], bool],
) -> Generator[Reservation]:
    """The reservation of a name, for the time of writing where it was not reserved before; then it is given free."""
    try:
        if held(target) is None:
            kind = type(unwritable(target, OSError()))
            reserve(target, may_replace, kind, patience=_PATIENCE)
        reservation = held(target)
        assert reservation is not None
        yield reservation
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        release(target)
