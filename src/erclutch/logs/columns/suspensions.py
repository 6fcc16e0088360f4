"""A damper between a body and a wheel moves by what they differ: ``dz_s`` and ``dz_u``, sprung and unsprung speed.

Either of them alone is no slip of the damper.
"""

from __future__ import annotations

import re

from erclutch.logs.columns.labels import without_unit
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.seen_columns import unit_fits
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.table import Table

#: What the mass above a spring is called, and the mass below.
_SPRUNG = set_of("sprung body chassis aufbau karosserie caisse carroceria 车身 簧上 车体 s b")
_UNSPRUNG = set_of("unsprung wheel axle tire tyre rad achse roue rueda 车轮 簧下 us u w")
_RATES = set_of(
    "v vz dx dy dz xd yd zd xdot ydot zdot dxdt dzdt dot vel velo velocity speed geschwindigkeit vitesse "
    "velocidad 速度"
)
_PLACES = set_of("x y z disp displacement position pos travel weg deplacement desplazamiento 位移")

_BESIDE = set_of("mass masse masa vertical 质量 of the")
#: A letter of a motion with the letter of a mass behind it: zs, xus, dzs, zsdot, vs.
_JOINED = re.compile(r"(d?[xyz]|v)(s|us|u|b|w)(dot|d)?")
_WORDS_WITHIN = re.compile(r"车身|簧上|车体|车轮|簧下|速度|位移|质量")


def ends_of_a_suspension(
    table: Table, signal: str, si_units: tuple[str, ...]
) -> tuple[str, str] | None:
    """The motions of the sprung and of the unsprung mass, by their names; None for no or several pairs.

    Args:
        table: a log.
        signal: slip for their speeds, position for their positions.
        si_units: of that signal.
    """
    above: dict[tuple[frozenset[str], str | None], list[str]] = {}  # by the other words, and unit
    below: dict[tuple[frozenset[str], str | None], list[str]] = {}
    for name in table.columns:
        unit = table.units.get(name)
        if unit and unit_fits(name, unit, si_units) is False:
            continue
        words: set[str] = set()  # those that are written together apart: z, s and dot of zs_dot
        for word in words_of(without_unit(name, unit)):
            joined = _JOINED.fullmatch(word)
            within = _WORDS_WITHIN.findall(word)
            if joined:
                words |= {part for part in joined.groups() if part}
            elif within and "".join(within) == word:
                words |= {*within}
            else:
                words.add(word)
        for masses, speeds in ((_SPRUNG, above), (_UNSPRUNG, below)):
            own = words & masses
            besides = frozenset(words - masses - _BESIDE)
            is_rate = not besides.isdisjoint(_RATES)
            is_of_kind = is_rate if signal == "slip" else bool(besides) and not is_rate
            if len(own) == 1 and is_of_kind and besides <= _RATES | _PLACES:
                speeds.setdefault((besides, unit), []).append(name)
    pairs: list[tuple[str, str]] = []
    for what in above.keys() & below.keys():
        pairs += [(sprung, unsprung) for sprung in above[what] for unsprung in below[what]]
    return pairs[0] if len(pairs) == 1 else None
