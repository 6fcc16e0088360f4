"""The arithmetic of a step is recorded here, from its inputs to its effort and flags; `step_record` asks for it.

input -> last good row -> [angles to speeds] -> fields and slips, held near the training range
      -> command of each element -> [stages] -> law or network -> limits
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.record import Node, Record
from erclutch.errors import ExportError
from erclutch.export import recorded_limits
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
from erclutch.models.covered_cells import within
from erclutch.models.gain_tracking import BASE, Tracked
from erclutch.models.haste import FOLLOWER
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
        step, record = self.step, self.record
        names = tuple(f"u{i}" for i in range(len(step.inputs)))
        given = [record.input(name) for name in names]
        measured = given[-1]  # the effort, where the step measures
        fields, speeds, extras = self._by_kind(self.receive(given[: step.model_inputs]))
        slips = slips_of(step.device, speeds)
        outside, both, held = self.signals(fields, slips, extras)
        unlike = self.unlike(fields, slips)
        fields, slips, extras = self._by_kind(held)
        value = self.behind(fields, slips, extras)
        effort, limited = self.limited(value)
        effort, adapted = self.tracked(effort, measured)
        flags = {OUTSIDE: outside, BOTH_FIELDS: both, LIMITED: limited, ADAPTED: adapted}
        may_count = record.both(self.good, record.opposite(outside))
        flags |= self.alarms(effort, held, measured, may_count, unlike)
        raised = {bit: record.both(self.started, truth) for bit, truth in flags.items() if truth is not False}
        raised[NON_FINITE] = record.opposite(self.good)

        self._refuse_names()
        nodes = [tuple(record.node_of(x) for x in signals) for signals in (fields, slips, extras)]
        record.outputs = [record.node_of(x) for x in (effort, *raised.values())]
        return StepRecord(
            record=record,
            inputs=names,
            effort=record.outputs[0],
            flags=dict(zip(raised, record.outputs[1:], strict=True)),
            value=record.node_of(value),
            fields=nodes[0],
            slips=nodes[1],
            extras=nodes[2],
            started=record.node_of(self.started),
        )

    def _by_kind(self, signals: Sequence[Any]) -> tuple[Sequence[Any], Sequence[Any], Sequence[Any]]:
        """Signals in the order of the inputs: those of the fields, of the motion, and the further ones."""
        elements = self.step.elements
        return signals[:elements], signals[elements : 2 * elements], signals[2 * elements :]

    def _refuse_names(self) -> None:
        """Refuse a stage whose state has a name that C does not take."""
        registers = (node.value[0] for node in self.record.nodes if node.operation == "delay")
        for name in (*self.record.after, *registers):
            if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
                raise ExportError(
                    f"a stage calls a number of its state {name!r}, which is no name in C",
                    where=self.step.model.name,
                    remedy="Name it in the stage with letters, digits and underscores, a letter first",
                )

    def next_effort(self) -> Record:
        """From a signed field and the other inputs, all finite, to the effort; the state is read."""
        step, record, elements = self.step, self.record, self.step.elements
        self.good = self.started = True
        self.going = record.state("started", kind="truth")
        fields = parted(step, record.input("field"))
        given = [record.input(f"u{i}") for i in range(elements, step.model_inputs)]
        motion, extras = given[:elements], given[elements:]
        speeds = [self._speed(angle, i) for i, angle in enumerate(motion)] if step.filter else motion
        _, _, held = self.signals(fields, slips_of(step.device, speeds), extras)
        record.give(self.behind(*self._by_kind(held)))
        record.after.clear()
        return record

    # --- input -------------------------------------------------------------------------------------------------------

    def receive(self, given: Sequence[Any]) -> list[Any]:
        """The last good row, and what is known of it."""
        record, elements = self.record, self.step.elements
        angles = range(elements, 2 * elements) if self.step.filter and not self.rest else range(0)
        good: Any = True
        for i, x in enumerate(given):
            usable = record.finite(x)
            if i in angles:
                near = record.both(record.less(-LARGEST_ANGLE, x), record.less(x, LARGEST_ANGLE))
                usable = record.both(usable, near)
            good = record.both(good, usable)
        self.good = self.started = record.label(good, "row_good")
        self.going: Any = False
        if not self.remember:
            return [record.label(record.choose(good, x, 0.0), f"row{i}") for i, x in enumerate(given)]
        self.going = record.state("started", kind="truth")
        self.started = record.label(record.either(good, self.going), "row_known")
        record.keep("started", self.started)
        return [self._speed(x, i - elements) if i in angles else self._last(x, i) for i, x in enumerate(given)]

    def _last(self, x: Any, i: int) -> Any:
        """An input, or its last good value."""
        kept = self.record.choose(self.good, x, self.record.state(f"last{i}"))
        self.record.keep(f"last{i}", kept)
        return self.record.label(kept, f"row{i}")

    def _speed(self, measured: Any, i: int) -> Any:
        """The derivative filter of one angle: a prediction, corrected by the innovation."""
        gains, period, record = self.step.filter, self.step.period, self.record
        assert gains is not None
        assert period is not None
        position, speed = record.state(f"position{i}"), record.state(f"speed{i}")
        predicted = position + period * speed
        innovation = record.choose(self.good, self._turned(measured - predicted), 0.0)
        first = record.choose(self.good, self._turned(measured), position)
        corrected = self._turned(predicted + gains.g * innovation)
        record.keep(f"position{i}", kept(record.choose(self.going, corrected, first)))
        now = kept(record.choose(self.going, speed + gains.h * innovation / period, speed))
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
        kinds = (
            ("field", fields, [step.field] * len(fields)),
            ("slip", slips, [step.slip] * len(slips)),
            ("further", extras, step.extras),
        )
        outside: Any = False
        held: list[Any] = []
        for kind, signals, windows in kinds:
            for i, (x, window) in enumerate(zip(signals, windows, strict=True), start=1):
                out, within = self._within(x, window)
                outside = record.either(outside, record.label(out, f"{kind}{i}_outside"))
                held.append(record.label(within, f"{kind}{i}_held"))
        trained_on = step.model.trained_on
        for i in range(len(fields) if trained_on.near else 0):
            far = trained_on.far(i, held[i], held[step.elements + i])
            outside = record.either(outside, record.label(far, f"far{i + 1}"))
        both = False
        if len(fields) == 2:
            both = record.both(record.less(step.both, fields[0]), record.less(step.both, fields[1]))
        return outside, both, held

    def _within(self, x: Any, window: Window) -> tuple[Any, Any]:
        """Whether a signal is outside its window, and the signal held in it."""
        record = self.record
        out = recorded_limits.beyond(x, *window.warn)
        low, high = window.hold
        held = record.call("held", recorded_limits.held, value=x, low=low, high=high)
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
        on_slip = [(stage, parameters) for stage, parameters in self.step.stages if stage.place == "slip"]
        remembered: list[list[Sequence[Any]]] = []
        for i, signal in enumerate(moved):
            remembered.append([self._stepped(stage, parameters, signal, str(i)) for stage, parameters in on_slip])
        return remembered

    def _stepped(self, stage: Stage, parameters: Mapping[str, float], signal: Any, element: str) -> tuple[Any, ...]:
        """Outputs of a stage for a signal; the stage's memory becomes numbers of the state."""
        initial = stage.initial(signal, parameters)
        memory = StageMemory(self.record, self.going, suffix_of(stage, element), initial, self._earlier)
        return stage.step(memory, signal, parameters, self.step.period or 1.0)

    def _through(self, place: Place, signal: Any, element: str = "") -> Any:
        """A signal behind the stages of a place."""
        if self.rest:
            return signal
        for stage, parameters in self.step.stages:
            if stage.place == place:
                (signal,) = self._stepped(stage, parameters, signal, element)
        return signal

    def _past(self) -> Any:
        """A function that gives a signal some rows back; each signal gets a register of its own."""
        names: dict[int, str] = {}

        def past(signal: Any, rows: int) -> Any:
            name = names.setdefault(self.record.node_of(signal).index, f"past{len(names)}")
            return self._earlier(name, signal, rows)

        return past

    def _earlier(self, name: str, signal: Any, rows: int) -> Any:
        """A signal some rows back; in the first row the signal itself."""
        if self.ahead:
            back = self.record.operand("earlier", value=(name, rows))
            return self.record.choose(self.going, back, signal)
        return self.record.operand("delay", signal, self.going, value=(name, rows))

    def tracked(self, effort: Any, measured: Any) -> tuple[Any, Any]:
        """The effort to be given out, and whether it is the adapted one; the state follows the measured effort."""
        tracking, record = self.step.tracking, self.record
        if tracking is None or self.rest:
            return effort, False
        names = [f"track_{name}" for name in BASE._fields]
        numbers = zip(names, BASE, strict=True)
        before = Tracked(*(record.choose(self.going, record.state(name), first) for name, first in numbers))
        moved, cost = tracking.moved(before, effort)
        adapted = record.label(record.both(self.started, record.less(cost, before.account)), "adapted")
        given = record.label(record.choose(adapted, moved, effort), "given")
        counts = record.label(record.both(self.started, record.finite(measured)), "counts")
        after = tracking.after(before, effort, given, record.choose(counts, measured, effort))
        for name, new, old in zip(names, after, before, strict=True):
            record.keep(name, record.label(record.choose(counts, new, old), name))
        return given, adapted

    def unlike(self, fields: Sequence[Any], slips: Sequence[Any]) -> Any:
        """Whether a field or slip is so far from all rows that it is held: no band is meant for it; of alarms only."""
        step, record = self.step, self.record
        if step.alarms is None or self.rest:
            return False
        far = [recorded_limits.beyond(x, *step.field.hold) for x in fields]
        far += [recorded_limits.beyond(x, *step.slip.hold) for x in slips]
        return record.label(reduce(record.either, far), "no_band")

    def alarms(self, effort: Any, held: Sequence[Any], measured: Any, good: Any, unlike: Any) -> dict[int, Any]:
        """Whether the band is wide or there is none, and whether the residual has drifted; the state keeps its ends."""
        alarms, record = self.step.alarms, self.record
        if alarms is None or self.rest:
            return {}
        band = alarms.band
        fields, slips, _ = self._by_kind(held)
        field, slip, place = band.leading(fields, slips)
        switching = band.switching(field, self._follow(band.settling_s, field, "_band"))
        factor = None if band.haste is None else band.haste.factor_of_step(slip, self._follow)
        low, high = band.ends(effort, slip, switching, place, factor)
        for name, end in (("low", low), ("high", high)):
            record.keep(name, record.label(end, name))
        side = less_select(slip, 0.0, -1.0, 1.0)
        drifted = self.drifted(alarms, effort, (low, high), side, measured, good)
        return {WIDE_BAND: record.either(record.less(alarms.wide, high - low), unlike), DRIFT: drifted}

    def _follow(self, seconds: float, signal: Any, name: str) -> Any:
        """A first-order lag behind a signal, with a number of the state by this name."""
        return self._stepped(FOLLOWER, {"tau_e": seconds}, signal, name)[0]

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
        record = self.record
        low, high = ends
        counts = record.both(record.both(good, record.finite(measured)), record.less(low, high))
        miss = record.both(counts, record.either(record.less(measured, low), record.less(high, measured)))
        # In half widths of the band. Gathered over a block of rows, and begun anew when the block is full.
        off = within((measured - effort) * side / (0.5 * (high - low)), -1.0, 1.0)
        row, missed = (record.choose(truth, 1.0, 0.0) for truth in (counts, miss))
        rows = record.state("drift_rows") + row
        misses = record.state("drift_misses") + missed
        lean = record.state("drift_lean") + record.choose(counts, off, 0.0)
        block = float(alarms.block)
        block_open = record.label(record.less(rows, block), "block_open")
        for name, total in (("rows", rows), ("misses", misses), ("lean", lean)):
            record.keep(f"drift_{name}", record.choose(block_open, total, 0.0))

        share_missed = misses * (1.0 / block)
        mean = lean * (1.0 / block)
        above, below = (less_select(alarms.lean, x, 1.0, 0.0) for x in (mean, -mean))
        raised: Any = False
        for name, share, tolerated in (
            ("missing", share_missed, alarms.missing),
            ("above", above, alarms.leaning),
            ("below", below, alarms.leaning),
        ):
            before = record.state(f"drift_{name}")
            now = record.choose(block_open, before, alarms.wealth(before, share, tolerated))
            record.keep(f"drift_{name}", record.label(now, f"drift_{name}"))
            raised = record.either(raised, record.opposite(record.less(now, alarms.goal)))
        return raised

    def limited(self, value: Any) -> tuple[Any, Any]:
        """The effort within its limits, that of the row before where it is not finite; and whether that was needed."""
        record, (low, high) = self.record, self.step.limits
        record.label(value, "unlimited")
        before = record.state("effort") if self.remember else 0.0
        limited = record.call("limited", recorded_limits.limited, value=value, before=before, low=low, high=high)
        effort = record.label(record.choose(self.started, limited, 0.0), "now")
        beyond = record.label(recorded_limits.beyond(value, low, high), "beyond")
        finite = record.label(record.finite(value), "is_finite")
        if self.remember:
            record.keep("effort", effort)
        return effort, record.either(record.opposite(finite), beyond)
