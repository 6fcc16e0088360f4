"""Flow curves show settled effort against slip at several fields, or against the field at several slips.

Each model is a curve, the data beside it are dots.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from erclutch.models.model import Model
from erclutch.report.numbers.correlation import period_of
from erclutch.report.numbers.model_stages import is_law, specification_of
from erclutch.report.numbers.switching import step_response
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array, largest_of_windows

Rows = NDArray[np.intp]

_LEVELS = 5  # curves, where a log has many fields
_CURVE = 81  # points of a curve
_DOTS = 160  # dots near a curve, at most
_RARE = 0.005  # share of all rows below which a field is rare
_PARTS = 12  # into which the range of slips is parted
_SHOWN = 8  # of these parts, that have dots of a curve
_BINS = 40  # into which the range of fields is parted
_DWELT = 0.01  # share of all rows from which a log dwells in a bin
_WHOLE = 0.95  # share of all rows that must lie in such bins


@dataclass(frozen=True)
class FlowCurves:
    """One law on one element.

    Attributes:
        model: its name in the run.
        element: its number, from 0.
        fields: of the curves, shape (k,).
        slip: shape (n,).
        effort: of the law in the settled field, shape (k, n).
        dots: measured (slip, effort) near each field, each (m, 2); for a pair less the law's effort of the other
            clutch.
        alike: the same of laws that `grouped` found alike.
    """

    model: str
    element: int
    fields: Array
    slip: Array
    effort: Array
    dots: tuple[Array, ...]
    alike: tuple[FlowCurves, ...] = ()

    #: Names of the columns of `rows`.
    HEADER: ClassVar = ("model", "element", "field", "slip", "effort")

    def rows(self) -> Iterator[tuple[object, ...]]:
        """A row of a table for each point of each curve; elements are numbered from 1."""
        for field, efforts in zip(self.fields, self.effort, strict=True):
            for slip, effort in zip(self.slip, efforts, strict=True):
                numbers = float(field), float(slip), float(effort)
                yield self.model, self.element + 1, *numbers


@dataclass(frozen=True)
class FieldCurves:
    """Effort of one model over the field of one element, at a few slips.

    Attributes:
        element: its number, from 0.
        slips: of the curves, shape (k,).
        field: magnitude, shape (n,).
        effort: in the settled field, shape (k, n).
        dots: measured (field, effort) near each slip, each (m, 2), as of `FlowCurves`.
    """

    element: int
    slips: Array
    field: Array
    effort: Array
    dots: tuple[Array, ...]


def law_names(body: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the laws of a run, each with its best stages, best first."""
    best: dict[str, str] = {}
    for entry in body["ranking"]:
        if is_law(entry):
            law = specification_of(entry).partition("+")[0]
            best.setdefault(law, entry["name"])
    return tuple(best.values())


def flow_curves(
    rows: RunRows,
    models: Mapping[str, Model],
    element: int = 0,
    wait: int | None = None,
) -> list[FlowCurves]:
    """Curves of models on one element and the rows near them.

    Args:
        rows: of the run.
        models: of the run, by the names that they have there.
        element: its number, from 0.
        wait: rows that the field must have stayed before a row is a dot; the curves are then at the fields at which the
            log dwells, where there are such. None: until the model's field has settled; curves all over the range.
    """
    own = rows.data.elements[element]
    strength = np.abs(own.field)
    levels = _levels(strength) if wait is None else _met(strength)
    first = float(np.quantile(own.slip, 0.0005))
    last = float(np.quantile(own.slip, 0.9995))
    inside = (own.slip >= first) & (own.slip <= last)

    # Points of a curve lie closer together near zero, where laws turn.
    reach = max(abs(first), abs(last)) or 1.0
    start = float(np.arcsinh(first / reach * np.sinh(3.0)))
    end = float(np.arcsinh(last / reach * np.sinh(3.0)))
    even: Array = np.linspace(start, end, _CURVE)
    slip: Array = reach * np.sinh(even) / np.sinh(3.0)

    # Rows of the dots at each level, by the rows in which a field settles.
    dots_after: dict[int, list[Rows]] = {}
    curves: list[FlowCurves] = []
    for name, model in models.items():
        settling = _settling(rows, model) if wait is None else wait
        if settling not in dots_after:
            near = _near(rows, settling, element, levels)
            dots_after[settling] = [_spread(own.slip, mask & inside) for mask in near]
        efforts: list[Array] = []
        for level in levels.tolist():
            field = np.full(slip.size, level, np.float64)
            efforts.append(_alone(model, element, field, slip))
        dots: list[Array] = []
        for near_level in dots_after[settling]:
            measured = rows.data.effort[near_level] - _others(rows, model, element, near_level)
            dots.append(np.column_stack([own.slip[near_level], measured]))
        curve = FlowCurves(
            name,
            element,
            fields=levels,
            slip=slip,
            effort=np.array(efforts),
            dots=tuple(dots),
        )
        curves.append(curve)
    return curves


