"""What a live loop can see of its sensors, in numbers that grow with how unusual it is. TWIN.

`studies/sensor_bound.py` looks in healthy sessions for rows that are as unusual as those of a fault.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from erclutch.signals.speed import Derivative, live
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.offered_programs import standard_programs
from erclutch.wings.live.session import LiveModel
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import RigParameters
from tests.support.sensor_faults import (
    FALLS,
    MOST_ABOVE,
    MOVES,
    OFF_SHARE,
    REST_FRICTION,
    ROWS,
    ZERO_WITHIN,
    field_too_high,
)

FIRST_HEALTHY = 1000  # seed: none of a fault
MOTORS = (0.05, 0.1, 0.3)  # N m

#: What is looked at in each row. Torques in N m, angles in rad.
LOOKS = (
    "torque",
    "its change in a period",
    "periods with one torque",
    "change of the model's torque meanwhile",
    "distance from the model's torque",
    "the same less its usual value",
    "its mean square in 8 periods beside the usual one",
    "how much nearer the turned torque is",
    "how much nearer the doubled torque is",
    "torque and motion apart, as a share of what they may be",
    "change of the speed of the drive",
    "change of the speed of the output",
    "way of the drive while its encoder reads the same",
    "way of the output while its encoder reads the same",
)
_LAST = 8  # readings
_OFFSET, _USUAL = (
    1.0 / 64.0,
    1.0 / 128.0,
)  # shares by which the usual distance and its square move in a period
#: Of the check of torque and motion in c/erc_plausible.c.
_NEAR_REST, _STANDS, _STOOD_STILL, _AT_REST = (
    3.0,
    0.02,
    32,
    0.3,
)  # rad/s, rad/s, periods, share of the band
_MOTOR_SHARE, _MOTOR_LAGS = 0.3, 6.0
_BEGINS = 300  # rows in which the filters settle
#: Readings over which the gain of the meter is estimated, and those before them with which it is compared.
GAIN_WINDOWS = (4, 8, 14, 20)
_GAIN_BEFORE = 64
_SMALLEST = 1e-12  # N m


@dataclass(frozen=True)
class Likeness:
    """The rows of a healthy session that are most like those of a fault, or more unusual.

    Attributes:
        session: its name.
        row: the first one.
        margin: the least ratio of its looks to those of the fault. From 1 on all of them are as unusual at once.
        least: the look of that ratio.
        alone: the same over all sessions, of each look by itself.
    """

    session: str
    row: int
    margin: float
    least: str
    alone: float


def rows_in_time(healthy: Any, faulty: Any, begin: int, *, too_high: bool) -> int:
    """Rows from the fault on in which an alarm is in time.

    Args:
        healthy, faulty: frames of both loops.
        begin: row of the fault.
        too_high: the field is never zero in time anyway: in time for a field that is too high.
    """
    if not too_high:
        return ZERO_WITHIN - FALLS
    high = field_too_high(healthy, faulty)[begin:]
    runs = np.convolve(high, np.ones(MOST_ABOVE + 1), "valid")
    return int(np.flatnonzero(runs > MOST_ABOVE)[0])


def same_bits(healthy: Any, faulty: Any, begin: int, rows: int) -> bool:
    """Whether each sample and each command has the bits of health."""
    kept = slice(begin, begin + rows)
    names = ("torque", "theta", "alpha", "field1", "field2", "motor_torque")
    return all(
        np.array_equal(healthy[name][kept], faulty[name][kept], equal_nan=True) for name in names
    )


def looks_of(frames: Any, settings: LoopSettings) -> NDArray[np.float64]:
    """`LOOKS` of each row, shape (rows, len(LOOKS))."""
    torque, model = np.nan_to_num(frames["torque"]), _late(frames["estimate"], settings)
    off, far, turned, doubled = _distances(torque, model)
    still = _periods_with_one(torque)
    theta, alpha = frames["theta"], frames["alpha"]
    columns = (
        np.abs(torque),
        np.abs(np.diff(torque, prepend=torque[0])),
        still,
        _range_over(model, still),
        np.abs(torque - model),
        np.abs(off),
        far,
        np.minimum(far, turned),
        np.minimum(far, doubled),
        _apart(frames, settings),
        np.abs(np.diff(theta, n=2, prepend=[theta[0]] * 2)) / settings.period,
        np.abs(np.diff(alpha, n=2, prepend=[alpha[0]] * 2)) / settings.period,
        _way(frames["theta_dot"], theta),
        _way(frames["alpha_dot"], alpha),
    )
    return np.column_stack(columns)


def gain_changes(frames: Any, settings: LoopSettings) -> NDArray[np.float64]:
    """How much more of the model's torque the meter reads than before, over each of `GAIN_WINDOWS`.

    By least squares the readings y of a window are a gain times the model's torque x and the offset that the readings
    before had. The gain's distance from 1 has the standard deviation s / sqrt(sum x^2), where s is that of the readings
    before. In white noise of that size no other look at a window tells another gain more often.

    Returns:
        That distance in these standard deviations, shape (rows, len(GAIN_WINDOWS)); 0 until the filters have settled.
    """
    torque, model = (
        np.nan_to_num(frames["torque"]),
        np.nan_to_num(_late(frames["estimate"], settings)),
    )
    apart = torque - model
    before = sliding_window_view(apart, _GAIN_BEFORE)
    offset, deviation = before.mean(axis=1), before.std(axis=1) + _SMALLEST
    changes = np.zeros((len(torque), len(GAIN_WINDOWS)))
    for place, rows in enumerate(GAIN_WINDOWS):
        first = np.arange(_BEGINS, len(torque) - rows + 1)  # of each window
        given = sliding_window_view(model, rows)[first]
        off = sliding_window_view(apart, rows)[first] - offset[first - _GAIN_BEFORE, np.newaxis]
        size = np.sqrt(np.sum(given**2, axis=1)) + _SMALLEST
        share = np.sum(off * given, axis=1) / size
        changes[first + rows - 1, place] = share / deviation[first - _GAIN_BEFORE]
    return changes


class HealthySessions:
    """Looks of healthy sessions of a loop under its own program and each offered one; each is run when asked for.

    Args:
        settings: of the loop.
        model: compiled.
        rig: parameters of the TWIN.
        count: sessions of each program and torque of the motor.
        looks: what is looked at in the frames of a session.
    """

    def __init__(
        self,
        settings: LoopSettings,
        model: LiveModel,
        rig: RigParameters,
        count: int,
        looks: Callable[[Any, LoopSettings], NDArray[np.float64]] = looks_of,
    ) -> None:
        offered = standard_programs(rig, model=True, device=settings.device, effort=model.effort)
        self._cases = list(itertools.product((*settings.programs, *offered), MOTORS, range(count)))
        self._settings, self._model, self._rig = settings, model, rig
        self._looks = looks
        self._run: list[tuple[str, NDArray[np.float64]]] = []

    def __iter__(self) -> Iterator[tuple[str, NDArray[np.float64]]]:
        for place in range(len(self._cases)):
            if place == len(self._run):
                self._run.append(self._looks_of(place))
            yield self._run[place]

    def _looks_of(self, place: int) -> tuple[str, NDArray[np.float64]]:
        program, motor, number = self._cases[place]
        changed = (
            replace(program, motor_torque=motor)
            if program.table is None and program.motor_torque
            else program
        )
        loop, single = (
            replace(self._settings, programs=(changed,)),
            self._settings.device == "single",
        )
        seed = FIRST_HEALTHY + number
        run = AcceleratedRun(
            loop, self._model.library, self._rig, seed=seed, single=single, locked=single
        )
        return f"{program.name}, {motor:g} N m, {seed}", self._looks(run.frames(ROWS)[0], loop)


def likeness_of(
    fault: NDArray[np.float64],
    sessions: Iterable[tuple[str, NDArray[np.float64]]],
    enough: float = math.inf,
) -> Likeness:
    """The healthy rows that are at least as unusual as a fault in each look, or that come nearest to that.

    Args:
        fault: looks of the rows in which an alarm is in time.
        sessions: names and looks of healthy sessions of the same loop.
        enough: margin from which on no further session is looked at.
    """
    most = fault.max(axis=0)
    asked = np.flatnonzero(most > 0.0)
    best, alone = Likeness("", 0, 0.0, "", 0.0), np.zeros(len(asked))
    for name, looks in sessions:
        windows = sliding_window_view(looks[_BEGINS:, asked], len(fault), axis=0).max(axis=2)
        ratios = windows / most[asked]
        alone = np.maximum(alone, ratios.max(axis=0))
        margins = ratios.min(axis=1)
        row = int(np.argmax(margins))
        if margins[row] > best.margin:
            least = LOOKS[asked[int(np.argmin(ratios[row]))]]
            best = Likeness(name, row + _BEGINS, float(margins[row]), least, 0.0)
        if best.margin >= enough:
            break
    return replace(best, alone=float(alone.min()))


def _late(estimate: NDArray[np.float64], settings: LoopSettings) -> NDArray[np.float64]:
    """The model's torque as late as the measured one."""
    share = 1.0 - math.exp(-settings.period / settings.torque_lag) if settings.torque_lag else 1.0
    late, expected = np.zeros(len(estimate)), 0.0
    for k, before in enumerate(np.nan_to_num(estimate[:-1]), start=1):
        expected += share * (before - expected)
        late[k] = expected
    return late


