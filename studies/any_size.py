"""What is lost where models are fitted to stretches of a log beyond memory, and not to all of its rows.

    python studies/any_size.py LOG.parquet --memory 1.5 --models hem+lag casson+lag+dahl/field

Each model is fitted to the stretches that `erclutch fit` keeps, and to all rows ahead of those that it holds out. Both
are scored on every row that is held out. The log must fit into the memory of this machine.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from time import process_time

from erclutch.fit.candidate import kinds
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.any_size import read_rows
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out
from erclutch.logs.reading import Reading
from erclutch.runs.every_row import score_every_row
from erclutch.runs.scoring_plan import plan_of_rows
from erclutch.runs.tasks import Tasks


def fitted(train: Dataset, name: str) -> tuple[AnyOutcome, float]:
    """A model fitted to some rows, and the CPU s that it took."""
    settings = Settings((name,), lag="none")
    (candidate,) = [each for _, kind in kinds() for each in kind.candidates(settings, train)]
    began = process_time()
    with one_thread():
        outcome = candidate.fit(train, (), 1)
    return outcome, process_time() - began


def main() -> None:
    """Print a line for each model."""
    parser = argparse.ArgumentParser(
        description="Fits to stretches of a log beside fits to all of its rows."
    )
    parser.add_argument("log", type=Path)
    parser.add_argument("--memory", type=float, default=1.5, help="GB, as of erclutch fit")
    parser.add_argument("--models", nargs="+", default=["hem+lag", "casson+lag+dahl/field"])
    asked = parser.parse_args()
    how = Reading()
    rows = read_rows([asked.log], how, memory=1e9 * asked.memory)
    test = hold_out(rows.data, 0.3)
    plan = plan_of_rows(rows, test)
    whole = build_dataset(how.read(asked.log, rows.data.device))
    held_out = plan.logs[0].held_out.of(0, whole.rows)
    kept, all_rows = rows.data.take(~test), whole.take(~held_out)
    label = f"{', '.join(filter(None, rows.data.origins)) or 'no label'}: {asked.log.name}"
    print(
        f"{label}, {whole.rows:,} rows, {held_out.sum():,} held out; fitted on {kept.rows:,} and on {all_rows.rows:,}"
    )
    print(
        f"{'model':44}{'RMSE kept':>12}{'RMSE all':>12}{'kept over all':>15}{'CPU s':>8}{'CPU s':>8}",
        flush=True,
    )
    for name in asked.models:
        (of_kept, seconds), (of_all, more_seconds) = (
            fitted(train, name) for train in (kept, all_rows)
        )
        models = {"kept": of_kept.model, "all": of_all.model}
        figures = score_every_row(replace(plan, run=""), models, how, Tasks(None))
        one, other = (figures.test[key].rmse.value for key in ("kept", "all"))
        print(
            f"{name:44}{one:12.6f}{other:12.6f}{one / other - 1:+15.2%}{seconds:8.1f}{more_seconds:8.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
