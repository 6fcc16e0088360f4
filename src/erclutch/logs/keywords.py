"""What options of a command say of the reading of a log is said in Python by keywords of the same names."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

from erclutch.errors import MappingError
from erclutch.logs.resample import rate_of, resampled
from erclutch.logs.time_window import seconds_of, within
from erclutch.signals.recording import NAMED_COLUMNS, Recording

#: First and last time that are taken, and how much is left out of the start, in s; None: all is taken.
Window = tuple[float | None, float | None, float | None]

_TIMES = {"begin": "from", "end": "until", "skip": "skip"}  # and what the command line calls them
_LISTS = ("constant", "scale", "input")
_TEXTS = ("time", "rate", "lead", "name_pattern", "decimal", "keep_values", "resample", *_TIMES)
#: The command line has no capitals: ``--E1`` is kept as e1.
_KNOWN = {**{name.lower(): name for name in NAMED_COLUMNS}, **{name: name for name in (*_LISTS, *_TEXTS)}}


def options_of(keywords: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `erclutch.read` as options; a text may stand for a list of one, a number for a time in s.

    Raises:
        MappingError: a name that is no signal and no option of reading.
    """
    for name in keywords:
        if name.lower() not in _KNOWN:
            near = difflib.get_close_matches(name, _KNOWN.values(), n=1)
            hint = f"Did you mean {near[0]}? " if near else ""
            remedy = f"{hint}Known are {', '.join(_KNOWN.values())}"
            raise MappingError(f"{name!r} is no signal and no option of reading", remedy=remedy)
    options = {name.lower(): value for name, value in keywords.items() if value is not None}
    lists = {name: (options[name],) for name in _LISTS if isinstance(options.get(name), str)}
    times = {name: str(options[name]) for name in ("resample", *_TIMES) if name in options}
    return {**options, **lists, **times}


def window_of(options: Mapping[str, Any]) -> Window:
    """The window in time that options name.

    Raises:
        SettingError: no such time.
    """
    begin, end, skip = (seconds_of(said, options[name]) if name in options else None for name, said in _TIMES.items())
    return begin, end, skip


def new_rate(options: Mapping[str, Any]) -> float | None:
    """The sampling rate in Hz that options ask for; None: logs keep their own.

    Raises:
        SettingError: no such rate.
    """
    return rate_of(options["resample"]) if "resample" in options else None


def finished(log: Recording, window: Window, rate: float | None) -> Recording:
    """A recording in its window and at its rate.

    Raises:
        SettingError: a window or a rate that it cannot have.
    """
    log = within(log, *window)
    return log if rate is None else resampled(log, rate)
