"""Rows that are points of a table, none after another in time, are fitted without a lag, a memory or past samples."""

from __future__ import annotations

from collections.abc import Iterable

from erclutch.errors import SettingError
from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.models.stages import needs_time, stages_of

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
        SettingError: a stage that needs a time, or past samples.
    """
    if not data.in_no_time:
        return
    in_time: list[str] = []  # of each specification with such stages, these stages
    for name in specifications:
        of_name = [stage.name for stage in stages_of(name) if needs_time(stage)]
        if of_name:
            in_time.append("+".join(of_name))
    if in_time or past:
        asked = f"the stages {in_time[0]} follow" if in_time else "past samples follow"
        problem = f"{asked} a time, and the rows are points of a table, none after another in time"
        left_out = in_time[0] if in_time else "--past"
        remedy = f"Leave {left_out} out, or give --rate if they are rows of a log"
        raise SettingError(problem, remedy=remedy)
