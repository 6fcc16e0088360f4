"""The user says which column is which signal: by labels on the command line, or in a TOML file beside the log.

The TOML file is ``<log>.toml`` (``run1.csv.toml``), ``<stem>.toml`` (``run1.toml``) or ``erclutch.toml`` in the folder
of the log; the first that exists is read. Its keys, all optional::

    time = "t [ms]"                  # time column: a label, or its number in the file
    rate = 3004.8                    # sampling rate in Hz instead of a time column
    lead = "10 mm"                   # lead of the screw (alpha_raw); a plain number is in m
    name_pattern = "{amplitude}mm{frequency}Hz{field}A"   # numbers in the file's name; 0x25 and 0p25 are 0.25
    variable = "rec001"              # which recording of a MATLAB file
    inputs = ["D [cm]", "A"]         # further inputs for networks, as logged
    decimal = ","                    # where numbers such as 1.500 may be read in two ways
    values = "keep"                  # keep -999 and the like, which loggers write for no measurement
    invalid = "drop"                 # cut the log where values are missing, instead of an error

    [columns]                        # signal = label, number, or a table
    slip = "V [cm/s]"
    effort = {column = 4, unit = "N", scale = -1}

    [scales]                         # of sensors in volts, or without a unit
    effort = "2.5 N*m/V"

    [zeros]                          # what a column reads where the signal is zero
    effort = "2048"

    [constants]                      # signals that are the same all through the log, and other numbers
    field = "0.5 A"                  # or one number a segment between gaps: "0, 0.25, 0.5 A"

    [fields]                         # of several logs in the folder, by their names
    "run1.csv" = "0.5 A"

A label is a column's name, with the unit in brackets where the file does not give it or gives it wrongly; a minus
before it turns the sign (``-F [N]``). ``n_in - n_out [rpm]`` is what two columns differ by.
What the command line says wins over the file, and the file over guesses.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from erclutch.errors import MappingError, UnitError, placed
from erclutch.files.given_files import plain_words, small_file, toml_of
from erclutch.logs.columns.name_pattern import FIELD
from erclutch.signals.recording import NAMED_COLUMNS, SIGNALS

_TEXT_KEYS = ("name_pattern", "variable", "invalid", "decimal", "values")
_TABLES = ("columns", "scales", "zeros", "constants", "fields")
_KEYS = ("time", "rate", "lead", *_TEXT_KEYS, "inputs", *_TABLES)
#: In place of a field in a mapping file that names logs: the user is to fill it in.
TO_FILL_IN = "?"
_ALLOWED = {"invalid": ("error", "drop"), "decimal": (".", ","), "values": ("keep",)}
_CHOICE_KEYS = ("column", "unit", "scale")

#: In place of a signal's column: no column is to be taken for it.
NONE = "none"


@dataclass(frozen=True)
class ColumnChoice:
    """One column, chosen for a signal.

    Attributes:
        column: its label (``V``, ``V [cm/s]``, ``-F [N]``) or its number in the file, counted from 1.
        unit: its unit; wins over the label's and the file's.
        scale: factor before the unit is converted; -1 turns the sign.
        source: who chose it, for the notes.
    """

    column: str | int
    unit: str | None = None
    scale: float = 1.0
    source: str = "given"

    @property
    def is_none(self) -> bool:
        """Whether the choice is that no column is taken."""
        return str(self.column).strip() == NONE


@dataclass(frozen=True)
class ColumnMap:
    """How the columns of a log become signals.

    Attributes:
        columns: signal -> column; the column `NONE` says that no column is taken for it.
        time: the time column; the column `NONE` says that the rows are points, none after another.
        rate: sampling rate in Hz, instead of a time column.
        lead: lead of the screw in m, for alpha_raw.
        constants: name -> number with unit (``0.5 A``), as text; a signal's name makes a constant signal.
        scales: signal -> number with unit, as text: what one of the column's unit (``2.5 N*m/V``) or one count is.
        zeros: signal -> what its column reads where the signal is zero, as text, with the column's unit or without one.
        name_pattern: template on the file's name (see the module).
        variable: recording of a MATLAB file.
        decimal: "." or "," for texts whose numbers may be read in two ways.
        values: "keep" for values that loggers write for no measurement.
        invalid: "error" or "drop" for values that are not finite.
        inputs: further columns that networks may take as inputs.
        fields: the field of each of several logs by its file's name, as text.
        source: who said so, for the notes.
        file: name and SHA-256 of the mapping file that had a say, if one had.
    """

    columns: Mapping[str, ColumnChoice] = field(default_factory=dict[str, ColumnChoice])
    time: ColumnChoice | None = None
    rate: float | None = None
    lead: float | None = None
    constants: Mapping[str, str] = field(default_factory=dict[str, str])
    scales: Mapping[str, str] = field(default_factory=dict[str, str])
    zeros: Mapping[str, str] = field(default_factory=dict[str, str])
    name_pattern: str | None = None
    variable: str | None = None
    invalid: str | None = None
    decimal: str | None = None
    values: str | None = None
    inputs: tuple[ColumnChoice, ...] = ()
    fields: Mapping[str, str] = field(default_factory=dict[str, str])
    source: str = "given"
    file: tuple[str, str] | None = None

    def declines(self, signal: str) -> bool:
        """Whether no column is to be taken for a signal, whatever the columns are called."""
        choice = self.time if signal == "time" else self.columns.get(signal)
        return choice is not None and choice.is_none

    @classmethod
    def from_labels(cls, labels: Mapping[str, str | int], **others: Any) -> ColumnMap:
        """From command-line style labels: ``{"slip": "V [cm/s]", "time": "t"}``; others are the class's attributes.

        Raises:
            MappingError: a name that is no signal.
        """
        columns = {name: label for name, label in labels.items() if name != "time"}
        timed = {"time": labels["time"]} if "time" in labels else {}
        return cls.from_dict({**others, "columns": columns, **timed})

    @classmethod
    def from_toml(cls, path: str | Path) -> ColumnMap:
        """Read a mapping file; the keys are in the module's description.

        Raises:
            MappingError: unreadable, no TOML, or an unknown key or value.
        """
        path = Path(path)
        try:
            content = small_file(path)
            values = toml_of(content)
        except (OSError, ValueError, RecursionError) as error:
            problem = f"the mapping file cannot be read ({plain_words(error)})"
            remedy = "Correct the mapping file"
            raise MappingError(problem, remedy=remedy, where=path.name) from error
        digest = hashlib.sha256(content).hexdigest()
        with placed(path.name):
            told = cls.from_dict(values, path.name)
        return replace(told, file=(path.name, digest))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], source: str = "given") -> ColumnMap:
        """From plain values with the keys of the mapping file; ``source`` says in reasons who gave them.

        Raises:
            MappingError: an unknown key, or a value of the wrong kind.
        """
        _known(values, _KEYS, "key")
        columns = _table_of(values, "columns")
        _known(columns, NAMED_COLUMNS, "signal")
        scales = _table_of(values, "scales")
        _known(scales, tuple(SIGNALS), "signal")
        zeros = _table_of(values, "zeros")
        _known(zeros, tuple(SIGNALS), "signal")
        inputs = values.get("inputs", ())
        if not isinstance(inputs, list | tuple):
            remedy = 'Write it as a list: inputs = ["D [cm]"]'
            raise MappingError(f"inputs is {inputs!r}", remedy=remedy)
        constants = _table_of(values, "constants")
        twice = sorted(columns.keys() & constants)
        if twice:
            problem = f"{twice[0]} is given as a column and as a constant"
            raise MappingError(problem, remedy="Give one of the two")
        texts = {key: values[key] for key in _TEXT_KEYS if values.get(key) is not None}
        for key, value in texts.items():
            if not isinstance(value, str):
                raise MappingError(f"{key} is {value!r}", remedy=f'Write it as text: {key} = "..."')
            allowed = _ALLOWED.get(key, ())
            if allowed and value not in allowed:
                remedy = f"Write {' or '.join(allowed)}"
                raise MappingError(f"{key} is '{value}'", remedy=remedy)
        time = values.get("time")
        return cls(
            columns={name: _choice(name, value, source) for name, value in columns.items()},
            time=None if time is None else _choice("time", time, source),
            rate=_number(values, "rate", "Hz"),
            lead=_number(values, "lead", "m"),
            constants={str(name): str(value) for name, value in constants.items()},
            scales={name: str(value) for name, value in scales.items()},
            zeros={name: str(value) for name, value in zeros.items()},
            inputs=tuple(_choice("inputs", label, source) for label in cast("list[Any]", inputs)),
            fields={name: str(text) for name, text in _table_of(values, "fields").items()},
            source=source,
            **texts,
        )

    @classmethod
    def from_options(cls, options: Mapping[str, Any], source: str = "given") -> ColumnMap:
        """From options of the command line by their names, as a run keeps them; those that say nothing of columns pass.

        Raises:
            MappingError: a constant, a scale or a zero of what is no signal; see `from_dict`.
        """
        plain = ("time", "rate", "lead", *_TEXT_KEYS)
        given = {key: options[key] for key in plain if key in options}
        if options.get("keep_values"):
            given["values"] = "keep"
        # The command line has no capitals.
        names = {name.lower(): name for name in NAMED_COLUMNS}
        given["columns"] = {names[key]: label for key, label in options.items() if key in names}
        given["inputs"] = list(options.get("input", ()))
        for option, example in (("constant", "0.5 A"), ("scale", "2.5 A/V"), ("zero", "2048")):
            texts: dict[str, str] = {}
            for pair in options.get(option, ()):
                name, _, text = pair.partition("=")
                name = name.strip()
                texts[name] = text
            for name in texts:
                if name not in SIGNALS:
                    remedy = f"Write it like --{option} 'field={example}'; signals are {', '.join(SIGNALS)}"
                    raise MappingError(f"--{option} {name!r} is no signal", remedy=remedy)
            given[f"{option}s"] = texts
        return cls.from_dict(given, source)

    def over(self, base: ColumnMap) -> ColumnMap:
        """This mapping with what it leaves open taken from another."""
        # A signal is a column or a constant: whichever is chosen here, the other's choice of either is left out.
        chosen = {*self.columns, *self.constants}
        columns = {name: choice for name, choice in base.columns.items() if name not in chosen}
        constants = {name: text for name, text in base.constants.items() if name not in chosen}
        timed = self.time is not None or self.rate is not None
        texts = ("variable", "invalid", "decimal", "values", "inputs", "file")
        return replace(
            self,
            columns={**columns, **self.columns},
            constants={**constants, **self.constants},
            scales={**base.scales, **self.scales},
            zeros={**base.zeros, **self.zeros},
            time=self.time if timed else base.time,
            rate=self.rate if timed else base.rate,
            lead=base.lead if self.lead is None else self.lead,
            name_pattern=self.name_pattern or still_needed(base.name_pattern, chosen),
            source=self.source if base == ColumnMap() else base.source,
            **{key: getattr(self, key) or getattr(base, key) for key in texts},
        )


def told_of(
    log: object,
    mapping: ColumnMap | Mapping[str, Any] | None,
    options: Mapping[str, Any],
    mapping_file: str | Path | None = None,
) -> ColumnMap:
    """All that is said of the columns of a log: options win over the mapping, and that over the mapping file.

    Args:
        log: see `file_mapping`.
        mapping: see `erclutch.read`.
        options: see `ColumnMap.from_options`.
        mapping_file: see `file_mapping`.

    Raises:
        MappingError: an unknown key or signal, or a mapping file that cannot be used.
    """
    said = ColumnMap.from_options(options).over(column_map(mapping))
    return said.over(file_mapping(log, mapping_file))


def map_over(mapping: ColumnMap | Mapping[str, Any] | None, base: ColumnMap | None) -> ColumnMap:
    """What is given as a mapping (see `erclutch.read`), over another mapping.

    Raises:
        MappingError: an unknown key or signal.
    """
    told = column_map(mapping)
    return told if base is None else told.over(base)


def column_map(mapping: ColumnMap | Mapping[str, Any] | None) -> ColumnMap:
    """What is given as a mapping: a plain mapping holds labels, or has the keys of a mapping file.

    Raises:
        MappingError: an unknown key or signal.
    """
    if isinstance(mapping, ColumnMap):
        return mapping
    values = mapping or {}
    if values.keys() <= {*NAMED_COLUMNS, "time"}:
        return ColumnMap.from_labels(values)
    return ColumnMap.from_dict(values)


def file_mapping(log: object, named: str | Path | None = None) -> ColumnMap:
    """What a mapping file says of a log: the file that is named, else that beside the log.

    Where the file names the log under its fields, the log's field is a constant.

    Args:
        log: its path; a log in memory has no file beside it.
        named: a mapping file in place of that beside the log.

    Raises:
        MappingError: the mapping file cannot be used, or the log's field is still to be filled in.
    """
    name = Path(log).name if isinstance(log, str | Path) else ""
    path = named
    if named is None and isinstance(log, str | Path):
        path = file_beside(Path(log))
    if path is None:
        return ColumnMap()
    try:
        told = ColumnMap.from_toml(path)
        level = told.fields.get(name)
        if level is None or "field" in told.columns or "field" in told.constants:
            return told
        if TO_FILL_IN in level:
            raise MappingError(
                f"the field of {name} is to be filled in",
                remedy=f'Write it like "{name}" = "0.5 A"',
                where=Path(path).name,
            )
        return replace(told, constants={**told.constants, "field": level})
    except MappingError as error:
        if named is not None:
            raise
        beside_log = f"it is read as it lies beside {name}: rename it if it is no mapping"
        remedy = f"{error.remedy}; {beside_log}"
        raise MappingError(error.problem, where=error.where, remedy=remedy) from error


def still_needed(pattern: str | None, given: Iterable[str]) -> str | None:
    """A name pattern; None where all the signals that it would give are given already."""
    names = {match.group(1) for match in FIELD.finditer(pattern or "")}
    signals = names & SIGNALS.keys()
    all_are_given = bool(signals) and signals.issubset(given)
    return None if all_are_given else pattern


def file_beside(log: Path) -> Path | None:
    """The mapping file that belongs to a log."""
    for name in (f"{log.name}.toml", log.with_suffix(".toml").name, "erclutch.toml"):
        beside = log.with_name(name)
        if beside.is_file():
            return beside
    return None


def _known(
    values: Mapping[str, Any],
    allowed: tuple[str, ...],
    what: str,
) -> None:
    for key in values:
        if key not in allowed:
            problem = f"there is no {what} '{key}' (allowed: {', '.join(allowed)})"
            raise MappingError(problem, remedy=f"Use one of these {what}s")


def _table_of(values: Mapping[str, Any], key: str) -> dict[str, Any]:
    table = values.get(key, {})
    if not isinstance(table, Mapping):
        raise MappingError(f"{key} is {table!r}", remedy=f"Write it as a table: [{key}]")
    return dict(cast("Mapping[str, Any]", table))


def _choice(name: str, value: Any, source: str) -> ColumnChoice:
    if isinstance(value, ColumnChoice):
        return value
    keys = cast("Mapping[str, Any]", value if isinstance(value, Mapping) else {"column": value})
    _known(keys, _CHOICE_KEYS, f"key of {name}")
    column = keys.get("column")
    unit = keys.get("unit")
    scale = keys.get("scale", 1.0)
    is_column = isinstance(column, str | int) and not isinstance(column, bool)
    is_unit = isinstance(unit, str | None)
    is_scale = isinstance(scale, int | float) and not isinstance(scale, bool)
    if not is_column or not is_unit or not is_scale or not 0 < abs(scale) < float("inf"):
        remedy = f'Write it like {name} = "V [cm/s]"'
        raise MappingError(f"the column for {name} is {value!r}", remedy=remedy)
    return ColumnChoice(cast("str | int", column), unit, float(scale), source)


def _number(values: Mapping[str, Any], name: str, unit: str) -> float | None:
    """A positive number, plain or as text with a unit."""
    from erclutch.signals import units

    value = values.get(name)
    if value is None:
        return None
    try:
        number = -1.0 if isinstance(value, bool) else units.in_unit(str(value), unit)
    except UnitError:
        number = -1.0
    if not number > 0:
        raise MappingError(f"{name} is {value!r}", remedy=f"Give a positive number in {unit}")
    return number
