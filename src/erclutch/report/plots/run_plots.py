"""Figures of a run have names; each is written as PDF, PNG and the numbers behind it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from erclutch.errors import SettingError, did_you_mean
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.error_map_plot import describe_error_map
from erclutch.report.plots.flow_curves_plot import describe_flow_curves
from erclutch.report.plots.lag_plot import describe_lag
from erclutch.report.plots.loops_plot import describe_loops
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.report.plots.model_plot import describe_model
from erclutch.report.plots.parity_plot import describe_parity
from erclutch.report.plots.plot_description import PAGE, Plot
from erclutch.report.plots.ranking_plot import describe_ranking
from erclutch.report.plots.residual_plot import describe_residual
from erclutch.report.plots.trace_plot import describe_trace

#: What each figure shows, in a phrase, and what describes it.
FIGURES: dict[str, tuple[str, Callable[..., Plot]]] = {
    "ranking": ("error of every model with its interval", describe_ranking),
    "trace": ("measured and estimated over a section of the log", describe_trace),
    "error-map": ("error and training rows over field and slip", describe_error_map),
    "parity": ("estimated against measured, and the residual's distribution", describe_parity),
    "residual": ("spectrum and autocorrelation of the residual", describe_residual),
    "model": ("the recommended model: effort over slip and field, beside a rival", describe_model),
    "flow-curves": ("effort over slip of each law", describe_flow_curves),
    "loops": ("effort around periods of the motion, over slip and over travel", describe_loops),
    "lag": ("error after a switch, step responses", describe_lag),
}


def write_figure(
    name: str,
    material: Material,
    folder: Path,
    *,
    start: float | None = None,
    seconds: float | None = None,
    kinds: Sequence[str] = ("pdf", "png"),
    wide: bool = False,
) -> list[Path]:
    """Draw a figure of a run at IEEE width.

    Args:
        name: one of `FIGURES`.
        material: the run.
        folder: for NAME.csv and a file of each kind.
        start: first second of a trace.
        seconds: length of a trace.
        kinds: of `paper_style.KINDS`.
        wide: over both columns of a page.

    Returns:
        The files written.

    Raises:
        SettingError: no such figure, or a section without rows.
        CheckError: the run cannot give it.
        RunError: the folder cannot be written.
    """
    if name not in FIGURES:
        hint = did_you_mean(name, FIGURES)
        raise SettingError(f"no figure {name!r}", remedy=f"{hint}Figures are {', '.join(FIGURES)}")
    _, describe = FIGURES[name]
    if name == "trace":
        plot = describe(material, start=start, seconds=seconds)
    else:
        plot = describe(material)
    if wide:
        plot = replace(plot, width=PAGE)
    return save_plot(plot, *(folder / f"{name}.{kind}" for kind in kinds))
