"""A log with one field, or none, is fitted by models without field terms; what needs a field is refused."""

from __future__ import annotations

from collections.abc import Sequence

from erclutch.errors import SettingError
from erclutch.fit.checks.data_check import field_text
from erclutch.fit.fit_settings import AUTO
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import at_one_field
from erclutch.models.networks import is_network
from erclutch.models.stages import stages_at


def refuse_field_terms(
    data: Dataset,
    asked: Sequence[str],
    stages: str,
    friction: bool | None,
) -> None:
    """Refuse what was asked for by name and needs a field that changes, for rows that all have one field.

    Args:
        data: the rows.
        asked: specifications of models, no sets of them.
        stages: specification of the stages.
        friction: whether a friction effort was asked for.

    Raises:
        SettingError: a law with other field terms than its yield effort, a stage on the command, or friction.
    """
    where = f"the field is constant at {field_text(data)} in all rows"
    for name in asked:
        if not is_network(name) and at_one_field(name, data.device) is None:
            problem = f"{name} describes how the effort changes with the field, and {where}"
            raise SettingError(
                problem, remedy="Log with a changing field, or leave the law out: --models all"
            )
    if stages != AUTO and stages_at(stages, "command"):
        problem = f"the stages {stages} follow a command that changes, and {where}"
        raise SettingError(problem, remedy="Leave the stages on the command out of --lag")
    if friction:
        problem = f"friction and yield effort cannot be told apart, since {where}"
        raise SettingError(problem, remedy="Leave --friction out: the yield effort holds both")
