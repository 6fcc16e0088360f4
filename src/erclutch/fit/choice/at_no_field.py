"""Which of several laws estimate at no field as most of them do, where no log is at no field.

A device is off at times, and a fit without rows at no field extrapolates there. Laws that no part of the training rows
can tell apart may then part by more than all that they err by elsewhere. The one in the middle is wrong by far less
often than any single one of them: what most forms say does not hang on one form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array, rms

#: Of two laws neither is in the middle.
FEWEST_LAWS = 3
NOT_IN_THE_MIDDLE = (
    "no log is at no field, and there it estimates otherwise than most laws that are as good"
)
#: Distances that differ by less than this share of the error on the training rows are alike.
_ALIKE = 0.01


def in_the_middle(train: Dataset, laws: Mapping[str, AnyOutcome]) -> list[str]:
    """The law nearest to the median of all at no field, and those that are next to as near.

    Args:
        train: the training rows; the laws are asked what the effort were in their motions without a field.
        laws: fits to these rows by name, as good as each other.

    Returns:
        All names where there are fewer than three laws.
    """
    if len(laws) < FEWEST_LAWS:
        return list(laws)
    elements = [replace(each, field=np.zeros_like(each.field)) for each in train.elements]
    off = replace(train, elements=tuple(elements))
    estimates: dict[str, Array] = {}
    for name, outcome in laws.items():
        estimates[name] = outcome.model.predict(off)
    median = np.median(np.array(list(estimates.values())), axis=0)
    away = {name: rms(estimate - median) for name, estimate in estimates.items()}
    if not np.isfinite(list(away.values())).all():
        return list(laws)

    error = min(rms(train.effort - outcome.model.predict(train)) for outcome in laws.values())
    near = min(away.values()) + _ALIKE * error
    return [name for name in laws if away[name] <= near]
