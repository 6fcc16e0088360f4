"""A guessed unit may mean two things: a range of a sensor stands before it, or a power of ten beside the name."""

from __future__ import annotations

import re

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.powers_of_ten import both_ways, power_beside
from erclutch.logs.planning.draft import Draft

#: A unit with a plain number in front of it.
_RANGE = re.compile(r"\s*(\d{1,6}(?:\.\d+)?)\s*([^\W\d_].*?)\s*")


def ask_about_ranges_of_sensors(draft: Draft) -> None:
    """Ask about a guessed signal whose unit begins with a number: ``Load [40 N]`` may name the range of its cell.

    A number below 1 is what a count of a converter is worth, and a power in ten is a factor.
    """
    for signal, guessed in [*draft.signals.items()]:
        unit = guessed.unit or ""
        match = _RANGE.fullmatch(unit)
        if match is None or float(match.group(1)) <= 1.0 or draft.guessed(signal) is None:
            continue
        plain_unit = match.group(2)
        draft.take_back(signal)
        bare = f"--{signal} {shell_word(f'{guessed.column} [{plain_unit}]')}"
        multiple = f"--{signal} {shell_word(f'{guessed.column} [{unit}]')}"
        may_be = f"{plain_unit} with the range of its sensor, or steps of it"
        problem = f"the unit of column {guessed.column} is {unit}: {may_be}"
        draft.ask(
            signal, MappingError(problem, remedy=f"Say which: {bare}, or {multiple}"), option=bare
        )


def ask_about_powers_of_ten(draft: Draft) -> None:
    """Ask about a guessed signal with a power of ten beside its name: its numbers may be times it, or over it."""
    for signal, guessed in [*draft.signals.items()]:
        factor = power_beside(guessed.column or "")
        if factor is None or draft.guessed(signal) is None:
            continue
        draft.take_back(signal)
        unit = guessed.unit or guessed.si
        multiplied, over = both_ways(f"--{signal}", guessed.column, unit, factor)
        problem = f"the name of column {guessed.column} has a power of ten: its numbers may be times it, or over it"
        remedy = f"Say which: {multiplied} if they were multiplied by it, or {over}"
        draft.ask(signal, MappingError(problem, remedy=remedy), option=multiplied)
