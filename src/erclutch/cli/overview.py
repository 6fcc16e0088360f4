"""What ``erclutch`` and ``erclutch --help`` print of themselves, without a library that takes words apart."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Container, Sequence
from itertools import groupby

from erclutch.cli.command_list import Command

TITLE = "Turn a test-bench log of a clutch, brake or damper with an ER or MR fluid into a checked torque model."
_FIRST = """erclutch turns a log of an ER or MR clutch, brake or damper into a checked torque model.

What to do first:
  erclutch demo                 see it work, on a log of the digital twin
  erclutch inspect LOG          see what is in your file and how it is read
  erclutch fit LOG              fit and rank all models; --out RUN keeps the result
  erclutch report RUN           write the result as one file to read and to forward
  erclutch app                  the same as a page in the browser
  erclutch laws                 list the models

erclutch COMMAND --help explains a command and its usual options, --help-all each option.
"""
_OPTIONS = {
    "--help (-h)": "Print this page.",
    "--version": "Print the version, what a report of a bug needs, and how to cite.",
    "--install-completion": "Let bash, zsh, fish or PowerShell complete commands and options with Tab.",
}


def first_steps(known: Container[str]) -> str:
    """What to do first, out of the commands that are there."""
    kept: list[str] = []
    for line in _FIRST.splitlines(keepends=True):
        is_command = line.startswith("  erclutch ")
        if not is_command or line.split()[1] in known:
            kept.append(line)
    return "".join(kept)


def overview(commands: Sequence[Command]) -> str:
    """All commands under their headings, as wide as the terminal."""
    columns = shutil.get_terminal_size().columns
    width = min(max(columns, 40), 100)
    names = [*_OPTIONS, *(command.name for command in commands)]
    across = max(map(len, names)) + 4
    lines = ["Usage: erclutch COMMAND", "", *textwrap.wrap(TITLE, width)]
    for panel, listed in groupby(commands, key=lambda command: command.panel):
        helps = {command.name: command.help for command in listed}
        lines += ["", panel, *_listed(helps, across, width)]
    lines += ["", "Options", *_listed(_OPTIONS, across, width)]
    lines += [
        "",
        *textwrap.wrap("erclutch COMMAND --help explains a command and its usual options.", width),
    ]
    return "\n".join(lines) + "\n"


def _listed(told: dict[str, str], across: int, width: int) -> list[str]:
    """Names with what they are for, in two columns."""
    lines: list[str] = []
    for name, text in told.items():
        first, *further = textwrap.wrap(text, max(width - across, 20))
        lines.append(f"  {name:{across - 2}}{first}")
        lines += [f"{'':{across}}{line}" for line in further]
    return lines
