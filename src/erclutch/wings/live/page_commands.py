"""A page may ask a session only for a fixed set of named commands, each with its range. Nothing else gets through.

A message is one small JSON object, checked twice: by the page's server where it arrives, and by the session before it
becomes an order to the loop or to the recorder. The loop checks its orders a third time (``c/erc_layout.h``).

    {"command": "zero"}                       fields to zero, and no program runs
    {"command": "reset"}                      clear a trip; fields stay at zero
    {"command": "program", "name": "sine"}    run one of the session's programs; not while tripped
    {"command": "motor", "torque": 0.1}       motor torque in N m, within the rig's limit
    {"command": "record", "on": true}         start or stop a recording; its name is the session's business
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, cast

from erclutch.errors import SettingError

Kind = Literal["zero", "reset", "program", "motor", "record"]
#: Each command, and the one key that it has beside it.
_KEYS: Mapping[str, str] = {
    "zero": "",
    "reset": "",
    "program": "name",
    "motor": "torque",
    "record": "on",
}
#: Longest message in bytes.
LONGEST = 256


class CommandError(SettingError):
    """A message from a page is none of the commands that there are."""


@dataclass(frozen=True)
class CommandLimits:
    """What the commands of a session may ask for.

    Attributes:
        programs: names of the session's programs, in the order of their numbers.
        motor: largest motor torque in N m, either way.
    """

    programs: tuple[str, ...] = ()
    motor: float = 0.0


@dataclass(frozen=True)
class PageCommand:
    """One checked command.

    Attributes:
        kind: which.
        value: number of the program; motor torque in N m; 1 or 0 for recording on or off; else 0.
    """

    kind: Kind
    value: float = 0.0


def parse(message: str | bytes, limits: CommandLimits) -> PageCommand:
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
    kind: Any = values.pop("command", None)
    if not isinstance(kind, str) or kind not in _KEYS:
        raise CommandError("an unknown command", remedy=f"Send one of {', '.join(_KEYS)}")
    key = _KEYS[kind]
    if set(values) != ({key} if key else set()):
        wanted = f"exactly {key}" if key else "nothing"
        raise CommandError(f"the wrong keys for {kind}", remedy=f"Send {wanted} beside command")

    # The value of the command's one key, checked; 0 where it has none.
    given = values.get(key)
    if key == "name":
        if not isinstance(given, str) or given not in limits.programs:
            known = ", ".join(limits.programs) or "none: there are none"
            raise CommandError("an unknown program", remedy=f"Send one of {known}")
        value = float(limits.programs.index(given))
    elif key == "torque":
        if isinstance(given, bool) or not isinstance(given, (int, float)):
            raise CommandError("a motor torque that is no number", remedy="Send N m")
        # An integer of any length compares exactly; only what is in range becomes a float.
        if not -limits.motor <= given <= limits.motor:
            raise CommandError(
                "a motor torque out of range",
                remedy=f"Send at most {limits.motor:g} N m either way",
            )
        value = float(given)
    else:
        if key == "on" and not isinstance(given, bool):
            raise CommandError("'on' is neither true nor false", remedy="Send true or false")
        value = float(bool(given))
    return PageCommand(cast("Kind", kind), value)
