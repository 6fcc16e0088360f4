"""A table and a mapping become a Recording: choose, convert, put on a clock, cut, refuse what is not finite."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError, MappingError, SettingError, UnitError, placed, shell_word
from erclutch.logs import guessed_columns, name_pattern, timing
from erclutch.logs.labels import split_label
from erclutch.logs.mapping import COUNTS, ColumnChoice, ColumnMap, columns_listed, locate, scaled
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NAMED_COLUMNS, NO_FIELD, SIGNALS, TEMPERATURE, Recording

Invalid = Literal["error", "drop"]

#: What a device needs: each group is satisfied by one of its alternatives, each of which is a set of signals.
NEEDS: Mapping[str, tuple[tuple[tuple[str, ...], ...], ...]] = {
    "single": ((("field",),), (("slip",), ("position",)), (("effort",),)),
    "coaxial": (
        (("E1", "E2"), ("E",)),
        (("theta_dot",), ("theta",)),
        (("alpha_dot",), ("alpha",), ("alpha_raw",)),
        (("T",),),
    ),
}
#: What a device may have besides; taken by its name where it is there.
OPTIONAL: Mapping[str, tuple[str, ...]] = {"single": (), "coaxial": ("motor_torque",)}
_INPUT = "input:"
_LARGEST = 1e30  # of a signal in SI units; squares of sums of such are still numbers
_SPARE = "spare column "
_MOST_SPARE = 8
_NONE = "none"  # in place of a column of the field: the device has none that was logged
_COUNTER = "samplenumber"
_SLOW = 0.5  # s between rows from which on a time without a unit is doubted


@dataclass
class _Draft:
    """A recording in the making; rows are those of the table."""

    table: Table
    device: DeviceName
    signals: dict[str, Array] = field(default_factory=dict[str, Array])
    units: dict[str, str] = field(default_factory=dict[str, str])
    columns: dict[str, str] = field(default_factory=dict[str, str])
    constants: dict[str, float] = field(default_factory=dict[str, float])
    stepped: dict[str, tuple[float, ...]] = field(default_factory=dict[str, tuple[float, ...]])
    notes: list[str] = field(default_factory=list[str])
    choices: dict[str, ColumnChoice] = field(default_factory=dict[str, ColumnChoice])
    stamps: tuple[str, str | None, float, str] | None = None  # name, unit, factor and source of the time column
    asked: dict[str, MappingError] = field(default_factory=dict[str, MappingError])

    def present(self, signals: tuple[str, ...]) -> bool:
        return all(signal in self.signals for signal in signals)


def assemble(table: Table, chosen: ColumnMap, *, device: DeviceName, invalid: Invalid | None = None) -> Recording:
    """Make a Recording of a table; see `assemble_rows`."""
    return assemble_rows(table, chosen, device=device, invalid=invalid)[0]


def assemble_rows(
    table: Table, chosen: ColumnMap, *, device: DeviceName, invalid: Invalid | None = None
) -> tuple[Recording, NDArray[np.int64]]:
    """Make a Recording of a table, and tell which row of the table each of its rows was, shape (n,).

    Args:
        table: columns as in the file.
        chosen: what the user said; the rest is guessed from names and units.
        device: "single" or "coaxial"; decides which signals are needed.
        invalid: "error" refuses values that are not finite, "drop" cuts the log there; None is what the mapping says.

    Raises:
        MappingError: a signal without a column, or with several; UnitError: a unit that does not fit.
        LogError: values that are not finite; TimingError: time that cannot be put right.
        SettingError: another device or way with invalid values than these.
    """
    if device not in NEEDS:
        raise SettingError(f"there is no device '{device}'", remedy=f"Use one of {', '.join(NEEDS)}")
    invalid = invalid or ("drop" if chosen.invalid == "drop" else "error")
    if invalid not in ("error", "drop"):
        raise SettingError(f"invalid is '{invalid}'", remedy="Use error or drop")
    with placed(table.name):
        draft = understood(table, chosen, device)
        if draft.asked:
            raise all_asked(draft, chosen)
        rows = np.arange(table.rows)
        rows = rows[~_bad_stamps(draft, invalid)]
        clock = _clock(draft, chosen, rows)
        return _recording(draft, clock, rows, _invalid_rows(draft, invalid), chosen.file)


def understood(table: Table, chosen: ColumnMap, device: DeviceName) -> _Draft:
    """Which column is which signal, and what is still to be asked for."""
    draft = _Draft(table, device, constants=dict(table.constants), notes=list(table.notes))
    steps = (_take_chosen, _ask_time, _take_constants, _take_guesses, _take_optional, _take_inputs, _spare, _turn_screw)
    for take in steps:
        take(draft, chosen)
    _effort_is_no_input(draft)
    return draft


def _effort_is_no_input(draft: _Draft) -> None:
    """Raise a MappingError where the effort's column is another signal's too: a model would find just that."""
    effort = "T" if draft.device == "coaxial" else "effort"
    for signal, column in draft.columns.items():
        if signal != effort and column == draft.columns.get(effort):
            raise MappingError(
                f"column {column} is both {signal} and {effort}",
                remedy=f"Name another column with --{effort} or --{signal}",
            )


def all_asked(draft: _Draft, chosen: ColumnMap) -> MappingError:
    """All that is missing as one error, with a command that asks for nothing more once it is filled in."""
    if len(draft.asked) == 1:
        return next(iter(draft.asked.values()))
    told = [error.problem.split("; the file has: ")[0] for error in draft.asked.values()]
    numbered = "; ".join(f"({number}) {problem}" for number, problem in enumerate(told, start=1))
    problem = f"{len(told)} things are missing: {numbered}; the file has: {columns_listed(draft.table)}"
    options = _options(draft, chosen)
    command = f"erclutch inspect {shlex.quote(draft.table.path)} {' '.join(options)}"
    if not draft.table.path:  # of a DataFrame or of arrays
        command = str({k[2:]: v for k, v in map(shlex.split, options) if k[2:] in (*NAMED_COLUMNS, "time")})
    pair = next((f"; if {hint}" for e in draft.asked.values() if (hint := e.remedy.partition("; if ")[2])), "")
    none = "; --field none if it was not logged" if "--field none" in str(draft.asked.get("field")) else ""
    return MappingError(problem, remedy=f"Give them all, with your columns in place of these: {command}{none}{pair}")


def _options(draft: _Draft, chosen: ColumnMap) -> list[str]:
    """What was given, and an example for what is missing, as options of a command."""
    given = {**chosen.columns, **({"time": chosen.time} if chosen.time else {})}
    words = [
        f"--{name} {shell_word(f'{c.column} [{c.unit}]' if c.unit else str(c.column))}"
        for name, c in given.items()
        if c.source == "given" and name not in draft.asked
    ]
    words += [f"--device {draft.device}"] * (draft.device != "single")
    if chosen.source == "given":
        words += [f"--rate {chosen.rate:g}"] if chosen.rate is not None else []
        words += [f'--lead "{chosen.lead:g} m"'] if chosen.lead is not None else []
        for option, texts in (("constant", chosen.constants), ("scale", chosen.scales)):
            words += [f"--{option} {shell_word(f'{name}={text}')}" for name, text in texts.items()]
    proposed: list[str] = []
    for signal, error in draft.asked.items():
        example = {"time": '--time "COLUMN [s]"', "lead": '--lead "10 mm"', "input": '--input "COLUMN"'}
        taken = [*draft.columns.values(), *_reserved(draft), *proposed]
        position = "--position" in error.remedy and f"--position {error.remedy.partition('--position ')[2]}"
        words.append(position or example.get(signal) or guessed_columns.example(draft.table, signal, taken))
        label = shlex.split(words[-1])[1]
        proposed += [label, split_label(label)[0]]
    return words


def _ask_time(draft: _Draft, chosen: ColumnMap) -> None:
    """Whether there is a clock of any kind; see `_clock`."""
    table = draft.table
    try:
        draft.stamps = column = _stamp_column(draft, chosen)
        if column is not None:
            _seconds(column[1], column[0])
            draft.choices["time"] = ColumnChoice(*column)
    except MappingError as error:
        draft.asked["time"] = error
        return
    hint = table.sample_period or _header_rate(table)
    if column is None and chosen.rate is None and table.clock is None and hint is None:
        problem = f"no time column and no sampling rate; the file has: {columns_listed(table)}"
        draft.asked["time"] = MappingError(problem, remedy='Give --time "NAME [s]" or --rate HZ')


def clocks_of(
    table: Table, chosen: ColumnMap
) -> tuple[list[tuple[NDArray[np.int64], timing.LogClock]], set[str], list[str]]:
    """The clock of each run of a log, which a restart of its time column ends.

    Args:
        table: columns as in the file.
        chosen: what the user said of time or rate; the rest is guessed.

    Returns:
        For each run the rows of the table that its clock keeps, and the clock; the columns that tell the time or count
        rows; and a sentence on each choice.

    Raises:
        MappingError, TimingError: no time, or time that cannot be put right.
    """
    draft = _Draft(table, "single")
    _ask_time(draft, chosen)
    column = draft.stamps
    stamps = table.clock if column is None and chosen.rate is None else None
    stamps = stamps if column is None else table.columns[column[0]]
    rows = np.arange(table.rows) if stamps is None else np.flatnonzero(np.isfinite(stamps))
    back = [] if stamps is None else (1 + np.flatnonzero(np.diff(stamps[rows]) < 0)).tolist()
    runs: list[tuple[NDArray[np.int64], timing.LogClock]] = []
    with placed(table.name):
        for error in draft.asked.values():
            raise error
        for part in np.split(rows, back):
            if back and part.size < timing.MINIMUM_ROWS:
                draft.notes.append(f"{part.size} rows between two restarts of the clock left out")
                continue
            cut = {name: values[part] for name, values in table.columns.items()}
            draft.table = replace(table, columns=cut, clock=None if table.clock is None else table.clock[part])
            clock = _clock(draft, chosen, np.arange(part.size))
            draft.notes.extend(clock.notes)
            runs.append((part[clock.keep], clock))
        timing.require_rows(sum(kept.size for kept, _ in runs))
    return runs, {*_reserved(draft), *([table.clock_name] if table.clock_name else [])}, draft.notes


def _signals_of(device: DeviceName) -> set[str]:
    return {signal for group in NEEDS[device] for option in group for signal in option} | set(OPTIONAL[device])


def _take_chosen(draft: _Draft, chosen: ColumnMap) -> None:
    """The columns that the user named."""
    allowed = _signals_of(draft.device)
    for signal, choice in chosen.columns.items():
        if signal == "field" and str(choice.column).strip() == _NONE and _NONE not in draft.table.columns:
            _take_no_field(draft)
            continue
        if signal not in allowed and signal != "temperature":
            problem = f"'{signal}' is no signal of a {draft.device} device (it has: {', '.join(sorted(allowed))})"
            raise MappingError(problem, remedy="Use one of these, or set --device")
        try:
            if signal == "temperature":
                _take_temperature(draft, choice)
            else:
                _take(draft, signal, choice, chosen.scales.get(signal))
        except MappingError as error:
            draft.asked[signal] = error


def _take_temperature(draft: _Draft, choice: ColumnChoice) -> None:
    """The temperature as a further input, in K."""
    name, unit, factor = locate(draft.table, choice, "temperature")
    values = draft.table.columns[name]
    key = f"{_INPUT}{TEMPERATURE}"
    draft.signals[key] = units.kelvin(values if factor == 1.0 else values * factor, unit, name)
    draft.columns[key] = name
    draft.choices["temperature"] = ColumnChoice(name, unit, factor, choice.source)
    draft.notes.append(f"temperature <- column {name} [{unit}], in K ({choice.source})")


def _take(draft: _Draft, signal: str, choice: ColumnChoice, scale_text: str | None = None) -> str:
    """Convert one column to SI and take it as a signal; the note says all that was done to it. Its name."""
    name, unit, factor = locate(draft.table, choice, signal)
    values, asked = draft.table.columns[name], draft.table.units.get(name)
    draft.choices[signal] = ColumnChoice(name, unit, factor, choice.source)
    if scale_text is not None:
        scale, si, how = _by_scale(signal, name, unit, scale_text)
        factor *= scale
    elif unit is None:
        si, how = _assumed_unit(draft.device, signal, values)
    else:
        scale, si = units.conversion(unit, SIGNALS[signal], name)
        factor *= scale
        how = f", converted to {si or 'a plain number'}" if scale != 1.0 else ""
        how += f" (the file says {asked})" if asked and asked != unit else ""
    how += ", sign turned" if factor < 0 else ""
    draft.signals[signal] = values if factor == 1.0 else values * factor
    draft.units[signal] = si
    draft.columns[signal] = name
    draft.notes.append(f"{signal} <- column {f'{name} [{unit}]' if unit else name}{how} ({choice.source})")
    return name


def _by_scale(signal: str, name: str, unit: str | None, text: str) -> tuple[float, str, str]:
    """Factor, SI unit and note of a column that a scale makes a signal of: ``2.5 N*m/V`` for one in volts."""
    number, made, sensor = scaled(text, signal)
    unit = None if unit in COUNTS else unit
    if sensor is not None and unit is not None:
        found = units.fits(unit, (sensor,))
        if found is None:
            problem = f"column '{name}' has the unit '{unit}', and the scale of {signal} is {text}"
            raise UnitError(problem, remedy=f"Give the scale in {signal} per {unit}, or the column's unit")
        number *= found[0]
    elif unit is not None and made is not None:
        problem = f"column '{name}' has the unit '{unit}', and the scale of {signal}, {text}, names no unit of a sensor"
        raise UnitError(problem, remedy=f"Write it like --scale {shell_word(f'{signal}={text}/{unit}')}")
    made = made if made is not None else unit
    if made is None:
        return number, units.UNKNOWN, f", times {text}, no unit: taken as logged"
    factor, si = units.conversion(made, SIGNALS[signal], name)
    return number * factor, si, f", times {text}"


def _assumed_unit(device: DeviceName, signal: str, values: Array) -> tuple[str, str]:
    """The unit of a column that has none: unknown for a single device, SI for the coaxial pair."""
    usual = SIGNALS[signal].si_units[0]
    if device == "single":
        return units.UNKNOWN, ", no unit: taken as logged"
    if usual:
        return usual, f", no unit: assumed {usual}"
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if largest > 0.5:
        return units.UNKNOWN, f", no unit and up to {largest:g}: taken as logged"
    return "", ", no unit and within 0.5: taken as a plain number"


def _take_constants(draft: _Draft, chosen: ColumnMap) -> None:
    """Numbers of the mapping and of the file's name; one that is called like a signal becomes a constant signal."""
    table = draft.table
    given: dict[str, tuple[float, str | None, str]] = {}
    if chosen.name_pattern:
        for key, (number, unit) in name_pattern.constants_of(chosen.name_pattern, table.name).items():
            given[key] = (number, unit, "from the file's name")
    for key, text in chosen.constants.items():
        if "," in text:
            _take_steps(draft, key, text, chosen.source)
        else:
            given[key] = (*_quantity(key, text), chosen.source)
    allowed = _signals_of(draft.device)
    for key, (number, unit, source) in given.items():
        text = f"{number:g} {unit}" if unit else f"{number:g}"
        if key not in allowed:
            draft.constants[key] = number
            draft.notes.append(f"{key} = {text} ({source})")
        elif key in draft.signals:
            draft.notes.append(f"{key} = {text} ({source}) not used: column {draft.columns.get(key, '?')} was chosen")
        else:
            values = np.full(table.rows, number)
            converted = units.conversion(unit, SIGNALS[key], key) if unit else None
            factor, si = converted or (1.0, _assumed_unit(draft.device, key, values)[0])
            draft.signals[key], draft.units[key] = values * factor, si
            draft.constants[key] = number * factor
            draft.notes.append(f"{key} <- constant {text} ({source})")


