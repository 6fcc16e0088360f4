"""A compiled model is a user actuator of MuJoCo: an actuator with biastype="user", whose force is the model's effort.

with Actuator(...) as actuator:
    mujoco.mj_step(model, data)

Fields are the ctrl of the actuators named in `fields`, speeds (or positions) those of the joints named in `joints`.
MuJoCo evaluates forces as often as its integrator likes; a model with memory is sampled once a period of its own and
its effort holds in between.

MuJoCo knows one function for all user actuators of a program. So all exports share a list of devices, by the MjModel
and the actuator in it: any number of devices may be entered at once, of one export or of several, in one MjModel or in
several. Each MjData has a memory of its own. While devices are entered, an actuator without a device raises an error
instead of giving no force. Load all models with user actuators before the first device is entered: MuJoCo tries a model
while it loads the model, and raises an error where somebody answers for user actuators already.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, MutableMapping, Sequence
from typing import Any

import mujoco

#: Name under which the exports of a program share their devices, in the module mujoco itself.
_SHARED = "_erclutch_devices"
#: The module again: its stubs do not know its enumerations.
_KINDS: Any = mujoco


class Devices:
    """All devices that are entered in this program, of all exports."""

    def __init__(self) -> None:
        self.entered: dict[tuple[int, int], Any] = {}
        # What answered for user actuators before the first device was entered.
        self.before: Any = None

    def add(self, device: Any) -> None:
        """Answer for a device's actuator from now on."""
        if device.key in self.entered:
            raise ValueError(
                f"the actuator {device.effort!r} of this model has a device already: leave that one first"
            )
        if not self.entered:
            self.before = mujoco.get_mjcb_act_bias()
            mujoco.set_mjcb_act_bias(self.force)
        self.entered[device.key] = device

    def remove(self, device: Any) -> None:
        """Answer for it no more."""
        self.entered.pop(device.key, None)
        if not self.entered:
            mujoco.set_mjcb_act_bias(self.before)
            self.before = None

    def force(self, model: Any, data: Any, actuator: int) -> float:
        """The force of a user actuator, as MuJoCo asks for it."""
        device = self.entered.get((id(model), actuator))
        if device is not None:
            return device.force(data)
        if self.before is not None:
            return self.before(model, data, actuator)
        raise RuntimeError(
            f"no device is entered for the user actuator {actuator} of this MjModel, while others are: "
            "enter a device with this MjModel (a copy of a model is another model)"
        )


def _devices() -> Any:
    return mujoco.__dict__.setdefault(_SHARED, Devices())


class DataMemory:
    """What a device remembers of one MjData.

    Attributes:
        flags: of the last sample.
        samples: how many were taken.
    """

    def __init__(self, compiled: Any) -> None:
        self.compiled = compiled
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self.compiled.reset()
        self.start: float | None = None
        self.effort = self.time = 0.0
        self.samples = self.flags = 0


class Actuator:
    """One device in one MjModel.

    Args:
        load: makes a compiled model; called once for each MjData.
        model: MjModel.
        effort: name of the actuator with biastype="user".
        fields: names of the actuators whose ctrl is a field, in the model's order.
        joints: names of the joints (one degree of freedom each) whose speeds or positions go in, in the model's order.
        positions: positions go in, not speeds.
        further: number of further inputs; set them in the attribute `further` before each step.
        period: sampling period in s; None for a model without memory, which is evaluated whenever MuJoCo asks.

    Attributes:
        further: values of further inputs.
        flags, samples: of the MjData that was stepped last; `memory_of` has those of each.

    Raises:
        KeyError: no actuator or joint of a name.
        ValueError: the simulation's step is longer than the period; MuJoCo would never ask for the actuator's force; a
            joint has more than one degree of freedom; or, when it is entered, its actuator has a device.
    """

    def __init__(
        self,
        load: Callable[[], Any],
        model: Any,
        effort: str,
        *,
        fields: Sequence[str],
        joints: Sequence[str],
        positions: bool,
        further: int,
        period: float | None,
    ) -> None:
        if period is not None and model.opt.timestep > period * (1.0 + 1e-6):
            raise ValueError(
                f"the timestep {model.opt.timestep:g} s is longer than the model's period {period:g} s: "
                "export it with a longer --period, or make the timestep shorter"
            )
        self.effort = effort
        self.model = model  # held, so that its id stays its own
        self.key = id(model), int(model.actuator(effort).id)
        # MuJoCo asks nobody for the force of another kind of actuator: the device would have no effect.
        bias = int(model.actuator_biastype[model.actuator(effort).id])
        if bias != int(_KINDS.mjtBias.mjBIAS_USER):
            raise ValueError(
                f'the actuator {effort!r} has no biastype="user", so that MuJoCo would never ask for its force: '
                'write biastype="user" gainprm="0" there'
            )
        # Of a ball or a free joint the first of several numbers would be read.
        of_one_number = (int(_KINDS.mjtJoint.mjJNT_HINGE), int(_KINDS.mjtJoint.mjJNT_SLIDE))
        for name in joints:
            if int(model.jnt_type[model.joint(name).id]) not in of_one_number:
                raise ValueError(
                    f"the joint {name!r} has more than one degree of freedom: name a joint of type hinge or slide"
                )
        self.further = [0.0] * further
        self._load, self._period = load, period
        self._fields = [int(model.actuator(name).id) for name in fields]
        address = model.jnt_qposadr if positions else model.jnt_dofadr
        self._joints = [int(address[model.joint(name).id]) for name in joints]
        self._positions = positions
        self._memories: MutableMapping[Any, DataMemory] = weakref.WeakKeyDictionary()
        self._latest: DataMemory | None = None

    @property
    def flags(self) -> int:
        """Of the last sample of the MjData that was stepped last."""
        return 0 if self._latest is None else self._latest.flags

    @property
    def samples(self) -> int:
        """How many were taken of the MjData that was stepped last."""
        return 0 if self._latest is None else self._latest.samples

    def memory_of(self, data: Any) -> DataMemory:
        """What the device remembers of an MjData."""
        memory = self._memories.get(data)
        if memory is None:
            memory = self._memories[data] = DataMemory(self._load())
        return memory

    def reset(self) -> None:
        """Forget all samples; done by itself for an MjData whose time goes back."""
        for memory in self._memories.values():
            memory.reset()

    def __enter__(self) -> Actuator:
        _devices().add(self)
        return self

    def __exit__(self, *error: object) -> None:
        _devices().remove(self)

    def force(self, data: Any) -> float:
        """The effort at the simulation's present time."""
        now = float(data.time)
        memory = self._latest = self.memory_of(data)
        if memory.start is None or now < memory.time:
            memory.reset()
            memory.start = now
        memory.time = now
        # A millionth of a period is rounding of the time.
        if self._period is None or memory.samples <= (now - memory.start) / self._period + 1e-6:
            source = data.qpos if self._positions else data.qvel
            values = [float(data.ctrl[i]) for i in self._fields] + [
                float(source[i]) for i in self._joints
            ]
            memory.effort = memory.compiled.step(*values, *self.further)
            memory.flags = memory.compiled.flags
            memory.samples += 1
        return memory.effort
