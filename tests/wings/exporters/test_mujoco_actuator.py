"""The actuator of the export for MuJoCo: when it steps, what it reads, whose it is, and that it goes when left."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

mujoco: Any = pytest.importorskip("mujoco")

from erclutch.export import ExportOptions, export_model  # noqa: E402
from erclutch.models.law_model import TorqueModel  # noqa: E402
from erclutch.wings.exporters.mujoco_actuator import Actuator  # noqa: E402

HINGE, USER = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtBias.mjBIAS_USER


class Compiled:
    """Answers with what it was given; counts its resets."""

    def __init__(self) -> None:
        self.resets, self.flags, self.seen = 0, 5, []

    def reset(self) -> None:
        self.resets += 1

    def step(self, *values: float) -> float:
        self.seen.append(values)
        return 10.0 * len(self.seen)


class Data:
    """What an actuator reads of an MjData."""

    def __init__(self, time: float = 0.0) -> None:
        self.time, self.ctrl, self.qpos, self.qvel = (
            time,
            [0.0, 0.5],
            [1.0, 2.0, 3.0],
            [4.0, 5.0, 6.0],
        )

    def at(self, time: float) -> Data:
        self.time = time
        return self


class Scene:
    """What an actuator reads of an MjModel."""

    def __init__(self, timestep: float = 0.01) -> None:
        places = {"effort": 4, "field": 1, "x": 0, "y": 1}
        self.opt = SimpleNamespace(timestep=timestep)
        self.actuator = self.joint = lambda name: SimpleNamespace(id=places[name])
        self.jnt_qposadr = self.jnt_dofadr = [0, 2]
        self.jnt_type = [HINGE, HINGE]
        self.actuator_biastype = [USER] * 5


def made(period: float | None, *, positions: bool = False, model: Any = None) -> Actuator:
    names: Any = {
        "fields": ["field"],
        "joints": ["x", "y"],
        "positions": positions,
        "further": 1,
        "period": period,
    }
    actuator = Actuator(Compiled, model or Scene(), "effort", **names)
    actuator.further[:] = [7.0]
    return actuator


@pytest.mark.parametrize(
    ("positions", "read"), [(False, (0.5, 4.0, 6.0, 7.0)), (True, (0.5, 1.0, 3.0, 7.0))]
)
def test_it_steps_once_a_period_and_holds_between(positions: bool, read: tuple[float, ...]) -> None:
    actuator, data = made(0.1, positions=positions), Data()
    assert (actuator.samples, actuator.flags) == (0, 0)
    efforts = [actuator.force(data.at(t)) for t in (2.0, 2.05, 2.0999, 2.1 - 1e-9, 2.15, 2.2)]
    assert efforts == [10.0, 10.0, 10.0, 20.0, 20.0, 30.0]
    assert actuator.memory_of(data).compiled.seen == [read] * 3
    assert (actuator.samples, actuator.flags) == (3, 5)
    again = made(None)
    assert [again.force(data.at(t)) for t in (0.0, 0.001)] == [10.0, 20.0]


def test_time_that_goes_back_begins_anew() -> None:
    actuator, data = made(0.1), Data()
    for t in (0.0, 0.1, 0.2):
        actuator.force(data.at(t))
    compiled = actuator.memory_of(data).compiled
    resets = compiled.resets
    actuator.force(data.at(0.2))
    assert (compiled.resets, actuator.samples) == (resets, 3)
    actuator.force(data.at(0.05))
    assert (compiled.resets, actuator.samples) == (resets + 1, 1)
    actuator.force(data.at(0.1))
    assert actuator.samples == 1  # counted from 0.05 s on
    actuator.force(data.at(0.15))
    assert actuator.samples == 2


def test_each_data_has_a_memory_of_its_own() -> None:
    actuator, one, two = made(0.1), Data(), Data()
    assert [actuator.force(one.at(t)) for t in (0.0, 0.1)] == [10.0, 20.0]
    assert actuator.force(two.at(0.0)) == 10.0
    assert actuator.force(one.at(0.2)) == 30.0
    assert [actuator.memory_of(each).samples for each in (one, two)] == [3, 1]
    actuator.reset()
    assert [actuator.memory_of(each).samples for each in (one, two)] == [0, 0]


def asked(model: Any, data: Any, actuator: int = 4) -> float:
    """What MuJoCo gets for a user actuator."""
    return mujoco.get_mjcb_act_bias()(model, data, actuator)


def test_it_answers_while_it_is_entered_and_only_for_its_own() -> None:
    first, second = Scene(), Scene()
    one, two, data = made(None, model=first), made(None, model=second), Data()
    with one:
        assert asked(first, data) == 10.0
        with pytest.raises(
            RuntimeError, match="no device is entered for the user actuator 4 of this MjModel"
        ):
            asked(second, data)
        with two:
            assert asked(second, data) == 10.0
            assert asked(first, data) == 20.0
        with pytest.raises(RuntimeError, match="no device is entered"):
            asked(second, data)
        with pytest.raises(ValueError, match="'effort' of this model has a device already"):
            made(None, model=first).__enter__()
        assert asked(first, data) == 30.0
    assert mujoco.get_mjcb_act_bias() is None


def test_who_answered_before_goes_on() -> None:
    def theirs(model: Any, data: Any, actuator: int) -> float:
        return -1.0

    model, data = Scene(), Data()
    mujoco.set_mjcb_act_bias(theirs)
    try:
        with made(None, model=model):
            assert asked(model, data) == 10.0
            assert asked(model, data, 3) == -1.0
        assert asked(model, data) == -1.0
    finally:
        mujoco.set_mjcb_act_bias(None)


@pytest.mark.parametrize("positions", [False, True])
def test_names_become_places(positions: bool) -> None:
    places = {"effort": 4, "a": 1, "b": 2, "x": 0, "y": 1}
    model: Any = SimpleNamespace(
        opt=SimpleNamespace(timestep=0.01),
        actuator=lambda name: SimpleNamespace(id=places[name]),
        joint=lambda name: SimpleNamespace(id=places[name]),
        jnt_qposadr=[7, 3],
        jnt_dofadr=[6, 2],
        jnt_type=[HINGE, HINGE],
        actuator_biastype=[USER] * 5,
    )

    def of(period: float | None) -> Any:
        names: Any = {
            "fields": ["b", "a"],
            "joints": ["y", "x"],
            "positions": positions,
            "further": 2,
        }
        return Actuator(Compiled, model, "effort", **names, period=period)

    found = of(0.01)
    assert (found.key, found._fields, found._joints) == (
        (id(model), 4),
        [2, 1],
        [3, 7] if positions else [2, 6],
    )
    assert (found.further, found._positions, found._period, found.samples) == (
        [0.0, 0.0],
        positions,
        0.01,
        0,
    )
    assert of(None)._period is None
    assert of(0.01 / (1.0 + 0.9e-6)) is not None
    with pytest.raises(ValueError, match=r"the timestep .* is longer than the model"):
        of(0.01 / (1.0 + 1.1e-5))


SCENE = """<mujoco><worldbody><body><joint name="{joint}" type="{kind}"/>
<geom type="sphere" size="0.1"/></body><body><joint name="other" type="hinge"/><geom type="sphere" size="0.1"/></body>
</worldbody><actuator><general name="field" joint="other"/>
<general name="effort" joint="other" gainprm="0" biastype="{bias}"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("kind", "bias", "told"),
    [
        ("hinge", "none", "the actuator 'effort' has no biastype=\"user\""),
        ("slide", "affine", "the actuator 'effort' has no biastype=\"user\""),
        ("ball", "user", "the joint 'x' has more than one degree of freedom"),
        ("free", "user", "the joint 'x' has more than one degree of freedom"),
        ("slide", "user", ""),
        ("hinge", "user", ""),
    ],
)
def test_a_device_that_would_read_or_give_nothing_is_refused(
    kind: str, bias: str, told: str
) -> None:
    model = mujoco.MjModel.from_xml_string(SCENE.format(joint="x", kind=kind, bias=bias))
    names: Any = {"fields": ["field"], "joints": ["x"], "positions": False, "further": 0}
    if told:
        with pytest.raises(ValueError, match=told):
            Actuator(Compiled, model, "effort", **names, period=None)
    else:
        Actuator(Compiled, model, "effort", **names, period=None)


