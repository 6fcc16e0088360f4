"""Users plug in rigs through the entry point ``erclutch.rigs``.

A plug-in is a function of no arguments that returns a `UdpRig` (somebody else's controller speaks the packets of
`erclutch.wings.rig.packet`) or a `LibraryRig` (a shared library with the functions of ``live/c/erc_rig.h``). No Python
of it runs between sensor and field.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from erclutch import registry
from erclutch.errors import SettingError
from erclutch.signals.channels import NamedChannels, named
from erclutch.signals.device import DEVICES, DeviceName

GROUP = "erclutch.rigs"


@dataclass(frozen=True, kw_only=True)
class RigDevice:
    """What hangs on a rig.

    Attributes:
        device: "coaxial", or "single": one brake, clutch or damper.
        channels: what the rig calls the channels that it has, with their units in SI: ``{"position": "wheel angle
            [rad]", "effort": "brake torque [N*m]", "field": "coil current [A]", "drive": "motor torque [N*m]"}`` of a
            single device, of which effort and drive may be missing; theta, alpha, torque, field1, field2 and
            motor_torque of the pair. None: those of the device, with the model's units.
        field_limit: largest field of its supply, in the unit of its field; None: that of the rig file.

    Raises:
        SettingError: an unknown device or channel, another unit than SI, or a limit that is none.
    """

    origin: ClassVar[str] = "HARDWARE"
    device: DeviceName = "coaxial"
    channels: Mapping[str, str] = field(default_factory=dict[str, str])
    field_limit: float | None = None

    def __post_init__(self) -> None:
        if self.device not in DEVICES:
            raise SettingError(
                f"device {self.device!r}", remedy=f"Give one of {', '.join(DEVICES)}"
            )
        _ = self.named
        if self.field_limit is not None and not 0.0 < self.field_limit < float("inf"):
            raise SettingError(
                f"a field limit of {self.field_limit}", remedy="Give a number above zero"
            )

    @property
    def named(self) -> NamedChannels | None:
        """Its channels, read; None where it names none."""
        return named(self.device, self.channels) if self.channels else None


@dataclass(frozen=True)
class UdpRig(RigDevice):
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
        super().__post_init__()
        try:
            ipaddress.IPv4Address(self.host)
        except ValueError as error:
            remedy = "Give the rig as numbers, for example 192.168.1.10:5005"
            raise SettingError(f"{self.host!r} is no IPv4 address", remedy=remedy) from error
        ports_fit = 0 < self.port < 65536 and 0 <= self.local_port < 65536
        if not ports_fit or not 0 <= self.session < 1 << 32:
            given = f"port {self.port}, local port {self.local_port}, session {self.session}"
            raise SettingError(
                given, remedy="Give ports from 1 to 65535 and a session from 0 to 2^32 - 1"
            )


@dataclass(frozen=True)
class LibraryRig(RigDevice):
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
    """The rig of a plug-in's name.

    Raises:
        SettingError: there is none (PluginError: it fails, or it returns something else).
    """
    if name not in registry.names(GROUP):
        plugins = registry.plugins(GROUP)
        # Ours are listed first, each at its place.
        ours = [plugin for plugin in plugins if plugin.own]
        others = [plugin for plugin in plugins if not plugin.own]
        ours.sort(key=lambda plugin: getattr(plugin.value, "place", len(plugins)))
        raise registry.unknown(GROUP, name, [plugin.name for plugin in (*ours, *others)])
    plugin = registry.find(GROUP, name)
    make: Callable[[], object] = plugin.of_type(Callable)  # pyright: ignore[reportArgumentType]
    with plugin.working():
        rig = make()
    if not isinstance(rig, UdpRig | LibraryRig):
        raise plugin.fault(
            f"returns a {type(rig).__name__}; it must return a UdpRig or a LibraryRig"
        )
    return rig


def udp_rig(text: str, session: int = 0, device: DeviceName = "coaxial") -> UdpRig:
    """A rig from HOST:PORT, and what hangs on it.

    Raises:
        SettingError: it is not of that form.
    """
    host, colon, port = text.rpartition(":")
    if not colon or not port.isdecimal():
        problem = (
            f"{text!r} is no address of a rig" if text else "the address of the rig is missing"
        )
        raise SettingError(
            problem, remedy="Give --address HOST:PORT, for example --address 192.168.1.10:5005"
        )
    return UdpRig(text, host, int(port), session, device=device)
