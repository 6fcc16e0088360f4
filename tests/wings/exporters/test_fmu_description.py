"""What an FMU says of itself, as fmpy reads and validates it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from erclutch.export.exported_step import ExportOptions
from erclutch.export.step_record import step_of
from erclutch.models.model import Model
from erclutch.wings.exporters.fmu.fmu_description import description, interface

pytestmark = pytest.mark.slow

fmpy: Any = pytest.importorskip("fmpy")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("label", ["bingham, single", "bingham+rise-fall, coaxial"])
def test_variables_units_and_step(
    models: dict[str, Model], label: str, version: int, tmp_path: Path
) -> None:
    program = step_of(models[label], ExportOptions(period=2e-3))
    face = interface(program)
    root = description(program, face, version, "own", "{token}", ["a.c", "b.c"])
    path = tmp_path / "modelDescription.xml"
    ElementTree.ElementTree(root).write(path, encoding="UTF-8", xml_declaration=True)
    found = fmpy.read_model_description(str(path), validate=True)
    names = {variable.name: variable for variable in found.modelVariables}
    for port, causality in (
        *((p, "input") for p in face.inputs),
        *((p, "output") for p in face.outputs),
    ):
        assert names[port.name].causality == causality
        if port.limits:
            assert (float(names[port.name].min), float(names[port.name].max)) == port.limits
    assert found.modelName == program.model.name
    assert found.fmiVersion == f"{version}.0"
    assert (found.guid if version == 2 else found.instantiationToken) == "{token}"
    assert [category.name for category in found.logCategories] == ["logStatusError"]
    assert {output.variable.name for output in found.outputs} >= {
        port.name for port in face.outputs
    }
    step = found.defaultExperiment.stepSize if found.defaultExperiment else None
    assert (float(step) if step else None) == program.period
    assert any(unit.name == program.model.units.effort for unit in found.unitDefinitions)


@pytest.mark.parametrize("version", [2, 3])
def test_a_further_input_with_a_name_that_is_taken_gets_another_one(
    law: Callable[..., Model], version: int, tmp_path: Path
) -> None:
    """A law with a position term, exported with speeds from positions, has the position twice."""
    model = law("bingham", "single", "lag", further=("position", "effort", "time", "measured"))
    program = step_of(model, ExportOptions(period=2e-3, inputs="angles"))
    root = description(program, interface(program), version, "own", "{token}", ["a.c"])
    path = tmp_path / "modelDescription.xml"
    ElementTree.ElementTree(root).write(path, encoding="UTF-8", xml_declaration=True)
    found = fmpy.read_model_description(str(path), validate=True)
    inputs = [variable.name for variable in found.modelVariables if variable.causality == "input"]
    assert inputs == ["field", "position"] + [f"{name} (further input)" for name in model.extras]
