"""Targets have names: each is a file in this folder or comes from another package (entry point ``erclutch.targets``).

    TITLE                              one phrase
    write(step, folder)             writes all its files
    verify(step, folder)            runs what it wrote on the test vectors and yields a `Check` each

A target is a module with these three names. export.json and model.json are written for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from erclutch import registry
from erclutch.errors import ExportError
from erclutch.export.exported_step import ExportedStep
from erclutch.export.target_check import Check
from erclutch.registry import Plugin

GROUP = "erclutch.targets"


class Target(Protocol):
    """What a target's module offers."""

    TITLE: str

    def write(self, step: ExportedStep, folder: Path) -> None:
        """Write all files of the target."""
        ...

    def verify(self, step: ExportedStep, folder: Path) -> Iterator[Check]:
        """Run what was written on the test vectors."""
        ...


def target(name: str) -> Plugin:
    """A target by name, as a plug-in; its value is a `Target`.

    Raises:
        ExportError: there is none (PluginError: a target of another package cannot be loaded).
    """
    if name not in registry.names(GROUP):
        raise registry.unknown(GROUP, name, where="--to", error=ExportError)
    plugin = registry.find(GROUP, name)
    missing = [part for part in ("TITLE", "write", "verify") if not hasattr(plugin.value, part)]
    if missing:
        raise plugin.fault(
            f"has no {' and no '.join(missing)}; a target's module has TITLE, write and verify"
        )
    return plugin
