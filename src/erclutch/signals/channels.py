"""A device names the numbers of a live session once: packets, frames, recordings, the page and plug-ins read them here.

for channel in channels_of("single", Units("N", "V", "m/s"), motor=False):
    print(channel.name, channel.unit)
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from erclutch.errors import SettingError
from erclutch.signals import units as units_module
from erclutch.signals.device import DeviceName, Units
from erclutch.signals.recording import SIGNALS

#: What a channel is to the page.
ROLES = ("position", "speed", "field", "motor", "effort", "estimate", "reference")
_LABEL = re.compile(r"\s*(?P<label>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
_POSITIONS = {"rad/s": "rad", "m/s": "m", "1/s": ""}


@dataclass(frozen=True)
class LiveChannel:
    """One number of each frame.

    Attributes:
        name: of the column in frames and recordings; of a plug-in's channel.
        slot: member of ``erc_frame`` (``live/c/erc_layout.h``) that holds it.
        role: position, speed, field, motor, effort, estimate or reference.
        unit: in SI, as the model has it; "" is dimensionless, "?" unknown.
        label: for people.
    """

    name: str
    slot: str
    role: str
    unit: str
    label: str

    def __str__(self) -> str:
        """Name, label and unit, as in ``field = coil current [A]``."""
        called = self.name if self.label == self.name else f"{self.name} = {self.label}"
        return f"{called} [{self.unit or '1'}]"


_Row = tuple[str, str, str, str]
_ROWS: Mapping[DeviceName, tuple[_Row, ...]] = {
    "single": (
        ("position", "theta", "position", "position"),
        ("slip", "theta_dot", "speed", "slip"),
        ("field", "field1", "field", "field"),
        ("drive", "motor_torque", "motor", "drive"),
        ("effort", "torque", "effort", "effort"),
        ("estimate", "estimate", "estimate", "estimate"),
        ("reference", "reference", "reference", "reference"),
    ),
    "coaxial": (
        ("theta", "theta", "position", "motor"),
        ("alpha", "alpha", "position", "output"),
        ("theta_dot", "theta_dot", "speed", "motor"),
        ("alpha_dot", "alpha_dot", "speed", "output"),
        ("field1", "field1", "field", "CH1"),
        ("field2", "field2", "field", "CH2"),
        ("motor_torque", "motor_torque", "motor", "motor_torque"),
        ("torque", "torque", "effort", "torque"),
        ("estimate", "estimate", "estimate", "estimate"),
        ("reference", "reference", "reference", "reference"),
    ),
}
#: The pair turns; nothing is known of a single device until its model, log or rig says it.
USUAL: Mapping[DeviceName, Units] = {
    "single": Units("?", "?", "?"),
    "coaxial": Units("N*m", "", "rad/s"),
}
#: Slots that a rig sends or is sent; a frame has the others besides.
_WIRED = ("theta", "alpha", "torque", "field1", "field2", "motor_torque")


def channels_of(
    device: DeviceName,
    units: Units | None = None,
    *,
    motor: bool = True,
) -> tuple[LiveChannel, ...]:
    """What the frames of a device hold, in their order.

    Args:
        device: "single" or "coaxial".
        units: of effort, field and slip; None: those of the pair in SI, unknown ones of a single device.
        motor: whether the rig has a drive that the loop commands.
    """
    known = units or USUAL[device]
    unit_of: Mapping[str, str] = {  # by role
        "position": _POSITIONS.get(known.slip, "?"),
        "speed": known.slip,
        "field": known.field,
        "motor": "N" if known.effort == "N" else "N*m",
        "effort": known.effort,
        "estimate": known.effort,
        "reference": "",
    }
    channels: list[LiveChannel] = []
    for name, slot, role, label in _ROWS[device]:
        if motor or role != "motor":
            channels.append(LiveChannel(name, slot, role, unit_of[role], label))
    return tuple(channels)


#: What a recording of the loop holds besides its channels, and what nothing measured among these.
NOT_MEASURED = ("estimate", "reference", "flags", "events", "lateness_ns", "step_ns")


def device_of_channels(names: Iterable[str]) -> DeviceName | None:
    """The device whose channels these are; None for channels that no device has, or for none."""
    held = set(names)
    if not held:
        return None
    fitting: list[DeviceName] = []
    for device, rows in _ROWS.items():
        if held <= {name for name, *_ in rows}:
            fitting.append(device)
    return fitting[0] if len(fitting) == 1 else None


def wired(device: DeviceName) -> tuple[str, ...]:
    """Names of what the packets of a device hold: what its rig sends, and what it is sent."""
    return tuple(name for name, slot, _, _ in _ROWS[device] if slot in _WIRED)


@dataclass(frozen=True)
class NamedChannels:
    """A rig's own words for its channels, such as ``{"field": "coil current [A]"}``.

    Attributes:
        labels: name of a channel -> label.
        units: of effort, field and slip; "?" where the words have none.
        motor: whether there is a drive among them.
        sensor: whether the effort is among them.
        drive: unit of the drive's torque or force; "?" where the words have none.
    """

    labels: Mapping[str, str]
    units: Units
    motor: bool
    sensor: bool
    drive: str = "?"

    def of(self, channels: tuple[LiveChannel, ...]) -> tuple[LiveChannel, ...]:
        """The same channels under these labels, without an effort that nothing measures."""
        kept: list[LiveChannel] = []
        for channel in channels:
            if channel.role == "effort" and not self.sensor:
                continue
            unit = channel.unit
            if channel.role == "motor" and self.drive != "?":
                unit = self.drive
            label = self.labels.get(channel.name, channel.label)
            kept.append(replace(channel, unit=unit, label=label))
        return tuple(kept)


def named(device: DeviceName, texts: Mapping[str, str]) -> NamedChannels:
    """Read a rig's words for its channels.

    Args:
        device: "single" or "coaxial".
        texts: name of a channel out of `wired` -> label, and its unit in SI in square brackets.

    Raises:
        SettingError: an unknown channel, or a label or unit that cannot be. UnitError: no unit.
    """
    labels: dict[str, str] = {}
    units: dict[str, str] = {}  # by role
    roles = {name: role for name, _, role, _ in _ROWS[device]}
    for name, text in texts.items():
        if name not in wired(device):
            remedy = f"Name some of {', '.join(wired(device))}"
            raise SettingError(f"there is no channel {name!r}", remedy=remedy)
        role = roles[name]
        match = _LABEL.fullmatch(text)
        if match is None or not match["label"] or not match["label"].isprintable():
            problem = f"channel {name!r} is called {text!r}"
            raise SettingError(problem, remedy="Write it like 'coil current [A]'")
        labels[name] = match["label"]
        written = match["unit"]
        if written is None:
            continue

        # A drive is a torque or a force, as an effort is. A rig converts before it sends.
        like = "effort" if role == "motor" else role
        signal = SIGNALS[name] if name in SIGNALS else SIGNALS[like]
        factor, unit = units_module.fits(written, signal.si_units) or (0.0, "")
        if factor != 1.0:
            allowed = ", ".join(si or "1" for si in signal.si_units)
            problem = f"channel {name!r} is in {written or '1'}"
            raise SettingError(problem, remedy=f"Send it in one of {allowed}")
        if units.setdefault(role, unit) != unit:
            problem = f"channel {name!r} is in {unit}, and another {role} in {units[role]}"
            raise SettingError(problem, remedy="Send both in one unit")

    # A rig sends positions; the speed's unit follows from theirs.
    speed_of = {position: speed for speed, position in _POSITIONS.items()}
    slip = speed_of.get(units.get("position", "?"), "?")
    given_roles = {roles[name] for name in labels}
    return NamedChannels(
        labels,
        Units(units.get("effort", "?"), units.get("field", "?"), slip),
        motor="motor" in given_roles,
        sensor="effort" in given_roles,
        drive=units.get("motor", "?"),
    )
