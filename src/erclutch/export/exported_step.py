"""What an exported step computes: the model, cut into stages with every number that they need. C and emulation read it.

input -> [angles to speeds] -> fields and slips, held near the training range -> command of each element
      -> [lag and delay] -> effort (law or network) -> limits
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from erclutch.differentiate import CAUSAL, Derivative, live
from erclutch.dynamics import Clock
from erclutch.errors import ExportError
from erclutch.export.graph import Graph, Traced
from erclutch.model import Structure, TorqueModel
from erclutch.networks import base_inputs
from erclutch.networks.model import NetworkModel
from erclutch.precision import PRECISIONS, Precision, PrecisionName
from erclutch.saved import Model

InputsName = Literal["speeds", "angles"]

#: Flags that a step returns.
OUTSIDE, NON_FINITE, BOTH_FIELDS, LIMITED, OUT_OF_REACH = 1, 2, 4, 8, 16
#: Angles beyond are taken for a broken sensor: one more turn could no longer be told in float32.
LARGEST_ANGLE = 1e6
_LONGEST_NAME = 20
_MOST_ROWS = 100_000
#: Share by which a measured period may be off the one that is meant.
_SAME_PERIOD = 0.01


@dataclass(frozen=True)
class Options:
    """What is asked of an export.

    Attributes:
        name: prefix of all C names and files; None takes the model's.
        precision: float32 or float64.
        period: sampling period in s; None takes that of the training data, where the model knows it.
        inputs: "speeds", or "angles" (positions of a single device) with the derivative filter inside.
        derivative: the causal filter for angles.
        limits: smallest and largest effort; None takes the training range, widened by half its width on each side.
    """

    name: str | None = None
    precision: PrecisionName = "float64"
    period: float | None = None
    inputs: InputsName = "speeds"
    derivative: Derivative = field(default_factory=lambda: Derivative("kalman"))
    limits: tuple[float, float] | None = None


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
class Lag:
    """First-order lag and delay of the command at a fixed period (`erclutch.dynamics`).

    Attributes:
        rise, fall: share of the way gone in a step, 1 - exp(-period / tau); fall None where it is the same.
        tau_rise, tau_fall: time constants in s.
        rows: rows of history that the delay needs.
        bend_before, bend_after, forward, reach: weights of the cubic between two rows.
    """

    rise: float
    fall: float | None
    tau_rise: float
    tau_fall: float
    rows: int
    bend_before: float
    bend_after: float
    forward: float
    reach: float


@dataclass(frozen=True)
class Filter:
    """Speed from position (`erclutch.differentiate.LiveDerivative`).

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
class Program:
    """Everything of a step.

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
        command: from each field to the command; for a law with a stimulus it is more than a division.
        lag: None without dynamics.
        law: record of the effort from x1, (x2,) w1, (w2); None for a network.
        past: rows back that a network looks at.
        search: of the inverse.
    """

    name: str
    model: Model
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
    command: Graph
    lag: Lag | None
    law: Graph | None
    past: tuple[int, ...]
    search: Search

    @property
    def elements(self) -> int:
        """Elements of the device."""
        return 2 if self.model.structure.device == "coaxial" else 1

    @property
    def base(self) -> tuple[str, ...]:
        """A network's inputs of the present row."""
        if not isinstance(self.model, NetworkModel):
            return ()
        return base_inputs(self.model.structure.device, self.model.structure.kind)

    @property
    def rows_back(self) -> int:
        """Rows of a network's history."""
        return max(self.past, default=0)


