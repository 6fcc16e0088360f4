"""What options of a command say of the reading of a log is said in Python by keywords of the same names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nextafter
from typing import Any, NamedTuple, cast

from erclutch.errors import TYPED, MappingError, SettingError, UnitError, did_you_mean
from erclutch.logs.clock.timing import LATEST
from erclutch.signals import units
from erclutch.signals.recording import NAMED_COLUMNS, LogFacts, Recording

#: First and last time that are taken, and how much is left out of the start, in s; None: all is taken.
Window = tuple[float | None, float | None, float | None]

#: Times of a window, and what the command line calls them.
_TIMES = {name: TYPED.get(name, name) for name in ("begin", "end", "skip")}
#: Keywords and options that may be given several times.
LISTS = ("constant", "scale", "zero", "input")
_TEXTS = ("time", "rate", "lead", "name_pattern", "decimal", "keep_values", "resample", *_TIMES)
#: The command line has no capitals: ``--E1`` is kept as e1.
_KNOWN = {name.lower(): name for name in (*NAMED_COLUMNS, *LISTS, *_TEXTS)}


class NumberKind(NamedTuple):
    """What an option's number is: its unit, its limits in that unit, and how a message calls it."""

    unit: str
    least: float
    most: float
    called: str
    example: str


_BELOW_LATEST = nextafter(LATEST, 0.0)
SECONDS = NumberKind("s", -_BELOW_LATEST, _BELOW_LATEST, "time", "2s, or 500ms")
HERTZ = NumberKind("Hz", 1e-3, 1e7, "sampling rate", "1kHz")


def options_of(keywords: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `erclutch.read` as options; a text may stand for a list of one, a number for a time in s.

    Raises:
        MappingError: a name that is no signal and no option of reading. SettingError: a switch that is none.
    """
    options: dict[str, Any] = {}
    for keyword, value in keywords.items():
        name = keyword.lower()
        if name not in _KNOWN:
            hint = did_you_mean(keyword, _KNOWN.values())
            remedy = f"{hint}Known are {', '.join(_KNOWN.values())}"
            raise MappingError(f"{keyword!r} is no signal and no option of reading", remedy=remedy)
        if value is None:
            continue
        if name == "keep_values" and not isinstance(value, bool):
            raise SettingError(f"{keyword} is {value!r}", remedy="Give True or False")
        if name in LISTS and isinstance(value, str):
            options[name] = (value,)
        elif name == "resample" or name in _TIMES:
            options[name] = str(value)
        else:
            options[name] = value
    return options


def all_options(mapping: object, said: Mapping[str, Any]) -> dict[str, Any]:
    """What was said of the columns, as options; a mapping with the keys of a mapping file has no options for all.

    Args:
        mapping: see `erclutch.read`.
        said: options, which win.
    """
    labels = cast("Mapping[str, Any]", mapping if isinstance(mapping, Mapping) else {})
    known = {name.lower() for name in NAMED_COLUMNS}
    columns = {name.lower(): label for name, label in labels.items() if name.lower() in known}
    return {**columns, **said}


def told_alike(logs: Sequence[LogFacts]) -> dict[str, Any]:
    """What `erclutch.read` was told of all of some logs, as options: the next logs may be read so; else empty."""
    told_of_logs: list[dict[str, Any]] = []
    for log in logs:
        told_of_logs.append(dict(log.told) if isinstance(log, Recording) else {})
    if not told_of_logs:
        return {}
    first, *others = told_of_logs
    return first if all(each == first for each in others) else {}


def window_and_rate(options: Mapping[str, Any]) -> tuple[Window, float | None]:
    """The window in time that options name, and the sampling rate in Hz; None: logs keep their own.

    Raises:
        SettingError: no such time or rate.
    """
    begin, end, skip = (
        number_of(said, options[name], SECONDS) if name in options else None
        for name, said in _TIMES.items()
    )
    rate = number_of("resample", options["resample"], HERTZ) if "resample" in options else None
    return (begin, end, skip), rate


def number_of(option: str, text: str, kind: NumberKind, example: str = "") -> float:
    """An option's number in the unit of its kind: 0.5 for the time ``500ms``, 1000 for the rate ``1 kHz``.

    Args:
        option: for the message.
        text: a number, with or without a unit.
        kind: `SECONDS` or `HERTZ`.
        example: of a text, for the message.

    Raises:
        SettingError: no number of this kind.
    """
    try:
        number = units.in_unit(text, kind.unit)
    except UnitError:
        number = float("nan")
    if not kind.least <= number <= kind.most:
        remedy = f"Write it like --{option} {example or kind.example}"
        raise SettingError(f"--{option} {text!r} is no {kind.called}", remedy=remedy)
    return number
