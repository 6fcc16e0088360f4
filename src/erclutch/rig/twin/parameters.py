"""A rig's parameters: one TOML file with value, unit, source and plausible range of each, checked on the way in."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any, cast

from erclutch.errors import SettingError

SECTIONS = ("supply", "fluid", "clutch", "drive", "screw", "sensors", "thermal", "excitation", "integration")

#: May be zero; all others must be positive.
_MAY_BE_ZERO = {
    "fluid": {"thinning", "field_thickening", "residual_yield"},
    "clutch": {"seal_1", "seal_2"},
    "drive": {"ripple", "coulomb", "viscous"},
    "screw": {"damping", "stop_damping", "coulomb", "viscous", "asymmetry", "waviness", "backlash"},
    "sensors": {"torque_noise", "torque_step"},
    "thermal": {"thinning"},
    "excitation": {"sines", "alternating", "motor_low"},
}
_SHARES = ("excitation.sines", "excitation.alternating")


@dataclass(frozen=True)
class Entry:
    """One parameter of a rig.

    Attributes:
        value, unit: the number, in SI.
        source: paper, catalogue, assumed or calibrated.
        low, high: plausible range; the limits of a calibration.
        meaning: one phrase.
        start: of a calibrated value, what its calibration started from.
        interval: of a calibrated value, its 95 % interval.
    """

    value: float
    unit: str
    source: str
    low: float
    high: float
    meaning: str
    start: float | None = None
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class RigParameters:
    """All parameters of a rig.

    Attributes:
        entries: section -> name -> entry.
        name: where they came from.
    """

    entries: Mapping[str, Mapping[str, Entry]]
    name: str = "default rig"

    def section(self, name: str) -> dict[str, float]:
        """Values of a section by name."""
        return {key: entry.value for key, entry in self.entries[name].items()}

    def value(self, path: str) -> float:
        """A value by ``section.name``.

        Raises:
            SettingError: no such parameter.
        """
        return self.entry(path).value

    def entry(self, path: str) -> Entry:
        """An entry by ``section.name``.

        Raises:
            SettingError: no such parameter.
        """
        section, _, key = path.partition(".")
        if key not in self.entries.get(section, {}):
            raise _unknown(path, self)
        return self.entries[section][key]

    def changed(self, values: Mapping[str, float], source: str | None = None) -> RigParameters:
        """The same rig with other values, given as ``section.name`` -> value.

        Raises:
            SettingError: an unknown parameter or a value that physics forbids.
        """
        entries = {section: dict(names) for section, names in self.entries.items()}
        for path, value in values.items():
            old = self.entry(path)
            section, _, key = path.partition(".")
            entries[section][key] = replace(
                old, value=_checked(path, value, old.unit), source=source or old.source, interval=None
            )
        return _consistent(RigParameters(entries, self.name))

    def calibrated(self, found: Mapping[str, tuple[float, float, float, float]]) -> RigParameters:
        """The same rig with calibrated values: ``section.name`` -> (value, start, low, high).

        Raises:
            SettingError: an unknown parameter or a value that physics forbids.
        """
        made = self.changed({path: numbers[0] for path, numbers in found.items()}, "calibrated")
        entries = {section: dict(names) for section, names in made.entries.items()}
        for path, (_, start, low, high) in found.items():
            section, _, key = path.partition(".")
            entries[section][key] = replace(entries[section][key], start=start, interval=(low, high))
        return RigParameters(entries, self.name)

    def to_dict(self) -> dict[str, dict[str, float]]:
        """Values as JSON."""
        return {section: self.section(section) for section in self.entries}


def _unknown(path: str, rig: RigParameters) -> SettingError:
    import difflib

    known = [f"{section}.{key}" for section, names in rig.entries.items() for key in names]
    near = difflib.get_close_matches(path, known, n=1)
    hint = f"Did you mean {near[0]}" if near else "They are listed in default.toml of the package erclutch.rig"
    return SettingError(f"the rig has no parameter {path!r}", remedy=hint, where=rig.name)


def _checked(path: str, value: Any, unit: str, where: str = "") -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise SettingError(f"{path} is {value!r}", remedy=f"Give a finite number in {unit}", where=where)
    section, _, key = path.partition(".")
    least = "0 or more" if key in _MAY_BE_ZERO.get(section, set()) else "above 0"
    if value < 0 or (value == 0 and least == "above 0"):
        raise SettingError(f"{path} is {value:g} {unit}, it must be {least}", remedy="Correct it", where=where)
    return float(value)


def _consistent(rig: RigParameters) -> RigParameters:
    if rig.value("clutch.outer_radius") <= rig.value("clutch.inner_radius"):
        raise SettingError(
            f"clutch.outer_radius {rig.value('clutch.outer_radius'):g} m is not above the inner radius "
            f"{rig.value('clutch.inner_radius'):g} m",
            remedy="Correct one of them",
            where=rig.name,
        )
    for part in ("drive", "screw"):
        if rig.value(f"{part}.breakaway") < 1.0:
            raise SettingError(
                f"{part}.breakaway is {rig.value(f'{part}.breakaway'):g} times Coulomb friction",
                remedy="Break-away friction is at least Coulomb friction: give 1 or more",
                where=rig.name,
            )
    for path in _SHARES:
        if rig.value(path) > 1.0:
            raise SettingError(f"{path} is {rig.value(path):g}", remedy="A share is at most 1", where=rig.name)
    for low, high in (("lowest", "highest"), ("motor_low", "motor_high")):
        if rig.value(f"excitation.{low}") >= rig.value(f"excitation.{high}"):
            raise SettingError(
                f"excitation.{low} {rig.value(f'excitation.{low}'):g} is not below excitation.{high} "
                f"{rig.value(f'excitation.{high}'):g}",
                remedy="Correct one of them",
                where=rig.name,
            )
    return rig


def _entry(e: Mapping[str, Any]) -> Entry:
    low, high = (float(v) for v in e["range"])
    interval = (float(e["interval"][0]), float(e["interval"][1])) if "interval" in e else None
    start = float(e["start"]) if "start" in e else None
    return Entry(float(e["value"]), e["unit"], e["source"], low, high, e["meaning"], start, interval)


@lru_cache(maxsize=1)
def default_rig() -> RigParameters:
    """The rig of the paper, as far as it is known; what is not is assumed or calibrated, and says so."""
    text = resources.files("erclutch.rig").joinpath("default.toml").read_text(encoding="utf-8")
    body = tomllib.loads(text)
    entries = {section: {key: _entry(e) for key, e in body[section].items()} for section in SECTIONS}
    return _consistent(RigParameters(entries))


def load_rig(path: str | Path) -> RigParameters:
    """A rig from a TOML file; what the file leaves out is the default rig's.

    A value is a plain number, or a table with ``value`` and, to be clear, the ``unit`` of the default file.

    Raises:
        SettingError: unreadable, an unknown section or parameter, a wrong unit, or a value that physics forbids.
    """
    path = Path(path)
    try:
        body = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise SettingError(f"the rig file cannot be read ({error})", remedy="Correct it", where=path.name) from error
    entries = {section: dict(names) for section, names in default_rig().entries.items()}
    base = RigParameters(entries, path.name)
    for section, content in body.items():
        if section == "calibration":
            continue
        if section not in SECTIONS or not isinstance(content, dict):
            raise SettingError(
                f"there is no section [{section}]", remedy=f"Use one of {', '.join(SECTIONS)}", where=path.name
            )
        for key, given in cast(dict[str, Any], content).items():
            entries[section][key] = _given(f"{section}.{key}", given, base.entry(f"{section}.{key}"), path.name)
    return _consistent(base)


def _given(path: str, given: Any, entry: Entry, where: str) -> Entry:
    """An entry of a user's file: a number, or a table like those of the default file."""
    if not isinstance(given, dict):
        return replace(entry, value=_checked(path, given, entry.unit, where), start=None, interval=None)
    table = cast(dict[str, Any], given)
    if table.get("unit", entry.unit) != entry.unit:
        raise SettingError(f"{path} is given in {table['unit']!r}", remedy=f"Give it in {entry.unit}", where=where)
    value = _checked(path, table.get("value"), entry.unit, where)
    whole = {"unit": entry.unit, "source": "given", "range": [entry.low, entry.high], "meaning": entry.meaning, **table}
    try:
        made = _entry({**whole, "value": value})
    except (TypeError, ValueError, IndexError) as error:
        raise SettingError(
            f"{path} has an unreadable range, start or interval",
            remedy="Write each like range = [0.1, 2.0]",
            where=where,
        ) from error
    if not made.low < made.high:
        raise SettingError(
            f"{path} has the range {made.low:g} to {made.high:g}", remedy="Give the lower end first", where=where
        )
    return made
