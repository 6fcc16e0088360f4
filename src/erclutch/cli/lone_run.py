"""A run that a command needs and nobody named is the only one near: in this folder, or beside the log.

One rule for all commands: the only run of the working folder is taken; where that has none, the only run of the folder
in which the logs lie. What is taken is said in a line. Of several runs none is taken, and the error names them. An
export that `verify` needs is found alike. A live loop takes no model that nobody named: it drives a device.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclopts import CycloptsError

RUN = "run.json"
_EXPORT = "export.json"
#: The file that marks a folder, by the command's name of what it needs.
_MARKS = {"--run": RUN, "RUN": RUN, "MODEL": RUN, "EXPORT": _EXPORT}
_KINDS = {RUN: "run", _EXPORT: "export"}
_NAMED = 5  # of several, in an error
_OF_SEVERAL = ("compare",)


def words_with_lone_run(words: Sequence[str], error: CycloptsError) -> list[str] | None:
    """The words of a command with the run that they lack; None where something else is wrong with them.

    Args:
        words: of the command line.
        error: what the parser says of them.
    """
    mark = _lacks(words, error)
    near = folders_near(words[1:], mark) if mark else []
    if len(near) != 1:
        return None
    folder = _as_word(near[0])
    _say(folder, mark)
    if _name_of(error) == "--run":
        return [*words, "--run", folder]
    return [words[0], folder, *words[1:]]


def several_near(words: Sequence[str], error: CycloptsError) -> str:
    """A sentence with the runs that may be meant, where there are several; "" otherwise."""
    mark = _lacks(words, error)
    near = folders_near(words[1:], mark) if mark else []
    if len(near) < 2:
        return ""
    named = ", ".join(shlex.quote(_as_word(folder)) for folder in near[:_NAMED])
    more = f" and {len(near) - _NAMED} more" if len(near) > _NAMED else ""
    return f" There are {len(near)} {_KINDS[mark]}s: {named}{more}."


def lone_run() -> Path | None:
    """The only run of the working folder, which is said in a line; None where there is none, or several."""
    near = folders_near((), RUN)
    if len(near) != 1:
        return None
    _say(_as_word(near[0]), RUN)
    return near[0]


def folders_near(words: Iterable[str], mark: str) -> list[Path]:
    """Folders that hold a file: the working folder, else those in it, else those beside the files that words name."""
    here = Path()
    if (here / mark).is_file():
        return [here]
    beside: dict[Path, None] = {}
    for word in words:
        path = Path(word)
        if word.startswith("-") or not path.exists():
            continue
        if path.is_dir():
            beside[path] = None
        beside[path.parent] = None
    for folders in ([here], list(beside)):
        places = {place.parent for folder in folders for place in folder.glob(f"*/{mark}")}
        if places:
            return sorted(places)
    return []


def _lacks(words: Sequence[str], error: CycloptsError) -> str:
    """The file that marks what is missing: a run, an export; "" where neither is."""
    from cyclopts import MissingArgumentError

    if not words or words[0] in _OF_SEVERAL or not isinstance(error, MissingArgumentError):
        return ""
    if any(word in ("--run", "--run=") or (Path(word) / RUN).is_file() for word in words[1:]):
        return ""  # a run was given, in another place
    name = _name_of(error)
    if (
        name == "LOG"
        and words[0] == "recalibrate"
        and any(not w.startswith("-") for w in words[1:])
    ):
        return RUN  # the log stands where the run is looked for
    return _MARKS.get(name, "")


def _name_of(error: CycloptsError) -> str:
    return error.argument.name if error.argument is not None else ""


def _as_word(folder: Path) -> str:
    """A folder as a word that is no option."""
    text = str(folder)
    return f"./{text}" if text.startswith("-") else text


def _say(folder: str, mark: str) -> None:
    from erclutch.cli import terminal

    kind = _KINDS[mark]
    note = f"{kind}: {folder}, the only {kind} here"
    # What is asked for as JSON stays JSON.
    terminal.console(stderr=True).print(note, style="dim", markup=False, soft_wrap=True)
