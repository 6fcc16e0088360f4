"""Columns are found by the labels that users give, or by what their names and units say; a bet is an error."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

import numpy as np

from erclutch.errors import LogError, MappingError, UnitError, shell_word
from erclutch.logs.labels import own_unit, split_end, split_label
from erclutch.logs.mapping import COUNTS, ColumnChoice
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


# Names in small letters without signs and accents; a column of another unit than the signal's is no candidate.
_NAMES = {
    "field": "field e i u b v voltage current coilcurrent drivecurrent command cmd excitation pwm duty volt amp amps "
    "strom spannung spulenstrom feld courant tension corriente voltaje tensao corrente tensione iq id uq ud ia udc",
    "slip": "slip w v n omega speed velocity vel sliprate slipspeed shearrate gammadot relativespeed rpm anglevelocity "
    "drehzahl geschwindigkeit winkelgeschwindigkeit schlupf vitesse velocidad velocidade velocita",
    "position": "position pos x d displacement disp stroke travel angle slipangle weg winkel hub verschiebung "
    "deplacement desplazamiento deslocamento spostamento posicion posicao angulo",
    "effort": "effort force torque f m load moment shearstress tau t te drehmoment kraft moment couple fuerza par "
    "forca coppia forza",
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
# Words beside the name that say where or how it was measured.
_BESIDE = _set(
    "measured meas msr actual act ist mess gemessen sensor filtered filt motor engine output brake clutch damper shaft "
    "piston angular rotational linear relative total machine cart du de der des moteur mesure mesuree medida"
)
# Words of what a drive was told, and of what is neither signal: no guess is made from the unit of such a column.
_TOLD = _set("setpoint set target desired demand demanded commanded command cmd ref reference goal soll consigne")
_OTHER = _set(
    "pressure druck pression presion pressao temperature temp esc vibration gap diameter thickness noise error "
    "normal accuracy resolution power viscosity strain crack radius size length width mass weight h"
)
_NEED_UNIT = _set("v t m d n u b x tau load id te par tension")  # short names that mean several things
_VOLTAGES = _set("u v uq ud udc voltage volt spannung tension voltaje tensao tensione")
_SINGLE = ("field", "slip", "position", "effort")
_TIME = re.compile(
    r"t|time|zeit|uhrzeit|tijd|temps|tiempo|tempo|timestamps?|elapsed(?:time)?|steptime|seconds|sec|tsec|times",
    re.IGNORECASE,
)
_MOVES = 0.02  # share of the largest position by which a position changes at least
_KEEPS = 0.2  # share of the rows from which on a field keeps its levels
_EXAMPLES = {"field": "I [A]", "slip": "V [cm/s]", "position": "D [mm]", "effort": "F [N]", "T": "torque [N*m]"}


def _plain(name: str) -> str:
    letters = unicodedata.normalize("NFKD", name)
    return re.sub(r"[\W_]", "", letters).lower()


def _words(name: str) -> list[str]:
    """Words of a name, in small letters: at signs, and where a small letter meets a large one."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", unicodedata.normalize("NFKD", name))
    return re.sub(r"[^\w\s]|_", " ", re.sub("[\u0300-\u036f]", "", apart)).lower().split()


def _called(name: str, signal: str) -> str | None:
    """The name that speaks for a signal: the whole of it, or what is left without its unit.

    For a single device also what is left without the words beside it; the pair has a motor and an output to tell apart.
    """
    stem, _ = split_end(name)
    if any(prime in stem for prime in "'\"′″"):
        return None  # E' is a fluctuation, G" a loss modulus: neither is E or G
    rest = "".join(word for word in _words(stem) if word not in _BESIDE) if signal in _SINGLE else ""
    return next((form for form in (_plain(name), _plain(stem), rest) if form in _NAMES[signal].split()), None)


