"""TorqueModel: a device, dynamics, a law and the numbers. It predicts effort and knows nothing of fits.

Normalisation is inside: fields are divided by the reference field, slips by the reference slip, so nobody ports it
by hand.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.device import DEVICES, DeviceName, Element, Units
from erclutch.dual import pick
from erclutch.dynamics import Clock, DynamicsForm, respond
from erclutch.errors import ErclutchError, RunError
from erclutch.exact import exact
from erclutch.laws import Dimension, Gain, Law, Shape, law_from_name
from erclutch.laws.smooth import FORWARD, direction

Array = NDArray[np.float64]

SCHEMA = 1
_TIME = Dimension(time=1)


@dataclass(frozen=True)
class Reference:
    """What normalises a model's inputs.

    Attributes:
        field: largest magnitude of the training fields, in the data's unit.
        slip: root mean square of the training slips, in the data's unit.
        period: sampling period of the training data in s; bounds the lags that can be told.
    """

    field: float
    slip: float
    period: float


def _as_it_is(x: Any) -> Any:
    return x


@dataclass(frozen=True)
class Structure:
    """What is fitted, without numbers.

    Attributes:
        device: "single" or "coaxial".
        specification: name of the law, for example ``hem/square``.
        law: the law itself.
        dynamics: stages between command and field.
        friction: a column of Coulomb friction at zero field (seals, bearings, remanence), one an element.
        offset: a constant effort (gas spring, preload, sensor zero).
    """

    device: DeviceName
    specification: str
    law: Law
    dynamics: DynamicsForm = "none"
    friction: bool = False
    offset: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        """Law functions are made, not imported, so a copy in another process makes its own from the names."""
        return _structure, (self.device, self.specification, self.dynamics, self.friction, self.offset)

    @property
    def elements(self) -> int:
        """Number of elements of the device."""
        return 2 if self.device == "coaxial" else 1

    @property
    def ways(self) -> tuple[float, ...]:
        """Sign in which each element drives: a law sees it as forward. Laws are odd, so only `Law.forward` feels it."""
        return (1.0, -1.0) if self.elements == 2 else (1.0,)

    def shapes(self, period: float) -> tuple[Shape, ...]:
        """All nonlinear parameters: of the stimulus, the law, the dynamics."""
        return (*self.law.stimulus_shape, *self.law.shape, *_dynamics_shapes(self.dynamics, period))

    def gains(self) -> tuple[Gain, ...]:
        """All linear parameters, elements one after another, the offset last."""
        own = (*self.law.gains, _FRICTION) if self.friction else self.law.gains
        if self.elements == 1:
            named = own
        else:
            named = tuple(
                Gain(f"{g.name}_{i + 1}", f"{g.meaning}, CH{i + 1}", g.dimension, g.nonnegative)
                for i in range(self.elements)
                for g in own
            )
        return (*named, _OFFSET) if self.offset else named

    def columns(
        self,
        elements: Sequence[Element],
        clock: Clock,
        reference: Reference,
        q: Sequence[Any],
        rows: slice = slice(None),
        functions: Callable[[Any], Any] = _as_it_is,
    ) -> list[Any]:
        """One column a gain, for normalised nonlinear parameters ``q`` (numbers or duals), at some of the rows.

        The dynamics run over all rows whatever is asked for: the fluid remembers the whole command. What ``functions``
        makes of an array is what the law computes with: `exact.exact` brings the exported C's exp, tanh and powers.
        """
        stimulus_count, law_count = len(self.law.stimulus_shape), len(self.law.shape)
        stimulus, shape = q[:stimulus_count], q[stimulus_count : stimulus_count + law_count]
        columns: list[Any] = []
        for way, element in zip(self.ways, elements, strict=True):
            command = functions(element.field / reference.field)
            if self.law.stimulus is not None:
                command = self.law.stimulus(command, *stimulus)
            strength = np.abs(functions(self.in_fluid(command, clock, q[stimulus_count + law_count :], rows)))
            slip = functions(way * element.slip[rows] / reference.slip)
            turn = FORWARD if self.law.forward else shape[0]
            own = [*self.law.columns(strength, slip, *shape)]
            if self.friction:
                own.append(direction(slip, turn) * np.ones(slip.size))
            columns.extend(own if way > 0 else (-c for c in own))
        if self.offset:
            columns.append(np.ones(clock.time[rows].size))
        return columns

    def in_fluid(self, command: Any, clock: Clock, q: Sequence[Any], rows: slice) -> Any:
        """The field in one element's fluid at some of the rows: the command after the dynamics."""
        if self.dynamics == "none":
            return pick(command, rows)
        fall = q[2] if self.dynamics == "rise-fall" else None
        return respond(command, clock, delay=q[0], rise=q[1], fall=fall, rows=rows)


