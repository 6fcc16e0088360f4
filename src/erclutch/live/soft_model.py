"""A saved model as the loop in Python runs it: one row at a time, the same flags as the compiled one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.device import Element
from erclutch.dynamics import Clock, Span
from erclutch.errors import RunError
from erclutch.live.settings import LoopSettings
from erclutch.networks.model import NetworkModel
from erclutch.saved import Model

_OUTSIDE, _NOT_FINITE, _BOTH_FIELDS, _OUT_OF_REACH = 1, 2, 4, 16
_HALVINGS = 12  # 0.5 / 2^12: half a volt in 2000 V


def refuse_memory(model: Model) -> None:
    """The loop in Python has the present row only.

    Raises:
        RunError: the model needs more: dynamics, past samples or further inputs.
    """
    structure: Any = model.structure
    needs = [] if structure.dynamics == "none" else [f"dynamics ({structure.dynamics})"]
    if isinstance(model, NetworkModel):
        needs += ["past samples"] if structure.past else []
        needs += ["further inputs"] if structure.extras else []
    if needs:
        raise RunError(
            f"{model.name} has {' and '.join(needs)}: only the loop in C runs that",
            remedy="Install a C compiler (pip install 'erclutch[compiler]' brings one) and leave out --python-loop, "
            "or give a model without",
        )


class SoftModel:
    """A model of the present row.

    Args:
        model: memoryless.
        settings: of the loop: its period and largest field.

    Raises:
        RunError: it is not memoryless.
    """

    def __init__(self, model: Model, settings: LoopSettings) -> None:
        refuse_memory(model)
        self._model = model
        self._clock = Clock(np.zeros(1), (Span(0, 1, settings.period),))
        self._limit = settings.field_limit
        self._last = 0.0

    def step(self, inputs: Sequence[float]) -> tuple[float, int]:
        """Effort and flags; inputs are E1, E2, theta_dot, alpha_dot, or field and slip of a single device."""
        if not all(map(math.isfinite, inputs)):
            return self._last, _NOT_FINITE
        rows = _elements(inputs)
        value = self._effort(rows)
        self._last = value if math.isfinite(value) else self._last
        both = len(rows) == 2 and inputs[0] > 0 and inputs[1] > 0
        return self._last, (_OUTSIDE if self._outside(rows) else 0) | (_BOTH_FIELDS if both else 0)

    def inverse(self, inputs: Sequence[float], wanted: float) -> tuple[float, int]:
        """Signed field for a wanted effort, and flags: bisection, for the effort of a device grows or falls with it."""
        low, high = (-self._limit if len(inputs) == 4 else 0.0), self._limit

        def effort(field: float) -> float:
            pair = (max(field, 0.0), max(-field, 0.0), *inputs[2:]) if len(inputs) == 4 else (field, *inputs[1:])
            return self._effort(_elements(pair))

        lowest, highest = effort(low), effort(high)
        way = 1.0 if highest >= lowest else -1.0
        if way * wanted < way * lowest:
            return low, _OUT_OF_REACH
        if way * wanted > way * highest:
            return high, _OUT_OF_REACH
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if way * effort(middle) < way * wanted:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high), 0

    def _effort(self, rows: tuple[Element, ...]) -> float:
        return float(self._model.effort(rows, self._clock, exactly=False)[0])

    def _outside(self, rows: tuple[Element, ...]) -> bool:
        trained = self._model.trained_on
        pairs = [(float(e.field[0]), trained.field) for e in rows] + [(float(e.slip[0]), trained.slip) for e in rows]
        return any(not a - 0.01 * (b - a) <= x <= b + 0.01 * (b - a) for x, (a, b) in pairs)


def _elements(inputs: Sequence[float]) -> tuple[Element, ...]:
    if len(inputs) == 2:
        pairs = [(inputs[0], inputs[1])]
    else:
        first, second, theta_dot, alpha_dot = inputs
        pairs = [(first, theta_dot - alpha_dot), (second, -theta_dot - alpha_dot)]
    return tuple(Element(np.array([field]), np.array([slip])) for field, slip in pairs)
