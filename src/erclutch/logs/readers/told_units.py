"""Texts of a file beside its columns may tell their units: by name, in the order of the columns, or in a sentence.

{"units": "s, A, mm/s, kN"}; {"units": ["s", "A", "mm/s", "kN"]}    in the order of the columns
{"v": "mm/s"}; {"units": {"v": "mm/s"}}; {"v_unit": "mm/s"}          by name
{"info": "t in s, v [mm/s], F: force in kN"}                         in a sentence
{"v": {"description": "velocity of the piston [mm/s]"}}              in what is said of a column
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, cast

from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import SINGLE
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.readers.json_columns import NAME, UNIT, text_of
from erclutch.logs.readers.stated_units import column_of_unit
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_DEEPEST = 6  # objects inside of objects
_LONGEST = 4000  # letters of a text
_MOST_NAMES = 500
_MOST_IN_SENTENCES = 100  # columns
_FEWEST_IN_ORDER = 2
_LISTS = re.compile(
    r"(?:.*[^\W_][\W_]*|[\W_]*)(?:units?|einheit(?:en)?|unit[eé]s?|unidad(?:es)?)", re.IGNORECASE
)
#: What a signal without a unit has in a list of units.
_NONE_WRITTEN = frozenset(("", "-", "--", "1", "none", "n/a", "na", "nan", "unitless"))
_SI_UNITS = tuple(
    dict.fromkeys(
        (
            *(unit for signal in SIGNALS.values() for unit in signal.si_units),
            *("s", "m/s^2", "rad/s^2", "W", "Hz", "kg", "Pa*s"),
        )
    )
)
_IN = re.compile(r"(?:^|\s)in\s++(\S++)$")
_IN_BRACKETS = re.compile(r"\s*+[\[(]([^\[\]()]++)[\])]")
_DESCRIBES = re.compile(
    r"desc|descr|description|long_?name|label|title|info|comment|quantity|beschreibung|bezeichnung",
    re.IGNORECASE,
)
_OF_ANOTHER = re.compile(r"[^\s\[\]()]+\s*\[[^\[\]]+\]")
#: A key that is the first part of a sentence: ``v - velocity``, ``x [mm]``, ``t in s``.
_BEGINS_A_SENTENCE = re.compile(r"\s[-–]\s|[\])]$|\sin\s\S{1,20}$")
_QUOTES = str.maketrans(dict.fromkeys("\"'{}", " "))
_ALL_BRACKETS = str.maketrans(dict.fromkeys("\"'{}[]()", " "))


def texts_in(node: Any, above: str = "", depth: int = 0) -> Iterator[tuple[str, str]]:
    """Texts inside of objects by the keys that lead to them; the texts of a list stand in one, behind each other."""
    if isinstance(node, str) and node.lstrip().startswith("{") and len(node) <= _LONGEST:
        with suppress(ValueError, RecursionError):
            yield from texts_in(json.loads(node), above, depth + 1)
    if isinstance(node, str):
        yield above, node
    if isinstance(node, Mapping) and depth < _DEEPEST:
        for key, inner in cast("Mapping[str, Any]", node).items():
            yield from texts_in(inner, f"{above}.{key}" if above else key, depth + 1)
    elif isinstance(node, list | tuple):
        items = cast("Sequence[Any]", node)
        if len(items) > _MOST_NAMES:
            return
        if all(isinstance(item, str) for item in items):
            yield above, "\n".join(items)
        for item in items:  # signals with a name and a unit each
            if not isinstance(item, Mapping):
                continue
            signal = cast("Mapping[str, Any]", item)
            name = text_of(signal, NAME)
            unit = text_of(signal, UNIT)
            if name and unit:
                yield f"{name}_unit", unit


def texts_below(lines: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Lines below the rows as texts with their keys: a bare line of units stands under the key units."""
    for line in lines:
        text = line[:_LONGEST].strip(" \r\n#%")
        key, *rest = re.split("[:=]", text, maxsplit=1)
        if rest and _LISTS.fullmatch(key.strip()):
            yield key.strip(), rest[0]
            continue
        cells = len(re.split(r"[;|\t,]", text))
        bare = bool(_in_order(text, cells))
        yield ("units" if bare else "below"), text