def waited(rows: RunRows, model: Model, element: int = 0) -> int:
    """Rows that the field must have stayed before a row is a dot: until the model's field has settled, or less.

    A field that switches all the time never settles. Then the longest wait is taken that leaves dots over most of the
    slips.
    """
    own = rows.data.elements[element]
    levels = _met(np.abs(own.field))
    low = float(np.quantile(own.slip, 0.01))
    high = float(np.quantile(own.slip, 0.99))
    parts = np.linspace(low, high, _PARTS + 1)

    def shown(wait: int) -> float:
        """Parts of the range of slips with a dot, of the middle one of all curves."""
        of_curves: list[int] = []
        for near in _near(rows, wait, element, levels):
            dots, _ = np.histogram(own.slip[near], parts)
            of_curves.append(int(np.count_nonzero(dots)))
        return float(np.median(of_curves))

    wait = _settling(rows, model)
    while wait > 1 and low < high and shown(wait) < _SHOWN:
        wait //= 2
    return wait


def field_curves(
    rows: RunRows,
    model: Model,
    element: int,
    wait: int,
) -> FieldCurves:
    """Curves of a model over the field of one element, and rows near their slips whose field has stayed for a wait."""
    own = rows.data.elements[element]
    strength = np.abs(own.field)
    first = float(np.quantile(own.slip, 0.01))
    last = float(np.quantile(own.slip, 0.99))
    slips = np.linspace(first, last, _LEVELS)
    field = np.linspace(float(strength.min()), float(strength.max()), _CURVE)
    settled, _ = _settled(rows, wait, element)
    reach = 0.1 * float(np.diff(slips).min()) if first < last else np.inf
    efforts: list[Array] = []
    dots: list[Array] = []
    for slip in slips.tolist():
        slips_there = np.full(field.size, slip)
        efforts.append(_alone(model, element, field, slips_there))
        is_near = np.abs(own.slip - slip) <= reach
        near = _spread(strength, settled & is_near)
        measured = rows.data.effort[near] - _others(rows, model, element, near)
        dots.append(np.column_stack([strength[near], measured]))
    return FieldCurves(
        element,
        slips,
        field,
        effort=np.array(efforts),
        dots=tuple(dots),
    )


def dwelled_fields(strength: Array) -> Array:
    """The few fields at which nearly all rows are, shape (k,); empty where the field takes many values."""
    low = float(strength.min())
    high = float(strength.max())
    if low == high:
        return np.array([low])
    places = (_BINS * (strength - low) / (high - low)).astype(np.intp)
    bins = np.minimum(places, _BINS - 1)  # of each row
    share = np.bincount(bins, minlength=_BINS) / strength.size
    dwelt = np.flatnonzero(share >= _DWELT)
    ends = np.flatnonzero(np.diff(dwelt) > 1) + 1
    groups = np.split(dwelt, ends)  # bins side by side
    nearly_all = share[dwelt].sum() >= _WHOLE
    narrow = max(map(len, groups)) <= 2  # a field at an edge of two bins has rows in both
    if not dwelt.size or len(groups) > _LEVELS + 2 or not nearly_all or not narrow:
        return np.zeros(0)
    fields: list[float] = []
    for group in groups:
        of_group = (bins >= group[0]) & (bins <= group[-1])
        fields.append(float(np.median(strength[of_group])))
    return np.array(fields)


def rare_fields(rows: RunRows, element: int) -> Array:
    """Fields of the curves of an element near which the log has hardly any rows, settled or not, shape (k,)."""
    strength = np.abs(rows.data.elements[element].field)
    levels = _levels(strength)
    shares = [near.mean() for near in _near(rows, 1, element, levels)]
    rare = [bool(share < _RARE) for share in shares]
    return levels[rare]


def grouped(
    curves: Sequence[Sequence[FlowCurves]], apart: float
) -> tuple[tuple[FlowCurves, ...], ...]:
    """Laws whose curves are nowhere further apart than that stand under the first of them, on all elements alike.

    Args:
        curves: of each element, of each law in the same order.
        apart: an effort.
    """

    def alike(one: int, other: int) -> bool:
        for laws in curves:
            difference = laws[one].effort - laws[other].effort
            if not np.max(np.abs(difference)) <= apart:
                return False
        return True

    alike_to: dict[int, list[int]] = {}  # places of further laws, by the place of the first
    for law in range(len(curves[0])):
        first = next((known for known in alike_to if alike(known, law)), None)
        if first is None:
            alike_to[law] = []
        else:
            alike_to[first].append(law)

    of_elements: list[tuple[FlowCurves, ...]] = []
    for laws in curves:
        drawn: list[FlowCurves] = []
        for first, further in alike_to.items():
            laws_like_it = tuple(laws[place] for place in further)
            drawn.append(replace(laws[first], alike=laws_like_it))
        of_elements.append(tuple(drawn))
    return tuple(of_elements)


