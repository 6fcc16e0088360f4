"""Orders of an operator to the loop: 24 bytes each, through a pipe that delivers them whole. ``erc_order`` in C."""

from __future__ import annotations

import struct
import zlib
from enum import IntEnum

_MAGIC = 0x4F435245
_BODY = struct.Struct("<IIdI")
SIZE = _BODY.size + 4


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


def read_order(data: bytes) -> tuple[int, float] | None:
    """Kind and value of an order, or None if it is not whole; the kind may be unknown."""
    if len(data) != SIZE or struct.unpack_from("<I", data, SIZE - 4)[0] != zlib.crc32(data[:-4]):
        return None
    magic, kind, value, _ = _BODY.unpack_from(data)
    return (kind, value) if magic == _MAGIC else None
