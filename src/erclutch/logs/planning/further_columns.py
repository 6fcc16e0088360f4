"""Columns beside those that the device needs are taken: what it may have, what the user wants, what is worth a look."""

from __future__ import annotations

import re

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import is_given_by_place
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.phases import is_of_phases
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import NOT_MEASURED as COMPUTED
from erclutch.logs.plan import OPTIONAL, SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.named_columns import locate
from erclutch.logs.planning.no_field import is_of_models
from erclutch.signals import units
from erclutch.signals.channels import NOT_MEASURED
from erclutch.signals.recording import SIGNALS

_MOST_SPARE = 8
#: How words for a temperature begin in several languages.
_TEMPERATURES = re.compile("temperat|темпер|油温|温度|온도")
_COUNTS = frozenset(
    {"row", "rows", "index", "idx", "sample", "samples", "unnamed", "nr", "no", "number", "count"}
)
#: Columns that say how a row came about, and measure nothing.
_STATES = ("flags", "events", "status", "state")


def take_optional_signals(draft: Draft) -> None:
    """Take the columns that are called like a signal that the device may have and does not need."""
    for signal in OPTIONAL[draft.device]:
        if signal in draft.signals or signal in draft.declined:
            continue
        called, _ = candidates(draft.seen, signal, draft.taken)
        if len(called) != 1:
            continue
        column = draft.seen.columns[called[0]]
        if np.isfinite(column.values).all():
            unit = column.unit_for(SIGNALS[signal].si_units)
            draft.take(signal, column.name, unit, 1.0, "guessed from its name", "likely")


def take_inputs(draft: Draft) -> None:
    """Take the columns that the user wants as further inputs of models, as logged; a wrong name is a question."""
    for choice in draft.told.inputs:  # they travel with the signals under a name of their own
        try:
            name, unit, factor = locate(draft.table, choice, "input")
        except MappingError as error:
            draft.ask("input", error)
            continue
        # A model keeps the unit in its file, whose reader takes well-written ones.
        is_known = bool(unit) and units.is_known_unit(unit) and units.is_written_well(unit)
        unit_as_logged = unit if unit and is_known and abs(factor) == 1.0 else units.UNKNOWN
        draft.inputs.append(
            SignalPlan("input", name, unit, factor, factor, unit_as_logged, reason=choice.source)
        )
        draft.notes.append(f"further input <- column {name}, as logged ({choice.source})")


def note_spare_columns(draft: Draft) -> None:
    """Note columns of finite numbers that change and that nothing has taken, and a temperature that no law uses.

    `fit.choice.ladder` says what they are good for.
    """
    not_spare = {*draft.taken, *draft.table.truths, *_STATES}
    if draft.table.device is not None:
        not_spare |= {*NOT_MEASURED}
    for column in draft.seen.without(not_spare):
        name = column.name
        if "temperature" not in draft.signals:
            unit = column.unit or split_end(name)[1]
            words = column.spoken.stem_words
            is_called_so = any(word == "temp" or _TEMPERATURES.match(word) for word in words)
            if units.is_temperature(unit):
                option = option_for_input(name, unit)
                draft.notes.append(
                    f"column {name} is a temperature, and no law uses it; with {option} laws do"
                )
            elif is_called_so and not unit and not column.shape.constant:
                option = option_for_input(name, "°C")
                draft.notes.append(
                    f"column {name} is called like a temperature and has no unit; with {option}, or [K], laws use it"
                )
        changes = not column.shape.constant and column.values.size > 1
        # Rows are counted by a column without a name, or with the name of a count.
        is_nameless = name == "" or is_given_by_place(name)
        is_called_a_count = is_nameless or column.spoken.says(_COUNTS)
        numbers_the_rows = column.shape.counts_rows and is_called_a_count
        is_other = numbers_the_rows or is_of_phases(draft.seen, column)
        measures = changes and not is_other and np.isfinite(column.values).all()
        # What another model says of the effort would take off its error, and no controller has it.
        if not measures or is_of_models(draft.seen, column):
            continue
        if not _is_an_effort_besides(draft, column):
            draft.spare.append(name)
            if len(draft.spare) == _MOST_SPARE:
                return


def option_for_input(name: str, unit: str | None) -> str:
    """The option that lets laws use a column that nothing has taken: stages make factors of a temperature.

    Args:
        name: of the column.
        unit: of the column; None where nobody says it.
    """
    if units.is_temperature(unit):
        return f"--temperature {shell_word(f'{name} [{unit}]')}"
    return f"--input {shell_word(name)}"


def _is_an_effort_besides(draft: Draft, column: SeenColumn) -> bool:
    """Whether a column is called like an effort that was computed, or is the effort of another joint."""
    words = column.spoken.stem_words
    if column.spoken.says(COMPUTED) and any(
        spoken_name(word).forms["effort"] for word in words if len(word) > 2
    ):
        return True
    effort = draft.signals.get("effort")
    if effort is None or not effort.column:
        return False
    taken = draft.seen.columns[effort.column].spoken
    is_numbered = taken.bare_stem != taken.plain_stem
    return is_numbered and column.spoken.bare_stem == taken.bare_stem