def _take_steps(draft: _Draft, key: str, text: str, source: str) -> None:
    """A signal that is constant in each segment: one number after another, the unit behind the last (``0, 1 A``)."""
    *earlier, last = text.split(",")
    final, unit = _quantity(key, last)
    numbers = (*(_quantity(key, number)[0] for number in earlier), final)
    if key not in SIGNALS:
        raise MappingError(f"{key} is no signal", remedy="Give one number")
    factor, si = units.conversion(unit, SIGNALS[key], key) if unit else (1.0, "?")
    draft.stepped[key] = tuple(number * factor for number in numbers)
    draft.signals[key], draft.units[key] = np.full(draft.table.rows, numbers[0] * factor), si
    draft.notes.append(f"{key} <- {text.strip()}, one number a segment ({source})")


def _quantity(key: str, text: str) -> tuple[float, str | None]:
    try:
        return units.quantity(text)
    except UnitError as error:
        raise MappingError(f"the constant {key} is '{text}'", remedy=error.remedy) from error


def _step_signals(draft: _Draft, signals: dict[str, Array], starts: NDArray[np.intp], stops: NDArray[np.intp]) -> None:
    for key, numbers in draft.stepped.items():
        if len(numbers) != starts.size:
            rows = [f"{n:,}" for n in stops - starts]
            listed = f"{', '.join(rows[:8])}{', ...' if len(rows) > 8 else ''}"
            problem = f"{len(numbers)} numbers for {key} and {starts.size} segments between gaps, of {listed} rows"
            raise MappingError(problem, remedy="Give one number for each")
        signals[key] = _frozen(np.repeat(np.array(numbers), (stops - starts).astype(np.int64)))


