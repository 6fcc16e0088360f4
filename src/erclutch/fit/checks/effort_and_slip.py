"""A passive device dissipates: its effort and its slip have the same sign on the whole, in each log."""

from __future__ import annotations

from collections.abc import Sequence
from re import compile as pattern
from typing import NamedTuple

import numpy as np

from erclutch.errors import listed, shell_word
from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.device import Element

#: Subject of the finding that effort opposes slip.
SIGN = "sign"

#: How a note of a recording says from which column a signal came.
_COLUMN = pattern(r"(\w+) <- column (.+?)(?:, .*| \(the file says .*)? \([^()]*\)")
#: Logs that a message names; the rest it counts.
_MOST_NAMED = 8
#: A motion goes one way that has no more than this share of its rows in the rarer direction: noise at rest.
_HARDLY_EVER = 0.02
#: Share of the power to and fro that goes one way: a spring or an inertia has none, friction has all of its own.
_CLEARLY_ONE_WAY = 0.3


class _Power(NamedTuple):
    """Mean power that a device takes, weighed by its field, and the mean of its size; 0 where nothing moves."""

    taken: float
    size: float

    @property
    def share(self) -> float:
        """1 where the device takes power in all rows, -1 where it delivers power in all."""
        return self.taken / self.size if self.size > 0.0 else 0.0


def effort_against_slip(train: Dataset) -> Finding | None:
    """The effort opposes the slip in the rows as a whole."""
    if _power(train.effort, train.elements).taken >= 0.0:
        return None
    name = "T" if train.device == "coaxial" else "effort"
    message = "effort opposes slip on average, so the device would deliver energy"
    remedy = f"Turn a sign, for example --{name} {shell_word(_turned(train.notes, name))}"
    return Finding("warning", SIGN, message, remedy)


def logs_against_others(data: Dataset) -> Finding | None:
    """Logs in which the effort opposes the slip, beside others in which it does not: a sensor was turned round."""
    against: list[str] = []
    along: list[str] = []
    for name, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        if stop == start:
            continue
        own = slice(start, stop)
        elements = [Element(each.field[own], each.slip[own]) for each in data.elements]
        share = _power(data.effort[own], elements).share
        if share < -_CLEARLY_ONE_WAY:
            against.append(name)
        elif share > _CLEARLY_ONE_WAY:
            along.append(name)
    if not against or not along:
        return None
    message = (
        f"effort opposes slip in {listed(against, _MOST_NAMED)} and goes with it in {listed(along, _MOST_NAMED)}: a "
        "sensor or the motion was turned round between them, or something drives the device"
    )
    log = against[0]
    if ": " in log:  # a recording of a larger file, beside which no file stands for it alone
        remedy = "Where it was turned round, turn the sign of that recording in the file"
    else:
        signal = "T" if data.device == "coaxial" else "effort"
        label = shell_word(_turned(data.notes, signal))
        mapping = shell_word(f"{log}.toml")
        command = f"erclutch inspect {shell_word(log)} --{signal} {label} --write-mapping {mapping}"
        remedy = (
            f"Where it was turned round, write a file beside the log that turns it back: {command}"
        )
    return Finding("warning", "signs of logs", message, remedy)


def _power(effort: Array, elements: Sequence[Element]) -> _Power:
    """The power that the device takes in these rows."""
    # A sensor's zero makes no power over a motion to and fro, and is taken off. Over a motion one way it cannot be told
    # from friction, and an effort that falls with the speed would seem to drive the device without its mean.
    rarer = [min(np.mean(element.slip > 0.0), np.mean(element.slip < 0.0)) for element in elements]
    to_and_fro = max(rarer) > _HARDLY_EVER
    if to_and_fro:
        effort = effort - np.mean(effort)

    taken = size = 0.0
    for element in elements:
        # Most power is dissipated under the strongest field, so rows weigh by it; all the same without any field.
        strength = np.abs(element.field)
        most = float(strength.max())
        weight = strength + 1e-3 * most if most > 0.0 else np.ones_like(element.field)
        weighed = effort * element.slip * weight
        taken += float(np.mean(weighed))
        size += float(np.mean(np.abs(weighed)))
    return _Power(taken, size)


def _turned(notes: Sequence[str], signal: str) -> str:
    """The column of a signal as an option names it, with the sign that it has not got now."""
    for note in notes:
        column = _COLUMN.fullmatch(note)
        if column is not None and column[1] == signal:
            return column[2] if "sign turned" in note else f"-{column[2]}"
    return "-NAME [unit]"
