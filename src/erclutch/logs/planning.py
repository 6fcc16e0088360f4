"""A plan is made of a table: what the user said goes first, names and units say the rest, and what is open is asked.

Nothing is converted here: `erclutch.logs.applied.apply` does what the plan says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from erclutch.errors import LogError, MappingError, SettingError, UnitError, placed, shell_word
from erclutch.logs import columns
from erclutch.logs.clock_planning import clock_plan, counters
from erclutch.logs.labels import split_label
from erclutch.logs.mapping import NONE, ColumnChoice, ColumnMap
from erclutch.logs.motions import another_motion, odd_rate
from erclutch.logs.name_pattern import constants_of
from erclutch.logs.named_columns import locate
from erclutch.logs.plan import NEEDS, OPTIONAL, ClockPlan, Invalid, Plan, Question, SignalPlan, Sureness
from erclutch.logs.proposals import proposals
from erclutch.logs.sensor_scales import by_sensor, scaled
from erclutch.logs.shapes import has_shape_of
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.channels import NOT_MEASURED
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NO_FIELD, SIGNALS

_MOST_SPARE = 8
_TEMPERATURE = "temperature"
#: Columns that say how a row came about, and measure nothing.
_STATES = ("flags", "events", "status", "state")
_OF_A_NAME = "from the file's name"
_NEEDED = (signal for groups in NEEDS.values() for group in groups for option in group for signal in option)
_OPTIONAL = (signal for signals in OPTIONAL.values() for signal in signals)
#: Signals stand in one order in a plan, whoever chose them, so that plans can be compared.
_ORDER = [*dict.fromkeys((*_NEEDED, *_OPTIONAL)), _TEMPERATURE]


@dataclass
class _Draft:
    """A plan in the making."""

    table: Table
    told: ColumnMap
    device: DeviceName
    signals: dict[str, SignalPlan] = field(default_factory=dict[str, SignalPlan])
    inputs: list[SignalPlan] = field(default_factory=list[SignalPlan])
    spare: list[str] = field(default_factory=list[str])
    declined: list[str] = field(default_factory=list[str])  # signals that the user said no column is
    clock: ClockPlan | None = None
    constants: dict[str, float] = field(default_factory=dict[str, float])
    questions: dict[str, Question] = field(default_factory=dict[str, Question])
    notes: list[str] = field(default_factory=list[str])

    @property
    def taken(self) -> list[str]:
        """Columns that are signals, inputs, the time or a counter of samples."""
        named = [each.column for each in (*self.signals.values(), *self.inputs) if each.column]
        stamps = [self.clock.column] if self.clock is not None and self.clock.kind == "column" else []
        return [*named, *counters(self.table), *stamps]

    def ask(self, signal: str, error: MappingError) -> None:
        """Keep an error as a question about a signal."""
        self.questions[signal] = Question.of(signal, error)


def plan_of(table: Table, told: ColumnMap, *, device: DeviceName | None = None, invalid: Invalid | None = None) -> Plan:
    """The plan of a table.

    Args:
        table: columns as in the file.
        told: what the user and the mapping file said; the rest is guessed from names and units.
        device: "single" or "coaxial"; decides which signals are needed. None: what a recording of the live loop says,
            and "single" for all other logs.
        invalid: "error" refuses values that are not finite, "drop" cuts the log there; None is what the mapping says.

    Raises:
        MappingError: a signal that the device does not have, a column that is two signals, a constant that is none.
        LogError: a column that is named, or that is called like a signal that nobody named, holds no numbers.
        SettingError: another device or way with invalid values than these.
    """
    notes = list(table.notes)
    if device is None:
        device = table.device or "single"
        if table.device is not None:
            notes.append(f"a recording of the live loop: its channels are those of a {device} device")
    if device not in NEEDS:
        raise SettingError(f"there is no device '{device}'", remedy=f"Use one of {', '.join(NEEDS)}")
    invalid = invalid or ("drop" if told.invalid == "drop" else "error")
    if invalid not in ("error", "drop"):
        raise SettingError(f"invalid is '{invalid}'", remedy="Use error or drop")
    draft = _Draft(table, told, device, constants=dict(table.constants), notes=notes)
    with placed(table.name):
        _refuse_unreadable_signals(draft)
        _take_named(draft)
        _take_clock(draft)
        _take_constants(draft)
        _guess_what_is_needed(draft)
        _take_what_may_be(draft)
        _take_inputs(draft)
        _look_at_the_rest(draft)
        _turn_screw(draft)
        if odd := odd_rate(table, draft.signals.get("slip"), draft.signals.get("position"), draft.clock):
            _tell_odd_rate(draft, odd)
        _refuse_effort_as_input(draft)
    return Plan(
        log=table.name,
        device=device,
        signals=tuple(sorted(draft.signals.values(), key=lambda each: _ORDER.index(each.signal))),
        clock=draft.clock,
        inputs=tuple(draft.inputs),
        spare=tuple(draft.spare),
        constants=draft.constants,
        invalid=invalid,
        questions=tuple(draft.questions.values()),
        labels={name: table.label(name) for name in table.columns},
        told=told,
        notes=tuple(draft.notes),
        path=table.path,
        examples=tuple(proposals(table, told, draft.taken, draft.signals, draft.questions)) if draft.questions else (),
    )


def _refuse_unreadable_signals(draft: _Draft) -> None:
    """Raise a LogError for a column that is called like a signal, or like the time, and holds no numbers.

    Only where nothing else was chosen for that signal, and no other column is called so: the log would be read without
    the signal.
    """
    table, told = draft.table, draft.told
    settled = {*told.columns, *told.constants}
    if settled & {"slip", "position"}:
        settled |= {"slip", "position"}
    wanted = {signal for group in NEEDS[draft.device] for option in group for signal in option} - settled
    if told.name_pattern:
        wanted -= {signal for signal in wanted if f"{{{signal}}}" in told.name_pattern}
    timed = told.time is not None or told.rate is not None or table.clock is not None

    for name, problem in table.unreadable.items():
        meant = columns.meant_by(name, wanted, time=not timed)
        readable = (columns.meant_by(other, {meant}, time=meant == "time") for other in table.columns)
        if not meant or any(readable):
            continue
        remedy = f"Correct its cells, or say what the {meant} is: --{meant} {shell_word('NAME [unit]')}"
        remedy += ", or --field none if it was not logged" if meant == "field" else ""
        raise LogError(f"{problem}, and it is called like the {meant}", remedy=remedy)


def _take_named(draft: _Draft) -> None:
    """The columns that the user named."""
    allowed = {signal for group in NEEDS[draft.device] for option in group for signal in option}
    allowed |= {*OPTIONAL[draft.device], _TEMPERATURE}
    for signal, choice in draft.told.columns.items():
        declined = draft.told.declines(signal) and NONE not in draft.table.columns
        if signal == "field" and declined:
            _take_no_field(draft)
            continue
        if signal not in allowed:
            own = ", ".join(sorted(allowed - {_TEMPERATURE}))
            problem = f"'{signal}' is no signal of a {draft.device} device (it has: {own})"
            raise MappingError(problem, remedy="Use one of these, or set --device")
        if declined:
            draft.declined.append(signal)
            draft.notes.append(f"{signal}: no column is taken for it ({choice.source})")
            continue
        try:
            if signal == _TEMPERATURE:
                _take_temperature(draft, choice)
            else:
                _take(draft, signal, choice)
        except MappingError as error:
            draft.ask(signal, error)


def _take_no_field(draft: _Draft, others: Sequence[str] = ()) -> None:
    """The field as 0 in all rows, for a device whose field nobody logged; ``others`` says why each column is none."""
    draft.signals["field"] = SignalPlan("field", numbers=(0.0,), si=units.UNKNOWN, reason=NO_FIELD)
    why = f" ({'; '.join(others)})" if others else ""
    draft.notes.append(f"{NO_FIELD}: taken as one constant field, written as 0{why}")


def _take_temperature(draft: _Draft, choice: ColumnChoice) -> None:
    """The temperature as a further input, in K."""
    name, unit, factor = locate(draft.table, choice, _TEMPERATURE)
    units.kelvin(draft.table.columns[name] * factor, unit, name)
    draft.signals[_TEMPERATURE] = SignalPlan(
        _TEMPERATURE, name, unit, scale=factor, factor=factor, si="K", reason=choice.source
    )
    draft.notes.append(f"temperature <- column {name} [{unit}], in K ({choice.source})")


def _take(draft: _Draft, signal: str, choice: ColumnChoice, sureness: Sureness = "given") -> str:
    """Take one column as a signal; the note says all that is done to it. Its name."""
    name, unit, scale = locate(draft.table, choice, signal)
    in_file = draft.table.units.get(name)
    scale_text = draft.told.scales.get(signal)
    factor = scale
    if scale_text is not None:
        sensor, si, how = by_sensor(signal, name, unit, scale_text)
        factor *= sensor
    elif unit is None:
        si, how = _assumed_unit(draft.device, signal, draft.table.columns[name])
    else:
        to_si, si = units.conversion(unit, SIGNALS[signal], name)
        factor *= to_si
        how = f", converted to {si or 'a plain number'}" if to_si != 1.0 else ""
        how += f" (the file says {in_file})" if in_file and in_file != unit else ""
    how += ", sign turned" if factor < 0 else ""
    others = () if sureness == "given" else columns.of_fitting_unit(draft.table, signal, [*draft.taken, name])
    draft.signals[signal] = SignalPlan(
        signal,
        name,
        unit,
        scale,
        factor,
        si,
        reason=choice.source,
        sureness=sureness,
        alternatives=others,
    )
    draft.notes.append(f"{signal} <- column {f'{name} [{unit}]' if unit else name}{how} ({choice.source})")
    return name


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


def _take_clock(draft: _Draft) -> None:
    """The clock, or the question about it."""
    try:
        draft.clock = clock_plan(draft.table, draft.told, [each.column for each in draft.signals.values()])
    except MappingError as error:
        draft.ask("time", error)


def _take_constants(draft: _Draft) -> None:
    """Numbers of the mapping and of the file's name; one that is called like a signal becomes a constant signal."""
    told = draft.told
    numbers: dict[str, tuple[float, str | None, str]] = {}
    if told.name_pattern:
        for key, (number, unit) in constants_of(told.name_pattern, draft.table.name).items():
            numbers[key] = (number, unit, _OF_A_NAME)
    for key, text in told.constants.items():
        if "," in text:
            _take_steps(draft, key, text)
        else:
            numbers[key] = (*_quantity(key, text), told.source)
    allowed = {signal for group in NEEDS[draft.device] for option in group for signal in option}
    allowed |= {*OPTIONAL[draft.device]}
    for key, (number, unit, source) in numbers.items():
        text = f"{number:g} {unit}" if unit else f"{number:g}"
        if key not in allowed:
            draft.constants[key] = number
            draft.notes.append(f"{key} = {text} ({source})")
        elif key in draft.signals and not draft.signals[key].column and source == _OF_A_NAME:
            raise MappingError(
                f"{key} is {text} {source}, and it was said that none was logged",
                remedy="Leave --field none out, or --name-pattern",
            )
        elif key in draft.signals:
            column = draft.signals[key].column or "?"
            draft.notes.append(f"{key} = {text} ({source}) not used: column {column} was chosen")
        else:
            if unit:
                factor, si = units.conversion(unit, SIGNALS[key], key)
            else:
                factor, si = 1.0, _assumed_unit(draft.device, key, np.array([number]))[0]
            draft.signals[key] = SignalPlan(key, unit=unit, si=si, numbers=(number * factor,), reason=source)
            draft.constants[key] = number * factor
            draft.notes.append(f"{key} <- constant {text} ({source})")


