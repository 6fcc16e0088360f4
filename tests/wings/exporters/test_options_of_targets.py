"""Alarms, adaptation and the switch of a residual in targets besides C: they work, or one sentence refuses them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, export_model, verify_export
from erclutch.models.model import Model
from erclutch.registry import names
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element
from tests.support.wide_band import BAND

PERIOD = 1e-3


def test_the_wing_brings_its_targets() -> None:
    assert {"cpp", "fmu2", "fmu3", "mujoco", "onnx", "simulink"} <= set(names("erclutch.targets"))


@pytest.mark.parametrize(("option", "said"), [("alarms", "no alarms"), ("adapt", "no adaptation")])
def test_a_network_format_has_neither_alarms_nor_adaptation(
    option: str, said: str, models: dict[str, Model], tmp_path: Path
) -> None:
    model: Any = replace(models["fnn-16, coaxial"], band=BAND)  # type: ignore[type-var]
    with pytest.raises(ExportError, match=f"target onnx has {said}"):
        export_model(
            model, tmp_path / "x", "onnx", replace(ExportOptions(period=PERIOD), **{option: True})
        )


@pytest.mark.slow
@pytest.mark.parametrize("option", ["alarms", "adapt"])
@pytest.mark.parametrize(
    "label", ["bingham, single", "fnn-16, coaxial", "bingham+rise-fall, coaxial"]
)
def test_cpp_with_alarms_and_cpp_that_adapts_verify(
    label: str, option: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "g++")
    model: Any = replace(models[label], band=BAND)  # type: ignore[type-var]
    options = replace(ExportOptions("m", "float32", PERIOD), **{option: True})
    checks = verify_export(export_model(model, tmp_path / "cpp", "cpp", options))
    assert checks
    assert all(check.passed and check.other_bits == 0 for check in checks), checks


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_has_the_switch_as_a_parameter(
    version: int, models: dict[str, Model], tmp_path: Path
) -> None:
    fmpy = pytest.importorskip("fmpy")
    model: Any = models["bingham+fnn-3, single"]
    export_model(model, tmp_path / "f", f"fmu{version}", ExportOptions(name="m"))
    archive = str(tmp_path / "f" / f"m_fmi{version}.fmu")
    at = {"field": 0.9, "slip": 25.0, "temperature": 2.0}
    element = Element(np.array([at["field"]]), np.array([at["slip"]]))
    clock = Clock(np.zeros(1), (Span(0, 1, PERIOD),))
    one = [element], clock, {"temperature": np.array([at["temperature"]])}
    assert model.effort(*one) != model.law.effort(*one)
    for on, expected in ((1.0, model), (0.0, model.law)):
        result = fmpy.simulate_fmu(
            archive,
            start_values={**at, "residual": on},
            output=["effort"],
            stop_time=0.005,
            output_interval=PERIOD,
        )
        assert result["effort"][-1] == expected.effort(*one)[0]
