"""Lists of one length in a column of Arrow, as LeRobot writes the joints of a robot, become a column a place."""

from __future__ import annotations

from typing import Any

from erclutch.logs.readers.budget import LONGEST_LIST


def is_of_number_lists(kind: Any) -> bool:
    """Whether a column of this type holds a list of numbers in each row."""
    from pyarrow import types

    if not (types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)):
        return False
    return bool(types.is_floating(kind.value_type) or types.is_integer(kind.value_type))


def with_lists_opened(table: Any) -> Any:
    """The table with ``state_1`` .. ``state_6`` in place of a column ``state`` of lists of six numbers.

    A column of lists of one number keeps its name. Lists of several lengths, and those of pictures, stay as they are.
    """
    import pyarrow
    from pyarrow import compute

    if not any(is_of_number_lists(field.type) for field in table.schema):
        return table
    fields: list[Any] = []
    columns: list[Any] = []
    for field, values in zip(table.schema, table.columns, strict=True):
        width = 0  # numbers in each row; none where the rows differ or one has none
        if is_of_number_lists(field.type) and not values.null_count:
            lengths: Any = compute.min_max(compute.list_value_length(values)).as_py()
            shortest = lengths["min"] or 0
            longest = lengths["max"] or 0
            width = longest if shortest == longest <= LONGEST_LIST else 0
        if not width:
            fields.append(field)
            columns.append(values)
        for place in range(width):
            name = field.name if width == 1 else f"{field.name}_{place + 1}"
            fields.append(pyarrow.field(name, field.type.value_type, metadata=field.metadata))
            columns.append(compute.list_element(values, place))
    return pyarrow.table(columns, schema=pyarrow.schema(fields, metadata=table.schema.metadata))
