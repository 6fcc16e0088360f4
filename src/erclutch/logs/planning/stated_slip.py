"""A speed that no column holds may be stated: in the header, or by the name of the file (``brake_100rpm.csv``).

A brake that turns at one speed while its field is switched is logged so.
"""

from __future__ import annotations

from dataclasses import replace

from erclutch.errors import UnitError, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_names import StatedLevel, speed_in
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import OTHER, TOLD, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

#: What a speed may be that the bench or the machine can do, and did not keep.
_OF_WHAT_CAN_BE = set_of("maximal maximum minimal minimum rated sync synchronous idle")


def offer_a_stated_slip(draft: Draft) -> None:
    """Offer the one speed that the file states, where no column holds a motion: it may be the slip in all rows."""
    question = draft.questions.get("slip")
    if question is None or question.option or "position" in draft.signals:
        return
    stated: list[StatedLevel] = []  # speeds in the header, or else in the file's name
    for key, text in draft.table.metadata.items():
        label, unit = split_label(key)
        name = spoken_name(label)
        is_another = "slip" in name.turned or name.says(TOLD | OTHER | _OF_WHAT_CAN_BE)
        if "slip" not in name.may_be or is_another:
            continue
        try:
            number, own = units.quantity(text)
        except UnitError:
            continue
        unit = own or unit or name.end
        if unit and units.is_unit(unit) and units.fits(unit, SIGNALS["slip"].si_units):
            stated.append(StatedLevel(label, number, unit))
    of_file_name = speed_in(draft.table.name)
    if not stated and of_file_name is not None:
        stated.append(of_file_name)
    if len(stated) != 1:
        return

    (speed,) = stated
    option = f"--constant {shell_word(f'slip={speed.number:g} {speed.unit}')}"
    with_the_speed = question.adding(f"; the file says {speed}, which it may be in all rows")
    draft.questions["slip"] = replace(with_the_speed, remedy=f"Give {option}", option=option)
