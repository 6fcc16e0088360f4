"""``erclutch simulate`` writes logs of the digital twin."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import SECONDS
from erclutch.errors import SettingError
from erclutch.files import LOG_ENDINGS, may_write_file

if TYPE_CHECKING:
    from erclutch.wings.rig.twin.scenarios import TwinRun

COMMAND = {
    "help": "Run one of the paper's scenarios on the digital TWIN and write the log.",
    "panel": "The digital TWIN and the paper",
    "place": 1,
}


def simulate(
    scenario: Annotated[str | None, Parameter(name="SCENARIO")] = None,
    /,
    *,
    out: Path | None = None,
    seconds: Annotated[float | None, SECONDS] = None,
    seed: int = 0,
    rig_file: Path | None = None,
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Run one of the paper's scenarios on the digital TWIN and write the log. Without a scenario: list them.

    Args:
        scenario: Name of the scenario. Default: none; all are listed.
        out: Log to write: .parquet, .csv or .mat. Default: SCENARIO.parquet.
        seconds: Rig time; default: the scenario's own.
        seed: Seed of the commands and the noise.
        rig_file: A rig file (TOML) with what differs from the default rig.
        force: Replace a file that is there.
        json: Print as JSON.
    """
    from erclutch.wings.rig.twin.parameters import load_rig
    from erclutch.wings.rig.twin.scenarios import SCENARIOS, prepare

    if scenario is None:
        listed: list[dict[str, object]] = []
        rows: list[list[str]] = []
        for known in SCENARIOS.values():
            listed.append({"name": known.name, "what": known.meaning, "seconds": known.seconds})
            rows.append([known.name, known.meaning, f"{known.seconds:g} s"])
        if json:
            terminal.say_json(listed)
        else:
            terminal.tell(
                terminal.table(
                    "Scenarios of the digital TWIN", ["name", "what", "length"], rows, left=2
                )
            )
        if out or seconds or seed or rig_file:
            raise SettingError(
                "no scenario is named, and no log was written", remedy="Name a scenario of the list"
            )
        return
    path = out or Path(f"{scenario}.parquet")
    may_write_file(path, force, endings=LOG_ENDINGS)
    run = prepare(scenario, rig=load_rig(rig_file), seconds=seconds, seed=seed)
    collect(run, path)
    if json:
        about = {"log": str(path), "rows": run.rows, "seconds": run.rows / 1000, "seed": seed}
        terminal.say_json({**about, "device": "single" if run.scenario.single else "coaxial"})
        return
    size = path.stat().st_size / 1e6
    terminal.tell(
        f"TWIN {scenario}: {run.rows:,} rows, {run.rows / 1000:g} s of rig time, seed {seed}"
    )
    terminal.say(f"{path}: {size:.1f} MB")
    device = "" if run.scenario.single else " --device coaxial"
    terminal.say(f"Next: erclutch fit {shlex.quote(str(path))}{device}")


def collect(run: TwinRun, path: Path) -> Path:
    """Let the twin run and write its log, with a progress bar on a terminal's standard error."""
    from erclutch.logs.log_writer import write_log

    what = "TWIN: compiling once, then running"
    with terminal.progress(what) as bar:
        return write_log(
            path,
            run.names,
            run.chunks(),
            run.about(),
            rows=run.rows,
            progress=lambda s: bar(s, 1.0, what),
        )
