"""``erclutch table`` prints tables of a run for papers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

COMMAND = {
    "help": "Print a table of a run for a paper: LaTeX, Markdown, HTML or CSV.",
    "panel": "For papers",
    "place": 2,
}


def table(
    run: Annotated[Path, Parameter(name="RUN")],
    /,
    *,
    as_: Annotated[
        Literal["latex", "markdown", "html", "csv"], Parameter(name="--as")
    ] = "markdown",
    what: Literal["ranking", "parameters"] = "ranking",
    model: str | None = None,
    most: int | None = None,
    out: Path | None = None,
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Print a table of a run for a paper, rounded to the digits that the intervals allow.

    Args:
        run: Folder that erclutch fit --out wrote.
        as_: Format: latex (booktabs, and siunitx columns), markdown, html, or csv, which is not rounded.
        what: The ranking of the models, or the parameters of a model with their intervals.
        model: The model whose parameters are printed. Default: the recommended.
        most: Only the first so many models of the ranking.
        out: File to write. Default: the terminal.
        force: Replace a file that is there.
    """
    import sys

    from erclutch.errors import SettingError
    from erclutch.files import may_write_file
    from erclutch.report.printed_table import PRINTERS, parameter_table, ranking_table
    from erclutch.runs.run_folder import read_run

    if most is not None and most < 1:
        raise SettingError(f"--most {most}", remedy="Give 1 or more")
    may_write_file(out, force)
    kept = read_run(run)
    numbers = parameter_table(kept, model) if what == "parameters" else ranking_table(kept, most)
    text = PRINTERS[as_](numbers)
    if out is None:
        sys.stdout.write(text)
        return
    from erclutch.cli.terminal import say
    from erclutch.report.plots.paper_style import placed

    with placed(out) as partial:
        partial.write_text(text, encoding="utf-8")
    say(out)
