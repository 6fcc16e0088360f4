"""The actuator of the export for MuJoCo: when it steps, what it reads, and that it goes when it is left."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

mujoco: Any = pytest.importorskip("mujoco")

from erclutch.wings.exporters.mujoco_actuator import Actuator  # noqa: E402


class Compiled:
    """Answers with what it was given; counts its resets."""

    def __init__(self) -> None:
        self.resets, self.flags, self.seen = 0, 5, []

    def reset(self) -> None:
        self.resets += 1

    def step(self, *values: float) -> float:
        self.seen.append(values)
        return 10.0 * len(self.seen)


def made(period: float | None, *, positions: bool = False, number: int = 3) -> Any:
    actuator = Actuator.__new__(Actuator)
    own: Any = actuator
    own._id, own._period, own._positions, own._fields, own._joints = number, period, positions, [1], [0, 2]
    own._compiled, own.further = Compiled(), [7.0]
    own.reset()
    return actuator


def data(time: float) -> Any:
    return SimpleNamespace(time=time, ctrl=[0.0, 0.5], qpos=[1.0, 2.0, 3.0], qvel=[4.0, 5.0, 6.0])


@pytest.mark.parametrize(("positions", "read"), [(False, (0.5, 4.0, 6.0, 7.0)), (True, (0.5, 1.0, 3.0, 7.0))])
def test_it_steps_once_a_period_and_holds_between(positions: bool, read: tuple[float, ...]) -> None:
    actuator = made(0.1, positions=positions)
    assert (actuator.samples, actuator.flags) == (0, 0)
    efforts = [actuator.force(data(t)) for t in (2.0, 2.05, 2.0999, 2.1 - 1e-9, 2.15, 2.2)]
    assert efforts == [10.0, 10.0, 10.0, 20.0, 20.0, 30.0]
    assert actuator._compiled.seen == [read] * 3
    assert (actuator.samples, actuator.flags) == (3, 5)
    again = made(None)
    assert [again.force(data(t)) for t in (0.0, 0.001)] == [10.0, 20.0]


def test_time_that_goes_back_begins_anew() -> None:
    actuator = made(0.1)
    for t in (0.0, 0.1, 0.2):
        actuator.force(data(t))
    resets = actuator._compiled.resets
    actuator.force(data(0.2))
    assert (actuator._compiled.resets, actuator.samples) == (resets + (0), 3)
    actuator.force(data(0.05))
    assert (actuator._compiled.resets, actuator.samples) == (resets + 1, 1)
    actuator.force(data(0.1))
    assert actuator.samples == 1  # counted from 0.05 s on
    actuator.force(data(0.15))
    assert actuator.samples == 2


def test_it_answers_while_it_is_entered_and_only_for_its_own() -> None:
    one, two = made(None, number=3), made(None, number=4)
    with one:
        assert Actuator._bias(None, data(0.0), 3) == 10.0
        assert Actuator._bias(None, data(0.0), 4) == 0.0
        with two:
            assert Actuator._bias(None, data(0.0), 4) == 10.0
        assert Actuator._bias(None, data(0.0), 4) == 0.0
        assert mujoco.get_mjcb_act_bias() is not None
    assert Actuator._bias(None, data(0.0), 3) == 0.0
    assert mujoco.get_mjcb_act_bias() is None


@pytest.mark.parametrize("positions", [False, True])
def test_names_become_places(positions: bool) -> None:
    places = {"effort": 4, "a": 1, "b": 2, "x": 0, "y": 1}
    model: Any = SimpleNamespace(
        opt=SimpleNamespace(timestep=0.01),
        actuator=lambda name: SimpleNamespace(id=places[name]),
        joint=lambda name: SimpleNamespace(id=places[name]),
        jnt_qposadr=[7, 3],
        jnt_dofadr=[6, 2],
    )

    def of(period: float | None) -> Any:
        return Actuator(
            Compiled(),
            model,
            "effort",
            fields=["b", "a"],
            joints=["y", "x"],
            positions=positions,
            further=2,
            period=period,
        )

    found = of(0.01)
    assert (found._id, found._fields, found._joints) == (4, [2, 1], [3, 7] if positions else [2, 6])
    assert (found.further, found._positions, found._period, found.samples) == ([0.0, 0.0], positions, 0.01, 0)
    assert of(None)._period is None
    assert of(0.01 / (1.0 + 0.9e-6)) is not None
    with pytest.raises(ValueError, match=r"the timestep .* is longer than the model"):
        of(0.01 / (1.0 + 1.1e-5))
