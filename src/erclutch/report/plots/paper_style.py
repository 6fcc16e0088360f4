"""This module says how figures look and how they are kept: embedded fonts, colours that the colour-blind can tell.

Colours: Okabe and Ito 2008. matplotlib is imported only where a figure is drawn.
"""

from __future__ import annotations

import csv
import os
import shutil
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from erclutch.errors import RunError
from erclutch.export.encode import latex
from erclutch.files import scratch_folder, unwritable, whole_file
from erclutch.files.groups import together
from erclutch.files.spreadsheet_cells import shown_as_words
from erclutch.report.plots.plot_description import COLUMN
from erclutch.signals.array import Array

SERIES = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#000000", "#7F7F7F")
BLUE, RED, GREEN, ORANGE, PINK, SKY, BLACK, GREY = SERIES
_VIRIDIS = ("#440154", "#46327e", "#375b8d", "#277e8e", "#1fa188", "#48c16e", "#9bd93c")
#: Colour and line of each meaning of a mark.
STYLES: dict[str, dict[str, Any]] = {
    "measured": {"color": BLACK},
    "recommended": {"color": RED},
    "best": {"color": BLUE, "linestyle": "--"},
    "baseline": {"color": GREEN, "linestyle": ":"},
    "ref": {"color": GREY, "linewidth": 0.6},
    "zero": {"color": GREY, "linewidth": 0.5},
    "whisker": {"color": BLACK, "linewidth": 0.5},
    "whiskers": {"color": BLACK, "linewidth": 0.2},
    "band": {"color": "#CCCCCC", "linewidth": 0},
    "other": {"color": "#B9BDC4"},
    **{f"level{k}": {"color": colour} for k, colour in enumerate(_VIRIDIS)},
    **{f"series{k}": {"color": colour} for k, colour in enumerate(SERIES)},
}
#: Colours of each meaning of a cell, the weakest first.
RAMPS = {
    "heat": (
        "#fff3d6",
        "#fee391",
        "#fec44f",
        "#fb9a29",
        "#ec7014",
        "#cc4c02",
        "#993404",
        "#662506",
    ),
    "mass": ("#c6dbef", "#9ecae1", "#6baed6", "#4292c6", "#2171b5", "#08519c", "#08306b"),
}

#: Endings of a figure's file.
KINDS = ("pdf", "png", "svg", "pgf")
_DATE = "SOURCE_DATE_EPOCH"
_RC: dict[Any, object] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Arial", "Helvetica", "Liberation Sans", "DejaVu Sans"],
    "font.size": 8.0,
    "text.parse_math": False,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.4,
    "lines.linewidth": 0.9,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "savefig.dpi": 300.0,
    "svg.hashsalt": "erclutch",
    "pgf.rcfonts": False,  # the fonts of the document
    # Every text is escaped here, so the package that matplotlib asks for has nothing to do.
    "pgf.preamble": r"\makeatletter\@namedef{ver@underscore.sty}{}\makeatother",
}
#: What may measure the texts of a .pgf, the usual one first.
_TEX = ("pdflatex", "lualatex", "xelatex")


@contextmanager
def style() -> Generator[None, None, None]:
    """Context in which figures are made and saved."""
    import logging

    from matplotlib import rc_context  # pyright: ignore[reportUnknownVariableType]

    # One of the four fonts is enough.
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    # Embedded fonts carry a date; a fixed one, so that the same data give the same bytes.
    dated = os.environ.get(_DATE)
    os.environ.setdefault(_DATE, "0")
    try:
        with rc_context(_RC):  # pyright: ignore[reportArgumentType]
            yield
    finally:
        if dated is None:
            del os.environ[_DATE]


def new_figure(height: float, width: float = COLUMN) -> Any:
    """An empty figure without global state; call inside `style`."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def settle(figure: Any) -> None:
    """Lay a figure out for good, rounded: the layout's solver differs in its last digits from call to call."""
    import numpy as np
    from matplotlib.transforms import Bbox

    if figure.axes:
        figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    parts = list(figure.subfigs)
    for part in parts:
        parts += part.subfigs
        points = part.bbox_relative.get_points()
        part.bbox_relative.set_points(np.round(points, 9))
    for axes in figure.axes:
        at: Array = axes.get_position(original=True).get_points()
        axes.set_position(Bbox(np.round(at, 9)))


def save(figure: Any, path: Path) -> Path:
    """Write a figure as its ending says, one of `KINDS`, whole or not at all; call inside `style`.

    Raises:
        RunError: another ending, a folder that cannot be written, or a .pgf without LaTeX, which measures its texts.
    """
    kind = path.suffix.lower()[1:]
    if kind not in KINDS:
        remedy = f"End it in {', '.join(f'.{kind}' for kind in KINDS)}"
        raise RunError(f"a figure cannot end in {path.suffix!r}", where=str(path), remedy=remedy)
    if kind == "pgf":
        _save_for_latex(figure, path)
        return path
    dated = {"pdf": "CreationDate", "svg": "Date"}.get(kind)
    settle(figure)
    drawn = BytesIO()  # on a full disk the PDF writer itself would fail, and not say why
    # No date: the same bytes again.
    figure.savefig(drawn, format=kind, metadata={dated: None} if dated else None)
    with placed(path) as partial:
        partial.write_bytes(drawn.getvalue())
    return path


def _save_for_latex(figure: Any, path: Path) -> None:
    """Write a .pgf and the pictures of its maps, NAME-img0.png, ...: all or none.

    LaTeX gets escaped texts: for matplotlib's own backend every text is TeX, whatever ``text.parse_math`` says.
    """
    from matplotlib import rc_context  # pyright: ignore[reportUnknownVariableType]
    from matplotlib.backends import backend_pgf

    program = next(filter(shutil.which, _TEX), None)
    remedy = "Install LaTeX with pgf, or take a .pdf"
    if program is None:
        raise RunError("a .pgf needs LaTeX, which is not here", where=str(path), remedy=remedy)
    backend: Any = backend_pgf
    plain = backend._tex_escape
    backend._tex_escape = latex
    try:
        with (
            rc_context({"pgf.texsystem": program}),
            scratch_folder() as folder,
            together(),
        ):
            figure.savefig(Path(folder, path.name), format="pgf")
            for made in sorted(Path(folder).iterdir()):
                with placed(path.with_name(made.name)) as partial:
                    partial.write_bytes(made.read_bytes())
    except OSError as error:
        raise unwritable(path, error) from error
    except (backend.LatexError, RuntimeError) as error:
        problem = f"{program} cannot measure its texts: {str(error).strip().partition(chr(10))[0]}"
        raise RunError(problem, where=str(path), remedy=remedy) from error
    finally:
        backend._tex_escape = plain


def save_numbers(
    path: Path,
    header: Sequence[str],
    rows: Iterable[Sequence[object]],
) -> Path:
    """Write the numbers behind a figure as CSV, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    with placed(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(map(shown_as_words, header))
        writer.writerows([f"{v:.9g}" if isinstance(v, float) else v for v in row] for row in rows)
    return path


@contextmanager
def placed(path: Path) -> Generator[Path, None, None]:
    """A file to write that is there whole or not at all; its folder is made.

    Raises:
        RunError: the folder cannot be made or written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(path, error) from error
    with whole_file(path) as partial:
        yield partial
