"""Text that targets print, looked at without a compiler: tables are whole, and names of MATLAB are made before use."""

from __future__ import annotations

import re

import pytest

from erclutch.export.c.c_printer import table
from erclutch.export.exported_step import ExportOptions
from erclutch.export.matlab_function import step_function
from erclutch.export.step_record import step_of, step_record
from erclutch.models.model import Model


@pytest.mark.parametrize("count", [1, 4, 5, 9])
def test_a_table_holds_all_its_values_in_order(count: int) -> None:
    values = [f"{n}.5" for n in range(count)]
    text = table("real", "gains", values)
    assert text.startswith(f"static const real gains[{count}] = {{\n")
    assert re.findall(r"\d+\.5", text) == values


@pytest.mark.parametrize("name", ["fnn-16, coaxial", "fnn-10-6+lag, coaxial"])
def test_a_network_in_matlab_uses_only_names_that_it_made(models: dict[str, Model], name: str) -> None:
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
