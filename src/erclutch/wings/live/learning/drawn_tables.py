"""Tables of fields and drive for a round of `learn`: blocks of the paper's draws, each with another character."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.wings.rig.twin.excitation import (
    FieldSettings,
    both_ways_torque,
    field_sequence,
    torque_sequence,
)

_BLOCK = 2.0  # s of one character
_REST = 0.3  # s at the end, without field and drive
_WITHOUT_FIELD = 0.2  # share of the blocks, for the friction
_LEAST_LEVEL = 0.15  # of the drive
_RATED = 0.30  # N m: the most of `both_ways_torque`
_PAIR = (0.05, 0.10)  # N m: the motor of a pair


@dataclass(frozen=True)
class TableLimits:
    """What a table may ask for.

    Attributes:
        device: a pair has two fields, one at a time.
        field: largest field.
        drive: largest torque of the drive in N m; 0: the loop commands no drive.
        rate: rows a second.
    """

    device: DeviceName
    field: float
    drive: float
    rate: float


def drawn_table(
    limits: TableLimits,
    seconds: float,
    rng: np.random.Generator,
    level: float = 1.0,
) -> Array:
    """A table of two fields and the drive, shape (rows, 3), that ends at rest.

    Args:
        limits: what it may ask for.
        seconds: length.
        rng: random numbers; the same ones give the same table.
        level: the most of the drive that a block draws, as a share.
    """
    rows = round(seconds * limits.rate)
    block = round(_BLOCK * limits.rate)  # rows
    fastest = min(100.0, 0.25 * limits.rate)  # Hz
    blocks: list[Array] = []
    for start in range(0, rows, block):
        length = min(block, rows - start)

        # The character of a block: how much field, how fast, how much drive.
        settings = FieldSettings(
            largest=limits.field,
            lowest=fastest * 0.005 * 10.0 ** rng.uniform(0.0, 1.0),
            highest=fastest * 10.0 ** rng.uniform(-1.0, 0.0),
            peakedness=rng.uniform(0.7, 2.5),
            sines=rng.random(),
        )
        field = field_sequence(length, rng, settings, limits.rate)
        if rng.random() < _WITHOUT_FIELD:
            field = np.zeros(length)
        share = level * rng.uniform(_LEAST_LEVEL, 1.0)

        if limits.device == "single":
            rated_share = min(1.0, limits.drive / _RATED)
            drive = share * rated_share * both_ways_torque(length, rng)
            blocks.append(np.column_stack([np.abs(field), np.zeros(length), drive]))
        else:
            largest_share = limits.drive / _PAIR[1]
            drive = min(share * 2.0, largest_share) * torque_sequence(length, rng, *_PAIR)
            first = np.maximum(field, 0.0)
            second = np.maximum(-field, 0.0)
            blocks.append(np.column_stack([first, second, drive]))
    table = np.concatenate(blocks)
    still = min(rows // 2, round(_REST * limits.rate))
    table[rows - still :] = 0.0
    return table
