"""The field in the fluid stays behind a command that turns, as the iron of a magnet does; the pace does not matter.

::

    m_i = clip(m_i before, u - i r_h / N, u + i r_h / N),   i = 1 .. N        remanence-N
    E = u + s_h ((m_1 + ... + m_N) / N - u)

Each m is a play operator: it moves only once the command has gone its way to the edge. A command that comes back to
zero leaves s_h times the mean of their edges in the iron. Noise of a measured current that is smaller than the edges
moves nothing, which is why these are plays and not states that forget with every step of the command.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.play import play
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, StageFamily
from erclutch.signals.clock import Clock

#: Plays of the name alone: one has a corner that iron has not, and each further one costs two choices a row.
_USUAL = 2
_FIELD = Dimension(field=1)


@dataclass(frozen=True)
class Remanence:
    """The play operators as a stage.

    Attributes:
        name, title, equation: see `Stage`.
        plays: how many operators there are.
    """

    name: str
    title: str
    equation: str
    plays: int
    source: str = "Prandtl and Ishlinskii's plays for magnets: a review is doi 10.3390/ma16062422"
    place: Place = "command"
    switches: bool = False
    #: Iron saturates too: a search tries the stage beside a yield effort that does, for either shows little by itself.
    of_iron: bool = True

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The widest edge, and how much of the field stays behind."""
        edge = "by how much a command turns before the last of the field follows"
        share = "share of the field that stays behind a command that turns"
        return (
            ShapeParameter("r_h", edge, 1e-3, 1.0, _FIELD, "log", (0.02, 0.6)),
            ShapeParameter("s_h", share, 0.0, 1.0),
        )

    def edges(self, widest: Any) -> list[Any]:
        """How far the command is from each play when it begins to move."""
        return [widest * (place / self.plays) for place in range(1, self.plays + 1)]

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> Any:
        """The field over all rows; see `Stage`.

        What stays behind hangs on the command alone where the stage stands ahead of a lag: there the search for the
        lag's numbers meets no corners.
        """
        widest, share = q
        plays = [play(signal, edge, clock) for edge in self.edges(widest)]
        field = _behind(signal, plays, share / self.plays, float(self.plays))
        return pick(field, rows)

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """Nothing stays behind the first command: what was before it is not known."""
        return {f"play{place}": signal for place in range(1, self.plays + 1)}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any]:
        """One row of each play."""
        plays: list[Any] = []
        for place, edge in enumerate(self.edges(q["r_h"]), start=1):
            name = f"play{place}"
            margin = memory.number(edge)
            low = signal - margin
            high = signal + margin
            before = memory.before(name)
            lifted = less_select(before, low, low, before)
            plays.append(memory.keep(name, less_select(high, lifted, high, lifted)))
        share = memory.number(q["s_h"] / self.plays)
        return (_behind(signal, plays, share, memory.number(float(self.plays))),)


def _behind(command: Any, plays: Sequence[Any], share: Any, count: Any) -> Any:
    """The field behind a command: of each play a share of what it is away."""
    together = plays[0]
    for further in plays[1:]:
        together = together + further
    return command + share * (together - command * count)


def _remanence(count: int, forms: tuple[str, ...]) -> Remanence:
    places = range(1, count + 1)
    edges = [f"u - {i} r_h / {count} and u + {i} r_h / {count}" for i in places]
    plays = [f"m{i} within {edge}" for i, edge in zip(places, edges, strict=True)]
    together = " + ".join(f"m{i}" for i in places)
    return Remanence(
        name="remanence" if count == _USUAL else f"remanence-{count}",
        title=f"remanence of the field with {count} play operator{'s' if count > 1 else ''}",
        equation=f"E = u + s_h (({together}) / {count} - u), {', '.join(plays)}",
        plays=count,
    )


STAGE = StageFamily(_remanence, count=_USUAL, ladder=("remanence",), edge="r_h")
