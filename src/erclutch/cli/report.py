"""``erclutch report``: one file to look at and to forward."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def report(
    run: Annotated[Path, Parameter(name="RUN")],
    *,
    out: Path | None = None,
    pdf: Annotated[bool, Parameter(negative=())] = False,
    open_: Annotated[bool, Parameter(name="--open", negative=())] = False,
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Write the report of a run: one HTML file that needs nothing else, from the run folder alone.

    Args:
        run: Folder that erclutch fit --out wrote.
        out: File to write. Default: report.html (or report.pdf) in the run folder.
        pdf: Write pages for print in place of the HTML file.
        open_: Open it when it is written.
        force: Replace a file that is there and is no report.
    """
    from erclutch.cli import show
    from erclutch.diagnostics.material import material_of
    from erclutch.report.output import may_write_report
    from erclutch.runs import read_run

    found = read_run(run)
    path = out or run / ("report.pdf" if pdf else "report.html")
    may_write_report(path, force)
    material = material_of(found)
    if pdf:
        from erclutch.report.printed import write_pdf

        write_pdf(material, path)
    else:
        from erclutch.report.page import write_report

        write_report(material, path)
    show.console().print(f"{path}: {path.stat().st_size / 1e6:.2f} MB", markup=False, soft_wrap=True)
    if open_:
        open_file(path)


def open_file(path: Path) -> None:
    """Show a file in the browser, or say that there is none."""
    import webbrowser

    from erclutch.cli import show

    if not webbrowser.open(path.resolve().as_uri()):
        show.console().print(f"No browser could be opened; the file is {path.resolve()}", markup=False, soft_wrap=True)
