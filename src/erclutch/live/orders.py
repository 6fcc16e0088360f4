"""Orders of an operator to the loop: 24 bytes each, through a pipe that delivers them whole. ``erc_order`` in C."""

from __future__ import annotations

import struct
import zlib
from enum import IntEnum

_MAGIC = 0x4F435245
_BODY = struct.Struct("<IIdI")


class Order(IntEnum):
    """What the loop can be told. The loop checks each again and counts what it refuses."""

    STOP = 1  # end at zero field
    ZERO = 2  # fields to zero until a reset
    RESET = 3  # out of a trip, if the sensors are there
    PROGRAM = 4  # value: number of the program
    MOTOR = 5  # value: motor torque in N m in place of the program's


def order_bytes(order: Order, value: float = 0.0) -> bytes:
    """An order as the loop reads it."""
    body = _BODY.pack(_MAGIC, order, value, 0)
    return body + struct.pack("<I", zlib.crc32(body))
