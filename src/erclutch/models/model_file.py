"""All saved models share a schema, a digest, and entries that are looked at before a number is computed.

A digest tells damage, not intent: whoever writes a file can write its digest. So every text has a grammar, and every
number a range in which all further arithmetic stays finite.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np

from erclutch.errors import ErclutchError, PluginError, RunError
from erclutch.models.band import MOST_EDGES, MOST_FIELD_EDGES, Band
from erclutch.models.haste import Haste
from erclutch.models.model import CELLS, Pair, Range
from erclutch.models.plugin_efforts import ENTRY, require_same_efforts
from erclutch.registry import require
from erclutch.signals.array import Array
from erclutch.signals.device import DEVICES, WAYS_OF, DeviceName, Units
from erclutch.signals.units import is_written_well

SCHEMA = 1
#: Of a sampling period in s.
LONGEST_PERIOD = 10.0
_REMEDY = "Restore the file, or fit again"
# Sums, products and squares of numbers within these stay finite.
_LARGEST = 1e18
SMALLEST = 1e-18
_LONGEST_TEXT = 1000  # characters
_SPECIFICATION = re.compile(r"[\w.+/ -]{1,200}", re.ASCII)
#: Entries that a model may write in other words: a stage may have several names, and another version of a plug-in may
#: be installed than the file was written with.
_IN_OTHER_WORDS = ("digest", "dynamics", ENTRY, "form", "law", "network", "plugins")

#: What an entry of the wrong type, size or name ends in.
UNFIT = (
    ErclutchError,
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    RecursionError,
)

M = TypeVar("M")


def digest_of(body: Mapping[str, Any]) -> str:
    """SHA-256 of a JSON body, independent of the order of its keys."""
    text = json.dumps(
        body,
        sort_keys=True,
        separators=(",", ":"),
        allow_nan=False,
    )
    return hashlib.sha256(text.encode()).hexdigest()


def sealed(body: Mapping[str, Any], band: Band | None) -> dict[str, Any]:
    """The body of a model's file with its band, if it has one, and the digest of all."""
    whole = dict(body)
    if band is not None:
        whole["band"] = band.to_dict()
    return {**whole, "digest": digest_of(_told(whole))}


def keeps_digest(body: Mapping[str, Any]) -> bool:
    """Whether a body holds the digest of its other entries; entries without a digest (NaN, lists without end) fail."""
    try:
        digest = digest_of(_told(body))
    except (ValueError, RecursionError):
        return False
    return digest == body.get("digest")


def _told(body: Mapping[str, Any]) -> dict[str, Any]:
    """What the digest is over. Efforts are compared by themselves, and the same model may stand without them."""
    return {key: value for key, value in body.items() if key not in ("digest", ENTRY)}


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
    whose = ""
    remedy = older
    if isinstance(found, int) and found > known:
        whose = ", of a newer version of erclutch"
        remedy = "Update erclutch: pip install --upgrade erclutch"
    raise error(
        f"schema {found!r:.40}{whose}; this version reads schema {known}",
        where=where,
        remedy=remedy,
    )


def read_model(
    body: Mapping[str, Any],
    kind: str,
    where: str,
    make: Callable[[Mapping[str, Any]], M],
) -> M:
    """A model from the body of its file.

    Args:
        body: as its ``to_dict`` wrote it.
        kind: what the body must say that it is.
        where: the file.
        make: makes the model, and raises what Python raises where an entry does not fit.

    Raises:
        RunError: another kind or schema, a digest that does not match, an entry that is missing or does not fit.
        PluginError: the model needs a plug-in that is not there.
    """
    if body.get("kind") != kind:
        raise RunError(
            f"this is no model but {body.get('kind')!r:.60}",
            where=where,
            remedy="Give a model of a run",
        )
    require_schema(body.get("schema"), SCHEMA, where)
    require(body.get("plugins", []), where)
    if not keeps_digest(body):
        raise RunError("the numbers do not match their digest", where=where, remedy=_REMEDY)
    try:
        model: Any = make(body)
        if body.get("band") is not None:
            model = replace(model, band=band_of(body["band"]))
        taken = model.to_dict()
        require_same_efforts(body, taken, where)
        _require_taken(dict(body), taken)
        return model
    except (PluginError, RunError):
        raise
    except UNFIT as error:
        reason = f"no {error}" if isinstance(error, KeyError) else str(error)
        raise RunError(f"unfit entry: {reason:.200}", where=where, remedy=_REMEDY) from error