def units_told(
    names: Sequence[str], texts: Iterable[tuple[str, str]]
) -> tuple[dict[str, str], list[str]]:
    """Units of columns that texts tell, by the columns' names, and what to say of lists that fit no columns.

    What is said of one column goes before a list of units, and this before a sentence. Of two units of one name that
    are told in the same way, none is taken.

    Args:
        names: of the columns, in their order.
        texts: with the keys that lead to them, as `texts_in` gives them.
    """
    if not names or len(names) > _MOST_NAMES:
        return {}, []
    of_one_column: dict[str, set[str]] = {}
    in_their_order: dict[str, set[str]] = {}
    in_a_sentence: dict[str, set[str]] = {}
    doubts: list[str] = []
    for key, whole in texts:
        text = whole[:_LONGEST]
        subject = _column_in(key, names)
        last = key.rpartition(".")[2]
        of_column = next((name for name in map(column_of_unit, (last, key)) if name in names), "")
        if _LISTS.fullmatch(last) and not of_column:
            in_order = _in_order(text, len(names))
            if in_order and _fit(names, in_order):
                for name, unit in zip(names, in_order, strict=True):
                    if unit:
                        in_their_order.setdefault(name, set()).add(unit)
            elif in_order:
                doubts.append(
                    f"{key} lists units that do not fit the columns in their order: {text!r:.80}"
                )
        if of_column and units.is_unit(text.strip()):
            of_one_column.setdefault(of_column, set()).add(text.strip())
        elif subject and not of_column:
            unit = _unit_in(text)
            if unit:
                of_one_column.setdefault(subject, set()).add(unit)
        sentence = f"{last}, {text}" if _BEGINS_A_SENTENCE.search(last) else text
        for name, unit in _in_a_sentence(sentence, names):
            in_a_sentence.setdefault(name, set()).add(unit)
    told: dict[str, str] = {}
    for way in (of_one_column, in_their_order, in_a_sentence):
        for name, units_of_name in way.items():
            if len(units_of_name) == 1:
                told.setdefault(name, *units_of_name)
    return told, doubts


def with_told_units(table: Table, texts: Iterable[tuple[str, str]]) -> Table:
    """The table with the units that texts tell, for the columns that have none of their own."""
    told, doubts = units_told([*table.columns], texts)
    new = {name: unit for name, unit in told.items() if not table.units.get(name)}
    if not new and not doubts:
        return table
    notes = [*doubts] if not all(table.units.get(name) for name in table.columns) else []
    if new:
        notes.append(_note(new))
    return replace(table, units={**table.units, **new}, notes=(*table.notes, *notes))


def take_told_units(recording: Found, texts: Iterable[tuple[str, str]]) -> None:
    """Take the units that texts tell, for the columns of a recording that have none of their own."""
    labels = {split_label(label)[0]: label for label in recording.columns}
    told, doubts = units_told([*labels], texts)
    new: dict[str, str | None] = {}
    for name, unit in told.items():
        if labels[name] == name and not recording.units.get(name):
            new[name] = unit
    if new:
        recording.units = {**recording.units, **new}
        recording.notes.append(_note(new))
    if not all(map(recording.units.get, recording.columns)):
        recording.notes += doubts


def _note(told: Mapping[str, str | None]) -> str:
    listed = ", ".join(f"{name} [{unit}]" for name, unit in told.items())
    return f"units that texts of the file tell: {listed}"