def _take_guesses(draft: _Draft, chosen: ColumnMap) -> None:
    """Guess what the device needs and nobody chose; raise where nothing or too much would do."""
    taken = [*draft.columns.values(), *_reserved(draft)]
    fieldless: MappingError | None = None  # of a log without a column that is the field; asked for unless none may be
    for group in NEEDS[draft.device]:
        settled = any(draft.present(option) or draft.asked.keys() & set(option) for option in group)
        failure: MappingError | None = None
        for option in group:
            # An alternative to what is there (E beside E1 and E2), not something more (theta).
            says_the_same = ("E",) in group or (option == ("alpha_raw",) and "alpha" in draft.signals)
            for signal in option:
                if signal in draft.signals or signal in draft.asked or (settled and says_the_same):
                    continue
                scale = chosen.scales.get(signal)
                sensor = scaled(scale, signal)[2] if scale else None
                try:
                    found = guessed_columns.guess(draft.table, signal, taken, (sensor,) if sensor else ())
                except MappingError as error:
                    failure = failure or error
                    continue
                if found is not None:
                    taken.append(_take(draft, signal, found, scale))
            settled = settled or draft.present(option)
        if not settled:
            names = " or ".join(" and ".join(option) for option in group)
            needed = next(signal for signal in group[0] if signal not in draft.signals)
            error = _or_a_pair(draft, failure or guessed_columns.missing(draft.table, needed, taken, names))
            draft.asked[needed] = error
            if needed == "field" and failure is None:
                fieldless = error
    if fieldless is not None:
        inputs = [split_label(str(choice.column))[0] for choice in chosen.inputs]
        inputs += [str(choice.column) for choice in chosen.inputs]
        if not guessed_columns.maybe_field(draft.table, [*taken, *inputs]):
            del draft.asked["field"]
            _take_no_field(draft)


