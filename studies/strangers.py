"""Copies of public files are planned, and each plan is held against what is true: `python studies/strangers.py FOLDER`.

FOLDER holds a copy of each file of `strangers.toml` as OWNER+NAME/PATH, at the commit named there; a file that is not
there is passed over. Printed: a row a file, then how many were understood at once, asked about, refused and misread.
With --sealed the sealed files are judged in place of the open ones. With --fit each log that is understood is fitted.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import ErclutchError
from erclutch.logs import ColumnMap, Plan, Table, apply, plan_of, read_table, recordings_in
from erclutch.logs.labels import name_columns

MANIFEST = Path(__file__).with_name("strangers.toml")
SIGNALS = ("field", "slip", "position", "effort")
AS_LOGGED = "as logged"
UNDERSTOOD, ASKED, REFUSED, MISREAD = "understood", "asked", "refused", "misread"
FIT_MODELS = ("linear", "quadratic")  # two that every log can have: fit is run to see that a read log goes on


def _column(label: str) -> str:
    """The name that the readers give a column of this label."""
    return name_columns([label])[0][0]


def _faults(plan: Plan, table: Table, truth: dict[str, Any]) -> Iterator[str]:
    """Where a plan differs from the truth, one sentence each; what it asks about is no fault."""
    rows = truth.get("rows", table.rows)
    if table.rows != rows:
        yield f"{table.rows} rows of {rows}"
    doubtful = {each.signal for each in plan.signals if each.sureness == "doubtful"}
    for each in plan.signals:
        if not each.column or each.signal in doubtful or each.signal not in SIGNALS:
            continue
        allowed = {_column(label): factor for label, factor in truth.get(each.signal, {}).items()}
        if each.column not in allowed:
            yield f"{each.signal} is {each.column}"
            continue
        factor = 1.0 if allowed[each.column] == AS_LOGGED else float(allowed[each.column])
        if not np.isclose(each.factor, factor, rtol=1e-9):
            yield f"{each.signal} is {each.column} times {each.factor:g}, not {factor:g}"
    clock = plan.clock
    if clock is not None and clock.kind == "column" and not clock.doubt:
        allowed = {_column(label): factor for label, factor in truth.get("time", {}).items()}
        if clock.column not in allowed:
            yield f"time is {clock.column}"
        elif allowed[clock.column] == "ask":
            yield f"time is {clock.column} in a unit that nobody said"
        elif not np.isclose(clock.factor, float(allowed[clock.column]), rtol=1e-9):
            yield f"time is {clock.column} times {clock.factor:g}"


def _settled(table: Table, truth: dict[str, Any]) -> bool:
    """Whether one command with the true columns answers all questions."""
    labels = {signal: next(iter(truth[signal])) for signal in SIGNALS if truth.get(signal)}
    if "slip" in labels:
        labels.pop("position", None)
    time = next(iter(truth.get("time", {})), None)
    try:
        plan = plan_of(table, ColumnMap.from_options({**labels, **({"time": time} if time else {})}))
        return not plan.questions and apply(plan, table).rows > 0
    except ErclutchError:
        return False


def _several(path: Path) -> bool:
    """Whether the file holds several recordings, so that a stop is the question which of them is meant."""
    try:
        return bool(recordings_in(path))
    except ErclutchError:
        return False


def judged(path: Path, truth: dict[str, Any]) -> tuple[str, str]:
    """The outcome of one file, and what was asked, refused or misread."""
    try:
        table = read_table(path)
        plan = plan_of(table, ColumnMap())
    except ErclutchError as error:
        return (ASKED if _several(path) else REFUSED), str(error)
    if faults := list(_faults(plan, table, truth)):
        return MISREAD, "; ".join(faults)
    if plan.questions or plan.doubts:
        settled = ", one command settles it" if truth["expect"] == "read" and _settled(table, truth) else ""
        return ASKED, "; ".join([*(each.short for each in plan.questions), *plan.doubts]) + settled
    try:
        recording = apply(plan, table)
    except ErclutchError as error:
        return REFUSED, str(error)
    if truth["expect"] != "read":
        return MISREAD, f"taken without a question: {truth['why']}"
    return UNDERSTOOD, f"{recording.rows} rows"


def _fit(path: Path) -> str:
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "erclutch",
            "fit",
            str(path),
            "--out",
            f"{folder}/run",
            "--models",
            *FIT_MODELS,
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        last = (done.stdout + done.stderr).strip().splitlines()[-1:]
        return f"fit: exit code {done.returncode}, {' '.join(last)[:160]}"


def main() -> None:
    """Print a row a file and the totals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sealed", action="store_true")
    parser.add_argument("--fit", action="store_true")
    parser.add_argument("--only", default="", help="repositories whose name holds this")
    asked = parser.parse_args()
    outcomes = Counter[str]()
    repositories = set[str]()
    absent = 0
    for truth in tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["file"]:
        if truth.get("sealed", False) != asked.sealed or asked.only not in truth["repository"]:
            continue
        path: Path = asked.folder / truth["repository"].replace("/", "+") / truth["path"]
        if not path.is_file():
            absent += 1
            continue
        if hashlib.sha256(path.read_bytes()).hexdigest() != truth["sha256"]:
            sys.exit(f"{path} is another file than that of the manifest: fetch it at commit {truth['commit']}")
        outcome, detail = judged(path, truth)
        outcomes[outcome] += 1
        repositories.add(truth["repository"])
        print(f"{outcome:10} {truth['expect']:6} {truth['repository']}:{truth['path']}: {detail[:300]}", flush=True)
        if asked.fit and outcome == UNDERSTOOD:
            print(f"{'':18}{_fit(path)}", flush=True)
    total = sum(outcomes.values())
    counts = ", ".join(f"{name} {outcomes[name]}" for name in (UNDERSTOOD, ASKED, REFUSED, MISREAD))
    print(f"{total} files of {len(repositories)} repositories: {counts}; {absent} absent")


if __name__ == "__main__":
    main()