def _fits(table: Table, name: str, si_units: tuple[str, ...]) -> bool | None:
    """Whether the column's unit is one for these; None where it has no unit."""
    unit = own_unit(name, table.units.get(name), si_units)
    if not unit:
        return False if split_end(name)[1] else None
    try:
        return units.fits(unit, si_units) is not None
    except UnitError:
        return False


def meant_by(name: str, signals: Iterable[str], *, time: bool) -> str:
    """The signal that a column's name speaks for, ``time`` among them where that is looked for; "" for none.

    Short names that mean several things speak for none.
    """
    if time and any(map(_TIME.fullmatch, (_plain(name), _plain(split_end(name)[0])))) and name != "T":
        return "time"
    words = set(_words(split_end(name)[0]))
    for signal in sorted(signals):
        form = _called(name, signal) if signal in _NAMES else None
        if form and form not in _NEED_UNIT and not (words & (_TOLD | _OTHER) and signal != "field"):
            return signal
    return ""


def candidates(
    table: Table, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = ()
) -> tuple[list[str], str]:
    """Columns that may be the signal, and what speaks for them: ``name`` or ``unit``.

    Args:
        table: the log.
        signal: its name.
        taken: columns that are something else.
        units_of_sensor: units of the column where a scale makes the signal of it, such as V; then names alone speak.
    """
    si_units = units_of_sensor or SIGNALS[signal].si_units
    fit = {name: _fits(table, name, si_units) for name in table.columns if name not in set(taken)}
    if signal in fit and fit[signal] is not False:
        return [signal], "name"
    told = _TOLD if signal != "field" else frozenset[str]()
    # A large W is the watt: power is no signal.
    fit = {name: fits for name, fits in fit.items() if name.strip() != "W" or fits}
    called = {name: _called(name, signal) for name, fits in fit.items() if fits is not False}
    named = [
        name
        for name, form in called.items()
        if form and (fit[name] or form not in _NEED_UNIT) and not told.intersection(_words(name))
    ]
    exact = [name for name in named if _plain(split_end(name)[0]) == called[name]]
    if named or units_of_sensor:
        chosen = exact or named
        if signal == "field" and {called[name] for name in chosen} <= _VOLTAGES:
            chosen = [*chosen, *_currents(table, fit, chosen)]
        return chosen, "name"
    by_unit = [
        name
        for name, fits in fit.items()
        if fits and own_unit(name, table.units.get(name), si_units) not in {None, "", "-", "1", "%"}
        if not (told | _OTHER).intersection(_words(split_end(name)[0])) and not _another(name, signal)
        if signal == "field" or not _is_constant(table.columns[name])
    ]
    return (by_unit if signal in _EXAMPLES else []), "unit"


def _currents(table: Table, fit: Iterable[str], named: Sequence[str]) -> list[str]:
    """Columns in amperes beside voltages: the current of a coil is its field as much as its voltage is."""
    return [
        name
        for name in fit
        if name not in named and _fits(table, name, ("A",)) and not _is_constant(table.columns[name])
        if not (_TOLD | _OTHER).intersection(_words(split_end(name)[0]))
    ]


def _is_constant(values: Array) -> bool:
    """Whether a column never changes: a radius or a gap is no motion, whatever its unit says."""
    known = values[np.isfinite(values)]
    return bool(known.size > 1 and np.ptp(known) == 0.0)


def has_shape_of(signal: str, values: Array) -> bool:
    """Whether the numbers of a column look like the signal.

    A slip turns back or rests, a field keeps or leaves levels, a position moves: a gap hardly does.

    Args:
        signal: its name.
        values: the column, shape (n,).
    """
    known = values[np.isfinite(values)]
    if known.size < 2 or signal not in ("field", "slip", "position"):
        return True
    if signal == "position":
        return bool(np.ptp(known) > _MOVES * np.abs(known).max())
    if signal == "slip":
        low, high = float(known.min()), float(known.max())
        return (low < 0.0 < high) or bool(np.any(np.abs(known) <= 0.02 * max(abs(low), abs(high))))
    stays = np.count_nonzero(np.diff(known) == 0.0) / (known.size - 1)
    return bool(stays > _KEEPS) or bool(np.any(known == 0.0))


