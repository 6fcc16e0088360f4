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
#: Endings that say a format.
_ENDINGS = {
    ".tex": "latex",
    ".md": "markdown",
    ".html": "html",
    ".htm": "html",
    ".csv": "csv",
}


def table(
    run: Annotated[Path, Parameter(name="RUN")],
    /,
    *,
    as_: Annotated[
        Literal["latex", "markdown", "html", "csv"] | None, Parameter(name="--as")
    ] = None,
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
            Default: by the ending of --out, else markdown.
        what: The ranking of the models, or the parameters of a model with their intervals.
        model: The model whose parameters are printed, with --what parameters. Default: the recommended.
        most: Only the first so many models of the ranking; not for parameters.
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
    if model is not None and what == "ranking":
        raise SettingError(
            "the ranking is of all models, and --model names one",
            remedy="Add --what parameters, or leave --model out",
        )
    if most is not None and what == "parameters":
        raise SettingError(
            "the parameters are of one model, and --most counts models",
            remedy="Leave --most out, or print the ranking",
        )
    of_ending = None if out is None else _ENDINGS.get(out.suffix.lower())
    format_ = as_ or of_ending or "markdown"
    # A browser would take markdown of a page's name for a page.
    if of_ending not in (None, format_):
        problem = f"--as {format_} for a file whose name ends in {out.suffix if out else ''}"
        raise SettingError(
            problem, where=str(out), remedy=f"Give --as {of_ending}, or another --out"
        )
    may_write_file(out, force)
    kept = read_run(run)
    numbers = parameter_table(kept, model) if what == "parameters" else ranking_table(kept, most)
    text = PRINTERS[format_](numbers)
    if out is None:
        sys.stdout.write(text)
        return
    from erclutch.cli.terminal import say
    from erclutch.report.plots.paper_style import placed

    with placed(out) as partial:
        partial.write_text(text, encoding="utf-8")
    say(out)
