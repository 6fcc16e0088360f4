"""Points of a sweep, each kept as soon as it is done, so that a sweep that was interrupted goes on where it was."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from erclutch.errors import RunError


class Points:
    """A file of results by key, one JSON line each.

    Args:
        path: the file; None keeps nothing.
        settings: what the results depend on; results of other settings are not used.

    Raises:
        RunError: the file cannot be read.
    """

    def __init__(self, path: Path | None, settings: Mapping[str, Any]) -> None:
        self.path = path
        self._digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:16]
        self._known: dict[str, Any] = {}
        if path is None or not path.exists():
            return
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(f"cannot be read: {error}", where=str(path), remedy="Delete it") from error
        whole = text[: text.rfind("\n") + 1]
        if whole != text:  # a last line that a power cut tore
            path.write_text(whole, encoding="utf-8")
        for line in whole.splitlines():
            self._take(line)

    def _take(self, line: str) -> None:
        try:
            body: Any = json.loads(line)
            if body["settings"] == self._digest:
                self._known[str(body["key"])] = body["value"]
        except (ValueError, KeyError, TypeError) as error:
            raise RunError(
                "this is no file of a sweep's points", where=str(self.path), remedy="Delete it, or give another --out"
            ) from error

    def get(self, key: str, make: Callable[[], Any]) -> Any:
        """The result for a key: the kept one, or a new one that is kept before it is returned.

        Raises:
            RunError: the file cannot be written.
        """
        if key not in self._known:
            value = make()
            if self.path is not None:
                try:
                    with self.path.open("a", encoding="utf-8") as file:
                        file.write(json.dumps({"settings": self._digest, "key": key, "value": value}) + "\n")
                except OSError as error:
                    raise RunError(
                        f"cannot be written: {error.strerror}", where=str(self.path), remedy="Give another --out"
                    ) from error
            self._known[key] = value
        return self._known[key]
