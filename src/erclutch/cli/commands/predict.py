"""``erclutch predict`` writes what a kept model says of each row of a log."""

from __future__ import annotations

from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.errors import RunError, SettingError
from erclutch.files import (
    LOG_ENDINGS,
    may_write_file,
    require_room,
    spare_logs,
    unwritable,
    whole_folder,
)
from erclutch.files.places import is_there, nothing, release, reserve
from erclutch.signals.percent import percent

if TYPE_CHECKING:
    from erclutch.models.model import Model
    from erclutch.runs.run_folder import Run
    from erclutch.signals.array import Array

COMMAND = {
    "help": "Write the effort of a kept model for each row of a log, with its band.",
    "panel": "The road of a log",
    "place": 6,
}

_UNWRITABLE = partial(unwritable, problem="the folder cannot be written")


def predict(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    run: Path,
    out: Path,
    model: str | None = None,
    band: Annotated[bool, Parameter(negative=())] = False,
    sensor: Annotated[bool, Parameter(negative=())] = False,
    kind: Annotated[Literal["csv", "parquet", "mat"], Parameter(name="--as")] = "csv",
    force: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Write the effort that a kept model estimates for each row of a log.

    Columns: time, field and slip of each element, further inputs, effort, low and high end of the band if asked for,
    and outside: 1 where the model guesses, beyond what it was trained on. The log needs no effort of its own.

    Args:
        logs: A log of the model's device. Several, or a folder of logs, give a folder with a file for each.
        run: The folder of a run, or a model's JSON file.
        out: File to write: .csv, .parquet or .mat. Of several logs: the folder to write.
        model: Which model of the run, by its id (m2) or specification; final: of all rows. Default: the recommended.
        band: Also write the band, which holds 95 % of rows like those of the run.
        sensor: Also write the band; it learns from the log's measured effort, row by row, from past rows alone.
        kind: Format of the files, where there are several logs.
        force: Replace a file or folder that is there.
        reading: How to read the log; by default as the run's own logs were read.
    """
    from erclutch.logs.log_writer import is_prediction
    from erclutch.logs.names_of_logs import names_apart
    from erclutch.runs.new_rows import opened

    files = expand(logs)
    names = names_apart(files)
    several = len(files) > 1 or logs[0].is_dir()
    if several:
        # A folder of predictions may be replaced where that is asked for, and no other folder.
        def are_predictions(folder: Path) -> bool:
            """Whether a folder holds nothing but predictions."""
            return folder.is_dir() and all(is_prediction(path) for path in folder.iterdir())

        may_replace = are_predictions if force else nothing
        require_room(out)
        reserve(out, may_replace)
        if is_there(out) and not may_replace(out):
            release(out)
            problem = "exists and holds more than predictions" if force else "exists already"
            raise RunError(problem, where=str(out), remedy="Give --out another name")
    else:
        may_write_file(out, force, endings=LOG_ENDINGS)
        spare_logs(files, [out])
    kept, chosen = opened(run, model)
    how = reading.like(kept, chosen)
    if not sensor:
        how = how.without_effort(chosen.units.effort)
    if several:
        # Logs of one name in several folders have the folders in the names of their predictions; log.csv and log.mat
        # would be one file.
        stems = [PurePath(name).with_suffix("").as_posix().replace("/", "_") for name in names]
        twice = next((stem for stem in stems if stems.count(stem) > 1), None)
        if twice is not None:
            remedy = "Give their predictions apart, each to a file"
            raise SettingError(f"two logs are called {twice}", where=str(out), remedy=remedy)
        if out.is_file() or out.suffix.lower() in LOG_ENDINGS:
            remedy = "Give --out the name of a folder"
            raise SettingError(f"one file for {len(files)} logs", where=str(out), remedy=remedy)
        with whole_folder(out, _UNWRITABLE) as folder, terminal.progress("predicting") as bar:
            for done, (file, stem) in enumerate(zip(files, stems, strict=True)):
                bar(done, len(files), file.name)
                of_file = folder / f"{stem}.{kind}"
                told = _estimated(file, how, chosen, kept, of_file, band=band, sensor=sensor)
                terminal.say(f"{names[done]}: {told}")
    else:
        summary = _estimated(files[0], how, chosen, kept, out, band=band, sensor=sensor)
        terminal.say(summary)
    terminal.say(f"Written to {out}")


def _estimated(
    file: Path,
    how: LogOptions,
    model: Model,
    run: Run | None,
    out: Path,
    *,
    band: bool,
    sensor: bool,
) -> str:
    """Write the prediction of one log by a model of a run, or by a model alone; what to say of it."""
    import numpy as np

    from erclutch.logs.log_writer import PREDICTED, write_log
    from erclutch.runs.new_rows import (
        band_ends,
        quicker_than_known,
        unlike_training,
        where_outside,
    )

    recordings = how.read([file])
    recording = recordings[0]
    data = how.dataset(recordings)
    effort = model.predict(data)
    outside = model.outside(data)
    unit = model.units.effort.replace("?", "")

    # Columns of the file, with their units.
    columns: dict[str, tuple[Array, str]] = {"time": (data.clock.time, "s")}
    for name, (values, of_signal) in data.named_signals.items():
        columns[name] = (values, of_signal.replace("?", ""))
    for name in model.extras:
        columns[name] = (data.extras[name], "")
    columns["effort"] = (effort, unit)
    summary = f"{model.name}: {data.rows:,} rows, {percent(outside.mean(), 2)} of them outside what it was trained on"
    if band or sensor:
        low, high = band_ends(data, model, effort, sensor)
        columns["low"] = (low, unit)
        columns["high"] = (high, unit)
        bandless = int(np.count_nonzero(np.isnan(low)))
        if bandless:
            summary += f", {bandless:,} without a band: nothing like them was ever logged"
        quick = int(np.count_nonzero(quicker_than_known(model, data)))
        if quick:
            summary += f", {quick:,} in quicker motion than any training log: their band is wider"
    columns["outside"] = (outside.astype(float), "")

    about = {"label": PREDICTED, "model": model.name, "log": recording.name}
    if recording.origin:
        about["of"] = recording.origin
    labels = [(name, of_column) for name, (_, of_column) in columns.items()]
    rows = np.column_stack([values for values, _ in columns.values()])
    write_log(out, labels, [rows], about, rows=len(rows))
    where = where_outside(model, data, outside) if outside.any() else ""
    if where:
        summary += f"\nnote: outside: {where}."
    if model.unbounded and outside.any():
        summary += f"\nnote: {model.unbounded}."
    for sentence in (*terminal.rows_left_out(recording), *unlike_training(run, model, data)):
        summary += f"\nnote: {sentence}"
    return summary