def _another(name: str, signal: str) -> bool:
    """Whether the name speaks for another signal of a single device: a force sensor in volts is no field."""
    own = "effort" if signal == "T" else signal
    return any(len(_called(name, other) or "") > 2 for other in _SINGLE if other != own)


def guess(
    table: Table, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = ()
) -> ColumnChoice | None:
    """The one column that a signal's name or unit points to, or None; see `candidates`.

    Raises:
        MappingError: several columns would do.
    """
    found, reason = candidates(table, signal, taken, units_of_sensor)
    if len(found) > 1:
        problem = f"{signal} may be any of the columns {', '.join(found)}; the file has: {table.listed}"
        remedy = f"Say which, such as --{signal} {shell_word(_label(table, found[0], signal))}"
        remedy += ", or --variable all if each is a log" if signal in ("effort", "T") else ""
        raise MappingError(problem, remedy=remedy)
    return ColumnChoice(found[0], source=f"guessed from its {reason}") if found else None


def example(table: Table, signal: str, taken: Iterable[str]) -> str:
    """An option for a signal that was not found: with a column that may be it, or with a place to fill in."""
    free = [name for name in table.columns if name not in set(taken)]
    short = _NEED_UNIT & set(_NAMES[signal].split())
    likely = candidates(table, signal, taken)[0] or [name for name in free if _plain(name) in short]
    if volts := _in_volts(table, signal, free):
        return volts
    unit = (_EXAMPLES.get(signal, "").partition("[")[2] or f"{SIGNALS[signal].si_units[0] or '-'}]")[:-1]
    return f"--{signal} {shell_word(_label(table, likely[0], signal) if likely else f'COLUMN [{unit}]')}"


def has_fitting_unit(table: Table, name: str, signal: str) -> bool:
    """Whether the column's unit is known and is one of the signal's."""
    return _fits(table, name, SIGNALS[signal].si_units) is True


def of_fitting_unit(table: Table, signal: str, taken: Iterable[str]) -> tuple[str, ...]:
    """Columns whose unit is one of the signal's."""
    free = [name for name in table.columns if name not in set(taken)]
    return tuple(name for name in free if has_fitting_unit(table, name, signal))


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
    lengths = [name for name in lengths if not _is_constant(table.columns[name])]
    if lengths:
        remedy = f"Give a speed, or the position that it is the rate of: --position {shell_word(lengths[0])}"
    if volts := _in_volts(table, signal, free):
        remedy = f"Give what a volt of its sensor is, such as {volts}"
    called = (name for name in free if table.units.get(name) and len(_called(name, signal) or "") > 2)
    refused = next((name for name in called if _fits(table, name, SIGNALS[signal].si_units) is False), None)
    doubt += f"; column {refused} is called so, but its unit {table.units[refused]} does not fit" if refused else ""
    problem = f"no column for {alternatives or signal}{doubt}; the file has: {table.listed}"
    return MappingError(problem, remedy=remedy)


def _in_volts(table: Table, signal: str, free: Iterable[str]) -> str:
    """Options for a column that has the signal's name and the unit of a sensor's output; "" where there is none."""
    for name in free:
        unit = table.units.get(name)
        volts = (unit in ("V", "mV") or unit in COUNTS) and _fits(table, name, SIGNALS[signal].si_units) is False
        if volts and len(_called(name, signal) or "") > 2:
            scale = shell_word(f"{signal}=2.5 {SIGNALS[signal].si_units[0] or '1'}/{unit}")
            return f"--{signal} {shell_word(name)} --scale {scale}"
    return ""


