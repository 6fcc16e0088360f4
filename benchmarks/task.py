"""What a contender is given, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from rows import Split
from watch import Predict, Watch

from erclutch.models.networks.network_model import Scaling

Array = NDArray[np.float64]


@dataclass
class Task:
    """One contender's task.

    Attributes:
        group: of `contenders.GROUPS`.
        train: rows to fit.
        scaling: of the network's inputs and of the effort.
        watch: the contender's clock.
        seed: of its start.
        threads: that it may use.
        notes: what the table should say of it.
        check: run once the clock and the memory are read; adds to the notes.
    """

    group: str
    train: Split
    scaling: Scaling
    watch: Watch
    seed: int
    threads: int
    notes: list[str] = field(default_factory=list)
    check: Callable[[], None] = lambda: None

    def effort(self, of_unit: Callable[[Array], Array]) -> Predict:
        """Prediction in the data's unit from one on normalised rows (n, 3)."""

        def predict(split: Split) -> Array:
            unit = np.asarray(of_unit(split.x), np.float64).reshape(-1)
            return unit * self.scaling.effort_scale + self.scaling.effort_offset

        return predict


#: Fits and returns how the fitted model predicts.
Fit = Callable[[Task], Predict]
