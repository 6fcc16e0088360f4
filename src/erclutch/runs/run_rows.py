"""The rows of a run are read back from its folder: measured, estimated by each model, held out or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.errors import LogError, RunError
from erclutch.logs.dataset import Dataset
from erclutch.logs.readers.budget import RAISED
from erclutch.runs.kept_columns import kept_columns
from erclutch.runs.run_folder import Run
from erclutch.runs.run_shape import INPUT
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

_LARGEST = 1e150  # of a row: its square is a number


@dataclass(frozen=True)
class RunRows:
    """Rows of a run.

    Attributes:
        data: fields, slips, further inputs, measured effort, clock.
        test: rows that were held out, shape (n,).
        predicted: effort by model, each (n,), best test error first.
    """

    data: Dataset
    test: Mask
    predicted: Mapping[str, Array]

    def residual(self, model: str) -> Array:
        """Measured minus estimated effort, shape (n,)."""
        return self.data.effort - self.predicted[model]


def read_rows(run: Run) -> RunRows:
    """Read the rows of a run.

    Raises:
        RunError: predictions.parquet is missing, was changed, or does not fit run.json.
    """
    path = run.file("predictions.parquet")
    try:
        columns: dict[str, Any] = dict(kept_columns(path))
        for name, column in columns.items():
            # The estimates of a model that diverged stand there too, and are what they are.
            measured = name == "effort" or name.startswith(("field", "slip"))
            if measured and not (np.abs(column) <= _LARGEST).all():
                raise ValueError(f"{name} is not a number up to {_LARGEST:g} in each row")
        columns["test"] = columns["test"] != 0.0
        body = run.body
        test = columns["test"]
        rows = test.size
        held = int(test.sum())
        if (rows - held, held) != (body["train_rows"], body["test_rows"]):
            raise ValueError(f"{rows} rows, {held} of them held out")
        units = body["units"]
        tails = [""] if body["device"] == "single" else ["1", "2"]
        spans: list[Span] = []
        for start, stop, period in body["spans"]:
            known_period = None if period is None else float(period)
            spans.append(Span(int(start), int(stop), known_period))
        further = {
            name.removeprefix(INPUT): column
            for name, column in columns.items()
            if name.startswith(INPUT)
        }
        data = Dataset(
            device=body["device"],
            elements=tuple(
                Element(columns[f"field{tail}"], columns[f"slip{tail}"]) for tail in tails
            ),
            effort=columns["effort"],
            clock=Clock(columns["time"], tuple(spans)),
            units=Units(units["effort"], units["field"], units["slip"]),
            sources=tuple(str(log["name"]) for log in body["logs"]),
            source_rows=tuple((int(start), int(stop)) for start, stop in body["source_rows"]),
            notes=tuple(body["notes"]),
            origins=tuple(str(log["origin"]) for log in body["logs"]),
            extras=further,
        )
        names = [entry["name"] for entry in body["ranking"]]
        return RunRows(data, test, {name: columns[f"effort:{name}"] for name in names})
    except LogError as error:
        remedy = error.remedy if RAISED in error.remedy else "Fit the log again"
        raise RunError(
            f"does not fit run.json: {error.problem}", where=str(path), remedy=remedy
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise RunError(
            f"does not fit run.json: {error}", where=str(path), remedy="Fit the log again"
        ) from error
