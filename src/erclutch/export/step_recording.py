"""The arithmetic of a step is recorded here, from its inputs to its effort and flags; `step_record` asks for it.

input -> last good row -> [angles to speeds] -> fields and slips, held near the training range
      -> command of each element -> [stages] -> law or network -> limits
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.record import Node, Record
from erclutch.errors import ExportError
from erclutch.export.exported_step import (
    ADAPTED,
    BOTH_FIELDS,
    DRIFT,
    LARGEST_ANGLE,
    LIMITED,
    NON_FINITE,
    OUTSIDE,
    WIDE_BAND,
    ExportedStep,
    Window,
)
from erclutch.export.giving_way import given_way, named_groups
from erclutch.export.stage_memory import StageMemory, kept, suffix_of
from erclutch.models.alarms import Alarms
from erclutch.models.band import FOLLOWER
from erclutch.models.covered_cells import within
from erclutch.models.gain_tracking import BASE, Tracked
from erclutch.models.model import FluidSignals, present, settled_memory
from erclutch.models.stages.stage import Place, Stage
from erclutch.signals.device import slips_of

#: Number of the state that switches the network of a law off: the effort is the law's alone.
SWITCHED_OFF = "residual_off"


@dataclass(frozen=True)
class StepRecord:
    """One step, or the effort at rest.

    Attributes:
        record: its arithmetic; ``network`` nodes stand for the forward pass.
        inputs: the record's names of the step's inputs.
        effort: the result.
        flags: by bit, whether it is raised.
        value: the effort ahead of its limits.
        fields, slips, extras: signals within their windows, of each element.
        started: whether a good row has come, this one included.
    """

    record: Record
    inputs: tuple[str, ...]
    effort: Node
    flags: Mapping[int, Node]
    value: Node
    fields: tuple[Node, ...]
    slips: tuple[Node, ...]
    extras: tuple[Node, ...]
    started: Node

    @property
    def size(self) -> int:
        """Numbers of the state."""
        return len(self.record.after) + sum(self.record.registers().values())


def parted(step: ExportedStep, signed: Any) -> list[Any]:
    """The fields of the elements for a signed field."""
    if step.elements == 1:
        return [signed]
    return [less_select(0.0, signed, signed, 0.0), less_select(signed, 0.0, -signed, 0.0)]


def _held(value: Any, low: Any, high: Any) -> Any:
    below = less_select(value, high, value, high)
    return less_select(low, below, below, low)


def _beyond(x: Any, low: Any, high: Any) -> Any:
    """Whether a recorded number lies outside two limits; a NaN does not."""
    return x.owner.either(x.owner.less(x, low), x.owner.less(high, x))


def _limited(value: Any, before: Any, low: Any, high: Any) -> Any:
    record = value.owner
    finite = record.label(record.finite(value), "is_finite")
    held = record.call("held", _held, value=value, low=low, high=high)
    return record.choose(finite, record.choose(_beyond(value, low, high), held, value), before)


@dataclass
class StepRecording:
    """A step while it is recorded.

    Attributes:
        step: whose arithmetic it is.
        remember: the last good row stands in for a bad one.
        rest: the effort at rest, without a state.
        ahead: the effort of the next step; the state is read and not written.
        record: what is recorded into.
    """

    step: ExportedStep
    remember: bool
    rest: bool = False
    ahead: bool = False
    record: Record = field(default_factory=Record)

    def whole(self) -> StepRecord:
        """From the inputs to effort and flags."""
        step, record, e = self.step, self.record, self.step.elements
        names = tuple(f"u{i}" for i in range(len(step.inputs)))
        given = [record.input(name) for name in names]
        rows = self.receive(given[: step.model_inputs])
        slips = slips_of(step.device, rows[e : 2 * e])
        outside, both, held = self.signals(rows[:e], slips, rows[2 * e :])
        fields, slips, extras = held[:e], held[e : 2 * e], held[2 * e :]
        value = self.behind(fields, slips, extras)
        effort, limited = self.limited(value)
        effort, adapted = self.tracked(effort, given[-1])
        flags = {OUTSIDE: outside, BOTH_FIELDS: both, LIMITED: limited, ADAPTED: adapted}
        flags |= self.alarms(effort, held, given[-1], record.both(self.good, record.opposite(outside)))
        raised = {bit: record.both(self.started, truth) for bit, truth in flags.items() if truth is not False}
        raised[NON_FINITE] = record.opposite(self.good)
        self._refuse_names()
        nodes = [[record.node_of(x) for x in group] for group in (fields, slips, extras)]
        record.outputs = [record.node_of(x) for x in (effort, *raised.values())]
        return StepRecord(
            record=record,
            inputs=names,
            effort=record.outputs[0],
            flags=dict(zip(raised, record.outputs[1:], strict=True)),
            value=record.node_of(value),
            fields=tuple(nodes[0]),
            slips=tuple(nodes[1]),
            extras=tuple(nodes[2]),
            started=record.node_of(self.started),
        )

    def _refuse_names(self) -> None:
        for name in (*self.record.after, *(n.value[0] for n in self.record.nodes if n.operation == "delay")):
            if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
                raise ExportError(
                    f"a stage calls a number of its state {name!r}, which is no name in C",
                    where=self.step.model.name,
                    remedy="Name it in the stage with letters, digits and underscores, a letter first",
                )

    def next_effort(self) -> Record:
        """From a signed field and the other inputs, all finite, to the effort; the state is read."""
        step, record, e = self.step, self.record, self.step.elements
        self.good = self.started = True
        self.going = record.state("started", kind="truth")
        fields = parted(step, record.input("field"))
        given = [record.input(f"u{i}") for i in range(e, step.model_inputs)]
        rows = [self._speed(x, i) if step.filter and i < e else x for i, x in enumerate(given)]
        _, _, held = self.signals(fields, slips_of(step.device, rows[:e]), rows[e:])
        record.give(self.behind(held[:e], held[e : 2 * e], held[2 * e :]))
        record.after.clear()
        return record

    # --- input -------------------------------------------------------------------------------------------------------

    def receive(self, given: Sequence[Any]) -> list[Any]:
        """The last good row, and what is known of it."""
        record, e = self.record, self.step.elements
        angles = range(e, 2 * e) if self.step.filter and not self.rest else range(0)
        good: Any = True
        for i, x in enumerate(given):
            within = record.finite(x)
            if i in angles:
                within = record.both(within, record.both(record.less(-LARGEST_ANGLE, x), record.less(x, LARGEST_ANGLE)))
            good = record.both(good, within)
        self.good = self.started = record.label(good, "row_good")
        self.going: Any = False
        if not self.remember:
            return [record.label(record.choose(good, x, 0.0), f"row{i}") for i, x in enumerate(given)]
        self.going = record.state("started", kind="truth")
        self.started = record.label(record.either(good, self.going), "row_known")
        record.keep("started", self.started)
        return [self._speed(x, i - e) if i in angles else self._last(x, i) for i, x in enumerate(given)]

    def _last(self, x: Any, i: int) -> Any:
        kept = self.record.choose(self.good, x, self.record.state(f"last{i}"))
        self.record.keep(f"last{i}", kept)
        return self.record.label(kept, f"row{i}")

    def _speed(self, measured: Any, i: int) -> Any:
        """The derivative filter of one angle: a prediction, corrected by the innovation."""
        f, period, record = self.step.filter, self.step.period, self.record
        assert f is not None
        assert period is not None
        position, speed = record.state(f"position{i}"), record.state(f"speed{i}")
        predicted = position + period * speed
        innovation = record.choose(self.good, self._turned(measured - predicted), 0.0)
        first = record.choose(self.good, self._turned(measured), position)
        corrected = self._turned(predicted + f.g * innovation)
        record.keep(f"position{i}", kept(record.choose(self.going, corrected, first)))
        now = kept(record.choose(self.going, speed + f.h * innovation / period, speed))
        record.keep(f"speed{i}", now)
        return record.label(now, f"speed{i}")

    def _turned(self, x: Any) -> Any:
        """An angle less whole turns, within half a turn of zero."""
        turn = self.step.filter.turn if self.step.filter else None
        if turn is None:
            return x

        def turned(x: Any) -> Any:
            turns = x * (1.0 / turn)
            return x - turns.record("nearest", turns) * turn

        return self.record.call("turned", turned, x=x)

    def signals(self, fields: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any]) -> tuple[Any, Any, list[Any]]:
        """Whether one is outside what was trained on, whether both fields are on, and all within their windows."""
        step, record = self.step, self.record
        windows = [*(step.field for _ in fields), *(step.slip for _ in slips), *step.extras]
        kinds = (("field", fields), ("slip", slips), ("further", extras))
        names = [f"{kind}{i + 1}" for kind, signals in kinds for i in range(len(signals))]
        outside: Any = False
        held: list[Any] = []
        for name, x, window in zip(names, [*fields, *slips, *extras], windows, strict=True):
            out, within = self._within(x, window)
            outside = record.either(outside, record.label(out, f"{name}_outside"))
            held.append(record.label(within, f"{name}_held"))
        trained_on = step.model.trained_on
        for i in range(len(fields) if trained_on.near else 0):
            far = trained_on.far(i, held[i], held[step.elements + i])
            outside = record.either(outside, record.label(far, f"far{i + 1}"))
        both = False
        if len(fields) == 2:
            both = record.both(record.less(step.both, fields[0]), record.less(step.both, fields[1]))
        return outside, both, held

    def _within(self, x: Any, window: Window) -> tuple[Any, Any]:
        record = self.record
        out = _beyond(x, *window.warn)
        held = record.call("held", _held, value=x, low=window.hold[0], high=window.hold[1])
        return out, record.choose(out, held, x)

    # --- effort ------------------------------------------------------------------------------------------------------

    def behind(self, fields: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any]) -> Any:
        """The effort from signals within their windows."""
        step = self.step
        commands = [self.record.call("command", step.model.command, field=x) for x in fields]
        fluids = [
            self.record.label(self._through("command", x, str(i)), f"fluid{i + 1}") for i, x in enumerate(commands)
        ]
        remembered = self._remembered(fluids, slips)
        effort = self._ahead(fluids, slips, remembered, extras)
        if step.model.gives_way is not None:
            again = None if step.model.past or any(remembered) else self._at_rest
            effort = given_way(step.model.gives_way, effort, (fluids, slips, extras), again)
        effort = self._through("effort", effort)
        correction = step.model.correction
        if correction is None:
            return effort
        past = self._past() if step.model.past and not self.rest else present
        further = dict(zip(step.model.extras, extras, strict=True))
        inputs = correction.inputs(FluidSignals(fluids, slips, remembered, further, past))
        named = {f"x{i + 1}": x for i, x in enumerate(inputs)}
        return self._corrected(effort, self.record.call("residual", correction.of, **named))

    def _corrected(self, effort: Any, residual: Any) -> Any:
        """The effort with what a network adds, unless that is switched off by the state."""
        if not self.remember:
            return effort + residual
        off = self.record.state(SWITCHED_OFF, kind="truth")
        self.record.keep(SWITCHED_OFF, off)
        return self.record.choose(off, effort, effort + residual)

    def _ahead(self, fluids: Sequence[Any], slips: Sequence[Any], remembered: Any, extras: Sequence[Any]) -> Any:
        """The effort ahead of the stages on it."""
        model = self.step.model
        if (model.past or any(remembered)) and not self.rest:  # in one piece, so that strength of the field is shared
            further = dict(zip(model.extras, extras, strict=True))
            return model.from_fluid(FluidSignals(fluids, slips, remembered, further, self._past()))
        return self._at_rest(self.record, fluids, slips, extras, remembered)

    def _at_rest(
        self, record: Record, fluids: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any], remembered: Any = ()
    ) -> Any:
        """The effort ahead of the stages on it as a function of its own: past rows are as the present one."""
        model, e = self.step.model, self.step.elements
        states = [x for element in remembered for outputs in element for x in outputs]

        def rest(*signals: Any) -> Any:
            own = iter(signals[2 * e : 2 * e + len(states)])
            memory = [[[next(own) for _ in outputs] for outputs in element] for element in remembered]
            further = dict(zip(model.extras, signals[2 * e + len(states) :], strict=True))
            return model.from_fluid(FluidSignals(signals[:e], signals[e : 2 * e], memory, further))

        return record.call("rest", rest, **named_groups("xwmv", (fluids, slips, states, extras)))

    def _remembered(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[list[Sequence[Any]]]:
        """Outputs of the stages on the slip, for each element."""
        model = self.step.model
        moved = model.moved(fluids, slips)
        if self.rest:
            return settled_memory(model, moved)
        return [
            [self._stepped(stage, q, m, str(i)) for stage, q in self.step.stages if stage.place == "slip"]
            for i, m in enumerate(moved)
        ]

    def _stepped(self, stage: Stage, q: Mapping[str, float], signal: Any, element: str) -> tuple[Any, ...]:
        memory = StageMemory(
            self.record, self.going, suffix_of(stage, element), stage.initial(signal, q), self._earlier
        )
        return stage.step(memory, signal, q, self.step.period or 1.0)

    def _through(self, place: Place, signal: Any, element: str = "") -> Any:
        """A signal behind the stages of a place."""
        for stage, q in () if self.rest else self.step.stages:
            if stage.place == place:
                (signal,) = self._stepped(stage, q, signal, element)
        return signal

    def _past(self) -> Any:
        names: dict[int, str] = {}

        def past(signal: Any, rows: int) -> Any:
            name = names.setdefault(self.record.node_of(signal).index, f"past{len(names)}")
            return self._earlier(name, signal, rows)

        return past

    def _earlier(self, name: str, signal: Any, rows: int) -> Any:
        """A signal some rows back; in the first row the signal itself."""
        if self.ahead:
            return self.record.choose(self.going, self.record.operand("earlier", value=(name, rows)), signal)
        return self.record.operand("delay", signal, self.going, value=(name, rows))

    def tracked(self, effort: Any, measured: Any) -> tuple[Any, Any]:
        """The effort to be given out, and whether it is the adapted one; the state follows the measured effort."""
        tracking, record = self.step.tracking, self.record
        if tracking is None or self.rest:
            return effort, False
        names = [f"track_{name}" for name in BASE._fields]
        before = Tracked(
            *(record.choose(self.going, record.state(name), x) for name, x in zip(names, BASE, strict=True))
        )
        moved, cost = tracking.moved(before, effort)
        adapted = record.label(record.both(self.started, record.less(cost, before.account)), "adapted")
        given = record.label(record.choose(adapted, moved, effort), "given")
        counts = record.label(record.both(self.started, record.finite(measured)), "counts")
        after = tracking.after(before, effort, given, record.choose(counts, measured, effort))
        for name, new, old in zip(names, after, before, strict=True):
            record.keep(name, record.label(record.choose(counts, new, old), name))
        return given, adapted

    def alarms(self, effort: Any, held: Sequence[Any], measured: Any, good: Any) -> dict[int, Any]:
        """Whether the band is wide and whether the residual has drifted; the state keeps the ends of the band."""
        alarms, record, e = self.step.alarms, self.record, self.step.elements
        if alarms is None or self.rest:
            return {}
        band = alarms.band
        field, slip, place = band.leading(held[:e], held[e : 2 * e])
        (followed,) = self._stepped(FOLLOWER, {"tau_e": band.settling_s}, field, "_band")
        low, high = band.ends(effort, slip, band.switching(field, followed), place)
        for name, end in (("low", low), ("high", high)):
            record.keep(name, record.label(end, name))
        side = less_select(slip, 0.0, -1.0, 1.0)
        drifted = self.drifted(alarms, effort, (low, high), side, measured, good)
        return {WIDE_BAND: record.less(alarms.wide, high - low), DRIFT: drifted}

    def drifted(self, alarms: Alarms, effort: Any, ends: tuple[Any, Any], side: Any, measured: Any, good: Any) -> Any:
        """Whether measured efforts have been outside the band, or to one side of the estimate, for too long.

        Args:
            alarms: numbers of the tests.
            effort: the estimate.
            ends: of its band.
            side: the sign of the slip.
            measured: effort.
            good: whether the row may count.
        """
        record, (low, high), block = self.record, ends, float(alarms.block)
        counts = record.both(record.both(good, record.finite(measured)), record.less(low, high))
        miss = record.both(counts, record.either(record.less(measured, low), record.less(high, measured)))
        off = within((measured - effort) * side / (0.5 * (high - low)), -1.0, 1.0)
        gathered: dict[str, Any] = {}
        for name, more in (("rows", record.choose(counts, 1.0, 0.0)), ("misses", record.choose(miss, 1.0, 0.0))):
            gathered[name] = record.state(f"drift_{name}") + more
        gathered["lean"] = record.state("drift_lean") + record.choose(counts, off, 0.0)
        open_ = record.label(record.less(gathered["rows"], block), "block_open")
        for name, total in gathered.items():
            record.keep(f"drift_{name}", record.choose(open_, total, 0.0))
        missed, mean = gathered["misses"] * (1.0 / block), gathered["lean"] * (1.0 / block)
        above, below = (less_select(alarms.lean, x, 1.0, 0.0) for x in (mean, -mean))
        tests = (
            ("missing", missed, alarms.missing),
            ("above", above, alarms.leaning),
            ("below", below, alarms.leaning),
        )
        raised: Any = False
        for name, share, tolerated in tests:
            before = record.state(f"drift_{name}")
            now = record.choose(open_, before, alarms.wealth(before, share, tolerated))
            record.keep(f"drift_{name}", record.label(now, f"drift_{name}"))
            raised = record.either(raised, record.opposite(record.less(now, alarms.goal)))
        return raised

    def limited(self, value: Any) -> tuple[Any, Any]:
        """The effort within its limits, that of the row before where it is not finite; and whether that was needed."""
        record, (low, high) = self.record, self.step.limits
        record.label(value, "unlimited")
        before = record.state("effort") if self.remember else 0.0
        limited = record.call("limited", _limited, value=value, before=before, low=low, high=high)
        effort = record.label(record.choose(self.started, limited, 0.0), "now")
        beyond = record.label(_beyond(value, low, high), "beyond")
        finite = record.label(record.finite(value), "is_finite")
        if self.remember:
            record.keep("effort", effort)
        return effort, record.either(record.opposite(finite), beyond)
