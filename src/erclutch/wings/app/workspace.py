"""The workspace is a folder: logs and runs lie in it as a user or a command put them there."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
import os
import re
import secrets
import threading
import time
from collections.abc import AsyncIterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from dataclasses import fields as dataclass_fields
from pathlib import Path
from typing import Any, cast

from erclutch.errors import ErclutchError, printable
from erclutch.files import whole_file
from erclutch.files.given_files import plain_words, small_json
from erclutch.files.places import put_beside, put_new
from erclutch.runs.run_about import RunAbout, about_with

#: What the page calls the estimate of a log.
ESTIMATE = re.compile(r"-estimate(-\d+)?\.csv$")
#: Of an upload, bytes; as large as the largest log that `erclutch.read` takes.
LARGEST = 4 << 30
_LONGEST_NAME = 120  # bytes
_ABOUT = ".erclutch-about.json"  # what was said of the logs
_MOST_INSIDE = 20_000  # files of a folder
#: The newest entries of a kind that are shown, and looked into: each run that is costs a millisecond.
SHOWN = 200
#: A look that took so long, in s, stands for the next ones: for so many times what it took, while no name came or went.
_LONG, _STANDS = 0.2, 4.0
_COMMANDS = b"# COMMANDS:"
_WRITTEN = (".html", ".pdf", ".png", ".svg", ".json", ".zip")


class WorkspaceError(ErclutchError):
    """A name or file that the workspace does not take or does not have."""


class NotThereError(WorkspaceError):
    """A file, folder, run or page that the workspace does not have."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A file or folder of the workspace: its name, bytes, and time of its last change in s since 1970."""

    name: str
    size: int
    changed: float


@dataclass(frozen=True)
class Look:
    """What is in a workspace: logs, runs, and what commands wrote: exports, estimates, comparisons, mappings.

    Attributes:
        unnamed: the entries whose names no address of a page can hold, see `plain_name`; they are not shown.
    """

    logs: list[Entry]
    runs: list[Entry]
    results: list[Entry]
    unnamed: list[str]


