"""``erclutch demo``: the whole road, with the digital twin as the rig."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

_WHAT = (
    "TWIN: a digital twin of the rig of Huang and Ishikawa (two ER clutches on a ball screw) collects a log as in "
    "their section III-B: random square and sine fields, one clutch at a time, random motor torque. It is no "
    "measurement, and none of the models below is what it is made of."
)


def demo(
    *,
    seconds: Annotated[float, Parameter()] = 60.0,
    seed: Annotated[int, Parameter()] = 0,
    keep: Annotated[Path | None, Parameter()] = None,
) -> None:
    """Let the digital TWIN collect a log, fit every model of the paper's table II to it and print the ranking.

    Args:
        seconds: Rig time of the log.
        seed: Seed of its commands and noise.
        keep: Folder to keep the log and the run in.
    """
    import tempfile
    import time

    from erclutch.errors import RunError, SettingError

    if not 10.0 <= seconds <= 3600.0 or seed < 0:
        raise SettingError(
            f"--seconds {seconds:g} --seed {seed}", remedy="Give 10 to 3600 seconds, a seed of 0 or more"
        )
    from erclutch.cli import show

    screen = show.console()
    screen.print(_WHAT, style="magenta")
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        folder = keep or Path(scratch)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RunError(
                f"cannot be made: {error.strerror}", where=str(folder), remedy="Give another --keep"
            ) from error
        _run(folder, seconds, seed, keep is not None)
    screen.print(f"{time.perf_counter() - began:.0f} s in all", markup=False)
    screen.print("Your own log: erclutch inspect LOG, then erclutch fit LOG.", markup=False)


def _run(folder: Path, seconds: float, seed: int, kept: bool) -> None:
    from erclutch.cli import show
    from erclutch.cli.fit import compare_with_progress, print_comparison
    from erclutch.cli.simulate import collect
    from erclutch.comparison import Settings
    from erclutch.dataset import build_dataset
    from erclutch.differentiate import Derivative
    from erclutch.logs import read
    from erclutch.rig.scenarios import prepare
    from erclutch.runs import write_run

    screen = show.console()
    log = collect(prepare("training", seconds=seconds, seed=seed), folder / "twin.parquet")
    recording = read(log, device="coaxial")
    screen.print("\n".join(show.recording_lines([recording])), markup=False)
    data = build_dataset(recording, device="coaxial", derivative=Derivative("difference"))
    comparison = compare_with_progress(data, Settings(models=("paper",), lag="none"))
    print_comparison(comparison)
    if kept:
        reading = {"device": "coaxial", "derivative": "difference"}
        run = write_run(folder / "run", comparison, [recording], reading=reading, force=True)
        screen.print(f"Kept: {log} and {run}", markup=False, soft_wrap=True)
