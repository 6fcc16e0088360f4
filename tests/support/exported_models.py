"""Models of every kind, whose numbers do not end in a binary fraction, and the tools that `.ci/run` installs."""

from __future__ import annotations

import importlib.util
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from erclutch.export.monotone import apart, sides
from erclutch.models.covered_cells import CoveredCells
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.model import Model, Range
from erclutch.models.networks import network_from_name, table_shapes
from erclutch.models.networks.network_model import NetworkModel, Scaling
from erclutch.models.residual_model import BoundedResidual, ResidualModel
from erclutch.models.stages import stages_of
from erclutch.models.structure import Reference, Structure
from erclutch.signals.device import DeviceName, Units
from erclutch.signals.recording import TEMPERATURE

UNITS = Units("N*m", "V", "rad/s")
LARGEST = 2000.0 / 3
TIMES = {"delay": 2.3e-3, "tau": 7e-3, "tau_rise": 4e-3, "tau_fall": 1.1e-2}
#: Of stages on slip and effort, and of the strength of the field in the memory of a network.
MEMORY = {
    "r_1": 0.021,
    "r_2": 0.33,
    "tau_e": 3.3e-3,
    "n_m": 1.3,
    "E_m": 555.5,
    "w_t": 0.4,
    "t_w": 0.3,
    "b_y": 0.9,
}
CHAIN = "rise-fall+dahl-2/field+inertia+effort-lag"
#: All stages that are not in the chain.
OTHERS = "two-lags+stops-2+bouc-wen-2+lugre/field+hysteretic-tanh+stiffness+effort-second-order"
#: Gains of columns that are far larger than one: acceleration and the like.
SMALL = {"m": 1.3e-5, "ld": 1e-2}


def law_model(
    specification: str,
    device: DeviceName = "coaxial",
    dynamics: str = "none",
    extra: bool = True,
    further: tuple[str, ...] = (),
) -> TorqueModel:
    """A law with stages, its numbers somewhere inside their bounds."""
    law = law_from_name(specification, device)
    structure = Structure(device, specification, law, dynamics, extra, extra, further)
    shape: dict[str, float] = {}
    for parameter in structure.shapes(1e-3):
        low, high = parameter.lower, parameter.upper
        shape[parameter.name] = (
            low * (high / low) ** 0.4 if parameter.scale == "log" else min(0.37, high)
        )
    shape |= {name: number for name, number in {**TIMES, **MEMORY}.items() if name in shape}
    gains: dict[str, float] = {}
    for i, gain in enumerate(structure.gains()):
        kind = gain.name.split("_")[0]
        gains[gain.name] = (0.1 + 0.07 * i) * SMALL.get(kind, 1.0)

    trained_on = Range((0.0, LARGEST), (-30.1, 30.1), (-1.1, 1.1))
    usual: list[float] = []  # of each further input
    ranges: list[tuple[float, float]] = []
    for name in structure.extras:
        warm = name == TEMPERATURE
        usual.append(320.0 if warm else 1.7)
        ranges.append((280.0, 360.0) if warm else (-2.5, 2.5))
    temperature = 320.0 if TEMPERATURE in structure.extras else 1.0
    reference = Reference(LARGEST, 17.1, 1e-3, tuple(usual), temperature)
    return _true_range(
        TorqueModel(
            structure, reference, shape, gains, UNITS, trained_on, extra_ranges=tuple(ranges)
        )
    )


def network_model(
    specification: str,
    device: DeviceName = "coaxial",
    dynamics: str = "none",
    past: tuple[int, ...] = (),
    extras: tuple[str, ...] = (),
) -> NetworkModel:
    """A network with weights of the size that fits find."""
    structure = network_from_name(
        specification, device, dynamics=dynamics, past=past, extras=extras
    )
    rng = np.random.default_rng(7)
    count = len(structure.inputs)
    weights = {
        name: rng.normal(size=shape) / np.sqrt(shape[-1])
        for name, shape in table_shapes(structure).items()
    }
    if structure.kind == "rbfn":
        weights["centres"] = rng.uniform(-1.0, 1.0, (structure.hidden[0], count))
        weights["spreads"] = rng.uniform(0.4, 1.2, structure.hidden[0])
    scale = np.array([_size(name, extras) for name in structure.inputs])
    stages = stages_of(dynamics)
    needed = {parameter.name for stage in stages for parameter in stage.parameters(1e-3)}
    if any(stage.place == "slip" for stage in stages):
        needed |= {"n_m", "E_m"}
    times = {name: number for name, number in {**TIMES, **MEMORY}.items() if name in needed}
    limits = np.column_stack([-scale, scale])
    ranges = Range((0.0, LARGEST), (-30.1, 30.1), (-1.1, 1.1))
    scaling = Scaling(0.01 * scale, scale, 0.013, 0.7)
    return _true_range(
        NetworkModel(structure, scaling, weights, times, UNITS, ranges, limits, {"seed": "7"})
    )


