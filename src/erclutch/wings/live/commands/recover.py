"""``erclutch recover`` makes a whole recording from a file that a crash left open or that is damaged."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

COMMAND = {
    "help": "Make a whole recording of one that a crash left open or that is damaged.",
    "panel": "Live",
    "place": 3,
}


def recover(file: Annotated[Path, Parameter(name="FILE")], *, out: Path | None = None) -> None:
    """Write what is whole of an MCAP recording as a whole file; the old file stays as it is.

    Args:
        file: A recording that was not closed (.mcap.partial) or that is damaged.
        out: File to write. Default: FILE without .partial, or FILE-recovered.mcap.
    """
    from erclutch.cli import terminal
    from erclutch.wings.live.recording import recover_recording as work

    found = work.recover(file, out)
    output = terminal.console()
    output.print(f"{found.path}: {found.messages:,} messages", markup=False, soft_wrap=True)
    if found.whole:
        output.print("The file was whole before; nothing is missing.", markup=False)
        return
    if found.torn:
        output.print(f"  left out at its end: {found.torn:,} bytes that are no whole chunk", markup=False)
    if found.damaged:
        output.print(f"  left out in between: {found.damaged:,} bytes that are damaged", markup=False)
    if found.missing:
        output.print(f"  missing by their numbers: {found.missing:,} messages", markup=False)
    if found.unsure:
        output.print("  check names and units of the columns: no checksum of the file covers them", markup=False)
    device = " --device coaxial" if found.coaxial else ""
    output.print(f"Next: erclutch inspect {found.path}{device}", markup=False, soft_wrap=True)
