"""``erclutch inspect``: what is in a log, and what it is taken for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import ErclutchError, SettingError

if TYPE_CHECKING:
    from erclutch.dataset import Dataset
    from erclutch.logs import Table
    from erclutch.signals import Array, Recording


def inspect(
    log: Annotated[Path, Parameter(name="LOG")],
    *,
    json: Annotated[bool, Parameter(negative=())] = False,
    plots: Path | None = None,
    start: float | None = None,
    seconds: float = 1.0,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Show a log's columns, sampling, gaps and coverage, and what each column is taken for.

    Args:
        log: The log.
        json: Print as JSON instead of tables.
        plots: Folder for two pictures and their numbers: a section of the log, and where it has data.
        start: First second of the section. Default: a typical one.
        seconds: Length of the section.
        reading: How to read the log.
    """
    from erclutch.cli import show
    from erclutch.logs import read_table

    if not seconds > 0 or not (start is None or start >= 0):
        raise SettingError(
            f"--seconds {seconds} --start {start}", remedy="Give a length above 0 and a start of 0 or more"
        )
    raw = read_table(log, variable=reading.variable)
    problem: ErclutchError | None = None
    recording = None
    try:
        recording = reading.read([log])[0]
    except ErclutchError as error:
        problem = error
    drawn = [] if plots is None else _draw(plots, log, recording, problem, start, seconds, reading)
    if json:
        _print_json(raw, recording, problem)
        return
    _print_columns(log, raw)
    if recording is None:
        _print_problem(raw, problem)
        return
    _print_signals(recording, reading.dataset([recording]))
    for path in drawn:
        show.console().print(f"drawn: {path}", markup=False, soft_wrap=True)


def _print_columns(log: Path, raw: Table) -> None:
    from erclutch.cli import show

    screen = show.console()
    screen.print(f"{log.name}: {raw.rows:,} rows, {len(raw.columns)} columns", markup=False)
    rows = [
        [name, raw.units.get(name) or "-", *(show.number(v) for v in _figures(values))]
        for name, values in raw.columns.items()
    ]
    screen.print(show.table("Columns", ["name", "unit", "smallest", "largest", "mean", "missing"], rows, left=2))
    if raw.clock is not None:
        screen.print(f"  {_dates(raw.clock_name, raw.clock)}", markup=False)


def _print_problem(raw: Table, problem: ErclutchError | None) -> None:
    from erclutch.cli import show

    screen = show.console()
    for note in raw.notes:
        screen.print(f"  {note}", markup=False)
    screen.print(f"Not understood yet: {problem}", style="yellow", markup=False)


def _print_signals(recording: Recording, data: Dataset) -> None:
    from erclutch.cli import show

    screen = show.console()
    screen.print("\n".join(show.recording_lines([recording], most=50)), markup=False)
    ranges = [
        [name, recording.units[name] or "1", *(show.number(v) for v in _figures(values)[:3])]
        for name, values in recording.signals.items()
    ]
    if "position" in recording.signals and "slip" not in recording.signals:
        slips = (show.number(v) for v in _figures(data.elements[0].slip)[:3])
        ranges.append(["slip (derived)", data.units.slip or "1", *slips])
    screen.print(show.table("Signals", ["name", "unit", "smallest", "largest", "mean"], ranges, left=2))
    if len(recording.segments) > 1:
        screen.print(_segments(recording, data))
    units = (data.units.field, data.units.slip)
    for i, element in enumerate(data.elements):
        name = f" of CH{i + 1}" if len(data.elements) > 1 else ""
        screen.print(show.coverage(element.field, element.slip, name, units), markup=False)


def _dates(name: str, clock: Array) -> str:
    """What a column of dates holds, and its pauses: they say how many stretches the log has."""
    import numpy as np

    steps = np.diff(clock)
    pauses = int(np.count_nonzero(steps > 1.5 * np.median(steps))) if steps.size else 0
    many = f", {pauses} pause{'s' if pauses > 1 else ''}" if 0 < pauses <= 0.1 * steps.size else ""
    return f"column {name} holds dates and times over {clock[-1] - clock[0]:.4g} s{many}"


def _segments(recording: Recording, data: Dataset, most: int = 12) -> object:
    """The segments between gaps, with the field of each."""
    import numpy as np

    from erclutch.cli import show

    def row(number: int, start: int, stop: int) -> list[str]:
        fields = np.concatenate([e.field[start:stop] for e in data.elements])
        low, high = show.number(float(fields.min())), show.number(float(fields.max()))
        at = recording.time[start], recording.time[stop - 1]
        times = [show.number(float(t), 5) for t in at]
        return [str(number), f"{stop - start:,}", *times, low if low == high else f"{low} .. {high}"]

    spans = data.clock.spans
    rows = [row(k, s.start, s.stop) for k, s in enumerate(spans[:most], start=1)]
    field = show.with_unit("field", data.units.field)
    title = "Segments between gaps" + (f", the first {most} of {len(spans)}" if len(spans) > most else "")
    return show.table(title, ["", "rows", "from [s]", "to [s]", field], rows)


def _draw(
    folder: Path,
    log: Path,
    recording: Recording | None,
    problem: ErclutchError | None,
    start: float | None,
    seconds: float,
    reading: LogOptions,
) -> list[Path]:
    """Figure 3 and the coverage of a log, in a folder."""
    from erclutch.figures.coverage import draw_coverage
    from erclutch.figures.section import draw_section, titled

    if recording is None:
        raise problem or SettingError("the log is not understood", remedy="Inspect it without --plots")
    section = draw_section(recording, folder / f"{log.stem}-section.png", start=start, seconds=seconds)
    data = reading.dataset([recording])
    return [*section, *draw_coverage(data, folder / f"{log.stem}-coverage.png", titled(recording))]


def _figures(values: Array) -> tuple[float, float, float, float]:
    import numpy as np

    finite = values[np.isfinite(values)]
    missing = float(values.size - finite.size)
    if not finite.size:
        return float("nan"), float("nan"), float("nan"), missing
    return float(finite.min()), float(finite.max()), float(finite.mean()), missing


def _print_json(raw: Table, recording: Recording | None, problem: ErclutchError | None) -> None:
    from json import dumps

    body: dict[str, object] = {
        "columns": {
            name: {
                "unit": raw.units.get(name),
                **dict(zip(("min", "max", "mean", "missing"), map(_or_null, _figures(v)), strict=True)),
            }
            for name, v in raw.columns.items()
        },
        "notes": list(raw.notes),
        "problem": str(problem) if problem else None,
    }
    if recording is not None:
        body |= {
            "signals": dict(recording.units),
            "rows": recording.rows,
            "period_s": recording.period,
            "uniform": recording.uniform,
            "segments": [list(s) for s in recording.segments],
            "sha256": recording.digest,
            "reading": list(recording.notes),
        }
    print(dumps(body, indent=1, allow_nan=False))


def _or_null(value: float) -> float | None:
    return value if value == value else None
