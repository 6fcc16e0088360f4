"""Files and folders are there whole or not at all; this module writes them, and knows the user's cache."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
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
    """Say before any work whether a folder may be made, or replaced.

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
    if not folder.exists():
        return
    if not (folder / marker).is_file():
        raise kind(f"exists and is not {what}", where=str(folder), remedy="Give --out another name")
    if not force:
        raise kind(f"there is {what} already", where=str(folder), remedy="Give --out another name, or --force")


def may_write_file(path: Path | None, force: bool, option: str = "out") -> None:
    """Say before any work whether a file may be made, or replaced; None is no file.

    Raises:
        RunError: there is a file of this name, and it may not be replaced; ``option`` gave the name.
    """
    if path is not None and path.exists() and not force:
        raise RunError("there is a file already", where=str(path), remedy=f"Give --{option} another name, or --force")


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def whole_file(target: Path, unwritable: Callable[[Path, OSError], ErclutchError] = unwritable) -> Generator[Path]:
    """A file to write that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Args:
        target: its name; an old file of that name is replaced.
        unwritable: the error to raise when it cannot be written.
    """
    partial: Path | None = None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.partial-", suffix=target.suffix, dir=target.parent)
        os.close(handle)
        partial = Path(name)
        yield partial
        partial.chmod(0o644)
        os.replace(partial, target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)


@contextmanager
def whole_folder(target: Path, unwritable: Callable[[Path, OSError], ErclutchError]) -> Generator[Path, None, None]:
    """A folder to fill that gets its name once it is whole; whatever goes wrong before leaves nothing.

    Args:
        target: its name; an old folder of that name is deleted once the new one is there.
        unwritable: the error to raise when it cannot be written.
    """
    try:
        partial = Path(tempfile.mkdtemp(prefix=f".{target.name}.partial-", dir=target.parent))
    except OSError as error:
        raise unwritable(target, error) from error
    try:
        partial.chmod(0o755)
        yield partial
        _put(partial, target)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _put(partial: Path, target: Path) -> None:
    if not target.exists():
        os.replace(partial, target)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{target.name}.old-", dir=target.parent)) / target.name
    shutil.move(target, old)
    try:
        os.replace(partial, target)
    except BaseException:
        shutil.move(old, target)
        raise
    finally:
        shutil.rmtree(old.parent, ignore_errors=True)
