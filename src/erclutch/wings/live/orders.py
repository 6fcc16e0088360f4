"""Orders of an operator to the loop, through a pipe that delivers each of them whole."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from erclutch.wings.live.layout import CONSTANTS, ORDER, sealed


class Order(IntEnum):
    """What the loop can be told. The loop checks each order again and counts what it refuses."""

    STOP = CONSTANTS["ERC_ORDER_STOP"]  # end at zero field
    ZERO = CONSTANTS["ERC_ORDER_ZERO"]  # fields to zero until a reset
    RESET = CONSTANTS["ERC_ORDER_RESET"]  # clear a trip, if the sensors are there; nothing moves
    # Its value is the number of the program to run; refused while tripped.
    PROGRAM = CONSTANTS["ERC_ORDER_PROGRAM"]
    # Its value is a motor torque in N m, in place of the program's.
    MOTOR = CONSTANTS["ERC_ORDER_MOTOR"]


def order_bytes(order: Order, value: float = 0.0) -> bytes:
    """An order as the loop reads it."""
    data = np.zeros((), ORDER)
    data["magic"] = CONSTANTS["ERC_ORDER_MAGIC"]
    data["kind"] = order
    data["value"] = value
    return sealed(data)
