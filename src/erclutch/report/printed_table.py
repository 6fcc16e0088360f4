"""Tables of a run for a paper: LaTeX, Markdown, HTML or CSV, with as many digits as the intervals allow."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from erclutch.errors import SettingError
from erclutch.export.encode import latex, markdown, markup
from erclutch.files.spreadsheet_cells import shown_as_words
from erclutch.fit.choice.standing import chosen_name, standing_of_run
from erclutch.report.numbers.number_text import unit_text
from erclutch.runs.run_folder import Run

#: A figure with the ends of its interval, printed in three columns.
Interval: TypeAlias = tuple[float | None, float | None, float | None]
_PLAIN = 4  # digits of a figure without an interval
_WIDTH_DIGITS = 2  # digits of an interval's half-width
_LONG = 26  # letters from which a column of texts is broken into lines in LaTeX
_PARAGRAPH = r">{\raggedright\arraybackslash}p{0.3\linewidth}"  # such a column
_BREAK = r"\allowbreak{}"
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
        lines: list[list[str]] = []
        for row in self.rows:
            line: list[str] = []
            for cell in row:
                line += rounded(cell) if isinstance(cell, tuple) else [str(cell)]
            lines.append(line)
        return lines


def rounded(figure: Interval) -> list[str]:
    """Value, low and high to the digit that the interval's width allows; empty where there is none."""
    sizes = [
        abs(number)
        for number in figure
        if number is not None and math.isfinite(number) and number != 0.0
    ]
    if not sizes:
        return ["0" if number == 0.0 else "" for number in figure]
    power = math.floor(math.log10(max(sizes)))  # of ten, of the first digit

    _, low, high = figure
    half_width = 0.0 if low is None or high is None else 0.5 * (high - low)
    last = power - _PLAIN + 1  # power of ten of the last digit
    if 0.0 < half_width < math.inf:
        last = math.floor(math.log10(half_width)) - _WIDTH_DIGITS + 1
    exponent = power if power < _SMALL or power >= _LARGE else 0
    places = max(0, exponent - last)
    return [_fixed(number, exponent, places) for number in figure]


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
    body = run.body
    rows: list[tuple[str, int, Interval, Interval]] = []
    for entry in body["ranking"][:most]:
        rmse: Interval = tuple(entry["test"]["rmse"])
        share = [None if end is None else 100.0 * end for end in entry["test"]["share"]]
        value, low, high = share
        rows.append((entry["title"], entry["parameters_count"], rmse, (value, low, high)))
    unit = unit_text(body["units"]["effort"])
    error = f"RMSE [{unit}]" if unit else "RMSE"
    header = ("Model", "Parameters", error, "low", "high", "Of the std [%]", "low [%]", "high [%]")

    nearest = run.titles[chosen_name(body)]
    word = "recommended"
    if standing_of_run(body).why_none:
        word = "no model is recommended, nearest"
    caption = f"Errors on {body['test_rows']} rows held out with 95 % bands; {word}: {nearest}."
    left_out = len(body["ranking"]) - len(rows)
    if left_out > 0:
        caption += f" {left_out} more models are left out."
    origins = {log["origin"] for log in body["logs"]} - {""}
    if origins:
        caption += f" Data: {', '.join(sorted(origins))}."
    return PaperTable(header, rows, caption)


def parameter_table(run: Run, model: str | None = None) -> PaperTable:
    """Parameters of a model of a run with 95 % intervals; None: the recommended model.

    Raises:
        RunError: no such model.
        SettingError: a network, whose weights mean nothing one by one.
    """
    entry = run.entry(model or run.body["recommended"])
    numbers: list[Mapping[str, float | str | None]] = entry["fit"]["parameters"]
    if not numbers:
        laws = [other["name"] for other in run.body["ranking"] if other["fit"]["parameters"]]
        names = ", ".join(laws) or "none here"
        problem = f"{entry['name']} is a network: its weights mean nothing one by one"
        raise SettingError(problem, where=str(run.folder), remedy=f"Give --model a law: {names}")
    rows: list[tuple[str, Interval, str, str]] = []
    for number in numbers:
        value: Any = (number["value"], number["low"], number["high"])
        name = str(number["name"])
        unit = unit_text(str(number["unit"]))
        meaning = str(number["meaning"])
        rows.append((name, value, unit, meaning))
    header = ("Parameter", "Value", "low", "high", "Unit", "Meaning")
    caption = f"Parameters of the {entry['title']} with 95 % intervals."
    at_bounds = [f"{p['name']} ({p['at_bound']})" for p in numbers if p["at_bound"]]
    if at_bounds:  # such a value says where the search ended, and may be no estimate
        caption += f" At a bound of the range that is searched: {', '.join(at_bounds)}."
    return PaperTable(header, rows, caption)


