"""A folder that is there whole or not at all: filled beside its name, moved there at the end."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

from erclutch.errors import ErclutchError


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
