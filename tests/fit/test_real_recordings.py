"""Recordings that nobody here made: the figures that they have given so far, and no worse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command import good

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "data"

if not SHARED.is_dir():
    pytest.skip(f"needs the measured data beside the project: {SHARED}", allow_module_level=True)

NEES = SHARED / "mr_damper_nees" / "ranran_50_converted.csv"
UTFSM = SHARED / "mr_damper_utfsm"


def fit(*arguments: str | Path) -> dict[str, Any]:
    return json.loads(good("fit", *arguments, "--json"))


def inspect(*arguments: str | Path) -> dict[str, Any]:
    return json.loads(good("inspect", *arguments, "--json"))


# --- the NEES damper --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def nees() -> dict[str, Any]:
    """All models on the damper whose voltage is switched, the last 30 % in time held out."""
    return fit(NEES, "--field", "Y [V]", "--slip", "V [cm/s]", "--effort", "F [N]", "--test", "0.3")


def figures_of(run: dict[str, Any], name: str) -> dict[str, Any]:
    return next(entry["test"] for entry in run["ranking"] if entry["name"] == name)


@pytest.mark.slow
def test_nees_bingham_without_a_lag(nees: dict[str, Any]) -> None:
    assert nees["test_rows"] == round(0.3 * 74_068)
    share, low, high = figures_of(nees, "bingham")["share"]
    assert abs(share - 0.354) <= 0.01
    assert low < share < high


@pytest.mark.slow
def test_nees_bingham_with_a_lag(nees: dict[str, Any]) -> None:
    assert figures_of(nees, "bingham+lag")["share"][0] <= 0.26
    tau = next(e for e in nees["ranking"] if e["name"] == "bingham+lag")["fit"]["parameters"]
    tau = next(p for p in tau if p["name"] == "tau")
    assert np.isclose(tau["value"], 1 / 190, rtol=0.3)
    assert tau["low"] < tau["value"] < tau["high"]


@pytest.mark.slow
def test_nees_best_law(nees: dict[str, Any]) -> None:
    assert nees["ranking"][0]["test"]["share"][0] <= 0.255
    assert nees["best"] == nees["ranking"][0]["name"]
    assert "+" in nees["recommended"]  # a lag matters more than the shape of the law
    for entry in nees["ranking"]:
        if entry["fit"][
            "weights"
        ]:  # training ends with its schedule; it must not end because no step helps
            assert entry["fit"]["stop"] != "stalled", entry["name"]
        elif (
            entry["fit"]["condition"] or np.inf
        ) <= 1e8:  # null is infinite: rounding stops the solver (rbfm-10)
            assert entry["fit"]["converged"], entry["name"]


# --- the UTFSM damper -------------------------------------------------------------------------------------------------

_UTFSM_COLUMNS = ("--time", "c1 [s]", "--slip", "c3 [mm/s]", "--effort", "c4 [N]")


@pytest.mark.slow
def test_utfsm_bingham_over_30_logs() -> None:
    words = (
        *("--name-pattern", "{amplitude}mm{frequency}Hz{field}A"),
        *_UTFSM_COLUMNS,
        *("--test", "*0x5A.txt", "--test", "5mm3Hz*"),
    )
    # The figure is that of the law alone: to search for memory as well took most of the time.
    folder = UTFSM / "preprocessed"
    run = fit(folder, *words, "--models", "bingham", "--lag", "none")
    assert len(run["logs"]) == 30
    assert figures_of(run, "bingham")["rmse"][0] <= 164.0
    # A law that switches gets no memory. Lags are left to the data, which cannot tell them.
    run = fit(folder, *words, "--models", "on-off")
    assert any("no lag between command and field" in f["message"] for f in run["findings"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rows", "segments", "more"),
    [
        ("ME5mm3Hz.txt", 39_800, 5, ("--constant", "field=0.5 A")),
        ("15Hz0x5A.txt", 48_000, 1, ("--name-pattern", "{frequency}Hz{field}A")),
    ],
)
def test_raw_exports_open(name: str, rows: int, segments: int, more: tuple[str, str]) -> None:
    columns = ("--position", "CHANNEL0 [cm]", "--effort", "CHANNEL1 [980.665 N]")
    body = inspect(UTFSM / "raw" / name, *columns, *more)
    assert body["problem"] is None
    assert body["rows"] == rows
    assert len(body["segments"]) == segments
    assert body["signals"]["effort"] == "N"
