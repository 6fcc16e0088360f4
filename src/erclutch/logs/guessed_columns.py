"""Signals are guessed from the names and units of columns; where a guess would be a bet there is an error."""

from __future__ import annotations

import re
from collections.abc import Iterable

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.mapping import ColumnChoice, columns_listed
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

# Names in small letters without signs; a column of another unit than the signal's is no candidate whatever its name.
_NAMES = {
    "field": "field e i u b v voltage current coilcurrent drivecurrent command cmd excitation",
    "slip": "slip w v n omega speed velocity vel sliprate slipspeed shearrate gammadot relativespeed",
    "position": "position pos x d displacement disp stroke travel angle slipangle",
    "effort": "effort force torque f m load moment shearstress tau t",
    "E1": "e1 field1 ech1",
    "E2": "e2 field2 ech2",
    "E": "e field",
    "theta": "theta motorangle",
    "theta_dot": "thetadot dtheta motorspeed",
    "alpha": "alpha outputangle",
    "alpha_dot": "alphadot dalpha outputspeed",
    "alpha_raw": "alpharaw screwposition tableposition",
    "T": "torque effort t",
    "motor_torque": "motortorque torquecommand torquecmd",
}
_NEED_UNIT = {"v", "t", "m", "d", "n", "u", "b", "x", "tau", "load"}  # short names that mean several things
_TIME = re.compile(
    r"t|time|zeit|tijd|temps|tiempo|tempo|timestamps?|elapsed(?:time)?|seconds|sec|tsec|times|timems", re.IGNORECASE
)
_EXAMPLES = {"field": "I [A]", "slip": "V [cm/s]", "position": "D [mm]", "effort": "F [N]", "T": "torque [N*m]"}


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


def _fits(table: Table, name: str, si_units: tuple[str, ...]) -> bool | None:
    """Whether the column's unit is one for these; None where it has no unit."""
    unit = table.units.get(name)
    if not unit:
        return None
    try:
        return units.fits(unit, si_units) is not None
    except UnitError:
        return False


def candidates(table: Table, signal: str, taken: Iterable[str]) -> tuple[list[str], str]:
    """Columns that may be the signal, and what speaks for them: ``name`` or ``unit``."""
    si_units, allowed = SIGNALS[signal].si_units, set(_NAMES[signal].split())
    fit = {name: _fits(table, name, si_units) for name in table.columns if name not in set(taken)}
    if signal in fit and fit[signal] is not False:
        return [signal], "name"
    named = [
        name
        for name, fits in fit.items()
        if (plain := _plain(name)) in allowed and (fits or (fits is None and plain not in _NEED_UNIT))
    ]
    if named:
        return named, "name"
    dimensionless = {"", "-", "1", "%"}
    by_unit = [name for name, fits in fit.items() if fits and table.units.get(name) not in dimensionless]
    return (by_unit if signal in _EXAMPLES else []), "unit"


def guess(table: Table, signal: str, taken: Iterable[str]) -> ColumnChoice | None:
    """The one column that a signal's name or unit points to, or None.

    Raises:
        MappingError: several columns would do.
    """
    found, reason = candidates(table, signal, taken)
    if len(found) > 1:
        problem = f"{signal} may be any of the columns {', '.join(found)}; the file has: {columns_listed(table)}"
        raise MappingError(
            problem, remedy=f"Say which, such as --{signal} {shell_word(_label(table, found[0], signal))}"
        )
    return ColumnChoice(found[0], source=f"guessed from its {reason}") if found else None


def maybe_field(table: Table, taken: Iterable[str]) -> list[str]:
    """Columns that nobody took and that may hold the field, whatever they are called: their unit fits, or is not known.

    Only where there is none, a log without a field is read as such.
    """
    free = [name for name in table.columns if name not in set(taken)]
    return [name for name in free if _fits(table, name, SIGNALS["field"].si_units) is not False]


def missing(table: Table, signal: str, taken: Iterable[str], alternatives: str = "") -> MappingError:
    """The error for a signal that no column was found for."""
    free = [name for name in table.columns if name not in set(taken)]
    short = _NEED_UNIT & set(_NAMES[signal].split())
    doubtful = [name for name in free if not table.units.get(name) and _plain(name) in short]
    doubt, example = "", _EXAMPLES.get(signal, f"NAME [{SIGNALS[signal].si_units[0] or '-'}]")
    if doubtful:
        meaning = " (voltage or velocity)" if _plain(doubtful[0]) == "v" else ""
        doubt = f"; {doubtful[0]} may be it, but its name alone can mean several things{meaning}"
        example = _label(table, doubtful[0], signal)
    remedy = f"Give it with its unit, such as --{signal} {shell_word(example)}"
    if signal == "field":
        remedy += ", or --constant 'field=0.5 A' if it is the same all through the log, or --field none if not logged"
    lengths = [name for name in free if signal == "slip" and _fits(table, name, SIGNALS["position"].si_units)]
    if lengths:
        remedy = f"Give a speed, or the position that it is the rate of: --position {shell_word(lengths[0])}"
    problem = f"no column for {alternatives or signal}{doubt}; the file has: {columns_listed(table)}"
    return MappingError(problem, remedy=remedy)


def _label(table: Table, name: str, signal: str) -> str:
    """The column with its unit, or with a likely one."""
    example = "V [V]" if signal == "field" and _plain(name) == "v" else _EXAMPLES.get(signal, "")
    likely = example[example.find("[") + 1 : -1] if example else SIGNALS[signal].si_units[0] or "-"
    return f"{name} [{table.units.get(name) or likely}]"


def time_column(table: Table, taken: Iterable[str]) -> str | None:
    """The column that is the time by its name, with a unit of time or none; or the only one with a unit of time."""
    timed = {name: _fits(table, name, ("s",)) for name in table.columns if name not in set(taken)}
    named = [n for n, fits in timed.items() if n != "T" and _TIME.fullmatch(_plain(n)) and fits is not False]
    by_unit = [name for name, fits in timed.items() if fits]
    return named[0] if named else by_unit[0] if len(by_unit) == 1 else None
