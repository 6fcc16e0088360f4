"""A plan is made of a table, step after step: `STEPS` lists the rules of reading, and `plan_of` goes through them.

A rule takes the draft of the plan and settles one thing of it. The order counts: what the user said goes first, a guess
before what doubts it, and the answers that are proposed come last. Whoever follows a log's way reads what each rule
settles and passes over the rules; whoever adds a rule writes a file for it and a line here.

Nothing is converted here: `erclutch.logs.applied.apply` does what the plan says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from erclutch.errors import ErclutchError, LogError, SettingError, placed
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import NEEDS, OPTIONAL, Invalid, Plan
from erclutch.logs.planning.act_or_actuator import doubt_what_act_means
from erclutch.logs.planning.axes_of_spectra import pass_over_axes_of_spectra
from erclutch.logs.planning.clock_planning import choose_clock
from erclutch.logs.planning.current_for_effort import offer_the_current_of_a_drive
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.effort_doubts import (
    add_a_stated_arm,
    doubt_a_force_at_a_stated_arm,
    doubt_a_share_of_a_rated_torque,
    doubt_a_torque_in_a_unit_of_force,
    doubt_an_effort_of_a_controller,
    doubt_an_effort_with_inertia,
    doubt_effort_without_power,
    doubt_the_torque_of_a_drive,
)
from erclutch.logs.planning.field_doubts import (
    doubt_the_command_of_a_drive,
    doubt_the_current_of_a_drive,
    doubt_the_current_of_a_motor_under_test,
    doubt_the_monitor_of_an_amplifier,
    doubt_the_sensor_of_the_motion,
    doubt_the_voltage_of_a_machine,
    leave_out_the_number_of_a_motor,
    leave_out_the_sensor_of_the_effort,
    leave_out_the_supply_of_a_drive,
)
from erclutch.logs.planning.first_look import make_differences, see_columns
from erclutch.logs.planning.further_columns import (
    note_spare_columns,
    take_inputs,
    take_optional_signals,
)
from erclutch.logs.planning.given_numbers import take_given_numbers
from erclutch.logs.planning.guesses import guess_what_is_needed
from erclutch.logs.planning.idle_channels import pass_over_idle_and_raw_channels
from erclutch.logs.planning.missing_values import drop_few_missing_values
from erclutch.logs.planning.motion_kinds import doubt_a_position_of_another_kind
from erclutch.logs.planning.motions import (
    ask_about_a_wrapped_angle,
    hold_power,
    hold_slip_against_position,
    refuse_the_effort_twice,
    turn_screw,
)
from erclutch.logs.planning.motor_under_test import leave_out_what_feeds_a_motor_under_test
from erclutch.logs.planning.named_columns import refuse_unreadable_signals, take_named
from erclutch.logs.planning.nameless_columns import propose_columns_without_names
from erclutch.logs.planning.no_field import settle_the_field
from erclutch.logs.planning.one_joint import propose_one_joint
from erclutch.logs.planning.open_units import (
    ask_about_powers_of_ten,
    ask_about_ranges_of_sensors,
)
from erclutch.logs.planning.parted_rows import ask_about_groups, ask_about_woven_devices
from erclutch.logs.planning.parts_of_a_test import ask_about_parts_of_a_test
from erclutch.logs.planning.planned_files import doubt_what_was_planned
from erclutch.logs.planning.points import say_what_is_a_map, take_points
from erclutch.logs.planning.proposals import propose_answers
from erclutch.logs.planning.raw_numbers import doubt_numbers_of_a_converter, say_what_has_no_column
from erclutch.logs.planning.rheometer_columns import (
    doubt_a_shear_rate_beside_a_torque,
    doubt_an_oscillation,
    pass_over_oscillations,
)
from erclutch.logs.planning.row_order import ask_about_order, sort_mixed_rows
from erclutch.logs.planning.rows_of_tests import (
    doubt_the_mean_of_a_motion_to_and_fro,
    propose_rows_of_tests,
)
from erclutch.logs.planning.scaled_signals import doubt_signals_scaled_for_a_network
from erclutch.logs.planning.sense_of_effort import doubt_an_effort_without_its_sense
from erclutch.logs.planning.sense_of_speed import doubt_a_speed_without_its_sense
from erclutch.logs.planning.settings_of_a_rig import ask_about_a_setting_of_the_rig
from erclutch.logs.planning.stated_factors import doubt_numbers_with_a_stated_factor
from erclutch.logs.planning.stated_scales import (
    doubt_a_position_in_counts,
    doubt_a_side_of_a_stated_gear,
    fill_in_stated_scales,
    offer_stated_scales,
)
from erclutch.logs.planning.stated_slip import offer_a_stated_slip
from erclutch.logs.planning.torn_columns import read_torn_columns
from erclutch.logs.planning.twin_speeds import (
    doubt_a_speed_before_a_gear,
    doubt_one_of_twin_speeds,
)
from erclutch.logs.planning.units_in_names import doubt_units_in_names
from erclutch.logs.planning.unsure_names import doubt_what_unsure_names_say
from erclutch.logs.planning.valve_in_flow_mode import propose_flow_and_pressure
from erclutch.logs.table import A_COLUMN_EACH, Table
from erclutch.signals.device import DeviceName

_NEEDED = (
    signal for groups in NEEDS.values() for group in groups for option in group for signal in option
)
_OPTIONAL = (signal for signals in OPTIONAL.values() for signal in signals)
_EFFORTS = ("effort", "T")
#: Signals stand in one order in a plan, whoever chose them, so that plans can be compared.
_ORDER = [*dict.fromkeys((*_NEEDED, *_OPTIONAL)), "temperature"]


class Step(NamedTuple):
    """One rule of reading.

    Attributes:
        settles: what is known behind it.
        rule: writes that into the draft, raises where the log cannot be read, and does nothing where it has no say.
        needs_all_rows: whether some rows of a log do not tell it.
    """

    settles: str
    rule: Callable[[Draft], None]
    needs_all_rows: bool = False


#: All rules of reading, in the order in which they are gone through.
STEPS = (
    # What stands in the file.
    Step("which columns with damaged cells are needed", read_torn_columns),
    Step("what two shafts differ by has a column", make_differences),
    Step("what each column says by name, unit and numbers", see_columns),
    # What the user said.
    Step("no column that is called like a signal holds words", refuse_unreadable_signals),
    Step("which columns the user named", take_named),
    Step("by which clock the rows are counted", choose_clock),
    Step("which numbers the user, a mapping or the file's name gives", take_given_numbers),
    # What the device needs besides.
    Step("which columns hold sizes of an oscillation", pass_over_oscillations),
    Step("which columns are frequencies of a spectrum", pass_over_axes_of_spectra),
    Step("which channels no supply feeds", pass_over_idle_and_raw_channels),
    Step("which column each signal is that nobody named", guess_what_is_needed),
    Step("whether a valve's flow rate and pressure drop are meant", propose_flow_and_pressure),
    Step("which of several joints is proposed", propose_one_joint),
    Step("whether a drive's current may stand for the effort", offer_the_current_of_a_drive),
    Step("which column a stated scale is for", offer_stated_scales),
    Step("whether a unit names the range of a sensor", ask_about_ranges_of_sensors),
    Step("whether a power of ten was multiplied already", ask_about_powers_of_ten),
    # Whether the guessed field is a field: what surely is none goes first.
    Step("the field is not the output of the effort's sensor", leave_out_the_sensor_of_the_effort),
    Step("the field is not the number of a motor", leave_out_the_number_of_a_motor),
    Step(
        "the field is not the current whose power makes an efficiency",
        leave_out_what_feeds_a_motor_under_test,
    ),
    Step("the field is not the current of a drive", doubt_the_current_of_a_drive),
    Step(
        "the field is not the current of a motor under test",
        doubt_the_current_of_a_motor_under_test,
    ),
    Step("the field is not the supply of a drive", leave_out_the_supply_of_a_drive),
    Step("the field is not the voltage of a machine", doubt_the_voltage_of_a_machine),
    Step("the field is not the output of the motion's sensor", doubt_the_sensor_of_the_motion),
    Step("the field is not what a drive was told", doubt_the_command_of_a_drive),
    Step("the field is not the monitor of an amplifier", doubt_the_monitor_of_an_amplifier),
    Step("whether the file states the field, or has none", settle_the_field),
    Step("whether a setting of the rig parts the efforts", ask_about_a_setting_of_the_rig),
    Step("whether a field was set for each part of a test", ask_about_parts_of_a_test),
    # What the rows are.
    Step("whether the rows are points in no time", take_points, needs_all_rows=True),
    Step("whether each row sums up a test", propose_rows_of_tests, needs_all_rows=True),
    Step("whether the rows are a map of efforts at rest", say_what_is_a_map, needs_all_rows=True),
    Step("whether rows without a number are dropped", drop_few_missing_values, needs_all_rows=True),
    Step("whether the rows were mixed up", sort_mixed_rows, needs_all_rows=True),
    Step("whether the time runs forward", ask_about_order, needs_all_rows=True),
    Step("whether rows of devices take turns", ask_about_woven_devices, needs_all_rows=True),
    Step("whether the rows are of one device", ask_about_groups, needs_all_rows=True),
    # What is left, and what belongs together.
    Step("which signals that the device may have are there", take_optional_signals),
    Step("which columns the user wants as inputs", take_inputs),
    Step("which other columns may be of use", note_spare_columns),
    Step("by which lead a position on a screw is an angle", turn_screw),
    Step("whether the slip is the rate of the position", hold_slip_against_position),
    Step("whether a position is an angle that wraps", ask_about_a_wrapped_angle),
    Step("whether slip times effort is the logged power", hold_power),
    Step("no column is the effort and another signal", refuse_the_effort_twice),
    Step("whether act means actual or actuator", doubt_what_act_means),
    Step("whether the slip is one of two shafts' speeds", doubt_one_of_twin_speeds),
    Step("whether a gear stands between the slip and the effort", doubt_a_speed_before_a_gear),
    Step("whether the slip has its sign", doubt_a_speed_without_its_sense),
    Step("whether the effort has its sign", doubt_an_effort_without_its_sense),
    Step("whether a force works at an arm", doubt_a_force_at_a_stated_arm),
    Step("whether a drive tells a share of its rated torque", doubt_a_share_of_a_rated_torque),
    Step("which scales and zeros are for no column", say_what_has_no_column),
    Step("whether a signal is in numbers of a converter", doubt_numbers_of_a_converter),
    Step("whether motion and effort were scaled for a network", doubt_signals_scaled_for_a_network),
    Step("whether the effort is a mean to and fro", doubt_the_mean_of_a_motion_to_and_fro),
    Step("whether a drive computed the effort beside a sensor", doubt_the_torque_of_a_drive),
    Step("whether a position in counts wants a stated number", doubt_a_position_in_counts),
    Step("whether slip or effort wants a stated ratio of a gear", doubt_a_side_of_a_stated_gear),
    Step("whether numbers want a stated factor", doubt_numbers_with_a_stated_factor),
    Step("whether the effort is the device's alone", doubt_an_effort_with_inertia),
    Step("whether a controller computed the effort", doubt_an_effort_of_a_controller),
    Step("whether slip and effort make a power", doubt_effort_without_power),
    Step("whether position and effort make a power", doubt_a_position_of_another_kind),
    Step("whether the effort's name and unit are of one kind", doubt_a_torque_in_a_unit_of_force),
    Step("the slip is no shear rate beside a torque", doubt_a_shear_rate_beside_a_torque),
    Step("the effort is no size of an oscillation", doubt_an_oscillation),
    Step("whether the file is called a plan or a simulation", doubt_what_was_planned),
    Step("whether a name holds a unit that nobody read", doubt_units_in_names),
    Step("whether the names stand over their columns", doubt_what_unsure_names_say),
    # What only the user can say.
    Step("which columns without names may be asked about", propose_columns_without_names),
    Step("whether the file states a speed for all rows", offer_a_stated_slip),
    Step("whether a weight that is offered pulls at an arm", add_a_stated_arm),
    Step("which options answer what is open", propose_answers),
    Step("whether the file states a number that they ask for", fill_in_stated_scales),
)


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
    if said not in ("error", "drop", None):
        raise SettingError(f"invalid is '{said}'", remedy="Use error or drop")
    if table.lying:
        raise LogError(table.lying, remedy=A_COLUMN_EACH, where=table.name)

    draft = Draft(table, told, device, said, whole, notes=notes, constants=dict(table.constants))
    # A stranger's column may hold infinities, or numbers whose squares are infinite. What a rule makes of them is no
    # number, and meets none of its conditions: nobody needs a warning of NumPy about it.
    with placed(table.name), np.errstate(over="ignore", invalid="ignore"):
        for step in STEPS:
            if whole or not step.needs_all_rows:
                step.rule(draft)

    table = draft.table
    return Plan(
        log=table.name,
        device=device,
        signals=tuple(sorted(draft.signals.values(), key=lambda each: _ORDER.index(each.signal))),
        clock=draft.clock,
        inputs=tuple(draft.inputs),
        spare=tuple(draft.spare),
        constants=draft.constants,
        invalid=draft.invalid or "error",
        questions=tuple(draft.questions.values()),
        labels=draft.labels,
        told=draft.told,
        notes=tuple(draft.notes),
        path=table.path,
        examples=tuple(draft.examples),
        joints=tuple(draft.joints),
    )


def sure_plan_of(
    table: Table, told: ColumnMap, device: DeviceName | None, invalid: Invalid | None
) -> Plan:
    """The plan of a table by which a log may be read: nothing is open, and nothing rests on little ground.

    The arguments are those of `plan_of`.

    Raises:
        MappingError, LogError, SettingError: see `plan_of`, and `Plan.require_sureness`.
    """
    plan = plan_of(table, told, device=device, invalid=invalid)
    plan.require_sureness()
    return plan


def plan_if_any(
    table: Table, told: ColumnMap | None = None, device: DeviceName | None = None
) -> Plan | None:
    """The plan of a table; None for a table that no plan can be made of.

    Args:
        table: columns as in the file.
        told: what the user said of them; None: nothing.
        device: whose signals count; see `plan_of`.
    """
    try:
        return plan_of(table, told or ColumnMap(), device=device)
    except ErclutchError:
        return None


def plans_of_logs(
    tables: Sequence[tuple[str, Table, ColumnMap]], device: DeviceName | None
) -> dict[str, Plan]:
    """The plans of those tables that are logs, by name.

    A prediction asks for no effort: a constant stands for it. Its log is the recording that `fit` would take; where no
    recording has an effort, each with a motion is a log.

    Args:
        tables: a name, a table and what the user said of its columns, each.
        device: see `erclutch.read`.
    """
    with_effort: dict[str, Plan] = {}
    with_motion: dict[str, Plan] = {}
    for name, table, told in tables:
        plan = plan_if_any(table, told, device)
        if plan is None:
            continue
        constants = {key: text for key, text in told.constants.items() if key not in _EFFORTS}
        as_for_a_fit = plan
        if len(constants) < len(told.constants):
            as_for_a_fit = plan_if_any(table, replace(told, constants=constants), device)
            if plan.has_motion:
                with_motion[name] = plan
        if as_for_a_fit is not None and as_for_a_fit.is_of_a_log:
            with_effort[name] = plan
    return with_effort or with_motion


def nearest_to_a_log(
    tables: Mapping[str, Table], told: ColumnMap, device: DeviceName | None
) -> str:
    """The name of the table that holds most of what a device needs, and of those the most rows; "" of no tables."""

    def nearness(name: str) -> tuple[int, int]:
        plan = plan_if_any(tables[name], told, device)
        in_sight = 0 if plan is None else len(plan.signals_in_sight)
        return in_sight, tables[name].rows

    return max(tables, key=nearness, default="")


def is_log(table: Table) -> bool:
    """Whether a table has columns of a motion and an effort, by names and units alone."""
    plan = plan_if_any(table)
    return plan is not None and plan.is_of_a_log


def signals_of(table: Table) -> set[str]:
    """Signals that have a column in a table, by names and units alone."""
    plan = plan_if_any(table)
    return set() if plan is None else plan.signals_with_columns
