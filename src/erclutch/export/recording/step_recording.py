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
from erclutch.arithmetic.record import Record
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
)
from erclutch.export.recording import recorded_limits
from erclutch.export.recording.drift_recording import drifted
from erclutch.export.recording.giving_way import given_way, named_groups
from erclutch.export.recording.recorded_filter import filtered_speed
from erclutch.export.recording.recorded_step import StepRecord
from erclutch.export.recording.recorded_tracking import tracked
from erclutch.export.recording.stage_memory import StageMemory, suffix_of
from erclutch.models.haste import FOLLOWER
from erclutch.models.model import FluidSignals, present, settled_memory
from erclutch.models.stages.stage import Place, Stage
from erclutch.signals.device import slips_of

#: Number of the state that switches the network of a law off: the effort is the law's alone.
SWITCHED_OFF = "residual_off"


def parted(step: ExportedStep, signed: Any) -> list[Any]:
    """The fields of the elements for a signed field."""
    if step.elements == 1:
        return [signed]
    first = less_select(0.0, signed, signed, 0.0)
    second = less_select(signed, 0.0, -signed, 0.0)
    return [first, second]


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
        step = self.step
        record = self.record
        names = tuple(f"u{i}" for i in range(len(step.inputs)))
        given = [record.input(name) for name in names]
        measured = given[-1]  # the effort, where the step measures
        row = self.receive(given[: step.model_inputs])

        # From speeds to slips, and all signals near what was trained on.
        fields, speeds, extras = self._by_kind(row)
        slips = slips_of(step.device, speeds)
        outside, both_fields, held = self.signals(fields, slips, extras)
        unlike = self.unlike(fields, slips)

        # The effort, and what is known of it.
        fields, slips, extras = self._by_kind(held)
        value = self.behind(fields, slips, extras)
        effort, limited = self.limited(value)
        effort, adapted = self.tracked(effort, measured)
        flags = {
            OUTSIDE: outside,
            BOTH_FIELDS: both_fields,
            LIMITED: limited,
            ADAPTED: adapted,
        }
        may_count = record.both(self.good, record.opposite(outside))
        flags |= self.alarms(effort, held, measured, may_count, unlike)

        # A flag that this step can never raise is none of its flags.
        raised: dict[int, Any] = {}
        for bit, truth in flags.items():
            if truth is not False:
                raised[bit] = record.both(self.started, truth)
        raised[NON_FINITE] = record.opposite(self.good)

        self._refuse_names()
        field_nodes = tuple(record.node_of(field) for field in fields)
        slip_nodes = tuple(record.node_of(slip) for slip in slips)
        extra_nodes = tuple(record.node_of(extra) for extra in extras)
        record.outputs = [record.node_of(output) for output in (effort, *raised.values())]
        effort_node, *flag_nodes = record.outputs
        return StepRecord(
            record=record,
            inputs=names,
            effort=effort_node,
            flags=dict(zip(raised, flag_nodes, strict=True)),
            value=record.node_of(value),
            fields=field_nodes,
            slips=slip_nodes,
            extras=extra_nodes,
            started=record.node_of(self.started),
        )

    def _by_kind(
        self, signals: Sequence[Any]
    ) -> tuple[Sequence[Any], Sequence[Any], Sequence[Any]]:
        """Signals in the order of the inputs: those of the fields, of the motion, and the further ones."""
        elements = self.step.elements
        fields = signals[:elements]
        motion = signals[elements : 2 * elements]
        further = signals[2 * elements :]
        return fields, motion, further

    def _refuse_names(self) -> None:
        """Refuse a stage whose state has a name that C does not take."""
        names = list(self.record.after)
        for node in self.record.nodes:
            if node.operation == "delay":
                register, _rows = node.value
                names.append(register)
        for name in names:
            if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
                raise ExportError(
                    f"a stage calls a number of its state {name!r}, which is no name in C",
                    where=self.step.model.name,
                    remedy="Name it in the stage with letters, digits and underscores, a letter first",
                )

    def next_effort(self) -> Record:
        """From a signed field and the other inputs, all finite, to the effort; the state is read."""
        step = self.step
        record = self.record
        elements = step.elements
        self.good = self.started = True
        self.going = record.state("started", kind="truth")
        fields = parted(step, record.input("field"))
        given = [record.input(f"u{i}") for i in range(elements, step.model_inputs)]
        speeds = given[:elements]
        extras = given[elements:]
        if step.filter:
            speeds = [self._speed(angle, i) for i, angle in enumerate(speeds)]
        _, _, held = self.signals(fields, slips_of(step.device, speeds), extras)
        record.give(self.behind(*self._by_kind(held)))
        record.after.clear()  # nothing is kept: the step itself comes later
        return record

    # --- input -------------------------------------------------------------------------------------------------------

    def receive(self, given: Sequence[Any]) -> list[Any]:
        """The last good row, and what is known of it."""
        record = self.record
        elements = self.step.elements
        angles = range(0)  # places of the angles among the inputs
        if self.step.filter and not self.rest:
            angles = range(elements, 2 * elements)

        # A row is good if all of it can be used.
        good: Any = True
        for i, signal in enumerate(given):
            usable = record.finite(signal)
            if i in angles:
                above = record.less(-LARGEST_ANGLE, signal)
                below = record.less(signal, LARGEST_ANGLE)
                usable = record.both(usable, record.both(above, below))
            good = record.both(good, usable)
        self.good = self.started = record.label(good, "row_good")
        self.going: Any = False  # whether there was a good row before
        row: list[Any] = []
        if not self.remember:
            for i, signal in enumerate(given):
                usable = record.choose(good, signal, 0.0)
                row.append(record.label(usable, f"row{i}"))
            return row

        self.going = record.state("started", kind="truth")
        self.started = record.label(record.either(good, self.going), "row_known")
        record.keep("started", self.started)
        for i, signal in enumerate(given):
            if i in angles:
                row.append(self._speed(signal, i - elements))
            else:
                last = record.choose(good, signal, record.state(f"last{i}"))
                record.keep(f"last{i}", last)
                row.append(record.label(last, f"row{i}"))
        return row

    def _speed(self, angle: Any, element: int) -> Any:
        """The speed of an element's angle by the derivative filter."""
        gains = self.step.filter
        period = self.step.period
        assert gains is not None
        assert period is not None
        return filtered_speed(self.record, gains, period, angle, element, self.good, self.going)

    def signals(
        self, fields: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any]
    ) -> tuple[Any, Any, list[Any]]:
        """Whether one is outside what was trained on, whether both fields are on, and all within their windows."""
        step = self.step
        record = self.record
        kinds = (
            ("field", fields, [step.field] * len(fields)),
            ("slip", slips, [step.slip] * len(slips)),
            ("further", extras, step.extras),
        )
        outside: Any = False
        held: list[Any] = []
        for kind, signals, windows in kinds:
            for i, (signal, window) in enumerate(zip(signals, windows, strict=True), start=1):
                # A signal is held at the window's ends only where it is outside: else its bits stay.
                is_outside = recorded_limits.beyond(signal, *window.warn)
                low, high = window.hold
                at_ends = record.call(
                    "held", recorded_limits.held, value=signal, low=low, high=high
                )
                within = record.choose(is_outside, at_ends, signal)
                outside = record.either(outside, record.label(is_outside, f"{kind}{i}_outside"))
                held.append(record.label(within, f"{kind}{i}_held"))

        # Also inside the ranges a pair of field and slip may be far from all training rows.
        trained_on = step.model.trained_on
        if trained_on.near:
            for i in range(len(fields)):
                far = trained_on.far(i, held[i], held[step.elements + i])
                outside = record.either(outside, record.label(far, f"far{i + 1}"))
        both_fields = False
        if len(fields) == 2:
            first_on = record.less(step.both, fields[0])
            second_on = record.less(step.both, fields[1])
            both_fields = record.both(first_on, second_on)
        return outside, both_fields, held

    # --- effort ------------------------------------------------------------------------------------------------------

    def behind(self, fields: Sequence[Any], slips: Sequence[Any], extras: Sequence[Any]) -> Any:
        """The effort from signals within their windows."""
        model = self.step.model
        record = self.record
        commands = [record.call("command", model.command, field=field) for field in fields]
        fluids: list[Any] = []  # fields in the fluid
        for i, command in enumerate(commands):
            fluid = self._through("command", command, str(i))
            fluids.append(record.label(fluid, f"fluid{i + 1}"))
        remembered = self._remembered(fluids, slips)
        further = dict(zip(model.extras, extras, strict=True))

        # The law or the network, ahead of the stages on the effort.
        has_memory = model.past or any(remembered)
        if has_memory and not self.rest:  # in one piece, so that strength of the field is shared
            effort = model.from_fluid(
                FluidSignals(fluids, slips, remembered, further, self._past())
            )
        else:
            effort = self._at_rest(record, fluids, slips, extras, remembered)
        if model.gives_way is not None:
            again = None if has_memory else self._at_rest
            effort = given_way(model.gives_way, effort, (fluids, slips, extras), again)
        effort = self._through("effort", effort)

        # What a network adds to a law, unless the state switches it off.
        correction = model.correction
        if correction is None:
            return effort
        past = self._past() if model.past and not self.rest else present
        inputs = correction.inputs(FluidSignals(fluids, slips, remembered, further, past))
        named = {f"x{i}": signal for i, signal in enumerate(inputs, start=1)}
        residual = record.call("residual", correction.of, **named)
        if not self.remember:
            return effort + residual
        switched_off = record.state(SWITCHED_OFF, kind="truth")
        record.keep(SWITCHED_OFF, switched_off)
        return record.choose(switched_off, effort, effort + residual)

    def _at_rest(
        self,
        record: Record,
        fluids: Sequence[Any],
        slips: Sequence[Any],
        extras: Sequence[Any],
        remembered: Any = (),
    ) -> Any:
        """The effort ahead of the stages on it as a function of its own: past rows are as the present one."""
        model = self.step.model
        states = [state for element in remembered for outputs in element for state in outputs]

        def rest(*signals: Any) -> Any:
            own_fluids, own_slips, others = self._by_kind(signals)
            # The outputs of the stages came in one after another: they are grouped again as they were.
            own_states = iter(others[: len(states)])
            memory: list[list[list[Any]]] = []
            for element in remembered:
                memory.append([[next(own_states) for _ in outputs] for outputs in element])
            further = dict(zip(model.extras, others[len(states) :], strict=True))
            return model.from_fluid(FluidSignals(own_fluids, own_slips, memory, further))

        return record.call("rest", rest, **named_groups("xwmv", (fluids, slips, states, extras)))

    def _remembered(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[list[Sequence[Any]]]:
        """Outputs of the stages on the slip, for each element."""
        model = self.step.model
        moved = model.moved(fluids, slips)
        if self.rest:
            return settled_memory(model, moved)
        remembered: list[list[Sequence[Any]]] = []
        for i, signal in enumerate(moved):
            of_element: list[Sequence[Any]] = []
            for stage, parameters in self.step.stages:
                if stage.place == "slip":
                    of_element.append(self._stepped(stage, parameters, signal, str(i)))
            remembered.append(of_element)
        return remembered

    def _stepped(
        self, stage: Stage, parameters: Mapping[str, float], signal: Any, element: str
    ) -> tuple[Any, ...]:
        """Outputs of a stage for a signal; the stage's memory becomes numbers of the state."""
        initial = stage.initial(signal, parameters)
        memory = StageMemory(
            self.record, self.going, suffix_of(stage, element), initial, self._earlier
        )
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
            index = self.record.node_of(signal).index
            name = names.setdefault(index, f"past{len(names)}")
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
        tracking = self.step.tracking
        if tracking is None or self.rest:
            return effort, False
        return tracked(self.record, tracking, effort, measured, self.started, self.going)

    def unlike(self, fields: Sequence[Any], slips: Sequence[Any]) -> Any:
        """Whether a field or slip is so far from all rows that it is held: no band is meant for it; of alarms only."""
        step = self.step
        record = self.record
        if step.alarms is None or self.rest:
            return False
        far = [recorded_limits.beyond(field, *step.field.hold) for field in fields]
        far += [recorded_limits.beyond(slip, *step.slip.hold) for slip in slips]
        return record.label(reduce(record.either, far), "no_band")

    def alarms(
        self, effort: Any, held: Sequence[Any], measured: Any, good: Any, unlike: Any
    ) -> dict[int, Any]:
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
        drift = drifted(record, alarms, (low, effort, high), side, measured, good)
        wide = record.either(record.less(alarms.wide, high - low), unlike)
        return {WIDE_BAND: wide, DRIFT: drift}

    def _follow(self, seconds: float, signal: Any, name: str) -> Any:
        """A first-order lag behind a signal, with a number of the state by this name."""
        return self._stepped(FOLLOWER, {"tau_e": seconds}, signal, name)[0]

    def limited(self, value: Any) -> tuple[Any, Any]:
        """The effort within its limits, or the effort before where it is not finite; and whether that was needed."""
        record = self.record
        low, high = self.step.limits
        record.label(value, "unlimited")
        before = record.state("effort") if self.remember else 0.0
        limited = record.call(
            "limited",
            recorded_limits.limited,
            value=value,
            before=before,
            low=low,
            high=high,
        )
        effort = record.label(record.choose(self.started, limited, 0.0), "now")
        beyond = record.label(recorded_limits.beyond(value, low, high), "beyond")
        finite = record.label(record.finite(value), "is_finite")
        if self.remember:
            record.keep("effort", effort)
        return effort, record.either(record.opposite(finite), beyond)