def _column_in(key: str, names: Sequence[str]) -> str:
    """The column that a key leads to: ``info.v``, ``v.description``, ``v_description``; "" for another key."""
    above, _, last = key.rpartition(".")
    if last in names:
        return last
    if _DESCRIBES.fullmatch(last):
        name = above.rpartition(".")[2]
        return name if name in names else ""
    name, sign, what = last.rpartition("_")
    return name if sign and _DESCRIBES.fullmatch(what) and name in names else ""


def _in_order(text: str, count: int) -> list[str]:
    """As many units as columns, "" where a column has none; nothing where the text is no such list."""
    plain = text.translate(_ALL_BRACKETS)
    ways = [plain.split(mark) for mark in "\n;|\t," if mark in plain]
    for parts in (*ways, plain.split()):
        cells = [part.strip() for part in parts]
        if len(cells) != count or count < _FEWEST_IN_ORDER:
            continue
        cells = ["" if cell.lower() in _NONE_WRITTEN else cell for cell in cells]
        if any(cells) and all(map(units.is_known_unit, filter(None, cells))):
            return cells
    return []


def _fit(names: Sequence[str], in_order: Sequence[str]) -> bool:
    """Whether no unit of a list is of another kind than what its column is called."""
    for name, unit in zip(names, in_order, strict=True):
        spoken = spoken_name(name)
        if not unit or not units.is_unit(unit):
            continue
        if spoken.is_time:
            wanted: tuple[str, ...] = ("s",)
        else:
            called = [signal for signal in SINGLE if signal in spoken.may_be]
            wanted = tuple(si for signal in called for si in SIGNALS[signal].si_units)
            wanted = (*wanted, "V") if wanted else ()  # a sensor's output
        if wanted and units.fits(unit, wanted) is None:
            return False
    return True


def _in_a_sentence(text: str, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Columns with the units that the parts of a text give them: ``t in s, v [mm/s], F: force in kN``."""
    told: dict[str, str] = {}
    if len(names) > _MOST_IN_SENTENCES:
        return
    by_length = sorted(names, key=len, reverse=True)
    plain = text.translate(_QUOTES)
    for parts in (re.split(r"[\n;|,]", plain), re.split(r"[\n;|]", plain)):
        for part in parts[:_MOST_NAMES]:
            statement = part.strip(" \t#%*-.")
            name = next((each for each in by_length if _is_about(statement, each)), None)
            if name is None and _OF_ANOTHER.fullmatch(statement):
                return  # a list of other columns
            if name is None or name in told:
                continue
            rest = statement[len(name) :].strip()
            bracket = _IN_BRACKETS.match(rest)
            if bracket:
                unit = bracket[1].strip() if units.is_known_unit(bracket[1].strip()) else None
            elif rest[:1] in (":", "=", "-", "–"):
                unit = _unit_in(rest[1:])
            else:
                unit = _unit_in(rest) if rest.startswith("in ") else None
            if unit:
                told[name] = unit
    yield from told.items()


def _is_about(statement: str, name: str) -> bool:
    """Whether a statement begins with a whole name."""
    behind = statement[len(name) : len(name) + 1]
    return statement.startswith(name) and bool(behind) and behind in " \t[(:=-–"


def _unit_in(text: str) -> str | None:
    """The unit that ends a text: in brackets, behind ``in`` or a comma, or alone."""
    statement = text.strip().rstrip(".").strip()
    if statement[:1].isdecimal():
        return None  # a setting: speed: 100 rpm
    _, unit = split_label(statement)
    if unit is None:
        behind_in = _IN.search(statement)
        behind_comma = statement.rpartition(",")[2].strip() if "," in statement else ""
        unit = behind_in[1] if behind_in else behind_comma or statement
    begins_well = unit[:1].isalpha() or unit[:1] in ("°", "%") or unit.startswith("1/")
    if not begins_well or not units.is_known_unit(unit):
        return None
    return unit if units.is_temperature(unit) or units.fits(unit, _SI_UNITS) else None