def _take_steps(draft: _Draft, key: str, text: str) -> None:
    """A signal that is constant in each segment: one number after another, the unit behind the last (``0, 1 A``)."""
    *earlier, last = text.split(",")
    final, unit = _quantity(key, last)
    numbers = (*(_quantity(key, number)[0] for number in earlier), final)
    if key not in SIGNALS:
        raise MappingError(f"{key} is no signal", remedy="Give one number")
    factor, si = units.conversion(unit, SIGNALS[key], key) if unit else (1.0, units.UNKNOWN)
    in_si = tuple(number * factor for number in numbers)
    draft.signals[key] = SignalPlan(key, unit=unit, si=si, numbers=in_si, reason=draft.told.source)
    draft.notes.append(f"{key} <- {text.strip()}, one number a segment ({draft.told.source})")


def _quantity(key: str, text: str) -> tuple[float, str | None]:
    try:
        return units.quantity(text)
    except UnitError as error:
        raise MappingError(f"the constant {key} is '{text}'", remedy=error.remedy) from error


def _guess_what_is_needed(draft: _Draft) -> None:
    """Guess what the device needs and nobody named; ask where nothing or too much would do."""
    table = draft.table
    taken = draft.taken
    unlogged_field = False
    for group in NEEDS[draft.device]:
        settled = any(all(s in draft.signals for s in option) or draft.questions.keys() & {*option} for option in group)
        doubt: MappingError | None = None
        for option in group:
            # An alternative to what is there (E beside E1 and E2), not something more (theta).
            says_the_same = ("E",) in group or (option == ("alpha_raw",) and "alpha" in draft.signals)
            for signal in option:
                known = signal in draft.signals or signal in draft.questions or signal in draft.declined
                if known or (settled and says_the_same):
                    continue
                scale = draft.told.scales.get(signal)
                sensor = scaled(scale, signal)[2] if scale else None
                try:
                    motion = next((draft.signals[s].column for s in ("slip", "position") if s in draft.signals), "")
                    guess = columns.guess(table, signal, taken, (sensor,) if sensor else (), motion)
                except MappingError as error:
                    doubt = doubt or error
                    continue
                if signal == "position" and motion and guess is not None:
                    other = another_motion(table, guess, motion)
                    draft.notes += [other] if other else []
                    guess = None if other else guess
                if guess is not None:
                    taken.append(_take(draft, signal, guess, _sureness(table, signal, guess)))
            settled = settled or all(signal in draft.signals for signal in option)
        if not settled:
            names = " or ".join(" and ".join(option) for option in group)
            needed = next(signal for signal in group[0] if signal not in draft.signals)
            draft.ask(needed, _or_a_pair(draft, doubt or columns.missing(table, needed, taken, names)))
            unlogged_field = unlogged_field or (needed == "field" and doubt is None)
    if unlogged_field:  # asked for only where a column may be it
        inputs = [split_label(str(choice.column))[0] for choice in draft.told.inputs]
        inputs += [str(choice.column) for choice in draft.told.inputs]
        if not columns.maybe_field(table, [*taken, *inputs]):
            del draft.questions["field"]
            others = {name: columns.why_no_field(table, name) for name in table.columns if name not in taken}
            _take_no_field(draft, [f"{name} {why}" for name, why in others.items() if why])


