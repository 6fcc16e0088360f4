"""A damped oscillator follows a signal; stages on the command and on the effort share it.

::

    tau**2 x'' + 2 zeta tau x' + x = u

The state is x and its slope v = tau x'. The signal is held over a sample, so one step is exact::

    x_k = u + a11 (x_{k-1} - u) + a12 v_{k-1},   v_k = a21 (x_{k-1} - u) + a22 v_{k-1}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import pick, value_of
from erclutch.arithmetic.recursion import follow, step_of
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, longest_lag
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Oscillator:
    """The oscillator as a stage.

    Attributes:
        name, title, source, place: see `Stage`.
        letter: ends the names of the parameters.
    """

    name: str
    title: str
    source: str
    place: Place
    letter: str
    switches: bool = False

    @property
    def equation(self) -> str:
        """See `Stage`."""
        tau = f"tau_{self.letter}"
        zeta = f"zeta_{self.letter}"
        x, u = ("E", "u") if self.place == "command" else ("T", "T_fluid")
        return f"{tau}^2 {x}'' + 2 {zeta} {tau} {x}' + {x} = {u}"

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The time constant and the damping; 1 / (2 pi tau) is the natural frequency."""
        tau = ShapeParameter(
            f"tau_{self.letter}",
            "reciprocal of the natural angular frequency",
            lower=0.2 * period,
            upper=longest_lag(period),
            dimension=Dimension(time=1),
            scale="log",
            usual=(0.5 * period, 50.0 * period),
        )
        zeta = ShapeParameter(
            f"zeta_{self.letter}",
            "damping: below 1 it overshoots",
            lower=0.03,
            upper=5.0,
            scale="log",
            usual=(0.2, 2.0),
        )
        return tau, zeta

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """What follows at some of the rows; see `Stage`."""
        tau, zeta = q
        given = (signal, *coefficients(tau, zeta, step_of(clock)))
        x, _ = follow(_advance, (signal, 0.0), given, clock, linear=True)
        return pick(x, rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """At rest at the signal."""
        return {"x": signal, "v": 0.0 * signal}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any]:
        """One row."""
        tau, zeta = q.values()
        before = memory.before("x"), memory.before("v")
        numbers = [memory.number(float(a)) for a in coefficients(tau, zeta, period)]
        x, v = _advance(before, (signal, *numbers))
        memory.keep("v", v)
        return (memory.keep("x", x),)


def _advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """State x and its speed times tau, v, after a row; exact for a signal u that is held over it."""
    u = given[0]
    a11 = given[1]
    a12 = given[2]
    a21 = given[3]
    a22 = given[4]
    off = before[0] - u
    v = before[1]
    return u + (a11 * off + a12 * v), a21 * off + a22 * v


def coefficients(
    tau: Any,
    zeta: Any,
    step: Any,
) -> tuple[Any, Any, Any, Any]:
    """The numbers a11, a12, a21, a22 for a sampling step, of numbers, arrays or duals."""
    h = step / tau
    x = h * h * (zeta * zeta - 1.0)
    swing, turn = decaying_waves(x, zeta * h)
    cross = h * turn
    return swing + zeta * cross, cross, -cross, swing - zeta * cross


def decaying_waves(x: Any, y: Any) -> tuple[Any, Any]:
    """exp(-y) cosh(sqrt x) and exp(-y) sinh(sqrt x) / sqrt x for y >= sqrt x; for x < 0 with a cosine and a sine."""
    values = value_of(x)
    decay = np.exp(-y)
    if np.max(np.abs(values)) < 0.01:
        # Near critical damping the root is nearly zero, and the series has derivatives there.
        even = 1.0
        odd = 1.0
        for k in range(6, 0, -1):
            even = 1.0 + even * x / (2 * k * (2 * k - 1))
            odd = 1.0 + odd * x / (2 * k * (2 * k + 1))
        return decay * even, decay * odd
    if np.max(values) < 0.0:
        root = np.sqrt(-x)
        return decay * np.cos(root), decay * (np.sin(root) / root)
    root = np.sqrt(x)
    slow = np.exp(root - y)  # at most 1, however long the step, and so the other one
    fast = np.exp(-(root + y))
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / root
