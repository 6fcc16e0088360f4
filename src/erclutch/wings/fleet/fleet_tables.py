"""What came out of each device becomes two tables, a series for each number, and a digest of all rows."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC
from operator import itemgetter
from pathlib import Path
from statistics import median_low
from typing import Any

import numpy as np

from erclutch.errors import SettingError
from erclutch.files import whole_file
from erclutch.fit.choice.standing import standing_of_run
from erclutch.runs.run_about import moment_of
from erclutch.runs.written_run import unwritable
from erclutch.signals.array import Array
from erclutch.wings.fleet.fleet_statistics import (
    OUTLYING,
    RMSE,
    FleetSeries,
    control_chart,
    outlier_scores,
    trend,
)

Rows = list[dict[str, Any]]
#: Of the tables of parameters and of fits.
FILES = ("parameters.parquet", "fits.parquet")

_SECONDS_A_DAY = 86400.0
#: What a number means that is of another field where a log reaches another field, such as the yield effort.
_AT_FIELD = "reference field"
#: How far a reference field may be from the fleet's, as a share of it, for numbers that the law carries over, and for
#: others: a yield effort follows the field, and a drift is small.
_NEARBY, _ONE_FIELD = 0.25, 0.02


@dataclass(frozen=True)
class FleetTables:
    """The tables of a fleet.

    Attributes:
        parameters: a row for each number of each model of each device.
        fits: a row for each model of each device; a device that failed has one with the reason.
        series: each number of each model over the devices.
        model: the model that is recommended most often.
        digest: SHA-256 of the rows of both tables, sorted.
    """

    parameters: Rows
    fits: Rows
    series: tuple[FleetSeries, ...]
    model: str | None
    digest: str

    def write(self, folder: Path) -> None:
        """Write both tables as Parquet, each whole or not at all.

        Raises:
            RunError: the folder cannot be written.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        for name, rows in zip(FILES, (self.parameters, self.fits), strict=True):
            names = dict.fromkeys(key for row in rows for key in row)
            columns = {key: [row.get(key) for row in rows] for key in names}
            table = pa.table(columns)
            with (
                whole_file(folder / name, unwritable) as partial,
                partial.open("wb") as file,
            ):
                pq.write_table(table, file)


def tables_of(devices: Sequence[Mapping[str, Any]], over: str, baseline: int) -> FleetTables:
    """The tables of what came out of each device (see `erclutch.wings.fleet.fleet.fit_device`).

    Args:
        devices: in the order of their names.
        over: what they are ordered by, see `erclutch.wings.fleet.fleet.fit_many`.
        baseline: how many of the first devices give the limits of the control charts; 0 for all.

    Raises:
        SettingError: no device has a number of this name to be ordered by.
    """
    # Where each device stands: its place, days since the first log, or a number of its own.
    if over == "name":
        orders = [float(place + 1) for place in range(len(devices))]
    elif over == "mtime":
        first = min((body["modified"] for body in devices if body["modified"]), default=0.0)
        orders = [(body["modified"] - first) / _SECONDS_A_DAY for body in devices]
    elif any(over in body["values"] for body in devices):
        orders = [float(body["values"].get(over, np.nan)) for body in devices]
    else:
        remedy = f"Give --name-pattern with {{{over}}} in it, or --over name, or --over mtime"
        failed = next((body["failed"] for body in devices if body["failed"]), "")
        why = f"; {failed}" if failed else ""
        raise SettingError(f"no log has a number {over!r}{why}", remedy=remedy)

    fits: Rows = []
    parameters: Rows = []
    for order, body in zip(orders, devices, strict=True):
        place = {"device": body["device"], "order": order}
        changed = moment_of(body["modified"])
        modified = "" if changed is None else changed.astimezone(UTC).isoformat(timespec="seconds")
        about = {**place, "logs": "; ".join(body["logs"]), "modified": modified}
        # A number of the name may be called as a column is, such as {device}.
        taken = (*about, *_NO_FIT, "failed")
        about |= {
            f"{key} in name" if key in taken else key: number
            for key, number in body["values"].items()
        }
        run = body.get("run")
        if run is None:
            fits.append({**about, **_NO_FIT, "failed": body["failed"]})
            continue
        for model in run["ranking"]:
            fit = fit_row(run, model)
            fits.append({**about, **fit, "failed": body["failed"]})
            # A row for each parameter of the model, and one for its error on rows held out.
            error: dict[str, Any] = {
                "name": RMSE,
                "meaning": "error on rows held out",
                "value": fit["rmse"],
                "low": fit["rmse_low"],
                "high": fit["rmse_high"],
                "at_bound": None,
                "unit": fit["effort_unit"],
            }
            # The largest field that the model was fitted to, and by which power the yield effort follows it there.
            field = body.get("reference_field")
            exponent = body.get("field_exponents", {}).get(model["name"])
            for number in (*model["fit"]["parameters"], error):
                is_at_field = _AT_FIELD in number["meaning"]
                row = {
                    **place,
                    "model": fit["model"],
                    "recommended": fit["recommended"],
                    "parameter": number["name"],
                    "value": number["value"],
                    "low": number["low"],
                    "high": number["high"],
                    "at_bound": number["at_bound"],
                    "unit": number["unit"],
                    "at_field": field if is_at_field else None,
                    "field_exponent": exponent if is_at_field else None,
                    "rmse": fit["rmse"],
                    "warnings": fit["notes"],
                }
                parameters.append(row)

    series = _series_of(parameters, baseline)
    recommended = [row["model"] for row in fits if row["recommended"]]
    most_often = max(sorted(set(recommended)), key=recommended.count, default=None)
    lines = sorted(json.dumps(row, sort_keys=True) for row in fits + parameters)
    text = "\n".join(lines)
    digest = hashlib.sha256(text.encode()).hexdigest()
    return FleetTables(parameters, fits, series, most_often, digest)


