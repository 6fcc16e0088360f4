"""A command that `inspect` prints is tried on the table first: what would be asked after it stands in it already."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from erclutch.cli.log_look import LogLook
from erclutch.cli.options import LogOptions
from erclutch.errors import ErclutchError

if TYPE_CHECKING:
    from erclutch.logs import Plan

_MOST_ROWS = 1_000_000  # of a log that is read once more
_MOST_QUESTIONS = 3  # one after another
#: What only the user can fill in, and options by which another table is read.
_NOT_TRIED = (
    *("COLUMN", "NUMBER", "NAME", "RATE Hz"),
    *("--variable", "--name-pattern", "--map", "--write-mapping", "--decimal"),
)


def with_options(command: str, reading: LogOptions) -> str:
    """A command of inspect with what the user gave besides, which is no part of the answer; as a window of the log."""
    words = command.split()  # a name may hold a quote
    if words[1] != "inspect":
        return command
    given = reading.words()
    beside: list[str] = []
    for place, word in enumerate(given):
        if word.startswith("--") and word not in (*words, "--constant", "--scale", "--zero"):
            values = given[place + 1 : place + 2]
            beside += [word, *(value for value in values if not value.startswith("--"))]
    return " ".join([command.rstrip(), *map(shlex.quote, beside)])


def tried_answer(command: str, look: LogLook, reading: LogOptions) -> str:
    """The command with the answers to what the log asks once it is answered, such as `--time none`.

    Args:
        command: of `inspect`, with what it found.
        look: what was found.
        reading: how the user said that the log is read.
    """
    table = look.raw
    all_words = shlex.split(command)
    first = next((place for place, word in enumerate(all_words) if word.startswith("--")), 0)
    words = all_words[first:] if first else []
    cannot_be_tried = any(mark in word for mark in _NOT_TRIED for word in words)
    is_of_inspect = all_words[:2] == ["erclutch", "inspect"]
    if not is_of_inspect or cannot_be_tried or reading.each or table.rows > _MOST_ROWS:
        return command
    from erclutch.logs import apply
    from erclutch.logs.keywords import LISTS

    given = [*words]
    for _ in range(_MOST_QUESTIONS):
        # The options by their names, each with its value; an option that may stand several times has all its values.
        options: dict[str, Any] = {}
        for option, value in zip(given[::2], given[1::2], strict=False):
            name = option.removeprefix("--").replace("-", "_")
            if name in LISTS:
                options[name] = (*options.get(name, getattr(reading, name)), value)
            else:
                options[name] = value
        told = replace(reading, **options)
        try:
            plan = told.plan(table, look.log)
            further: list[str] = []
            if plan.questions:
                proposed = shlex.split(plan.command())[3:]
                has_a_place = any(mark in word for mark in _NOT_TRIED for word in proposed)
                further = [] if has_a_place else proposed  # a place is filled in by the user
            else:
                try:
                    told.how().finished(apply(plan, table))
                except ErclutchError as error:
                    further = shlex.split(answer_to(error, plan))
        except ErclutchError:
            break
        new: list[str] = []
        for option, value in zip(further[::2], further[1::2], strict=False):
            if option not in given:
                new += [option, value]
        if not new:
            break
        given += new
    added = given[len(words) :]
    return f"{command.rstrip()} {shlex.join(added)}" if added else command


def answer_to(error: ErclutchError, plan: Plan) -> str:
    """The only option that answers what stands against the rows of a plan; "" where none does.

    Points have no time that a position could be differentiated by: rows that no clock fits are points only where the
    speed has a column; else the user fills in the rate.
    """
    if len(error.answers) != 1:
        return ""
    (answer,) = error.answers
    needs_a_speed = answer == "--time none"
    return '--rate "RATE Hz"' if needs_a_speed and plan.signal("slip") is None else answer
