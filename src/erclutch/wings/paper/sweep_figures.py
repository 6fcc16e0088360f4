"""Figures 4 and 5 and the RBFM's kernels are drawn as PDF and PNG, with the numbers behind them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.report.plots.plot_description import Axis, Dots, Line, Mark, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.wings.paper.section_figures import kept

_SHOWN = (10, 20, 50)
_ERROR = Axis("MSE", "N² m²", log=True)


def draw_rbfn_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """Figure 4: (a) error against spread for some sizes, (b) error against neurons at the best spread of each."""
    spreads = np.asarray(sweep["spreads"])
    neurons = np.asarray(sweep["neurons"])
    scan = np.asarray(sweep["scan"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])
    best = np.asarray(sweep["best_spread"])
    sizes: list[Line] = []
    for number, size in enumerate(_SHOWN):
        errors = scan[:, list(neurons).index(size)]
        sizes.append(Line(spreads, errors, f"series{number}", f"{size} neurons", marked=True))
    spread_axis = Axis("spread (inputs normalised to 0 .. 1)", log=True)
    size_axis = Axis("neurons (best spread of each)", log=True)
    panels = [
        Panel(spread_axis, _ERROR, sizes, title=f"(a) RBFN, training, {label}"),
        Panel(size_axis, _ERROR, _errors(neurons, train, test), title="(b)"),
    ]
    rows: list[tuple[object, ...]] = []
    for i, spread in enumerate(spreads):
        for j, size in enumerate(neurons):
            rows.append((float(spread), int(size), float(scan[i, j]), "", ""))
    for spread, size, train_error, test_error in zip(best, neurons, train, test, strict=True):
        rows.append((float(spread), int(size), "", float(train_error), float(test_error)))
    header = ["spread", "neurons", "train_mse_on_centroids", "train_mse", "test_mse"]
    return kept(Plot(panels, PlotTable(header, rows), 3.9), folder, "fig4")


def draw_fnn_sweep(sweep: Mapping[str, Any], folder: Path, label: str, printed: Mapping[int, float]) -> list[Path]:
    """Figure 5: error against neurons, every restart as a dot; the paper's printed training errors where it has any."""
    neurons = np.asarray(sweep["neurons"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])
    restarts = np.asarray(sweep["restarts"])  # (neurons, restarts)
    each = np.repeat(neurons, restarts.shape[1])
    marks: list[Mark] = [Dots(each, restarts.ravel(), "series7", "each restart, training", 1.3)]
    marks += _errors(neurons, train, test, "best, ")
    if printed:
        paper = np.array(list(printed.items()), np.float64)
        marks.append(Dots(paper[:, 0], paper[:, 1], "series6", "paper, training", 4.5))
    header = ["neurons", "train_mse", "test_mse"]
    header += [f"restart_{number}" for number in range(1, restarts.shape[1] + 1)]
    errors = np.column_stack([train, test, restarts]).tolist()
    rows = [(int(size), *row) for size, row in zip(neurons, errors, strict=True)]
    table = PlotTable(header, rows)
    panel = Panel(Axis("neurons of the hidden layer", whole=True), _ERROR, marks, title=f"FNN, {label}")
    return kept(Plot([panel], table, 2.6), folder, "fig5")


def draw_kernel_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """RBFM: error against kernels."""
    kernels = np.asarray(sweep["kernels"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])
    rows: list[tuple[object, ...]] = []
    for count, train_error, test_error in zip(kernels, train, test, strict=True):
        rows.append((int(count), float(train_error), float(test_error)))
    table = PlotTable(("kernels", "train_mse", "test_mse"), rows)
    error = Axis(_ERROR.label, _ERROR.unit)
    panel = Panel(Axis("kernels", whole=True), error, _errors(kernels, train, test), title=f"RBFM, {label}")
    return kept(Plot([panel], table, 2.2), folder, "kernels")


def _errors(x: Array, train: Array, test: Array, prefix: str = "") -> list[Line]:
    """Lines of the training and of the test errors."""
    return [
        Line(x, train, "series0", f"{prefix}training", marked=True),
        Line(x, test, "series1", f"{prefix}test", dashed=True, marked=True),
    ]
