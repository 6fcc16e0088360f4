"""Points of a sweep or a search, each kept once it is done, so that what was interrupted goes on where it was."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from erclutch.errors import RunError
from erclutch.files.given_files import small_text
from erclutch.runs.cluster import TaskPool, finished, saying_kept
from erclutch.signals.array import Array

T = TypeVar("T")


class Points:
    """A file of results by key, one JSON line each. A last line that a power cut tore is taken out of it.

    Args:
        path: the file; None keeps nothing.
        settings: what the results depend on; results of other settings are not used.
        kind: what the file is called in an error.

    Attributes:
        others: how many results of the file are of other settings.

    Raises:
        RunError: the file cannot be read.
    """

    def __init__(
        self,
        path: Path | None,
        settings: Mapping[str, Any],
        kind: str = "file of a sweep's points",
    ) -> None:
        self.path = path
        self.others = 0
        self._kind = kind
        of_settings = json.dumps(settings, sort_keys=True).encode()
        self._digest = hashlib.sha256(of_settings).hexdigest()[:16]
        self._known: dict[str, Any] = {}
        if path is None or not path.exists():
            return
        try:
            text = small_text(path)
            whole = text[: text.rfind("\n") + 1]
            if whole != text:  # cut and not written anew: a full disk would take all points
                os.truncate(path, len(whole.encode()))
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(
                f"cannot be read: {error}", where=str(path), remedy="Delete it"
            ) from error
        for line in whole.splitlines():
            self._take(line)

    def _take(self, line: str) -> None:
        try:
            body: Any = json.loads(line)
            kept = body["settings"], str(body["key"]), body["value"]
            told = body.get("digest")  # lines of older versions have none
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            remedy = "Delete it, or give another --out"
            raise RunError(
                f"this is no {self._kind}", where=str(self.path), remedy=remedy
            ) from error
        settings, key, value = kept
        if settings != self._digest or told is None:
            self.others += 1
        elif told != _digest_of_line(*kept):
            raise RunError(
                f"what it keeps of {key!r:.60} was changed",
                where=str(self.path),
                remedy="Delete it, or give another --out",
            )
        else:
            self._known[key] = value

    def get(self, key: str, make: Callable[[], Any]) -> Any:
        """The result for a key: the kept one, or a new one that is kept before it is returned.

        Raises:
            RunError: the file cannot be written.
        """
        if key not in self._known:
            self._keep(key, make())
        return self._known[key]

    def fill(
        self,
        pool: TaskPool,
        function: Callable[[T], Any],
        tasks: Mapping[str, T],
        report: Callable[[int, str], None],
    ) -> list[Any]:
        """The result of each task, by its key: the kept one, or a new one that is kept as soon as it is there.

        Args:
            pool: where tasks run.
            function: stands at the top of a module; gives JSON values.
            tasks: by key.
            report: called with how many are done, and the last of them.

        Raises:
            RunError: the file cannot be written; what a task raises.
        """
        kept = [key for key in tasks if key in self._known]
        new = [key for key in tasks if key not in self._known]
        with saying_kept(kept, len(tasks), "points are kept"):
            for index, result in finished(pool, function, [tasks[key] for key in new]):
                if isinstance(result, Exception):
                    raise result
                self._keep(new[index], result)
                kept.append(new[index])
                report(len(kept), new[index])
        return [self._known[key] for key in tasks]

    def _keep(self, key: str, value: Any) -> None:
        if self.path is not None:
            try:
                with self.path.open("a", encoding="utf-8") as file:
                    line: dict[str, Any] = {"settings": self._digest, "key": key, "value": value}
                    line["digest"] = _digest_of_line(*line.values())
                    file.write(json.dumps(line) + "\n")
            except OSError as error:
                problem = f"cannot be written: {error.strerror}"
                raise RunError(
                    problem, where=str(self.path), remedy="Give another --out"
                ) from error
        self._known[key] = value


def _digest_of_line(settings: Any, key: str, value: Any) -> str:
    """What tells that a result is the one that was kept."""
    # As it comes back from the file: the keys of an object are texts there.
    as_read = json.loads(json.dumps([settings, key, value]))
    text = json.dumps(as_read, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def digest_of_rows(signals: Iterable[Array]) -> str:
    """What tells rows from other rows, to the last bit: results of the one are none of the other.

    Args:
        signals: each of any shape.
    """
    digest = hashlib.sha256()
    for signal in signals:
        digest.update(str(signal.shape).encode())
        digest.update(np.ascontiguousarray(signal, "<f8").tobytes())
    return digest.hexdigest()[:16]


def make_folder(folder: Path) -> None:
    """Make the folder of what comes out, if it is not there.

    Raises:
        RunError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = f"cannot be made: {error.strerror}"
        raise RunError(problem, where=str(folder), remedy="Give another --out") from error
