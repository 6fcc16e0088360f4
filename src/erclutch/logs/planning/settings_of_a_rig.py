"""Where no field is logged, a gap or a load that a rig was set to may be what parts the efforts: the user is asked.

An eddy-current brake has the distance of its magnet in place of a current, and a friction rig its normal load. Without
that column the rows of all settings are mixed in one fit.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_of_words import levels_of_efforts, slip_and_effort
from erclutch.logs.planning.strength_of_efforts import strengths_of_efforts
from erclutch.signals import units
from erclutch.signals.array import Array

_SETTINGS = set_of(
    "gap airgap distance spacing separation clearance luftspalt spalt abstand entrefer distancia distanza traferro "
    "normal normalkraft normallast pressure druck anpressdruck anpresskraft clamp clamping 间隙 气隙 距离 压力 "
)
_DIFFERS = 1.2  # between the mean sizes of the effort at two settings
_MUCH_STRONGER = (
    1.5  # times the effort: a pressure that a seal or a gas makes has less to do with it
)


def ask_about_a_setting_of_the_rig(draft: Draft) -> None:
    """Ask whether the one column of such a name that keeps a few levels is wanted, where the effort goes with them.

    A column of another name that keeps levels is one too, where the effort at the same slip goes with them.
    """
    effort = draft.signals.get("effort")
    if not draft.field_is_open or effort is None or effort.column not in draft.table.columns:
        return
    wanted = {str(choice.column) for choice in draft.told.inputs}
    sizes = np.abs(draft.table.columns[effort.column])
    settings: list[str] = []
    for column in draft.seen.without(draft.taken):
        is_wanted = column.name in wanted or draft.table.label(column.name) in wanted
        is_set = column.shape.keeps_levels and column.spoken.says(_SETTINGS)
        if is_wanted or not is_set:
            continue
        known = np.isfinite(column.values) & np.isfinite(sizes)
        levels = np.unique(column.values[known])
        means = [float(sizes[known & (column.values == level)].mean()) for level in levels]
        if len(means) > 1 and max(means) > _DIFFERS * min(means):
            settings.append(column.name)
    if not settings:
        # Whatever it is called: an angle of vanes, or the place of a magnet, which was guessed as the device's.
        place = draft.guessed("position") if "slip" in draft.signals else None
        others = [name for name in draft.taken if place is None or name != place.column]
        for name in levels_of_efforts(draft, others):
            unit = draft.seen.columns[name].written_unit
            if unit and not units.is_temperature(unit):  # a warm fluid has less effort at any field
                settings.append(name)
        if place is not None and settings == [place.column]:
            draft.take_back("position")
    how = "the effort goes with the levels of"
    slip, measured = slip_and_effort(draft)
    if not settings and slip is not None and measured is not None:
        # A pressure or a clamping force keeps no levels.
        pressing: dict[str, Array] = {}
        for column in draft.seen.without(draft.taken):
            clamps = column.fits(("N",)) and column.spoken.says(_SETTINGS)
            if column.unit and (column.fits(("Pa",)) or clamps):
                pressing[column.name] = column.values
        settings = strengths_of_efforts(pressing, slip, measured, _MUCH_STRONGER)
        how = "at the same slip the effort is larger under more"
    if len(settings) != 1:
        return
    (name,) = settings
    option = f"--field {shell_word(draft.table.label(name))}"
    problem = f"no column for field, and {how} {name}"
    remedy = f"Give {option} if it sets the effort as a field does, else --field none"
    draft.ask("field", MappingError(problem, remedy=remedy), option)
    del draft.signals["field"]
