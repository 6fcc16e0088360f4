"""Names of stages, and a stage of another package that is not what it says."""

from __future__ import annotations

from typing import Any

import pytest

from erclutch.errors import PluginError, SettingError
from erclutch.models.stages import stage_named
from erclutch.models.stages.outside_stage import OutsideStage
from erclutch.registry import Plugin

PLUGIN = Plugin(
    "erclutch.stages", "drag", "erclutch_stage_drag:STAGE", "erclutch-stage-drag", "2.0"
)


@pytest.mark.parametrize("name", ["dahl", "dahl-2", "dahl-2/field", "dahl/field"])
def test_a_stage_by_its_name(name: str) -> None:
    assert stage_named(name).name == name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("dahl/odd", r"Write dahl-N with N from 1 to \d+, dahl/field"),
        ("dahl-0", "Write dahl-N"),
        ("dahl-99", "Write dahl-N"),
        ("dahl-1000", "Write dahl-N"),
        ("dahl-x", "Did you mean dahl"),
        ("lag-2", "Write lag"),
    ],
)
def test_a_number_or_form_that_there_is_not(name: str, said: str) -> None:
    with pytest.raises(SettingError, match=f"unknown stage '{name}'.*{said}"):
        stage_named(name)


class Own:
    """What a package may bring as a stage."""

    def __init__(self, name: str, place: str = "slip") -> None:
        self.name, self.place, self.limit = name, place, 3
        self.title, self.source, self.equation = "drag", "made up", "d = w"

    def broken(self) -> None:
        raise ZeroDivisionError("no")


@pytest.mark.parametrize("name", ["drag", "drag-2", "drag/field", "drag-2/field/odd"])
def test_a_stage_of_another_package_answers_as_itself(name: str) -> None:
    own: Any = Own(name)
    stage = OutsideStage(own, PLUGIN)
    assert (stage.name, stage.limit) == (name, 3)
    assert stage == OutsideStage(own, PLUGIN)
    assert stage != own
    assert stage != OutsideStage(own, Plugin("erclutch.stages", "drag", "x:Y", "other", "1"))
    assert hash(stage) == hash(OutsideStage(own, PLUGIN))
    with pytest.raises(PluginError, match="erclutch-stage-drag"):
        stage.broken()
    assert stage.__reduce__()[1] == ("erclutch.stages", "drag", name)


@pytest.mark.parametrize(
    ("name", "place", "said"),
    [
        ("other", "slip", "calls itself 'other'; its name and its entry point must agree"),
        ("drags", "slip", "calls itself 'drags'"),
        ("drag-", "slip", "calls itself"),
        (
            "drag",
            "temperature",
            "stands on the temperature; command, slip and effort are open to packages",
        ),
    ],
)
def test_a_stage_that_is_not_what_it_says(name: str, place: str, said: str) -> None:
    own: Any = Own(name, place)
    with pytest.raises(PluginError, match=said):
        OutsideStage(own, PLUGIN)