def _label(table: Table, name: str, signal: str) -> str:
    """The column with its unit, or with a likely one."""
    example = "V [V]" if signal == "field" and _plain(name) == "v" else _EXAMPLES.get(signal, "")
    likely = example[example.find("[") + 1 : -1] if example else SIGNALS[signal].si_units[0] or "-"
    _, end = split_end(name)
    return name if end and not table.units.get(name) else table.label(name, likely)


def time_column(table: Table, taken: Iterable[str]) -> str | None:
    """The column that is the time by its name, with a unit of time or none; or the only one with a unit of time."""
    timed = {name: _fits(table, name, ("s",)) for name in table.columns if name not in set(taken)}
    named = [
        name
        for name, fits in timed.items()
        if name != "T" and fits is not False and any(map(_TIME.fullmatch, (_plain(name), _plain(split_end(name)[0]))))
    ]
    by_unit = [name for name, fits in timed.items() if fits and not _OTHER.intersection(_words(name))]
    return named[0] if named else by_unit[0] if len(by_unit) == 1 else None


def locate(table: Table, choice: ColumnChoice, signal: str) -> tuple[str, str | None, float]:
    """Column name, unit and factor that a choice means; an exact column name wins over its reading as a label.

    Raises:
        MappingError: no such column; the message lists the columns and a close match.
        LogError: its cells are no numbers.
    """
    text = str(choice.column).strip()
    _refuse_unreadable(table, text)
    for candidate, factor in ((text, 1.0), (text[1:].strip(), -1.0))[: 1 + text.startswith("-")]:
        name, unit = candidate, choice.unit
        if name not in table.columns:
            name, own = split_label(candidate)
            unit = choice.unit or own
        if name not in table.columns and name.isdecimal() and len(name) < 10:
            name = table.numbered(int(name)) or name
        if name in table.columns:
            _refuse_another_kind(name, unit, signal)
            si_units = SIGNALS[signal].si_units if signal in SIGNALS else ("s",) if signal == "time" else ()
            return name, choice.unit or own_unit(name, unit or table.units.get(name), si_units), factor * choice.scale
    raise _no_column(table, text, signal)


def _refuse_unreadable(table: Table, text: str) -> None:
    """Raise a LogError where the column that is named holds no numbers."""
    plain = text.removeprefix("-").strip()
    for name in (text, plain, split_label(text)[0], split_label(plain)[0]):
        if name not in table.columns and name in table.unreadable:
            raise LogError(table.unreadable[name], remedy="Correct its cells, or name another column")


def _refuse_another_kind(name: str, unit: str | None, signal: str) -> None:
    """Refuse a unit that is given for a column whose name ends in a unit of another kind: no volt is an ampere."""
    _, end = split_end(name)
    if not end or not unit or not (units.is_unit(end) and units.is_unit(unit)):
        return
    if units.parse(end).dimension != units.parse(unit).dimension:
        problem = f"column '{name}' ends in a unit, {end}, and {unit} is of another kind"
        scale = shell_word(f"{signal}=1 {unit}/{end}")
        remedy = f"Give it as it is, --{signal} {shell_word(name)}"
        remedy += f", or what one {end} of it means, such as --scale {scale}" if signal in SIGNALS else ""
        raise UnitError(problem, remedy=remedy)


def _no_column(table: Table, text: str, signal: str) -> MappingError:
    import difflib

    lower = {name.lower(): name for name in table.columns if name not in table.truths}
    near = difflib.get_close_matches(split_label(text)[0].lower(), lower, n=1, cutoff=0.5)
    close = lower[near[0]] if near else ""
    hint = f"Did you mean {close}? Give it as" if close else "Give one of them as"
    problem = f"there is no column '{text}' for {signal}; the file has: {table.listed}"
    each = "; for a log of each column of such a name add --variable all" if "*" in text and signal != "time" else ""
    return MappingError(problem, remedy=f"{hint} --{signal} {shell_word(close or 'NAME [unit]')}{each}")
