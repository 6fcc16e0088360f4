"""Test vectors hold random and edge rows, the bits that the step must return for them, and what NumPy returns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_numbers import band_of, inverse, inverse_now, reference, run
from erclutch.signals.array import Array
from erclutch.signals.device import speeds_of

STEPS, FIELDS, AHEAD = 256, 48, 32


@dataclass(frozen=True)
class Vectors:
    """Rows and what must come out.

    Attributes:
        rows: inputs of successive steps from a reset, shape (n, inputs), in the step's precision.
        effort, flags: of each step, bit for bit.
        numpy: the model's own NumPy in float64.
        speeds: inputs of the inverse, shape (m, inputs).
        wanted: its efforts.
        field, field_flags: what it returns.
        wanted_now: efforts that are asked of the inverse of the next step ahead of each of the first rows.
        field_now, field_now_flags: what it returns.
        band: low and high end behind each step, shape (n, 2); no rows for a step without alarms.
    """

    rows: NDArray[Any]
    effort: NDArray[Any]
    flags: NDArray[np.uint32]
    numpy: Array
    speeds: NDArray[Any]
    wanted: NDArray[Any]
    field: NDArray[Any]
    field_flags: NDArray[np.uint32]
    wanted_now: NDArray[Any]
    field_now: NDArray[Any]
    field_now_flags: NDArray[np.uint32]
    band: NDArray[Any]


@lru_cache(maxsize=4)
def vectors_of(step: ExportedStep, steps: int = STEPS, fields: int = FIELDS) -> Vectors:
    """The same vectors for the same model, always."""
    rng = np.random.default_rng(int(step.digest[:12], 16))
    dtype = step.precision.dtype
    rows = rows_of(step, rng, steps).astype(dtype)
    effort, flags = run(step, rows)
    band = band_of(step, rows)
    speeds = ordinary(step, rng, fields).astype(dtype)
    low, high = step.model.trained_on.effort
    wanted = rng.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), fields).astype(dtype)
    speeds[: step.elements, step.elements] = np.nan
    wanted[-3:] = (np.nan, np.inf, 0.0)
    field, field_flags = inverse(step, speeds, wanted)
    # Half of them are within reach: the row's own effort, except where the field that gives it is an odd one.
    wanted_now = np.where(np.arange(AHEAD) % 2, wanted[:AHEAD], effort[:AHEAD])
    now, now_flags = inverse_now(step, rows[:AHEAD], wanted_now)
    numpy = reference(step, rows)[0]
    return Vectors(rows, effort, flags, numpy, speeds, wanted, field, field_flags, wanted_now, now, now_flags, band)


def rows_of(step: ExportedStep, rng: np.random.Generator, count: int) -> Array:
    """Ordinary rows, with edges strewn in: one row in eight has an odd value."""
    rows = ordinary(step, rng, count)
    if step.filter is not None:
        at = slice(step.elements, 2 * step.elements)
        rows[:, at] = np.cumsum(rows[:, at], axis=0) * (step.period or 0.0)
    odd = np.flatnonzero(rng.random(count) < 0.125)
    edges = _edges(step)
    for k in odd:
        column = int(rng.integers(len(step.inputs)))
        values = edges[column]
        rows[k, column] = values[int(rng.integers(values.size))]
    return rows


def ordinary(step: ExportedStep, rng: np.random.Generator, count: int) -> Array:
    """Rows inside the training range, speeds in any case: fields that are held for a while, one side at a time."""
    e = step.elements
    low, high = step.field.range
    hold = np.repeat(rng.uniform(low, high, count // 8 + 1), 8)[:count]
    columns = [hold]
    if e == 2:
        first = np.repeat(rng.random(count // 16 + 1) < 0.5, 16)[:count]
        columns = [np.where(first, hold, 0.0), np.where(first, 0.0, hold)]
    slip = [rng.uniform(*step.slip.range, count) for _ in range(e)]
    speeds = speeds_of(step.device, slip)
    extras = [rng.uniform(*window.range, count) for window in step.extras]
    measured = [] if not step.measures else [rng.uniform(*step.limits, count)]
    return np.column_stack([*columns, *speeds, *extras, *measured])


def _edges(step: ExportedStep) -> list[Array]:
    """Odd values of each input: limits, zeros, what is no number, denormals, far outside."""
    info = np.finfo(step.precision.dtype)
    tiny = float(info.smallest_subnormal)
    largest, smallest = float(info.max), float(info.tiny)
    always = [0.0, -0.0, np.nan, np.inf, -np.inf, tiny, smallest, largest, -largest]
    # A stage that tells rise from fall asks for the field's sign: a field of no size but a sign is all rounding there.
    switched = any(stage.switches for stage, _ in step.stages)
    e = step.elements
    windows = [step.field] * e + [step.slip] * e + list(step.extras)
    found: list[Array] = []
    for i, window in enumerate(windows):
        low, high = window.range
        inside = [low, high, *window.warn, *window.hold, 1.5 * high - 0.5 * low, 100.0 * (high - low)]
        angle = step.filter is not None and e <= i < 2 * e
        small: list[float] = [] if switched and i < e else [-100 * tiny]
        found.append(np.array([*always, *small, *([1e-3, -7.0, 2e6] if angle else inside)]))
    return [*found, np.array([*always, *step.limits])]
