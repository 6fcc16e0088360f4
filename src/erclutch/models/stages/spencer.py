"""Spencer's modified Bouc-Wen model has a Bouc-Wen element, a dashpot and a spring, in series with another dashpot.

::

    c_1 y' = alpha z + k_0 (x - y) + c_0 (x' - y'),   effort = c_1 y' + k_1 (x - x_0)
    z' = A v - beta |v| |z| z - gamma v |z|**2,   v = x' - y'
    alpha = alpha_a + alpha_b u,   c_0 = c_0a + c_0b u,   c_1 = c_1a + c_1b u

u is the voltage behind a first-order lag. The fit sees ratios, because an effort has one scale. With c = c_1a + c_1b at
the reference field (u = 1), s the strength of the field, z over its end z_max = (A / (beta + gamma))**(1/2), and the
deflection d = x - y, this stage is::

    c_1 = e + (1 - e) s,   c_0 = p + p_b s,   alpha = q + q_b s          all over c; q and q_b are slips
    v = (c_1 w - alpha z - k_0 d) / (c_0 + c_1),   d' = v
    r z' = v (1 - z**2) while v and z agree, v (1 + (2 beta - 1) z**2) while they do not
    column c_1 (w - v), whose gain is c

So c_1a = e c, c_0a = p c, alpha_a z_max = q c, k_0 (published) = k_0 c, r = z_max / A, and beta is the published
beta / (beta + gamma). The lag of the voltage is the stage ``lag`` on the command; k_1 and x_0 are the stage
``stiffness`` and the offset. The published alpha, c_0 and c_1 are linear in the voltage: that is an exponent n of 1.

A step is linearly implicit (trapezoidal), and z is held within -1 and 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.arithmetic.dual import pick
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import follow
from erclutch.models.laws.law import SLIP, VISCOUS, Dimension, Gain, ShapeParameter
from erclutch.models.stages.slip_memory import travel
from erclutch.models.stages.stage import Memory, Place, SlipAndStrength
from erclutch.signals.clock import Clock


@dataclass(frozen=True)
class Spencer:
    """The model's two states as a stage on the slip."""

    name: str = "spencer"
    title: str = "modified Bouc-Wen model"
    source: str = (
        "Spencer, Dyke, Sain and Carlson 1997, doi 10.1061/(ASCE)0733-9399(1997)123:3(230)"
    )
    equation: str = (
        "u = c1 (w - v), d' = v = (c1 w - alpha z - k_y d) / (c0 + c1), r_y z' = v (1 - z^2) while v z > 0, else "
        "v (1 + (2 beta_y - 1) z^2); c1 = e_y + (1 - e_y) y(E), c0 = p_y + p_yb y(E), alpha = q_y + q_yb y(E)"
    )
    place: Place = "slip"
    switches: bool = True
    outputs: tuple[str, ...] = ("u",)
    gains: tuple[Gain, ...] = (
        Gain("c_y", "dashpot in series (c_1) at the reference field", VISCOUS),
    )

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """All but the scale of the effort."""
        none = Dimension()
        rate = Dimension(time=-1)
        small = (1e-3, 1.0)
        slip = (0.01, 3.0)
        yields = "yield effort without field over c_1"
        grows = "growth of the yield effort with the field over c_1"
        return (
            ShapeParameter(
                "e_y", "c_1 without field over c_1", 1e-3, 1.0, none, "log", (0.03, 1.0)
            ),
            ShapeParameter("p_y", "c_0 without field over c_1", 1e-4, 30.0, none, "log", small),
            ShapeParameter(
                "p_yb", "growth of c_0 with the field over c_1", 1e-4, 30.0, none, "log", small
            ),
            ShapeParameter("q_y", yields, 1e-3, 30.0, SLIP, "log", slip),
            ShapeParameter("q_yb", grows, 1e-3, 30.0, SLIP, "log", slip),
            ShapeParameter(
                "k_y", "spring beside the hysteresis over c_1", 1e-3, 1e3, rate, "log", (0.03, 30.0)
            ),
            travel("r_y", "travel over which the hysteresis yields", period),
            ShapeParameter("beta_y", "beta over beta + gamma", 0.5, 5.0, none, "log", (0.55, 2.0)),
        )

    def columns(self, outputs: Sequence[Any], strength: Any) -> tuple[Any, ...]:
        """The effort over that of the dashpot in series: the field is in it."""
        return tuple(outputs)

    def respond(
        self,
        signal: SlipAndStrength,
        clock: Clock,
        q: Sequence[Any],
        rows: slice,
    ) -> list[Any]:
        """The column over all rows; see `Stage`."""
        given = _given(signal, q, clock.steps)
        z, d = follow(_advance, (_yielded(given), 0.0), given, clock)
        return [pick(_effort(z, d, given), rows)]

    def settled(self, signal: SlipAndStrength, q: Mapping[str, float]) -> tuple[Any, ...]:
        """The hysteresis has yielded as far as the slip takes it; the spring counts from zero."""
        given = _given(signal, list(q.values()), 0.0)
        return (_effort(_yielded(given), 0.0, given),)

    def initial(self, signal: SlipAndStrength, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The settled states."""
        given = _given(signal, list(q.values()), 0.0)
        return {"z": _yielded(given), "d": 0.0 * signal.slip}

    def step(
        self,
        memory: Memory,
        signal: SlipAndStrength,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any, ...]:
        """One row."""
        numbers = [memory.number(x) for x in q.values()]
        given = _given(signal, numbers, memory.number(period))
        before = memory.before("z"), memory.before("d")
        z, d = _advance(before, given)
        z = memory.keep("z", z)
        d = memory.keep("d", d)
        return (_effort(z, d, given),)


def _given(signal: SlipAndStrength, q: Sequence[Any], step: Any) -> tuple[Any, ...]:
    """What a row brings: the slip, the step, c_0, c_1, alpha, k_0, r and beta - gamma."""
    e, p, p_b, q_0, q_b, k_0, r, beta = q
    s = signal.strength
    c_0 = p + p_b * s
    c_1 = e + (1.0 - e) * s
    alpha = q_0 + q_b * s
    against = 2.0 * beta - 1.0
    return signal.slip, step, c_0, c_1, alpha, k_0, r, against


def _yielded(given: tuple[Any, ...]) -> Any:
    """The z at which the hysteresis carries the effort of the slip, at most 1."""
    w, _, _, c_1, alpha, _, _, _ = given
    z = (c_1 * w) / alpha
    held = less_select(z, 1.0, z, 1.0)
    return less_select(-1.0, held, held, -1.0)


def _effort(z: Any, d: Any, given: tuple[Any, ...]) -> Any:
    """The effort c_1 (w - v) over c, by the equation of v."""
    w, _, c_0, c_1, alpha, k_0, _, _ = given
    return c_1 * (((alpha * z + c_0 * w) + k_0 * d) / (c_0 + c_1))


def _advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """Both states after a step: rates, their derivatives, and Cramer's rule for the implicit part."""
    # By places and one a line: the step is also compiled, from this text, by Numba.
    z = before[0]
    d = before[1]
    w = given[0]
    step = given[1]
    c_0 = given[2]
    c_1 = given[3]
    alpha = given[4]
    k_0 = given[5]
    r = given[6]
    against = given[7]

    # The rates: v = d', and left = z' / v, which loses by how far z has yielded.
    total = c_0 + c_1
    a = alpha / total
    k = k_0 / total
    v = ((c_1 * w - alpha * z) - k_0 * d) / total
    pull = less_select(z * v, 0.0, -against, 1.0) * (z * z)
    left = (1.0 - pull) / r
    bend = (
        less_select(z * v, 0.0, against, 1.0)
        * less_select(z, 0.0, -z, z)
        * less_select(v, 0.0, -v, v)
    )

    # The matrix 1 - (step / 2) times the derivatives of both rates by z and d.
    half = 0.5 * step
    m11 = 1.0 + half * (a * left + 2.0 * bend / r)
    m12 = half * (k * left)
    m21 = half * a
    m22 = 1.0 + half * k
    move = (step * v) / (m11 * m22 - m12 * m21)
    after = z + move * (left * m22 - m12)
    held = less_select(after, 1.0, after, 1.0)
    return less_select(-1.0, held, held, -1.0), d + move * (m11 - m21 * left)


STAGE = Spencer()
