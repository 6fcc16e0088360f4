"""``score --run RUN LOG``: an option that takes several runs takes the log behind them too, which is no run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.cli.lone_run import RUN

if TYPE_CHECKING:
    from cyclopts import CycloptsError


def words_with_logs_first(words: Sequence[str], error: CycloptsError) -> list[str] | None:
    """The words of a command that lacks its log, with the logs behind ``--run`` in front; None where none is there.

    Args:
        words: of the command line.
        error: what the parser says of them.
    """
    from cyclopts import MissingArgumentError

    lacks_a_log = (
        isinstance(error, MissingArgumentError)
        and error.argument is not None
        and error.argument.name == "LOG"
    )
    if not lacks_a_log or words.count("--run") != 1:
        return None
    behind = words.index("--run") + 1
    end = next((n for n in range(behind, len(words)) if words[n].startswith("-")), len(words))
    taken = words[behind:end]
    runs = [word for word in taken if (Path(word) / RUN).is_file()]
    logs = [word for word in taken if word not in runs]
    if not runs or not logs or not all(Path(log).exists() for log in logs):
        return None
    return [words[0], *logs, *words[1:behind], *runs, *words[end:]]