def _tell_odd_rate(draft: _Draft, odd: str) -> None:
    """Ask about a slip in another unit than its position says; where the user gave the slip, only say so."""
    slip = draft.signals["slip"]
    if slip.sureness == "given":
        draft.notes.append(odd)
    else:
        remedy = f"Say which is right, such as --slip {shell_word(draft.table.label(slip.column))}"
        draft.ask("slip", MappingError(odd, remedy=remedy))


def _sureness(table: Table, signal: str, guess: ColumnChoice) -> Sureness:
    """How sure a guess is: name and unit agree, or one of them speaks; a unit alone asks for the shape too."""
    name = str(guess.column)
    if " name" in guess.source:
        return "sure" if columns.has_fitting_unit(table, name, signal) else "likely"
    return "likely" if has_shape_of(signal, table.columns[name]) else "doubtful"


def _or_a_pair(draft: _Draft, error: MappingError) -> MappingError:
    """The error, with another remedy where the columns look like those of a coaxial pair."""
    fields = [columns.candidates(draft.table, signal, ())[0] for signal in ("E1", "E2")]
    if draft.device != "single" or not all(fields):
        return error
    first, second = (names[0] for names in fields)
    remedy = f"{error.remedy}; if {first} and {second} are the fields of a coaxial pair, --device coaxial"
    return MappingError(error.problem, remedy=remedy)


