"""The field of each log may stand in a file beside the logs: a test plan or workbook, a table of a README, JSON, YAML.

Such a file is searched for the names of the logs, and for a number that is called like a field beside each. What is
found is proposed: it is taken once it stands in a mapping file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from erclutch.errors import ErclutchError, UnitError
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.name_pattern import FIELD_IN_A_NAME
from erclutch.logs.columns.names import spoken_name, words_of
from erclutch.logs.columns.vocabulary import OTHER, TOLD
from erclutch.logs.log_file import recordings_in, tables_in
from erclutch.signals import units
from erclutch.signals.recording import SI_UNITS_OF_FIELDS

_LARGEST = 65_536  # bytes of such a file
_MOST_FILES = 2_000  # of a folder that is searched
_SUFFIXES = frozenset({".json", ".yaml", ".yml", ".csv", ".tsv", ".txt", ".md", ".rst"})
#: Workbooks, whose sheets may be a test plan.
WORKBOOKS = frozenset({".xlsx", ".xlsm", ".xls", ".ods"})
_NUMBERS_LOGS = frozenset(
    {"run", "nr", "no", "test", "trial", "log", "file", "id", "versuch", "messung", "lauf", "n"}
)
_NUMBER = re.compile(r"\d+")
_KEY = re.compile(r"\s*(- )?\s*[\"']?([^:\"'#]+?)[\"']?\s*:\s*(.*?)\s*")
_RULE = re.compile(r"[\s|:+=-]+")
_NAME = ""  # the key of what stands in front of a record


class FieldsOfLogs(NamedTuple):
    """What a file beside the logs says of their fields.

    Attributes:
        file: its name, or that of the first of several.
        texts: the field of each log by its file's name, such as ``0.5 A``.
    """

    file: str
    texts: dict[str, str]

    def __str__(self) -> str:
        return f"{self.file} says " + ", ".join(
            f"{name} {text}" for name, text in self.texts.items()
        )


def fields_beside(logs: Sequence[Path]) -> FieldsOfLogs | None:
    """The fields of logs by files beside them: the file that says most; None where none says any."""
    files: list[Path] = []
    for folder in sorted({log.parent for log in logs}):
        files += sorted(folder.iterdir())
        if len(files) > _MOST_FILES:
            return None
    best: FieldsOfLogs | None = None
    own: dict[str, str] = {}  # of files that belong to one log each
    file_of_own = ""
    for file in files:
        suffix = file.suffix.lower()
        if file in logs or suffix not in _SUFFIXES | WORKBOOKS or file.name.startswith((".", "~$")):
            continue
        if not file.is_file() or file.stat().st_size > _LARGEST:
            continue
        records = _records(file)
        # A file may be called like a log: ``run1.json`` and ``run1_meta.json`` beside ``run1.csv``.
        logs_of_file: list[Path] = []
        for log in logs:
            rest = file.stem.removeprefix(log.stem)
            if file.stem.startswith(log.stem) and (not rest or not rest[0].isalnum()):
                logs_of_file.append(log)
        if len(logs_of_file) == 1:
            merged = {key: text for record in records for key, text in record.items() if key}
            text = _field_of(merged)
            if text:
                own[logs_of_file[0].name] = text
                file_of_own = file_of_own or file.name
            continue
        texts: dict[str, str] = {}
        for record in records:
            name = _log_of(record, logs)
            text = _field_of(record)
            if name and text:
                texts.setdefault(name, text)
        if texts and (best is None or len(texts) > len(best.texts)):
            best = FieldsOfLogs(file.name, texts)
    if own and (best is None or len(own) > len(best.texts)):
        return FieldsOfLogs(file_of_own, own)
    return best


def _log_of(record: Mapping[str, str], logs: Sequence[Path]) -> str:
    """The log that a record names, by its file, its stem or its number; "" for none."""
    said = {text.strip() for key, text in record.items() if key == _NAME or not _is_field(key)}
    for log in logs:
        if said & {log.name, log.stem, str(log)}:
            return log.name
    for key, text in record.items():
        if _NUMBERS_LOGS.isdisjoint(words_of(key)) or not text.strip().isdecimal():
            continue
        numbered: list[Path] = []
        for log in logs:
            if [int(number) for number in _NUMBER.findall(log.stem)] == [int(text)]:
                numbered.append(log)
        if len(numbered) == 1:
            return numbered[0].name
    return ""


def _is_field(key: str) -> bool:
    """Whether a key is called like a current or a voltage, and not like a supply or a set point."""
    label, _ = split_label(key)
    spoken = spoken_name(label)
    form = spoken.forms["field"] or spoken.heads.get("field") or ""
    is_another = "field" in spoken.turned or bool({*spoken.words} & (TOLD | OTHER))
    return (len(form) > 2 or label == "I") and not is_another


def _field_of(record: Mapping[str, str]) -> str:
    """The one field of a record as text with its unit; "" for none, and for several."""
    quantities: list[str] = []
    for key, text in record.items():
        if not _is_field(key):
            continue
        label, unit = split_label(key)
        unit = unit or spoken_name(label).end or record.get("unit") or record.get("units")
        try:
            number, own = units.quantity(text.strip())
            unit = own or unit
            is_of_a_field = not unit or units.fits(unit, SI_UNITS_OF_FIELDS) is not None
        except UnitError:
            continue
        if is_of_a_field:
            quantities.append(f"{number:g} {unit or ''}".strip())
    currents = [text for text in quantities if text.endswith("A")]
    chosen = currents if len(currents) == 1 else quantities
    return chosen[0] if len(chosen) == 1 else ""


def _records(file: Path) -> list[dict[str, str]]:
    """What a file says, a record for each row, item or line that may be of a log."""
    if file.suffix.lower() in WORKBOOKS:
        return [*_of_workbook(file)]
    text = file.read_bytes().decode("utf-8", "replace").removeprefix("\ufeff")
    if file.suffix.lower() == ".json":
        try:
            return [*_of_json(json.loads(text))]
        except (ValueError, RecursionError):
            return []
    lines = text.splitlines()
    if file.suffix.lower() in (".yaml", ".yml"):
        return [*_of_yaml(lines)]
    records = [*_of_tables(lines)]
    for line in lines:
        # A remark has a name in front of a colon or an equals sign, and one field behind it.
        name, parted, rest = line.strip(" \t-*").partition(":" if ":" in line else "=")
        fields = FIELD_IN_A_NAME.findall(rest)
        if parted and len(fields) == 1:
            number, _, unit = fields[0]
            kind = "current" if unit.endswith("A") else "voltage"
            records.append({_NAME: name.strip(' `"'), kind: f"{number} {unit}"})
    return records


def names_logs(file: Path, logs: Sequence[Path]) -> bool:
    """Whether a file has records of several logs by their names, as a plan of tests has."""
    texts = {text.strip() for record in _records(file) for text in record.values()}
    named = [log for log in logs if not log.stem.isdecimal() and texts & {log.name, log.stem}]
    return len(named) > 1


def _of_workbook(file: Path) -> Iterator[dict[str, str]]:
    """A record for each row of each sheet: its numbers, and the words in its columns and in front of it."""
    try:
        tables = tables_in(file, recordings_in(file) or [""])
    except ErclutchError:
        return
    for table in tables.values():
        if isinstance(table, ErclutchError):
            continue
        for row in range(table.rows):
            record: dict[str, str] = {}
            if table.row_names:
                record[_NAME] = table.row_names[row]
            for name, column in table.words.items():
                place = int(column.of_row[row])
                record[name] = column.words[place] if place >= 0 else ""
            for name, values in table.columns.items():
                if np.isfinite(values[row]):
                    record[table.label(name)] = f"{values[row]:.15g}"
            yield record


def _of_json(value: Any, name: str = _NAME, above: str = "") -> Iterator[dict[str, str]]:
    """A record for each object, with the key in front of it; and for each number, with the key above."""
    if isinstance(value, list):
        for each in cast("list[Any]", value):
            yield from _of_json(each, name, above)
    elif isinstance(value, dict):
        record = {_NAME: name}
        for key, each in cast("dict[str, Any]", value).items():
            if isinstance(each, dict | list):
                yield from _of_json(each, key, key)
            else:
                record[key] = str(each)
                yield {_NAME: key, above or name: str(each)}
        yield record


def _of_yaml(lines: Iterable[str]) -> Iterator[dict[str, str]]:
    """A record for each item of a list and for each key with keys below it."""
    record: dict[str, str] = {}
    head = _NAME
    for line in lines:
        match = _KEY.fullmatch(line.partition(" #")[0])
        if match is None:
            continue
        item, key, value = match.groups()
        if item or not value:
            if record:
                yield record
            head = "" if item else key
            record = {_NAME: head}
        if value:
            record[key] = value.strip("\"'")
            yield {_NAME: key, head or _NAME: value.strip("\"'")}
    if record:
        yield record


def _of_tables(lines: Sequence[str]) -> Iterator[dict[str, str]]:
    """A record for each row of a table in text or Markdown whose head has a field."""
    head: list[str] = []
    mark = ""
    for line in lines:
        if not line.strip():
            head = []
            continue
        if not head:
            for mark in ("|", ";", "\t", ","):
                cells = _cells(line, mark)
                if len(cells) > 1 and any(map(_is_field, cells)):
                    head = cells
                    break
            continue
        if _RULE.fullmatch(line):
            continue
        cells = _cells(line, mark)
        if len(cells) == len(head):
            if mark != ",":
                cells = [re.sub(r"^(\d+),(\d+)$", r"\1.\2", cell) for cell in cells]
            yield dict(zip(head, cells, strict=True))


def _cells(line: str, mark: str) -> list[str]:
    return [cell.strip().strip('"`') for cell in line.strip().strip("|").split(mark)]
