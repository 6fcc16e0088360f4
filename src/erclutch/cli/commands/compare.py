"""``erclutch compare`` compares runs on the same rows."""

from __future__ import annotations

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
    pairing = pair([read_run(run) for run in runs], model)
    if json:
        # Figures in the effort's unit, each as value, low, high; differences are to the first run.
        of_runs: list[dict[str, Any]] = []
        for contender in pairing.contenders:
            more, share = contender.more, contender.share  # of the first run there are none
            of_runs.append(
                {
                    "run": str(contender.run.folder),
                    "model": contender.model,
                    "rmse": contender.figures.rmse.to_list(),
                    "difference": None if more is None else more.to_list(),
                    "share": None if share is None else share.to_list(),
                }
            )
        terminal.say_json(
            {
                "rows": pairing.rows,
                "unit": pairing.contenders[0].run.body["units"]["effort"],
                "runs": of_runs,
                "done_differently": {name: list(values) for name, values in pairing.differing},
            }
        )
    else:
        _print(pairing)
    if out is not None:
        from erclutch.cli.commands.report import say_written
        from erclutch.report.html.runs_page import write_comparison

        written = write_comparison(pairing, out)
        if not json:
            say_written(written, open_)


def _print(pairing: Pairing) -> None:
    from erclutch.cli import terminal
    from erclutch.report.html.runs_page import band, joined, sentence, what_changed
    from erclutch.report.numbers.number_text import count, plain

    screen = terminal.console()
    scale = joined(pairing).effort
    labels = [contender.label for contender in pairing.contenders]
    screen.print(
        plain(f"{count(pairing.rows)} rows that all {len(labels)} runs held out"), markup=False
    )
    rows: list[list[str]] = []
    for contender in pairing.contenders:
        rmse = contender.figures.rmse
        rows.append(
            [
                contender.label,
                contender.run.titles[contender.model],
                scale.bare(rmse.value, 4),
                scale.band(rmse.to_list()),
                band(contender.more, scale.factor),
                band(contender.share, 100.0, "%"),
            ]
        )
    error = f"RMSE [{scale.unit}]" if scale.unit else "RMSE"
    columns = ["run", "model", error, "95 % band", "difference", "in per cent"]
    screen.print(terminal.table(f"Differences to {labels[0]}, paired", columns, rows, left=2))
    if pairing.differing:
        settings = [[name, *values] for name, values in pairing.differing]
        columns = ["setting", *labels]
        screen.print(
            terminal.table("What was done differently", columns, settings, left=len(columns))
        )
    else:
        screen.print("Settings, reading and versions are the same.", markup=False)
    screen.print(plain(what_changed(pairing)), markup=False)
    in_plain_words = plain(sentence(pairing, scale))
    screen.print(in_plain_words, style="bold", markup=False)
