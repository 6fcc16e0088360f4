"""What a page may ask of a session: a fixed set of named commands, each with its range. Nothing else gets through.

A message is one small JSON object, checked twice: by the page's server where it arrives, and by the session before it
becomes an order to the loop or to the recorder. The loop checks its orders a third time (``c/erc_layout.h``).

    {"command": "zero"}                       fields to zero, and no program runs
    {"command": "reset"}                      out of a trip
    {"command": "program", "name": "sine"}    run one of the session's programs (trajectories, tests)
    {"command": "motor", "torque": 0.1}       motor torque in N m, within the rig's limit
    {"command": "record", "on": true}         start or stop a recording; its name is the session's business
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

from erclutch.errors import SettingError

Kind = Literal["zero", "reset", "program", "motor", "record"]
#: Longest message in bytes.
LONGEST = 256


class CommandError(SettingError):
    """A message from a page is none of the commands that there are."""


@dataclass(frozen=True)
class Limits:
    """What the commands of a session may ask for.

    Attributes:
        programs: names of the session's programs, in the order of their numbers.
        motor: largest motor torque in N m, either way.
    """

    programs: tuple[str, ...] = ()
    motor: float = 0.0


@dataclass(frozen=True)
class Command:
    """One checked command.

    Attributes:
        kind: which.
        value: number of the program; motor torque in N m; 1 or 0 for recording on or off; else 0.
    """

    kind: Kind
    value: float = 0.0

    def to_message(self, limits: Limits) -> bytes:
        """The message that `parse` reads as this command."""
        body: dict[str, Any] = {"command": self.kind}
        if self.kind == "program":
            body["name"] = limits.programs[int(self.value)]
        elif self.kind == "motor":
            body["torque"] = self.value
        elif self.kind == "record":
            body["on"] = bool(self.value)
        return json.dumps(body).encode()


def parse(message: str | bytes, limits: Limits) -> Command:
    """Read a message.

    Args:
        message: JSON, at most `LONGEST` bytes.
        limits: of the session.

    Raises:
        CommandError: too long, no JSON object, an unknown command, a key too few or too many, a value out of range.
    """
    size = len(message.encode(errors="surrogatepass") if isinstance(message, str) else message)
    if size > LONGEST:
        raise CommandError(f"a command of {size} bytes", remedy=f"Send at most {LONGEST}")
    try:
        body: Any = json.loads(message)
    except (ValueError, RecursionError) as error:
        raise CommandError("a command that is no JSON", remedy="Send one JSON object") from error
    if not isinstance(body, dict):
        raise CommandError("a command that is no JSON object", remedy="Send one JSON object")
    values = cast("dict[str, Any]", body)
    kind = values.pop("command", None)
    reader = _READERS.get(kind) if isinstance(kind, str) else None
    if reader is None:
        raise CommandError("an unknown command", remedy=f"Send one of {', '.join(_READERS)}")
    return reader(values, limits)


def _plain(kind: Kind) -> Callable[[Mapping[str, Any], Limits], Command]:
    def read(values: Mapping[str, Any], limits: Limits) -> Command:
        _only(values, (), kind)
        return Command(kind)

    return read


def _program(values: Mapping[str, Any], limits: Limits) -> Command:
    _only(values, ("name",), "program")
    name = values["name"]
    if not isinstance(name, str) or name not in limits.programs:
        raise CommandError(
            "an unknown program", remedy=f"Send one of {', '.join(limits.programs) or 'none: there are none'}"
        )
    return Command("program", float(limits.programs.index(name)))


def _motor(values: Mapping[str, Any], limits: Limits) -> Command:
    _only(values, ("torque",), "motor")
    torque = values["torque"]
    if isinstance(torque, bool) or not isinstance(torque, (int, float)):
        raise CommandError("a motor torque that is no number", remedy="Send N m")
    # An integer of any length compares exactly; only what is in range becomes a float.
    if not -limits.motor <= torque <= limits.motor:
        raise CommandError("a motor torque out of range", remedy=f"Send at most {limits.motor:g} N m either way")
    return Command("motor", float(torque))


def _record(values: Mapping[str, Any], limits: Limits) -> Command:
    _only(values, ("on",), "record")
    if not isinstance(values["on"], bool):
        raise CommandError("'on' is neither true nor false", remedy="Send true or false")
    return Command("record", float(values["on"]))


def _only(values: Mapping[str, Any], keys: Sequence[str], kind: str) -> None:
    if set(values) != set(keys):
        wanted = f"exactly {', '.join(keys)}" if keys else "nothing"
        raise CommandError(f"the wrong keys for {kind}", remedy=f"Send {wanted} beside command")


_READERS: Mapping[str, Callable[[Mapping[str, Any], Limits], Command]] = {
    "zero": _plain("zero"),
    "reset": _plain("reset"),
    "program": _program,
    "motor": _motor,
    "record": _record,
}
