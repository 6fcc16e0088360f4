"""A plan in the making: what is known of a log, and what the steps of `whole_plan` chose so far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import COUNTS, own_unit
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import (
    NEEDS,
    OPTIONAL,
    THOUGH,
    ClockPlan,
    Invalid,
    Joint,
    Question,
    SignalPlan,
    Sureness,
)
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NO_FIELD, SIGNALS

_SHARE = 0.5  # up to which a column without a unit is a plain number


@dataclass
class Draft:
    """A plan in the making; see `erclutch.logs.plan.Plan` for what is not said here.

    Attributes:
        table: as it was read, and with what two shafts differ by.
        told: what the user and the mapping file said.
        device: whose signals are looked for.
        invalid: what is done about values that are not finite; None while nobody said it.
        is_whole: whether the table is the whole log: some rows of it do not tell everything.
        notes: what was chosen, guessed, converted and assumed, one sentence each.
        seen: the table's columns, which a step near the first looks at for all others.
        constants: numbers that hold for the whole log.
        signals: what was chosen, by the signal.
        inputs: further inputs of networks, as logged.
        spare: further columns that are worth a look.
        no_signals: columns that are known to be none.
        declined: signals that the user said no column is.
        missing: signals that the device needs and that no column may be.
        clock: None while no clock was found.
        questions: what only the user can say, by the signal that it is about.
        examples: options that answer the questions.
        joints: of a log of several, each of which is a device; the proposed joint is the first.
        no_fields: why columns are no field that may be, for all that they say by themselves.
        supply: in V, that feeds a motor under test all through the log; None where no number tells it.
    """

    table: Table
    told: ColumnMap
    device: DeviceName
    invalid: Invalid | None
    is_whole: bool
    notes: list[str]
    constants: dict[str, float]
    seen: SeenColumns = field(init=False)
    signals: dict[str, SignalPlan] = field(default_factory=dict[str, SignalPlan])
    inputs: list[SignalPlan] = field(default_factory=list[SignalPlan])
    spare: list[str] = field(default_factory=list[str])
    no_signals: list[str] = field(default_factory=list[str])
    declined: list[str] = field(default_factory=list[str])
    missing: list[str] = field(default_factory=list[str])
    clock: ClockPlan | None = None
    questions: dict[str, Question] = field(default_factory=dict[str, Question])
    examples: list[str] = field(default_factory=list[str])
    joints: list[Joint] = field(default_factory=list[Joint])
    no_fields: dict[str, str] = field(default_factory=dict[str, str])
    supply: float | None = None

    @property
    def needed(self) -> set[str]:
        """Signals that the device may need."""
        return {signal for group in NEEDS[self.device] for option in group for signal in option}

    @property
    def known_signals(self) -> set[str]:
        """Signals that the device can have."""
        return {*self.needed, *OPTIONAL[self.device]}

    @property
    def labels(self) -> dict[str, str]:
        """The table's columns as a user would write them; differences that were made only where a signal is one."""
        labels: dict[str, str] = {}
        for name in self.table.columns:
            if name not in self.table.made or name in self.taken:
                labels[name] = self.table.label(name)
        return labels

    @property
    def taken(self) -> list[str]:
        """Columns that are signals, inputs, the time or a counter of samples, or that are known to be no signal."""
        chosen = [each.column for each in (*self.signals.values(), *self.inputs) if each.column]
        stamps = (
            [self.clock.column] if self.clock is not None and self.clock.kind == "column" else []
        )
        return [*chosen, *self.no_signals, *self.seen.counters, *stamps]

    @property
    def field_is_open(self) -> bool:
        """Whether no field is logged and the user has not said so: the field may still be asked for."""
        chosen = self.signals.get("field")
        is_unlogged = chosen is not None and chosen.reason == NO_FIELD
        return is_unlogged and not self.told.declines("field")

    def guessed(self, signal: str) -> SignalPlan | None:
        """The column that was guessed for a signal; None where the user chose, or nothing is chosen."""
        chosen = self.signals.get(signal)
        return chosen if chosen is not None and chosen.reason.startswith("guessed") else None

    def ask(self, signal: str, error: MappingError, option: str = "") -> None:
        """Keep an error as a question about a signal, with the option that answers it where that is known."""
        self.questions[signal] = Question(
            signal, error.problem, error.remedy, type(error), option, error.answers, error.option
        )

    def take(
        self,
        signal: str,
        name: str,
        unit: str | None,
        scale: float,
        reason: str,
        sureness: Sureness = "given",
    ) -> None:
        """Take a column as a signal; the note says all that is done to it.

        Args:
            signal: its name.
            name: of the column.
            unit: of the column; None where nobody says it.
            scale: before the unit is converted.
            reason: who chose it, or what it was guessed from.
            sureness: how sure the choice is.

        Raises:
            MappingError: a scale or a zero of a sensor that is none. UnitError: a unit that does not fit the signal.
        """
        column = self.seen.columns[name]
        sensor = self.told.scales.get(signal)
        factor = scale
        if sensor is None and unit is None:
            si, how = self.assumed_unit(signal, column.values)
        elif sensor is not None:
            by_scale, si, how = _by_sensor(signal, name, unit, sensor)
            factor *= by_scale
        else:
            to_si, si = units.conversion(unit or "", SIGNALS[signal], name)
            factor *= to_si
            how = "" if to_si == 1.0 else f", converted to {si or 'a plain number'}"
            how += _other_unit(column, unit or "", SIGNALS[signal].si_units)
        how += f", times {abs(scale):g}" if abs(scale) != 1.0 else ""
        how += ", sign turned" if factor < 0 else ""
        zero, how_zeroed = _zero_of(name, unit, self.told.zeros.get(signal), signal)
        how += how_zeroed

        alternatives: list[str] = []
        if sureness != "given":
            others = self.seen.without([*self.taken, name])
            alternatives = [other.name for other in others if other.fits(SIGNALS[signal].si_units)]
        self.signals[signal] = SignalPlan(
            signal,
            name,
            unit,
            scale,
            factor,
            si,
            offset=-zero * factor if zero else 0.0,
            reason=reason,
            sureness=sureness,
            alternatives=tuple(alternatives),
        )
        label = f"{name} [{unit}]" if unit else name
        self.notes.append(f"{signal} <- column {label}{how} ({reason})")

    def doubt(self, signal: str, why: str, answer: str = "") -> None:
        """Say why the choice for a signal is doubtful: the user is asked to confirm it, or an answer that is likely."""
        self.signals[signal] = replace(
            self.signals[signal], sureness="doubtful", doubt=why, answer=answer
        )

    def take_back(self, signal: str) -> None:
        """Take a guess back, and what was noted of it."""
        del self.signals[signal]
        self.notes[:] = [note for note in self.notes if not note.startswith(f"{signal} <- ")]

    def assumed_unit(self, signal: str, values: Array) -> tuple[str, str]:
        """The unit of numbers without a unit, with a note: unknown for a single device, SI for the coaxial pair."""
        usual = SIGNALS[signal].si_units[0]
        if self.device == "single":
            return units.UNKNOWN, ", no unit: taken as logged"
        if usual:
            return usual, f", no unit: assumed {usual}"
        largest = float(np.nanmax(np.abs(values), initial=0.0))
        if largest > _SHARE:
            return units.UNKNOWN, f", no unit and up to {largest:g}: taken as logged"
        return "", ", no unit and within 0.5: taken as a plain number"

    def take_no_field(self, others: Sequence[str] = (), *, said: bool = False) -> None:
        """Take the field as 0 in all rows, for a device whose field nobody logged.

        Args:
            others: why each column is no field.
            said: whether the user said so.
        """
        self.signals["field"] = SignalPlan(
            "field",
            numbers=(0.0,),
            si=units.UNKNOWN,
            reason=NO_FIELD,
        )
        why = f" ({'; '.join(others)})" if others else ""
        how = f"{NO_FIELD}, as was said" if said else NO_FIELD
        self.notes.append(f"{how}: taken as one constant field, written as 0{why}")


