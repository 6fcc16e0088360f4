"""``erclutch report`` writes one file to look at and to forward."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

COMMAND = {
    "help": "Write the report of a run: one HTML file, or a PDF that a browser prints.",
    "panel": "The road of a log",
    "place": 5,
}


def report(
    run: Annotated[Path, Parameter(name="RUN")],
    /,
    *,
    title: str | None = None,
    device_name: str | None = None,
    author: str | None = None,
    date: str | None = None,
    note: str | None = None,
    out: Path | None = None,
    pdf: Annotated[bool, Parameter(negative=())] = False,
    open_: Annotated[bool, Parameter(name="--open", negative=())] = False,
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Write the report of a run: one HTML file that needs nothing else, from the run folder alone.

    Args:
        run: Folder that erclutch fit --out wrote. What is said of it below is kept there, in about.json.
        title: Title of the report. Default: the name of the log.
        device_name: Which device was measured, as people call it.
        author: Who measured it, or fitted it.
        date: Day, as 2026-07-31. Default: the day on which the run was written.
        note: A sentence or two under the title.
        out: File to write. Default: report.html (or report.pdf) in the run folder.
        pdf: Let a browser print it to a PDF, in place of the HTML file; so does an --out that ends in .pdf.
        open_: Open the file when it is written.
        force: Replace a file that is there and is no report.
    """
    from erclutch.report.html.report_file import may_write_report
    from erclutch.report.numbers.run_material import material_of
    from erclutch.runs.run_about import about_with, kept_about, write_about
    from erclutch.runs.run_folder import read_run

    pdf = pdf or (out is not None and out.suffix.lower() == ".pdf")
    endings = (".pdf",) if pdf else (".html",)
    if out is not None:
        may_write_report(out, force, endings)
    kept = read_run(run)
    path = out or run / f"report{endings[0]}"
    may_write_report(path, force, endings)
    about = {"title": title, "device": device_name, "author": author, "date": date, "note": note}
    if any(text is not None for text in about.values()):
        write_about(run, about_with(kept_about(run), **about))
    material = material_of(kept)
    if pdf:
        from erclutch.report.html.printed_page import print_report

        print_report(material, path)
    else:
        from erclutch.report.html.report_page import write_report

        write_report(material, path)
    say_written(path, open_)


def say_written(path: Path, open_: bool) -> None:
    """Name a file with its size, and show it in the browser if asked."""
    from erclutch.cli import terminal

    terminal.say(f"{path}: {path.stat().st_size / 1e6:.2f} MB")
    if open_:
        open_file(path)


def open_file(path: Path) -> None:
    """Show a file in the browser, or say that there is none."""
    import webbrowser

    from erclutch.cli import terminal

    if not webbrowser.open(path.resolve().as_uri()):
        terminal.say(f"No browser could be opened; the file is {path.resolve()}")
