"""A compiled model is a user actuator of MuJoCo: an actuator with biastype="user", whose force is the model's effort.

with Actuator(...) as actuator:
    mujoco.mj_step(model, data)

Fields are the ctrl of the actuators named in `fields`, speeds (or positions) those of the joints named in `joints`.
MuJoCo evaluates forces as often as its integrator likes; a model with memory is sampled once a period of its own and
its effort holds in between. Several actuators may be in use at once, one a device.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import mujoco


class Actuator:
    """One device.

    Args:
        compiled: the compiled model.
        model: MjModel.
        effort: name of the actuator with biastype="user".
        fields: names of the actuators whose ctrl is a field, in the model's order.
        joints: names of the joints (one degree of freedom each) whose speeds or positions go in, in the model's order.
        positions: positions go in, not speeds.
        further: number of further inputs; set them in the attribute `further` before each step.
        period: sampling period in s; None for a model without memory, which is evaluated whenever MuJoCo asks.

    Attributes:
        flags: of the last sample.
        further: values of further inputs.
        samples: how many were taken.

    Raises:
        KeyError: no actuator or joint of a name.
        ValueError: the simulation's step is longer than the period.
    """

    _users: ClassVar[dict[int, Actuator]] = {}

    def __init__(
        self,
        compiled: Any,
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
        self._compiled, self._period = compiled, period
        self._id = int(model.actuator(effort).id)
        self._fields = [int(model.actuator(name).id) for name in fields]
        address = model.jnt_qposadr if positions else model.jnt_dofadr
        self._joints = [int(address[model.joint(name).id]) for name in joints]
        self._positions = positions
        self.further = [0.0] * further
        self.reset()

    def reset(self) -> None:
        """Forget all samples; done by itself when the simulation's time goes back."""
        self._compiled.reset()
        self._start: float | None = None
        self._effort, self._time = 0.0, 0.0
        self.samples = self.flags = 0

    def __enter__(self) -> Actuator:
        Actuator._users[self._id] = self
        mujoco.set_mjcb_act_bias(Actuator._bias)
        return self

    def __exit__(self, *error: object) -> None:
        Actuator._users.pop(self._id, None)
        if not Actuator._users:
            mujoco.set_mjcb_act_bias(None)

    @staticmethod
    def _bias(model: Any, data: Any, actuator: int) -> float:
        user = Actuator._users.get(actuator)
        return 0.0 if user is None else user.force(data)

    def force(self, data: Any) -> float:
        """The effort at the simulation's present time."""
        now = float(data.time)
        if self._start is None or now < self._time:
            self.reset()
            self._start = now
        self._time = now
        # A millionth of a period is rounding of the time.
        if self._period is None or self.samples <= (now - self._start) / self._period + 1e-6:
            source = data.qpos if self._positions else data.qvel
            values = [float(data.ctrl[i]) for i in self._fields] + [float(source[i]) for i in self._joints]
            self._effort = self._compiled.step(*values, *self.further)
            self.flags = self._compiled.flags
            self.samples += 1
        return self._effort
