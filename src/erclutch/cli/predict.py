"""``erclutch predict`` writes what a kept model says of each row of a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions, opened
from erclutch.errors import RunError, SettingError

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset
    from erclutch.models.model import Model
    from erclutch.signals.array import Array


def predict(
    log: Annotated[Path, Parameter(name="LOG", negative=())],
    *,
    model: Path,
    out: Path,
    name: str | None = None,
    band: Annotated[bool, Parameter(negative=())] = False,
    sensor: Annotated[bool, Parameter(negative=())] = False,
    force: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Write the effort that a kept model estimates for each row of a log.

    Columns: time, field and slip of each element, further inputs, effort, low and high end of the band if asked for,
    and outside: 1 where the model guesses, beyond what it was trained on. The log needs no effort of its own.

    Args:
        log: A log of the device that the model is of.
        model: The folder of a run, or a model's JSON file.
        out: File to write: .csv, .parquet or .mat.
        name: Which model of a run; the recommended one by default.
        band: Also write the band, which holds 95 % of rows like those of the run.
        sensor: Also write the band; it learns from the log's measured effort, row by row, from past rows alone.
        force: Replace a file that is there.
        reading: How to read the log; by default as the run's own logs were read.
    """
    if out.exists() and not force:
        raise RunError("there is a file already", where=str(out), remedy="Give --out another name, or --force")
    run, chosen = opened(model, name)
    how = reading.like(run, chosen)
    recordings = (how if sensor else how.without_effort(chosen.units.effort)).read([log])
    if len(recordings) > 1:
        raise SettingError(f"{len(recordings)} logs in a folder", where=str(log), remedy="Give one log at a time")
    data = how.dataset(recordings)
    effort = chosen.predict(data)
    columns = _columns(data, chosen)
    columns["effort"] = effort, chosen.units.effort
    if band or sensor:
        low, high = _ends(data, chosen, effort, sensor)
        columns |= {"low": (low, chosen.units.effort), "high": (high, chosen.units.effort)}
    outside = chosen.outside(data)
    columns["outside"] = outside.astype(float), ""
    _write(out, columns, {"label": "PREDICTED", "model": chosen.name, "log": recordings[0].name})
    terminal.say(f"{chosen.name}: {data.rows:,} rows, {outside.mean():.2%} of them outside what it was trained on")
    terminal.say(f"Written to {out}")


def _columns(data: Dataset, model: Model) -> dict[str, tuple[Array, str]]:
    """Time and the model's inputs: values (n,) and unit by name."""
    columns = {"time": (data.clock.time, "s")}
    tails = [""] if len(data.elements) == 1 else [str(i + 1) for i in range(len(data.elements))]
    for tail, element in zip(tails, data.elements, strict=True):
        columns[f"field{tail}"] = element.field, data.units.field
        columns[f"slip{tail}"] = element.slip, data.units.slip
    return columns | {extra: (data.extras[extra], "") for extra in model.extras}


def _ends(data: Dataset, model: Model, effort: Array, sensor: bool) -> tuple[Array, Array]:
    """Low and high end of the band, each (n,)."""
    from erclutch.models.adaptive_band import adapted

    if model.band is None:
        raise SettingError("the model has no band", where=model.name, remedy="Fit its log again with this version")
    ends = model.band.around(effort, data.elements, data.clock)
    return adapted(model.band, ends, effort, data.effort, data.clock) if sensor else ends


def _write(out: Path, columns: dict[str, tuple[Array, str]], about: dict[str, str]) -> None:
    import numpy as np

    from erclutch.logs.log_writer import write_log

    rows = np.column_stack([values for values, _ in columns.values()])
    labels = [(name, unit.replace("?", "")) for name, (_, unit) in columns.items()]
    write_log(out, labels, [rows], about, rows=len(rows))
