"""A rig's parameters: one TOML file with value, unit, source and plausible range of each, checked on the way in."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any, cast

from erclutch.errors import SettingError

SECTIONS = ("supply", "fluid", "clutch", "drive", "screw", "sensors", "thermal", "integration")

#: May be zero; all others must be positive.
_MAY_BE_ZERO = {
    "fluid": {"thinning", "field_thickening", "residual_yield"},
    "clutch": {"seal_1", "seal_2"},
    "drive": {"ripple", "coulomb", "breakaway", "viscous"},
    "screw": {"damping", "stop_damping", "coulomb", "breakaway", "viscous", "asymmetry", "waviness", "backlash"},
    "sensors": {"torque_noise", "torque_step"},
    "thermal": {"thinning"},
}


@dataclass(frozen=True)
class Entry:
    """One parameter of a rig.

    Attributes:
        value, unit: the number, in SI.
        source: paper, catalogue, assumed or prototype.
        low, high: plausible range; the limits of a calibration.
        meaning: one phrase.
    """

    value: float
    unit: str
    source: str
    low: float
    high: float
    meaning: str


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
            entries[section][key] = Entry(
                _checked(path, value, old.unit), old.unit, source or old.source, old.low, old.high, old.meaning
            )
        return _consistent(RigParameters(entries, self.name))

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
        if rig.value(f"{part}.breakaway") < rig.value(f"{part}.coulomb"):
            raise SettingError(
                f"{part}.breakaway {rig.value(f'{part}.breakaway'):g} N*m is below {part}.coulomb "
                f"{rig.value(f'{part}.coulomb'):g} N*m",
                remedy="Break-away friction is at least Coulomb friction",
                where=rig.name,
            )
    return rig


@lru_cache(maxsize=1)
def default_rig() -> RigParameters:
    """The rig of the paper, as far as it is known; what is not is assumed or calibrated, and says so."""
    text = resources.files("erclutch.rig").joinpath("default.toml").read_text(encoding="utf-8")
    body = tomllib.loads(text)
    entries = {
        section: {
            key: Entry(
                float(e["value"]), e["unit"], e["source"], float(e["range"][0]), float(e["range"][1]), e["meaning"]
            )
            for key, e in body[section].items()
        }
        for section in SECTIONS
    }
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
    base = RigParameters(default_rig().entries, path.name)
    values: dict[str, float] = {}
    for section, content in body.items():
        if section == "calibration":
            continue
        if section not in SECTIONS or not isinstance(content, dict):
            raise SettingError(
                f"there is no section [{section}]", remedy=f"Use one of {', '.join(SECTIONS)}", where=path.name
            )
        for key, given in cast(dict[str, Any], content).items():
            entry = base.entry(f"{section}.{key}")
            values[f"{section}.{key}"] = _given(f"{section}.{key}", given, entry.unit, path.name)
    return base.changed(values)


def _given(path: str, given: Any, unit: str, where: str) -> float:
    if not isinstance(given, dict):
        return _checked(path, given, unit, where)
    table = cast(dict[str, Any], given)
    if table.get("unit", unit) != unit:
        raise SettingError(f"{path} is given in {table['unit']!r}", remedy=f"Give it in {unit}", where=where)
    return _checked(path, table.get("value"), unit, where)