def _take_no_field(draft: _Draft) -> None:
    """The field as 0 in all rows, for a device whose field nobody logged."""
    draft.signals["field"], draft.units["field"] = np.zeros(draft.table.rows), units.UNKNOWN
    draft.notes.append(f"{NO_FIELD}: taken as one constant field, written as 0")


def _or_a_pair(draft: _Draft, error: MappingError) -> MappingError:
    """The error, with another remedy where the columns look like those of a coaxial pair."""
    fields = [guessed_columns.candidates(draft.table, signal, ())[0] for signal in ("E1", "E2")]
    if draft.device != "single" or not all(fields):
        return error
    first, second = (names[0] for names in fields)
    remedy = f"{error.remedy}; if {first} and {second} are the fields of a coaxial pair, --device coaxial"
    return MappingError(error.problem, remedy=remedy)


def _take_optional(draft: _Draft, chosen: ColumnMap) -> None:
    """What the device may have besides, if one column is called so and is finite; it never stops a reading."""
    taken = [*draft.columns.values(), *_reserved(draft)]
    for signal in OPTIONAL[draft.device]:
        found = [] if signal in draft.signals else guessed_columns.candidates(draft.table, signal, taken)[0]
        if len(found) == 1 and np.all(np.isfinite(draft.table.columns[found[0]])):
            _take(draft, signal, ColumnChoice(found[0], source="guessed from its name"))