def _other_unit(column: SeenColumn, unit: str, si_units: tuple[str, ...]) -> str:
    """What is said of a unit that was given in place of that of the file; "" where both mean the same.

    Where that of the file would do too, one of the two is wrong: the check before a fit warns of it.
    """
    own = column.written_unit
    if not own or own == unit:
        return ""
    if not column.fits(si_units):
        return f" (the file says {own})"
    given = units.parse(unit)
    # 1/min of a speed is turns a minute, and no other unit.
    of_turns = own_unit(column.name, own, si_units)
    for said in (own, of_turns):
        of_file = units.parse(said or "")
        if (given.factor, given.dimension) == (of_file.factor, of_file.dimension):
            return "" if said == own else f" (the file says {own})"
    return f", {THOUGH} {own}"


def _by_sensor(
    signal: str,
    name: str,
    unit: str | None,
    text: str,
) -> tuple[float, str, str]:
    """Factor, SI unit and note of a column that a scale makes a signal of: ``2.5 N*m/V`` for a sensor in volts."""
    number, made, sensor = scaled(text, signal)
    unit = None if unit in COUNTS else unit
    if sensor is not None and unit is not None:
        fitting = units.fits(unit, (sensor,))
        if fitting is None:
            problem = f"column '{name}' has the unit '{unit}', and the scale of {signal} is {text}"
            raise UnitError(
                problem, remedy=f"Give the scale in {signal} per {unit}, or the column's unit"
            )
        number *= fitting[0]
    elif unit is not None and made is not None:
        problem = f"column '{name}' has the unit '{unit}', and the scale of {signal}, {text}, names no unit of a sensor"
        raise UnitError(
            problem, remedy=f"Write it like --scale {shell_word(f'{signal}={text}/{unit}')}"
        )
    made = made if made is not None else unit
    if made is None:
        return number, units.UNKNOWN, f", times {text}, no unit: taken as logged"
    factor, si = units.conversion(made, SIGNALS[signal], name)
    return number * factor, si, f", times {text}"


