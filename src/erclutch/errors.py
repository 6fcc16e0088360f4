"""All exceptions form one tree. Each message names the value, the limit and the remedy.

The command line prints ``str(error)`` and exits with ``error.exit_code``; nothing here is ever a bug report.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Generator
from contextlib import contextmanager


class ErclutchError(Exception):
    """Base of every error that a user can cause and mend.

    Args:
        problem: what is wrong, with the value and the limit that it missed.
        remedy: what to do about it, as an imperative sentence.
        where: the file (and row or column) or the option at fault.
    """

    exit_code = 2

    def __init__(self, problem: str, *, remedy: str, where: str = "") -> None:
        self.problem = problem
        self.remedy = remedy
        self.where = where
        super().__init__(problem)

    def __reduce__(self) -> tuple[object, ...]:
        # Errors come back from other processes.
        return _again, (type(self), self.problem, self.remedy, self.where)

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        return printable(f"{place}{self.problem}. {self.remedy}.")


def _again(kind: type[ErclutchError], problem: str, remedy: str, where: str) -> ErclutchError:
    return kind(problem, remedy=remedy, where=where)


def printable(text: str) -> str:
    """A text as one line that a terminal only shows: white space is a blank, any other hidden character is written out.

    What is hidden: control characters, line ends, marks that turn the direction, halves of a character.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else " " if c.isspace() else ascii(c)[1:-1] for c in text)


@contextmanager
def placed(where: str) -> Generator[None]:
    """Errors that name no file get this one."""
    try:
        yield
    except ErclutchError as error:
        error.where = error.where or where
        raise


def shell_word(text: str) -> str:
    """A text as a word of a command that a message offers for copying; a shell must not see more in it."""
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


class LogError(ErclutchError):
    """A log file cannot be read as a table of numbers."""


class MappingError(ErclutchError):
    """The columns of a log cannot be matched to the signals that a device needs."""


class UnitError(MappingError):
    """A unit is unknown or does not fit the signal that it is given for."""


class TimingError(LogError):
    """Time stamps that cannot be put right: running backwards, none at all, a single row."""


class ShortLogError(TimingError):
    """Fewer rows than a clock can be told from."""


class CheckError(ErclutchError):
    """The data cannot support the fit that was asked for."""


class SettingError(ErclutchError):
    """A command-line option or an API argument is outside what it may be."""


def require(low: float, high: float = math.inf, unit: str = "", **options: float) -> None:
    """Refuse options outside a range, with a message of the first of them alone.

    Args:
        low: smallest value.
        high: largest value.
        unit: of the values, with a space before it.
        options: values by their options' names, with _ for -.

    Raises:
        SettingError: a value is outside, or no number.
    """
    for name, value in options.items():
        if not low <= value <= high:
            allowed = f"{low:g}{unit} or more" if high == math.inf else f"{low:g} to {high:g}{unit}"
            raise SettingError(f"--{name.replace('_', '-')} {value:g}", remedy=f"Give {allowed}")


class PluginError(SettingError):
    """A plug-in that is needed is not installed, or it fails."""


def of_missing_wing(error: ModuleNotFoundError, what: str) -> PluginError | None:
    """The error to raise where a module is in a wing whose folder is not there, else None.

    Args:
        error: that names the module.
        what: needs it, for example "the command live".
    """
    room, *below = (error.name or "").removeprefix("erclutch.").split(".")
    if room != "wings" or len(below) > 1:
        return None
    wing = below[0] if below else "all wings"
    remedy = "Install erclutch whole: its package has all wings"
    return PluginError(f"{what} needs the wing {wing}, whose folder is not there", remedy=remedy)


class RunError(ErclutchError):
    """A run folder or a saved model cannot be written or read back."""


class ExportError(ErclutchError):
    """A model cannot be exported, or an export cannot be written, built or verified."""
