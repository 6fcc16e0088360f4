"""What an exported step is: a model, and every number around it that the step needs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, Literal, cast

import numpy as np

from erclutch.arithmetic.precision import PRECISIONS, Precision, PrecisionName
from erclutch.errors import ExportError, keywords_checked
from erclutch.export.c_names import c_name
from erclutch.export.encode import comment
from erclutch.export.monotone import monotone_share, sides
from erclutch.models.alarms import Alarms, alarms_of
from erclutch.models.gain_tracking import GainTracking, tracking_of
from erclutch.models.model import Model, held_window, margins, stage_numbers
from erclutch.models.model_titles import title_of
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.shared_answers import ModelBase
from erclutch.models.stages import NONE
from erclutch.models.stages.stage import Stage
from erclutch.signals.array import largest_size
from erclutch.signals.device import WAYS_OF, DeviceName
from erclutch.signals.speed import CAUSAL, Derivative, live

InputsName = Literal["speeds", "angles"]

#: Flags that a step returns; WIDE_BAND and DRIFT only with alarms, ADAPTED only with tracking.
OUTSIDE = 1
NON_FINITE = 2
BOTH_FIELDS = 4
LIMITED = 8
OUT_OF_REACH = 16
WIDE_BAND = 32
DRIFT = 64
ADAPTED = 128
#: Angles beyond are taken for a broken sensor: one more turn could no longer be told in float32.
LARGEST_ANGLE = 1e6
#: Share by which a measured period may be off the one that is meant.
_SAME_PERIOD = 0.01
#: In s: no loop that runs in real time is slower.
_LONGEST_PERIOD = 10.0


@keywords_checked
@dataclass(frozen=True)
class ExportOptions:
    """What is asked of an export.

    Attributes:
        name: prefix of all C names and files; None takes the model's.
        precision: float32 or float64.
        period: sampling period in s; None takes that of the training data, where the model knows it.
        inputs: "speeds", or "angles" (positions of a single device) with the derivative filter inside.
        derivative: the causal filter for angles.
        limits: smallest and largest effort; None takes the training range, widened by half its width on each side.
        alarms: a step takes the measured effort too, keeps the band, and raises the flags WIDE_BAND and DRIFT.
        adapt: a step takes the measured effort too, and a gain and an offset follow it (`models.gain_tracking`).
    """

    name: str | None = None
    precision: PrecisionName = "float64"
    period: float | None = None
    inputs: InputsName = "speeds"
    derivative: Derivative = field(default_factory=lambda: Derivative("kalman"))
    limits: tuple[float, float] | None = None
    alarms: bool = False
    adapt: bool = False


@dataclass(frozen=True)
class Window:
    """Limits of a signal.

    Attributes:
        range: smallest and largest value of the training data.
        warn: a value outside raises the flag OUTSIDE.
        hold: a value outside is computed with as the nearest one inside.
    """

    range: tuple[float, float]
    warn: tuple[float, float]
    hold: tuple[float, float]


@dataclass(frozen=True)
class Filter:
    """Speed from position (`erclutch.signals.speed.LiveDerivative`).

    Attributes:
        name: of the filter.
        g, h: its gains.
        turn: a whole turn, where the position is an angle that may wrap.
    """

    name: str
    g: float
    h: float
    turn: float | None


@dataclass(frozen=True)
class Search:
    """Where the inverse looks for the field.

    Attributes:
        origin, plus, minus: it goes from the origin to both sides; minus is the origin where there is one side only.
        segments: parts of each side, 1 where effort was found monotone in the field at all speeds.
        tolerance: effort that counts as met.
        width: field interval that ends the search.
        most: evaluations of the model at most, those of the segments not counted.
        monotone_share: share of the lines of the check that were monotone.
    """

    origin: float
    plus: float
    minus: float
    segments: int
    tolerance: float
    width: float
    most: int
    monotone_share: float


@dataclass(frozen=True)
class ExportedStep:
    """Everything of a step. Steps are equal where the digest of the model and all numbers around it are.

    Attributes:
        name: prefix of C names.
        model: what is exported.
        digest: SHA-256 of the model.
        precision: of all arithmetic.
        period: sampling period in s, None where nothing depends on it.
        inputs: names, in their order.
        units: unit of each input.
        filter: None where speeds come in.
        field, slip: windows.
        extras: windows of further inputs.
        both: each of the two fields is above: flag BOTH_FIELDS.
        limits: of the effort.
        scale: largest magnitude of the training effort; ulps are counted at it.
        stages: between command and field, in the order of the signal, each with its parameters.
        search: of the inverse.
        alarms: numbers of the alarms; None for a step without.
        tracking: numbers of the adaptation to a sensor; None for a step without.
    """

    name: str
    model: Model = dataclasses.field(compare=False)
    digest: str
    precision: Precision
    period: float | None
    inputs: tuple[str, ...]
    units: tuple[str, ...]
    filter: Filter | None
    field: Window
    slip: Window
    extras: tuple[Window, ...]
    both: float
    limits: tuple[float, float]
    scale: float
    stages: tuple[tuple[Stage, Mapping[str, float]], ...] = dataclasses.field(compare=False)
    search: Search
    alarms: Alarms | None = None
    tracking: GainTracking | None = None

    @property
    def measures(self) -> bool:
        """Whether the last input is the measured effort."""
        return self.alarms is not None or self.tracking is not None

    @property
    def other_period(self) -> str:
        """What to know of a memory that is called at another period than it was fitted at; else empty."""
        own = self.model.period
        period = self.period
        if own is None or period is None or self.model.structure.dynamics == NONE:
            return ""
        if abs(period - own) <= _SAME_PERIOD * own:
            return ""
        return (
            f"{self.model.name} was fitted to rows of {1e3 * own:.4g} ms and is called every {1e3 * period:.4g} ms. "
            "Its memory moves once a call, so the errors of its run do not hold. Fit with --resample "
            f"{1.0 / period:.6g}Hz to see those of this period"
        )

    @property
    def notes(self) -> list[str]:
        """What to know before the step is used: sentences without their full stops."""
        return [note for note in (self.other_period, self.model.unbounded) if note]

    @property
    def model_inputs(self) -> int:
        """How many of the inputs the model's effort depends on; behind them may come the measured effort."""
        return len(self.inputs) - self.measures

    @property
    def elements(self) -> int:
        """Elements of the device."""
        return len(WAYS_OF[self.device])

    @property
    def device(self) -> DeviceName:
        """Which device it is of."""
        return self.model.structure.device

    @property
    def headline(self) -> str:
        """Title of the model in plain words, for a comment."""
        return comment(title_of(self.model.name))

    @property
    def network(self) -> NetworkModel | None:
        """The network, where the model is one or has one: its tables are printed as tables."""
        return self.model.network_part


