"""How figures look and how they are kept: IEEE column width, embedded fonts, colours that the colour-blind can tell.

Colours: Okabe and Ito 2008. matplotlib is imported only here and where a figure is drawn.
"""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from erclutch.errors import RunError

#: Widths of one and two columns in inches.
COLUMN, PAGE = 3.5, 7.16
BLACK, BLUE, ORANGE, GREEN, RED, SKY, PINK, GREY = (
    "#000000",
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#56B4E9",
    "#CC79A7",
    "#7F7F7F",
)
SERIES = (BLUE, RED, GREEN, ORANGE, PINK, SKY, BLACK, GREY)

_DATE = "SOURCE_DATE_EPOCH"
_RC = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Arial", "Helvetica", "Liberation Sans", "DejaVu Sans"],
    "font.size": 8.0,
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
}


@contextmanager
def style() -> Generator[None, None, None]:
    """Context in which figures are made and saved."""
    logging: Any = import_module("logging")
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)  # one of the four fonts is enough
    matplotlib: Any = import_module("matplotlib")
    # Embedded fonts carry a date; a fixed one, so that the same data give the same bytes.
    dated = os.environ.get(_DATE)
    os.environ.setdefault(_DATE, "0")
    try:
        with matplotlib.rc_context(_RC):
            yield
    finally:
        if dated is None:
            del os.environ[_DATE]


def new_figure(height: float, width: float = COLUMN) -> Any:
    """An empty figure without global state; call inside `style`."""
    return import_module("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")


def save(figure: Any, path: Path) -> Path:
    """Write a figure as its ending says (.png, .pdf, .svg), whole or not at all; call inside `style`.

    Raises:
        RunError: another ending, or the folder cannot be written.
    """
    if path.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise RunError(
            f"a figure cannot end in {path.suffix!r}", where=str(path), remedy="End it in .png, .pdf or .svg"
        )
    kind = path.suffix.lower()[1:]
    # Without a date the same data give the same bytes.
    metadata = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)

    def write(partial: Path) -> None:
        figure.savefig(partial, format=kind, metadata=metadata)

    return write_whole(path, write)


def save_numbers(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write the numbers behind a figure as CSV, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """

    def write(partial: Path) -> None:
        with partial.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows([f"{v:.9g}" if isinstance(v, float) else v for v in row] for row in rows)

    return write_whole(path, write)


def write_whole(path: Path, write: Callable[[Path], object]) -> Path:
    """Let a function write a file under another name and move it to its own when it is whole.

    Raises:
        RunError: the folder cannot be made or written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.partial-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise _unwritable(path, error) from error
    os.close(handle)
    partial = Path(name)
    try:
        write(partial)
        partial.chmod(0o644)
        os.replace(partial, path)
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        partial.unlink(missing_ok=True)
    return path


def _unwritable(path: Path, error: OSError) -> RunError:
    return RunError(f"cannot be written: {error.strerror or error}", where=str(path), remedy="Give another place")