def _latex(table: PaperTable) -> str:
    """With booktabs and siunitx, over both columns: numbers are aligned at their points, long texts are broken."""
    columns = _columns(table)
    numeric = [_numeric(column) for column in columns]
    kinds: list[str] = []
    for column, is_numeric in zip(columns, numeric, strict=True):
        longest = max(map(len, column), default=0)
        if is_numeric:
            # The digits before and after the point, and of the exponent.
            sign = ""
            mark = "e"
            whole = places = 0
            longest_power = ""
            for cell in column:
                mantissa, _, power = cell.partition("e")
                before, _, behind = mantissa.partition(".")
                whole = max(whole, len(before.lstrip("-")))
                places = max(places, len(behind))
                longest_power = max(longest_power, power, key=len)
                if mantissa.startswith("-"):
                    sign = "-"
                if power.startswith("-"):
                    mark = "e-"
            exponent = f"{mark}{len(longest_power.lstrip('-'))}" if longest_power else ""
            kinds.append(f"S[table-format={sign}{whole}.{places}{exponent}]")
        elif longest > _LONG:
            kinds.append(_PARAGRAPH)
        else:
            kinds.append("l")
    head = " & ".join(f"{{{latex(name)}}}" for name in table.header)
    body = ""
    for row in table.cells():
        # Braces keep siunitx from reading a text as a number.
        shown: list[str] = []
        for cell, is_numeric in zip(row, numeric, strict=True):
            is_number = is_numeric and cell != ""
            shown.append(cell if is_number else f"{{{_broken(cell)}}}")
        body += f"  {' & '.join(shown)} \\\\\n"
    return (
        "% \\usepackage{booktabs,siunitx}\n\\begin{table*}\n\\centering\\footnotesize\\setlength{\\tabcolsep}{3pt}\n"
        f"\\caption{{{_broken(table.caption)}}}\n\\begin{{tabular}}{{{' '.join(kinds)}}}\n  \\toprule\n"
        f"  {head} \\\\\n  \\midrule\n{body}  \\bottomrule\n\\end{{tabular}}\n\\end{{table*}}\n"
    )


def _columns(table: PaperTable) -> list[tuple[str, ...]]:
    """The cells by column; a table without rows has empty columns."""
    return list(zip(*table.cells(), strict=True)) or [() for _ in table.header]


def _broken(text: str) -> str:
    """A text in which a line may end between the parts of a model's long name."""
    words: list[str] = []
    for word in text.split(" "):
        shown = latex(word)
        if len(word) > _LONG:
            shown = shown.replace("+", "+" + _BREAK).replace("/", "/" + _BREAK)
        words.append(shown)
    return " ".join(words)


def _numeric(column: Iterable[str]) -> bool:
    filled = [cell for cell in column if cell]
    return bool(filled) and all(map(_NUMBER.fullmatch, filled))


def _markdown(table: PaperTable) -> str:
    head = [markdown(name) for name in table.header]
    sides = ["---:" if _numeric(column) else "---" for column in _columns(table)]
    lines = [f"| {' | '.join(head)} |\n", f"| {' | '.join(sides)} |\n"]
    for row in table.cells():
        cells = [markdown(cell) for cell in row]
        lines.append(f"| {' | '.join(cells)} |\n")
    return f"{''.join(lines)}\n{markdown(table.caption)}\n"


def _html(table: PaperTable) -> str:
    head = "".join(f"<th>{markup(name)}</th>" for name in table.header)
    rows = ""
    for row in table.cells():
        cells = "".join(f"<td>{markup(cell)}</td>" for cell in row)
        rows += f"<tr>{cells}</tr>\n"
    caption = f"<caption>{markup(table.caption)}</caption>"
    return (
        f"<table>\n{caption}\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n"
    )


def _csv(table: PaperTable) -> str:
    """Unrounded: a program reads it."""
    import csv
    import io

    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(map(shown_as_words, table.header))
    for row in table.rows:
        line: list[object] = []
        for cell in row:
            if isinstance(cell, tuple):
                line += cell
            else:
                line.append(shown_as_words(cell) if isinstance(cell, str) else cell)
        writer.writerow(line)
    return out.getvalue()


#: How each format is printed.
PRINTERS: Mapping[str, Callable[[PaperTable], str]] = {
    "latex": _latex,
    "markdown": _markdown,
    "html": _html,
    "csv": _csv,
}
