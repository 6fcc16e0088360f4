"""A prefix may be written out in front of its unit: ``CurrentMilliAmps`` is in mA, and ``Force kilo newton`` in kN."""

from __future__ import annotations

import re

_LONGEST = 100  # letters of such a name
_PREFIXES = {"nano": "n", "micro": "u", "milli": "m", "centi": "c", "kilo": "k", "mega": "M"}
_UNITS = (
    (re.compile(r"amp(?:ere)?s?", re.IGNORECASE), "A"),
    (re.compile(r"volts?", re.IGNORECASE), "V"),
    (re.compile(r"newtons?[\W_]?met(?:er|re)s?", re.IGNORECASE), "N*m"),
    (re.compile(r"newtons?", re.IGNORECASE), "N"),
    (re.compile(r"met(?:er|re)s?", re.IGNORECASE), "m"),
    (re.compile(r"pascals?", re.IGNORECASE), "Pa"),
    (re.compile(r"tesla", re.IGNORECASE), "T"),
)
_WRITTEN_OUT = re.compile(
    rf"(?P<name>.*?)[\W_]*(?P<prefix>{'|'.join(_PREFIXES)})[\W_]?(?P<unit>[A-Z][A-Z \W_]{{2,14}})",
    re.IGNORECASE,
)


def split_written_out(name: str) -> tuple[str, str | None]:
    """``Current`` and ``mA`` of ``CurrentMilliAmps``; the whole name and None where no such unit ends it."""
    parts = _WRITTEN_OUT.fullmatch(name) if len(name) <= _LONGEST else None
    if parts is None:
        return name, None
    for written, unit in _UNITS:
        if written.fullmatch(parts["unit"]):
            return parts["name"] or name, _PREFIXES[parts["prefix"].lower()] + unit
    return name, None