def _require_taken(entry: Any, taken: Any, name: str = "") -> None:
    """That a model took up all that its file says, entry by entry.

    What nobody takes up would be ignored in silence: a gain of a newer version, an entry whose name was changed.

    Raises:
        ValueError: an entry is not in the model, or is another there.
    """
    if isinstance(entry, dict) and isinstance(taken, dict):
        of_model = cast("dict[str, Any]", taken)
        for key, value in cast("dict[str, Any]", entry).items():
            if key in _IN_OTHER_WORDS and not isinstance(value, dict):
                continue
            path = f"{name}.{key}" if name else key
            if key not in of_model:
                raise ValueError(f"{path!r:.100} is {value!r:.40}, and no such entry is read")
            _require_taken(value, of_model[key], path)
    elif entry != taken:
        raise ValueError(f"{name} is {entry!r:.40}, and is read as {taken!r:.40}")


# --- entries: each raises ValueError with the entry's name and value -------------------------------------------------


def number_of(value: Any, name: str, *, positive: bool = False) -> float:
    """A saved number; a truth, a text, an infinite, far too large or (if positive) too small number is none."""
    low = SMALLEST if positive else -_LARGEST
    # True is an int to Python.
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not low <= value <= _LARGEST:
        raise ValueError(f"{name} is {value!r:.40}, not a number from {low:g} to {_LARGEST:g}")
    return float(value)


def whole_number_of(value: Any, name: str) -> int:
    """A saved whole number."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"{name} is {value!r:.40}, not a whole number")
    return value


def truth_of(value: Any, name: str) -> bool:
    """A saved yes or no."""
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r:.40}, not true or false")
    return value


def table_of(value: Any, name: str, *shape: int, positive: bool = False) -> Array:
    """A saved table of numbers of a shape."""

    def part(value: Any, shape: Sequence[int]) -> Any:
        if not shape:
            return number_of(value, name, positive=positive)
        if not isinstance(value, list) or len(cast(list[Any], value)) != shape[0]:
            raise ValueError(f"{name} is {value!r:.40}, not a table of {shape[0]}")
        return [part(entry, shape[1:]) for entry in cast(list[Any], value)]

    return np.array(part(value, shape), np.float64)


def pair_of(value: Any, name: str) -> Pair:
    """A saved range, the smaller number first."""
    low, high = table_of(value, name, 2).tolist()
    if math.copysign(1.0, high - low) < 0:  # also 0 .. -0
        raise ValueError(f"{name} is {low:g} .. {high:g}")
    return low, high


def name_of(value: Any, name: str) -> str:
    """A saved name, such as a column's: a line of characters that can be seen."""
    if not (isinstance(value, str) and 0 < len(value) <= _LONGEST_TEXT and value.isprintable()):
        raise ValueError(
            f"{name} is {value!r:.60}, not a line of up to {_LONGEST_TEXT} characters that can be seen"
        )
    return value


def names_of(values: Any, name: str) -> tuple[str, ...]:
    """Saved names that differ."""
    names = tuple(name_of(value, name) for value in values)
    if len(set(names)) < len(names):
        raise ValueError(f"{name} are {names!r:.60}, two of them the same")
    return names


def specification_of(value: Any, name: str) -> str:
    """A saved specification of a law, a network or stages."""
    if not (isinstance(value, str) and _SPECIFICATION.fullmatch(value)):
        raise ValueError(f"{name} is {value!r:.60}")
    return value


def device_of(body: Mapping[str, Any]) -> DeviceName:
    """The device of a model."""
    if body["device"] not in DEVICES:
        raise ValueError(f"device is {body['device']!r:.40}")
    return body["device"]


def units_of(body: Mapping[str, Any]) -> Units:
    """The units of a model's effort, field and slip."""
    return Units(*(unit_of(body["units"][key]) for key in ("effort", "field", "slip")))


