"""What loggers, instruments and people made of a table becomes rows under a line of names again.

Each change is a file of its own. They come in the order in which one may need what another has put right.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.declared_attributes import with_declared_names
from erclutch.logs.readers.formula_cells import without_formula_marks
from erclutch.logs.readers.keyed_heads import with_keyed_heads
from erclutch.logs.readers.ledger_numbers import with_leading_minus
from erclutch.logs.readers.lists_in_cells import with_lists_in_cells
from erclutch.logs.readers.loose_text import (
    with_a_line_of_names,
    without_brackets,
    without_brackets_of_rows,
    without_matrix,
    without_rules,
)
from erclutch.logs.readers.lying_tables import upright
from erclutch.logs.readers.numerals import with_plain_digits, with_plain_minus
from erclutch.logs.readers.padded_settings import without_padded_settings
from erclutch.logs.readers.pivoted_tables import with_pivoted_heads
from erclutch.logs.readers.printed_frames import (
    with_names_for_places,
    with_names_of_printed_frame,
)
from erclutch.logs.readers.scope_heads import with_scope_heads
from erclutch.logs.readers.serial_monitor import with_stamps_in_cells
from erclutch.logs.readers.spread_cells import without_spread_in_cells
from erclutch.logs.readers.text_bytes import unbroken, with_whole_names, without_row_marks
from erclutch.logs.readers.unit_cells import without_units_in_cells
from erclutch.logs.readers.unit_columns import with_units_in_cells
from erclutch.logs.readers.waveform_lines import with_steps_above

#: In front of a number or a quote at the beginning of a cell.
_FORMULA_MARK = re.compile(r"""(?:^|[,;\t|])[ ]?"?(?:=["\d.+-]|'[\d.+-])""", re.MULTILINE)


def put_right(text: str) -> tuple[str, list[str]]:
    """The text as a table of rows, whatever its logger made of these; and a note on each change.

    A search for one character is fast: most texts have none of these marks, and need no further look.
    """
    notes: list[str] = []
    if " -> " in text:
        text, stamps_in_cells = with_stamps_in_cells(text)
        notes.append(stamps_in_cells)
    if not text.isascii():
        text, digits = with_plain_digits(text)
        notes.append(digits)
    if not text.isascii():
        text, other_minus = with_plain_minus(text)
        notes.append(other_minus)
    text, negative = with_leading_minus(text)
    notes.append(negative)
    if ("=" in text or "'" in text) and _FORMULA_MARK.search(text):
        text, formulas = without_formula_marks(text)
        notes.append(formulas)
    if '"[' in text:
        text, lists = with_lists_in_cells(text)
        notes.append(lists)
    if "]" in text or ")" in text:
        text, rows_in_brackets = without_brackets_of_rows(text)
        notes.append(rows_in_brackets)
    if "]" in text:
        text, matrix = without_matrix(text)
        notes.append(matrix)
    if ";" in text:
        text = without_row_marks(text)
    broken_cells = 0
    if '"' in text:
        text, broken_cells = unbroken(text)
        text = with_whole_names(text)
    if "[" in text:
        text, brackets = without_brackets(text)
        notes.append(brackets)
    for change in (
        with_declared_names,
        with_names_of_printed_frame,
        with_names_for_places,
        with_scope_heads,
        without_padded_settings,
        without_rules,
        with_steps_above,
        with_a_line_of_names,
        without_spread_in_cells,
        with_units_in_cells,
        without_units_in_cells,
        with_keyed_heads,
        upright,
        with_pivoted_heads,
    ):
        text, note = change(text)
        notes.append(note)
    if broken_cells:
        notes.append(
            f"{broken_cells} quoted cells hold a number and a line end: the line end is left out"
        )
    return text, [note for note in notes if note]
