"""Peers of `accuracy.py`: each learns the effort of a device from the rows before, of field and slip, and runs freely.

A peer gets the training stretches, parts of them for its validation, and the test stretches without their effort. All
inputs are standardised by the training rows. What stops a peer, or chooses between its forms, is its validation.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """Rows without a gap.

    Attributes:
        inputs: field, slip, and the position where it is logged, standardised, shape (n, 2 or 3).
        effort: standardised, shape (n,).
        period: in s.
        lead: first rows that are not judged: states and past samples come from them.
    """

    inputs: Array
    effort: Array
    period: float
    lead: int = 0


@dataclass(frozen=True)
class Rows:
    """What a peer learns from.

    Attributes:
        train: to fit.
        validation: to stop and to choose; parts of the training rows of the case.
    """

    train: list[Stretch]
    validation: list[Stretch]


#: Efforts of stretches, each (n,).
Free = Callable[[Sequence[Stretch]], list[Array]]
Peer = Callable[[Rows, int, float], Free]


def rms_error(free: Free, stretches: Sequence[Stretch]) -> float:
    """Root mean square error over all rows of some stretches."""
    efforts = free(stretches)
    errors = np.concatenate(
        [(e - s.effort)[s.lead :] for e, s in zip(efforts, stretches, strict=True)]
    )
    return float(np.sqrt(np.mean(errors**2)))


# --- LightGBM on lags ------------------------------------------------------------------------------------------------

_LAGS = 50


def lagged(stretch: Stretch, step: int) -> Array:
    """Inputs now and some multiples of a step of rows back, shape (n, inputs * 51); the first row stands before."""
    n = len(stretch.effort)
    back = np.maximum(np.arange(n)[:, None] - step * np.arange(_LAGS + 1)[None], 0)
    return stretch.inputs[back].reshape(n, -1)


def lightgbm_on_lags(rows: Rows, seed: int, _seconds: float) -> Free:
    """Trees on fifty past samples; the step between them is the one that validation prefers."""
    import lightgbm  # pyright: ignore[reportMissingImports]

    best: tuple[float, Any, int] | None = None
    for step in (1, 4):
        x, y = _table(rows.train, step)
        model = lightgbm.LGBMRegressor(
            n_estimators=600,
            learning_rate=0.06,
            num_leaves=31,
            min_child_samples=40,
            subsample=0.8,
            subsample_freq=1,
            colsample_bytree=0.5,
            random_state=seed,
            n_jobs=1,
            verbose=-1,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            held = _table(rows.validation, step)
            model.fit(x, y, eval_set=[held], callbacks=[lightgbm.early_stopping(30, verbose=False)])
            error = float(np.sqrt(np.mean((model.predict(held[0]) - held[1]) ** 2)))
        if best is None or error < best[0]:
            best = error, model, step
    assert best is not None
    _, chosen, step = best

    def free(stretches: Sequence[Stretch]) -> list[Array]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return [np.asarray(chosen.predict(lagged(s, step)), np.float64) for s in stretches]

    return free


def _table(stretches: Sequence[Stretch], step: int) -> tuple[Array, Array]:
    """All rows of some stretches, thinned to 40,000."""
    every = max(1, sum(len(s.effort) for s in stretches) // 40_000)
    x = np.concatenate([lagged(s, step)[::every] for s in stretches])
    return x, np.concatenate([s.effort[::every] for s in stretches])


# --- GRU by back-propagation through time ----------------------------------------------------------------------------

_UNITS, _WINDOW, _WARM, _BATCH = 16, 320, 80, 48


def gru(rows: Rows, seed: int, seconds: float) -> Free:
    """A GRU of 16 units on windows of 320 rows, of which the first 80 warm up its state; the best of its validation."""
    import torch  # pyright: ignore[reportMissingImports]

    torch.set_num_threads(1)
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    width = rows.train[0].inputs.shape[1]
    net = torch.nn.GRU(width, _UNITS, batch_first=True)
    out = torch.nn.Linear(_UNITS + width, 1)
    parameters = [*net.parameters(), *out.parameters()]
    optimizer = torch.optim.Adam(parameters, lr=6e-3)
    long = [s for s in rows.train if len(s.effort) > _WINDOW] or rows.train
    share = np.array([len(s.effort) for s in long], float)

    def run(x: Any) -> Any:
        states, _ = net(x)
        return out(torch.cat([states, x], dim=-1))[..., 0]

    def free(stretches: Sequence[Stretch]) -> list[Array]:
        with torch.no_grad():
            return [
                run(torch.tensor(s.inputs[None], dtype=torch.float32))[0].numpy().astype(float)
                for s in stretches
            ]

    def batch() -> tuple[Any, Any]:
        chosen = rng.choice(len(long), _BATCH, p=share / share.sum())
        width = min(_WINDOW, *(len(long[k].effort) for k in chosen))
        begins = [int(rng.integers(0, len(long[k].effort) - width + 1)) for k in chosen]
        x = np.stack([long[k].inputs[b : b + width] for k, b in zip(chosen, begins, strict=True)])
        y = np.stack([long[k].effort[b : b + width] for k, b in zip(chosen, begins, strict=True)])
        return torch.tensor(x, dtype=torch.float32), torch.tensor(y, dtype=torch.float32)

    start, best, kept, step = time.process_time(), np.inf, None, 0
    while (spent := time.process_time() - start) < seconds:
        for group in optimizer.param_groups:
            group["lr"] = 6e-3 * (0.02 + 0.98 * 0.5 * (1.0 + np.cos(np.pi * spent / seconds)))
        x, y = batch()
        warm = min(_WARM, x.shape[1] // 4)
        loss = torch.mean((run(x) - y)[:, warm:] ** 2)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(parameters, 1.0)
        optimizer.step()
        step += 1
        if step % 20 == 0:
            error = rms_error(free, rows.validation)
            if error < best:
                best, kept = error, [p.detach().clone() for p in parameters]
    for p, value in zip(parameters, kept or parameters, strict=True):
        p.data.copy_(value)
    return free


# --- FROLS of SysIdentPy ---------------------------------------------------------------------------------------------


def frols(rows: Rows, _seed: int, _seconds: float) -> Free:
    """NARX polynomials by forward regression, run freely on their own output; degree and lags by validation."""
    from sysidentpy.basis_function import Polynomial  # pyright: ignore[reportMissingImports]
    from sysidentpy.model_structure_selection import FROLS  # pyright: ignore[reportMissingImports]

    every = max(1, sum(len(s.effort) for s in rows.train) // 3_000)
    longest = max(rows.train, key=lambda s: len(s.effort))
    best: tuple[float, Free] | None = None
    for degree, lag in ((1, 4), (2, 2), (3, 1)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model = FROLS(
                order_selection=True,
                n_info_values=12,
                ylag=lag,
                xlag=[list(range(1, lag + 1))] * longest.inputs.shape[1],
                basis_function=Polynomial(degree=degree),
            )
            model.fit(X=longest.inputs[::every], y=longest.effort[::every, None])

        def free(stretches: Sequence[Stretch], model: Any = model) -> list[Array]:
            return [_narx(model, s, every) for s in stretches]

        error = rms_error(free, rows.validation)
        if best is None or error < best[0]:
            best = error, free
    assert best is not None
    return best[1]


def _narx(model: Any, stretch: Stretch, every: int) -> Array:
    """A free run on every so manieth row, then lines between these; it starts from no effort and cannot run away."""
    x = stretch.inputs[::every]
    start = np.zeros((int(model.max_lag), 1))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        y = np.asarray(model.predict(X=x, y=start), np.float64).ravel()
    y = np.clip(np.nan_to_num(y, nan=0.0, posinf=4.0, neginf=-4.0), -4.0, 4.0)
    at = np.arange(len(stretch.effort), dtype=float)
    return np.interp(at, at[::every][: y.size], y)


# --- Bouc-Wen and Spencer by SciPy -----------------------------------------------------------------------------------


@njit(cache=False)
def _run_bouc_wen(x: Array, period: float, q: Array, spencer: bool) -> Array:
    """Bouc-Wen's or Spencer's force for field and slip, shape (n, 2 or 3); constants grow with the lagged field."""
    out = np.empty(len(x))
    z = u = position = inner = 0.0
    u = x[0, 0]
    share = 1.0 - np.exp(-period / np.exp(q[0]))
    gamma, beta, a = np.exp(q[1]), np.exp(q[2]), np.exp(q[3])
    for k in range(len(x)):
        v = x[k, 1]
        u += share * (x[k, 0] - u)
        alpha, c0 = q[4] + q[5] * u, q[6] + q[7] * u
        rate = v
        if spencer:
            c1 = np.exp(q[11]) * (1.0 + np.exp(q[12]) * (u + 3.0))
            rate = (alpha * z + c0 * v + q[8] * (position - inner)) / (c0 + c1)
        relative = v - rate if spencer else v
        inner += period * rate if spencer else 0.0
        steps = 4
        for _ in range(steps):
            dz = a * relative - beta * relative * abs(z) - gamma * abs(relative) * z
            z = min(max(z + period / steps * dz, -50.0), 50.0)
        position = 0.999 * (position + period * v)
        inner *= 0.999
        force = c1 * rate if spencer else alpha * z + c0 * v
        out[k] = min(max(force + q[9] * position + q[10], -1e3), 1e3)
    return out


def _bouc_wen(rows: Rows, seed: int, seconds: float, *, spencer: bool) -> Free:
    rng, start = np.random.default_rng(seed), time.process_time()
    few = [_shortened(s, 6_000 // max(len(rows.train), 1) + 400) for s in rows.train]
    first = np.array([-4.0, 0.0, 0.0, 1.0, 0.5, 0.2, 0.3, 0.1, 0.0, 0.0, 0.0, 1.0, -2.0])
    first[:4] += np.log([1.0, 10.0, 10.0, 10.0])

    def missed(q: Array) -> Array:
        errors = [_run_bouc_wen(s.inputs, s.period, q, spencer) - s.effort for s in few]
        return np.nan_to_num(np.concatenate(errors), nan=1e3, posinf=1e3, neginf=-1e3)

    best: tuple[float, Array] = (np.inf, first)
    while time.process_time() - start < seconds:
        guess = first + rng.normal(size=first.size) * np.r_[1.5, 1.5, 1.5, 1.0, np.full(9, 0.3)]
        found = least_squares(
            missed, guess, x_scale="jac", method="trf", max_nfev=60, loss="linear"
        )

        def free(stretches: Sequence[Stretch], q: Array = found.x) -> list[Array]:
            return [
                np.clip(np.nan_to_num(_run_bouc_wen(s.inputs, s.period, q, spencer)), -4, 4)
                for s in stretches
            ]

        error = rms_error(free, rows.validation)
        if error < best[0]:
            best = error, found.x

    def chosen(stretches: Sequence[Stretch]) -> list[Array]:
        runs = [_run_bouc_wen(s.inputs, s.period, best[1], spencer) for s in stretches]
        return [np.clip(np.nan_to_num(run), -4.0, 4.0) for run in runs]

    return chosen


def _shortened(stretch: Stretch, rows: int) -> Stretch:
    """A stretch's middle, so that each evaluation is quick."""
    begin = max(0, (len(stretch.effort) - rows) // 2)
    return Stretch(
        stretch.inputs[begin : begin + rows], stretch.effort[begin : begin + rows], stretch.period
    )


def bouc_wen(rows: Rows, seed: int, seconds: float) -> Free:
    """Bouc-Wen with a lagged field, a dashpot, a spring and a constant, from many random starts."""
    return _bouc_wen(rows, seed, seconds, spencer=False)


def spencer(rows: Rows, seed: int, seconds: float) -> Free:
    """Spencer's modified Bouc-Wen (1997), from many random starts."""
    return _bouc_wen(rows, seed, seconds, spencer=True)


PEERS: dict[str, Peer] = {
    "LightGBM, 50 lags": lightgbm_on_lags,
    "GRU, 16 units": gru,
    "FROLS, free run": frols,
    "Bouc-Wen": bouc_wen,
    "Spencer": spencer,
}