def _take_inputs(draft: _Draft, chosen: ColumnMap) -> None:
    """Further inputs that the user named, as logged; they travel with the signals under a name of their own."""
    for choice in chosen.inputs:
        try:
            name, _, factor = locate(draft.table, choice, "input")
        except MappingError as error:
            draft.asked["input"] = error
            continue
        values = draft.table.columns[name]
        draft.signals[f"{_INPUT}{name}"] = values if factor == 1.0 else values * factor
        draft.columns[f"{_INPUT}{name}"] = name
        draft.notes.append(f"further input <- column {name}, as logged ({choice.source})")


def _spare(draft: _Draft, chosen: ColumnMap) -> None:
    """Columns of finite numbers that change and that nothing has taken; `fit.ladder` says what they are good for."""
    taken = {*draft.columns.values(), *_reserved(draft), *draft.table.truths}
    for name, values in draft.table.columns.items():
        if (
            name not in taken
            and units.is_temperature(draft.table.units.get(name))
            and "temperature" not in draft.choices
        ):
            option = f"--temperature {shell_word(f'{name} [{draft.table.units[name]}]')}"
            draft.notes.append(f"column {name} is a temperature, and no law uses it: {option} lets them")
        if name not in taken and values.size and np.isfinite(values).all() and np.ptp(values) > 0:
            draft.signals[f"{_SPARE}{name}"] = values
        if sum(key.startswith(_SPARE) for key in draft.signals) == _MOST_SPARE:
            return