def _alone(
    model: Model,
    element: int,
    field: Array,
    slip: Array,
) -> Array:
    """Effort of the device with one element moving under field and the others at rest without."""
    nothing = np.zeros(slip.size)
    count = 1 if model.structure.device == "single" else 2
    fields = [field if i == element else nothing for i in range(count)]
    slips = [slip if i == element else nothing for i in range(count)]
    return _steady(model, fields, slips)


def _others(
    rows: RunRows,
    model: Model,
    element: int,
    at: Rows,
) -> Array:
    """Effort that the law gives the other elements, without field, at the slips that they had in some rows."""
    nothing = np.zeros(at.size)
    if model.structure.device == "single" or not at.size:
        return nothing
    slips: list[Array] = []
    for number, other in enumerate(rows.data.elements):
        slips.append(nothing if number == element else other.slip[at])
    return _steady(model, [nothing] * len(slips), slips)


def _steady(model: Model, fields: Sequence[Array], slips: Sequence[Array]) -> Array:
    """Effort at rest with further inputs, such as a temperature, in the middle of their ranges."""
    rows = slips[0].size
    middles = [0.5 * (low + high) for low, high in model.extras.values()]
    extras = [np.full(rows, middle) for middle in middles]
    return model.steady(fields, slips, extras)


def _levels(strength: Array) -> Array:
    """All fields of a log that has few, else some evenly over its range, shape (k,)."""
    few: Array = np.unique(strength)
    if few.size <= _LEVELS + 2:
        return few
    return np.linspace(0.0, float(np.quantile(strength, 0.98)), _LEVELS)


def _met(strength: Array) -> Array:
    """The fields at which the log dwells, else some over its range."""
    dwelled = dwelled_fields(strength)
    return dwelled if dwelled.size > 1 else _levels(strength)


def _near(
    rows: RunRows,
    settling: int,
    element: int,
    levels: Array,
) -> list[NDArray[np.bool_]]:
    """Rows whose field is near each level and has been there long enough for the lag to be over."""
    strength = np.abs(rows.data.elements[element].field)
    settled, slack = _settled(rows, settling, element, levels)
    return [settled & (np.abs(strength - level) <= slack) for level in levels]


def _settled(
    rows: RunRows,
    settling: int,
    element: int,
    levels: Array | None = None,
) -> tuple[NDArray[np.bool_], float]:
    """Rows whose field has stayed where it is for so many rows, the other elements without field; how near that is."""
    fields = [np.abs(each.field) for each in rows.data.elements]
    largest = max(float(field.max()) for field in fields) or 1.0
    slack = 0.04 * largest
    if levels is not None and levels.size > 1:
        narrowest = float(np.diff(levels).min())
        slack = min(slack, 0.3 * narrowest)
    settled = rows_at_rest(fields[element], settling, 2.0 * slack)
    for i, other in enumerate(fields):
        if i != element:
            settled &= other <= slack
    return settled, slack


def _settling(rows: RunRows, model: Model) -> int:
    """Rows after which the model's field has settled, and the lag of the effort is over."""
    response = step_response({"name": model.name, "dynamics": model.times}, ("command", "effort"))
    if response is None:
        return 1
    settled_rows = response.settled / period_of(rows)
    return int(np.clip(settled_rows, 1, rows.data.rows // 4))


def rows_at_rest(field: Array, back: int, reach: float) -> NDArray[np.bool_]:
    """Rows before which the field has stayed within a reach for some rows."""
    if back <= 1:
        return np.ones(field.size, np.bool_)
    still = np.zeros(field.size, np.bool_)
    highest, lowest = largest_of_windows(field, back), -largest_of_windows(-field, back)
    still[back - 1 :] = highest - lowest <= reach  # a window ends with its row
    return still


def _spread(values: Array, mask: NDArray[np.bool_]) -> Rows:
    """Some rows of a mask, evenly over their values, not over time: most rows lie near zero."""
    inside = np.flatnonzero(mask)
    if inside.size <= _DOTS:
        return inside
    order = inside[np.argsort(values[inside], kind="stable")]
    rising = values[order]
    targets = np.linspace(float(rising[0]), float(rising[-1]), _DOTS)
    places = np.searchsorted(rising, targets)
    return np.unique(order[np.clip(places, 0, order.size - 1)])