# --- real exports in real simulations ---------------------------------------------------------------------------------


@pytest.fixture
def exports(
    law: Callable[..., TorqueModel], need: Callable[..., None], tmp_path: Path
) -> Generator[dict[str, tuple[ModuleType, ModuleType, Path]]]:
    """Two exports, one with memory: the modules of MuJoCo's actuator and of the compiled step, and the scene."""
    need("gcc")
    kept = dict(sys.modules)
    found: dict[str, tuple[ModuleType, ModuleType, Path]] = {}
    for name, stages in (("one", "none"), ("two", "lag")):
        folder = export_model(
            law("bingham", "single", stages),
            tmp_path / name,
            "mujoco",
            ExportOptions(name=name, period=1e-3),
        )
        for module in (name, f"{name}_mujoco"):
            spec = importlib.util.spec_from_file_location(module, folder / f"{module}.py")
            assert spec is not None
            assert spec.loader is not None
            sys.modules[module] = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(sys.modules[module])
        found[name] = sys.modules[f"{name}_mujoco"], sys.modules[name], folder / f"{name}.xml"
    yield found
    for name in set(sys.modules) - set(kept):
        del sys.modules[name]


@pytest.mark.slow
def test_two_exports_in_two_models_with_two_data_each(
    exports: dict[str, tuple[ModuleType, ModuleType, Path]],
) -> None:
    """Each torque has the bits of the Python export that steps through the same samples."""
    models = [
        (name, mujoco.MjModel.from_xml_path(str(xml)))
        for name, (*_, xml) in exports.items()
        for _ in range(2)
    ]
    scenes: list[tuple[str, Any, Any]] = []
    with ExitStack() as stack:
        for name, model in models:
            actuators, compiled, _ = exports[name]
            stack.enter_context(getattr(actuators, name)(model))
            for _ in range(2):  # two data of one model
                scenes.append((name, model, (mujoco.MjData(model), compiled.load())))
        rng = np.random.default_rng(0)
        for step in range(20):
            for name, model, (data, peer) in rng.permutation(np.array(scenes, dtype=object)):
                field, slip = rng.uniform(0.1, 300.0), rng.uniform(-20.0, 20.0)
                data.time = 1e-3 * step
                data.ctrl[model.actuator("field").id] = field
                data.joint("slip").qvel[0] = slip
                for part in (mujoco.mj_fwdPosition, mujoco.mj_fwdVelocity, mujoco.mj_fwdActuation):
                    part(model, data)
                assert data.actuator_force[model.actuator("effort").id] == peer.step(field, slip), (
                    name
                )


@pytest.mark.slow
def test_a_model_whose_device_was_left_is_refused(
    exports: dict[str, tuple[ModuleType, ModuleType, Path]],
) -> None:
    actuators, _, xml = exports["one"]
    models = [mujoco.MjModel.from_xml_path(str(xml)) for _ in range(2)]
    with actuators.one(models[0]):
        with actuators.one(models[1]):
            mujoco.mj_step(models[1], mujoco.MjData(models[1]))
        mujoco.mj_step(models[0], mujoco.MjData(models[0]))
        with pytest.raises(RuntimeError, match="no device is entered"):
            mujoco.mj_step(models[1], mujoco.MjData(models[1]))
