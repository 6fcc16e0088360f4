"""Rows that are points of a table, none after another in time, are fitted without a lag, a memory or past samples."""

from __future__ import annotations

from collections.abc import Iterable

from erclutch.errors import SettingError
from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.models.stages import stages_of

#: Places of the stages that take something from one row to the next.
_IN_TIME = ("command", "slip", "effort")
NO_MEMORY = Finding(
    "note",
    "dynamics",
    "the rows are points of a table, none after another in time: models are fitted without a lag and without memory",
    "Give --rate if they are rows of a log",
)


def refuse_memory(data: Dataset, specifications: Iterable[str], past: bool) -> None:
    """Refuse what was asked for by name and needs a time, for rows that have none.

    Args:
        data: the rows.
        specifications: of stages.
        past: whether past samples were asked for.

    Raises:
        SettingError: a stage that keeps a state, or past samples.
    """
    if not data.in_no_time:
        return
    kept: list[str] = []
    for name in specifications:
        if any(stage.place in _IN_TIME for stage in stages_of(name)):
            kept.append(name)
    if kept or past:
        asked = f"the stages {kept[0]} follow" if kept else "past samples follow"
        problem = f"{asked} a time, and the rows are points of a table, none after another in time"
        remedy = (
            f"Leave {'--lag' if kept else '--past'} out, or give --rate if they are rows of a log"
        )
        raise SettingError(problem, remedy=remedy)
