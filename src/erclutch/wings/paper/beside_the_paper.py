"""A table of the paper stands beside ours: on the screen, and in LaTeX."""

from __future__ import annotations

from typing import Any

from erclutch.cli import terminal
from erclutch.report.printed_table import PRINTERS, Interval, PaperTable
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.tables import Row, printed


def on_screen(what: str, rows: list[Row], shown: list[str], origin: str, width: int) -> Any:
    """The table; on a narrow screen bands, seconds and ratios are left out, in this order."""
    cells = {"model": [_title_of(row) for row in rows]}
    for run in shown:
        bands: list[str] = []
        for row in rows:
            low, high = row.bands[run]
            bands.append(f"{low:.1e} - {high:.1e}")
        cells[f"{run}\n{origin}"] = [f"{row.errors[run]:.3e}" for row in rows]
        cells[f"{run}\n95 % band"] = bands
        cells[f"{run}\npaper"] = [or_dash(printed(row.name).get(run), "{:.3e}") for row in rows]

    # Table II has ratios of its training run alone, so their heading names no run.
    ratios: list[str] = []  # headings, the least needed first
    for run in shown[:1] if what == "table2" else shown:
        ours, papers = _to_bingham(rows, run)
        heading = "to Bingham" if what == "table2" else f"{run}\nto Bingham"
        cells[f"{heading}\n{origin}"] = [f"{ratio:.3f}" for ratio in ours]
        cells[f"{heading}\npaper"] = [or_dash(ratio, "{:.3f}") for ratio in papers]
        ratios = [f"{heading}\npaper", f"{heading}\n{origin}", *ratios]
    cells["CPU s"] = [f"{row.seconds:.2f}" for row in rows]

    less_needed = [f"{run}\n95 % band" for run in shown]
    less_needed += ["CPU s", *ratios]
    number = "II" if what == "table2" else "III"
    return terminal.narrowed(
        f"Table {number}: {origin} beside the paper", cells, less_needed, width
    )


def in_latex(rows: list[Row], runs: list[str], origin: str) -> str:
    """The table for a paper: errors with 95 % bands, the paper's own, and their ratios to Bingham."""
    header = ["Model"]
    lines: list[list[str | int | Interval]] = [[_title_of(row)] for row in rows]
    for run in runs:
        header += [
            f"{run}, {origin}",
            f"{run}, low",
            f"{run}, high",
            f"{run}, paper",
            "to Bingham",
            "paper",
        ]
        ratios, papers_ratios = _to_bingham(rows, run)
        for line, row, ratio, papers_ratio in zip(lines, rows, ratios, papers_ratios, strict=True):
            papers_error = printed(row.name).get(run)
            line.append((row.errors[run], *row.bands[run]))
            line.append("" if papers_error is None else f"{papers_error:.4e}".replace("e-0", "e-"))
            line.append(f"{ratio:.3f}")
            line.append("" if papers_ratio is None else f"{papers_ratio:.3f}")
    caption = f"Mean squared errors with 95 % bands on {origin} data, beside those that Huang and Ishikawa print."
    return PRINTERS["latex"](PaperTable(header, lines, caption))


def _title_of(row: Row) -> str:
    """What the paper calls a model, or what we do."""
    approach = APPROACHES.get(row.name)
    return row.title if approach is None else approach.title


def _to_bingham(rows: list[Row], run: str) -> tuple[list[float], list[float | None]]:
    """Errors on a run over that of the first model, which is Bingham's: ours, and the paper's."""
    bingham = rows[0]
    papers_bingham = printed(bingham.name).get(run)
    ours: list[float] = []
    papers: list[float | None] = []
    for row in rows:
        ours.append(row.errors[run] / bingham.errors[run])
        papers_error = printed(row.name).get(run)
        if papers_error is None or not papers_bingham:
            papers.append(None)
        else:
            papers.append(papers_error / papers_bingham)
    return ours, papers


def or_dash(value: float | None, form: str) -> str:
    """A number in a form such as ``{:.3f}``; a dash where there is none."""
    return "-" if value is None else form.format(value)
