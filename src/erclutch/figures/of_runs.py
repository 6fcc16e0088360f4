"""Figures of a run by name: each as PDF, PNG and the numbers behind it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from erclutch.diagnostics.material import Material
from erclutch.errors import SettingError
from erclutch.figures import run_flow_curves, run_lag, run_ranking
from erclutch.figures.parts import Numbers
from erclutch.figures.run_error_map import draw_error_map
from erclutch.figures.run_flow_curves import draw_flow_curves
from erclutch.figures.run_lag import draw_lag
from erclutch.figures.run_parity import draw_parity
from erclutch.figures.run_ranking import draw_ranking
from erclutch.figures.run_residual import draw_residual
from erclutch.figures.run_trace import draw_trace
from erclutch.figures.style import COLUMN, PAGE, new_figure, save, save_numbers, style


@dataclass(frozen=True)
class RunFigure:
    """One figure.

    Attributes:
        meaning: one phrase for people.
        draw: draws it and gives its numbers.
        height: in inches, at the width.
        width: one column or two.
    """

    meaning: str
    draw: Callable[[Any, Material], Numbers]
    height: Callable[[Material], float]
    width: float = COLUMN


def _high(inches: float) -> Callable[[Material], float]:
    return lambda _: inches


def _map_height(material: Material) -> float:
    return 0.55 + 1.75 * len(material.rows.data.elements)


FIGURES: dict[str, RunFigure] = {
    "ranking": RunFigure("error of every model with its interval", draw_ranking, run_ranking.height),
    "trace": RunFigure("measured and estimated over a section of the log", draw_trace, _high(3.1)),
    "error-map": RunFigure("error and training rows over field and slip", draw_error_map, _map_height),
    "parity": RunFigure("estimated against measured, and the residual's distribution", draw_parity, _high(4.6)),
    "residual": RunFigure("spectrum and autocorrelation of the residual", draw_residual, _high(3.8)),
    "flow-curves": RunFigure("effort over slip of each law", draw_flow_curves, run_flow_curves.height, PAGE),
    "lag": RunFigure("error after a switch, step responses", draw_lag, run_lag.height),
}


def write_figure(
    name: str, material: Material, folder: Path, *, start: float | None = None, seconds: float | None = None
) -> list[Path]:
    """Draw a figure of a run at IEEE width.

    Args:
        name: one of `FIGURES`.
        material: the run.
        folder: for NAME.pdf, NAME.png and NAME.csv.
        start: first second of a trace.
        seconds: length of a trace.

    Returns:
        The files written.

    Raises:
        SettingError: no such figure, or a section without rows.
        CheckError: the run cannot give it.
        RunError: the folder cannot be written.
    """
    if name not in FIGURES:
        raise SettingError(f"no figure {name!r}", remedy=f"Figures are {', '.join(FIGURES)}")
    chosen = FIGURES[name]
    draw: Any = partial(draw_trace, start=start, seconds=seconds) if name == "trace" else chosen.draw
    with style():
        figure: Any = new_figure(chosen.height(material), chosen.width)
        numbers: Numbers = draw(figure, material)
        paths = [save(figure, folder / f"{name}.{kind}") for kind in ("pdf", "png")]
    return [*paths, save_numbers(folder / f"{name}.csv", numbers.header, numbers.rows)]
