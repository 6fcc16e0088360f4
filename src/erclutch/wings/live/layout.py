"""Layouts that C and Python share, read from their only source, ``c/erc_layout.h``.

This module makes dtypes and constants of them: frames, the ring, samples, commands, orders and settings.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.signals.channels import LiveChannel

_C = Path(__file__).parent / "c"
_SETTINGS = (_C / "erc_settings.h").read_text(encoding="utf-8")
_SETTING = re.compile(r"ERC_SETTING\((\w+), (\w+)\) +/\* (?:\[(.*?)\] )?(.*?) \*/")
#: The layout, with the members that its settings are.
_LAYOUT = (_C / "erc_layout.h").read_text(encoding="utf-8")
_HEADER = _LAYOUT.replace('#include "erc_settings.h"\n', _SETTING.sub(r"    double \2;", _SETTINGS))
_TYPES = {"uint64_t": "<u8", "uint32_t": "<u4", "int32_t": "<i4", "double": "<f8"}
_STRUCT = re.compile(r"typedef struct \{\n(.*?)\} (\w+);", re.DOTALL)
_MEMBERS = re.compile(r"^ +(\w+) ([\w\[\], ]+);", re.MULTILINE)
_DEFINED = re.compile(r"#define (\w+) (0x\w+u|\d+u)\b")
_ENUMERATED = re.compile(r"(ERC_\w+) = (\w+)(?: << (\d+))?")
_EVENT = re.compile(r"ERC_(\w+) = 1u << \d+,? +/\* (.*?) \*/")


#: Numbers that the header names.
CONSTANTS: dict[str, int] = {
    **{name: int(value.rstrip("u"), 0) for name, value in _DEFINED.findall(_HEADER)},
    **{
        name: int(value.rstrip("u")) << int(shift or 0)
        for name, value, shift in _ENUMERATED.findall(_HEADER)
    },
}


def _structs() -> dict[str, np.dtype[Any]]:
    """Each struct of the header as a dtype."""
    types: dict[str, Any] = dict(_TYPES)  # a struct may have others as members
    structs: dict[str, np.dtype[Any]] = {}
    for body, struct in _STRUCT.findall(_HEADER):
        fields: list[Any] = []
        for kind, names in _MEMBERS.findall(body):
            for member in names.split(", "):
                name, _, length = member.rstrip("]").partition("[")
                # 0: no array.
                count = CONSTANTS[length] if length in CONSTANTS else int(length or 0)
                if kind == "char":
                    fields.append((name, f"S{count}"))
                elif count:
                    fields.append((name, types[kind], (count,)))
                else:
                    fields.append((name, types[kind]))
        structs[struct] = np.dtype(fields, align=True)
        types[struct] = structs[struct]
    return structs


STRUCTS = _structs()


@dataclass(frozen=True)
class SettingNote:
    """What ``c/erc_settings.h`` says of a setting.

    Attributes:
        kind: ABOVE_ZERO, FROM_ZERO or SIGNED.
        unit: as written there; empty where it has none, or that of the device.
        meaning: for people.
    """

    kind: str
    unit: str
    meaning: str

    @property
    def least(self) -> float:
        """The smallest that it may be."""
        return {"ABOVE_ZERO": LEAST, "FROM_ZERO": 0.0, "SIGNED": -MOST}[self.kind]

    @property
    def wanted(self) -> str:
        """How it may be, in words."""
        least = {
            "ABOVE_ZERO": "a number above 0",
            "FROM_ZERO": "0 or a number above",
            "SIGNED": "a finite number",
        }
        return f"{least[self.kind]}, at most {MOST:g}"


#: The numbers that a loop is set by, in the order of the configuration.
SETTINGS: dict[str, SettingNote] = {
    name: SettingNote(kind, unit, meaning)
    for kind, name, unit, meaning in _SETTING.findall(_SETTINGS)
}
#: No setting is larger, and none that has to be above zero is smaller.
MOST = float(re.findall(r"#define ERC_MOST (\S+)", _HEADER)[0])
LEAST = float(re.findall(r"#define ERC_LEAST (\S+)", _HEADER)[0])

#: What the loop writes each step, under the names that its C has; `frames_of` gives the names of a device.
FRAME = STRUCTS["erc_frame"]
#: The ring's header. The loop writes what stands from ``head`` on; all else is set when the ring is made.
HEADER = STRUCTS["erc_ring_header"]
#: One reading of a rig's sensors.
SAMPLE = STRUCTS["erc_sample"]
#: What the rig is told.
COMMAND = STRUCTS["erc_command"]
#: What an operator tells the loop.
ORDER = STRUCTS["erc_order"]
#: What the loop is to do.
CONFIG = STRUCTS["erc_config"]
#: One of its programs.
PROGRAM = STRUCTS["erc_program"]

#: Bits of ``events`` from bit 0 on: name, meaning.
EVENTS: tuple[tuple[str, str], ...] = tuple(
    (name.lower().replace("_", "-"), meaning) for name, meaning in _EVENT.findall(_HEADER)
)
EVENT_BITS: dict[str, int] = {name: 1 << bit for bit, (name, _) in enumerate(EVENTS)}


def frames_of(channels: Sequence[LiveChannel]) -> np.dtype[Any]:
    """A frame as a device has it: the bytes of `FRAME`, its numbers under the names of the channels.

    Raises:
        ValueError: a channel that no frame can have.
    """
    members: Any = FRAME.fields
    slots = [name for name in FRAME.names or () if FRAME[name] == np.float64]
    if any(channel.slot not in slots for channel in channels) or not channels:
        raise ValueError(f"channels {[channel.slot for channel in channels]} of {slots}")
    first = ["seq", "time_ns"]
    last = ["flags", "events", "lateness_ns", "step_ns"]
    names = [*first, *(channel.name for channel in channels), *last]
    places = [*first, *(channel.slot for channel in channels), *last]
    formats = [members[place][0] for place in places]
    offsets = [members[place][1] for place in places]
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": FRAME.itemsize}
    )


def sealed(record: np.ndarray[Any, np.dtype[Any]]) -> bytes:
    """The bytes of an order or a configuration, with the checksum of all before it in its last member, ``crc``."""
    before = record.tobytes()[: -record.dtype["crc"].itemsize]
    record["crc"] = zlib.crc32(before)
    return record.tobytes()


def word_places(record: np.dtype[Any], *members: str) -> tuple[int, ...]:
    """Where members of a record begin, in words of 8 bytes."""
    fields: Any = record.fields
    return tuple(fields[name][1] // 8 for name in members)
