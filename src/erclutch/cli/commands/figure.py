"""``erclutch figure`` draws the report's plots for papers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from erclutch.cli.quantities import SECONDS

COMMAND = {
    "help": "Draw a figure of a run for a paper: PDF, PNG and the numbers behind it.",
    "panel": "For papers",
    "place": 1,
}


def figure(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    run: Annotated[Path | None, Parameter(name="RUN")] = None,
    /,
    *,
    out: Path = Path("figures"),
    start: Annotated[float | None, SECONDS] = None,
    seconds: Annotated[float | None, SECONDS] = None,
    as_: Annotated[
        tuple[Literal["pdf", "png", "svg", "pgf"], ...],
        Parameter(name="--as", consume_multiple=True, negative=()),
    ] = ("pdf", "png"),
    wide: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Draw a figure of a run at IEEE column width, with the numbers behind it as CSV. Without a name: list.

    Args:
        name: Which figure: ranking, trace, error-map, parity, residual, model, flow-curves, loops or lag; 'all' for
            all that the run can give.
        run: Folder that erclutch fit --out wrote.
        out: Folder for the files.
        start: First second of a trace, on the log's own clock.
        seconds: Length of a trace.
        as_: Formats: pdf, png, svg, or pgf, which needs LaTeX.
        wide: Draw over both columns of a page.
    """
    from erclutch.cli import terminal
    from erclutch.cli.lone_run import lone_run
    from erclutch.errors import CheckError, SettingError, did_you_mean
    from erclutch.files import may_fill
    from erclutch.files.groups import together
    from erclutch.report.plots.run_plots import FIGURES, write_figure

    screen = terminal.console()
    if name is None:
        rows = [[key, meaning] for key, (meaning, _) in FIGURES.items()]
        screen.print(terminal.table("Figures of a run", ["name", "what"], rows, left=2))
        return
    if name != "all" and name not in FIGURES:
        hint = did_you_mean(name, FIGURES)
        raise SettingError(
            f"no figure {name!r}",
            remedy=f"{hint}Figures are {', '.join(FIGURES)}, or all of them: all",
        )
    run = run or lone_run()
    if run is None:
        raise SettingError("no run was given", remedy=f"Write erclutch figure {name} RUN")
    may_fill(out)
    from erclutch.report.numbers.run_material import material_of
    from erclutch.runs.run_folder import read_run

    material = material_of(read_run(run))
    written: list[Path] = []
    with together():
        for one in FIGURES if name == "all" else (name,):
            try:
                written += write_figure(
                    one, material, out, start=start, seconds=seconds, kinds=as_, wide=wide
                )
            except CheckError as error:
                if name != "all":
                    raise
                screen.print(
                    f"{one} left out: {error.problem}", style="dim", markup=False, soft_wrap=True
                )
    for path in written:
        screen.print(str(path), markup=False, soft_wrap=True)