def residual_model(
    law: TorqueModel, specification: str, past: tuple[int, ...] = (), *, limit: float
) -> ResidualModel:
    """A law and a network of its size on the residual, over two boxes with a gap between them."""
    device, dynamics = law.structure.device, law.structure.dynamics
    network = network_from_name(
        specification, device, dynamics=dynamics, past=past, extras=("temperature",)
    )
    rng = np.random.default_rng(5)
    count = len(network.inputs)
    weights = {name: rng.normal(size=shape) for name, shape in table_shapes(network).items()}
    sizes = {"field": 1.0, "E1-E2": 1.0, "temperature": 2.5}
    scale = np.array([sizes.get(name.split("[")[0], 30.1) for name in network.inputs])
    of_strength = [name.startswith("s") and name != "slip" for name in network.inputs]
    scale[of_strength] = 0.8
    scaling = Scaling(0.01 * scale, scale, 0.013, 1.5 * limit)
    ranges = np.column_stack([-scale, scale])
    residual = NetworkModel(
        network, scaling, weights, law.times, law.units, law.trained_on, ranges, {}, law.period
    )

    # Two boxes: the first up to a field of zero, the second from a tenth of the largest field on.
    start_of_second = np.r_[0.1, np.full(count - 1, 0.7)]
    low = np.array([-0.9 * scale, start_of_second * scale])
    high = np.array([np.r_[0.0, scale[1:]], scale])
    return ResidualModel(
        law, BoundedResidual(residual, limit, CoveredCells(low, high, 0.37 * scale))
    )


def _true_range(model: Any) -> Any:
    """The model with the efforts that it gives inside its field and slip ranges as its training range."""
    rng = np.random.default_rng(3)
    rows = 2000
    _, _, smallest = sides(model)
    fields = apart(model, rng.uniform(smallest, LARGEST, rows))
    slips = [rng.uniform(-30.1, 30.1, rows) for _ in fields]
    extras = [rng.uniform(low, high, rows) for low, high in model.extras.values()]
    effort = model.steady(fields, slips, extras)
    given = float(effort.min()), float(effort.max())
    return replace(model, trained_on=replace(model.trained_on, effort=given))


def _at_some_slips(model: Any) -> Any:
    """The model with training rows at all fields, but not at all slips."""
    elements = 2 if model.structure.device == "coaxial" else 1
    near = tuple((mask,) * 16 for mask in (0x0FFF, 0xFFE0)[:elements])
    return replace(model, trained_on=replace(model.trained_on, near=near))


def _with_gaps(model: Any) -> Any:
    """The model with a grid over field and slip that has gaps, other ones for each element."""
    elements = 2 if model.structure.device == "coaxial" else 1
    masks = np.random.default_rng(11).integers(0, 1 << 16, (elements, 16))
    near = tuple(tuple(element) for element in masks.tolist())
    return replace(model, trained_on=replace(model.trained_on, near=near))


def with_law(network: NetworkModel, specification: str = "bingham") -> NetworkModel:
    """The network with a law beyond its rows, that has the network's further inputs."""
    device, extras = network.structure.device, network.structure.extras
    structure = Structure(
        device, specification, law_from_name(specification, device), "none", True, True, extras
    )
    numbers = {"n": 1.4, "w_s": 0.05}
    shape = {parameter.name: numbers[parameter.name] for parameter in structure.shapes(1e-3)}
    gains = {gain.name: 0.3 + 0.07 * i for i, gain in enumerate(structure.gains())}
    reference = Reference(LARGEST, 17.1, 1e-3, (1.7,) * len(extras))
    ranges = tuple(network.extras[name] for name in extras)
    law = TorqueModel(
        structure, reference, shape, gains, UNITS, network.trained_on, extra_ranges=ranges
    )
    return _true_range(replace(network, beyond=law))


