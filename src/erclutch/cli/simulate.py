"""``erclutch simulate``: logs from the digital twin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from erclutch.rig.scenarios import TwinRun


def simulate(
    scenario: Annotated[str | None, Parameter(name="SCENARIO")] = None,
    *,
    out: Path | None = None,
    seconds: float | None = None,
    seed: int = 0,
    rig: Path | None = None,
) -> None:
    """Run one of the paper's scenarios on the digital TWIN and write the log. Without a scenario: list them.

    Args:
        scenario: Which run.
        out: Log to write: .parquet, .csv or .mat. Default: SCENARIO.parquet.
        seconds: Rig time; default: the scenario's own.
        seed: Seed of the commands and the noise.
        rig: A rig file (TOML) with what differs from the default rig.
    """
    from erclutch.cli import show
    from erclutch.rig.parameters import load_rig
    from erclutch.rig.scenarios import SCENARIOS, prepare

    output = show.console()
    if scenario is None:
        rows = [[s.name, s.meaning, f"{s.seconds:g} s"] for s in SCENARIOS.values()]
        output.print(show.table("Scenarios of the digital TWIN", ["name", "what", "length"], rows, left=2))
        return
    run = prepare(scenario, rig=None if rig is None else load_rig(rig), seconds=seconds, seed=seed)
    path = collect(run, out or Path(f"{scenario}.parquet"))
    size = path.stat().st_size / 1e6
    output.print(f"TWIN {scenario}: {run.rows:,} rows, {run.rows / 1000:g} s of rig time, seed {seed}", markup=False)
    output.print(f"{path}: {size:.1f} MB", markup=False, soft_wrap=True)
    device = "" if run.scenario.single else " --device coaxial"
    output.print(f"Next: erclutch fit {path}{device}", markup=False, soft_wrap=True)


def collect(run: TwinRun, path: Path) -> Path:
    """Let the twin run and write its log, with a progress bar on a terminal's standard error."""
    from rich.console import Console
    from rich.progress import Progress

    from erclutch.rig.log_file import write_log

    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("TWIN: compiling once, then running", total=1.0)
        return write_log(
            path,
            run.names,
            run.chunks(),
            run.about(),
            rows=run.rows,
            progress=lambda share: bar.update(task, completed=share),
        )
