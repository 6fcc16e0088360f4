"""A viscometer's log may have the speed of its rotor and the reading of its dial in place of rate and stress.

The factors between them are of the rotor, the bob and the spring, which no file names: the user is asked, with the
factors of the commonest geometry. A Fann 35 with rotor R1, bob B1 and spring F1 (386 dyn cm a degree) shows mPa s at
300 rpm (Fann, Model 35 Viscometer Instruction Manual 208878, 2013): 1.7023 1/s for 1 rpm, 0.511 Pa for 1 degree.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from erclutch.errors import MappingError, listed, shell_word
from erclutch.logs.columns.rheometer_names import plain_name, said_by_name
from erclutch.logs.table import Table

_SPEED = re.compile(
    r"\brpm\b|\brotor speed\b|^speed\b|drehzahl|vitesse de rotation|velocidad de giro|转速|回転|ротор"
)
_TURNS = ("rpm", "r/min", "rev/min", "1/min", "об/мин", "U/min", "tr/min")
_READING = re.compile(
    r"\bdial\b|\breading|deflection|deflex|deflect|\blectura|\bleitura|\btheta\b|θ|读数"
)
#: A reading at one speed of a mud's viscometer: ``R600``, ``Theta 300``, ``6 rpm``.
_AT_A_SPEED = re.compile(
    r"(?:r|theta|teta|θ|φ|phi|dial|fann|l)? ?(600|300|200|100|60|30|6|3)(?: ?rpm)?"
)
_TORQUE = re.compile(r"torque|drehmoment|\bcouple\b|\bpar\b|扭矩|トルク")
_FEWEST_SPEEDS = 3
_RATE_OF_R1_B1 = 1.7023  # 1/s for 1 rpm
_STRESS_OF_R1_B1_F1 = 0.511  # Pa for 1 degree


def a_row_for_each_speed(table: Table) -> Table | None:
    """A table whose rows are readings at the same speeds, turned; None for others.

    Returns:
        A row a speed: the column ``rpm`` in front, then a column for each row of the table, with the name of the row
        (a mud), or ``row 1``, ``row 2``, ...
    """
    at_speeds = _at_speeds(table)
    if not at_speeds:
        return None
    columns = {"rpm": np.array([*at_speeds.values()])}
    names = table.row_names if len(table.row_names) == table.rows else [""] * table.rows
    for row, name in enumerate(names):
        label = name if name and name not in columns else f"{name} row {row + 1}".strip()
        columns[label] = np.array([table.columns[at_speed][row] for at_speed in at_speeds])
    return replace(table, columns=columns, units={}, clock=None, breaks=(), words={}, row_names=())


def _at_speeds(table: Table) -> dict[str, float]:
    """Columns of readings at one speed, with the speed in rpm; none where they are fewer than three."""
    at_speeds: dict[str, float] = {}
    for name in table.columns:
        match = _AT_A_SPEED.fullmatch(plain_name(name))
        if match:
            at_speeds[name] = float(match.group(1))
    return at_speeds if len(at_speeds) >= _FEWEST_SPEEDS else {}


def speed_in_place_of_rate(table: Table) -> MappingError | None:
    """The question where a table has a rotor's speed and no shear rate; None where it has no such speed."""
    at_speeds = _at_speeds(table)
    if at_speeds:
        factors = f"--shear-rate {shell_word(f'[{_RATE_OF_R1_B1} 1/s]')}"
        factors += f" --stress {shell_word(f'[{_STRESS_OF_R1_B1_F1} Pa]')}"
        return MappingError(
            f"each of the columns {listed(list(at_speeds), 6)} is a dial's reading at one speed: a row is a flow curve",
            where=table.name,
            remedy="Give the shear rate of 1 rpm and the stress of 1 degree, such as those of a Fann 35 with R1, B1 "
            f"and F1: {factors}",
        )
    speeds: list[str] = []
    for name in table.columns:
        in_turns = table.units.get(name) in _TURNS
        if in_turns or (_SPEED.search(plain_name(name)) and said_by_name(name) != "rate"):
            speeds.append(name)
    if not speeds:
        return None
    problem = f"no column is the shear rate: {speeds[0]!r} is the speed of a rotor, whose shear rate its geometry tells"
    options = f"--shear-rate {shell_word(f'{speeds[0]} [{_RATE_OF_R1_B1} 1/s]')}"
    geometry = "R1 and B1"
    readings = [name for name in table.columns if _READING.search(plain_name(name))]
    has_values = any(said_by_name(name) in ("stress", "viscosity") for name in table.columns)
    torques = [
        name
        for name in table.columns
        if _TORQUE.search(plain_name(name)) and "%" not in table.label(name)
    ]
    if not readings and not has_values and torques:
        of_geometry = f"--shear-rate {shell_word(f'{speeds[0]} [FACTOR 1/s]')}"
        of_geometry += f" --stress {shell_word(f'{torques[0]} [FACTOR Pa]')}"
        remedy = f"Give the shear rate and the stress that 1 of each stands for in this geometry: {of_geometry}"
        return MappingError(problem, where=table.name, remedy=remedy)
    if not readings and not has_values:
        return MappingError(
            problem, where=table.name, remedy="Give shear rates, and shear stresses or viscosities"
        )
    if readings and not has_values:
        of_each = (shell_word(f"{reading} [{_STRESS_OF_R1_B1_F1} Pa]") for reading in readings)
        options += f" --stress {' '.join(of_each)}"
        geometry = "R1, B1 and F1"
    remedy = f"Give the factors of rotor, bob and spring, such as those of a Fann 35 with {geometry}: {options}"
    return MappingError(problem, where=table.name, remedy=remedy)
