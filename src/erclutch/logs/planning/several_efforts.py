"""A file may hold several recordings, and a recording several efforts over one position: each of them is a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fnmatch import fnmatchcase

from erclutch.errors import MappingError
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.name_pattern import constants_of
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.planning.stated_field import differ_by_field, stated_in
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.table import Table
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NO_FIELD
from erclutch.signals.units import quantity


def logs_of(
    tables: Mapping[str, Table], chosen: ColumnMap, device: DeviceName | None
) -> list[tuple[str, Table, ColumnMap]]:
    """The logs of a file: a name, a table and a mapping for each effort of each recording.

    An effort that was not chosen may be any of several columns, and ``F_*`` stands for all columns called so. The name
    pattern may be that of efforts or recordings in place of files. A constant with as many numbers as there are logs
    gives each of them its own.
    """
    logs: list[tuple[str, Table, ColumnMap]] = []
    for name, table in tables.items():
        effort = "T" if (device or table.device) == "coaxial" else "effort"
        efforts = _efforts(table, chosen, device, effort)
        if not efforts:  # the plan finds it, or asks
            logs.append((name, table, _named(chosen, [name])))
        for each in efforts:
            column = str(each.column)
            called = f"{name} {column}".strip() if len(efforts) > 1 else name
            own = replace(chosen, columns={**chosen.columns, effort: each})
            logs.append((called, table, _named(own, [column.lstrip("- "), name])))
    numbered: list[tuple[str, Table, ColumnMap]] = []
    for place, (name, table, own) in enumerate(logs):
        numbered.append((name, table, _numbered(own, place, len(logs))))
    return _with_fields_in_names(numbered, device)


def _with_fields_in_names(
    logs: list[tuple[str, Table, ColumnMap]],
    device: DeviceName | None,
) -> list[tuple[str, Table, ColumnMap]]:
    """The logs with the fields that their names tell them apart by, such as sheets ``0A`` and ``0.5A``.

    Only where no log has a field of its own: read without one, all would be logs at field 0.
    """
    stated = {name: stated_in(name) for name, _, _ in logs}
    named = [name for name, field in stated.items() if field is not None]
    if not differ_by_field(named) or any(own.declines("field") for _, _, own in logs):
        return logs
    with_fields: list[tuple[str, Table, ColumnMap]] = []
    for name, table, own in logs:
        field = stated[name]
        plan = plan_of(table, own, device=device)
        taken = plan.signal("field")
        if plan.is_of_a_log and taken is not None and taken.reason != NO_FIELD:
            return logs
        if field is not None:
            text = f"{field.number!r} {field.unit}"
            own = replace(own, constants={"field": text, **own.constants})
            note = f"the field is {text} by the name of the recording, which differs from the others in that alone"
            table = replace(table, notes=(*table.notes, note))
        elif plan.is_of_a_log:
            return logs
        with_fields.append((name, table, own))
    return with_fields


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
        found, _ = candidates(seen_columns(table), effort, taken)
        if len(found) > 1:
            return [ColumnChoice(each, source="each is a log") for each in found]
        return []

    text = str(choice.column)
    if "*" not in text or text in table.columns:
        return []
    sign = "-" if text.startswith("-") else ""
    name, unit = split_label(text.removeprefix("-").strip())
    found = [each for each in table.columns if fnmatchcase(each, name)]
    return [replace(choice, column=sign + each, unit=choice.unit or unit) for each in found]


def _named(chosen: ColumnMap, names: list[str]) -> ColumnMap:
    """The mapping with the numbers that the name of the effort or of the recording holds, where the pattern fits it."""
    for name in names if chosen.name_pattern else []:
        try:
            found = constants_of(chosen.name_pattern or "", name)
        except MappingError:
            continue
        texts: dict[str, str] = {}
        for key, (number, unit) in found.items():
            texts[key] = f"{number!r} {unit}" if unit else f"{number!r}"
        return replace(chosen, name_pattern=None, constants={**texts, **chosen.constants})
    return chosen


def _numbered(chosen: ColumnMap, at: int, count: int) -> ColumnMap:
    """The mapping with the number of this log out of a list of as many as there are logs: ``0, 0.5, 1 A``."""
    own: dict[str, str] = {}
    for key, text in chosen.constants.items():
        *numbers, last = text.split(",")
        if numbers and len(numbers) + 1 == count:
            unit = quantity(last)[1] or ""
            own[key] = last if at == count - 1 else f"{numbers[at]} {unit}"
    return replace(chosen, constants={**chosen.constants, **own})