def _counters(table: Table) -> list[str]:
    return [name for name in table.columns if name.replace(" ", "").lower() == _COUNTER]


def _reserved(draft: _Draft) -> list[str]:
    """Columns that are no signals: the time, the sample counter."""
    return [*_counters(draft.table), *([draft.stamps[0]] if draft.stamps else [])]


def _turn_screw(draft: _Draft, chosen: ColumnMap) -> None:
    """Replace alpha_raw: alpha = alpha_raw 2 pi / lead, equation 4 of Huang and Ishikawa."""
    if "alpha_raw" not in draft.signals:
        return
    if chosen.lead is None:
        problem = "alpha_raw is the position on a screw whose lead is not given"
        draft.asked["lead"] = MappingError(problem, remedy='Give the lead, such as --lead "10 mm"')
        return
    raw = draft.signals.pop("alpha_raw")
    del draft.units["alpha_raw"]
    column = draft.columns.pop("alpha_raw", "")
    if "alpha" in draft.signals:
        draft.notes.append(f"column {column} (alpha_raw) not used: alpha itself is logged")
        return
    draft.signals["alpha"], draft.units["alpha"], draft.columns["alpha"] = raw * (2 * pi / chosen.lead), "rad", column
    draft.notes.append(f"alpha = alpha_raw * 2 pi / lead with a lead of {chosen.lead:g} m")


def _stamp_column(draft: _Draft, chosen: ColumnMap) -> tuple[str, str | None, float, str] | None:
    """Name, unit, factor and source of the time column, if there is one to use."""
    if chosen.rate is not None:
        return None
    if chosen.time is not None:
        return *locate(draft.table, chosen.time, "time"), chosen.time.source
    name = guessed_columns.time_column(draft.table, draft.columns.values())
    choice = ColumnChoice(name or "", source="guessed from its name or unit")
    return None if name is None else (*locate(draft.table, choice, "time"), choice.source)


