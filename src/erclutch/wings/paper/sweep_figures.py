"""Figures 4 and 5 and the RBFM's kernels are drawn as PDF and PNG, with the numbers behind them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.report.plots.plot_description import Axis, Dots, Line, Mark, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.wings.paper.section_figures import kept

_SHOWN = (10, 20, 50)  # neurons, of figure 4 (a)
_ERROR = Axis("MSE", "N² m²", log=True)


def draw_rbfn_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """Figure 4: (a) error against spread for some sizes, (b) error against neurons at the best spread of each."""
    spreads = np.asarray(sweep["spreads"])
    neurons = np.asarray(sweep["neurons"])
    on_centroids = np.asarray(sweep["scan"])  # training error, (spreads, neurons)
    # At the best spread of each size, (neurons,).
    best_spreads = np.asarray(sweep["best_spread"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])

    sizes: list[Line] = []
    for number, size in enumerate(_SHOWN):
        place = list(neurons).index(size)
        line = Line(
            spreads,
            on_centroids[:, place],
            style=f"series{number}",
            label=f"{size} neurons",
            marked=True,
        )
        sizes.append(line)
    panels = [
        Panel(
            Axis("spread (inputs normalised to 0 .. 1)", log=True),
            _ERROR,
            sizes,
            title=f"(a) RBFN, training, {label}",
        ),
        Panel(
            Axis("neurons (best spread of each)", log=True),
            _ERROR,
            _errors(neurons, train, test),
            title="(b)",
        ),
    ]

    # A row has either the error on centroids or both errors on all rows.
    rows: list[tuple[object, ...]] = []
    for spread, of_sizes in zip(spreads, on_centroids, strict=True):
        for size, error in zip(neurons, of_sizes, strict=True):
            rows.append((float(spread), int(size), float(error), "", ""))
    for spread, size, train_error, test_error in zip(
        best_spreads, neurons, train, test, strict=True
    ):
        rows.append((float(spread), int(size), "", float(train_error), float(test_error)))
    header = ["spread", "neurons", "train_mse_on_centroids", "train_mse", "test_mse"]
    plot = Plot(panels, PlotTable(header, rows), height=3.9)
    return kept(plot, folder, "fig4")


def draw_fnn_sweep(
    sweep: Mapping[str, Any],
    folder: Path,
    label: str,
    printed: Mapping[int, float],
) -> list[Path]:
    """Figure 5: error against neurons, every restart as a dot; the paper's printed training errors where it has any."""
    neurons = np.asarray(sweep["neurons"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])
    restarts = np.asarray(sweep["restarts"])  # training errors, (neurons, restarts)
    tries = restarts.shape[1]

    every_restart = Dots(
        np.repeat(neurons, tries),
        restarts.ravel(),
        style="series7",
        label="each restart, training",
        size=1.3,
    )
    marks: list[Mark] = [every_restart, *_errors(neurons, train, test, "best, ")]
    if printed:
        of_paper = Dots(
            np.array(list(printed), np.float64),
            np.array(list(printed.values()), np.float64),
            style="series6",
            label="paper, training",
            size=4.5,
        )
        marks.append(of_paper)
    x = Axis("neurons of the hidden layer", whole=True)
    panel = Panel(x, _ERROR, marks, title=f"FNN, {label}")

    header = ["neurons", "train_mse", "test_mse"]
    header += [f"restart_{number}" for number in range(1, tries + 1)]
    errors = np.column_stack([train, test, restarts]).tolist()
    pairs = zip(neurons, errors, strict=True)
    rows = [(int(size), *of_size) for size, of_size in pairs]
    plot = Plot([panel], PlotTable(header, rows), height=2.6)
    return kept(plot, folder, "fig5")


def draw_kernel_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """RBFM: error against kernels."""
    kernels = np.asarray(sweep["kernels"])
    train = np.asarray(sweep["train"])
    test = np.asarray(sweep["test"])
    panel = Panel(
        Axis("kernels", whole=True),
        Axis(_ERROR.label, _ERROR.unit),
        _errors(kernels, train, test),
        title=f"RBFM, {label}",
    )
    rows: list[tuple[object, ...]] = []
    for count, train_error, test_error in zip(kernels, train, test, strict=True):
        rows.append((int(count), float(train_error), float(test_error)))
    table = PlotTable(("kernels", "train_mse", "test_mse"), rows)
    return kept(Plot([panel], table, height=2.2), folder, "kernels")


def _errors(
    x: Array,
    train: Array,
    test: Array,
    prefix: str = "",
) -> list[Line]:
    """Lines of the training and of the test errors."""
    return [
        Line(x, train, "series0", f"{prefix}training", marked=True),
        Line(x, test, "series1", f"{prefix}test", dashed=True, marked=True),
    ]
