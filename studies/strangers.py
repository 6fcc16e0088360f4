"""Copies of public files are planned, and each plan is held against what is true: `python studies/strangers.py FOLDER`.

FOLDER holds a copy of each file of `strangers.toml` as OWNER+NAME/PATH, at the commit named there; a file that is not
there is passed over. Printed: a row a file, then how many were understood at once, asked about, refused, misread and
ended in a traceback, and of those that hold what a device needs, how many took one try and two.

What is asked is asked once more with the command that `inspect` prints in its last line: as it is (second), or with
the one thing that it leaves open and the file does not hold, the rate or a unit (filled). A flow curve is read by
`flowcurve`, as `inspect` says. With --fit the logs are fitted too: at once, or by that command. With --sealed NAME the
files of a sealed set are judged in place of the open ones.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import ErclutchError
from erclutch.logs import (
    ColumnMap,
    Plan,
    Table,
    apply,
    plan_of,
    read_table,
    recordings_in,
    table_of_log,
)
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.joints_of_log import plans_of_joints
from erclutch.logs.log_file import wants_each
from erclutch.logs.plan import Joint
from erclutch.logs.planning.recording_choice import AlikeRecordingsError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

MANIFEST = Path(__file__).with_name("strangers.toml")
SIGNALS = ("field", "slip", "position", "effort")
AS_LOGGED = "as logged"
UNDERSTOOD, SECOND, FILLED, ASKED, REFUSED, MISREAD, CRASHED = (
    "understood",
    "second",
    "filled",
    "asked",
    "refused",
    "misread",
    "crashed",
)
_PLACE = re.compile(r"COLUMN|RATE Hz|NAME|NUMBER|\[UNIT\]")
#: Options that may be given several times, each with a signal and its number.
_OF_SIGNALS = ("constant", "scale", "zero")
#: What stands for an answer that only the user knows: a rate, the unit of a viscosity, and the unit of an effort.
_ANSWERS = {"RATE Hz": "100 Hz", "[UNIT]": "[mPa*s]"}
_UNIT_OF_EFFORT = "[N*m]"
FIT_MODELS = (
    "bingham",
    "casson",
)  # two that every log can have: fit is run to see that a read log goes on


def _column(label: str) -> str:
    """The name that the readers give a column of this label."""
    return name_columns([label])[0][0]


def _faults(plan: Plan, table: Table, truth: dict[str, Any]) -> Iterator[str]:
    """Where a plan differs from the truth, one sentence each; what it asks about is no fault."""
    rows = truth.get("rows", table.rows)
    if table.rows != rows:
        yield f"{table.rows} rows of {rows}"
    joints = {
        part for each in plan.signals for part in truth.get("joints", ()) if part in each.column
    }
    if len(joints) > 1:
        yield f"signals of {' and '.join(sorted(joints))}"
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


def _last_command(path: Path) -> list[str]:
    """The words of the command in the last line of `inspect`; none where it prints no command, or one to fill in."""
    done = _run("inspect", str(path))
    last = (done.stdout.strip().splitlines() or [""])[-1]
    found = re.search(r"(?:settles it|say so|flow curve): erclutch (.+)", last)
    return shlex.split(found.group(1)) if found else []


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "erclutch", *words],
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )


def _is_right(words: list[str], path: Path, truth: dict[str, Any]) -> str:
    """The fault of a reading by a command, one sentence; "" for none."""
    if words[0] == "flowcurve":
        return _flow_fault(path, truth, words[2:])
    told: dict[str, Any] = {}
    for option, value in zip(words[2::2], words[3::2], strict=False):
        name = option.removeprefix("--").replace("-", "_")
        told[name] = [*told.get(name, []), value] if name in _OF_SIGNALS else value
    variable = told.pop("variable", None)
    device = told.pop("device", None)
    invalid: Any = told.pop("invalid", None)
    try:
        names = recordings_in(path, variable) if wants_each(variable) else [variable]
        mapping = ColumnMap.from_options(told)
        faults: list[str] = []
        rows = 0
        for name in names:
            table = read_table(path, variable=name) if name else table_of_log(path, mapping, device)  # type: ignore[arg-type]
            plan = plan_of(table, mapping, device=device, invalid=invalid)  # type: ignore[arg-type]
            if wants_each(variable) and not plan.is_of_a_log:
                continue
            faults += _faults(plan, table, truth)
            faults += [question.short for question in plan.questions]
            rows += 0 if plan.questions else apply(plan, table).rows
    except ErclutchError as error:
        return str(error)
    return "; ".join(faults) or ("" if rows else "no rows")


def _flow_fault(path: Path, truth: dict[str, Any], words: list[str] | None = None) -> str:
    """What is wrong with the flow curves of a file, as `flowcurve` reads it with some options."""
    told: dict[str, list[str]] = {"--shear-rate": [], "--stress": [], "--sheet": []}
    option = ""
    for word in words or []:
        if word.startswith("--"):
            option = word
        else:
            told[option].append(word)
    rate = told["--shear-rate"]
    try:
        curves = read_flow_curves(
            path,
            shear_rate=rate[0] if rate else None,
            stress=told["--stress"],
            sheet=told["--sheet"],
        )
    except ErclutchError as error:
        return str(error)
    wanted = truth.get("curves")
    found = len(curves.curves)
    return "" if wanted in (None, found) else f"{found} flow curves of {wanted}"


def judged(path: Path, truth: dict[str, Any]) -> tuple[str, str]:
    """The outcome of one file, and what was asked, refused or misread."""
    if "curves" in truth:
        fault = _flow_fault(path, truth)
        return (UNDERSTOOD, f"{truth['curves']} flow curves") if not fault else (REFUSED, fault)
    try:
        table = table_of_log(path, ColumnMap(), None)
        plan = plan_of(table, ColumnMap())
    except AlikeRecordingsError:
        fault = _is_right(["inspect", str(path), "--variable", "all"], path, truth)
        if not fault and not truth["holds"]:
            return _of_rows_that_lack_something(path, truth)
        return (MISREAD, fault) if fault else (UNDERSTOOD, "several logs of the same columns")
    except ErclutchError as error:
        return (ASKED if "variable" in error.remedy else REFUSED), str(error)
    if joints := plans_of_joints(plan, table):
        return _of_joints(joints, table, truth)
    if faults := list(_faults(plan, table, truth)):
        return MISREAD, "; ".join(faults)
    if plan.questions or plan.doubts:
        return ASKED, "; ".join([*(each.short for each in plan.questions), *plan.doubts])
    try:
        recording = apply(plan, table)
    except ErclutchError as error:
        return REFUSED, str(error)
    if not truth["holds"]:
        return _of_rows_that_lack_something(path, truth)
    return UNDERSTOOD, f"{recording.rows} rows"


def _of_joints(
    joints: Mapping[Joint, Plan], table: Table, truth: dict[str, Any]
) -> tuple[str, str]:
    """The outcome of a file of several joints, each of which is fitted by itself."""
    faults: list[str] = []
    for joint, plan in joints.items():
        faults += [f"{joint.name}: {fault}" for fault in _faults(plan, table, truth)]
    try:
        for plan in joints.values():
            apply(plan, table)
    except ErclutchError as error:
        return REFUSED, str(error)
    if faults:
        return MISREAD, "; ".join(faults)
    if not truth["holds"]:
        return MISREAD, f"taken without a question: {truth['why']}"
    return UNDERSTOOD, f"{len(joints)} joints"


def _of_rows_that_lack_something(path: Path, truth: dict[str, Any]) -> tuple[str, str]:
    """The outcome of a file whose columns are read and whose rows lack something: `inspect` looks at the rows too."""
    last = (_run("inspect", str(path)).stdout.strip().splitlines() or [""])[-2:]
    for line in last:
        if "Not understood yet" in line:
            return ASKED, line
        if "nothing can be fitted" in line:
            return REFUSED, line
    return MISREAD, f"taken without a question: {truth['why']}"


def _second_try(path: Path, truth: dict[str, Any]) -> tuple[str, list[str], str]:
    """What the command that `inspect` prints makes of the file, its words, and what is wrong."""
    words = _last_command(path)
    open_ones = [word for word in words if _PLACE.search(word)]
    left_open = {_PLACE.search(word)[0] for word in open_ones}  # type: ignore[index]
    if not words or len(left_open) > 1 or not left_open <= {*_ANSWERS}:
        return ASKED, [], "no command, or with columns to fill in"
    for at, word in enumerate(words):
        unit = _UNIT_OF_EFFORT if words[at - 1] == "--effort" else _ANSWERS["[UNIT]"]
        words[at] = word.replace("[UNIT]", unit).replace("RATE Hz", _ANSWERS["RATE Hz"])
    fault = _is_right(words, path, truth)
    return ASKED if fault else FILLED if open_ones else SECOND, words, fault


def _in_two_tries(path: Path, truth: dict[str, Any]) -> tuple[str, str, list[str]]:
    """The outcome of one file at once or by the printed command, what was said, and the options of that command."""
    outcome, detail = judged(path, truth)
    if outcome in (MISREAD, UNDERSTOOD) or not truth["holds"]:
        return outcome, detail, []
    second, words, fault = _second_try(path, truth)
    if words:
        detail += f" => erclutch {shlex.join(words)[:300]}"
    if fault:
        detail += f" => {fault}"
    return (outcome if second == ASKED else second), detail, words[2:]


def _fit(path: Path, options: list[str]) -> str:
    with tempfile.TemporaryDirectory() as folder:
        done = _run("fit", str(path), *options, "--out", f"{folder}/run", "--models", *FIT_MODELS)
        last = (done.stdout + done.stderr).strip().splitlines()[-1:]
        return f"fit: exit code {done.returncode}, {' '.join(last)[:160]}"


def main() -> None:
    """Print a row a file and the totals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--sealed", default="", metavar="NAME", help="first, second, third, fourth or fifth"
    )
    parser.add_argument("--fit", action="store_true")
    parser.add_argument("--only", default="", help="repositories whose name holds this")
    asked = parser.parse_args()
    outcomes = Counter[str]()
    of_logs = Counter[str]()
    repositories = set[str]()
    absent = 0
    for truth in tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["file"]:
        if truth.get("sealed", "") != asked.sealed or asked.only not in truth["repository"]:
            continue
        path: Path = asked.folder / truth["repository"].replace("/", "+") / truth["path"]
        if not path.is_file():
            absent += 1
            continue
        if hashlib.sha256(path.read_bytes()).hexdigest() != truth["sha256"]:
            sys.exit(
                f"{path} is another file than that of the manifest: fetch it at commit {truth['commit']}"
            )
        options: list[str] = []
        try:
            outcome, detail, options = _in_two_tries(path, truth)
        # A user would see its traceback: it is counted, and the other files are judged.
        except Exception as error:
            outcome, detail = CRASHED, repr(error)
        outcomes[outcome] += 1
        of_logs[outcome] += truth["holds"]
        repositories.add(truth["repository"])
        holds = "holds" if truth["holds"] else "lacks"
        print(
            f"{outcome:10} {holds} {truth['repository']}:{truth['path']}: {detail[:900]}",
            flush=True,
        )
        if asked.fit and outcome in (UNDERSTOOD, SECOND, FILLED) and "curves" not in truth:
            print(f"{'':17}{_fit(path, options)}", flush=True)
    total, logs = sum(outcomes.values()), sum(of_logs.values())
    names = (UNDERSTOOD, SECOND, FILLED, ASKED, REFUSED, MISREAD, CRASHED)
    counts = ", ".join(f"{name} {outcomes[name]}" for name in names)
    print(f"{total} files of {len(repositories)} repositories: {counts}; {absent} absent")
    counts = ", ".join(f"{name} {of_logs[name]}" for name in names)
    print(f"{logs} of them hold what a device needs: {counts}")


if __name__ == "__main__":
    main()
