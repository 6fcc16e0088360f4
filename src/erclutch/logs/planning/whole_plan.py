"""A plan is made of a table, a step after another: `plan_of` calls them all.

1. What is seen of the columns: names, units, how their numbers run, which is the time (`seen_columns`).
2. What the user said: columns (`named_columns`), the clock (`clock_planning`), numbers (`given_numbers`). A column that
   is called like a signal and holds no numbers ends it here.
3. What is needed besides is guessed (`guesses`): `candidates` and `quotients` list the columns that may be a signal, of
   several `one_of_several` takes one, of several joints `one_joint` proposes one. What two shafts differ by was made in
   front of all this (`two_shafts`). Where no column is, `missing_columns` says what to do. A guess that the log speaks
   against is doubted (`field_doubts`, `doubts`). A log has no field where `no_field` tells of each column what else it
   is; the file may still state one (`stated_field`).
4. What is left is looked at (`row_order`, `further_columns`), and what belongs together is held together (`motions`).
5. What is open is asked: `proposals` has the options that answer it.

Nothing is converted here: `erclutch.logs.applied.apply` does what the plan says.
"""

from __future__ import annotations

from erclutch.errors import ErclutchError, LogError, SettingError, placed
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.columns.two_shafts import with_differences
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import NEEDS, OPTIONAL, Invalid, Plan
from erclutch.logs.planning.clock_planning import choose_clock
from erclutch.logs.planning.current_for_effort import offer_the_current_of_a_drive
from erclutch.logs.planning.doubts import (
    ask_about_powers_of_ten,
    ask_about_ranges_of_sensors,
    doubt_a_force_at_a_stated_arm,
    doubt_a_speed_without_its_sense,
    doubt_a_torque_in_a_unit_of_force,
    doubt_effort_without_power,
    doubt_what_a_rheometer_gives,
)
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_doubts import doubt_the_field
from erclutch.logs.planning.further_columns import take_further_columns
from erclutch.logs.planning.given_numbers import take_given_numbers
from erclutch.logs.planning.guesses import guess_what_is_needed
from erclutch.logs.planning.motions import (
    ask_about_a_wrapped_angle,
    hold_power,
    hold_slip_against_position,
    refuse_the_effort_twice,
    turn_screw,
)
from erclutch.logs.planning.named_columns import refuse_unreadable_signals, take_named
from erclutch.logs.planning.no_field import settle_the_field
from erclutch.logs.planning.one_joint import propose_one_joint
from erclutch.logs.planning.proposals import proposals
from erclutch.logs.planning.row_order import (
    ask_about_groups,
    ask_about_order,
    few_values_are_missing,
    take_points,
)
from erclutch.logs.readers.lying_tables import WIDEST
from erclutch.logs.table import Table
from erclutch.signals.device import DeviceName

_NEEDED = (
    signal for groups in NEEDS.values() for group in groups for option in group for signal in option
)
_OPTIONAL = (signal for signals in OPTIONAL.values() for signal in signals)
#: Signals stand in one order in a plan, whoever chose them, so that plans can be compared.
_ORDER = [*dict.fromkeys((*_NEEDED, *_OPTIONAL)), "temperature"]


def plan_of(
    table: Table,
    told: ColumnMap,
    *,
    device: DeviceName | None = None,
    invalid: Invalid | None = None,
    whole: bool = True,
) -> Plan:
    """The plan of a table.

    Args:
        table: columns as in the file.
        told: what the user and the mapping file said; the rest is guessed from names and units.
        device: "single" or "coaxial"; decides which signals are needed. None: what a recording of the live loop or a
            log of the TWIN says, and "single" for all other logs.
        invalid: "error" refuses values that are not finite, "drop" cuts the log there; None is what the mapping says.
        whole: whether the table is the whole log; a column without a number in some rows may have numbers in others.

    Raises:
        MappingError: a signal that the device does not have, a column that is two signals, a constant that is none.
        LogError: a column that is named, or that is called like a signal that nobody named, holds no numbers.
        SettingError: another device or way with invalid values than these.
    """
    notes = list(table.notes)
    if device is None:
        device = table.device or table.simulated_device or "single"
        if table.device is not None:
            notes.append(
                f"a recording of the live loop: its channels are those of a {device} device"
            )
        elif table.simulated_device is not None:
            notes.append(f"a log of the TWIN, which says that it is of a {device} device")
    if device not in NEEDS:
        raise SettingError(
            f"there is no device '{device}'", remedy=f"Use one of {', '.join(NEEDS)}"
        )
    said = invalid or told.invalid
    invalid = invalid or ("drop" if told.invalid == "drop" else "error")
    if invalid not in ("error", "drop"):
        raise SettingError(f"invalid is '{invalid}'", remedy="Use error or drop")

    if len(table.columns) > max(WIDEST, table.rows):
        problem = f"{table.rows} rows of {len(table.columns):,} columns: a log has one row a sample"
        raise LogError(
            problem, remedy="Give a table with a column for each signal", where=table.name
        )
    with placed(table.name):
        table, told = with_differences(table, told)
    seen = seen_columns(table, whole=whole)
    if numberless := [name for name in seen.empty if name in table.columns]:
        notes.append(f"no number in any row: column {', '.join(numberless)}: left out")
    draft = Draft(seen, told, device, notes, constants=dict(table.constants))
    with placed(table.name):
        # What the user said.
        refuse_unreadable_signals(draft)
        take_named(draft)
        choose_clock(draft)
        take_given_numbers(draft)

        # What the device needs besides.
        guess_what_is_needed(draft)
        propose_one_joint(draft)
        offer_the_current_of_a_drive(draft)
        ask_about_ranges_of_sensors(draft)
        ask_about_powers_of_ten(draft)
        doubt_the_field(draft)
        settle_the_field(draft)

        # What the rows are; some rows of a log do not tell it.
        if whole:
            take_points(draft)
            if not said and few_values_are_missing(draft):
                invalid = "drop"  # without these rows the others are what they were
            ask_about_order(draft)
            ask_about_groups(draft)

        # What is left, and what belongs together.
        take_further_columns(draft)
        turn_screw(draft)
        hold_slip_against_position(draft)
        ask_about_a_wrapped_angle(draft)
        hold_power(draft)
        refuse_the_effort_twice(draft)
        doubt_a_speed_without_its_sense(draft)
        doubt_a_force_at_a_stated_arm(draft)
        doubt_effort_without_power(draft)
        doubt_a_torque_in_a_unit_of_force(draft)
        doubt_what_a_rheometer_gives(draft)
        examples = proposals(draft) if draft.questions else []

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
        labels={
            name: table.label(name)
            for name in table.columns
            if name not in table.made or name in draft.taken
        },
        told=told,
        notes=tuple(draft.notes),
        path=table.path,
        examples=tuple(examples),
    )


def is_log(table: Table, told: ColumnMap | None = None, device: DeviceName | None = None) -> bool:
    """Whether a table has columns of a motion and an effort.

    Args:
        table: columns as in the file.
        told: what the user said of them; None: nothing.
        device: whose signals count; see `plan_of`.
    """
    try:
        return plan_of(table, told or ColumnMap(), device=device).is_of_a_log
    except ErclutchError:
        return False


def signals_of(table: Table) -> set[str]:
    """Signals that have a column in a table, by names and units alone."""
    try:
        return {each.signal for each in plan_of(table, ColumnMap()).signals if each.column}
    except ErclutchError:
        return set()
