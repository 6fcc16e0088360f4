"""What LaTeX makes of a table and of a figure: pdflatex compiles both, whatever their names are made of."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import RunError
from erclutch.export.encode import latex
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots import paper_style
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.report.plots.plot_description import (
    COLUMN,
    PAGE,
    Axis,
    Cells,
    Line,
    Panel,
    Plot,
    PlotTable,
)
from erclutch.report.plots.run_plots import write_figure
from erclutch.report.printed_table import PRINTERS, PaperTable, parameter_table, ranking_table

pytestmark = pytest.mark.slow

HOSTILE = (
    r"a_b\end{tabular}|<b>%$1 & x^2~#{}µλΩ℃·³ 10⁻⁹ → 温 é ř ł ﬁ ½ '\"--`"
    + "\u2013\u2212\u221e\u00ab"
)
#: An IEEE page without its class.
_PAGE = r"""\documentclass[10pt,twocolumn]{article}
\setlength{\textwidth}{7.16in}\setlength{\columnsep}{0.16in}
\usepackage{booktabs,siunitx,pgf}
\begin{document}
%s
\end{document}
"""


def compiled(folder: Path, body: str) -> str:
    """The log of pdflatex, which must end well and set nothing over the edge of its column."""
    if shutil.which("pdflatex") is None:
        pytest.skip("pdflatex is not installed: Debian texlive-science, texlive-pictures")
    (folder / "page.tex").write_text(_PAGE % body, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=120, check=False)
    text = done.stdout.decode("utf-8", "replace")
    assert done.returncode == 0, text[-2000:]
    assert "Overfull" not in text, text
    return text


@given(st.text())
def test_nothing_in_a_text_is_a_command_of_latex(text: str) -> None:
    """Only letters that pdflatex knows, and none that ends a group or begins a comment."""
    shown = latex(text)
    assert "%" not in shown.replace(r"\%", "")
    assert shown.count("{") - shown.count(r"\{") == shown.count("}") - shown.count(r"\}")
    assert all(c.isascii() or ord(c) < 0x180 for c in shown)


def test_a_pgf_without_latex_is_refused(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paper_style, "_TEX", ("no-such-tex",))
    with pytest.raises(RunError, match="needs LaTeX"):
        write_figure("ranking", material, tmp_path, kinds=("pgf",))
    assert not list(tmp_path.iterdir())


def test_pdflatex_sets_tables(material: Material, tmp_path: Path) -> None:
    law = next(name for name in material.run.names if name.startswith("bingham"))
    long = PaperTable(
        ("Model", "x"),
        [("casson" + 9 * "+effort-lag/field", (1e-9, -1.5e-9, 2e-7))],
        "A long name.",
    )
    hostile = PaperTable((HOSTILE, "x"), [(HOSTILE, 1)], HOSTILE)
    tables = (ranking_table(material.run), parameter_table(material.run, law), long, hostile)
    compiled(tmp_path, "\n".join(PRINTERS["latex"](table) for table in tables))


@pytest.mark.parametrize("width", [COLUMN, PAGE])
def test_pdflatex_sets_figures(material: Material, tmp_path: Path, width: float) -> None:
    """A map has a picture beside it; the file names it, and holds no place of this machine."""
    x = np.linspace(0.0, 1.0, 5)
    cells = Cells(x, x, np.eye(4), 1.0, "heat", HOSTILE[:20])
    lines = [Line(x, k * x - 0.5, f"series{k}", HOSTILE[3 * k :][:25]) for k in range(2)]
    axes = Axis("slip_1 % #", "$\\alpha$ & m²"), Axis("effort", "N·m")
    plot = Plot(
        [Panel(*axes, lines), Panel(*axes, [cells])],
        PlotTable(("x",), [(1,)]),
        4.0,
        width,
        title=HOSTILE[:30],
    )
    save_plot(plot, tmp_path / "hostile.pgf")
    write_figure("trace", material, tmp_path, kinds=("pgf",), wide=width == PAGE)
    texts = [
        (tmp_path / f"{name}.pgf").read_text(encoding="utf-8") for name in ("hostile", "trace")
    ]
    assert "{hostile-img0.png}" in texts[0]
    assert not [
        text for text in texts if str(tmp_path) in text or "partial" in text or ".ttf" in text
    ]
    star = "*" if width == PAGE else ""
    frames = (
        f"\\begin{{figure{star}}}\\input{{{n}.pgf}}\\end{{figure{star}}}"
        for n in ("hostile", "trace")
    )
    compiled(tmp_path, "\n".join(frames))