def _structure(
    device: DeviceName, specification: str, dynamics: DynamicsForm, friction: bool, offset: bool
) -> Structure:
    return Structure(device, specification, law_from_name(specification, device), dynamics, friction, offset)


_FRICTION = Gain("T_f", "friction effort at zero field", Dimension(effort=1))
_OFFSET = Gain("T_0", "constant effort", Dimension(effort=1), nonnegative=False)


def _dynamics_shapes(form: DynamicsForm, period: float) -> tuple[Shape, ...]:
    if form == "none":
        return ()
    longest = 1.0
    delay = Shape("delay", "dead time between command and field", 0.0, max(0.05, 5 * period), _TIME)
    if form == "lag":
        return delay, Shape("tau", "time constant of the field", 0.2 * period, longest, _TIME, "log")
    return (
        delay,
        Shape("tau_rise", "time constant of the rising field", 0.2 * period, longest, _TIME, "log"),
        Shape("tau_fall", "time constant of the falling field", 0.2 * period, longest, _TIME, "log"),
    )


#: Names of the parameters of each form of dynamics.
TIMES: Mapping[DynamicsForm, tuple[str, ...]] = {
    "none": (),
    "lag": ("delay", "tau"),
    "rise-fall": ("delay", "tau_rise", "tau_fall"),
}


def in_user_units(value: float, dimension: Dimension, reference: Reference) -> float:
    """A normalised number in the data's own units."""
    return value * reference.field**dimension.field * reference.slip**dimension.slip


def unit_text(dimension: Dimension, units: Units) -> str:
    """Unit of a parameter, such as ``N/(m/s)``; "1" for a pure number, "?" inside where the log gave no unit."""
    above: list[str] = []
    below: list[str] = []
    powers = (
        (dimension.effort, units.effort),
        (dimension.field, units.field),
        (dimension.slip, units.slip),
        (dimension.time, "s"),
    )
    for exponent, unit in powers:
        if exponent and unit:
            name = f"({unit})" if "/" in unit and exponent < 0 else unit
            (above if exponent > 0 else below).append(name)
    text = "*".join(above) or "1"
    return text + "".join(f"/{name}" for name in below)


@dataclass(frozen=True)
class Range:
    """What the training data covered.

    Attributes:
        field: smallest and largest field over all elements.
        slip: smallest and largest slip over all elements.
        effort: smallest and largest effort.
    """

    field: tuple[float, float]
    slip: tuple[float, float]
    effort: tuple[float, float]


class Rows(Protocol):
    """What a model needs of a data set."""

    @property
    def device(self) -> DeviceName:
        """Which device the rows are of."""
        ...

    @property
    def elements(self) -> Sequence[Element]:
        """Field and slip of each element."""
        ...

    @property
    def clock(self) -> Clock:
        """When the rows were sampled."""
        ...

    @property
    def units(self) -> Units:
        """Units of effort, field and slip."""
        ...

    @property
    def extras(self) -> Mapping[str, Array]:
        """Further logged inputs by name."""
        ...


