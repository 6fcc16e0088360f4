"""Ranking: every model with its error, its interval and its price in parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.text import count, number, percent
from erclutch.report.section import Section


class Ranking(Section):
    """The table of models."""

    name: ClassVar[str] = "ranking"
    title: ClassVar[str] = "All models, best first"
    short: ClassVar[str] = "Models"

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        ranking = material.body["ranking"]
        finite = [e["test"]["rmse"] for e in ranking if e["test"]["rmse"][0] is not None]
        # One model gone wild must not flatten the bars of all others.
        most = min(max(f[2] for f in finite), 4.0 * finite[0][0]) if finite else 1.0
        roles = {s.name: s.role for s in material.shown}
        rows = [_row(material, e, i, most, roles.get(e["name"], "")) for i, e in enumerate(ranking, start=1)]
        return {
            "unit": material.effort.unit,
            "rows": rows,
            "noted": [row for row in rows if row["notes"]],
            "test_rows": count(material.body["test_rows"]),
            "train_rows": count(material.body["train_rows"]),
            "folds": any(e["folds_rmse"] for e in ranking),
        }


def _row(material: Material, entry: Mapping[str, Any], rank: int, most: float, role: str) -> dict[str, Any]:
    test, effort = entry["test"], material.effort
    value, low, high = (None if v is None else min(100.0 * v / most, 100.0) for v in test["rmse"])
    more = entry["excess_over_best"]
    folds = entry["folds_rmse"]
    return {
        "rank": rank,
        "name": entry["name"],
        "title": entry["title"],
        "role": role,
        "recommended": entry["name"] == material.recommended,
        "parameters": entry["parameters_count"],
        "weights": bool(entry["fit"]["weights"]),
        "bar": None if value is None else {"value": value, "low": low, "high": high},
        "off": test["rmse"][0] is not None and test["rmse"][0] > most,
        "rmse": effort.bare(test["rmse"][0]),
        "band": effort.band(test["rmse"]),
        "share": percent(test["share"][0]),
        "over": "–" if more[0] is None else f"{number(100 * more[0], 2)} %",
        "over_band": ""
        if more[0] is None or rank == 1
        else f"{number(100 * (more[1] or 0.0), 2)} to {number(None if more[2] is None else 100 * more[2], 2)}",
        "r2": number(test["r2"][0], 3),
        "largest": effort.bare(test["largest"][0]),
        "train": effort.bare(entry["train"]["rmse"][0]),
        "folds": effort.bare((sum(f * f for f in folds) / len(folds)) ** 0.5) if folds else "–",
        "notes": "; ".join(entry["notes"]),
    }
