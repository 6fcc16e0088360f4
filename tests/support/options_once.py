"""Cyclopts takes the options of a command together anew at each call, for 20 ms: here once, as nothing else changes."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from cyclopts import App, ArgumentCollection


def build_options_once() -> None:
    """Let each call of a command, in this process, begin with a copy of its options that no call has filled."""
    built: dict[tuple[object, ...], ArgumentCollection] = {}
    assemble: Callable[..., ArgumentCollection] = App.assemble_argument_collection

    def assembled(app: App, **how: Any) -> ArgumentCollection:
        asked = (app.default_command, *how.items())
        if asked not in built:
            built[asked] = assemble(app, **how)
        return _unfilled(built[asked])

    App.assemble_argument_collection = assembled  # pyright: ignore[reportAttributeAccessIssue]


def _unfilled(options: ArgumentCollection) -> ArgumentCollection:
    """Copies of options to which no word is given yet; those within a group are within the copy of that group."""
    copies = {id(option): copy.copy(option) for option in options}
    for each in copies.values():
        each.tokens = []
        each.children = ArgumentCollection(copies[id(child)] for child in each.children)
    return ArgumentCollection(copies.values())
