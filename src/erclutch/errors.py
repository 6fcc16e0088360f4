"""All exceptions form one tree. Each message names the value, the limit and the remedy.

The command line prints ``str(error)`` and exits with ``error.exit_code``; nothing here is ever a bug report.
"""

from __future__ import annotations

import functools
import inspect
import math
import re
import shlex
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar, cast

Taker = TypeVar("Taker", bound=Callable[..., Any])


class ErclutchError(Exception):
    """Base of every error that a user can cause and mend.

    Args:
        problem: what is wrong, with the value and the limit that it missed.
        remedy: what to do about it, as an imperative sentence.
        where: the file (and row or column) or the option at fault.
        answers: options of a command that the remedy gives, each a whole answer, the likeliest first: ``--time none``.
            There are several where the user chooses, and none where the user fills something in or mends the file.
        option: options of ``erclutch inspect`` that the remedy gives, where they say which recording of a file is
            taken, how its numbers are written, or which field its logs have; NUMBER in it is for the user to fill in.
    """

    exit_code = 2

    def __init__(
        self,
        problem: str,
        *,
        remedy: str,
        where: str = "",
        answers: Sequence[str] = (),
        option: str = "",
    ) -> None:
        self.problem = problem
        self.remedy = remedy
        self.where = where
        self.answers = tuple(answers)
        self.option = option
        super().__init__(problem)

    def __reduce__(self) -> tuple[object, ...]:
        # Errors come back from other processes.
        again = functools.partial(
            type(self),
            self.problem,
            remedy=self.remedy,
            where=self.where,
            answers=self.answers,
            option=self.option,
        )
        return again, ()

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        return printable(worded(f"{place}{self.problem}. {self.remedy}."))


@dataclass
class _Interface:
    """Whom messages are for: a shell, or Python."""

    shell: bool = False


_INTERFACE = _Interface()

#: An option of a message, with its value where one follows: quoted, a number, a name in capitals, a known word, or what
#: holds a sign of a name such as ``lag+dahl``. Any other word that follows belongs to the sentence.
_OPTION = re.compile(
    r"--(?P<name>[A-Za-z][\w-]*)"
    r"(?:[ =](?P<value>'[^']*'|\"[^\"]*\"|-?[\dA-Z](?:[\w.*/+-]*\w)?|[.,](?= for)|[\w./-]*[+/][\w+/.-]*\w"
    r"|(?:all|auto|central|coaxial|difference|drop|error|float32|float64|kalman|lowpass|none|savgol|single)\b))?"
)
_VALUE = r"\"[^\"]*\"|'[^']*'|[^\s;\"']+(?<!\.)"
#: A command that a message offers for copying, with its options.
_COMMAND = re.compile(
    rf"erclutch inspect (?P<path>'[^']*'|\S+)(?P<options>(?: --[\w-]+ (?:{_VALUE}))+)"
)
#: What the command line calls keywords of Python that have another name there, or capitals.
TYPED = {"begin": "from", "end": "until", "e1": "E1", "e2": "E2", "e": "E", "t": "T"}
#: Options whose names in Python are others; "" where Python has the value alone, as the name of a folder.
_IN_PYTHON = {TYPED[name]: name for name in ("begin", "end")} | {"out": "", "to": "", "run": ""}
_DROPPED = re.compile(r"--(?:out|to|run) (?=[a-z])")
_SWITCHES = ("adapt", "alarms", "force", "keep-values", "polish")


@contextmanager
def for_a_shell() -> Generator[None]:
    """Messages name options as a shell takes them: ``--rate '1000 Hz'``; else as Python does: ``rate='1000 Hz'``."""
    before = _INTERFACE.shell
    _INTERFACE.shell = True
    try:
        yield
    finally:
        _INTERFACE.shell = before


def worded(text: str) -> str:
    """A message, which is written in a shell's words, in the words of the interface that shows it."""
    if _INTERFACE.shell:
        return text
    text = _COMMAND.sub(_as_call, text)
    return _OPTION.sub(_as_argument, _DROPPED.sub("", text))


def _as_call(command: re.Match[str]) -> str:
    """``erclutch inspect run.csv --slip "w [rpm]"`` as a call of `erclutch.read`."""
    path = command["path"].strip("'")
    arguments = [repr(path)]
    for name, value in re.findall(rf"--([\w-]+) ({_VALUE})", command["options"]):
        keyword = _IN_PYTHON.get(name, name.replace("-", "_"))
        given = value if value[0] in "'\"" else repr(value)
        arguments.append(f"{keyword}={given}")
    return f"erclutch.read({', '.join(arguments)})"