def _bad_stamps(draft: _Draft, invalid: Invalid) -> Mask:
    """Rows without a finite time stamp; an error unless they are to be dropped."""
    column = draft.stamps
    if column is None:
        return np.zeros(draft.table.rows, dtype=np.bool_)
    bad = ~np.isfinite(draft.table.columns[column[0]])
    if bad.any():
        _refuse_or_note(draft, {column[0]: bad}, invalid)
    return bad


def _invalid_rows(draft: _Draft, invalid: Invalid) -> Mask:
    """Rows where a signal is not finite; an error unless they are to be dropped."""
    unsampled = draft.table.unsampled
    known = np.zeros(draft.table.rows, dtype=np.bool_) if unsampled is None else unsampled
    each = {draft.columns.get(signal, signal): ~np.isfinite(values) for signal, values in draft.signals.items()}
    each = {name: bad & ~known for name, bad in each.items() if (bad & ~known).any()}
    if each:
        _refuse_or_note(draft, each, invalid)
    for signal, values in draft.signals.items():
        size = np.abs(np.where(np.isfinite(values), values, 0.0))
        if float(size.max(initial=0.0)) > _LARGEST:
            row, name = int(size.argmax()), draft.columns.get(signal, signal)
            raise LogError(
                f"column {name} is {values[row]:.3g} {draft.units.get(signal, '')}".rstrip()
                + f" in data row {draft.table.first_row + row + 1}, beyond {_LARGEST:.0e}, which nothing measures",
                remedy="Correct the row, or leave it out with --skip",
            )
    if known.any():
        many = int(known.sum())
        draft.notes.append(f"{many} steps of the loop had no good sample: left out, the log cut there")
    return np.logical_or.reduce([*each.values(), known])


def _refuse_or_note(draft: _Draft, each: Mapping[str, Mask], invalid: Invalid) -> None:
    name, bad = next(iter(each.items()))
    row, count = int(np.argmax(bad)), int(bad.sum())
    values = draft.table.columns.get(name)
    shown = "nan" if values is None or np.isnan(values[row]) else "infinity" if values[row] > 0 else "-infinity"
    many = f"{count} value{'s' if count > 1 else ''} missing or infinite"
    text = f"column {name} has {many}, the first ({shown}) in data row {draft.table.first_row + row + 1}"
    if invalid == "error":
        raise LogError(text, remedy="Correct them, or cut the log there with --invalid drop")
    total = int(np.logical_or.reduce(list(each.values())).sum())
    others = "".join(f", column {other} {int(rows.sum())}" for other, rows in list(each.items())[1:])
    draft.notes.append(f"{text}{others}: {total} rows dropped, the log cut there")


def _clock(draft: _Draft, chosen: ColumnMap, rows: NDArray[np.int64]) -> timing.LogClock:
    """The best clock there is: a rate, a time column, a date column, the header's period."""
    table, notes = draft.table, draft.notes
    if chosen.rate is not None:
        notes.append(f"time from the sampling rate of {chosen.rate:g} Hz ({chosen.source})")
        return timing.from_rate(rows.size, 1.0 / chosen.rate)
    hint = table.sample_period or _header_rate(table)
    column = draft.stamps
    if column is not None:
        name, unit, factor, source = column
        scale = _seconds(unit, name)
        stamps, how = table.columns[name][rows] * (factor * scale), f", converted from {unit}" if scale != 1.0 else ""
        if not unit:
            stamps, how = _unitless(stamps)
        notes.append(f"time <- column {name}{how} ({source})")
    elif table.clock is not None:
        name, stamps = table.clock_name, table.clock
        notes.append(f"time <- date and time in column {name}")
    elif hint is not None:
        counter = next(iter(_counters(table)), None)
        notes.append(f"time from the sampling period in the header: {hint:g} s")
        if counter is None or not np.isfinite(table.columns[counter]).all():
            return timing.from_rate(rows.size, hint)
        name, stamps = counter, (table.columns[counter] - table.columns[counter][0]) * hint
    else:
        raise AssertionError("a log without a clock was asked about")
    clock = timing.from_stamps(stamps, _same_as_before(table, name, rows), column=name, hint=hint)
    if column is not None and not column[1] and clock.period >= _SLOW:
        remedy = f"if it counts milliseconds, give --time {shell_word(f'{name} [ms]')}"
        notes.append(f"{name} has no unit, and in s its rows are {clock.period:.4g} s apart: {remedy}")
    return clock


