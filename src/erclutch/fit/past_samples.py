"""How far back the past samples of a network lie: given in rows or as times, kept in rows, said in both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from erclutch.errors import SettingError, UnitError
from erclutch.fit.checks.finding import Finding
from erclutch.fit.fit_settings import Settings
from erclutch.logs.dataset import Dataset
from erclutch.models.model import Model
from erclutch.models.networks import MOST_PAST
from erclutch.signals import units

_REMEDY = "Give times with a unit (--past 1ms 2ms 4ms) or whole numbers of rows (--past 1 2 4)"


def past_rows(asked: Sequence[int | str], data: Dataset) -> tuple[int, ...]:
    """Rows back, in the order in which they were asked for; each once.

    Args:
        asked: whole numbers of rows, or times with a unit, such as ``2ms`` or ``0.5 s``.
        data: the rows that it is about.

    Raises:
        SettingError: neither of both, less than one row, more than 1000, or times where rows come at unequal steps,
            or logs of different sampling rates.
    """
    slow, fast = data.rates
    if asked and slow < fast:
        problem = f"the logs were sampled at {slow:.6g} to {fast:.6g} Hz, so past samples are other instants in each"
        raise SettingError(
            problem, remedy=f"Bring all logs to one rate, for example --resample {slow:.4g}"
        )
    back: list[int] = []
    for word in asked:
        if isinstance(word, int) or word.strip().isdecimal():
            back.append(_allowed(int(word), f"past samples {word}"))
            continue
        try:
            seconds = units.in_unit(word, "s") if units.quantity(word)[1] else 0.0
        except UnitError:
            seconds = 0.0
        if not seconds > 0:
            problem = f"past samples {word!r} are neither a time nor a number of rows"
            raise SettingError(problem, remedy=_REMEDY)
        if any(span.period is None for span in data.clock.spans):
            problem = (
                f"past samples {word!r} are no number of rows, since rows come at unequal steps"
            )
            remedy = "Bring them to one rate, for example --resample 1kHz"
            raise SettingError(problem, where=data.where, remedy=remedy)
        rows = min(seconds / data.period, 1e6)
        what = f"past samples {word!r} are {rows:.3g} rows at {1 / data.period:.6g} Hz"
        back.append(_allowed(round(rows), what))
    return tuple(dict.fromkeys(back))


def past_finding(asked: Sequence[int | str], data: Dataset) -> tuple[Finding, ...]:
    """Where the past samples lie, in rows and in time; nothing without any."""
    rows = past_rows(asked, data)
    if not rows:
        return ()
    given = ", ".join(str(word) for word in asked)
    back = ", ".join(str(count) for count in rows)
    times = ", ".join(f"{1e3 * count * data.period:.4g}" for count in rows)
    rate = 1 / data.period
    message = f"past samples (--past {given}) lie {back} rows back, {times} ms, at the {rate:.6g} Hz of these rows"
    return (Finding("note", "past", message, "An export must be called at this rate"),)


def without_network(settings: Settings, models: Iterable[Model]) -> tuple[Finding, ...]:
    """What was asked of networks where none is among the models: it changes nothing."""
    asked = [
        option
        for option, given in (("--past", settings.past), ("--polish", settings.polish))
        if given
    ]
    if not asked or any(model.network_part is not None for model in models):
        return ()
    options = " and ".join(asked)
    message = f"no network is among the models, so {options} changed nothing"
    remedy = f"Name a network too, for example --models bingham fnn-16, or leave {options} out"
    return (Finding("note", "network", message, remedy),)


def _allowed(rows: int, problem: str) -> int:
    """A number of rows back, if there may be so many."""
    if not 1 <= rows <= MOST_PAST:
        raise SettingError(problem, remedy=f"Give what lies 1 to {MOST_PAST} rows back")
    return rows
