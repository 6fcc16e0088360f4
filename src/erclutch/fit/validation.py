"""Training rows that a fit has not seen say how well a model does elsewhere; rows held out are never looked at."""

from __future__ import annotations

import numpy as np

from erclutch.fit.candidate import Fitted
from erclutch.logs.dataset import Dataset, time_folds
from erclutch.signals.array import Array


def cross_validated(train: Dataset, fitted: Fitted, blocks: int) -> tuple[float, ...]:
    """RMSE on each block of the training rows in time, fitted on the others; empty for no blocks."""
    errors: list[float] = []
    for block in time_folds(train, blocks) if blocks else ():
        model = fitted.candidate.refit(train.take(~block), fitted.outcome).model
        error: Array = train.effort - model.predict(train)
        errors.append(float(np.sqrt(np.mean(error[block] ** 2))))
    return tuple(errors)
