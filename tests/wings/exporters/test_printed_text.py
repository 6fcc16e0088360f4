"""Text that targets print, looked at without a compiler: tables are whole, and names of MATLAB are made before use."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from erclutch.export.c.c_header import header
from erclutch.export.c.c_printer import table
from erclutch.export.exported_step import ExportOptions
from erclutch.export.step_numbers import band_of, run
from erclutch.export.step_record import step_of, step_record
from erclutch.export.targets.c import check_source
from erclutch.models.model import Model
from erclutch.signals.device import Units
from erclutch.wings.exporters.matlab_function import step_function
from erclutch.wings.exporters.targets import mujoco


@pytest.mark.parametrize("count", [1, 4, 5, 9])
def test_a_table_holds_all_its_values_in_order(count: int) -> None:
    values = [f"{n}.5" for n in range(count)]
    text = table("real", "gains", values)
    assert text.startswith(f"static const real gains[{count}] = {{\n")
    assert re.findall(r"\d+\.5", text) == values


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fnn-16, coaxial", "fnn-10-6+lag, coaxial"])
def test_a_network_in_matlab_uses_only_names_that_it_made(
    models: dict[str, Model], name: str
) -> None:
    program = step_of(models[name], ExportOptions(period=1e-3))
    text = step_function(program, step_record(program))
    body = text.partition("function y = network(x)")[2]
    known = {"x", "tanh", "double", "end"}
    for line in body.replace("...\n", " ").splitlines():
        made, _, used = line.strip().partition(" = ")
        missing = set(re.findall(r"(?<![\w.])[a-z]\w*", used)) - known
        assert not missing, line
        known.add(made)
    assert {"a1", "a", "y"} <= known


def test_a_control_of_mujoco_has_some_width(models: dict[str, Model]) -> None:
    program = step_of(models["bingham, single"])
    assert mujoco._control_range(program) == program.field.range
    low, high = program.field.range
    one_field = replace(program, field=replace(program.field, range=(high, high)))
    wide = replace(one_field, search=replace(program.search, plus=2.0 * high))
    assert low < high
    assert mujoco._control_range(wide) == (high, 2.0 * high)


@pytest.mark.parametrize(("precision", "word"), [("float32", "PRIx32"), ("float64", "PRIx64")])
def test_the_check_prints_words_of_its_precision(
    models: dict[str, Model], precision: Any, word: str
) -> None:
    printed = check_source(step_of(models["bingham, single"], ExportOptions(precision=precision)))
    assert set(re.findall(r"PRIx\d+", printed)) - {"PRIx8"} == {word}


def test_a_step_without_alarms_has_no_band(models: dict[str, Model]) -> None:
    program = step_of(models["bingham, single"])
    assert band_of(program, np.zeros((4, program.model_inputs))).shape == (0, 2)


def test_a_force_over_a_speed_moves_a_mass_on_a_slide(models: dict[str, Model]) -> None:
    turning = step_of(models["bingham, single"])
    made: Any = turning.model
    linear: Any = replace(made, units=Units("N", "V", "m/s"))
    assert 'type="hinge"' in mujoco.example_model(turning)
    said = mujoco.example_model(step_of(linear))
    assert 'joint name="slip" type="slide" axis="1 0 0"' in said
    assert f'mass="{max(map(abs, linear.trained_on.effort)) / 100.0:.6g}"' in said


@pytest.mark.slow
@pytest.mark.parametrize("label", ["bingham, single", "hem+rise-fall, coaxial"])
def test_the_example_in_the_header_lies_where_the_model_was_trained(
    models: dict[str, Model], label: str
) -> None:
    model: Any = models[label]
    slow = replace(model, trained_on=replace(model.trained_on, slip=(-0.59, 0.64), near=()))
    program = step_of(slow, ExportOptions("m", "float32", 1e-3))
    said = dict(re.findall(r"input\[M_IN_(\w+)\] = \(m_real\)(\S+);", header(program)))
    row = [float(said.get(name.upper(), 0.0)) for name in program.inputs]
    assert any(row)
    assert run(program, np.array([row]))[1].tolist() == [0]