def _size(name: str, extras: tuple[str, ...]) -> float:
    """Of an input of a network: a field, a further input, a state of a memory, an acceleration or a speed."""
    if name in extras:
        return 2.5
    for start, size in (("field", LARGEST), ("E1", LARGEST), ("z", 1.0), ("a_", 6e4)):
        if name == start[:-1] or name.startswith(start):
            return size
    return 30.1


#: One of every kind; the label is the test's name.
MODELS: dict[str, Model] = {
    f"{m.name}, {m.structure.device}": m
    for m in (
        law_model("on-off", "coaxial"),
        law_model("on-off", "single", "rise-fall"),
        law_model("quadratic", "coaxial", "lag"),
        _with_gaps(law_model("bingham", "single")),
        law_model("bingham", "coaxial", "rise-fall"),
        law_model("bingham/critical", "coaxial"),
        law_model("bingham/saturating", "single"),
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
        law_model("eddy-current", "single", "lag"),
        law_model("bingham", "single", "lugre/field/sides"),
        law_model("hem", "coaxial"),
        law_model("hem", "coaxial", "rise-fall"),
        law_model("hem/forward", "single", "lag"),
        law_model("rbfm-5", "coaxial", "lag"),
        law_model("rbfm-10", "coaxial"),
        law_model("rbfm-10/forward", "single", "rise-fall"),
        with_law(_at_some_slips(network_model("fnn-16"))),
        with_law(_at_some_slips(network_model("fnn-10-6", "coaxial", "lag"))),
        network_model("fnn-3", "single", "rise-fall", past=(1, 4)),
        network_model("fnn-7", "coaxial", past=(2,), extras=("temperature", "current i_q")),
        network_model("rbfn-50"),
        with_law(network_model("rbfn-13", "single", "lag", past=(1, 2), extras=("temperature",))),
        law_model("casson", "single", CHAIN, further=("position", "bellows 2")),
        law_model("bingham/forward", "coaxial", CHAIN),
        law_model("herschel-bulkley", "single", OTHERS),
        with_law(_at_some_slips(network_model("fnn-16", "coaxial", CHAIN))),
        residual_model(law_model("bingham", "single"), "fnn-3", limit=0.02),
        residual_model(
            law_model("bingham", "single", "lag+effort-lag"), "fnn-4", (1, 3), limit=0.02
        ),
        residual_model(law_model("hem", "coaxial", "lag"), "rbfn-5", limit=0.02),
    )
}


#: Of these, the ones of the fast tests: each kind of law, network and stage, and what compiles and counts quickly.
QUICK_MODELS = {
    "on-off+rise-fall, single",
    "quadratic+lag, coaxial",
    "bingham, single",
    "bingham/critical, coaxial",
    "bingham/saturating, single",
    "casson/square, coaxial",
    "herschel-bulkley/critical+lag, coaxial",
    "seo-seo/power+rise-fall, single",
    "cho-choi-jhon+lag, single",
    "hem/forward+lag, single",
    "hem+rise-fall, coaxial",
    "rbfm-10/forward+rise-fall, single",
    "fnn-3+rise-fall, single",
    "fnn-7, coaxial",
    "rbfn-13+lag, single",
    "casson+rise-fall+dahl-2/field+inertia+effort-lag, single",
    "bingham+fnn-3, single",
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
        "frama-c": "frama-c-base",
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
    """A test with an argument ``model`` runs for every model, for some of them in the fast tests."""
    if "model" in metafunc.fixturenames:
        slow = {label: () if label in QUICK_MODELS else pytest.mark.slow for label in MODELS}
        values = [
            pytest.param(model, id=label, marks=slow[label]) for label, model in MODELS.items()
        ]
        metafunc.parametrize("model", values)


@pytest.fixture(scope="session")
def boards() -> ModuleType:
    """The bench of Cortex-M boards under QEMU."""
    file = Path(__file__).parents[1] / "export" / "cortex_m" / "boards.py"
    spec = importlib.util.spec_from_file_location("cortex_m_boards", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its data classes look themselves up
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def models() -> dict[str, Model]:
    return MODELS


@pytest.fixture
def law() -> Callable[..., TorqueModel]:
    return law_model


@pytest.fixture
def network() -> Callable[..., NetworkModel]:
    return network_model