def _take_what_may_be(draft: _Draft) -> None:
    """What the device may have besides, if one column is called so and is finite; it never stops a reading."""
    for signal in OPTIONAL[draft.device]:
        if signal in draft.signals or signal in draft.declined:
            continue
        called, _ = columns.candidates(draft.table, signal, draft.taken)
        if len(called) == 1 and np.all(np.isfinite(draft.table.columns[called[0]])):
            _take(draft, signal, ColumnChoice(called[0], source="guessed from its name"), "likely")


def _take_inputs(draft: _Draft) -> None:
    """Further inputs that the user named, as logged; they travel with the signals under a name of their own."""
    for choice in draft.told.inputs:
        try:
            name, unit, factor = locate(draft.table, choice, "input")
        except MappingError as error:
            draft.ask("input", error)
            continue
        draft.inputs.append(SignalPlan("input", name, unit, factor, factor, reason=choice.source))
        draft.notes.append(f"further input <- column {name}, as logged ({choice.source})")


def _look_at_the_rest(draft: _Draft) -> None:
    """Columns of finite numbers that change and that nothing has taken; `fit.ladder` says what they are good for."""
    taken = {*draft.taken, *draft.table.truths, *_STATES}
    if draft.table.device is not None:
        taken |= {*NOT_MEASURED}
    for name, values in draft.table.columns.items():
        if name in taken:
            continue
        unit = draft.table.units.get(name)
        if units.is_temperature(unit) and _TEMPERATURE not in draft.signals:
            option = f"--temperature {shell_word(f'{name} [{unit}]')}"
            draft.notes.append(f"column {name} is a temperature, and no law uses it: {option} lets them")
        if values.size and np.isfinite(values).all() and np.ptp(values) > 0:
            draft.spare.append(name)
            if len(draft.spare) == _MOST_SPARE:
                return


