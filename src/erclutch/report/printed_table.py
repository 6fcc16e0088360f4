"""Tables of a run for a paper: LaTeX, Markdown, HTML or CSV, with as many digits as the intervals allow."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from erclutch.errors import SettingError
from erclutch.export.encode import latex, markdown, markup
from erclutch.fit.standing import chosen_name, standing_of_run
from erclutch.report.numbers.number_text import unit_text
from erclutch.runs.run_folder import Run

#: A figure with the ends of its interval, printed in three columns.
Interval: TypeAlias = tuple[float | None, float | None, float | None]
_PLAIN = 4  # digits of a figure without an interval
_WIDTH_DIGITS = 2  # digits of an interval's half-width
_LONG = 26  # letters from which a column of texts is broken into lines in LaTeX
_PARAGRAPH, _BREAK = r">{\raggedright\arraybackslash}p{0.3\linewidth}", r"\allowbreak{}"
_NUMBER = re.compile(r"-?\d+(\.\d*)?(e[+-]?\d+)?")
_SMALL, _LARGE = -3, 6  # powers of ten beyond which an exponent is read more easily


@dataclass(frozen=True)
class PaperTable:
    """A table for a paper.

    Attributes:
        header: of the columns; one for each end of an interval.
        rows: texts, whole numbers and intervals.
        caption: one sentence.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str | int | Interval]]
    caption: str

    def cells(self) -> list[list[str]]:
        """Rows as text, rounded."""
        return [
            [text for cell in row for text in (rounded(cell) if isinstance(cell, tuple) else [str(cell)])]
            for row in self.rows
        ]


def rounded(figure: Interval) -> list[str]:
    """Value, low and high to the digit that the interval's width allows; empty where there is none."""
    known = [abs(v) for v in figure if v is not None and math.isfinite(v) and v != 0.0]
    if not known:
        return ["0" if v == 0.0 else "" for v in figure]
    power = math.floor(math.log10(max(known)))
    half = 0.5 * (figure[2] - figure[1]) if figure[1] is not None and figure[2] is not None else 0.0
    last = math.floor(math.log10(half)) - _WIDTH_DIGITS + 1 if 0.0 < half < math.inf else power - _PLAIN + 1
    shown = power if power < _SMALL or power >= _LARGE else 0
    return [_fixed(v, shown, max(0, shown - last)) for v in figure]


def _fixed(value: float | None, power: int, places: int) -> str:
    """A number to so many places before a power of ten; what would be rounded to 0 keeps a digit of its own."""
    if value is None or not math.isfinite(value):
        return ""
    text = f"{value / 10.0**power:.{places}f}" + (f"e{power}" if power else "")
    if value != 0.0 and float(text) == 0.0:
        mantissa, _, exponent = f"{value:.0e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    return text


def ranking_table(run: Run, most: int | None = None) -> PaperTable:
    """Models of a run, best first: parameters, RMSE on the rows held out, share of the standard deviation."""
    body, unit = run.body, unit_text(run.body["units"]["effort"])
    rows = [
        (e["title"], e["parameters_count"], tuple(e["test"]["rmse"]), _per_cent(e["test"]["share"]))
        for e in body["ranking"][:most]
    ]
    error = f"RMSE [{unit}]" if unit else "RMSE"
    header = ("Model", "Parameters", error, "low", "high", "Of the std [%]", "low [%]", "high [%]")
    left = len(body["ranking"]) - len(rows)
    more = f" {left} more models are left out." if left > 0 else ""
    origins = {log["origin"] for log in body["logs"]} - {""}
    made = f" Data: {', '.join(sorted(origins))}." if origins else ""
    caption = f"Errors on {body['test_rows']} rows held out with 95 % bands; {_standing_of(run)}."
    return PaperTable(header, rows, f"{caption}{more}{made}")


def _standing_of(run: Run) -> str:
    nearest = run.titles[chosen_name(run.body)]
    none = standing_of_run(run.body).why_none
    return f"no model is recommended, nearest: {nearest}" if none else f"recommended: {nearest}"


def _per_cent(figure: Sequence[float | None]) -> Interval:
    value, low, high = (None if v is None else 100.0 * v for v in figure)
    return value, low, high


