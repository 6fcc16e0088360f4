"""A command that answers all questions about a log at once is proposed: with columns that may be what is asked for."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

import numpy as np

from erclutch.logs import name_pattern
from erclutch.logs.columns import candidates
from erclutch.logs.labels import split_label
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.missing_columns import example_of, field_or_none, has_speed
from erclutch.logs.plan import Question, SignalPlan
from erclutch.logs.seen_columns import SeenColumns

_USUAL = {"lead": '--lead "10 mm"', "input": '--input "COLUMN"', "temperature": '--temperature "COLUMN [°C]"'}


def proposals(
    seen: SeenColumns,
    told: ColumnMap,
    taken: Sequence[str],
    signals: Mapping[str, SignalPlan],
    questions: Mapping[str, Question],
    name: str = "",
) -> list[str]:
    """An option for each question: with what is most likely, or with a place to fill in; then what the rows need.

    Args:
        seen: the columns of the log.
        told: what the user and the mapping file said.
        taken: columns that are signals, inputs, the time or a counter of samples.
        signals: what was found, by its name.
        questions: what is asked, by the signal that it is about.
        name: the file's: it may hold the field.
    """
    motions = [each.column for name, each in signals.items() if name in ("slip", "position")]
    options: dict[str, str] = {}
    proposed: list[str] = []  # the columns in these options, and their labels

    # The field comes last, since a log may have none: it gets no column that another question needs more.
    for signal, question in sorted(questions.items(), key=lambda item: item[0] == "field"):
        others = [*taken, *proposed]
        filled_in = not any("COLUMN" in option for option in options.values())
        may_be_unlogged = "--field none" in question.remedy and not _doubtful(question, proposed)
        if question.option:
            option = question.option
        elif signal == "field" and may_be_unlogged and filled_in:
            option = field_or_none(seen, taken=others)
        elif signal == "time":
            option = _clock_option(seen, signals, questions, others)
        elif signal == "slip" and "--position" in question.remedy:
            option = f"--position {question.remedy.partition('--position ')[2]}"
        else:
            asks_for_both = signal in ("slip", "position") and "effort" in questions
            partners = candidates(seen, "effort", others)[0] if asks_for_both else []
            option = _USUAL.get(signal) or example_of(seen, signal, others, [*motions, *proposed], partners)
        if signal == "field" and ("COLUMN" in option or "none" in option) and (pattern := name_pattern.proposed(name)):
            option = f"--name-pattern {shlex.quote(pattern)}"
        options[signal] = option
        if signal != "time" or option.startswith("--time"):
            label = shlex.split(option)[1]
            proposed += [label, split_label(label)[0]]

    examples = [options[signal] for signal in questions]
    needed = [*taken, *(name for name in proposed if name in seen.columns)]
    holes = told.invalid != "drop" and any(not np.isfinite(seen.columns[name].values).all() for name in needed)
    return [*examples, *(["--invalid drop"] if holes else [])]


def _doubtful(question: Question, proposed: Sequence[str]) -> bool:
    """Whether a column with a name of several meanings may be the field, and is proposed for no other signal."""
    _, _, named = question.problem.partition("; ")
    column, may_be, _ = named.partition(" may be it")
    return bool(may_be) and column not in proposed


def _clock_option(
    seen: SeenColumns, signals: Mapping[str, SignalPlan], questions: Mapping[str, Question], others: Sequence[str]
) -> str:
    """The option for a clock that was not found: a column that the question names, a rate, or a place to fill in."""
    _, named, column = questions["time"].remedy.partition("--time ")
    if named and "NAME" not in column:
        return f"--time {column}"
    if has_speed(seen, signals, questions):
        return "--time none"  # a law without memory needs no clock where the speed is logged
    free = [column.shape for column in seen.without(others)]
    moving = not questions.keys() - {"time", "field"}  # else a column of the time may be among the open ones
    timeless = moving and not any(shape.rises and not shape.counts_rows for shape in free)
    return '--rate "RATE Hz"' if timeless or not free else '--time "COLUMN [s]"'