def _as_argument(option: re.Match[str]) -> str:
    name, value = option["name"], option["value"]
    argument = _IN_PYTHON.get(name, name.replace("-", "_"))
    if not argument:
        return value or name
    if name in _SWITCHES:
        return f"{argument}=True"
    if value is None:
        return f"{argument}="
    plain = value[0] in "'\"" or value.isupper() or re.fullmatch(r"-?[\d.]+", value)
    return f"{argument}={value}" if plain else f"{argument}={value!r}"


def printable(text: str) -> str:
    """A text as one line that a terminal only shows: white space is a blank, any other hidden character is written out.

    What is hidden: control characters, line ends, marks that turn the direction, halves of a character.
    """
    if text.isprintable():
        return text

    def seen(character: str) -> str:
        if character.isprintable():
            return character
        return " " if character.isspace() else ascii(character)[1:-1]

    return "".join(seen(character) for character in text)


@contextmanager
def placed(where: str) -> Generator[None]:
    """Errors that name no file get this one."""
    try:
        yield
    except ErclutchError as error:
        error.where = error.where or where
        raise


def listed(labels: Iterable[str], most: int = 30) -> str:
    """The first of some labels, and how many there are in all."""
    every = list(labels)
    more = f", ... ({len(every)} in all)" if len(every) > most else ""
    return ", ".join(every[:most]) + more if every else "none"


def plural(count: int, noun: str) -> str:
    """A noun as it stands behind a number: ``row`` behind 1, ``rows`` behind any other."""
    return noun if count == 1 else f"{noun}s"


def shell_word(text: str) -> str:
    """A text as a word of a command that a message offers for copying; a shell must not see more in it."""
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


class LogError(ErclutchError):
    """A log file cannot be read as a table of numbers."""


class SeveralRecordingsError(LogError):
    """A file holds several recordings, and the user takes one of them, or each."""


class AlikeRecordingsError(SeveralRecordingsError):
    """Recordings of a file have the same columns, and nothing is open about any: together they are several logs."""


class MappingError(ErclutchError):
    """The columns of a log cannot be matched to the signals that a device needs."""


class MissingColumnError(MappingError):
    """No column can be a signal that the device needs."""


class SeveralColumnsError(MappingError):
    """Several columns may be a signal, and nothing tells which of them is."""


class MissingClockError(MappingError):
    """A log has neither a column of times nor a sampling rate."""


class UnloggedFieldError(MappingError):
    """Logs without a field differ as logs at several fields do: names, a test plan or nobody tells which."""


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


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question with the known name that is nearest to a misspelt one, and a space; empty where none is near."""
    import difflib

    near = difflib.get_close_matches(name, list(known), n=1)
    return f"Did you mean {near[0]}? " if near else ""


def require_known(given: Iterable[str], known: Sequence[str], of: str) -> None:
    """Refuse a keyword that a function or a class does not know; the nearest that it knows is proposed.

    Raises:
        SettingError: an unknown keyword.
    """
    for keyword in given:
        if keyword not in known:
            hint = did_you_mean(keyword, known)
            raise SettingError(
                f"{of} knows no {keyword}", remedy=f"{hint}Known are {', '.join(known)}"
            )


def keywords_checked(taker: Taker) -> Taker:
    """A function or a class of the Python interface that answers a misspelt keyword with `SettingError`."""
    parameters = inspect.signature(taker).parameters.values()
    known = [each.name for each in parameters if each.kind is not each.POSITIONAL_ONLY]
    plain: Any = taker.__init__ if isinstance(taker, type) else taker

    @functools.wraps(plain)
    def checked(*values: Any, **keywords: Any) -> Any:
        require_known(keywords, known, taker.__name__)
        return plain(*values, **keywords)

    if isinstance(taker, type):
        taker.__init__ = checked
        return cast(Taker, taker)
    return cast(Taker, checked)


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
    """A plug-in that is needed is not installed, or it fails.

    Attributes:
        plugin: group and name of the plug-in that fails; empty where none is there.
    """

    plugin: tuple[str, str] | tuple[()] = ()


class SpoiltError(PluginError):
    """A plug-in changed what all others compute with: what was computed meanwhile may be wrong."""


class RunError(ErclutchError):
    """A run folder or a saved model cannot be written or read back."""


class ExportError(ErclutchError):
    """A model cannot be exported, or an export cannot be written, built or verified."""
