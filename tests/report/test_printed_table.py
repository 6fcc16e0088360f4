"""Tables for papers: digits from the interval, columns that siunitx aligns, foreign text that stays text."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from erclutch.cli.commands.table import table
from erclutch.errors import SettingError
from erclutch.report.numbers.run_material import Material
from erclutch.report.printed_table import (
    PRINTERS,
    PaperTable,
    parameter_table,
    ranking_table,
    rounded,
)


@pytest.mark.parametrize(
    ("figure", "printed"),
    [
        ((0.042801, 0.02484, 0.0571), ["0.043", "0.025", "0.057"]),
        ((1.62687, 1.5267, 1.7243), ["1.627", "1.527", "1.724"]),
        ((0.0015217, 4.2e-6, 0.01776), ["0.0015", "4e-6", "0.0178"]),
        ((2.756e-5, 2.377e-5, 3.135e-5), ["2.76e-5", "2.38e-5", "3.14e-5"]),
        ((-1234.5, -1300.0, -1170.0), ["-1234", "-1300", "-1170"]),
        ((0.123456, None, None), ["0.1235", "", ""]),
        ((3.0, float("-inf"), float("inf")), ["3.000", "", ""]),
        ((0.0, 0.0, 1.27e-6), ["0.00e-6", "0.00e-6", "1.27e-6"]),
        ((None, None, None), ["", "", ""]),
    ],
)
def test_digits_come_from_the_interval(
    figure: tuple[float | None, float | None, float | None], printed: list[str]
) -> None:
    assert rounded(figure) == printed


def test_foreign_text_stays_text_in_each_format() -> None:
    name = r"a_b\end{tabular}|<b>%$1 & x^2~"
    hostile = PaperTable(("Model", "x"), [(name, 1)], f"Of {name}.")
    text = PRINTERS["latex"](hostile)
    assert (
        r"{a\_b\textbackslash{}end\{tabular\}\textbar{}\textless{}b\textgreater{}\%\$1 \& x\textasciicircum{}2"
        in text
    )
    assert text.count(r"\end{tabular}") == 1
    assert "<b>" not in PRINTERS["html"](hostile)
    assert len(re.findall(r"(?<!\\)\|", PRINTERS["markdown"](hostile).splitlines()[2])) == 3
    assert next(csv.DictReader(io.StringIO(PRINTERS["csv"](hostile))))["Model"] == name


def test_the_ranking_for_siunitx_and_for_a_program(material: Material) -> None:
    run = material.run
    text = PRINTERS["latex"](ranking_table(run, 2))
    assert re.search(
        r"\\begin\{tabular\}\{(l|>.*?linewidth\})( S\[table-format=\d+\.\d+\]){7}\}", text
    )
    assert f"{len(run.names) - 2} more models are left out." in text
    assert "Data: SYNTHETIC." in text
    body = [line for line in text.splitlines() if line.endswith(r"\\")][1:]
    assert [line.count("&") for line in body] == [7, 7]
    rows = list(csv.DictReader(io.StringIO(PRINTERS["csv"](ranking_table(run)))))
    errors = {run.titles[name]: run.entry(name)["test"]["rmse"][0] for name in run.names}
    assert {row["Model"]: float(row["RMSE [N·m]"]) for row in rows} == errors


def test_parameters_of_a_law_and_of_a_network(material: Material) -> None:
    run = material.run
    law = next(name for name in run.names if name.startswith("bingham"))
    table = parameter_table(run, law)
    assert [row[0] for row in table.rows] == [
        p["name"] for p in run.entry(law)["fit"]["parameters"]
    ]
    with pytest.raises(SettingError, match="weights mean nothing"):
        parameter_table(run, "fnn-2")


def test_a_value_at_a_bound_is_named_below_the_table(material: Material) -> None:
    run = material.run
    law = next(name for name in run.names if name.startswith("bingham"))
    entry = run.entry(law)
    first, *others = entry["fit"]["parameters"]
    free = [{**each, "at_bound": None} for each in others]
    parameters = [{**first, "at_bound": "lower"}, *free]
    changed = {**entry, "fit": {**entry["fit"], "parameters": parameters}}
    ranking = [changed if each["name"] == law else each for each in run.body["ranking"]]
    caption = parameter_table(replace(run, body={**run.body, "ranking": ranking}), law).caption
    assert caption.endswith(f"At a bound of the range that is searched: {first['name']} (lower).")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"model": "m1"}, "the ranking is of all models"),
        ({"what": "parameters", "most": 2}, "the parameters are of one model"),
    ],
)
def test_an_option_of_the_other_table_is_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(SettingError, match=said):
        table(Path("run"), **options)


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        ("t.html", "<table>"),
        ("t.tex", "% \\usepackage"),
        ("t.csv", "Model,"),
        ("t.md", "| Model"),
        ("t.txt", "| Model"),
    ],
)
def test_the_ending_says_the_format_of_a_table(
    name: str, begins: str, kept_run: Path, tmp_path: Path
) -> None:
    """Markdown under the name of a page was taken for one by a browser, with whatever names of logs hold."""
    table(kept_run, out=tmp_path / name)
    assert (tmp_path / name).read_text("utf-8").startswith(begins)
    if name != "t.txt":
        with pytest.raises(SettingError, match=f"whose name ends in {Path(name).suffix}"):
            table(
                kept_run,
                as_="html" if name != "t.html" else "markdown",
                out=tmp_path / f"other-{name}",
            )