def logs_of_several_devices(devices: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """What the check of a fit said of the logs of each device that look like those of several, by its name."""
    said: dict[str, str] = {}
    for name, body in devices.items():
        for finding in body.get("run", {}).get("findings", ()):
            if finding["subject"] == "logs":
                said[name] = finding["message"]
    return said


def fit_row(run: Mapping[str, Any], model: Mapping[str, Any]) -> dict[str, Any]:
    """What the table of fits says of a model of a run."""
    test = model["test"]
    rmse, rmse_low, rmse_high = test["rmse"]
    return {
        "model": model["name"],
        "recommended": model["name"] == run["recommended"] and not standing_of_run(run).why_none,
        "sound": model["sound"],
        "rmse": rmse,
        "rmse_low": rmse_low,
        "rmse_high": rmse_high,
        "share": test["share"][0],
        "train_rmse": model["train"]["rmse"][0],
        "parameters": model["parameters_count"],
        "train_rows": run["train_rows"],
        "test_rows": run["test_rows"],
        "effort_unit": run["units"]["effort"],
        "notes": "; ".join(model["notes"]),
    }


#: The columns of `fit_row` for a device that failed.
_NO_FIT: dict[str, Any] = {
    "model": None,
    "recommended": False,
    "sound": None,
    "rmse": None,
    "rmse_low": None,
    "rmse_high": None,
    "share": None,
    "train_rmse": None,
    "parameters": None,
    "train_rows": None,
    "test_rows": None,
    "effort_unit": None,
    "notes": None,
}


def _series_of(parameters: Rows, baseline: int) -> tuple[FleetSeries, ...]:
    """Each number of each model over the devices; its rows get their score, and whether they stand out."""
    groups: dict[tuple[str, str, str], Rows] = {}
    for row in parameters:
        key = row["model"], row["parameter"], row["unit"]
        groups.setdefault(key, []).append(row)

    series: list[FleetSeries] = []
    for (model, parameter, unit), rows in groups.items():
        # A device without this number, or without a place in the order (NaN), is left out.
        known = [row for row in rows if row["value"] is not None and row["order"] == row["order"]]
        known.sort(key=itemgetter("order"))

        # Kept are rows whose number can be told for the fleet's usual reference field. A log without the largest
        # current has its yield effort at the next one: that is no device that stands out.
        fields = [row["at_field"] for row in known if row["at_field"] is not None]
        usual = median_low(fields) if fields else 0.0
        kept: Rows = []
        factors: list[float] = []  # what carries each number to the usual field
        apart: dict[str, float] = {}  # other fields, by the device
        for row in known:
            field: float | None = row["at_field"]
            exponent: float | None = row["field_exponent"]
            factor = 1.0
            if field is not None and usual and field != usual:
                away = abs(field / usual - 1.0)
                if away > (_ONE_FIELD if exponent is None else _NEARBY):
                    apart[row["device"]] = field
                    continue
                factor = float((usual / field) ** (exponent or 0.0)) if field else 1.0
            kept.append(row)
            factors.append(factor)

        to_usual = np.array(factors)
        order = _column(kept, "order")
        value = _column(kept, "value") * to_usual
        low = _column(kept, "low") * to_usual
        high = _column(kept, "high") * to_usual
        scores = outlier_scores(value, low, high)
        for row, score in zip(kept, scores, strict=True):
            row["score"] = float(score) if np.isfinite(score) else None
            row["outlier"] = bool(abs(score) > OUTLYING)
        series.append(
            FleetSeries(
                model=model,
                parameter=parameter,
                unit=unit,
                devices=tuple(row["device"] for row in kept),
                x=order,
                value=value,
                low=low,
                high=high,
                score=scores,
                trend=trend(order, value),
                chart=control_chart(value, baseline),
                apart=apart,
            )
        )
    return tuple(series)


def _column(rows: Rows, name: str) -> Array:
    """Numbers of some rows, NaN where there is none, shape (n,)."""
    values = [row[name] for row in rows]
    return np.array([np.nan if value is None else value for value in values], float)