def program_of(model: Any, options: Options | None = None) -> Program:
    """The program of a model.

    Raises:
        ExportError: no model of erclutch, numbers that are not finite, an option that does not fit.
    """
    options = options or Options()
    if not isinstance(model, TorqueModel | NetworkModel):
        raise ExportError(
            f"a {type(model).__module__}.{type(model).__name__} cannot be exported: its equation is not known, "
            "so no C can be made of it",
            remedy="Export a TorqueModel or NetworkModel: erclutch fit writes them, and a fitted LawRegressor has "
            "one in its model_",
        )
    _all_finite(model)
    if options.precision not in PRECISIONS:
        raise ExportError(f"precision {options.precision!r}", remedy="Give float32 or float64")
    period = _period(model, options)
    command, law = _graphs(model)
    coaxial = model.structure.device == "coaxial"
    field_window, slip_window = _window(model.trained_on.field), _window(model.trained_on.slip)
    scale = float(np.max(np.abs(model.trained_on.effort)))
    names = ("E1", "E2", "theta_dot", "alpha_dot") if coaxial else ("field", "slip")
    extras = model.structure.extras if isinstance(model, NetworkModel) else ()
    field_unit, slip_unit = model.units.field or "1", model.units.slip
    units: tuple[str, ...] = (*((field_unit,) * (len(names) // 2)), *((slip_unit,) * (len(names) // 2)))
    filter_ = None
    if options.inputs == "angles":
        names = ("E1", "E2", "theta", "alpha") if coaxial else ("field", "position")
        assert period is not None
        filter_ = _filter(options.derivative, period, slip_unit, coaxial)
        angle_unit = slip_unit.removesuffix("/s") if slip_unit.endswith("/s") else f"{slip_unit}*s"
        units = (*units[: len(units) // 2], *((angle_unit,) * (len(names) // 2)))
    return Program(
        name=c_name(model.name, options.name),
        model=model,
        digest=str(model.to_dict()["digest"]),
        precision=PRECISIONS[options.precision],
        period=period,
        inputs=(*names, *extras),
        units=(*units, *("?" for _ in extras)),
        filter=filter_,
        field=field_window,
        slip=slip_window,
        extras=_extra_windows(model),
        both=0.01 * max(abs(v) for v in model.trained_on.field),
        limits=_limits(model, options.limits),
        scale=scale,
        command=command,
        lag=_lag(model, period),
        law=law,
        past=model.structure.past if isinstance(model, NetworkModel) else (),
        search=_search(model, PRECISIONS[options.precision], scale),
    )


# --- numbers ---------------------------------------------------------------------------------------------------------


def _numbers(model: Model) -> dict[str, Any]:
    ranges = {f"range of {k}": getattr(model.trained_on, k) for k in ("field", "slip", "effort")}
    if isinstance(model, TorqueModel):
        reference = {"reference field": model.reference.field, "reference slip": model.reference.slip}
        return {**model.shape, **model.gains, **reference, **ranges}
    s = model.scaling
    scaling = {"offset": s.offset, "scale": s.scale, "effort_offset": s.effort_offset, "effort_scale": s.effort_scale}
    return {**model.weights, **model.dynamics, **scaling, "input range": model.input_range, **ranges}


def _all_finite(model: Model) -> None:
    for name, value in _numbers(model).items():
        numbers = np.asarray(value, np.float64)
        if not np.all(np.isfinite(numbers)):
            bad = numbers[~np.isfinite(numbers)].flat[0]
            raise ExportError(
                f"{name} is {bad}; every number of a model must be finite",
                where=model.name,
                remedy="Fit the model again, or restore its file",
            )


def _window(covered: tuple[float, float]) -> Window:
    low, high = covered
    slack = 0.01 * (high - low)
    room = 0.1 * max(high - low, abs(low), abs(high))
    return Window(covered, (low - slack, high + slack), (low - room, high + room))


def _extra_windows(model: Model) -> tuple[Window, ...]:
    if not isinstance(model, NetworkModel) or not model.structure.extras:
        return ()
    ranges = model.input_range[-len(model.structure.extras) :]
    return tuple(_window((float(low), float(high))) for low, high in ranges)


def _limits(model: Model, wanted: tuple[float, float] | None) -> tuple[float, float]:
    low, high = model.trained_on.effort
    if wanted is None:
        room = 0.5 * (high - low)
        return low - room, high + room
    if not (np.all(np.isfinite(wanted)) and wanted[0] < wanted[1]):
        raise ExportError(
            f"effort limits {wanted[0]:g} to {wanted[1]:g}", remedy="Give the smaller one first, both finite"
        )
    return wanted


def _period(model: Model, options: Options) -> float | None:
    own = model.reference.period if isinstance(model, TorqueModel) else model.period
    period = own if options.period is None else options.period
    if period is not None and not (np.isfinite(period) and 1e-7 <= period <= 10.0):
        raise ExportError(f"a period of {period:g} s", remedy="Give one between 1e-7 s and 10 s")
    past = model.structure.past if isinstance(model, NetworkModel) else ()
    if period is None and (past or model.structure.dynamics != "none" or options.inputs == "angles"):
        raise ExportError(
            "its past rows, dynamics or filter need a sampling period, which this network's file does not hold",
            where=model.name,
            remedy="Give --period, for example --period 0.001",
        )
    if past and own is not None and period is not None and abs(period - own) > _SAME_PERIOD * own:
        raise ExportError(
            f"a period of {period:g} s for a network whose inputs are rows {', '.join(map(str, past))} back at "
            f"{own:.6g} s: at another period they would be other instants",
            where=model.name,
            remedy=f"Call the step every {own:.6g} s and leave --period out, or fit a log sampled at {period:g} s",
        )
    return period


# --- stages ----------------------------------------------------------------------------------------------------------


def _lag(model: Model, period: float | None) -> Lag | None:
    """The lag's numbers, by the same operations as `dynamics`."""
    if model.structure.dynamics == "none":
        return None
    assert period is not None
    numbers = model.shape if isinstance(model, TorqueModel) else model.dynamics
    delay, single = numbers["delay"], model.structure.dynamics == "lag"
    rise = numbers["tau"] if single else numbers["tau_rise"]
    fall = rise if single else numbers["tau_fall"]
    whole = int(delay / period)
    if whole + 2 > _MOST_ROWS:
        raise ExportError(
            f"a delay of {delay:g} s is {whole} rows at a period of {period:g} s",
            remedy=f"Give a longer --period: at most {_MOST_ROWS} rows",
        )
    s = ((whole + 1) * period - delay) / period
    square, cube = s * s, s * s * s
    return Lag(
        rise=-float(np.expm1(-period / rise)),
        fall=None if single else -float(np.expm1(-period / fall)),
        tau_rise=rise,
        tau_fall=fall,
        rows=whole + 2,
        bend_before=cube - 2.0 * square + s,
        bend_after=cube - square,
        forward=3.0 * square - 2.0 * cube,
        reach=period,
    )


def _filter(derivative: Derivative, period: float, slip_unit: str, coaxial: bool) -> Filter:
    if derivative.name not in CAUSAL:
        raise ExportError(
            f"the filter {derivative.name} needs samples of the future",
            remedy=f"Give --derivative {', '.join(CAUSAL)}",
        )
    made = live(derivative, period)
    turn = 2.0 * np.pi if coaxial or slip_unit == "rad/s" else None
    return Filter(derivative.name, made.g, made.h, turn)


def _graphs(model: Model) -> tuple[Graph, Graph | None]:
    """Records of the command (from field) and of the effort (from x1, x2, w1, w2)."""
    command = Graph()
    if isinstance(model, NetworkModel):
        command.give(command.input("field"))
        return command, None
    effort = Graph()
    structure, names = model.structure, [f"x{i + 1}" for i in range(model.structure.elements)]
    fluids = iter([effort.input(name) for name in names])

    class _InFluid(Structure):
        """The model's own structure, with the fluid's field as an input of its own."""

        def in_fluid(self, command: Any, clock: Clock, q: Any, rows: slice) -> Any:
            return next(fluids)

    own = _InFluid(
        structure.device,
        structure.specification,
        structure.law,
        structure.dynamics,
        structure.friction,
        structure.offset,
    )
    elements: list[Any] = [_Row(effort.input(f"E{i + 1}"), effort.input(f"w{i + 1}")) for i in range(len(names))]
    q = list(model.shape.values())
    columns = own.columns(elements, Clock(np.zeros(1), ()), model.reference, q)
    total: Any = None
    for gain, column in zip(model.gains.values(), columns, strict=True):
        term = gain * column
        total = term if total is None else total + term
    effort.give(total)
    given: Any = command.input("field") / model.reference.field
    law = structure.law
    command.give(given if law.stimulus is None else law.stimulus(given, *q[: len(law.stimulus_shape)]))
    return command, effort


@dataclass(frozen=True)
class _Row:
    """One row of one element."""

    field: Traced
    slip: Traced


def _search(model: Model, precision: Precision, scale: float) -> Search:
    from erclutch.export.monotone import monotone_share, sides

    origin, plus, minus = sides(model)
    share = monotone_share(model)
    bits = precision.fraction - 5
    return Search(
        origin=origin,
        plus=plus,
        minus=minus,
        segments=1 if share == 1.0 else 8,
        tolerance=scale * 2.0 ** (-18 if precision.width == 32 else -44),
        width=(plus - minus) * 2.0 ** (-20 if precision.width == 32 else -46),
        most=2 * bits,
        monotone_share=share,
    )


# --- names -----------------------------------------------------------------------------------------------------------

# Words of C and C++, and names that would meet others.
_KEYWORDS = (
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept "
    "const const_cast consteval constexpr constinit continue decltype default delete do double "
    "dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable "
    "namespace new noexcept not not_eq nullptr operator or or_eq private protected public register "
    "reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast "
    "struct switch template this thread_local throw true try typedef typeid typename union unsigned using "
    "virtual void volatile wchar_t while xor xor_eq main erc_model"
)


def c_name(model: str, wanted: str | None = None) -> str:
    """Prefix of all C names, and so the name of the C file: the one that is wanted, else made from the model's.

    Raises:
        ExportError: what is wanted will not do.
    """
    if wanted is None:
        made = re.sub(r"[^a-z0-9]+", "_", model.lower()).strip("_")
        return made[:_LONGEST_NAME].rstrip("_")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", wanted) or wanted in _KEYWORDS.split() or "__" in wanted:
        raise ExportError(
            f"{wanted!r} is no name for C functions",
            where="--name",
            remedy="Give a C identifier: a letter, then letters, digits and single underscores; no keyword",
        )
    if len(wanted) > _LONGEST_NAME:
        raise ExportError(
            f"{wanted!r} has {len(wanted)} characters; C compilers need only tell 31 of {wanted}_inverse apart",
            where="--name",
            remedy=f"Give at most {_LONGEST_NAME} characters",
        )
    return wanted
