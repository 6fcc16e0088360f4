"""An exported step that follows a torque sensor: the bits of the record in the C, its budget, and what a reset does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.export import ExportOptions, export_model, step_of, verify_export
from erclutch.export.exported_step import ADAPTED, ExportedStep
from erclutch.export.step_numbers import inverse, inverse_now, run
from erclutch.export.step_record import has_memory
from erclutch.export.targets.python import compile_model
from erclutch.models.model import Model
from erclutch.signals.array import Array

pytestmark = pytest.mark.slow

LABELS = ("bingham, single", "bingham+rise-fall, coaxial")
ROWS = 800


def adapting(model: Any, precision: Any = "float64") -> ExportedStep:
    return step_of(model, ExportOptions("m", precision, 1e-3, adapt=True))


def motion(made: ExportedStep, rows: int = ROWS) -> Array:
    """Rows within the ranges; no measured effort."""
    t, e = np.arange(rows) / 1000.0, made.elements
    field = 300.0 * (1.0 + np.sin(40.0 * t))
    fields = (
        [field]
        if e == 1
        else [np.where(t % 0.2 < 0.1, field, 0.0), np.where(t % 0.2 < 0.1, 0.0, field)]
    )
    speeds = [12.0 * np.sin(15.0 * t + i) for i in range(e)]
    return np.column_stack([*fields, *speeds, np.full(rows, np.nan)])


def hostile(kind: str, base: Array, scale: float) -> Array:
    """Measured efforts for efforts of the model."""
    rng, said = np.random.default_rng(3), 1.2 * base + 0.1 * scale
    half = base.size // 2
    odd = rng.choice([np.nan, np.inf, -np.inf, 1e30, -1e30, 5e-324, 0.0], base.size)
    return {
        "gain": said,
        "stuck": np.where(np.arange(base.size) < half, said, said[half]),
        "odd": np.where(rng.random(base.size) < 0.3, odd, said),
        "flipped": said * np.where(np.arange(base.size) // 100 % 2, -1.0, 1.0),
        "noise": rng.normal(0.0, scale, base.size),
    }[kind]


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("label", LABELS)
def test_c_and_record_have_the_same_bits_on_hostile_streams_and_keep_the_budget(
    label: str, precision: str, models: dict[str, Model], need: Callable[..., None]
) -> None:
    need("gcc")
    made = adapting(models[label], precision)
    device, limit, adapted = compile_model(made), 0.25 * made.scale, 0
    base = run(made, motion(made))[0].astype(np.float64)
    kinds = (
        "gain",
        "stuck",
        "odd",
        "flipped",
        "noise",
        *(() if has_memory(made) else ("adversary",)),
    )
    for kind in kinds:
        rows = motion(made)
        said = hostile("gain" if kind == "adversary" else kind, base, limit)
        device.reset()
        for k, row in enumerate(rows.tolist()):
            if (
                kind == "adversary" and k > ROWS // 3
            ):  # it sees the effort first; a row twice is as once
                given = device.step(*row)
                said[k] = base[k] - 1e3 * (given - base[k]) if given != base[k] else said[k]
            rows[k, -1] = said[k]
            row[-1] = said[k]
            device.step(*row)
        rows = rows.astype(made.precision.dtype).astype(np.float64)
        device.reset()
        effort, flags = (np.array(x) for x in device.run(np.ascontiguousarray(rows)))
        wanted, wanted_flags = run(made, rows)
        assert np.array_equal(effort, wanted.astype(np.float64)), kind
        assert np.array_equal(flags, wanted_flags), kind
        finite = np.isfinite(rows[:, -1])
        own, other = (
            np.cumsum(np.clip(rows[finite, -1] - x[finite], -limit, limit) ** 2)
            for x in (effort, base)
        )
        assert np.all(own <= (1.02**2 + 1e-4) * other + 1e-6 * limit**2), kind
        assert np.array_equal(effort[(flags & ADAPTED) == 0], base[(flags & ADAPTED) == 0])
        adapted += int(np.sum(effort != base))
    assert adapted > ROWS


def test_a_gain_is_followed_and_a_reset_restores_the_model(
    models: dict[str, Model], need: Callable[..., None]
) -> None:
    need("gcc")
    made = adapting(models[LABELS[0]])
    device = compile_model(made)
    rows = motion(made, 2000)
    base = np.array(device.run(np.ascontiguousarray(rows))[0])
    rows[:, -1] = 0.9 * base
    for _ in range(2):  # the second time as the first
        device.reset()
        effort, flags = (np.array(x) for x in device.run(np.ascontiguousarray(rows)))
        assert effort[0] == base[0]
        assert np.abs(effort - rows[:, -1])[1000:].max() < 0.01 * np.abs(base).max()
        assert np.all(flags[1000:] & ADAPTED)


def test_adaptation_changes_no_inverse(models: dict[str, Model]) -> None:
    made, plain = (
        adapting(models[LABELS[1]]),
        step_of(models[LABELS[1]], ExportOptions("m", period=1e-3)),
    )
    rows, wanted = motion(made, 20), np.linspace(-0.5, 0.5, 20)
    rows[:, -1] = 0.3
    for of in (inverse, inverse_now):
        for got, expected in zip(
            of(made, rows, wanted), of(plain, rows[:, :-1], wanted), strict=True
        ):
            assert np.array_equal(got, expected)


@pytest.mark.parametrize("to", ["c", "python"])
def test_exports_that_adapt_verify(
    to: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "g++")
    checks = verify_export(
        export_model(
            models[LABELS[1]], tmp_path / to, to, ExportOptions("m", "float32", 1e-3, adapt=True)
        )
    )  # type: ignore[type-var]
    assert checks
    assert all(check.passed and check.other_bits == 0 for check in checks), checks
