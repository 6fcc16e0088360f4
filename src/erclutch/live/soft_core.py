"""The control step in Python, for machines without a C compiler: the same step as ``c/erc_core.c``, file by file.

A test runs both on the same sensors, faults included, and compares every frame. What is not the same is time: this is
soft real time, and says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.live.frame import EVENT_BITS, FRAME, State
from erclutch.live.orders import Order
from erclutch.live.sample import COMMAND
from erclutch.live.settings import ZERO_BEFORE_TRIP, LoopSettings, Mode, Program, Shape, speed_filter

_LARGEST_GAP = 1000
_WARM_UP = 64
_CLOCK_SLACK = 20_000_000
_OUT_OF_REACH = 16
_WATCHDOG, _FAULT = 1, 2

#: Inputs of the device -> effort, flags; and inputs, wanted effort -> signed field, flags.
StepFunction = Callable[[Sequence[float]], tuple[float, int]]
InverseFunction = Callable[[Sequence[float], float], tuple[float, int]]


@dataclass
class _Encoder:
    """An angle encoder: unwrapping, rejection of impossible jumps, and a position-speed filter."""

    wrap: float
    glitch: float
    dt: float
    g: float
    h: float
    offset: float = 0.0
    measured: float = 0.0
    position: float = 0.0
    speed: float = 0.0
    since: int = 0
    taken: int = 0

    def predict(self, periods: int) -> None:
        self.position += self.dt * self.speed * periods
        self.since += periods

    def _near(self, raw: float) -> tuple[float, float, float]:
        """The prediction, and the reading without whole wraps, with the offset for that."""
        predicted = self.position + self.dt * self.speed
        offset = self.offset
        if self.wrap > 0.0 and self.taken > 0:
            offset += round((predicted - raw - offset) / self.wrap) * self.wrap
        return predicted, raw + offset, offset

    def possible(self, raw: float, periods: int) -> bool:
        predicted, x, _ = self._near(raw)
        return (
            self.taken < _WARM_UP or self.glitch <= 0.0 or abs(x - predicted) <= self.glitch * self.dt * float(periods)
        )

    def take(self, raw: float) -> int:
        predicted, x, offset = self._near(raw)
        events = 0 if offset == self.offset else EVENT_BITS["wrap"]
        self.offset, self.measured = offset, x
        if self.taken == 0:
            self.position, self.speed = x, 0.0
        else:
            innovation = x - predicted
            self.position = predicted + self.g * innovation
            self.speed += self.h * innovation / (self.dt * (self.since + 1))
        self.since = 0
        self.taken = min(self.taken + 1, _WARM_UP)
        return events


class SoftCore:
    """The control step without input or output; see `erclutch.live.core.Core` for the one in C.

    Args:
        settings: limits, gains, programs.
        step, inverse: the model; None estimates nothing.
    """

    def __init__(
        self, settings: LoopSettings, step: StepFunction | None = None, inverse: InverseFunction | None = None
    ) -> None:
        self.settings = settings
        self._model_step, self._model_inverse = step, inverse
        speed = speed_filter(settings)
        self._period_ns = round(settings.period * 1e9)
        self._dt = 1e-9 * self._period_ns
        self._theta = _Encoder(settings.theta_wrap, settings.theta_glitch, self._dt, speed.g, speed.h)
        self._alpha = _Encoder(settings.alpha_wrap, settings.alpha_glitch, self._dt, speed.g, speed.h)
        self.state, self.trip_reason, self.program, self.missing = State.STARTING, 0, 0, 0
        self.sensor_seq = self._sensor_time = 0
        self._resync, self._stopping, self._rig_seen, self._torque_seen = True, False, False, False
        self._lost_by = self._pending = self._tick = self._program_tick = 0
        self._torque = self._estimate = self._reference = self._motor = math.nan
        self._base = self._integral = self._last_wave = self._field = 0.0
        self._mirrored = 1.0
        self._asked = (0.0, 0.0, 0.0)
        self._command, self._frame = np.zeros(1, COMMAND), np.zeros(1, FRAME)

    # --- sensors ------------------------------------------------------------------------------------------------------

    def _gap_before(self, seq: int, time_ns: int) -> tuple[int | None, int]:
        if self._resync:
            self._resync = False
            self._theta.taken = self._alpha.taken = 0
            return 0, 0
        if seq <= self.sensor_seq or seq - self.sensor_seq > _LARGEST_GAP:
            return None, EVENT_BITS["stale-packet"]
        counted = (seq - self.sensor_seq) * self._period_ns
        stamped = (time_ns - self._sensor_time) % (1 << 64)
        events = EVENT_BITS["clock-jump"] if abs(stamped - counted) > _CLOCK_SLACK else 0
        return seq - self.sensor_seq - 1, events

    def _status_events(self, status: int) -> int:
        events = EVENT_BITS["rig-fault"] if status & _FAULT else 0
        if not status & _WATCHDOG:
            self._rig_seen = True
        elif self._rig_seen:
            events |= EVENT_BITS["rig-watchdog"]
        return events

    def _torque_events(self, torque: float) -> int:
        finite = math.isfinite(torque)
        self._torque = torque if finite else math.nan
        self._torque_seen |= finite
        return 0 if finite or (math.isnan(torque) and not self._torque_seen) else EVENT_BITS["sample-invalid"]

    def _take_one(self, sample: Any) -> tuple[int, bool]:
        seq, time_ns = int(sample["seq"]), int(sample["time_ns"])
        gap, events = self._gap_before(seq, time_ns)
        if gap is None:
            return events, False
        self.sensor_seq, self._sensor_time = seq, time_ns
        events |= self._status_events(int(sample["status"])) | self._torque_events(float(sample["torque"]))
        both = ((self._theta, float(sample["theta"])), (self._alpha, float(sample["alpha"])))
        for encoder, _ in both:
            encoder.predict(gap)
        if not all(math.isfinite(raw) for _, raw in both):
            self._lost_by = EVENT_BITS["sample-invalid"]
        elif not all(encoder.possible(raw, gap + 1) for encoder, raw in both):
            self._lost_by = EVENT_BITS["glitch"]
        else:
            for encoder, raw in both:
                events |= encoder.take(raw)
            return events, True
        for encoder, _ in both:
            encoder.predict(1)
        return events | self._lost_by, False

    def _take(self, samples: Any, periods: int) -> int:
        events, any_good = 0, False
        for sample in samples:
            seen, good = self._take_one(sample)
            events |= seen
            any_good |= good
        if any_good:
            self.missing = 0
            return events
        if not events & (EVENT_BITS["sample-invalid"] | EVENT_BITS["glitch"]):
            events |= EVENT_BITS["sample-lost"]
            self._lost_by = EVENT_BITS["sample-lost"]
        self.missing = min(self.missing + periods, 2**32 - 1)
        return events

    # --- control ------------------------------------------------------------------------------------------------------

    def _wanted(self, program: Program, k: int) -> tuple[float, float, float]:
        """Reference, its rate (or the second field of a table) and motor torque."""
        if program.table is not None:
            row = self.sensor_seq - 1 if program.by_sample else k
            last = len(program.table)
            row = (row % last if program.repeat else last - 1) if row >= last else row
            first, second, motor = program.table[row].tolist()
            return first, second, motor
        turns = math.fmod(k * self._dt * program.frequency, 1.0)
        value, rate = program.offset, 0.0
        if program.shape is Shape.SINE:
            value += program.amplitude * math.sin(math.tau * turns)
            rate = program.amplitude * math.tau * program.frequency * math.cos(math.tau * turns)
        elif program.shape is Shape.SQUARE:
            value += program.amplitude if turns < 0.5 else -program.amplitude
        else:
            value += program.amplitude
        return value, rate, program.motor_torque

    def _torque_field(self, wanted: float) -> tuple[float, int]:
        if self._model_inverse is None:
            return 0.0, 0
        s = self.settings
        inputs = self._inputs(0.0, 0.0)
        forward, flags = self._model_inverse(inputs, wanted)
        error = wanted - self._estimate if math.isfinite(self._estimate) else 0.0
        way = -1.0 if self._theta.speed < 0.0 else 1.0
        before = self._integral
        self._integral += way * s.torque_i * error * self._dt
        field = forward + way * s.torque_p * error + self._integral
        if not abs(field) <= s.field_limit:
            self._integral = before
        return field, EVENT_BITS["unreachable"] if flags & _OUT_OF_REACH else 0

    def _turned(self, program: Program, wave: float) -> float:
        if wave * self._last_wave <= 0.0 or abs(wave - self._last_wave) > 0.1:
            drive = -wave if self._theta.speed < 0.0 else wave
            at, soft = self._alpha.measured, program.soft
            outward = (at > soft and drive > 0.0) or (at < -soft and drive < 0.0)
            self._mirrored = -1.0 if soft > 0.0 and outward else 1.0
        self._last_wave = wave
        return self._mirrored

    def _start(self, program: int, tick: int) -> None:
        self.program, self._program_tick = program, tick
        self._integral, self._mirrored, self._last_wave, self._motor = 0.0, 1.0, 0.0, math.nan
        self._base = self._alpha.measured if self.settings.programs[program].relative else 0.0

    def _split(self, field: float) -> tuple[float, float]:
        if math.isnan(field):
            return field, 0.0
        single = self.settings.device == "single"
        return max(field, 0.0), 0.0 if field >= 0.0 or single else -field

    def _control(self, tick: int) -> tuple[tuple[float, float, float], int]:
        s = self.settings
        program = s.programs[self.program]
        value, rate, motor = self._wanted(program, tick - self._program_tick)
        motor = motor if math.isnan(self._motor) else self._motor
        self._reference, events, fields = math.nan, 0, (0.0, 0.0)
        if program.mode is Mode.TRACK:
            value += self._base
            self._reference = value
            field = s.k_p * (value - self._alpha.measured) + s.k_d * (rate - self._alpha.speed)
            fields = self._split(_clip(field, s.field_limit))
        elif program.mode is Mode.TORQUE:
            self._reference = value
            field, events = self._torque_field(value)
            fields = self._split(_clip(field, s.field_limit))
        elif program.mode is Mode.FIELDS and program.table is not None:
            turned = self._turned(program, value - rate) < 0.0
            fields = (rate, value) if turned else (value, rate)
        elif program.mode is Mode.FIELDS:
            fields = self._split(self._turned(program, value) * value)
        return (*fields, motor), events

    # --- interlock ----------------------------------------------------------------------------------------------------

    def _interlock(self, ask: tuple[float, float, float]) -> tuple[tuple[float, float, float], int]:
        s, events = self.settings, 0

        def safe(value: float, low: float, high: float) -> float:
            nonlocal events
            if not math.isfinite(value):
                events |= EVENT_BITS["command-not-finite"]
                return 0.0
            if value < low or value > high:
                events |= EVENT_BITS["beyond-limit"]
                return low if value < low else high
            return value

        first, second = safe(ask[0], 0.0, s.field_limit), safe(ask[1], 0.0, s.field_limit)
        if first > 0.0 and second > 0.0:
            events |= EVENT_BITS["both-fields"]
            first, second = (first, 0.0) if first >= second else (0.0, second)
        wanted = first - second
        drive = -wanted if self._theta.speed < 0.0 else wanted
        alpha = self._alpha.measured
        if s.stroke > 0.0 and ((alpha > s.stroke and drive > 0.0) or (alpha < -s.stroke and drive < 0.0)):
            events |= EVENT_BITS["guard"]
            wanted = 0.0
        field = _reachable(self._field, wanted, s.rise_rate * self._dt, s.fall_rate * self._dt)
        if abs(field - wanted) > 1e-12:
            events |= EVENT_BITS["rate-limited"]
        return (max(field, 0.0), max(-field, 0.0), safe(ask[2], -s.motor_limit, s.motor_limit)), events

    # --- step ---------------------------------------------------------------------------------------------------------

    def order(self, order: Order | int, value: float = 0.0) -> bool:
        """Give an order; whether the loop is to end."""
        done = False
        if order == Order.STOP:
            self._pending |= EVENT_BITS["order"]
            return True
        if order == Order.ZERO:
            self._trip(EVENT_BITS["order"])
            done = True
        elif order == Order.RESET and self.state is State.TRIPPED and self.missing == 0:
            self.state, self.trip_reason, self._rig_seen, done = State.RUNNING, 0, False, True
            self._start(self.program, self._tick)
        elif order == Order.PROGRAM and 0.0 <= value < len(self.settings.programs):
            self._start(int(value), self._tick)
            done = True
        elif order == Order.MOTOR and abs(value) <= self.settings.motor_limit:
            self._motor, done = value, True
        self._pending |= EVENT_BITS["order" if done else "order-refused"]
        return False

    def refuse(self) -> None:
        """Count an order that could not be read."""
        self._pending |= EVENT_BITS["order-refused"]

    def stop(self) -> None:
        """Zero from now on."""
        self._stopping = True

    def _trip(self, event: int) -> None:
        if self.state is State.TRIPPED:
            return
        self.state, self.trip_reason = State.TRIPPED, event.bit_length()
        if self.missing >= self.settings.trip:
            self._resync = True

    def _trip_checks(self, late_ns: int, events: int) -> int:
        if self.state is State.STARTING and self.missing == 0:
            self.state = State.RUNNING
            self._start(self.program, self._tick)
        if self.state is not State.RUNNING:
            return 0
        reasons = (
            (self.missing >= self.settings.trip, self._lost_by),
            (late_ns > round(self.settings.late_trip * 1e9), EVENT_BITS["overrun"]),
            (bool(events & EVENT_BITS["rig-watchdog"]), EVENT_BITS["rig-watchdog"]),
            (bool(events & EVENT_BITS["rig-fault"]), EVENT_BITS["rig-fault"]),
        )
        reason = next((event for there, event in reasons if there), 0)
        if reason:
            self._trip(reason)
            return EVENT_BITS["trip"]
        return 0

    def _wish(self, tick: int) -> tuple[tuple[float, float, float], int]:
        if self.missing == 0:
            self._asked, events = self._control(tick)
            return self._asked, events
        hold, none = self.settings.hold, self.settings.trip - ZERO_BEFORE_TRIP
        share = 1.0 if self.missing <= hold else max(0.0, (none - self.missing) / (none - hold))
        first, second, motor = self._asked
        return (share * first, share * second, motor), EVENT_BITS["degrade" if share < 1.0 else "hold"]

    def _inputs(self, first: float, second: float) -> tuple[float, ...]:
        if self.settings.device == "single":
            return first, self._theta.speed - self._alpha.speed
        return first, second, self._theta.speed, self._alpha.speed

    def step(self, samples: Any, tick: int, *, late_ns: int = 0, events: int = 0) -> tuple[Any, Any]:
        """One step; as `erclutch.live.core.Core.step`."""
        periods, self._tick = max(tick - self._tick, 1), tick
        events |= self._pending
        self._pending = 0
        events |= self._take(samples, periods)
        if late_ns >= self._period_ns:
            events |= EVENT_BITS["overrun"]
        events |= self._trip_checks(late_ns, events)
        if self._stopping:
            events |= EVENT_BITS["stopping"]
        out, flags = (0.0, 0.0, 0.0), 0
        if self.state is State.RUNNING and not self._stopping:
            ask, seen = self._wish(tick)
            out, held = self._interlock(ask)
            events |= seen | held
        else:
            self._reference = math.nan
        self._field = out[0] - out[1]
        if self._model_step is not None and self.state is not State.STARTING:
            self._estimate, flags = self._model_step(self._inputs(out[0], out[1]))
        command, frame = self._command, self._frame
        command["field1"], command["field2"], command["motor_torque"] = out
        command["flags"] = self._stopping
        torque = self._torque if self.missing == 0 else math.nan
        theta, alpha = self._theta, self._alpha
        frame[0] = (
            *(0, 0, theta.measured, alpha.measured, theta.speed, alpha.speed),
            *(*out, torque, self._estimate, self._reference, flags, events, 0, 0),
        )
        return command[0], frame[0]


def _clip(value: float, limit: float) -> float:
    return limit if value > limit else (-limit if value < -limit else value)


def _reachable(previous: float, wanted: float, rise: float, fall: float) -> float:
    """The signed field that the supply can reach in one period."""
    way = -1.0 if previous < 0.0 else 1.0
    start, end = way * previous, way * wanted
    least = start - fall
    if least > 0.0 and end < least:
        return way * least
    return way * (max(end, -rise) if end < 0.0 else min(end, start + rise))
