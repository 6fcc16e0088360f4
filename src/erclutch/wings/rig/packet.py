"""Packets between a rig and the loop have 64 bytes, little-endian, and go over UDP.

The table of bytes is in ``docs/live.md``; ``live/c/erc_packet.c`` is the same in C.

A rig answers each command with its next sample. If none comes for one and a half periods it goes on by its own clock,
so a rig that only knows its own clock is one, too. No valid command for 15 ms: the rig sets its fields to zero.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Any

from erclutch.signals.device import DeviceName

SIZE = 64
SENSOR_MAGIC = 0x31535245
COMMAND_MAGIC = 0x31435245
WATCHDOG, FAULT = 1, 2
LAST = 1

#: Numbers of the devices in packets.
NUMBERS: dict[DeviceName, int] = {"coaxial": 0, "single": 1}
_BODY = struct.Struct("<IIQQdddII4x")
_CRC = struct.Struct("<I")


@dataclass(frozen=True)
class SensorPacket:
    """One sample; its numbers are those of ``erc_sample`` in ``live/c/erc_layout.h``.

    A single device has its position in theta, the position of its other side in alpha (0: it stands still), and its
    effort in torque, in SI units.
    """

    session: int
    seq: int
    time_ns: int
    theta: float
    alpha: float
    torque: float
    status: int = 0
    device: int = 0


@dataclass(frozen=True)
class CommandPacket:
    """One command; a single device has its field in field1, and the command of a drive in motor_torque."""

    session: int
    seq: int
    time_ns: int
    field1: float
    field2: float
    motor_torque: float
    flags: int = 0
    device: int = 0


def _sealed(magic: int, packet: SensorPacket | CommandPacket) -> bytes:
    body = _BODY.pack(magic, *vars(packet).values())
    return body + _CRC.pack(zlib.crc32(body))


def _opened(data: bytes, magic: int, session: int) -> Any:
    """What a packet holds after its magic number; None if it is not whole, of another kind or another session."""
    if len(data) != SIZE:
        return None
    (checksum,) = _CRC.unpack_from(data, SIZE - 4)
    if checksum != zlib.crc32(data[: SIZE - 4]):
        return None
    own_magic, *values = _BODY.unpack_from(data)
    own_session = values[0]
    return values if own_magic == magic and own_session == session else None


def pack_sensors(packet: SensorPacket) -> bytes:
    """A sample as 64 bytes."""
    return _sealed(SENSOR_MAGIC, packet)


def pack_command(packet: CommandPacket) -> bytes:
    """A command as 64 bytes."""
    return _sealed(COMMAND_MAGIC, packet)


def unpack_sensors(data: bytes, session: int) -> SensorPacket | None:
    """A sample, or None if the packet is not whole, not a sample or of another session."""
    values = _opened(data, SENSOR_MAGIC, session)
    return values and SensorPacket(*values)


def unpack_command(data: bytes, session: int) -> CommandPacket | None:
    """A command, or None if the packet is not whole, not a command or of another session."""
    values = _opened(data, COMMAND_MAGIC, session)
    return values and CommandPacket(*values)
