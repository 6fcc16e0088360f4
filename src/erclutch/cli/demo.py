"""``erclutch demo``: the whole road on a log that the project makes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def _make(folder: Path) -> None:
    from erclutch.errors import RunError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot be made: {error.strerror}", where=str(folder), remedy="Give another --keep") from error


def demo(
    *,
    seconds: Annotated[float, Parameter()] = 20.0,
    seed: Annotated[int, Parameter()] = 0,
    keep: Annotated[Path | None, Parameter()] = None,
) -> None:
    """Make a small SYNTHETIC log, fit all models to it and print the table.

    Args:
        seconds: Length of the log.
        seed: Seed of its random command, motion and noise.
        keep: Folder to keep the log and the run in.
    """
    import tempfile
    import time

    from erclutch.errors import SettingError

    if not 2.0 <= seconds <= 3600.0 or seed < 0:
        raise SettingError(f"--seconds {seconds:g} --seed {seed}", remedy="Give 2 to 3600 seconds, a seed of 0 or more")
    from erclutch.cli import show
    from erclutch.cli.fit import compare_with_progress, print_comparison
    from erclutch.comparison import Settings
    from erclutch.dataset import build_dataset
    from erclutch.demo import write_synthetic_log
    from erclutch.logs import read
    from erclutch.runs import write_run

    screen = show.console()
    screen.print(
        "SYNTHETIC data: a made-up ER clutch with elastic chains, shear thinning and a 4 ms lag. It is neither a "
        "measurement nor the digital twin, and its law is none of those fitted.",
        style="magenta",
    )
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        if keep is not None:
            _make(keep)
        log = (keep or Path(scratch)) / "synthetic.csv"
        write_synthetic_log(log, seconds, seed)
        recording = read(log)
        screen.print("\n".join(show.recording_lines([recording])), markup=False)
        comparison = compare_with_progress(build_dataset(recording), Settings())
        print_comparison(comparison)
        screen.print(f"{len(comparison.entries)} models in {time.perf_counter() - began:.1f} s", markup=False)
        if keep is not None:
            run = write_run(keep / "run", comparison, [recording], force=True)
            screen.print(f"Kept: {log} and {run}", markup=False, soft_wrap=True)
    screen.print("Your own log: erclutch inspect LOG, then erclutch fit LOG.", markup=False)