class Workspace:
    """A folder with logs and runs.

    Args:
        folder: where.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self._looks = threading.Lock()
        self._last: tuple[Look, int, float] | None = None  # a look, of which folder, until when

    def look(self) -> Look:
        """What is in the folder, each kind with the newest first.

        Of 10^6 runs the folder is read once. Who asks meanwhile, or soon after, gets the same answer: else a few pages
        of such a folder take all processors. A name that comes or goes is always seen.
        """
        with self._looks:
            of_folder = self._changed()
            if self._last and self._last[1] == of_folder and time.monotonic() < self._last[2]:
                return self._last[0]
            began = time.monotonic()
            look = self._looked()
            took = time.monotonic() - began
            stands = time.monotonic() + _STANDS * took
            self._last = (look, of_folder, stands) if took > _LONG else None
            return look

    def _changed(self) -> int:
        """When a name last came into the folder or went, in ns since 1970; 0 where that cannot be asked."""
        with contextlib.suppress(OSError):
            return self.folder.stat().st_mtime_ns
        return 0

    def _looked(self) -> Look:
        """What is in the folder now."""
        from erclutch.logs.log_reader import folder_reader, log_suffixes

        suffixes = tuple(suffix for suffix in log_suffixes() if suffix not in _WRITTEN)

        def kind_of(entry: os.DirEntry[str]) -> list[Entry] | None:
            name = entry.name
            if entry.is_dir() and os.path.isfile(os.path.join(entry.path, "run.json")):
                return look.runs
            estimate = ESTIMATE.search(name) is not None
            if entry.is_dir():
                if folder_reader(Path(entry.path)) is not None:
                    return look.logs
                if os.path.isfile(os.path.join(entry.path, "export.json")):
                    return look.results
            elif not estimate and entry.is_file() and name.lower().endswith(suffixes):
                return look.logs
            return look.results if estimate or Path(name).suffix in (*_WRITTEN, ".toml") else None

        look = Look([], [], [], [])
        for entry in self._visible(look.unnamed):
            with contextlib.suppress(OSError):  # gone since the folder was listed
                kind = kind_of(entry)
                if kind is not None:
                    state = entry.stat()
                    kind.append(Entry(entry.name, state.st_size, state.st_mtime))
        for kind in (look.logs, look.runs, look.results):
            kind.sort(key=lambda entry: (-entry.changed, entry.name))
        commands = [entry for entry in look.logs[:SHOWN] if self._holds_commands(entry.name)]
        for entry in commands:  # of erclutch excite: nothing was measured
            look.logs.remove(entry)
            look.results.append(entry)
        look.results.sort(key=lambda entry: (-entry.changed, entry.name))
        return look

    def _holds_commands(self, name: str) -> bool:
        """Whether a text says in its first bytes that it is a sequence to log, and no log."""
        if not name.lower().endswith(".csv"):
            return False
        with contextlib.suppress(OSError), (self.folder / name).open("rb") as file:
            return file.read(len(_COMMANDS)) == _COMMANDS
        return False

    def logs(self) -> list[Entry]:
        """Logs, the newest first: files of a suffix that a reader knows, and folders that are one log."""
        return self.look().logs

    def runs(self) -> list[Entry]:
        """Runs, the newest first."""
        return self.look().runs

    def results(self) -> list[Entry]:
        """What commands wrote besides: exports, estimates, comparisons, mapping files."""
        return self.look().results

    def _visible(self, unnamed: list[str] | None = None) -> Iterator[os.DirEntry[str]]:
        """What may be shown; names that are none for a page are added to ``unnamed``."""
        with contextlib.suppress(OSError), os.scandir(self.folder) as entries:
            for entry in entries:
                # Only a link leads elsewhere: to follow each of 10^5 runs takes seconds.
                linked_away = entry.is_symlink() and not self._holds(Path(entry.path))
                if entry.name.startswith((".", "-")) or linked_away:
                    continue
                if is_plain_name(entry.name):
                    yield entry
                elif unnamed is not None:
                    unnamed.append(printable(entry.name))

    def _holds(self, path: Path) -> bool:
        """Whether a path, its links followed, is in the workspace."""
        return Path(os.path.realpath(path)).is_relative_to(self.folder)

    def path(self, name: str) -> Path:
        """A file or folder that is in the workspace.

        Raises:
            WorkspaceError: no such name, or a folder that holds a link: it could lead to any file of this machine.
        """
        path = self.folder / plain_name(name)
        try:
            there = path.exists() and self._holds(path)
            link = _link_in(path) if there else None
        except OSError:
            there, link = False, None
        if link is not None:
            problem = f"the folder holds {link}, and links in a folder are not followed"
            raise NotThereError(
                problem, where=name, remedy="Put the file itself in the place of the link"
            )
        if there:
            return path
        raise NotThereError(
            "the workspace has no such file or folder", where=name, remedy="Go back to the overview"
        )

    def run(self, name: str) -> Path:
        """The folder of a run that is in the workspace.

        Raises:
            WorkspaceError: no such name, or no run.
        """
        path = self.path(name)
        if not (path / "run.json").is_file():
            raise NotThereError(
                "this is no run: it holds no run.json", where=name, remedy="Go back to the overview"
            )
        return path

    def free(self, name: str) -> str:
        """A name that nothing has: this one, or with a number."""
        stem, suffix = os.path.splitext(plain_name(name))
        free = name
        number = 1
        while (self.folder / free).exists():
            number += 1
            free = f"{stem}-{number}{suffix}"
        return free

    async def take(self, name: str, content: AsyncIterable[bytes]) -> tuple[str, bool]:
        """Write a log that somebody uploads, whole or not at all; a log of the same name and bytes stands for it.

        Returns:
            The log's name, and whether it was there before.

        Raises:
            WorkspaceError: no such name is taken, the file is larger than 4 GiB, empty, or cannot be written.
        """
        from erclutch.files.given_files import file_digest

        stem, suffix = os.path.splitext(plain_name(name))
        numbered = re.compile(re.escape(stem) + r"-\d+" + re.escape(suffix))
        logs = await asyncio.to_thread(self.logs)
        namesakes = [
            entry for entry in logs if entry.name == name or numbered.fullmatch(entry.name)
        ]

        name = self.free(name)
        partial = self.folder / f".{secrets.token_hex(8)}.part"
        digest = hashlib.sha256()
        size = 0  # bytes
        try:
            with partial.open("xb") as file:
                async for piece in content:
                    size += len(piece)
                    if size > LARGEST:
                        remedy = "Copy it into the folder, and use erclutch fit there"
                        raise WorkspaceError(
                            f"the file is larger than {LARGEST >> 30} GiB",
                            where=name,
                            remedy=remedy,
                        )
                    file.write(piece)
                    digest.update(piece)
            if not size:
                raise WorkspaceError("the file is empty", where=name, remedy="Give a log with rows")
            for entry in namesakes:
                if entry.size != size:
                    continue
                its_digest = await asyncio.to_thread(file_digest, self.folder / entry.name)
                if its_digest == digest.hexdigest():
                    return entry.name, True
            return put_beside(partial, self.folder / name).name, False
        except OSError as error:
            problem = f"the file cannot be written ({error.strerror or error})"
            remedy = "Make room, or give erclutch app another folder"
            raise WorkspaceError(problem, where=name, remedy=remedy) from error
        finally:
            partial.unlink(missing_ok=True)

    def mappings(self) -> list[str]:
        """Names of the mapping files."""
        ending_so = [entry for entry in self._visible() if entry.name.endswith(".toml")]
        return sorted(entry.name for entry in ending_so if entry.is_file())

    def about(self, log: str) -> RunAbout:
        """What was said of a log; nothing where the file was changed into what nobody can have said."""
        known = [each.name for each in dataclass_fields(RunAbout)]
        with contextlib.suppress(OSError, ValueError, ErclutchError):
            said = self._abouts().get(log)
            if isinstance(said, dict):
                texts = cast("dict[str, Any]", said)
                return about_with(
                    RunAbout(), **{key: str(texts[key]) for key in known if key in texts}
                )
        return RunAbout()

    def keep_about(self, log: str, about: RunAbout) -> None:
        """Keep what is said of a log.

        Raises:
            WorkspaceError: the folder cannot be written; or the file with what was said of other logs was damaged, and
                would be lost.
        """
        said = {name: text for name, text in asdict(about).items() if text}
        try:
            every = {**self._abouts(), log: said}
        except (OSError, ValueError) as error:
            problem = f"{_ABOUT}, which holds what was said of all logs, cannot be understood: {plain_words(error)}"
            raise WorkspaceError(
                problem, where=log, remedy="Mend this file, or remove it and say it again"
            ) from error
        try:
            with whole_file(self.folder / _ABOUT) as partial:
                partial.write_text(
                    json.dumps(every, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
                )
        except OSError as error:
            problem = f"what is said of the log cannot be kept ({error.strerror or error})"
            raise WorkspaceError(
                problem, where=log, remedy="Check the folder's permissions"
            ) from error

    def _abouts(self) -> dict[str, Any]:
        """What was said of each log, as its file has it.

        Raises:
            OSError, ValueError: the file cannot be read, or is no object of JSON.
        """
        try:
            body: Any = small_json(self.folder / _ABOUT)
        except FileNotFoundError:
            return {}
        if not isinstance(body, dict):
            raise ValueError("it is no object of JSON")
        return cast("dict[str, Any]", body)

    def state(self, name: str) -> tuple[object, ...]:
        """Changes when a log changes, or what says how it is read."""
        entries: list[Entry] = []
        for each in (name, *self.mappings()):
            with contextlib.suppress(OSError):  # gone since the folder was listed
                state = (self.folder / each).stat()
                entries.append(Entry(each, state.st_size, state.st_mtime))
        return tuple(entries)

    def body(self, name: str) -> Mapping[str, Any] | None:
        """What run.json says of a run; None where it cannot be read."""
        from erclutch.runs.run_folder import read_run

        with contextlib.suppress(ErclutchError):
            return read_run(self.path(name)).body
        return None

    def rename(self, old: str, new: str) -> None:
        """Give a run another name.

        Raises:
            WorkspaceError: no such run, or the name is taken.
        """
        path = self.path(old)
        target = self.folder / plain_name(new)
        try:
            put_new(path, target)
        except FileExistsError as error:
            raise WorkspaceError(
                "there is such a name already", where=new, remedy="Choose another name"
            ) from error
        except OSError as error:
            problem = f"the run cannot be renamed ({error.strerror or error})"
            raise WorkspaceError(
                problem, where=old, remedy="Check the folder's permissions"
            ) from error


def plain_name(name: str) -> str:
    """A name of one file or folder of the workspace, once it has been checked.

    Raises:
        WorkspaceError: a path, a hidden name, a name like an option, control characters, or too many characters.
    """
    has_bad_sign = not name.isprintable() or bool(set('/\\:*?"<>|') & set(name))
    has_bad_end = name.startswith((".", "-", " ")) or name.endswith((".", " "))
    if not name or has_bad_sign or has_bad_end:
        problem = f"{name!r} cannot be the name of a file here"
        raise WorkspaceError(
            problem, remedy='Use letters, digits, "-", "_", "." and spaces; no "-" or "." in front'
        )
    if len(name.encode()) > _LONGEST_NAME:
        raise WorkspaceError(
            f"the name has more than {_LONGEST_NAME} bytes", where=name[:40], remedy="Shorten it"
        )
    return name


def is_plain_name(name: str) -> bool:
    """Whether `plain_name` takes a name."""
    try:
        plain_name(name)
    except WorkspaceError:
        return False
    return True


def _link_in(folder: Path) -> str | None:
    """The first link below a folder, or what stands for it where there is too much to look at."""
    looked = 0
    for place, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = Path(place) / name
            looked += 1
            if path.is_symlink():
                return f"the link {path.relative_to(folder).as_posix()[:80]}"
            if looked > _MOST_INSIDE:
                return f"more than {_MOST_INSIDE} files"
    return None


def shown_folder(folder: Path) -> str:
    """A folder's path for people: ``~`` stands for their home."""
    try:
        below = folder.relative_to(Path.home())
    except (ValueError, RuntimeError):
        return str(folder)
    return os.path.join("~", *below.parts)


def said_size(size: int) -> str:
    """Bytes for people."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.1f} kB"


def zipped(folder: Path) -> bytes:
    """A folder as a zip archive in memory; links and what lies outside are left out."""
    import io
    import zipfile

    packed = io.BytesIO()
    with zipfile.ZipFile(
        packed,
        "w",
        zipfile.ZIP_DEFLATED,
        strict_timestamps=False,  # of a clock in 1970, or in 2150
    ) as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file() and not path.is_symlink():
                archive.write(path, path.relative_to(folder.parent).as_posix())
    return packed.getvalue()