def _turn_screw(draft: _Draft) -> None:
    """Alpha = alpha_raw 2 pi / lead, equation 4 of Huang and Ishikawa, in place of alpha_raw."""
    raw = draft.signals.get("alpha_raw")
    if raw is None:
        return
    lead = draft.told.lead
    if lead is None:
        problem = "alpha_raw is the position on a screw whose lead is not given"
        draft.ask("lead", MappingError(problem, remedy='Give the lead, such as --lead "10 mm"'))
        return
    if "alpha" in draft.signals:
        del draft.signals["alpha_raw"]
        draft.notes.append(f"column {raw.column} (alpha_raw) not used: alpha itself is logged")
        return
    draft.signals["alpha_raw"] = replace(raw, lead=lead)
    draft.notes.append(f"alpha = alpha_raw * 2 pi / lead with a lead of {lead:g} m")


def _refuse_effort_as_input(draft: _Draft) -> None:
    """Refuse the effort's column as another signal: a model would find just that."""
    effort = "T" if draft.device == "coaxial" else "effort"
    own = draft.signals.get(effort)
    for each in (*draft.signals.values(), *draft.inputs):
        if own is not None and own.column and each is not own and each.column == own.column:
            raise MappingError(
                f"column {each.column} is both {each.signal} and {effort}",
                remedy=f"Name another column with --{effort} or --{each.signal}",
            )