def parameter_table(run: Run, model: str | None = None) -> PaperTable:
    """Parameters of a model of a run with 95 % intervals; None: the recommended model.

    Raises:
        RunError: no such model.
        SettingError: a network, whose weights mean nothing one by one.
    """
    entry = run.entry(model or run.body["recommended"])
    numbers: list[Mapping[str, float | str | None]] = entry["fit"]["parameters"]
    if not numbers:
        names = ", ".join(e["name"] for e in run.body["ranking"] if e["fit"]["parameters"]) or "none here"
        problem = f"{entry['name']} is a network: its weights mean nothing one by one"
        raise SettingError(problem, where=str(run.folder), remedy=f"Give --model a law: {names}")
    rows = [
        (str(p["name"]), (p["value"], p["low"], p["high"]), unit_text(str(p["unit"])), str(p["meaning"]))
        for p in numbers
    ]
    header = ("Parameter", "Value", "low", "high", "Unit", "Meaning")
    return PaperTable(header, rows, f"Parameters of the {entry['title']} with 95 % intervals.")  # pyright: ignore[reportArgumentType]


def _latex(table: PaperTable) -> str:
    """With booktabs and siunitx, over both columns: numbers are aligned at their points, long texts are broken."""
    cells = table.cells()
    columns = list(zip(*cells, strict=True)) or [() for _ in table.header]
    numeric = [_numeric(column) for column in columns]
    kinds = " ".join(
        f"S[table-format={_format(c)}]" if n else _PARAGRAPH if max(map(len, c), default=0) > _LONG else "l"
        for c, n in zip(columns, numeric, strict=True)
    )
    head = " & ".join(f"{{{latex(name)}}}" for name in table.header)
    lines = [
        " & ".join(c if n and c else f"{{{_broken(c)}}}" for c, n in zip(row, numeric, strict=True)) for row in cells
    ]
    body = "".join(f"  {line} \\\\\n" for line in lines)
    return (
        "% \\usepackage{booktabs,siunitx}\n\\begin{table*}\n\\centering\\footnotesize\\setlength{\\tabcolsep}{3pt}\n"
        f"\\caption{{{_broken(table.caption)}}}\n\\begin{{tabular}}{{{kinds}}}\n  \\toprule\n"
        f"  {head} \\\\\n  \\midrule\n{body}  \\bottomrule\n\\end{{tabular}}\n\\end{{table*}}\n"
    )


def _broken(text: str) -> str:
    """A text in which a line may end between the parts of a model's long name."""
    shown = ((word, latex(word)) for word in text.split(" "))
    return " ".join(
        found.replace("+", "+" + _BREAK).replace("/", "/" + _BREAK) if len(word) > _LONG else found
        for word, found in shown
    )


def _numeric(column: Iterable[str]) -> bool:
    found = [cell for cell in column if cell]
    return bool(found) and all(_NUMBER.fullmatch(cell) for cell in found)


def _format(column: Iterable[str]) -> str:
    """The table-format of siunitx: digits before and after the point, and of the exponent."""
    mantissas, powers = zip(*(cell.partition("e")[::2] for cell in column), strict=True)
    whole = max(len(m.lstrip("-").partition(".")[0]) for m in mantissas)
    places = max(len(m.partition(".")[2]) for m in mantissas)
    power = max(powers, key=len)
    sign = "-" if any(m.startswith("-") for m in mantissas) else ""
    mark = "e-" if any(p.startswith("-") for p in powers) else "e"
    return f"{sign}{whole}.{places}" + (f"{mark}{len(power.lstrip('-'))}" if power else "")


def _markdown(table: PaperTable) -> str:
    cells = table.cells()
    columns = list(zip(*cells, strict=True)) or [() for _ in table.header]
    sides = ["---:" if _numeric(column) else "---" for column in columns]
    rows = [[markdown(c) for c in row] for row in (table.header, *cells)]
    lines = [rows[0], sides, *rows[1:]]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines) + f"\n{markdown(table.caption)}\n"


def _html(table: PaperTable) -> str:
    head = "".join(f"<th>{markup(name)}</th>" for name in table.header)
    rows = "".join("<tr>" + "".join(f"<td>{markup(c)}</td>" for c in row) + "</tr>\n" for row in table.cells())
    caption = f"<caption>{markup(table.caption)}</caption>"
    return f"<table>\n{caption}\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n"


def _csv(table: PaperTable) -> str:
    """Unrounded: a program reads it."""
    import csv
    import io

    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table.header)
    for row in table.rows:
        writer.writerow([value for cell in row for value in (cell if isinstance(cell, tuple) else (cell,))])
    return out.getvalue()


#: How each format is printed.
PRINTERS: Mapping[str, Callable[[PaperTable], str]] = {
    "latex": _latex,
    "markdown": _markdown,
    "html": _html,
    "csv": _csv,
}
