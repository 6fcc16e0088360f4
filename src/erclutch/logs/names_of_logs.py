"""What logs are called: by their files, and by their folders too where files of several folders have one name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from erclutch.signals.recording import Recording


def names_apart(paths: Sequence[Path]) -> list[str]:
    """The name of each file, with as many folders in front as tell it from another file of that name.

    Returns:
        ``run1.csv`` where no other log is called so, else such as ``0.5A/run1.csv``.
    """
    ways = [path.absolute().parts for path in paths]
    parts = dict.fromkeys(ways, 1)  # of each file's way, counted from its end

    def name(way: tuple[str, ...]) -> str:
        return "/".join(way[-parts[way] :])

    while len(shared := Counter(map(name, parts))) < len(parts):
        for way in [way for way in parts if shared[name(way)] > 1]:
            parts[way] += 1
    return [name(way) for way in ways]


def called(log: Recording, path: Path, name: str) -> Recording:
    """A recording of a file under the name that tells the file from others."""
    if not log.name.startswith(path.name):
        return log
    return replace(log, name=name + log.name.removeprefix(path.name))
