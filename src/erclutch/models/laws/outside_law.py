"""A law of another package is checked before it is used, and the package is named where the law fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import Dual
from erclutch.models.laws.law import Columns, Dimension, Gain, Law, LawFamily, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP
from erclutch.registry import Plugin

#: Where a law is tried: without field, in the middle, at the reference; moving either way and at rest.
_FIELDS = np.array([0.0, 0.5, 1.0, 1.0])
_SLIPS = np.array([0.0, -1.0, 1.0, 0.0])
# A law that changes what it is given changes the log's own rows: here it fails.
_FIELDS.setflags(write=False)
_SLIPS.setflags(write=False)


#: Characters of a text by which a law, a stage or a number is called; that tells more of it; of all that is said.
LONGEST_TITLE, LONGEST_LINE, LONGEST_TEXT = 100, 1000, 10_000


def checked(law: Any, plugin: Plugin) -> Law:
    """The law with its plug-in, its functions guarded: whatever they raise names the plug-in.

    Raises:
        PluginError: it is no law, calls itself otherwise than its entry point, or its columns are not what it says.
    """
    if not isinstance(law, Law):
        raise plugin.fault(
            f"gives a {type(law).__name__}, it must be a Law of erclutch.models.laws.law"
        )
    if law.name != plugin.name and law.name.rpartition("-")[0] != plugin.name:
        raise plugin.fault(
            f"calls itself {law.name!r}; its Law.name and its entry point must agree"
        )
    if law.shape[:1] != (TRANSITION_SLIP,):
        raise plugin.fault(
            "must have TRANSITION_SLIP of erclutch.models.laws.smooth as its first shape parameter"
        )
    require_law(law, plugin)
    own = replace(
        law,
        columns=_looked_at(law, plugin),
        stimulus=None if law.stimulus is None else plugin.guarded(law.stimulus),
        paper_form=None if law.paper_form is None else _published(law.paper_form, plugin),
        plugin=plugin,
    )
    # The law is tried out: its columns must be what its gains say.
    names = [number.name for number in (*own.stimulus_shape, *own.shape, *own.gains)]
    if len(set(names)) < len(names):
        raise plugin.fault(f"has two parameters of one name: {', '.join(names)}")
    field = _FIELDS
    if own.stimulus is not None:
        field = own.stimulus(_FIELDS, *map(typical, own.stimulus_shape))
        if isinstance(field, np.ndarray):
            field.setflags(write=False)
    shape = [typical(number) for number in own.shape]
    columns = own.columns(field, _SLIPS, *shape)
    if not np.array_equal(columns, own.columns(field, _SLIPS, *shape)):
        raise plugin.fault("returns other numbers for the same rows when it is asked again")
    # Derivatives run through the same function.
    own.columns(field, _SLIPS, *(Dual(x, {place: 1.0}) for place, x in enumerate(shape)))
    return own


def _looked_at(law: Law, plugin: Plugin) -> Columns:
    """The columns of a law, each looked at whenever rows are asked for: many rows meet what a few do not."""
    guarded = plugin.guarded(law.columns)

    def columns(E: Any, w: Any, *shape: Any) -> tuple[Any, ...]:
        given: Any = guarded(_only_read(E), _only_read(w), *map(_only_read, shape))
        said = type(given).__name__
        if type(given) is tuple:
            count = len(cast("tuple[Any, ...]", given))
            said = f"{count} columns"
        if said != f"{len(law.gains)} columns":
            gains = ", ".join(gain.name for gain in law.gains)
            raise plugin.fault(
                f"must return a tuple with a column for each of its gains ({gains}), it returns {said}"
            )
        shape_of_rows = rows_of(w)
        if shape_of_rows:
            for gain, column in zip(law.gains, cast("tuple[Any, ...]", given), strict=True):
                require_rows(column, shape_of_rows, f"for the gain {gain.name}", plugin)
        return cast("tuple[Any, ...]", given)

    return columns


def _only_read(signal: Any) -> Any:
    """What a law is given: the rows are the log's own, or those of another law's turn."""
    if isinstance(signal, Dual):
        partials = {place: _only_read(partial) for place, partial in signal.partials.items()}
        return Dual(_only_read(signal.value), partials)
    if not isinstance(signal, np.ndarray):
        return signal
    rows = cast("NDArray[Any]", signal).view()
    rows.setflags(write=False)
    return rows


def _published(
    paper_form: Callable[..., dict[str, float]], plugin: Plugin
) -> Callable[..., dict[str, float]]:
    """The published symbols of a law, if they are numbers by name."""
    guarded = plugin.guarded(paper_form)

    def published(*given: Any) -> dict[str, float]:
        symbols: Any = guarded(*given)
        entries = cast("dict[Any, Any]", symbols) if isinstance(symbols, dict) else {0: 0}
        numbers: dict[str, float] = {}
        for name, value in entries.items():
            if not isinstance(name, str) or not isinstance(value, int | float | np.number):
                raise plugin.fault(
                    f"gives {symbols!r:.60} as its published numbers; these are a dict of floats by name"
                )
            numbers[name] = float(cast(float, value))
        return numbers

    return published


def rows_of(signal: Any) -> tuple[int, ...]:
    """The shape of a signal over rows, an array or a dual; () of what is computed a row at a time, or of symbols."""
    values: object = getattr(signal, "value", signal)
    return cast("NDArray[Any]", values).shape if isinstance(values, np.ndarray) else ()


def require_rows(given: Any, shape: tuple[int, ...], what: str, plugin: Plugin) -> None:
    """Refuse an answer that is no finite array of the rows; of a `Dual` the derivatives are looked at, too.

    Args:
        given: the answer.
        shape: that it must have.
        what: it is, for example "for the gain eta".
        plugin: that gave it.

    Raises:
        PluginError: what is wrong.
    """
    values = given.value if isinstance(given, Dual) else given
    if np.asarray(values).dtype.kind == "O":
        remedy = "operators and NumPy's functions alone, and not np.asarray, np.array or float"
        raise plugin.fault(f"loses the derivatives {what}: it may use {remedy}")
    if np.shape(values) != shape or np.asarray(values).dtype.kind not in "fiu":
        raise plugin.fault(
            f"returns {what} what is no finite array of the rows, of shape {shape}: {values!s:.80}"
        )
    partials = given.partials.values() if isinstance(given, Dual) else ()
    for numbers in (values, *partials):
        wrong = np.size(numbers) - np.count_nonzero(np.isfinite(numbers))
        if wrong:
            raise plugin.fault(
                f"returns {what} what is no finite array of the rows: {wrong} of {np.size(numbers)} "
                "numbers are infinite or none"
            )


def typical(shape: ShapeParameter) -> float:
    """A number from the middle of the usual range of a parameter."""
    low, high = shape.scanned
    if shape.scale == "log":
        return float(np.sqrt(low * high))
    return 0.5 * (low + high)


def require_family(family: LawFamily, plugin: Plugin) -> None:
    """Refuse what a package brings as a law where a part is of a wrong type.

    Raises:
        PluginError: a part, and what it must be.
    """

    def is_text(value: object) -> bool:
        return isinstance(value, str) and is_line("".join(value.split()), LONGEST_TEXT)

    def is_count(value: object) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and value >= 0

    def is_ladder(value: object) -> bool:
        entries = cast("dict[object, object]", value) if isinstance(value, dict) else {0: 0}
        return all(is_text(name) and is_count(place) for name, place in entries.items())

    def are_texts(value: object) -> bool:
        return isinstance(value, tuple | list) and all(map(is_text, cast("list[object]", value)))

    fits = {
        "law": isinstance(family.law, Law) or callable(family.law),
        "formula": is_text(family.formula),
        "about": is_text(family.about),
        "curves": is_text(family.curves),
        "ladder": is_ladder(family.ladder),
        "aliases": are_texts(family.aliases),
        "count": family.count is None or is_count(family.count),
    }
    for name, right in fits.items():
        if not right:
            given = getattr(family, name)
            raise plugin.fault(
                f"has {given!r:.40} as its {name}; see LawFamily for what it must be"
            )


def require_law(law: Law, plugin: Plugin) -> None:
    """Refuse a law whose parts are of wrong types.

    Raises:
        PluginError: a part, and what it must be.
    """
    if not is_line(law.title, LONGEST_TITLE) or not is_line(law.source, LONGEST_LINE):
        raise plugin.fault(
            f"must have a title and a source: lines of up to {LONGEST_TITLE} and {LONGEST_LINE} "
            "characters that can be seen"
        )
    require_parameters((*law.stimulus_shape, *law.shape), plugin)
    gain: Any
    for gain in law.gains:
        known = isinstance(gain, Gain) and _is_described(gain.name, gain.meaning, gain.dimension)
        if not known:
            raise plugin.fault(
                f"has the gain {gain!r:.60}; a Gain has a name, a meaning, a dimension"
            )
        if gain.extra is not None or gain.part not in (None, "yield", "viscous"):
            raise plugin.fault(
                f"has the gain {gain.name} with extra {gain.extra!r:.20} and part {gain.part!r:.20}; extra is "
                "None, for further inputs are added by erclutch, and part is yield, viscous or None"
            )
    for name in ("columns", "stimulus", "paper_form"):
        function = getattr(law, name)
        if not callable(function) and (function is not None or name == "columns"):
            raise plugin.fault(f"has {function!r:.40} as its {name}, which must be a function")


def require_parameters(
    given: tuple[ShapeParameter, ...], plugin: Plugin
) -> tuple[ShapeParameter, ...]:
    """The parameters of a law or stage, if a search can use their names and bounds.

    Raises:
        PluginError: a parameter, and what is wrong with it.
    """
    each: Any
    for each in given:
        if not isinstance(each, ShapeParameter):
            raise plugin.fault(f"has {each!r:.40} as a parameter, it must be a ShapeParameter")
        known = _is_described(each.name, each.meaning, each.dimension)
        if not known or each.scale not in ("linear", "log"):
            needed = "its name is an identifier; it has a meaning, a Dimension and a known scale"
            raise plugin.fault(f"has a parameter {each.name!r:.40}; {needed}")
        bounds: tuple[Any, ...] = ((each.lower, each.upper), each.scanned)
        for low, high in bounds:
            rising = isinstance(low, int | float) and isinstance(high, int | float) and low < high
            finite = rising and np.isfinite([low, high]).all()
            if not finite or (each.scale == "log" and low <= 0.0):
                raise plugin.fault(
                    f"has a parameter {each.name} from {low!r:.20} to {high!r:.20}; bounds are "
                    "finite and rise, and those of a log scale are above 0"
                )
    return given


def _is_described(name: Any, meaning: Any, dimension: Any) -> bool:
    is_name = is_line(name, LONGEST_TITLE) and name.isidentifier()
    return is_name and is_line(meaning, LONGEST_LINE) and isinstance(dimension, Dimension)


def is_line(value: Any, most: int) -> bool:
    """Whether a text of a package may stand in tables and pages: a line that a screen holds, and that hides nothing."""
    return isinstance(value, str) and len(value) <= most and value.isprintable()
