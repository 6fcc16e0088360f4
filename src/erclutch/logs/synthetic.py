"""Tests and studies try things on this small log: a made-up clutch, SYNTHETIC; no measurement and not the twin.

It is no law of the ladder: chains strain elastically before they yield (a Dahl-type state), the yield torque follows
the critical-field form, the viscosity thins with slip and rises with the field, and the field lags behind the command.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from erclutch.signals.array import Array

RATE = 1000.0
LABEL = "SYNTHETIC"
_LAG_S = 4.0e-3  # of the field behind the command
_DEAD_ROWS = 2  # before the field begins to follow


def synthetic_log(seconds: float = 20.0, seed: int = 0) -> dict[str, tuple[str, Array]]:
    """Columns of the demonstration log: name -> (unit, samples).

    Args:
        seconds: length of the log; sampled at 1 kHz.
        seed: of the random command, motion and noise.
    """
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    command = _steps(rng, n)
    slip = _motion(rng, n)
    torque = _torque(command, slip)
    return {
        "time": ("s", np.arange(n) / RATE),
        "field": ("V", command),
        "slip": ("rad/s", slip),
        "torque": ("N*m", _measured(torque, rng)),
    }


def synthetic_pair(seconds: float = 20.0, seed: int = 0) -> dict[str, tuple[str, Array]]:
    """Columns of a log of two such clutches on one output, driven in opposite directions: name -> (unit, samples).

    One of the two has a field at a time, or none has. The motor turns at some 40 rad/s and the output to and fro.

    Args:
        seconds: length of the log; sampled at 1 kHz.
        seed: of the random commands, motions and noise.
    """
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    one_after_another = _steps(rng, n)
    first_is_on = _steps(rng, n) > 0.0
    first = np.where(first_is_on, one_after_another, 0.0)
    second = np.where(first_is_on, 0.0, one_after_another)
    motor = 40.0 + 0.5 * _motion(rng, n)
    output = _motion(rng, n)
    torque = _torque(first, motor - output) + _torque(second, -motor - output)
    return {
        "time": ("s", np.arange(n) / RATE),
        "E1": ("V", first),
        "E2": ("V", second),
        "theta_dot": ("rad/s", motor),
        "alpha_dot": ("rad/s", output),
        "T": ("N*m", _measured(torque, rng)),
    }


def _torque(command: Array, slip: Array) -> Array:
    """Torque of one clutch in N*m, from its command in V and its slip in rad/s, row by row."""
    torque = np.empty(command.size)
    field = 0.0
    bend = 0.0  # strain of the chains, over that at which they yield
    share = -np.expm1(-1.0 / (RATE * _LAG_S))
    for k in range(command.size):
        field += share * (command[max(k - _DEAD_ROWS, 0)] - field)
        strength = field / 1500.0
        yield_torque = 0.02 + 0.45 * strength**1.5 * np.tanh(strength**0.5)
        # Pre-yield strain of the chains: elastic at first, then sliding (Dahl's model, implicit in the strain).
        rate = slip[k] / 0.01
        bend = (bend + rate / RATE) / (1.0 + abs(rate) / RATE)
        viscosity = 4.0e-3 * (1.0 + 1.5 * strength) / (1.0 + abs(slip[k]) / 60.0) ** 0.3
        torque[k] = yield_torque * bend + viscosity * slip[k]
    return torque


def _measured(torque: Array, rng: np.random.Generator) -> Array:
    """The torque with the noise and the resolution of a sensor."""
    noise = 2.0e-3 * rng.standard_normal(torque.size)
    step = 1e-4
    return np.round((torque + noise) / step) * step


def _steps(rng: np.random.Generator, n: int) -> Array:
    """Square field of random height (0 in a third of the cases) and duration, 10 - 250 ms."""
    out = np.empty(n)
    at = 0
    while at < n:
        width = int(rng.integers(10, 250))
        out[at : at + width] = 0.0 if rng.random() < 1 / 3 else rng.uniform(0.0, 2000.0)
        at += width
    return out


def _motion(rng: np.random.Generator, n: int) -> Array:
    """A sum of sines between 0.3 and 8 Hz, through zero slip both ways."""
    t = np.arange(n) / RATE
    hertz = rng.uniform(0.3, 8.0, 8)
    phase = rng.uniform(0.0, 2 * np.pi, 8)
    angle = 2 * np.pi * hertz[:, None] * t + phase[:, None]  # shape (sines, n)
    return 12.0 * np.sin(angle).sum(axis=0)


def write_synthetic_log(path: Path, seconds: float = 20.0, seed: int = 0) -> None:
    """Write the demonstration log as CSV with units in its header and its label in the first line."""
    columns = synthetic_log(seconds, seed)
    header = ",".join(f"{name} [{unit}]" for name, (unit, _) in columns.items())
    rows = np.column_stack([values for _, values in columns.values()])
    header = f"# {LABEL}: made by erclutch.logs.synthetic, seed {seed}\n{header}"
    np.savetxt(
        path,
        rows,
        delimiter=",",
        fmt="%.6g",
        header=header,
        comments="",
    )


def write_hysteretic_log(path: Path, seconds: float = 24.0, seed: int = 0) -> None:
    """Write the log of a brake with hysteresis as CSV: a Dahl state that yields over 0.15 rad of travel.

    The current stands still for a sixth of the time at each of its levels, and the slip is the sum of two sines.
    """
    rng = np.random.default_rng(seed)
    travel = 0.15  # [rad]
    period = 1e-3  # [s]
    time = np.arange(round(seconds / period)) * period
    levels = np.array([0.0, 0.5, 1.0, 1.5, 1.0, 0.5])
    sixth = np.minimum(levels.size * np.arange(time.size) // time.size, levels.size - 1)
    current = levels[sixth]  # [A]
    slip = 4.0 * np.sin(9.0 * time) + 2.0 * np.sin(2.3 * time)  # [rad/s]
    state = 0.0
    strained = np.zeros_like(time)  # the state in each row
    for row, w in enumerate(slip):
        aim = float(np.sign(w))
        state = aim + (state - aim) * float(np.exp(-abs(w) * period / travel))
        strained[row] = state
    noise = 0.005 * rng.standard_normal(time.size)  # [N m]
    torque = (0.05 + 0.4 * current) * strained + 0.01 * slip + noise
    header = f"# {LABEL}: made by erclutch.logs.synthetic, seed {seed}\ntime [s],current [A],slip [rad/s],torque [N*m]"
    rows = np.column_stack([time, current, slip, torque])
    np.savetxt(
        path,
        rows,
        delimiter=",",
        fmt="%.6g",
        header=header,
        comments="",
    )
