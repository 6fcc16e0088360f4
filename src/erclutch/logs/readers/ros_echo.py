"""What ``rostopic echo`` and ``ros2 topic echo`` print, saved as a text: a message in YAML, and ``---`` behind it.

Each message is a row. It is written as an object of JSON, so that names beside lists, stamps and what is nested are
read as in a log of JSON lines.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers.jsonl import READER as JSON_LINES
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table

_BREAK = re.compile(r"(?m)^---[ \t]*\r?$")
_KEY = re.compile(r"([A-Za-z_]\w{0,80}):(?:[ \t]+(.*))?")
_LINE = re.compile(r"\s*(?:- +)*(?:[A-Za-z_]\w{0,80}:(?:\s.*)?|- .*|[-+\d.,\]\s].*)?")
_WITH_HEADER = re.compile(r"header:\s*\n\s+(?:seq|stamp):")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORDS = {"true": True, "false": False, ".nan": float("nan"), "nan": float("nan"), "null": None}
_INFINITE = re.compile(r"([-+]?)\.?inf", re.IGNORECASE)
_FEWEST_BREAKS = 2  # among the first bytes, where no header begins the message
_DIGITS = 19  # of a whole number at most, as nanoseconds since 1970 have
_DEEPEST = 20  # messages inside of messages

#: Lines of a message from the last to the first, each with its indent.
_Lines = list[tuple[int, str]]


def _claims(head: bytes) -> bool:
    text = head.decode("utf-8", errors="replace").lstrip("\ufeff").removeprefix("---").lstrip()
    if _WITH_HEADER.match(text.replace("\r", "")):
        return True
    messages = _BREAK.split(text)
    if len(messages) <= _FEWEST_BREAKS:
        return False
    first, second, *_ = messages
    keys = _keys_of(first)
    if not keys or keys != _keys_of(second):
        return False
    return all(_LINE.fullmatch(line) for line in (first + second).splitlines())


def _keys_of(message: str) -> list[str]:
    """The names of a message's outermost values."""
    matches = [_KEY.fullmatch(line.rstrip()) for line in message.splitlines()]
    return [match[1] for match in matches if match is not None]


def _read(source: LogSource) -> Table:
    """The messages as rows; a last one that was cut is left out."""
    *messages, rest = _BREAK.split(decode(source.data).removeprefix("---\n"))
    if rest.strip() and (not messages or _keys_of(rest) == _keys_of(messages[-1])):
        messages.append(rest)  # the last of them, without a line behind it
        rest = ""
    rows = [
        json.dumps(_message(text, f"message {number}"))
        for number, text in enumerate(messages, start=1)
        if text.strip()
    ]
    if not rows:
        raise LogError("no message holds values", remedy="Give the whole of what echo printed")
    read = JSON_LINES.read(replace(source, data="\n".join(rows).encode()))
    notes = [f"{len(rows)} messages as an echo of ROS prints them, a row each"]
    if rest.strip():
        notes.append("the last message was cut: left out")
    return replace(read, notes=(*notes, *read.notes))


def _message(text: str, where: str) -> Any:
    """The values of a message by their names."""
    lines: _Lines = []
    for line in _with_whole_lists(text.splitlines()):
        bare = line.strip()
        if bare:
            lines.append((len(line) - len(line.lstrip()), bare))
    lines.reverse()
    values = _block(lines, 0, where)
    if lines or not isinstance(values, dict):
        shown = lines[-1][1] if lines else text.strip()
        problem = f"{shown[:60]!r} is no value with its name"
        raise LogError(problem, where=where, remedy="Correct or delete that message")
    return values  # pyright: ignore[reportUnknownVariableType]


def _with_whole_lists(lines: list[str]) -> Iterator[str]:
    """Lines, those of a list in brackets as one."""
    begun: list[str] = []  # of a list whose bracket was not closed yet
    for line in lines:
        begun.append(line.rstrip())
        joined = " ".join(begun) if len(begun) > 1 else begun[0]
        if "[" in begun[0] and joined.count("[") > joined.count("]"):
            continue
        yield joined
        begun.clear()
    yield from begun


def _block(lines: _Lines, depth: int, where: str) -> Any:
    """The next values at one indent: by name, or in a list. Their lines are taken away."""
    if depth > _DEEPEST:
        raise LogError("messages are nested too deeply", where=where, remedy="Log plain messages")
    indent, text = lines[-1]
    if text.startswith("-") and not _NUMBER.fullmatch(text):
        items: list[Any] = []  # a line each, or begun by it
        while lines and lines[-1][0] == indent and lines[-1][1].startswith("-"):
            _, text = lines.pop()
            item = text[1:].strip()
            if _KEY.fullmatch(item):
                lines.append((indent + len(text) - len(item), item))  # a message in the list
                items.append(_block(lines, depth + 1, where))
            elif item or not lines or lines[-1][0] <= indent:
                items.append(_scalar(item))
            else:
                items.append(_block(lines, depth + 1, where))
        return items

    values: dict[str, Any] = {}
    while lines and lines[-1][0] == indent:
        match = _KEY.fullmatch(lines[-1][1])
        if match is None:
            break
        lines.pop()
        name, value = match[1], (match[2] or "").strip()
        if value:
            values[name] = _scalar(value)
            continue
        # What is nested stands further in; a list may stand below its name.
        is_list = bool(lines) and lines[-1][0] == indent and lines[-1][1].startswith("-")
        is_nested = bool(lines) and (lines[-1][0] > indent or is_list)
        values[name] = _block(lines, depth + 1, where) if is_nested else None
    return values


def _scalar(text: str) -> Any:
    """A number, a switch, a text, or a list of them."""
    inside = text[1:-1].strip()
    if text.startswith("[") and text.endswith("]") and "[" not in inside:
        return [_scalar(item.strip()) for item in inside.split(",")] if inside else []
    if _NUMBER.fullmatch(text):
        return int(text) if len(text) <= _DIGITS and not re.search(r"[.eE]", text) else float(text)
    infinite = _INFINITE.fullmatch(text)
    if infinite:
        return float(f"{infinite[1]}inf")
    return _WORDS.get(text.lower(), text.strip("'\""))


READER = LogReader((), _claims, _read, tells_damage=DAMAGE)
