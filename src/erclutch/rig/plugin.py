"""Rigs by name: what the product brings, and hardware that users plug in through the entry point ``erclutch.rigs``.

A plug-in is a function of no arguments that returns a `UdpRig` (somebody else's controller speaks the packets of
`erclutch.rig.packet`) or a `LibraryRig` (a shared library with the functions of ``live/c/erc_rig.h``). No Python of it
runs between sensor and field.
"""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path

from erclutch.errors import SettingError

GROUP = "erclutch.rigs"


@dataclass(frozen=True)
class UdpRig:
    """A rig that speaks the packets.

    Attributes:
        name: for people.
        host, port: IPv4 address and UDP port of the rig.
        session: number that both sides put into each packet.
        local_port: port that the loop sends from; 0 for any.
    """

    name: str
    host: str
    port: int
    session: int = 0
    local_port: int = 0

    def __post_init__(self) -> None:
        try:
            ipaddress.IPv4Address(self.host)
        except ValueError as error:
            raise SettingError(
                f"{self.host!r} is no IPv4 address", remedy="Give the rig as numbers, for example 192.168.1.10:5005"
            ) from error
        if not 0 < self.port < 65536 or not 0 <= self.local_port < 65536 or not 0 <= self.session < 1 << 32:
            raise SettingError(
                f"port {self.port}, local port {self.local_port}, session {self.session}",
                remedy="Give ports from 1 to 65535 and a session from 0 to 2^32 - 1",
            )


@dataclass(frozen=True)
class LibraryRig:
    """A rig behind a shared library that the loop loads.

    Attributes:
        name: for people.
        path: of the library.
        options: text that the library's open function gets.
    """

    name: str
    path: Path
    options: str = ""


def hardware(name: str) -> UdpRig | LibraryRig:
    """The plug-in of a name.

    Raises:
        SettingError: there is none, it fails, or it returns something else.
    """
    found = {point.name: point for point in entry_points(group=GROUP)}
    if name not in found:
        known = ", ".join(["twin", "replay", "udp", *sorted(found)])
        raise SettingError(f"there is no rig {name!r}", remedy=f"Choose one of {known}")
    try:
        rig = found[name].load()()
    except Exception as error:  # a plug-in is somebody else's code: whatever it raises is told, not shown as our crash
        raise SettingError(
            f"the rig {name!r} failed: {type(error).__name__}: {error}", remedy="Ask its author, or choose another rig"
        ) from error
    if not isinstance(rig, UdpRig | LibraryRig):
        raise SettingError(
            f"the rig {name!r} is a {type(rig).__name__}", remedy="It must return a UdpRig or a LibraryRig"
        )
    return rig


def udp_rig(text: str, session: int = 0) -> UdpRig:
    """A rig from HOST:PORT.

    Raises:
        SettingError: it is not of that form.
    """
    host, colon, port = text.rpartition(":")
    if not colon or not port.isdecimal():
        raise SettingError(f"{text!r} is no address of a rig", remedy="Give HOST:PORT, for example 192.168.1.10:5005")
    return UdpRig(text, host, int(port), session)
