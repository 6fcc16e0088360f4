"""Packets between a rig and the loop: 64 bytes, little-endian, over UDP. The same in C: ``live/c/erc_packet.c``.

| byte | type | sensors, rig to loop | command, loop to rig |
| --- | --- | --- | --- |
| 0 | uint32 | 0x31535245 ("ERS1") | 0x31435245 ("ERC1") |
| 4 | uint32 | session: the number both sides were given | the same |
| 8 | uint64 | sequence number: 1, 2, 3, ...; one a sampling period | sequence number: grows |
| 16 | uint64 | time in ns, the rig's clock | time in ns, the loop's clock |
| 24 | float64 | theta in rad | field E1 |
| 32 | float64 | alpha in rad | field E2 |
| 40 | float64 | torque in N m; NaN without a meter | motor torque in N m |
| 48 | uint32 | 1: watchdog holds the fields at zero; 2: fault | 1: the last command, the loop is ending |
| 52 | 8 bytes | zero | zero |
| 60 | uint32 | CRC-32 (zlib, Ethernet) of bytes 0 to 59 | the same |

A rig answers each command with its next sample. If none comes for one and a half periods it goes on by its own clock,
so a rig that only knows its own clock is one, too. No valid command for 15 ms: the rig sets its fields to zero.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

SIZE = 64
SENSOR_MAGIC = 0x31535245
COMMAND_MAGIC = 0x31435245
WATCHDOG, FAULT = 1, 2
LAST = 1

_BODY = struct.Struct("<IIQQdddI8x")
_CRC = struct.Struct("<I")


@dataclass(frozen=True)
class SensorPacket:
    """One sample; see the table above for meanings and units."""

    session: int
    seq: int
    time_ns: int
    theta: float
    alpha: float
    torque: float
    status: int = 0


@dataclass(frozen=True)
class CommandPacket:
    """One command."""

    session: int
    seq: int
    time_ns: int
    field1: float
    field2: float
    motor_torque: float
    flags: int = 0


def _sealed(body: bytes) -> bytes:
    return body + _CRC.pack(zlib.crc32(body))


def _opened(data: bytes, magic: int, session: int) -> tuple[float, ...] | None:
    if len(data) != SIZE or _CRC.unpack_from(data, SIZE - 4)[0] != zlib.crc32(data[: SIZE - 4]):
        return None
    values = _BODY.unpack_from(data)
    return values[2:] if values[0] == magic and values[1] == session else None


def pack_sensors(packet: SensorPacket) -> bytes:
    """A sample as 64 bytes."""
    p = packet
    return _sealed(_BODY.pack(SENSOR_MAGIC, p.session, p.seq, p.time_ns, p.theta, p.alpha, p.torque, p.status))


def pack_command(packet: CommandPacket) -> bytes:
    """A command as 64 bytes."""
    p = packet
    return _sealed(_BODY.pack(COMMAND_MAGIC, p.session, p.seq, p.time_ns, p.field1, p.field2, p.motor_torque, p.flags))


def unpack_sensors(data: bytes, session: int) -> SensorPacket | None:
    """A sample, or None if the packet is not whole, not a sample or of another session."""
    values = _opened(data, SENSOR_MAGIC, session)
    return None if values is None else SensorPacket(session, *values)  # type: ignore[arg-type]


def unpack_command(data: bytes, session: int) -> CommandPacket | None:
    """A command, or None if the packet is not whole, not a command or of another session."""
    values = _opened(data, COMMAND_MAGIC, session)
    return None if values is None else CommandPacket(session, *values)  # type: ignore[arg-type]
