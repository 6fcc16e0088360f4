"""Memories of the slip share this: their outputs are columns, without field and times the strength of the field."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import sign_of
from erclutch.models.laws.law import EFFORT, VISCOUS, Dimension, Gain, Part, ShapeParameter
from erclutch.models.stages.stage import Place, SlipAndStrength

TRAVEL = Dimension(slip=1, time=1)
#: Travels, over the reference slip in s, between which the states of a scan lie.
_USUAL = (3.0, 600.0)  # sampling periods
_LONGEST = 10.0  # s at the reference slip, and of a slow log what is usual


@dataclass(frozen=True)
class SlipMemory:
    """Outputs, columns and gains of a stage on the slip.

    Attributes:
        name, title, source: see `Stage`.
        outputs: names of the outputs.
        meanings: what the gain of each output is.
        equation: see `Stage`.
        ahead: whether the field enters ahead of the memory; then an output is one column, else two.
        damping: the outputs that are slips, with a viscous gain.
    """

    name: str
    title: str
    source: str
    outputs: tuple[str, ...]
    meanings: tuple[str, ...]
    equation: str
    ahead: bool = False
    damping: tuple[str, ...] = ()
    place: Place = "slip"
    switches: bool = True

    @property
    def gains(self) -> tuple[Gain, ...]:
        """Effort of each output, without field and with it."""
        gains: list[Gain] = []
        named = list(zip(self.outputs, self.meanings, strict=True))
        if not self.ahead:
            for output, meaning in named:
                gains.append(self._gain(output, "", f"{meaning} without field"))
        for output, meaning in named:
            gains.append(self._gain(output, "y", f"{meaning} at the reference field", "yield"))
        return tuple(gains)

    def _gain(
        self,
        output: str,
        ending: str,
        meaning: str,
        part: Part | None = None,
    ) -> Gain:
        if output in self.damping:
            return Gain(f"T_{output}{ending}", meaning, VISCOUS, part="viscous")
        return Gain(f"T_{output}{ending}", meaning, EFFORT, part=part)

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The outputs, and the outputs times the strength of the field where that is not in them yet."""
        if self.ahead:
            return tuple(outputs)
        with_field = [strength * output for output in outputs]
        return (*outputs, *with_field)

    def aim(self, signal: SlipAndStrength) -> Any:
        """Where a state yields in the way of the slip."""
        way = sign_of(signal.slip)
        return way * signal.strength if self.ahead else way

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """All states have yielded in the way of the slip."""
        return (self.aim(signal),) * len(self.outputs)

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The settled states, by the names of the outputs."""
        return dict(zip(self.outputs, self.settled(signal, q), strict=True))


def travel(name: str, meaning: str, period: float) -> ShapeParameter:
    """A travel as a parameter."""
    shortest, longest = _USUAL[0] * period, _USUAL[1] * period
    upper = max(_LONGEST, longest)
    return ShapeParameter(name, meaning, 0.1 * period, upper, TRAVEL, "log", (shortest, longest))


def travels(
    name: str,
    meaning: str,
    period: float,
    count: int,
) -> tuple[ShapeParameter, ...]:
    """Travels of equal parts of a memory; a scan looks for them in neighbouring parts of the usual range."""
    shortest = _USUAL[0] * period
    longest = _USUAL[1] * period
    ends = np.geomspace(shortest, longest, count + 1).tolist()
    of_parts: list[ShapeParameter] = []
    for i, part in enumerate(itertools.pairwise(ends), start=1):
        whole = travel(name.format(i), meaning.format(i), period)
        of_parts.append(replace(whole, usual=part))
    return tuple(of_parts)