def _zero_of(name: str, unit: str | None, text: str | None, signal: str) -> tuple[float, str]:
    """What a column reads where its signal is zero, in the numbers of the column, and a note of it.

    Raises:
        MappingError: no number. UnitError: a number in another unit than the column's.
    """
    if text is None:
        return 0.0, ""
    try:
        number, written = units.quantity(text)
    except UnitError:
        number, written = float("nan"), None
    if not isfinite(number):
        remedy = f"Write it like --zero {shell_word(f'{signal}=2048')}"
        raise MappingError(f"the zero of {signal} is '{text}'", remedy=remedy)
    if written is not None and written not in COUNTS:
        fitting = units.fits(written, (unit,)) if unit and units.is_unit(written) else None
        if fitting is None:
            has = f"the unit '{unit}'" if unit else "no unit"
            problem = f"column '{name}' has {has}, and the zero of {signal} is {text}"
            remedy = "Give the number that the column reads there, without a unit"
            raise UnitError(problem, remedy=remedy)
        number *= fitting[0]
    return number, f", zero at {text}"


def scaled(text: str, signal: str) -> tuple[float, str | None, str | None]:
    """A scale such as ``2.5 N*m/V`` as 2.5, ``N*m`` and ``V``; None where it names no unit, or none of a sensor.

    Raises:
        MappingError: no number with a unit, or zero.
    """
    try:
        number, unit = units.quantity(text)
        over, _, under = (unit or "").rpartition("/")
        whole = not unit or (units.is_unit(unit) and units.fits(unit, SIGNALS[signal].si_units))
        # A per cent of the rated torque is the unit of a drive's sensor.
        whole = whole and under.strip() != "%"
        if not whole:
            over = units.parse(over).text
            under = None if under in COUNTS else units.parse(under).text
    except UnitError:
        number, whole, over, under, unit = 0.0, False, "", None, None
    if not 0 < abs(number) < float("inf"):
        problem = f"the scale of {signal} is '{text}'"
        example = f"{signal}=2.5 {SIGNALS[signal].si_units[0] or '1'}/V"
        raise MappingError(problem, remedy=f"Write it like --scale {shell_word(example)}")
    return (number, unit, None) if whole else (number, over, under)
