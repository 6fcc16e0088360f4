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

STEPS = 256  # rows of test vectors
FIELDS = 48  # inverses at rest
AHEAD = 32  # inverses of the next step


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
    """The vectors of a step; a model always gets the same ones."""
    rng = np.random.default_rng(int(step.digest[:12], 16))
    dtype = step.precision.dtype
    rows = rows_of(step, rng, steps).astype(dtype)
    effort, flags = run(step, rows)
    band = band_of(step, rows)
    speeds = ordinary(step, rng, fields).astype(dtype)
    speeds[: step.elements, step.elements] = np.nan

    low, high = step.model.trained_on.effort
    slack = 0.1 * (high - low)
    wanted = rng.uniform(low - slack, high + slack, fields).astype(dtype)
    wanted[-3:] = (np.nan, np.inf, 0.0)
    field, field_flags = inverse(step, speeds, wanted)
    # Half of them are within reach: the row's own effort, except where the field that gives it is an odd one.
    wanted_now = np.where(np.arange(AHEAD) % 2, wanted[:AHEAD], effort[:AHEAD])
    field_now, field_now_flags = inverse_now(step, rows[:AHEAD], wanted_now)
    of_numpy, _ = reference(step, rows)
    return Vectors(
        rows=rows,
        effort=effort,
        flags=flags,
        numpy=of_numpy,
        speeds=speeds,
        wanted=wanted,
        field=field,
        field_flags=field_flags,
        wanted_now=wanted_now,
        field_now=field_now,
        field_now_flags=field_now_flags,
        band=band,
    )


def rows_of(step: ExportedStep, rng: np.random.Generator, count: int) -> Array:
    """Ordinary rows, with edges strewn in: one row in eight has an odd value."""
    rows = ordinary(step, rng, count)
    if step.filter is not None:
        angles = slice(step.elements, 2 * step.elements)
        rows[:, angles] = np.cumsum(rows[:, angles], axis=0) * (step.period or 0.0)
    odd_rows = np.flatnonzero(rng.random(count) < 0.125)
    edges = odd_values(step)
    for row in odd_rows:
        column = int(rng.integers(len(step.inputs)))
        odd = edges[column]
        rows[row, column] = odd[int(rng.integers(odd.size))]
    return rows


def ordinary(step: ExportedStep, rng: np.random.Generator, count: int) -> Array:
    """Rows inside the training range, speeds in any case: fields that are held for a while, one side at a time."""
    low, high = step.field.range
    drawn = rng.uniform(low, high, count // 8 + 1)
    held = np.repeat(drawn, 8)[:count]
    fields = [held]
    if step.elements == 2:
        sides = rng.random(count // 16 + 1) < 0.5
        first = np.repeat(sides, 16)[:count]
        fields = [np.where(first, held, 0.0), np.where(first, 0.0, held)]
    slips = [rng.uniform(*step.slip.range, count) for _ in range(step.elements)]
    speeds = speeds_of(step.device, slips)
    extras = [rng.uniform(*window.range, count) for window in step.extras]
    measured = [rng.uniform(*step.limits, count)] if step.measures else []
    return np.column_stack([*fields, *speeds, *extras, *measured])


def odd_values(step: ExportedStep) -> list[Array]:
    """Odd values of each input: limits, zeros, what is no number, denormals, far outside."""
    info = np.finfo(step.precision.dtype)
    tiny = float(info.smallest_subnormal)
    largest = float(info.max)
    smallest = float(info.tiny)
    always = [0.0, -0.0, np.nan, np.inf, -np.inf, tiny, smallest, largest, -largest]
    # A stage that tells rise from fall asks for the field's sign: a field of no size but a sign is all rounding there.
    switched = any(stage.switches for stage, _ in step.stages)
    elements = step.elements
    windows = [step.field] * elements + [step.slip] * elements + list(step.extras)
    edges: list[Array] = []
    for i, window in enumerate(windows):
        is_field = i < elements
        is_angle = step.filter is not None and elements <= i < 2 * elements
        low, high = window.range
        span = high - low
        if is_angle:
            own = [1e-3, -7.0, 2e6]
        else:
            own = [low, high, *window.warn, *window.hold, 1.5 * high - 0.5 * low, 100.0 * span]
        small: list[float] = [] if switched and is_field else [-100 * tiny]
        edges.append(np.array([*always, *small, *own]))
    return [*edges, np.array([*always, *step.limits])]
