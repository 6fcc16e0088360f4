"""What a command writes last, by two processes at once, a hundred times in a second: its own result, its own rule of
what may be replaced, and the code that puts it in place. The work before is done once.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from erclutch import files
from erclutch.errors import ErclutchError
from erclutch.files import whole_file, whole_folder
from erclutch.files.places import nothing, release, reserve
from tests.support.command import run
from tests.support.races import left_in, words_of

_FORK = multiprocessing.get_context("fork")
_TOLD = ("is writing it", "made it meanwhile")
_Error = Callable[[Path, OSError], ErclutchError]


class Written(NamedTuple):
    """A file or folder that a command put in place: a copy of it, its name, and what the command said of it."""

    copy: Path
    name: str
    may_replace: Callable[[Path], bool]
    unwritable: _Error


def written_by(command: str, folder: Path, copies: Path) -> list[Written]:
    """Run a command once, in this process, and keep what it puts in place."""
    found, put = list[Written](), files._put

    def kept(
        partial: Path, target: Path, may_replace: Callable[[Path], bool], unwritable: _Error
    ) -> None:
        copy = copies / f"{command}-{len(found)}"
        (shutil.copytree if partial.is_dir() else shutil.copy)(partial, copy)
        found.append(Written(copy, target.name, may_replace, unwritable))
        put(partial, target, may_replace, unwritable)

    files._put = kept  # pyright: ignore[reportPrivateUsage]
    try:
        done = run(*words_of(command, -2), cwd=folder)  # pairs begin with -1
    finally:
        files._put = put  # pyright: ignore[reportPrivateUsage]
    assert done.code == 0, done.error
    return found


def lost_in(written: Written, pairs: int, folder: Path) -> list[str]:
    """What went wrong where two processes put a result in each of so many places at one moment."""
    folder.mkdir()
    begin = _FORK.Barrier(2)
    both = [
        _FORK.Process(target=_writer, args=(written, pairs, folder, begin, who)) for who in "ab"
    ]
    for process in both:
        process.start()
    for process in both:
        process.join()
    if any(process.exitcode for process in both):
        return ["a writer ended with an error"]
    said: dict[str, list[str]] = {
        who: json.loads((folder / f"said-{who}").read_bytes()) for who in "ab"
    }
    lost = [
        _lost(written, folder, pair, {who: said[who][pair] for who in "ab"})
        for pair in range(pairs)
    ]
    return [each for each in lost if each] + [f"left {name}" for name in left_in(folder)]


def _place(written: Written, folder: Path, pair: int) -> Path:
    return folder / f"{pair}-{written.name}"


def _writer(written: Written, pairs: int, folder: Path, begin: Any, who: str) -> None:
    """One of two processes: it writes its letter at the end of each file, so that a mixture would show."""
    said = list[str]()
    for pair in range(pairs):
        place, is_folder = _place(written, folder, pair), written.copy.is_dir()
        begin.wait()
        try:
            kind = type(written.unwritable(place, OSError()))
            reserve(place, written.may_replace, kind)
            with (whole_folder if is_folder else whole_file)(place, written.unwritable) as partial:
                shutil.copytree(
                    written.copy, partial, dirs_exist_ok=True
                ) if is_folder else shutil.copy(written.copy, partial)
                for file in _files(partial):
                    with file.open("ab") as end:
                        end.write(who.encode())
            said.append("")
        except ErclutchError as error:
            release(place)
            said.append(f"{error.problem}. {error.remedy}")
    (folder / f"said-{who}").write_text(json.dumps(said), encoding="utf-8")
    os._exit(0)


def _files(place: Path) -> Sequence[Path]:
    return (
        [path for path in sorted(place.rglob("*")) if path.is_file()] if place.is_dir() else [place]
    )


def _lost(written: Written, folder: Path, pair: int, said: dict[str, str]) -> str:
    """What is wrong with a place that two processes have written to; "" where nothing is."""
    place = _place(written, folder, pair)
    writers = [who for who, text in said.items() if not text]
    if any(text and not any(words in text for words in _TOLD) for text in said.values()):
        return f"said: {said}"
    if len(writers) != 1 and (written.may_replace is nothing or not writers):
        return f"{len(writers)} of two say that they have written"
    whole = {
        str(file.relative_to(written.copy)): file.stat().st_size + 1
        for file in _files(written.copy)
    }
    found = {str(file.relative_to(place)): file.stat().st_size for file in _files(place)}
    if found != whole:
        return f"not whole: {found}"
    by = {file.read_bytes()[-1:].decode() for file in _files(place)}
    return (
        ""
        if len(by) == 1 and by <= set(writers)
        else f"by {by}, and {writers} say that they have written"
    )
