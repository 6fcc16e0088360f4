"""What the device needs and nobody named is guessed; where nothing or too much would do, the user is asked."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.two_courses import is_rate_of
from erclutch.logs.columns.vocabulary import VOLTAGES
from erclutch.logs.mapping import NONE
from erclutch.logs.plan import NEEDS, SignalPlan, Sureness
from erclutch.logs.planning.draft import Draft, scaled
from erclutch.logs.planning.missing_columns import missing
from erclutch.logs.planning.one_of_several import Guess, guess
from erclutch.logs.planning.own_position import own_position
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS
from erclutch.signals.units import UNKNOWN

_NUMBER = re.compile(r"\d+")
#: A coil that makes a field draws more than this, in A or as logged.
_FAINT_FIELD = 1e-3
#: V, that the bridge of a load cell gives: 2 mV a volt of a supply of 10 V. No coil is driven by as little.
_BRIDGE = 0.02
#: Units of a field that is the output of a supply.
OF_A_SUPPLY = ("A", "V", UNKNOWN)


def guess_what_is_needed(draft: Draft) -> None:
    """Guess each signal that the device needs; ask where nothing or too much would do.

    Raises:
        MappingError: a scale that is none. UnitError: a unit that does not fit its signal.
    """
    taken = [*draft.taken, *draft.table.truths]
    for group in NEEDS[draft.device]:
        settled = False
        for option in group:
            is_asked = not draft.questions.keys().isdisjoint(option)
            if is_asked or all(signal in draft.signals for signal in option):
                settled = True

        doubts: list[MappingError] = []
        for option in group:
            # An alternative to what is there (E beside E1 and E2), not something more (theta).
            says_the_same = ("E",) in group or (
                option == ("alpha_raw",) and "alpha" in draft.signals
            )
            if settled and says_the_same:
                continue
            for signal in option:
                if signal in draft.signals or signal in draft.questions or signal in draft.declined:
                    continue
                moving = draft.signals.get("slip") or draft.signals.get("position")
                motion = moving.column if moving else ""
                scale = draft.told.scales.get(signal)
                unit_of_sensor = scaled(scale, signal)[2] if scale else None
                units_of_sensor = (unit_of_sensor,) if unit_of_sensor else ()
                try:
                    likely = guess(draft.seen, signal, taken, units_of_sensor, motion)
                except MappingError as error:
                    doubts.append(error)
                    continue
                if likely is not None and take_guess(draft, signal, likely, motion):
                    taken.append(likely.column)
                    if signal == "field":
                        _tell_supplies(draft, likely.column, taken)
            if all(signal in draft.signals for signal in option):
                settled = True
        if settled:
            if ("slip",) in group and doubts:
                _settle_several_speeds(draft, doubts[0])
            continue

        needed = next(signal for signal in group[0] if signal not in draft.signals)
        names = " or ".join(" and ".join(option) for option in group)
        first, _ = candidates(draft.seen, "E1", ())
        second, _ = candidates(draft.seen, "E2", ())
        both = f"{first[0]} and {second[0]}" if first and second else ""
        remedy = f"; if {both} are the fields of a coaxial pair, --device coaxial"
        or_a_pair = remedy if both and draft.device == "single" else ""
        error = doubts[0] if doubts else missing(draft.seen, needed, taken, names)
        error.remedy += or_a_pair
        draft.ask(needed, error)
        if not doubts:
            draft.missing.append(needed)


def _settle_several_speeds(draft: Draft, doubt: MappingError) -> None:
    """Take the one of several speeds that is the rate of the guessed position; ask where none of them is, or two are.

    With the position alone the speeds would be passed over, though one of them may be of another motion.
    """
    position = draft.signals.get("position")
    stamps = draft.seen.stamps
    if "slip" in draft.signals or stamps is None:
        return
    if position is None or not position.column or position.sureness == "given":
        return
    columns = draft.table.columns
    names, reason = candidates(draft.seen, "slip", draft.taken)
    rates: list[str] = []
    for name in names:
        if name in columns and is_rate_of(columns[name], columns[position.column], stamps):
            rates.append(name)
    if len(rates) == 1:
        rate = Guess(rates[0], f"{reason}, and it is the rate of {position.column}")
        take_guess(draft, "slip", rate, position.column)
    elif names:
        draft.ask("slip", doubt)


def take_guess(draft: Draft, signal: str, likely: Guess, motion: str) -> bool:
    """Take a column that was guessed, and say how sure that is; False for one that is not to be taken.

    So is a position that goes with no slip, and a speed at rest beside a speed that moves.
    """
    if signal == "position" and motion:
        # The position with the motion's number in its name, where the guess has the number of another joint.
        numbers = _NUMBER.findall(motion)
        if len(numbers) == len(_NUMBER.findall(likely.column)) == 1:
            own = _NUMBER.sub(numbers[0], likely.column)
            if own in draft.table.columns and own not in draft.taken:
                likely = likely._replace(column=own)
        own = own_position(draft, motion, likely.column)
        if not own:
            option = f"--position {shell_word(draft.table.label(likely.column))}"
            why = f"column {likely.column} is the position of another motion than column {motion}"
            draft.notes.append(f"{why}: left out ({option} takes it)")
            return False
        likely = likely._replace(column=own)
    column = draft.seen.columns[likely.column]
    is_named = likely.reason.startswith("name")
    others = draft.seen.without([*draft.taken, column.name])
    speeds = [each for each in others if "slip" in each.spoken.may_be and not each.shape.constant]
    if signal == "slip" and not column.values.any() and speeds:
        draft.notes.append(f"column {column.name} is 0 in all rows, and another speed is not")
        return False
    if signal == "position" and motion:
        speed = draft.seen.columns[motion]
        if column.shape.constant and not speed.shape.constant:
            draft.notes.append(
                f"column {column.name} never changes while {motion} does: left out, it is no position"
            )
            return False
        # A gap and a travel of something else have the unit of a position too.
        if not is_named and not is_rate_of(speed.values, column.values, draft.seen.stamps):
            option = f"--position {shell_word(draft.table.label(column.name))}"
            why = f"column {column.name} has the unit of a position, and column {motion} is not its rate"
            draft.notes.append(f"{why}: left out ({option} takes it)")
            return False

    si_units = SIGNALS[signal].si_units
    sureness: Sureness
    if is_named:  # name and unit agree, or the name speaks alone
        sureness = "sure" if column.fits(si_units) else "likely"
    else:  # a unit alone asks for the shape too
        sureness = "likely" if column.shape.looks_like(signal) else "doubtful"
    reason = f"guessed from its {likely.reason}"
    draft.take(signal, column.name, column.unit_for(si_units), 1.0, reason, sureness)
    strongest = faintness(draft.signals[signal], column.values) if signal == "field" else None
    if strongest is not None:
        doubt = f"which never exceeds {strongest:.3g}, as the output of a sensor"
        # A current may be in another unit; such volts come of a bridge.
        if draft.signals[signal].si == "V" or column.spoken.says(VOLTAGES):
            named = shell_word(draft.table.label(column.name))
            draft.doubt(
                signal, f"{doubt}: no field then, --field {named} if it drives a coil", NONE
            )
        else:
            draft.doubt(signal, f"{doubt}: --field none if it drives no coil")
    return True


def faintness(field: SignalPlan, values: Array) -> float | None:
    """The largest field in its unit, where that is too little for a coil; None where it may drive one."""
    strongest = float(np.nanmax(np.abs(values), initial=0.0)) * abs(field.factor)
    faint = _BRIDGE if field.si == "V" else _FAINT_FIELD
    if field.si not in OF_A_SUPPLY or not 0.0 < strongest < faint:
        return None
    is_called_field = spoken_name(field.column).forms["field"] == "field"
    return None if is_called_field else strongest


def _tell_supplies(draft: Draft, field: str, taken: Iterable[str]) -> None:
    """Say which columns could be the field by their names and units, and are that of a supply by their numbers."""
    if not draft.seen.columns[field].varies:
        return
    for column in draft.seen.without(taken):
        may_be_it = column.fits(("V", "A")) and "field" in column.spoken.may_be
        if not may_be_it or not column.is_steady:
            continue
        low = np.nanmin(column.values)
        high = np.nanmax(column.values)
        level = f"{low:.4g} to {high:.4g} {column.unit_for(('V', 'A'))}"
        course = f"keeps near one level, {level}, while {field} changes"
        draft.notes.append(f"column {column.name} {course}: taken for a supply, left out")
