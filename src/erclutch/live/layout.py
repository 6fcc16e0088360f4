"""Layouts that C and Python share, read from their only source, ``c/erc_layout.h``.

This module makes dtypes and constants of them: frames, the ring, samples, commands, orders and settings.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

_HEADER = (Path(__file__).parent / "c" / "erc_layout.h").read_text(encoding="utf-8")
_TYPES = {"uint64_t": "<u8", "uint32_t": "<u4", "int32_t": "<i4", "double": "<f8"}
_STRUCT = re.compile(r"typedef struct \{\n(.*?)\} (\w+);", re.DOTALL)
_MEMBERS = re.compile(r"^ +(\w+) ([\w\[\], ]+);(?: +/\*(?: \[(.+?)\])?)?", re.MULTILINE)
_DEFINED = re.compile(r"#define (\w+) (\w+)")
_ENUMERATED = re.compile(r"(ERC_\w+) = (\w+)(?: << (\d+))?")
_EVENT = re.compile(r"ERC_(\w+) = 1u << \d+,? +/\* (.*?) \*/")


def _constants() -> Iterator[tuple[str, int]]:
    for name, value in _DEFINED.findall(_HEADER):
        yield name, int(value.rstrip("u"), 0)
    for name, value, shift in _ENUMERATED.findall(_HEADER):
        yield name, int(value.rstrip("u")) << int(shift or 0)


#: Numbers that the header names.
CONSTANTS: dict[str, int] = dict(_constants())


def _structs() -> dict[str, tuple[np.dtype[Any], dict[str, str]]]:
    """Each struct of the header: its dtype, and the units of its members."""
    types: dict[str, Any] = dict(_TYPES)
    found: dict[str, tuple[np.dtype[Any], dict[str, str]]] = {}
    for body, struct in _STRUCT.findall(_HEADER):
        fields: list[Any] = []
        units: dict[str, str] = {}
        for kind, names, unit in _MEMBERS.findall(body):
            for member in names.split(", "):
                name, _, length = member.rstrip("]").partition("[")
                count = 0 if not length else CONSTANTS[length] if length in CONSTANTS else int(length)
                if kind == "char":
                    fields.append((name, f"S{count}"))
                else:
                    fields.append((name, types[kind], (count,)) if count else (name, types[kind]))
                units[name] = unit
        types[struct] = np.dtype(fields, align=True)
        found[struct] = types[struct], units
    return found


_FOUND = _structs()
STRUCTS = {name: dtype for name, (dtype, _) in _FOUND.items()}

#: What the loop writes each step.
FRAME = STRUCTS["erc_frame"]
#: Units of the columns of `FRAME`; empty where a number has none.
UNITS = _FOUND["erc_frame"][1]
#: The ring's header. The loop writes what stands from ``head`` on; all else is set when the ring is made.
HEADER = STRUCTS["erc_ring_header"]
#: One reading of a rig's sensors; what the rig is told; what an operator tells the loop.
SAMPLE, COMMAND, ORDER = STRUCTS["erc_sample"], STRUCTS["erc_command"], STRUCTS["erc_order"]
#: What the loop is to do, and one of its programs.
CONFIG, PROGRAM = STRUCTS["erc_config"], STRUCTS["erc_program"]

#: Bits of ``events`` from bit 0 on: name, meaning.
EVENTS: tuple[tuple[str, str], ...] = tuple(
    (name.lower().replace("_", "-"), text) for name, text in _EVENT.findall(_HEADER)
)
EVENT_BITS: dict[str, int] = {name: 1 << i for i, (name, _) in enumerate(EVENTS)}


def sealed(record: np.ndarray[Any, np.dtype[Any]]) -> bytes:
    """The bytes of an order or a configuration, with the checksum of all before it in its last member, ``crc``."""
    record["crc"] = zlib.crc32(record.tobytes()[: -record.dtype["crc"].itemsize])
    return record.tobytes()


def word_places(record: np.dtype[Any], *members: str) -> tuple[int, ...]:
    """Where members of a record begin, in words of 8 bytes."""
    fields: Any = record.fields
    return tuple(fields[name][1] // 8 for name in members)