def _distances(
    torque: NDArray[np.float64], model: NDArray[np.float64]
) -> tuple[NDArray[np.float64], ...]:
    """Distance less its usual value; by how much the last readings are off, nearer the turned, the doubled torque."""
    off, expected = np.zeros(len(torque)), np.zeros(len(torque))
    usual, offset, square = np.zeros(len(torque)), 0.0, 0.0
    for k, (read, said) in enumerate(zip(torque.tolist(), model.tolist(), strict=True)):
        expected[k] = said + offset
        off[k] = read - expected[k]
        offset += _OFFSET * off[k]
        usual[k] = square
        if k >= _LAST:
            square += max(_USUAL, 1.0 / (k - _LAST + 1)) * (off[k - _LAST] ** 2 - square)
    sums = [_last_sum(each**2) for each in (off, torque + expected, torque - 2.0 * expected)]
    tiny = np.finfo(float).tiny
    return (
        off,
        sums[0] / (_LAST * usual + tiny),
        sums[0] / (sums[1] + tiny),
        sums[0] / (sums[2] + tiny),
    )


def _last_sum(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.convolve(values, np.ones(_LAST))[: len(values)]


def _periods_with_one(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    """For how many periods a reading has been the same to the bit."""
    rows = np.arange(len(readings))
    changed = np.where(np.diff(readings, prepend=np.nan) != 0.0, rows, 0)
    return (rows - np.maximum.accumulate(changed)).astype(float)


def _range_over(values: NDArray[np.float64], periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """By how much values have moved in the periods before each row."""
    spans = zip(range(len(values)), periods.astype(int), strict=True)
    return np.array([np.ptp(values[row - back : row + 1]) for row, back in spans])


def _way(speed: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a side would have moved while its encoder reads the same, by its speed before."""
    periods = _periods_with_one(angle)
    rows = np.arange(len(speed)) - periods.astype(int)
    return np.abs(speed[rows]) * periods


def _apart(frames: Any, settings: LoopSettings) -> NDArray[np.float64]:
    """How far measured torque and motion are apart, as a share of what they may be: as ``c/erc_plausible.c`` has it."""
    chosen, friction, drag = settings.derivative, settings.load_friction, settings.load_drag
    filtered = live(chosen, settings.period) if isinstance(chosen, Derivative) else chosen
    single, g, h = settings.device == "single", filtered.g, filtered.h
    speeds = frames["theta_dot" if single else "alpha_dot"].tolist()
    driven = [0.0, *frames["motor_torque"][:-1].tolist()]
    measured = np.nan_to_num(frames["torque"]).tolist()
    result = np.zeros(len(speeds))
    now = before = passed = rests = size = motor = last = 0.0
    speed, stands = speeds[0], 0
    for k, rate in enumerate(speeds):
        torque = driven[k] - measured[k] if single else measured[k]
        late = (2.0 - g - h) * now - (1.0 - g) * before + 0.5 * h * (torque + last)
        before, now, last = now, late, torque
        way = math.tanh(rate / _NEAR_REST)
        faster = MOVES * (rate - speed)
        speed += faster
        taken = settings.load_inertia * faster / settings.period
        unsure = abs(taken) + drag * abs(rate)
        if single:
            unsure = (
                abs(taken) + _MOTOR_SHARE * abs(driven[k]) + _MOTOR_LAGS * abs(driven[k] - motor)
            )
        passed += MOVES * (late - friction * way - drag * rate - passed)
        size += MOVES * (unsure - size)
        rests += MOVES * (1.0 - abs(way) - rests)
        motor += MOVES * (driven[k] - motor)
        stands = stands + 1 if abs(rate) <= _STANDS else 0
        band = settings.load_band * (1.0 if stands < _STOOD_STILL else _AT_REST)
        result[k] = abs(passed - taken) / (
            band + REST_FRICTION * friction * rests + OFF_SHARE * size
        )
    return result
