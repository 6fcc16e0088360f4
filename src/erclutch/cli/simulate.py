"""``erclutch simulate``: logs from the digital twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


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
    from rich.console import Console
    from rich.progress import Progress

    from erclutch.cli import show
    from erclutch.rig.log_file import write_log
    from erclutch.rig.parameters import load_rig
    from erclutch.rig.scenarios import SCENARIOS, prepare

    output = show.console()
    if scenario is None:
        rows = [[s.name, s.meaning, f"{s.seconds:g} s"] for s in SCENARIOS.values()]
        output.print(show.table("Scenarios of the digital TWIN", ["name", "what", "length"], rows, left=2))
        return
    run = prepare(scenario, rig=None if rig is None else load_rig(rig), seconds=seconds, seed=seed)
    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("TWIN: compiling once, then running", total=1.0)
        path = write_log(
            out or Path(f"{scenario}.parquet"),
            run.names,
            run.chunks(),
            run.about(),
            rows=run.rows,
            progress=lambda share: bar.update(task, completed=share),
        )
    size = path.stat().st_size / 1e6
    output.print(f"TWIN {scenario}: {run.rows:,} rows, {run.rows / 1000:g} s of rig time, seed {seed}", markup=False)
    output.print(f"{path}: {size:.1f} MB", markup=False, soft_wrap=True)
    device = "" if run.scenario.single else " --device coaxial"
    output.print(f"Next: erclutch fit {path}{device}", markup=False, soft_wrap=True)
