"""``erclutch compare`` compares runs on the same rows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from erclutch.report.numbers.paired_runs import Pairing

COMMAND = {
    "help": "Compare runs on the rows that all of them held out.",
    "panel": "More logs",
    "place": 2,
}


def compare(
    runs: Annotated[tuple[Path, ...], Parameter(name="RUN", negative=())],
    /,
    *,
    model: Annotated[tuple[str, ...], Parameter(negative=(), show_default=False)] = (),
    out: Path | None = None,
    open_: Annotated[bool, Parameter(name="--open", negative=())] = False,
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Compare runs on the rows that all of them held out: difference of errors with its interval, settings that differ.

    Args:
        runs: Folders that erclutch fit --out wrote; differences are to the first folder.
        model: Model that stands for a run: one name for all runs, or a name for each. Default: the recommended model.
        out: HTML file to write the comparison to.
        open_: Open the file when it is written.
        force: Replace a file that is there and is no report.
        json: Print as JSON instead of tables.
    """
    from erclutch.cli import terminal
    from erclutch.errors import SettingError
    from erclutch.report.html.report_file import may_write_report
    from erclutch.report.numbers.paired_runs import pair
    from erclutch.runs.run_folder import read_run

    if open_ and out is None:
        raise SettingError("--open needs a file", remedy="Give --out FILE.html too")
    if out is not None:
        may_write_report(out, force, (".html",))
    found = pair([read_run(run) for run in runs], model)
    if json:
        terminal.say_json(_as_json(found))
    else:
        _print(found, runs)
    if out is not None:
        from erclutch.cli.commands.report import say_written
        from erclutch.report.html.runs_page import write_comparison

        written = write_comparison(found, out)
        if not json:
            say_written(written, open_)


def _as_json(found: Pairing) -> dict[str, Any]:
    """Figures in the effort's unit, each as value, low, high; differences are to the first run."""
    contenders = [
        {
            "run": str(c.run.folder),
            "model": c.model,
            "rmse": c.figures.rmse.to_list(),
            "difference": None if c.more is None else c.more.to_list(),
            "share": None if c.share is None else c.share.to_list(),
        }
        for c in found.contenders
    ]
    differing = {setting: list(values) for setting, values in found.differing}
    unit = found.contenders[0].run.body["units"]["effort"]
    return {"rows": found.rows, "unit": unit, "runs": contenders, "done_differently": differing}


def _print(found: Pairing, runs: Sequence[Path]) -> None:
    from erclutch.cli import terminal
    from erclutch.report.html.runs_page import band, joined, sentence, what_changed
    from erclutch.report.numbers.number_text import count, plain

    screen = terminal.console()
    scale = joined(found).effort
    screen.print(plain(f"{count(found.rows)} rows that all {len(runs)} runs held out"), markup=False)
    head = f"RMSE [{scale.unit}]" if scale.unit else "RMSE"
    rows = [
        [
            c.label,
            c.run.titles[c.model],
            scale.bare(c.figures.rmse.value, 4),
            scale.band(c.figures.rmse.to_list()),
            band(c.more, scale.factor),
            band(c.share, 100.0, "%"),
        ]
        for c in found.contenders
    ]
    columns = ["run", "model", head, "95 % band", "difference", "in per cent"]
    screen.print(terminal.table(f"Differences to {found.contenders[0].label}, paired", columns, rows, left=2))
    if found.differing:
        labels = [c.label for c in found.contenders]
        lines = [[name, *values] for name, values in found.differing]
        screen.print(terminal.table("What was done differently", ["setting", *labels], lines, left=len(labels) + 1))
    else:
        screen.print("Settings, reading and versions are the same.", markup=False)
    screen.print(plain(what_changed(found)), markup=False)
    screen.print(plain(sentence(found, scale)), style="bold", markup=False)
