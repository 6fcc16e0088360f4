"""Figures that pages cite: what their commands print, and what moved since (`studies/figures.py`)."""

from __future__ import annotations

import difflib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parents[2]
LISTED = HERE / "docs" / "figures.toml"
KEPT = HERE / "docs" / "figures"
NUMBER = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*\w\.)")


def printed(entry: dict[str, str], data: Path) -> str:
    """What the command of an entry prints, run in a folder of its own; it knows the project's folder as $PROJECT."""
    with tempfile.TemporaryDirectory() as folder:
        if "needs" in entry:
            if not (data / entry["needs"]).is_file():
                raise SystemExit(
                    f"{data / entry['needs']} is not there: name the folder of recordings with --data"
                )
            shutil.copy(data / entry["needs"], folder)
        path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
        shown = {"COLUMNS": "160", "NO_COLOR": "1", "PYTHONUTF8": "1"}
        surroundings = {**os.environ, "PATH": path, "PROJECT": str(HERE), **shown}
        done = subprocess.run(
            ["bash", "-c", entry["command"]],
            cwd=folder,
            env=surroundings,
            stdout=subprocess.PIPE,
            text=True,
        )
    if done.returncode:
        raise SystemExit(f"{entry['command']}\nended with exit code {done.returncode}")
    kept = (line.rstrip() for line in done.stdout.splitlines())
    shown = [line for line in kept if line and not re.search(entry.get("leave_out", "$^"), line)]
    return "\n".join([f"$ {entry['command']}", *shown]) + "\n"


def moved(old: str, new: str) -> list[str]:
    """Lines that came, went or changed, but for blanks. Of a line whose words are the same, the numbers: old -> new."""
    before, after = ([" ".join(line.split()) for line in text.splitlines()] for text in (old, new))
    said = []
    for kind, a, b, c, d in difflib.SequenceMatcher(
        None, before, after, autojunk=False
    ).get_opcodes():
        gone, come = before[a:b], after[c:d]
        if kind == "replace" and len(gone) == len(come):
            said += [_changed(*pair) for pair in zip(gone, come, strict=True)]
        elif kind != "equal":
            said += [f"- {line}" for line in gone] + [f"+ {line}" for line in come]
    return said


def _changed(old: str, new: str) -> str:
    if [*NUMBER.sub("#", old).split()] != [*NUMBER.sub("#", new).split()]:
        return f"- {old}\n+ {new}"
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new), strict=True)
    return f"{' '.join(new.split()[:2])}: " + ", ".join(f"{a} -> {b}" for a, b in pairs if a != b)