def _unitless(stamps: Array) -> tuple[Array, str]:
    """Stamps without a unit in s, and as what they were taken.

    They may be dates as spreadsheets number them (1954 to 2119, at 1 Hz or faster) or a time since 1970 (2001 to 2100).
    """
    steps = np.abs(np.diff(stamps))
    if stamps.size > 1 and np.all((stamps > 20_000) & (stamps < 80_000)) and np.median(steps) < 1.2e-5:
        return (stamps - np.floor(stamps[0])) * 86_400.0, ", no unit: dates as spreadsheets number them, taken as days"
    for unit, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if stamps.size and np.all((stamps * factor > 1e9) & (stamps * factor < 4.1e9)):
            return (stamps - stamps[0]) * factor, f", no unit: a time since 1970, taken as {unit}"
    return stamps, ", no unit: taken as s"


def _seconds(unit: str | None, name: str) -> float:
    if unit is None:
        return 1.0
    found = units.fits(unit, ("s",)) if units.is_unit(unit) else None
    if found is None:
        problem = f"column '{name}' has the unit '{unit}', which is no unit of time"
        raise UnitError(problem, remedy=f"Give its unit, such as --time {shell_word(f'{name} [ms]')}")
    return found[0]


def _header_rate(table: Table) -> float | None:
    """The period of a header constant such as ``fs``."""
    for name, value in table.constants.items():
        plain = name.lower().replace("_", "")
        if plain in {"fs", "rate", "samplerate", "samplingrate"} and 0 < value < float("inf"):
            return 1.0 / value
    return None


def _same_as_before(table: Table, time: str, rows: NDArray[np.int64]) -> Mask:
    """Whether a row equals the one before in all columns but the time."""
    same = np.ones(rows.size, dtype=np.bool_)
    same[:1] = False
    left_out = {time, *_counters(table)}
    for kept in (values[rows] for name, values in table.columns.items() if name not in left_out):
        same[1:] &= (kept[1:] == kept[:-1]) | (np.isnan(kept[1:]) & np.isnan(kept[:-1]))
    return same


def _recording(
    draft: _Draft, clock: timing.LogClock, rows: NDArray[np.int64], bad: Mask, mapping: tuple[str, str] | None
) -> tuple[Recording, NDArray[np.int64]]:
    """Take the rows that are left and cut the segments where rows are missing."""
    kept = rows[clock.keep]
    first = np.zeros(kept.size, dtype=np.bool_)
    first[list(clock.starts)] = True
    part = np.cumsum(first)  # which segment of the clock a row is in
    fine = ~bad[kept]
    timing.require_rows(int(fine.sum()))
    place = np.flatnonzero(fine)
    starts = np.flatnonzero(np.concatenate(([True], (np.diff(place) > 1) | (np.diff(part[fine]) > 0))))
    stops = np.append(starts[1:], place.size)
    signals = {name: _frozen(values[kept[fine]]) for name, values in draft.signals.items()}
    extras, spare = (
        {name.removeprefix(mark): signals.pop(name) for name in list(signals) if name.startswith(mark)}
        for mark in (_INPUT, _SPARE)
    )
    _step_signals(draft, signals, starts, stops)
    recording = Recording(
        name=draft.table.name,
        signals=MappingProxyType(signals),
        units=MappingProxyType(draft.units),
        time=_frozen(clock.time[fine]),
        period=clock.period,
        segments=tuple((int(start), int(stop)) for start, stop in zip(starts, stops, strict=True)),
        uniform=clock.uniform,
        digest=draft.table.digest,
        constants=MappingProxyType(draft.constants),
        origin=draft.table.origin,
        extras=MappingProxyType(extras),
        spare=MappingProxyType(spare),
        notes=(*draft.notes, *clock.notes),
        mapping=mapping,
    )
    return recording, kept[fine]


def _frozen(values: Array) -> Array:
    values = np.ascontiguousarray(values, dtype=np.float64).copy()
    values.setflags(write=False)
    return values