def unit_of(unit: Any) -> str:
    """A unit in the form of units."""
    if not (isinstance(unit, str) and is_written_well(unit)):
        raise ValueError(f"a unit is {unit!r:.60}")
    return unit


def range_of(body: Mapping[str, Any]) -> Range:
    """What a model was trained on."""
    entry = body["trained_on"]
    near = near_of(entry.get("near", ()), body["device"])
    return Range(
        field=pair_of(entry["field"], "range of field"),
        slip=pair_of(entry["slip"], "range of slip"),
        effort=pair_of(entry["effort"], "range of effort"),
        near=near,
    )


def near_of(values: Any, device: DeviceName) -> tuple[tuple[int, ...], ...]:
    """The cells near training rows of each element; none where that is not known."""
    near: list[tuple[int, ...]] = []
    for masks_of_element in values:
        masks = tuple(whole_number_of(value, "a row of cells") for value in masks_of_element)
        in_range = all(0 <= mask < 1 << CELLS for mask in masks)
        if len(masks) != CELLS or not in_range:
            raise ValueError(f"cells near training rows are {masks!r:.60}")
        near.append(masks)
    if near and len(near) != len(WAYS_OF[device]):
        raise ValueError(f"cells near training rows for {len(near)} elements")
    return tuple(near)


def band_of(body: Mapping[str, Any]) -> Band:
    """The band of a model."""
    level = number_of(body["level"], "level", positive=True)
    if level >= 1.0:
        raise ValueError(f"level is {level:g}, not below 1")
    empty = Band(
        level=level,
        settling_s=number_of(body["settling_s"], "settling_s", positive=True),
        threshold=number_of(body["threshold"], "threshold", positive=True),
        field=pair_of(body["field"], "the band's field"),
        slip=pair_of(body["slip"], "the band's slip"),
        field_edges=_edges_of(body["field_edges"], "field_edges", MOST_FIELD_EDGES),
        slip_edges=_edges_of(body["slip_edges"], "slip_edges"),
        behind=(),
        ahead=(),
    )
    cells = math.prod(empty.shape)
    behind = tuple(table_of(body["behind"], "behind", cells).tolist())
    ahead = tuple(table_of(body["ahead"], "ahead", cells).tolist())
    narrowest = min(*behind, *ahead)
    if narrowest < 0.0:
        raise ValueError(f"a half width is {narrowest:g}")
    haste: Haste | None = None
    growing = body.get("haste")
    if growing is not None:
        haste = Haste(
            lag_s=number_of(growing["lag_s"], "lag_s", positive=True),
            mean_s=number_of(growing["mean_s"], "mean_s", positive=True),
            known=number_of(growing["known"], "known", positive=True),
            quickest=number_of(growing["quickest"], "quickest"),
            growth=number_of(growing["growth"], "growth"),
            smooth_s=number_of(growing.get("smooth_s", 0.0), "smooth_s"),
        )
        if haste.quickest < 1.0 or haste.growth < 0.0:
            raise ValueError(f"a band grows with haste by {haste.quickest:g} and {haste.growth:g}")
        if haste.smooth_s < 0.0:
            raise ValueError(f"the slip is smoothed over {haste.smooth_s:g} s")
    part = None if body.get("part") is None else number_of(body["part"], "part", positive=True)
    return replace(
        empty,
        behind=behind,
        ahead=ahead,
        haste=haste,
        part=part,
    )


def _edges_of(value: Any, name: str, most: int = MOST_EDGES) -> tuple[float, ...]:
    """Saved edges of a band: few, positive and ascending."""
    if not isinstance(value, list) or len(cast(list[Any], value)) > most:
        raise ValueError(f"{name} is {value!r:.40}, not a table of up to {most}")
    edges = [number_of(edge, name, positive=True) for edge in cast(list[Any], value)]
    if edges != sorted(set(edges)):
        raise ValueError(f"{name} are {tuple(edges)!r:.60}, not ascending")
    return tuple(edges)


def about_of(body: Mapping[str, Any]) -> dict[str, str]:
    """Remarks on a model by name."""
    about = cast(dict[Any, Any], body["about"])
    return {name_of(key, "a remark"): name_of(text, str(key)) for key, text in about.items()}
