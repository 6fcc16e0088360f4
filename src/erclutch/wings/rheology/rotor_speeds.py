"""A viscometer's log may have the speed of its rotor and the reading of its dial in place of rate and stress.

The factors between them are of the rotor, the bob and the spring, which no file names: the user is asked, with the
factors of the commonest geometry. A Fann 35 with rotor R1, bob B1 and spring F1 (386 dyn cm a degree) shows mPa s at
300 rpm (Fann, Model 35 Viscometer Instruction Manual 208878, 2013): 1.7023 1/s for 1 rpm, 0.511 Pa for 1 degree.
"""

from __future__ import annotations

import re

from erclutch.errors import MappingError, shell_word
from erclutch.logs.rheometer_names import plain_name, said_by_name
from erclutch.logs.table import Table

_SPEED = re.compile(r"\brpm\b|\brotor speed\b|^speed\b|drehzahl|vitesse de rotation|velocidad de giro|转速|回転|ротор")
_TURNS = ("rpm", "r/min", "rev/min", "1/min", "об/мин", "U/min", "tr/min")
_READING = re.compile(r"\bdial\b|\breading|deflection|deflex|deflect|\blectura|\bleitura|\btheta\b|θ|读数")
_RATE_OF_R1_B1 = 1.7023  # 1/s for 1 rpm
_STRESS_OF_R1_B1_F1 = 0.511  # Pa for 1 degree


def speed_in_place_of_rate(table: Table) -> MappingError | None:
    """The question where a table has a rotor's speed and no shear rate; None where it has no such speed."""
    speeds = [name for name in table.columns if _is_speed(table, name)]
    if not speeds:
        return None
    options = f"--shear-rate {shell_word(f'{speeds[0]} [{_RATE_OF_R1_B1} 1/s]')}"
    geometry = "R1 and B1"
    readings = [name for name in table.columns if _READING.search(plain_name(name))]
    if readings and not any(said_by_name(name) == "stress" for name in table.columns):
        options += f" --stress {shell_word(f'{readings[0]} [{_STRESS_OF_R1_B1_F1} Pa]')}"
        geometry = "R1, B1 and F1"
    return MappingError(
        f"no column is the shear rate: {speeds[0]!r} is the speed of a rotor, whose shear rate its geometry tells",
        where=table.name,
        remedy=f"Give the factors of rotor, bob and spring, such as those of a Fann 35 with {geometry}: {options}",
    )


def _is_speed(table: Table, name: str) -> bool:
    is_named = _SPEED.search(plain_name(name)) is not None
    return (is_named or table.units.get(name) in _TURNS) and said_by_name(name) != "rate"