def outside_of(data: Rows, trained_on: Range) -> NDArray[np.bool_]:
    """Rows whose field or slip lies more than 1 % outside a range, shape (n,)."""
    out = np.zeros(data.clock.time.size, np.bool_)
    for element in data.elements:
        for values, (low, high) in ((element.field, trained_on.field), (element.slip, trained_on.slip)):
            slack = 0.01 * (high - low)
            out |= (values < low - slack) | (values > high + slack)
    return out


@dataclass(frozen=True)
class TorqueModel:
    """Effort of a device from its fields and slips.

    Attributes:
        structure: device, law, dynamics, friction and offset.
        reference: what normalises the inputs.
        shape: normalised nonlinear parameters by name.
        gains: linear parameters by name: effort per normalised column.
        units: units of inputs and output.
        trained_on: range of the training data.
    """

    structure: Structure
    reference: Reference
    shape: Mapping[str, float]
    gains: Mapping[str, float]
    units: Units
    trained_on: Range
    about: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def title(self) -> str:
        """Name for people."""
        return self.structure.law.title

    @property
    def name(self) -> str:
        """Identifier: specification of the law and the dynamics, for example ``bingham/power+lag``."""
        lag = "" if self.structure.dynamics == "none" else f"+{self.structure.dynamics}"
        return f"{self.structure.specification}{lag}"

    def predict(self, data: Rows) -> Array:
        """Effort over a data set, shape (n,), in the unit of the training data.

        Raises:
            ErclutchError: the data set is of another device or in other units.
        """
        if data.device != self.structure.device or data.units != self.units:
            raise ErclutchError(
                f"data of device {data.device} ({data.units.text()}) for a model of {self.structure.device} "
                f"({self.units.text()})",
                where=self.name,
                remedy="Read the log with the device and the units of the training data",
            )
        return self.effort(data.elements, data.clock)

    def outside(self, data: Rows) -> NDArray[np.bool_]:
        """Rows whose field or slip lies outside what the model was trained on, shape (n,): a guess there."""
        return outside_of(data, self.trained_on)

    def effort(self, elements: Sequence[Element], clock: Clock, *, exactly: bool = True) -> Array:
        """Effort for the fields and slips of each element on a clock, shape (n,).

        To the bit that of the exported C; with ``exactly=False`` by NumPy's own exp, tanh and powers, off by rounding
        and several times faster for a single row.
        """
        q = list(self.shape.values())
        functions = exact if exactly else _as_it_is
        columns = self.structure.columns(elements, clock, self.reference, q, functions=functions)
        return self._weighted(columns, clock.time.size)

    def _weighted(self, columns: Sequence[Any], rows: int) -> Array:
        """The sum of the columns times their gains, from left to right as in the exported C."""
        total = np.zeros(rows)
        for gain, column in zip(self.gains.values(), columns, strict=True):
            total += gain * np.asarray(column)
        return total

    def steady(self, fields: Sequence[Array], slips: Sequence[Array]) -> Array:
        """Effort once the field has settled: no dynamics. One array (n,) an element, in the data's units."""
        elements = [
            Element(np.atleast_1d(np.asarray(f, float)), np.atleast_1d(np.asarray(s, float)))
            for f, s in zip(fields, slips, strict=True)
        ]
        still = replace(self.structure, dynamics="none")
        clock = Clock(np.zeros(elements[0].field.size), ())
        count = len(still.law.stimulus_shape) + len(still.law.shape)
        columns = still.columns(elements, clock, self.reference, list(self.shape.values())[:count], functions=exact)
        return self._weighted(columns, elements[0].field.size)

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values, with a schema version and a digest over all of them."""
        body: dict[str, Any] = {
            "kind": "erclutch torque model",
            "schema": SCHEMA,
            "device": self.structure.device,
            "law": self.structure.specification,
            "dynamics": self.structure.dynamics,
            "friction": self.structure.friction,
            "offset": self.structure.offset,
            "units": {"effort": self.units.effort, "field": self.units.field, "slip": self.units.slip},
            "reference": {
                "field": self.reference.field,
                "slip": self.reference.slip,
                "period_s": self.reference.period,
            },
            "shape": dict(self.shape),
            "gains": dict(self.gains),
            "trained_on": {
                "field": list(self.trained_on.field),
                "slip": list(self.trained_on.slip),
                "effort": list(self.trained_on.effort),
            },
            "about": dict(self.about),
        }
        return {**body, "digest": digest_of(body)}


def digest_of(body: Mapping[str, Any]) -> str:
    """SHA-256 of a JSON body, independent of the order of its keys."""
    text = json.dumps(body, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def require_schema(
    found: Any,
    known: int,
    where: str,
    *,
    error: type[ErclutchError] = RunError,
    older: str = "Fit the log again with this version",
) -> None:
    """Refuse a file of another schema: a newer one wants this program updated, an older one the file made again.

    Args:
        found: the file's schema.
        known: the one that is read.
        where: the file.
        error: what is raised.
        older: what to do about a file of an older schema.

    Raises:
        ErclutchError: it is another one; of the class ``error``.
    """
    if found == known and not isinstance(found, bool):
        return
    newer = isinstance(found, int) and found > known
    raise error(
        f"schema {found!r}{', of a newer version of erclutch' if newer else ''}; this version reads schema {known}",
        where=where,
        remedy="Update erclutch: pip install --upgrade erclutch" if newer else older,
    )


def model_from_dict(body: Mapping[str, Any], where: str = "model") -> TorqueModel:
    """The model that `TorqueModel.to_dict` wrote.

    Raises:
        RunError: another schema, a missing or unfitting entry, or numbers that do not match the digest.
    """
    if body.get("kind") != "erclutch torque model":
        raise RunError(
            f"this is no model but {body.get('kind')!r}",
            where=where,
            remedy="Give a file of the models folder of a run",
        )
    require_schema(body.get("schema"), SCHEMA, where)
    content = {key: value for key, value in body.items() if key != "digest"}
    try:
        if digest_of(content) != body.get("digest"):
            raise RunError(
                "the numbers do not match their digest", where=where, remedy="Restore the file, or fit again"
            )
        return _model_from(body)
    except RunError:
        raise
    except (ErclutchError, AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
        raise RunError(f"unfit entry: {error}", where=where, remedy="Restore the file, or fit again") from error


def _model_from(body: Mapping[str, Any]) -> TorqueModel:
    device = cast(DeviceName, body["device"])
    if device not in DEVICES or body["dynamics"] not in ("none", "lag", "rise-fall"):
        raise ValueError(f"device {device!r} with dynamics {body['dynamics']!r}")
    structure = Structure(
        device,
        str(body["law"]),
        law_from_name(str(body["law"]), device),
        body["dynamics"],
        bool(body["friction"]),
        bool(body["offset"]),
    )
    for key in ("friction", "offset"):
        if not isinstance(body[key], bool):
            raise ValueError(f"{key} is {body[key]!r}")
    reference = Reference(*(float(body["reference"][key]) for key in ("field", "slip", "period_s")))
    if not min(reference.field, reference.slip, reference.period) > 0:
        raise ValueError(f"{reference}")
    shape_names = [s.name for s in structure.shapes(reference.period)]
    gain_names = [g.name for g in structure.gains()]
    for shape in structure.shapes(reference.period):
        if not shape.lower <= float(body["shape"][shape.name]) <= shape.upper:
            raise ValueError(f"{shape.name} is {body['shape'][shape.name]}")
    if not all(isinstance(unit, str) for unit in body["units"].values()):
        raise ValueError(f"units are {body['units']}")
    trained = body["trained_on"]
    pair = {key: (float(trained[key][0]), float(trained[key][1])) for key in ("field", "slip", "effort")}
    return TorqueModel(
        structure=structure,
        reference=reference,
        shape={name: float(body["shape"][name]) for name in shape_names},
        gains={name: float(body["gains"][name]) for name in gain_names},
        units=Units(body["units"]["effort"], body["units"]["field"], body["units"]["slip"]),
        trained_on=Range(pair["field"], pair["slip"], pair["effort"]),
        about={str(key): str(value) for key, value in body["about"].items()},
    )