#: What targets call the step's other variables: no further input may have such a name.
_NAMES_OF_TARGETS = ("measured", "effort", "flags", "residual", "time")


def described_step(model: Any, options: ExportOptions | None = None) -> ExportedStep:
    """Everything of a model's step.

    Raises:
        ExportError: no model of erclutch, numbers that are not finite, an option that does not fit.
    """
    options = options or ExportOptions()
    # A model of another package may answer all but say no equation: then there is nothing to make C of.
    if not (isinstance(cast(object, model), ModelBase) and hasattr(model, "from_fluid")):
        if isinstance(model, str | PathLike):
            name = repr(str(cast(object, model)))
            remedy = f"Export its model: erclutch.read_run({name}).model()"
            raise ExportError(f"{name} is the name of a file or run, not a model", remedy=remedy)
        if callable(getattr(model, "model", None)):  # a run
            remedy = "Export its recommended model: run.model()"
            raise ExportError(
                f"{type(model).__name__} is not a model, but holds models", remedy=remedy
            )
        raise ExportError(
            f"{type(model).__module__}.{type(model).__name__} cannot be exported: its equation is not known, "
            "so no C can be made of it",
            remedy="Export a TorqueModel or NetworkModel: erclutch fit writes them, and a fitted LawRegressor has "
            "one in its model_",
        )
    _all_finite(model)
    if options.precision not in PRECISIONS:
        raise ExportError(f"precision {options.precision!r}", remedy="Give float32 or float64")
    period = _period(model, options)
    coaxial = model.structure.device == "coaxial"
    elements = len(WAYS_OF[model.structure.device])
    scale = largest_size(model.trained_on.effort)

    field_unit = model.units.field or "1"
    slip_unit = model.units.slip
    filter_ = None
    if options.inputs == "angles":
        assert period is not None
        derivative = options.derivative
        if derivative.name not in CAUSAL:
            problem = f"the filter {derivative.name} needs samples of the future"
            raise ExportError(problem, remedy=f"Give --derivative {', '.join(CAUSAL)}")
        gains = live(derivative, period)
        turn = 2.0 * np.pi if coaxial or slip_unit == "rad/s" else None
        filter_ = Filter(derivative.name, gains.g, gains.h, turn)
        names = ("E1", "E2", "theta", "alpha") if coaxial else ("field", "position")
        motion_unit = slip_unit.removesuffix("/s") if slip_unit.endswith("/s") else f"{slip_unit}*s"
    else:
        names = ("E1", "E2", "theta_dot", "alpha_dot") if coaxial else ("field", "slip")
        motion_unit = slip_unit
    units = (field_unit,) * elements + (motion_unit,) * elements
    # A column may have the name of a signal (a position beside speeds from positions) or of a target's own variable.
    taken = {*names, *_NAMES_OF_TARGETS}
    names += tuple(f"{name} (further input)" if name in taken else name for name in model.extras)
    units += tuple(model.extra_units.values())
    if options.alarms or options.adapt:
        names += ("measured",)
        units += (model.units.effort or "1",)

    alarms = _alarms(model, scale, period) if options.alarms else None
    limits = _limits(model, options.limits)
    precision = PRECISIONS[options.precision]
    origin, plus, minus = sides(model)
    share = monotone_share(model)
    search = Search(
        origin=origin,
        plus=plus,
        minus=minus,
        segments=1 if share == 1.0 else 8,
        tolerance=scale * 2.0 ** (-18 if precision.width == 32 else -44),
        width=(plus - minus) * 2.0 ** (-20 if precision.width == 32 else -46),
        most=2 * (precision.fraction - 5),
        monotone_share=share,
    )
    return ExportedStep(
        name=c_name(model.name, options.name),
        model=model,
        digest=str(model.to_dict()["digest"]),
        precision=precision,
        period=period,
        inputs=names,
        units=units,
        filter=filter_,
        field=_window(model.trained_on.field),
        slip=_window(model.trained_on.slip),
        extras=tuple(_window(covered) for covered in model.extras.values()),
        both=0.01 * largest_size(model.trained_on.field),
        limits=limits,
        scale=scale,
        stages=tuple(stage_numbers(model)),
        search=search,
        alarms=alarms,
        tracking=tracking_of(scale, limits) if options.adapt else None,
    )


