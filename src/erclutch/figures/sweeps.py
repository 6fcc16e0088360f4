"""Figures 4 and 5 and the RBFM's kernels, as PDF, PNG and the numbers behind them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.figures.style import BLACK, BLUE, GREY, RED, SERIES, new_figure, save, save_numbers, style

_SHOWN = (10, 20, 50)


def draw_rbfn_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """Figure 4: (a) error against spread for some sizes, (b) error against neurons at the best spread of each."""
    spreads, neurons, scan, train, test = (
        np.asarray(sweep[k]) for k in ("spreads", "neurons", "scan", "train", "test")
    )
    with style():
        figure: Any = new_figure(3.9)
        first, second = figure.subplots(2, 1)
        for colour, n in zip(SERIES, _SHOWN, strict=False):
            first.loglog(spreads, scan[:, list(neurons).index(n)], "o-", ms=2.5, color=colour, label=f"{n} neurons")
        first.set_xlabel("Spread (inputs normalised to 0 .. 1)")
        first.set_title(f"(a) RBFN, training, {label}", loc="left")
        second.loglog(neurons, train, "o-", ms=2.5, color=BLUE, label="training")
        second.loglog(neurons, test, "s--", ms=2.5, color=RED, label="test")
        second.set_xlabel("Neurons (best spread of each)")
        second.set_title("(b)", loc="left")
        for axis in (first, second):
            axis.set_ylabel("MSE [N$^2$ m$^2$]")
            axis.legend()
        paths = [save(figure, folder / f"fig4.{kind}") for kind in ("pdf", "png")]
    rows = [
        (float(spreads[i]), int(neurons[j]), float(scan[i, j]), "", "")
        for i in range(spreads.size)
        for j in range(neurons.size)
    ]
    best = np.asarray(sweep["best_spread"])
    rows += [(float(s), int(n), "", float(a), float(b)) for s, n, a, b in zip(best, neurons, train, test, strict=True)]
    header = ["spread", "neurons", "train_mse_on_centroids", "train_mse", "test_mse"]
    return [*paths, save_numbers(folder / "fig4.csv", header, rows)]


def draw_fnn_sweep(sweep: Mapping[str, Any], folder: Path, label: str, printed: Mapping[int, float]) -> list[Path]:
    """Figure 5: error against neurons, every restart as a dot; the paper's printed training errors where it has any."""
    neurons, train, test, restarts = (np.asarray(sweep[k]) for k in ("neurons", "train", "test", "restarts"))
    with style():
        figure: Any = new_figure(2.6)
        axis: Any = figure.subplots()
        dots = np.repeat(neurons, restarts.shape[1])
        axis.semilogy(dots, restarts.ravel(), ".", ms=2.0, color=GREY, label="each restart, training")
        axis.semilogy(neurons, train, "o-", ms=2.5, color=BLUE, label="best, training")
        axis.semilogy(neurons, test, "s--", ms=2.5, color=RED, label="best, test")
        if printed:
            axis.semilogy(list(printed), list(printed.values()), "x", ms=5, color=BLACK, label="paper, training")
        axis.set_xlabel("Neurons of the hidden layer")
        axis.set_ylabel("MSE [N$^2$ m$^2$]")
        axis.set_title(f"FNN, {label}", loc="left")
        axis.legend()
        paths = [save(figure, folder / f"fig5.{kind}") for kind in ("pdf", "png")]
    header = ["neurons", "train_mse", "test_mse", *(f"restart_{k + 1}" for k in range(restarts.shape[1]))]
    rows = [
        (int(n), float(a), float(b), *(float(r) for r in line))
        for n, a, b, line in zip(neurons, train, test, restarts, strict=True)
    ]
    return [*paths, save_numbers(folder / "fig5.csv", header, rows)]


def draw_kernel_sweep(sweep: Mapping[str, Any], folder: Path, label: str) -> list[Path]:
    """RBFM: error against kernels."""
    kernels, train, test = (np.asarray(sweep[k]) for k in ("kernels", "train", "test"))
    with style():
        figure: Any = new_figure(2.2)
        axis: Any = figure.subplots()
        axis.plot(kernels, train, "o-", ms=2.5, color=BLUE, label="training")
        axis.plot(kernels, test, "s--", ms=2.5, color=RED, label="test")
        axis.set_xlabel("Kernels")
        axis.xaxis.get_major_locator().set_params(integer=True)
        axis.set_ylabel("MSE [N$^2$ m$^2$]")
        axis.set_title(f"RBFM, {label}", loc="left")
        axis.legend()
        paths = [save(figure, folder / f"kernels.{kind}") for kind in ("pdf", "png")]
    rows = [(int(k), float(a), float(b)) for k, a, b in zip(kernels, train, test, strict=True)]
    return [*paths, save_numbers(folder / "kernels.csv", ["kernels", "train_mse", "test_mse"], rows)]
