"""A command that answers all questions about a log at once is proposed: with columns that may be what is asked for."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from erclutch.logs.labels import split_label
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.missing_columns import example_of, field_or_none, has_speed
from erclutch.logs.plan import Question, SignalPlan
from erclutch.logs.seen_columns import SeenColumns


def proposals(
    seen: SeenColumns,
    told: ColumnMap,
    taken: Sequence[str],
    signals: Mapping[str, SignalPlan],
    questions: Mapping[str, Question],
) -> list[str]:
    """An option for each question: with what is most likely, or with a place to fill in; then what the rows need.

    Args:
        seen: the columns of the log.
        told: what the user and the mapping file said.
        taken: columns that are signals, inputs, the time or a counter of samples.
        signals: what was found, by its name.
        questions: what is asked, by the signal that it is about.
    """
    usual = {"time": '--time "COLUMN [s]"', "lead": '--lead "10 mm"', "input": '--input "COLUMN"'}
    usual["temperature"] = '--temperature "COLUMN [°C]"'
    examples: list[str] = []
    proposed: list[str] = []
    motions = [each.column for name, each in signals.items() if name in ("slip", "position")]
    for signal, question in questions.items():
        position = "--position" in question.remedy and f"--position {question.remedy.partition('--position ')[2]}"
        time = signal == "time" and "--time " in question.remedy and f"--time {question.remedy.partition('--time ')[2]}"
        time = time if time and "NAME" not in time else None
        others = [*taken, *proposed]
        if signal == "field" and "--field none" in question.remedy and "may be it" not in question.problem:
            examples.append("")  # once it is known whether the other questions have answers
            continue
        if signal == "time" and not time and has_speed(seen, signals, questions):
            examples.append('--rate "1 Hz"')  # a law without memory needs no clock where the speed is logged
            continue
        free = [column.shape for column in seen.without(others)]
        moving = not questions.keys() - {"time", "field"}  # else a column of the time may be among the open ones
        timeless = moving and not any(shape.rises and not shape.counts_rows for shape in free)
        if signal == "time" and not time and (timeless or not free):
            examples.append('--rate "RATE Hz"')
            continue
        known = position or time or usual.get(signal)
        examples.append(known or example_of(seen, signal, others, [*motions, *proposed]))
        label = shlex.split(examples[-1])[1]
        proposed += [label, split_label(label)[0]]
    if "" in examples:
        others = [*taken, *proposed]
        filled_in = not any("COLUMN" in example for example in examples)
        field = field_or_none if filled_in else partial(example_of, signal="field")
        examples[examples.index("")] = field(seen, taken=others)
    needed = [*taken, *(name for name in proposed if name in seen.columns)]
    holes = told.invalid != "drop" and any(not np.isfinite(seen.columns[name].values).all() for name in needed)
    return [*examples, *(["--invalid drop"] if holes else [])]
