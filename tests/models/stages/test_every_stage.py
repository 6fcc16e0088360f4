"""What every stage must hold; a new stage is tested by being there."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import partial_of, seed
from erclutch.errors import SettingError
from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import native
from erclutch.export.step_numbers import run
from erclutch.export.targets.python import compile_model
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import ladder, law_from_name
from erclutch.models.laws.law import ShapeParameter
from erclutch.models.model import Range
from erclutch.models.stages import GROUP, needs_time, stage_named
from erclutch.models.stages.stage import (
    Memory,
    PositionStage,
    SlipAndStrength,
    SlipStage,
    Stage,
    StageFamily,
)
from erclutch.models.stages.temperature_factor import TemperatureFactor
from erclutch.models.structure import Reference, Structure
from erclutch.registry import find, names
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.recording import POSITION, TEMPERATURE

STAGES = {
    stage.name: stage
    for name in names(GROUP)
    for plugin in [find(GROUP, name)]
    for forms in (
        ("", *(f"/{form}" for form in plugin.value.forms))
        if isinstance(plugin.value, StageFamily)
        else ("",)
    )
    for number in (
        ("", "-3") if isinstance(plugin.value, StageFamily) and plugin.value.count else ("",)
    )
    for stage in [stage_named(f"{name}{number}{forms}")]
}
PERIOD, ROWS = 1e-3, 240
CLOCK = Clock(np.arange(ROWS, dtype=np.float64) * PERIOD, (Span(0, ROWS, PERIOD),))
stages = pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))


def inside(shape: ShapeParameter) -> float:
    """A value within the bounds that is no round number of rows."""
    if shape.scale == "log":
        return float(shape.lower * (shape.upper / shape.lower) ** 0.43)
    return shape.lower + 0.137 * (shape.upper - shape.lower)


def signal() -> Array:
    rng = np.random.default_rng(8)
    steps = np.repeat(rng.uniform(0.05, 1.0, ROWS // 12), 12)
    return steps + 0.02 * np.sin(np.arange(ROWS) / 7.0)


class Plain:
    """The memory of a step in plain floats."""

    def __init__(self) -> None:
        self.kept: dict[str, Any] = {}
        self.next: dict[str, Any] = {}
        self.past: dict[str, list[Any]] = {}
        self.initial: Mapping[str, Any] = {}

    def before(self, name: str) -> Any:
        return self.kept.get(name, self.initial[name])

    def keep(self, name: str, value: Any) -> Any:
        self.next[name] = value if self.kept else self.initial[name]
        return self.next[name]

    def back(self, name: str, value: Any, rows: int) -> Any:
        history = self.past.setdefault(f"{name} {rows}", [value] * rows)
        history.append(value)
        return history[-1 - rows]

    def number(self, value: float) -> float:
        return value

    def row(self, stage: Stage, u: Any, q: Mapping[str, float]) -> list[float]:
        self.initial = stage.initial(u, q)
        memory: Memory = self
        out = stage.step(memory, u, q, PERIOD)
        self.kept = dict(self.next)
        return [float(x[0]) for x in out]


def numbers(stage: Stage) -> dict[str, float]:
    return {shape.name: inside(shape) for shape in stage.parameters(PERIOD)}


def coming(stage: Stage, u: Array) -> Any:
    """What comes into a stage for a signal: of a stage on the slip a slip that turns, and the signal as strength."""
    return (
        SlipAndStrength(2.0 * np.sin(np.arange(u.size) / 11.0), u) if stage.place == "slip" else u
    )


def rows_of(signal: Any) -> list[Any]:
    """A signal row by row, in numbers that round as the C does."""
    if isinstance(signal, SlipAndStrength):
        pairs = zip(signal.slip.tolist(), signal.strength.tolist(), strict=True)
        return [
            SlipAndStrength(array_as_in_c([slip]), array_as_in_c([strength]))
            for slip, strength in pairs
        ]
    return [array_as_in_c([x]) for x in signal.tolist()]


def responses(stage: Stage, signal: Any, q: Sequence[Any], rows: slice = slice(None)) -> list[Any]:
    """All outputs."""
    found = stage.respond(signal, CLOCK, q, rows)
    return [found] if stage.place in ("command", "effort") else list(found)


def exactly(signal: Any) -> Any:
    return (
        SlipAndStrength(*map(array_as_in_c, signal))
        if isinstance(signal, SlipAndStrength)
        else array_as_in_c(signal)
    )


@stages
def test_it_says_what_it_is(stage: Stage) -> None:
    assert stage.title
    assert stage.source
    assert stage.place in ("command", "slip", "effort", "temperature", "position")
    names = [shape.name for shape in stage.parameters(PERIOD)]
    assert len(set(names)) == len(names)
    assert all(shape.lower < shape.scanned[0] < shape.scanned[1] <= shape.upper or shape.usual is None
               for shape in stage.parameters(PERIOD))  # fmt: skip
    assert all(shape.lower < shape.upper for shape in stage.parameters(PERIOD))
    if stage.place == "slip":
        assert isinstance(stage, SlipStage)
        settled = stage.settled(SlipAndStrength(0.5, 0.7), numbers(stage))
        assert len(settled) == len(set(stage.outputs)) == len(stage.outputs)
        assert len(stage.columns(settled, 0.7)) == len(stage.gains)
    if stage.place == "position":
        assert isinstance(stage, PositionStage)
        assert len(stage.outputs_at(0.5, *numbers(stage).values())) == len(stage.gains)


@stages
@pytest.mark.parametrize("period", [1e-6, 1e-3, 0.1, 1.0, 26.0, 3600.0])
def test_numbers_have_room_at_any_sampling_period(stage: Stage, period: float) -> None:
    for shape in stage.parameters(period):
        assert shape.lower < shape.upper, shape
        if shape.usual is not None:
            low, high = shape.usual
            assert shape.lower <= low < high <= shape.upper, shape


@pytest.mark.slow
@stages
def test_the_step_is_the_response(stage: Stage) -> None:
    q, u, memory = numbers(stage), coming(stage, signal()), Plain()
    stepped = np.array([memory.row(stage, x, q) for x in rows_of(u)]).T
    for mine, whole, exact in zip(
        stepped,
        responses(stage, u, list(q.values())),
        responses(stage, exactly(u), list(q.values())),
        strict=True,
    ):
        np.testing.assert_allclose(
            mine, whole, rtol=0, atol=1e-12 * max(1.0, float(np.abs(mine).max()))
        )
        np.testing.assert_array_equal(mine, np.asarray(exact))


@stages
def test_it_starts_at_rest(stage: Stage) -> None:
    level: Any = np.full(ROWS, 0.37)
    if stage.place == "slip":
        assert isinstance(stage, SlipStage)
        long = SlipAndStrength(level, 0.5 * level)
        for found, settled in zip(
            responses(stage, long, list(numbers(stage).values())),
            stage.settled(SlipAndStrength(0.37, 0.185), numbers(stage)),
            strict=True,
        ):
            np.testing.assert_allclose(found[0], settled, rtol=1e-12)
        return
    if isinstance(stage, PositionStage):
        for found, output in zip(
            responses(stage, level, list(numbers(stage).values())),
            stage.outputs_at(0.37, *numbers(stage).values()),
            strict=True,
        ):
            np.testing.assert_allclose(found, np.full(ROWS, output), rtol=1e-12)
        return
    found = stage.respond(level, CLOCK, list(numbers(stage).values()), slice(None))
    if isinstance(stage, TemperatureFactor):
        level = stage.factor(0.37, *numbers(stage).values())
        assert stage.factor(1.0, *numbers(stage).values()) == 1.0
    np.testing.assert_allclose(found, level, rtol=1e-12)


@stages
def test_some_rows_are_those_of_all(stage: Stage) -> None:
    q, u = list(numbers(stage).values()), coming(stage, signal())
    some = slice(50, 90)
    for part, whole in zip(responses(stage, u, q, some), responses(stage, u, q), strict=True):
        np.testing.assert_array_equal(part, whole[some])


@stages
def test_only_a_stage_that_needs_no_time_says_the_same_of_rows_in_another_order(
    stage: Stage,
) -> None:
    q, u = list(numbers(stage).values()), coming(stage, signal())
    order = np.random.default_rng(2).permutation(ROWS)
    turned = (
        SlipAndStrength(u.slip[order], u.strength[order]) if stage.place == "slip" else u[order]
    )
    same = True
    for whole, again in zip(responses(stage, u, q), responses(stage, turned, q), strict=True):
        same &= np.allclose(np.asarray(whole)[order], again, rtol=1e-9, atol=1e-12)
    assert same != needs_time(stage)


@stages
def test_derivatives_are_those_of_differences(stage: Stage) -> None:
    q, u = list(numbers(stage).values()), coming(stage, signal())
    found = responses(stage, u, seed(q))
    for k, value in enumerate(q):
        h = 1e-5 * value
        ends = [responses(stage, u, [*q[:k], value + s * h, *q[k + 1 :]]) for s in (1, -1)]
        for output, up, down in zip(found, *ends, strict=True):
            slope = (up - down) / (2 * h)
            np.testing.assert_allclose(
                partial_of(output, k) + 0.0 * slope,
                slope,
                atol=2e-5 * float(np.max(np.abs(slope))) + 1e-12,
            )


def model_with(stage: Stage) -> TorqueModel:
    structure = Structure("single", "bingham", law_from_name("bingham", "single"), stage.name)
    shape = {s.name: inside(s) for s in structure.shapes(PERIOD)}
    gains = {g.name: 0.3 + 0.1 * i for i, g in enumerate(structure.gains())}
    ranges = Range((0.0, 2.0), (-3.0, 3.0), (-2e4, 2e4))
    warm = [(250.0, 400.0)] * len(structure.extras)
    reference = Reference(2.0, 1.7, PERIOD, (320.0,) * len(warm), 320.0)
    return TorqueModel(
        structure, reference, shape, gains, Units("N", "A", "m/s"), ranges, extra_ranges=tuple(warm)
    )


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.slow
@stages
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_c_has_the_bits_of_the_record_and_of_predict(
    stage: Stage, precision: Any, tmp_path: Path
) -> None:
    try:
        native()
    except Exception as error:
        pytest.skip(f"no compiler: {error}")
    model = model_with(stage)
    step = step_of(model, ExportOptions("m", precision, PERIOD))
    warm = {name: 320.0 + 60.0 * np.sin(np.arange(ROWS) / 29.0) for name in model.extras}
    rows = np.column_stack([2.0 * signal(), np.sin(np.arange(ROWS) / 11.0), *warm.values()])
    effort, flags = run(step, rows)
    found, found_flags = compile_model(step).run(rows)
    np.testing.assert_array_equal(np.asarray(found).astype(step.precision.dtype), effort)
    np.testing.assert_array_equal(np.asarray(found_flags), flags)
    if precision == "float64":
        inputs = [Element(rows[:, 0].copy(), rows[:, 1].copy())]
        held = np.minimum(np.maximum(inputs[0].field, step.field.hold[0]), step.field.hold[1])
        expected = model.effort([Element(held, inputs[0].slip)], CLOCK, warm)
        np.testing.assert_array_equal(effort, expected)


@stages
def test_the_equation_names_all_numbers_and_outputs(stage: Stage) -> None:
    names = [p.name for p in stage.parameters(PERIOD)] + (
        list(stage.outputs) if isinstance(stage, SlipStage) else []
    )
    words = set(re.findall(r"[A-Za-z]\w*", stage.equation))
    assert set(names) <= words, set(names) - words
    assert f"{stage.name}: {stage.equation}." in model_with(stage).equation()


@pytest.mark.parametrize(
    ("stage", "offered"),
    [
        ("bouc-wen-0", "bouc-wen-N with N from 1 to 8"),
        ("bouc-wen-9", "bouc-wen-N with N from 1 to 8"),
        ("bouc-wen/nothing", "bouc-wen-N with N from 1 to 8"),
        ("lugre/field/more", "lugre, lugre/field, lugre/sides"),
    ],
)
def test_a_form_that_a_stage_does_not_have_is_refused(stage: str, offered: str) -> None:
    with pytest.raises(SettingError, match=f"unknown stage '{stage}'.*{offered}"):
        Structure("single", "bingham", law_from_name("bingham", "single"), dynamics=stage)


@pytest.mark.parametrize("stage", ["arrhenius", "softening", "softening/exponential"])
def test_a_stage_of_temperature_asks_for_the_temperature(stage: str) -> None:
    assert Structure(
        "single", "bingham", law_from_name("bingham", "single"), dynamics=stage
    ).extras == (TEMPERATURE,)
    assert Structure("single", "bingham", law_from_name("bingham", "single")).extras == ()


def test_a_stage_of_the_position_asks_for_the_position() -> None:
    assert Structure(
        "single", "bingham", law_from_name("bingham", "single"), dynamics="ripple"
    ).extras == (POSITION,)


@pytest.mark.parametrize("device", ["single", "coaxial"])
def test_a_gain_has_a_name_that_no_law_and_no_other_stage_has(device: DeviceName) -> None:
    # Two numbers of one name are one number in a table, and in the comment of an export.
    elements = ("_1", "_2") if device == "coaxial" else ("",)
    gains: dict[str, set[str]] = {}  # of each file, in all of its numbers and forms
    numbers: dict[str, set[str]] = {}
    for name, stage in STAGES.items():
        file = re.sub(r"-\d+$", "", name.split("/")[0])
        per_device = elements if stage.place == "slip" else ("",)
        own = {f"{gain.name}{end}" for gain in getattr(stage, "gains", ()) for end in per_device}
        gains.setdefault(file, set()).update(own)
        numbers.setdefault(file, set()).update(own, (p.name for p in stage.parameters(PERIOD)))
    for name in ladder():
        law = law_from_name(name, device)
        own = {f"{gain.name}{end}" for gain in law.gains for end in elements}
        own |= {shape.name for shape in (*law.stimulus_shape, *law.shape)}
        gains[name], numbers[name] = own, own
    laws = set(ladder())
    for one, own in gains.items():
        for other, theirs in numbers.items():
            if one != other and not {one, other} <= laws:
                assert not own & theirs, (one, other)


def test_a_model_whose_numbers_share_a_name_is_refused() -> None:
    law = law_from_name("bingham", "single")
    with pytest.raises(
        SettingError, match=r"two numbers of bingham\+inertia.* are called m_a"
    ) as one:
        Structure("single", "bingham", law, "inertia+inertia/smooth")
    assert "Leave one" in one.value.remedy
