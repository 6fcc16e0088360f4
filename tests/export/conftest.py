"""Models of every kind, whose numbers do not end in a binary fraction, and the tools that `.ci/run` installs."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from erclutch.device import DeviceName, Units
from erclutch.dynamics import DynamicsForm
from erclutch.export.monotone import apart, middles, sides, steady
from erclutch.laws import law_from_name
from erclutch.model import Range, Reference, Structure, TorqueModel
from erclutch.networks import network_from_name
from erclutch.networks.model import NetworkModel, Scaling, table_shapes
from erclutch.saved import Model

UNITS = Units("N*m", "V", "rad/s")
LARGEST = 2000.0 / 3
TIMES = {"delay": 2.3e-3, "tau": 7e-3, "tau_rise": 4e-3, "tau_fall": 1.1e-2}


def law_model(
    specification: str, device: DeviceName = "coaxial", dynamics: DynamicsForm = "none", extra: bool = True
) -> TorqueModel:
    structure = Structure(device, specification, law_from_name(specification, device), dynamics, extra, extra)
    inside = {
        s.name: s.lower * (s.upper / s.lower) ** 0.4 if s.scale == "log" else min(0.37, s.upper)
        for s in structure.shapes(1e-3)
    }
    inside.update({name: value for name, value in TIMES.items() if name in inside})
    gains = {g.name: 0.1 + 0.07 * i for i, g in enumerate(structure.gains())}
    ranges = Range((0.0, LARGEST), (-30.1, 30.1), (-1.1, 1.1))
    return _true_range(TorqueModel(structure, Reference(LARGEST, 17.1, 1e-3), inside, gains, UNITS, ranges))


def network_model(
    specification: str,
    device: DeviceName = "coaxial",
    dynamics: DynamicsForm = "none",
    past: tuple[int, ...] = (),
    extras: tuple[str, ...] = (),
) -> NetworkModel:
    """A network with weights of the size that fits find."""
    structure = network_from_name(specification, device, dynamics=dynamics, past=past, extras=extras)
    rng = np.random.default_rng(7)
    count = len(structure.inputs)
    weights = {name: rng.normal(size=shape) / np.sqrt(shape[-1]) for name, shape in table_shapes(structure).items()}
    if structure.kind == "rbfn":
        weights["centres"] = rng.uniform(-1.0, 1.0, (structure.hidden[0], count))
        weights["spreads"] = rng.uniform(0.4, 1.2, structure.hidden[0])
    base = len(structure.inputs) - len(extras)
    scale = np.array([30.1] * base + [2.5] * len(extras))
    scale[:: 2 if device == "single" else 3][: base // (2 if device == "single" else 3)] = LARGEST
    times = {} if dynamics == "none" else {k: v for k, v in TIMES.items() if k in _names(dynamics)}
    limits = np.column_stack([-scale, scale])
    ranges = Range((0.0, LARGEST), (-30.1, 30.1), (-1.1, 1.1))
    scaling = Scaling(0.01 * scale, scale, 0.013, 0.7)
    return _true_range(NetworkModel(structure, scaling, weights, times, UNITS, ranges, limits, {"seed": "7"}))


def _true_range(model: Any) -> Any:
    """The model with the efforts that it gives inside its field and slip ranges as its training range."""
    rng, rows = np.random.default_rng(3), 2000
    fields = apart(model, rng.uniform(sides(model)[2], LARGEST, rows))
    slips = [rng.uniform(-30.1, 30.1, rows) for _ in fields]
    extras = [rng.uniform(-2.5, 2.5, rows) for _ in middles(model)]
    effort = steady(model, fields, slips, extras)
    return replace(model, trained_on=replace(model.trained_on, effort=(float(effort.min()), float(effort.max()))))


def _names(dynamics: DynamicsForm) -> tuple[str, ...]:
    return ("delay", "tau") if dynamics == "lag" else ("delay", "tau_rise", "tau_fall")


#: One of every kind; the label is the test's name.
MODELS: dict[str, Model] = {
    f"{m.name}, {m.structure.device}": m
    for m in (
        law_model("on-off", "coaxial"),
        law_model("on-off", "single", "rise-fall"),
        law_model("quadratic", "coaxial", "lag"),
        law_model("bingham", "single"),
        law_model("bingham", "coaxial", "rise-fall"),
        law_model("bingham/critical", "coaxial"),
        law_model("bingham/forward", "coaxial"),
        law_model("casson", "single", "lag"),
        law_model("casson/square", "coaxial"),
        law_model("herschel-bulkley", "single"),
        law_model("herschel-bulkley/critical", "coaxial", "lag", extra=False),
        law_model("seo-seo", "coaxial"),
        law_model("seo-seo/power", "single", "rise-fall"),
        law_model("seo-seo/forward", "coaxial", extra=False),
        law_model("cho-choi-jhon", "single", "lag"),
        law_model("cho-choi-jhon/critical/forward", "coaxial", "rise-fall"),
        law_model("hem", "coaxial"),
        law_model("hem", "coaxial", "rise-fall"),
        law_model("hem/forward", "single", "lag"),
        law_model("rbfm-5", "coaxial", "lag"),
        law_model("rbfm-10", "coaxial"),
        law_model("rbfm-10/forward", "single", "rise-fall"),
        network_model("fnn-16"),
        network_model("fnn-10-6", "coaxial", "lag"),
        network_model("fnn-3", "single", "rise-fall", past=(1, 4)),
        network_model("fnn-7", "coaxial", past=(2,), extras=("temperature", "current i_q")),
        network_model("rbfn-50"),
        network_model("rbfn-13", "single", "lag", past=(1, 2), extras=("temperature",)),
    )
}


def _need(*tools: str) -> None:
    """Skip where a program is missing, saying what to install."""
    packages = {
        "clang": "clang",
        "gcc": "gcc libc6-dev",
        "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
        "qemu-system-arm": "qemu-system-arm",
        "qemu-aarch64": "qemu-user",
        "qemu-ppc": "qemu-user",
        "aarch64-linux-gnu-gcc": "gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
        "powerpc-linux-gnu-gcc": "gcc-powerpc-linux-gnu libc6-dev-powerpc-cross",
        "cppcheck": "cppcheck",
        "g++": "g++",
        "octave-cli": "octave",
        "wine64": "wine64",
        "colcon": "ament-cmake colcon python3-colcon-ros",
    }
    missing = [packages.get(tool, tool) for tool in tools if shutil.which(tool) is None]
    if missing:
        pytest.skip(f"apt install {' '.join(missing)}")


@pytest.fixture(scope="session")
def need() -> Callable[..., None]:
    """``need("gcc", ...)`` skips where a program is missing."""
    return _need


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test with an argument ``model`` runs for every model."""
    if "model" in metafunc.fixturenames:
        metafunc.parametrize("model", list(MODELS.values()), ids=list(MODELS))


@pytest.fixture
def models() -> dict[str, Model]:
    return MODELS


@pytest.fixture
def law() -> Callable[..., TorqueModel]:
    return law_model


@pytest.fixture
def network() -> Callable[..., NetworkModel]:
    return network_model