# --- numbers ---------------------------------------------------------------------------------------------------------


def _all_finite(model: Model) -> None:
    """Refuse a model with a number that is not finite."""
    every = dict(model.numbers)
    for signal in ("field", "slip", "effort"):
        every[f"range of {signal}"] = getattr(model.trained_on, signal)
    for name, value in every.items():
        numbers = np.asarray(value, np.float64)
        if not np.all(np.isfinite(numbers)):
            bad = numbers[~np.isfinite(numbers)].flat[0]
            raise ExportError(
                f"{name} is {bad}; every number of a model must be finite",
                where=model.name,
                remedy="Fit the model again, or restore its file",
            )


def _window(covered: tuple[float, float]) -> Window:
    return Window(covered, margins(covered), held_window(covered))


def _alarms(model: Model, scale: float, period: float | None) -> Alarms:
    if model.band is None:
        raise ExportError(
            "alarms need a band, and the model has none",
            where=model.name,
            remedy="Fit the log again with this version, or export without alarms",
        )
    if period is None:
        raise ExportError(
            "alarms need a sampling period",
            where=model.name,
            remedy="Give --period, for example --period 0.001",
        )
    return alarms_of(model.band, scale, period)


def _limits(model: Model, wanted: tuple[float, float] | None) -> tuple[float, float]:
    low, high = model.trained_on.effort
    if wanted is None:
        room = 0.5 * (high - low)
        return low - room, high + room
    if not (np.all(np.isfinite(wanted)) and wanted[0] < wanted[1]):
        raise ExportError(
            f"effort limits {wanted[0]:g} to {wanted[1]:g}",
            remedy="Give the smaller one first, both finite",
        )
    return wanted


def _period(model: Model, options: ExportOptions) -> float | None:
    own = model.period
    past = model.past
    period = own if options.period is None else options.period
    if options.period is None and own is not None and own > _LONGEST_PERIOD:
        raise ExportError(
            f"its log has a row in {own:.4g} s, and no step is written for more than {_LONGEST_PERIOD:g} s",
            where=model.name,
            remedy=f"Give the period of the target, for example --period {_LONGEST_PERIOD:g}",
        )
    if period is not None and not (np.isfinite(period) and 1e-7 <= period <= _LONGEST_PERIOD):
        raise ExportError(f"a period of {period:g} s", remedy="Give one between 1e-7 s and 10 s")
    if period is None and (past or model.structure.dynamics != NONE or options.inputs == "angles"):
        raise ExportError(
            "its past rows, dynamics or filter need a sampling period, which this network's file does not hold",
            where=model.name,
            remedy="Give --period, for example --period 0.001",
        )
    # Past samples count in rows of the log: at another period they would lie at other times.
    if past and own is not None and period is not None and abs(period - own) > _SAME_PERIOD * own:
        raise ExportError(
            f"a period of {period:g} s for a network whose inputs are rows {', '.join(map(str, past))} back at "
            f"{own:.6g} s: at another period they would be other instants",
            where=model.name,
            remedy=f"Call the step every {own:.6g} s and leave --period out, or fit a log sampled at {period:g} s",
        )
    return period
