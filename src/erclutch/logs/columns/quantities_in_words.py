"""Which unit is of which quantity, as a word beside the unit names it: ``kN`` of ``force``, ``mA`` of ``coil``."""

from __future__ import annotations

from contextlib import suppress

from erclutch.errors import UnitError
from erclutch.logs.columns.vocabulary import set_of
from erclutch.signals.units import fits

#: Words, and units that their quantities have: of a force the kg of a weight too, which is asked about.
_QUANTITIES = (
    (set_of("force load kraft thrust fuerza forza"), ("N", "kg")),
    (set_of("torque moment drehmoment couple par coppia"), ("N*m",)),
    (set_of("time zeit timestamp temps tiempo tempo elapsed"), ("s",)),
    (set_of("current strom courant corriente corrente coil"), ("A",)),
    (set_of("voltage spannung tension"), ("V",)),
    (set_of("position angle winkel"), ("m", "rad")),
    (set_of("displacement stroke travel weg extension distance hub"), ("m",)),
    (set_of("speed velocity geschwindigkeit omega drehzahl vel"), ("m/s", "rad/s")),
)


def is_of(unit: str, word: str) -> bool:
    """Whether a unit is one of the quantity that a word in small letters means."""
    for words, si_units in _QUANTITIES:
        if word in words:
            with suppress(UnitError):
                return fits(unit, si_units) is not None
    return False
