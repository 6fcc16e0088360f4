"""What the device needs and nobody named is guessed; where nothing or too much would do, the user is asked."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns import Guess, candidates, guess
from erclutch.logs.draft import Draft
from erclutch.logs.labels import split_label
from erclutch.logs.missing_columns import missing
from erclutch.logs.no_field import maybe_field, why_no_field
from erclutch.logs.plan import NEEDS, Sureness
from erclutch.logs.sensor_scales import scaled
from erclutch.logs.shapes import is_rate_of
from erclutch.logs.stated_field import take_stated_field
from erclutch.signals.recording import SIGNALS
from erclutch.signals.units import UNKNOWN

#: A coil that makes a field draws more than this, in A, in V or as logged.
_FAINT_FIELD = 1e-3


def guess_what_is_needed(draft: Draft) -> None:
    """Guess each signal that the device needs; ask where nothing or too much would do."""
    taken = [*draft.taken, *draft.table.truths]
    unlogged_field = False
    for group in NEEDS[draft.device]:
        settled = any(
            all(signal in draft.signals for signal in option) or draft.questions.keys() & {*option} for option in group
        )
        doubt: MappingError | None = None
        for option in group:
            # An alternative to what is there (E beside E1 and E2), not something more (theta).
            says_the_same = ("E",) in group or (option == ("alpha_raw",) and "alpha" in draft.signals)
            for signal in option:
                known = signal in draft.signals or signal in draft.questions or signal in draft.declined
                if known or (settled and says_the_same):
                    continue
                scale = draft.told.scales.get(signal)
                _, _, sensor = scaled(scale, signal) if scale else (1.0, None, None)
                motion = next(
                    (draft.signals[each].column for each in ("slip", "position") if each in draft.signals), ""
                )
                try:
                    found = guess(draft.seen, signal, taken, (sensor,) if sensor else (), motion)
                except MappingError as error:
                    doubt = doubt or error
                    continue
                if found is not None and _take_guess(draft, signal, found, motion):
                    taken.append(found.column)
                    if signal == "field":
                        _tell_supplies(draft, found.column, taken)
            settled = settled or all(signal in draft.signals for signal in option)

        if not settled:
            needed = next(signal for signal in group[0] if signal not in draft.signals)
            names = " or ".join(" and ".join(option) for option in group)
            or_a_pair = _pair_remedy(draft)
            error = doubt or missing(draft.seen, needed, taken, names)
            draft.ask(needed, MappingError(error.problem, remedy=error.remedy + or_a_pair))
            unlogged_field = unlogged_field or (needed == "field" and doubt is None)

    if unlogged_field:  # asked for only where a column may be it
        inputs = [str(choice.column) for choice in draft.told.inputs]
        inputs += [split_label(label)[0] for label in inputs]
        if not maybe_field(draft.seen, [*taken, *inputs]):
            del draft.questions["field"]
            if take_stated_field(draft):
                return
            whys = [(column.name, why_no_field(draft.seen, column, taken)) for column in draft.seen.without(taken)]
            draft.take_no_field([f"{name} {why}" for name, why in whys if why])


def _take_guess(draft: Draft, signal: str, found: Guess, motion: str) -> bool:
    """Take a column that was guessed, and say how sure that is; False for a position that goes with no slip."""
    table = draft.table
    column = draft.seen.columns[found.column]
    named = found.reason.startswith("name")
    if signal == "position" and motion and column.shape.constant and not draft.seen.columns[motion].shape.constant:
        draft.notes.append(f"column {column.name} never changes while {motion} does: left out, it is no position")
        return False
    if signal == "position" and motion and not named:
        # A gap and a travel of something else have the unit of a position too.
        speed = table.columns[motion]
        if not is_rate_of(speed, column.values, draft.seen.stamps):
            option = f"--position {shell_word(table.label(column.name))}"
            why = f"column {column.name} has the unit of a position, and column {motion} is not its rate"
            draft.notes.append(f"{why}: left out ({option} takes it)")
            return False

    si_units = SIGNALS[signal].si_units
    sureness: Sureness
    if named:  # name and unit agree, or the name speaks alone
        sureness = "sure" if column.fits(si_units) else "likely"
    else:  # a unit alone asks for the shape too
        sureness = "likely" if column.shape.looks_like(signal) else "doubtful"
    draft.take(signal, column.name, column.unit_for(si_units), 1.0, f"guessed from its {found.reason}", sureness)
    taken = draft.signals[signal]
    strongest = float(np.nanmax(np.abs(column.values), initial=0.0)) * abs(taken.factor)
    called_field = column.spoken.forms["field"] == "field"
    if signal == "field" and not called_field and taken.si in ("A", "V", UNKNOWN) and 0.0 < strongest < _FAINT_FIELD:
        doubt = f"which never exceeds {strongest:.3g}, as the output of a sensor: --field none if it drives no coil"
        draft.signals[signal] = replace(taken, sureness="doubtful", doubt=doubt)
    return True


def _tell_supplies(draft: Draft, field: str, taken: Iterable[str]) -> None:
    """Say which columns could be the field by their names and units, and are that of a supply by their numbers."""
    if not draft.seen.columns[field].varies:
        return
    for column in draft.seen.without(taken):
        if column.fits(("V", "A")) and "field" in column.spoken.may_be and column.is_steady:
            low, high = np.nanmin(column.values), np.nanmax(column.values)
            course = (
                f"keeps near one level, {low:.4g} to {high:.4g} {column.unit_for(('V', 'A'))}, while {field} changes"
            )
            draft.notes.append(f"column {column.name} {course}: taken for a supply, left out")


def _pair_remedy(draft: Draft) -> str:
    """What else would help where the columns of a single device look like those of a coaxial pair; "" elsewhere."""
    first, _ = candidates(draft.seen, "E1", ())
    second, _ = candidates(draft.seen, "E2", ())
    if draft.device != "single" or not first or not second:
        return ""
    return f"; if {first[0]} and {second[0]} are the fields of a coaxial pair, --device coaxial"
