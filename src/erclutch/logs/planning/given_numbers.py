"""Numbers that a user, a mapping file or a file's name gives for a whole log are taken, for a signal or not."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from erclutch.errors import MappingError, UnitError
from erclutch.logs.columns.name_pattern import constants_of, names_a_folder
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_OF_A_NAME = "from the file's name"


def take_given_numbers(draft: Draft) -> None:
    """Take numbers of the mapping and of the file's name; what is called like a signal becomes a constant signal.

    Raises:
        MappingError: a number that is none, a name that does not match its pattern, a number for the field where the
            user said that none was logged. UnitError: a unit that does not fit its signal.
    """
    told = draft.told
    of_mapping: dict[str, tuple[float, str | None, str]] = {}  # number, unit, source
    for key, text in told.constants.items():
        if "," not in text:
            of_mapping[key] = (*_quantity(key, text), told.source)
            continue
        # A signal that is constant in each segment: one number after another, a unit behind the last (0, 1 A).
        *earlier, last = text.split(",")
        final, unit = _quantity(key, last)
        numbers = [*(_quantity(key, number)[0] for number in earlier), final]
        if key not in SIGNALS:
            raise MappingError(f"{key} is no signal", remedy="Give one number")
        factor, si = units.conversion(unit, SIGNALS[key], key) if unit else (1.0, units.UNKNOWN)
        draft.signals[key] = SignalPlan(
            key,
            unit=unit,
            si=si,
            numbers=tuple(number * factor for number in numbers),
            reason=told.source,
        )
        draft.notes.append(f"{key} <- {text.strip()}, one number a segment ({told.source})")

    of_name: dict[str, tuple[float, str | None, str]] = {}
    if told.name_pattern:
        of_folder = names_a_folder(told.name_pattern)
        name = str(Path(draft.table.path).resolve()) if of_folder else draft.table.name
        try:
            stated = constants_of(told.name_pattern, name)
        except MappingError:
            # Beside logs with the number in their names stands one that a mapping file says it of.
            if not of_mapping.keys() & draft.known_signals:
                raise
            stated = {}
        for key, (number, unit) in stated.items():
            of_name[key] = (number, unit, _OF_A_NAME)

    given = {**of_name, **of_mapping}
    for key, (number, unit, source) in given.items():
        text = f"{number:g} {unit}" if unit else f"{number:g}"
        chosen = draft.signals.get(key)
        if key not in draft.known_signals:
            draft.constants[key] = number
            draft.notes.append(f"{key} = {text} ({source})")
        elif chosen is not None and not chosen.column and source == _OF_A_NAME:
            problem = f"{key} is {text} {source}, and it was said that none was logged"
            raise MappingError(problem, remedy="Leave --field none out, or --name-pattern")
        elif chosen is not None:
            draft.notes.append(
                f"{key} = {text} ({source}) not used: column {chosen.column or '?'} was chosen"
            )
        else:
            if unit:
                factor, si = units.conversion(unit, SIGNALS[key], key)
            else:
                factor = 1.0
                si, _ = draft.assumed_unit(key, np.array([number]))
            draft.signals[key] = SignalPlan(
                key,
                unit=unit,
                si=si,
                numbers=(number * factor,),
                reason=source,
            )
            draft.constants[key] = number * factor
            draft.notes.append(f"{key} <- constant {text} ({source})")


def _quantity(key: str, text: str) -> tuple[float, str | None]:
    try:
        return units.quantity(text)
    except UnitError as error:
        raise MappingError(f"the constant {key} is '{text}'", remedy=error.remedy) from error
