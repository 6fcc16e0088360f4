"""A rig's parameters stand in one TOML file with value, unit, source and plausible range, checked on the way in."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any, cast

from erclutch.errors import SettingError, did_you_mean
from erclutch.files.given_files import plain_words, small_file, toml_of

SECTIONS = (
    "supply",
    "fluid",
    "clutch",
    "drive",
    "screw",
    "sensors",
    "thermal",
    "excitation",
    "integration",
)

#: May be zero; all others must be positive.
_MAY_BE_ZERO = {
    "fluid": {"thinning", "field_thickening", "residual_yield", "residual_field"},
    "clutch": {"seal_1", "seal_2"},
    "drive": {"ripple", "coulomb", "viscous"},
    "screw": {"damping", "stop_damping", "coulomb", "viscous", "asymmetry", "waviness", "backlash"},
    "sensors": {"torque_noise", "torque_step"},
    "thermal": {"thinning", "softening"},
    "excitation": {"sines", "alternating", "motor_low"},
}
_SIGNED = {"thermal.room"}
_FAR = 1000.0  # times beyond its plausible range a value is a slip of the pen, with which no simulation stays finite
_SHARES = ("fluid.residual_field", "excitation.sines", "excitation.alternating")
_ORDERED = (
    ("excitation.lowest", "excitation.highest"),
    ("excitation.motor_low", "excitation.motor_high"),
    ("excitation.half_sine_low", "excitation.half_sine_high"),
    ("excitation.half_sine_slowest", "excitation.half_sine_fastest"),
)


@dataclass(frozen=True)
class ParameterEntry:
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

    entries: Mapping[str, Mapping[str, ParameterEntry]]
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

    def entry(self, path: str) -> ParameterEntry:
        """An entry by ``section.name``.

        Raises:
            SettingError: no such parameter.
        """
        section, _, key = path.partition(".")
        if key not in self.entries.get(section, {}):
            import difflib

            known = [f"{section}.{key}" for section, names in self.entries.items() for key in names]
            near = difflib.get_close_matches(path, known, n=1)
            hint = (
                f"Did you mean {near[0]}"
                if near
                else "default.toml in erclutch.wings.rig.twin lists them"
            )
            raise SettingError(f"the rig has no parameter {path!r}", remedy=hint, where=self.name)
        return self.entries[section][key]

    def changed(self, values: Mapping[str, float], source: str | None = None) -> RigParameters:
        """The same rig with other values, given as ``section.name`` -> value.

        Raises:
            SettingError: an unknown parameter or a value that physics forbids.
        """
        made = self
        for path, value in values.items():
            old = self.entry(path)
            value = _checked(path, value, old.unit)
            made = made.with_entry(
                path,
                replace(
                    old,
                    value=value,
                    source=source or old.source,
                    interval=None,
                ),
            )
        return _consistent(made)

    def calibrated(
        self, numbers_of: Mapping[str, tuple[float, float, float, float]]
    ) -> RigParameters:
        """The same rig with calibrated values: ``section.name`` -> (value, start, low, high).

        Raises:
            SettingError: an unknown parameter or a value that physics forbids.
        """
        made = self.changed(
            {path: numbers[0] for path, numbers in numbers_of.items()}, "calibrated"
        )
        for path, (_, start, low, high) in numbers_of.items():
            entry = replace(made.entry(path), start=start, interval=(low, high))
            made = made.with_entry(path, entry)
        return made

    def begun_here(self) -> RigParameters:
        """The same rig, whose next calibration starts from its values and not from where the last one did."""
        made = self
        for section, names in self.entries.items():
            for key, entry in names.items():
                made = made.with_entry(
                    f"{section}.{key}", replace(entry, start=None, interval=None)
                )
        return made

    def with_entry(self, path: str, entry: ParameterEntry) -> RigParameters:
        """The same rig with another entry; nothing is checked."""
        section, _, key = path.partition(".")
        changed = {**self.entries[section], key: entry}
        return RigParameters({**self.entries, section: changed}, self.name)

    def to_dict(self) -> dict[str, dict[str, float]]:
        """Values as JSON."""
        return {section: self.section(section) for section in self.entries}


def _checked(
    path: str,
    value: Any,
    unit: str,
    where: str = "",
) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value):
        raise SettingError(
            f"{path} is {value!r}", remedy=f"Give a finite number in {unit}", where=where
        )
    section, _, key = path.partition(".")
    may_be_zero = key in _MAY_BE_ZERO.get(section, set())
    too_small = value < 0 or (value == 0 and not may_be_zero)
    if too_small and path not in _SIGNED:
        least = "0 or more" if may_be_zero else "above 0"
        problem = f"{path} is {value:g} {unit}, it must be {least}"
        raise SettingError(problem, remedy="Correct it in the rig file", where=where)
    return float(value)


def _near(
    path: str,
    given: Any,
    entry: ParameterEntry,
    where: str,
) -> float:
    value = _checked(path, given, entry.unit, where)
    if value and not entry.low / _FAR <= abs(value) <= entry.high * _FAR:
        usual = f"{entry.low:g} to {entry.high:g}"
        problem = f"{path} is {value:g} {entry.unit}, over {_FAR:g} times beyond its range {usual}"
        raise SettingError(problem, remedy="Correct it in the rig file", where=where)
    return value


def _consistent(rig: RigParameters) -> RigParameters:
    value = rig.value
    inner = value("clutch.inner_radius")
    outer = value("clutch.outer_radius")
    if outer <= inner:
        problem = f"clutch.outer_radius {outer:g} m is not above the inner radius {inner:g} m"
        raise SettingError(problem, remedy="Correct one of the two in the rig file", where=rig.name)
    for path in ("drive.breakaway", "screw.breakaway"):
        if value(path) < 1.0:
            problem = f"{path} is {value(path):g} times Coulomb friction"
            remedy = "Break-away friction is at least Coulomb friction: give 1 or more"
            raise SettingError(problem, remedy=remedy, where=rig.name)
    for path in _SHARES:
        if value(path) > 1.0:
            raise SettingError(
                f"{path} is {value(path):g}", remedy="A share is at most 1", where=rig.name
            )
    for low, high in _ORDERED:
        if value(low) >= value(high):
            problem = f"{low} {value(low):g} is not below {high} {value(high):g}"
            raise SettingError(
                problem, remedy="Correct one of the two in the rig file", where=rig.name
            )
    return rig


#: What a table of an entry may hold.
_KEYS = ("value", "unit", "source", "range", "start", "interval", "meaning")


def _entry(table: Mapping[str, Any]) -> ParameterEntry:
    """An entry of a table of the file; ValueError, TypeError or IndexError where a number is none."""
    low, high = (float(end) for end in table["range"])
    interval: tuple[float, float] | None = None
    if "interval" in table:
        interval = float(table["interval"][0]), float(table["interval"][1])
    return ParameterEntry(
        value=float(table["value"]),
        unit=table["unit"],
        source=table["source"],
        low=low,
        high=high,
        meaning=table["meaning"],
        start=float(table["start"]) if "start" in table else None,
        interval=interval,
    )


@lru_cache(maxsize=1)
def default_rig() -> RigParameters:
    """The rig of the paper, as far as it is known; what is not is assumed or calibrated, and says so."""
    default = resources.files("erclutch.wings.rig.twin").joinpath("default.toml")
    body = toml_of(default.read_bytes())
    entries: dict[str, dict[str, ParameterEntry]] = {}
    for section in SECTIONS:
        entries[section] = {key: _entry(table) for key, table in body[section].items()}
    return _consistent(RigParameters(entries))


def load_rig(path: str | Path | None) -> RigParameters:
    """A rig from a TOML file; what the file leaves out is the default rig's, and all of it without a file.

    A value is a plain number, or a table with ``value`` and, to be clear, the ``unit`` of the default file.

    Raises:
        SettingError: unreadable, an unknown section or parameter, a wrong unit, or a value that physics forbids.
    """
    if path is None:
        return default_rig()
    path = Path(path)
    try:
        body = toml_of(small_file(path))
    except (OSError, ValueError, RecursionError) as error:
        problem = f"the rig file cannot be read ({plain_words(error)})"
        raise SettingError(problem, remedy="Correct the file", where=path.name) from error
    body.pop("calibration", None)
    rig = RigParameters(default_rig().entries, path.name)
    for section, content in body.items():
        if section not in SECTIONS or not isinstance(content, dict):
            remedy = f"Use one of {', '.join(SECTIONS)}"
            raise SettingError(f"there is no section [{section}]", remedy=remedy, where=path.name)
        for key, given in cast(dict[str, Any], content).items():
            name = f"{section}.{key}"
            rig = rig.with_entry(name, _given(name, given, rig.entry(name), path.name))
    return _consistent(rig)


def _given(
    path: str,
    given: Any,
    entry: ParameterEntry,
    where: str,
) -> ParameterEntry:
    """An entry of a user's file: a number, or a table like those of the default file."""
    if not isinstance(given, dict):
        return replace(
            entry,
            value=_near(path, given, entry, where),
            start=None,
            interval=None,
        )
    table = cast(dict[str, Any], given)
    for key in table:
        if key not in _KEYS:
            remedy = f"{did_you_mean(key, _KEYS)}Keys are {', '.join(_KEYS)}"
            raise SettingError(f"{path} has the key {key!r:.60}", remedy=remedy, where=where)
    if table.get("unit", entry.unit) != entry.unit:
        raise SettingError(
            f"{path} is given in {table['unit']!r}", remedy=f"Give it in {entry.unit}", where=where
        )
    value = _near(path, table.get("value"), entry, where)
    usual = {
        "unit": entry.unit,
        "source": "given",
        "range": [entry.low, entry.high],
        "meaning": entry.meaning,
    }
    try:
        made = _entry({**usual, **table, "value": value})
    except (TypeError, ValueError, IndexError) as error:
        problem = f"{path} has an unreadable range, start or interval"
        raise SettingError(
            problem, remedy="Write each like range = [0.1, 2.0]", where=where
        ) from error
    if not made.low < made.high:
        problem = f"{path} has the range {made.low:g} to {made.high:g}"
        raise SettingError(problem, remedy="Give the lower end first", where=where)
    return made
