"""A file may hold several recordings, and a recording several efforts over one position: each of them is a log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_names import (
    differ_by_field,
    field_set_in,
    fields_told_by,
    stated_in,
)
from erclutch.logs.columns.name_pattern import constants_of
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.planning.stated_field import ask_about_specimens
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.table import Table
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NO_FIELD
from erclutch.signals.units import quantity

#: A log of a file: a name, its table, and what is said of its columns.
Log = tuple[str, Table, ColumnMap]


def logs_of(tables: Mapping[str, Table], chosen: ColumnMap, device: DeviceName | None) -> list[Log]:
    """The logs of a file: a name, a table and a mapping for each effort of each recording.

    An effort that was not chosen may be any of several columns, and ``F_*`` stands for all columns called so. The name
    pattern may be that of efforts or recordings in place of files. A constant with as many numbers as there are logs
    gives each of them its own.
    """
    logs: list[Log] = []
    for name, table in tables.items():
        effort = (
            "T" if (device or table.device or table.simulated_device) == "coaxial" else "effort"
        )
        efforts = _efforts(table, chosen, device, effort)
        if not efforts:  # the plan finds it, or asks
            # As the log is called where it is asked about: ``sheets.xlsx: 4 clicks``.
            names = [name, f"{table.name}: {name}"]
            logs.append((name, table, _with_numbers_of_names(chosen, names)))
        for choice in efforts:
            column = str(choice.column)
            own = replace(chosen, columns={**chosen.columns, effort: choice})
            own = _with_numbers_of_names(own, [column.lstrip("- "), name])
            called = f"{name} {column}".strip() if len(efforts) > 1 else name
            logs.append((called, table, own))
    # Of a list of as many numbers as there are logs each takes its own: ``0, 0.5, 1 A``.
    numbered: list[Log] = []
    for place, (name, table, own) in enumerate(logs):
        constants = dict(own.constants)
        for key, text in own.constants.items():
            *numbers, last = text.split(",")
            if numbers and len(numbers) + 1 == len(logs):
                _, unit = quantity(last)
                is_last = place == len(logs) - 1
                constants[key] = last if is_last else f"{numbers[place]} {unit or ''}"
        numbered.append((name, table, replace(own, constants=constants)))
    return _with_fields_in_names(numbered, device)


def _efforts(
    table: Table,
    chosen: ColumnMap,
    device: DeviceName | None,
    effort: str,
) -> list[ColumnChoice]:
    """The columns that are efforts of their own; none where the effort is one column, or nobody knows of any."""
    choice = chosen.columns.get(effort)
    if choice is None:
        plan = plan_of(table, replace(chosen, name_pattern=None), device=device)
        if not any(question.signal == effort for question in plan.questions):
            return []
        taken = [each.column for each in plan.signals]
        names, _ = candidates(seen_columns(table), effort, taken)
        if len(names) < 2:
            return []
        return [ColumnChoice(name, source="each is a log") for name in names]

    label = str(choice.column)
    if "*" not in label or label in table.columns:
        return []
    sign = "-" if label.startswith("-") else ""
    pattern, unit = split_label(label.removeprefix("-").strip())
    efforts: list[ColumnChoice] = []
    for name in table.columns:
        if fnmatchcase(name, pattern):
            efforts.append(replace(choice, column=sign + name, unit=choice.unit or unit))
    return efforts


def _with_numbers_of_names(chosen: ColumnMap, names: Sequence[str]) -> ColumnMap:
    """The mapping with the numbers that the name of the effort or of the recording holds, where the pattern fits it."""
    pattern = chosen.name_pattern
    if not pattern:
        return chosen
    for name in names:
        try:
            numbers = constants_of(pattern, name)
        except MappingError:
            continue
        texts: dict[str, str] = {}
        for key, (number, unit) in numbers.items():
            texts[key] = f"{number!r} {unit}" if unit else f"{number!r}"
        return replace(chosen, name_pattern=None, constants={**texts, **chosen.constants})
    return chosen


def _with_fields_in_names(logs: list[Log], device: DeviceName | None) -> list[Log]:
    """The logs with the fields that their names tell them apart by, such as sheets ``0A`` and ``0.5A``.

    Only where no log has a field of its own: read without one, all would be logs at field 0.

    Raises:
        MappingError: some names state a field and the others nothing, or all state the same; the field of each log is
            asked for.
    """
    names = [name for name, _, _ in logs]
    told = fields_told_by(names)
    stated = told or {name: field for name in names if (field := stated_in(name)) is not None}
    if not stated or any(own.declines("field") for _, _, own in logs):
        return logs
    alone = ", which differs from the others in that alone" if differ_by_field([*told]) else ""
    with_fields: list[Log] = []
    silent: list[str] = []  # logs whose names say nothing
    for name, table, own in logs:
        plan = plan_of(table, own, device=device)
        taken = plan.signal("field")
        has_own_field = taken is not None and taken.reason != NO_FIELD
        if plan.is_of_a_log and has_own_field:
            return logs
        field = stated.get(name)
        if field is not None:
            text = f"{field.number!r} {field.unit or ''}".strip()
            own = replace(own, constants={"field": text, **own.constants})
            beside = alone
            if not alone and not field_set_in(name):
                beside = ", which differs from the others in more than that"
            note = f"the field is {text} by the name of the recording{beside}"
            table = replace(table, notes=(*table.notes, note))
        elif plan.is_of_a_log:
            silent.append(name)
        with_fields.append((name, table, own))
    if len(logs) > 1 and (silent or not told):
        quoted = ", ".join(
            f"{name!r} says {field.number:g} {field.unit}" for name, field in stated.items()
        )
        unit = next(iter(stated.values())).unit or ""
        # The unit stands behind the last number and is that of all: 500 mA beside 1 A is for the user to write.
        of_one_unit = len({field.unit for field in stated.values()}) == 1
        numbers: list[str] = []
        for name in names:
            is_known = of_one_unit and name in stated
            numbers.append(f"{stated[name].number:g}" if is_known else "NUMBER")
        given = shell_word(f"field={', '.join(numbers)} {unit}".strip())
        option = f"--variable all --constant {given}"
        problem = f"no log has a column for field, and of their names {quoted}"
        remedy = f"Give the field of each log: {option}; or --variable all --field none"
        raise MappingError(problem, remedy=remedy, option=option)
    for _, _, own in logs[:1]:
        ask_about_specimens([*told], own)
    return with_fields if told else logs
