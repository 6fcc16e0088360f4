"""``erclutch inspect`` says what is in a log and how it is read."""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.log_advice import advice_on
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.cli.quantities import SECONDS
from erclutch.errors import AlikeRecordingsError, ErclutchError, LogError, SettingError, require

if TYPE_CHECKING:
    from rich.table import Table as RichTable

    from erclutch.logs import Plan, Table
    from erclutch.logs.dataset import Dataset
    from erclutch.signals.array import Array
    from erclutch.signals.recording import Recording

COMMAND = {
    "help": "Show what is in a log and what each column is taken for.",
    "panel": "The road of a log",
    "place": 3,
}

_FIGURES = ("min", "max", "mean", "missing")
_LEAST_MEAN = 1e-12  # of the largest value: below it a mean is what is left of a sum


def inspect(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    json: Annotated[bool, Parameter(negative=())] = False,
    courses: int = 0,
    plots: Path | None = None,
    start: Annotated[float | None, SECONDS] = None,
    seconds: Annotated[float, SECONDS] = 1.0,
    write_mapping: Path | None = None,
    reading: LogOptions = DEFAULT_READING,
) -> int:
    """Show a log's columns, sampling, gaps and coverage, and which signal each column is taken for.

    The exit code is 1 while anything is missing, in doubt or not understood; then the last line says what settles it.

    Args:
        logs: One log or several; a folder stands for the logs in it. Of several, the columns of the first are shown.
        json: Print as JSON instead of tables.
        courses: With --json: smallest and largest value of each signal in so many stretches of the log.
        plots: Folder for two pictures and their numbers: a section of the log, and where it has data.
        start: First second of the section, on the clock that inspect shows. Default: of a typical section.
        seconds: Length of the section.
        write_mapping: File for the mapping that the log was read by (TOML), with comments where something is missing.
        reading: How to read the log.
    """
    require(1e-6, unit=" s", seconds=seconds)
    require(0, 10_000, courses=courses)
    require(0, unit=" s", start=start or 0.0)
    log, *others = expand(logs)
    look_at = _table if json else _table_or_question
    typed, asked = shlex.join(map(str, logs)), reading
    try:
        raw = look_at(log, reading)
    except AlikeRecordingsError:
        reading = replace(reading, variable="all")
        raw = look_at(log, reading)
    if raw is None:
        return 1
    look = _look(log, others, raw, reading)
    drawn: list[Path] = []
    if plots is not None:
        if look.problem is not None:
            raise look.problem
        drawn = _draw(plots, log, look.read[0], start, seconds, reading)
    if write_mapping is not None:
        look.plan.save(write_mapping)
    if json:
        _print_json(look, courses)
    else:
        _tell(look, write_mapping, drawn)
        _tell_what_is_next(look, typed, asked)
    return int(look.doubtful)


@dataclass(frozen=True)
class _Look:
    """What a look at logs found.

    Attributes:
        log: the first of them; its columns are shown.
        raw: its table.
        plan: how it is read.
        missing: what the user must say of it, a phrase each.
        read: its recordings; none where something stands against them.
        problem: what stands against them.
        further: the recordings of further logs.
        refused: why a log is not read beside the others, by its name.
        rows: the first recording.
        covered: all recordings, as far as they fit together.
        advice: what logs teach nothing new, and what no log has.
    """

    log: Path
    raw: Table
    plan: Plan
    missing: tuple[str, ...]
    read: list[Recording]
    problem: ErclutchError | None
    further: list[Recording]
    refused: dict[str, str]
    rows: Dataset | None
    covered: Dataset | None
    advice: list[str]

    @property
    def every(self) -> list[Recording]:
        """All recordings; none where the first log is not understood."""
        return [*self.read, *self.further] if self.read else []

    @property
    def doubtful(self) -> bool:
        """Whether anything is missing, in doubt or not understood."""
        return self.problem is not None or bool(self.refused or self.plan.doubts)


def _look(log: Path, others: Sequence[Path], raw: Table, reading: LogOptions) -> _Look:
    plan = reading.plan(raw, log)
    missing = () if reading.each else tuple(question.short for question in plan.questions)  # each has its own effort
    read, problem = _read(log, raw, plan, reading)
    further, refused = _further(others, reading)
    rows = reading.dataset(read[:1]) if read else None
    covered = rows
    if read and len(read) + len(further) > 1:
        try:
            covered = reading.dataset([*read, *further])
        except ErclutchError as error:  # such as logs in different units
            refused[error.where] = str(error)
    advice = advice_on(covered) if covered is not None and len(covered.sources) > 1 else []
    return _Look(log, raw, plan, missing, read, problem, further, refused, rows, covered, advice)


def _tell(look: _Look, mapping: Path | None, drawn: Sequence[Path]) -> None:
    """Columns, signals, coverage and advice."""
    _print_columns(look.log, look.raw)
    _offer_mapping(look.log, mapping, look.missing)
    if look.rows is not None and look.covered is not None:
        _print_recordings(look.every, look.rows, look.covered)
        terminal.tell(*look.advice)
    else:
        terminal.tell(*(f"  {note}" for note in look.raw.notes))
        if look.further:
            terminal.tell(_several(look.further))
    for path in drawn:
        terminal.say(f"drawn: {path}")


def _tell_what_is_next(look: _Look, typed: str, reading: LogOptions) -> None:
    """What stands against the logs and the command that settles it; where nothing does, the command that fits them.

    Args:
        look: what was found.
        typed: the logs or the folder, as the user gave them.
        reading: how the user said that they are read.
    """
    alike = _refused_alike(look)
    for name, why in look.refused.items():
        if name not in alike:
            terminal.say(f"Not understood yet: {why}" if why.startswith(name) else f"Not understood yet: {name}: {why}")
    if look.problem is not None:
        settled = _settling(look.plan, look.problem)
        if len(alike) == len(look.refused):  # one command settles it for all of them
            settled = settled.replace(shlex.quote(look.plan.path), typed)
        several = settled and len(look.plan.questions) > 1  # their remedy is that command: it is printed once
        why = f"{look.problem.where}: {look.problem.problem}" if several else str(look.problem)
        terminal.say(f"Not understood yet: {why}")  # one line: it may hold a command to copy
        if alike:
            terminal.say(f"The same is asked of {len(alike)} more log{'s'[: len(alike) != 1]}, the last {alike[-1]}")
        if settled:
            terminal.say(f"What settles it: {settled}")
    elif look.plan.doubts:
        doubtful = look.plan.command().replace(shlex.quote(look.plan.path), typed)
        terminal.say(f"In doubt: {'; '.join(look.plan.doubts)}. If that is right, say so: {doubtful}")
    elif not look.refused:
        command = " ".join(["erclutch fit", typed, *map(shlex.quote, reading.words())])
        terminal.say(f"Understood. Fit {'them' if look.further else 'it'}: {command} --out RUN")


def _refused_alike(look: _Look) -> tuple[str, ...]:
    """The further logs for which the first log's problem stands too: it is told once."""
    if look.problem is None:
        return ()
    told = str(look.problem).replace(look.plan.path, "").replace(look.log.name, "")
    folder = str(look.log.parent)
    return tuple(
        name for name, why in look.refused.items() if why.replace(str(Path(folder, name)), "").replace(name, "") == told
    )


def _read(log: Path, raw: Table, plan: Plan, reading: LogOptions) -> tuple[list[Recording], ErclutchError | None]:
    """The recordings of the first log, or what stands against them."""
    from erclutch.logs import apply

    try:
        return reading.read([log]) if reading.each else [reading.how().finished(apply(plan, raw))], None
    except SettingError:
        raise
    except ErclutchError as error:
        return [], error


def _is_of_a_rheometer(plan: Plan) -> bool:
    """Whether a table without a time holds a shear rate and a shear stress, by names or units."""
    if not any(question.signal == "time" for question in plan.questions):
        return False
    letters = {name.lower() for name in plan.labels}
    if {"gamma", "γ"} & letters and {"tau", "τ"} & letters:
        return True
    chosen = [plan.signal("slip"), plan.signal("effort")]
    return all(each is not None and (each.unit in ("1/s", "Pa") or "shear" in each.column.lower()) for each in chosen)


def _settling(plan: Plan, problem: ErclutchError) -> str:
    """The command that answers all questions about a log; "" where only another file helps."""
    if plan.questions:
        # Points of a rheometer are for laws at one field.
        return shlex.join(["erclutch", "flowcurve", plan.path]) if _is_of_a_rheometer(plan) else plan.command()
    if "(--time none)" in problem.remedy and plan.signal("slip") is not None:
        return f"{plan.command().rstrip()} --time none"
    return f"{plan.command().rstrip()} --invalid drop" if "--invalid drop" in problem.remedy else ""


def _further(logs: Sequence[Path], reading: LogOptions) -> tuple[list[Recording], dict[str, str]]:
    """The recordings of further logs, and by its name what is wrong with each log that is not understood."""
    further: list[Recording] = []
    refused: dict[str, str] = {}
    for log in logs:
        try:
            further += reading.read([log])
        except SettingError:
            raise
        except ErclutchError as error:
            refused[log.name] = str(error)
    return further, refused


def _print_recordings(read: list[Recording], first: Dataset, covered: Dataset) -> None:
    """The signals of the first log; what each of several is read as; what they cover."""
    if len(read) > 1:
        terminal.tell(_several(read))
    _print_signals(read[0], first)
    _print_coverage(covered)


def _table_or_question(log: Path, reading: LogOptions) -> Table | None:
    """The log as it is; None where an option must say how it is read, and that option is printed as a command."""
    try:
        return _table(log, reading)
    except AlikeRecordingsError:
        raise
    except LogError as error:
        option = re.search(r"--variable (?:'[^']*'|[^\s,;]+)[^;,.]*|--decimal [.,]", error.remedy)
        if option is None:
            raise
        terminal.say(f"Not understood yet: {error}")
        terminal.say(f"What settles it: {shlex.join(['erclutch', 'inspect', str(log)])} {option.group()}")
        return None


def _table(log: Path, reading: LogOptions) -> Table:
    """The log as it is; of a file that holds several recordings and all are wanted, the first."""
    from erclutch.logs import recordings_in, table_of_log
    from erclutch.logs.recording_choice import logs_among

    variable = reading.variable
    if reading.each:  # the first that is a log of a device: a sheet of settings may stand before it
        names = recordings_in(log, variable)
        variable = next(iter(logs_among(log, names, reading.column_map(), reading.device)), next(iter(names), None))
    with terminal.progress("reading") as bar:

        def told(done: int, size: int) -> None:
            if done < size:
                bar(done, size, f"{done / 1e6:.0f} of {size / 1e6:.0f} MB read")
            else:
                bar(done, None, "columns, clock and checks")

        return table_of_log(log, reading.column_map(), reading.device, variable, told)


def _offer_mapping(log: Path, written: Path | None, missing: Sequence[str]) -> None:
    if written is None and not missing:
        return
    if written is None:
        offer = shlex.join(["erclutch", "inspect", str(log), "--write-mapping", f"{log}.toml"])
        terminal.say(f"A mapping file to fill in: {offer}")
        return
    terminal.say(f"Mapping written: {written}" + (f"; {len(missing)} to fill in" if missing else ""))


def _print_columns(log: Path, raw: Table) -> None:
    terminal.tell(f"{log.name}: {raw.rows:,} row{'s'[: raw.rows != 1]}, {len(raw.columns)} columns")
    rows = [
        [name, raw.units.get(name) or "-", *(terminal.number(v) for v in _figures(values))]
        for name, values in raw.columns.items()
    ]
    terminal.tell(terminal.table("Columns", ["name", "unit", "smallest", "largest", "mean", "missing"], rows, left=2))
    terminal.tell(f"  damage to the file is {raw.damage}")
    if raw.clock is not None:
        terminal.tell(f"  {_dates(raw.clock_name, raw.clock)}")


def _several(recordings: Sequence[Recording]) -> RichTable:
    """Several logs; the signals that follow are those of the first."""

    def ends(values: Array | None) -> str:
        low, high = ("", "") if values is None else (terminal.number(float(v)) for v in _figures(values)[:2])
        return low if low == high else f"{low} .. {high}"

    units = recordings[0].units
    names = [name for name in recordings[0].signals if not name.startswith(("input:", "spare column"))]
    heads = [terminal.with_unit(name, units[name]) for name in names]
    endings = {Path(r.name).suffix for r in recordings}
    alike = endings.pop() if len(endings) == 1 else ""  # what all names end in tells none apart
    rows = [
        [r.name.removesuffix(alike), f"{r.rows:,}", *(ends(r.signals.get(name)) for name in names)] for r in recordings
    ]
    title = f"{len(recordings)} logs; columns and signals are shown of the first"
    return terminal.table(title, ["", "rows", *heads], rows, left=1)


def _print_signals(recording: Recording, data: Dataset) -> None:
    terminal.tell("\n".join(terminal.recording_lines([recording], most=50)))
    ranges = [
        [name, recording.units[name] or "1", *(terminal.number(v) for v in _figures(values)[:3])]
        for name, values in recording.signals.items()
    ]
    if "position" in recording.signals and "slip" not in recording.signals:
        slips = (terminal.number(v) for v in _figures(data.elements[0].slip)[:3])
        ranges.append(["slip (derived)", data.units.slip or "1", *slips])
    terminal.tell(terminal.table("Signals", ["name", "unit", "smallest", "largest", "mean"], ranges, left=2))
    if len(recording.segments) > 1:
        terminal.tell(_segments(recording, data))


def _print_coverage(data: Dataset) -> None:
    """Where all logs have rows, and what is odd in them."""
    units = (data.units.field, data.units.slip)
    for i, element in enumerate(data.elements):
        name = f" of CH{i + 1}" if len(data.elements) > 1 else ""
        terminal.tell(terminal.coverage(element.field, element.slip, name, units))
    terminal.tell(*_findings(data), style="yellow")


def _findings(data: Dataset) -> list[str]:
    """What is odd in a log, each with its level."""
    from erclutch.fit.history import effort_finding
    from erclutch.fit.sensor_check import sensor_findings

    memory = effort_finding(data)
    return [f"{found.level}: {found}" for found in (*sensor_findings(data), *([memory] if memory else []))]


def _dates(name: str, clock: Array) -> str:
    """What a column of dates holds, and its pauses: they say how many stretches the log has."""
    import numpy as np

    steps = np.diff(clock)
    pauses = int(np.count_nonzero(steps > 1.5 * np.median(steps))) if steps.size else 0
    many = f", {pauses} pause{'s' if pauses > 1 else ''}" if 0 < pauses <= 0.1 * steps.size else ""
    return f"column {name} holds dates and times over {clock[-1] - clock[0]:.4g} s{many}"


def _segments(recording: Recording, data: Dataset, most: int = 12) -> RichTable:
    """The segments between gaps, with the field of each."""
    import numpy as np

    def row(number: int, start: int, stop: int) -> list[str]:
        fields = np.concatenate([e.field[start:stop] for e in data.elements])
        low, high = terminal.number(float(fields.min())), terminal.number(float(fields.max()))
        at = recording.time[start], recording.time[stop - 1]
        times = [terminal.number(float(t), 5) for t in at]
        return [str(number), f"{stop - start:,}", *times, low if low == high else f"{low} .. {high}"]

    spans = data.clock.spans
    rows = [row(k, s.start, s.stop) for k, s in enumerate(spans[:most], start=1)]
    field = terminal.with_unit("field", data.units.field)
    title = "Segments between gaps" + (f", the first {most} of {len(spans)}" if len(spans) > most else "")
    return terminal.table(title, ["", "rows", "from [s]", "to [s]", field], rows)


def _draw(
    folder: Path, log: Path, recording: Recording, start: float | None, seconds: float, reading: LogOptions
) -> list[Path]:
    """Figure 3 and the coverage of a log, in a folder."""
    from erclutch.report.plots.log_plots import describe_coverage, describe_section, titled
    from erclutch.report.plots.matplotlib_painter import save_plot

    if start is not None and start >= recording.time[-1]:
        raise SettingError(f"--start {start:g} s", remedy=f"Give less than {recording.time[-1]:.4g} s, the log's end")
    section = describe_section(recording, start=start, seconds=seconds)
    coverage = describe_coverage(reading.dataset([recording]), titled(recording))
    drawn = {"section": section, "coverage": coverage}
    return [path for name, plot in drawn.items() for path in save_plot(plot, folder / f"{log.stem}-{name}.png")]


def _figures(values: Array) -> tuple[float, float, float, float]:
    """Smallest, largest and mean, and how many are missing."""
    import numpy as np

    finite = values[np.isfinite(values)] if np.isfinite(values).any() else np.array([np.nan])
    missing = np.count_nonzero(~np.isfinite(values))
    low, high, mean = float(finite.min()), float(finite.max()), float(finite.mean())
    largest = max(abs(low), abs(high))
    return low, high, 0.0 if abs(mean) < _LEAST_MEAN * largest else mean, float(missing)


def _print_json(look: _Look, courses: int) -> None:
    from erclutch.cli.column_courses import courses_of, sketch

    columns: dict[str, object] = {}
    for name, values in look.raw.columns.items():
        figures = (None if figure != figure else figure for figure in _figures(values))
        shown = dict(zip(_FIGURES, figures, strict=True))
        columns[name] = {"unit": look.raw.units.get(name), **shown, "sketch": sketch(values)}
    choices = {
        name: dict(asdict(choice), file_unit=look.raw.units.get(str(choice.column)))
        for name, choice in look.plan.choices.items()
    }
    body: dict[str, Any] = {
        "columns": columns,
        "damage": look.raw.damage,
        "notes": list(look.raw.notes),
        "problem": str(look.problem) if look.problem else None,
        "findings": _findings(look.covered) if look.covered else [],
        "missing": list(look.missing),
        "doubts": list(look.plan.doubts),
        "refused": look.refused,
        "mapping": tomllib.loads(look.plan.to_toml()),
        "choices": choices,
    }
    if look.advice:
        body["advice"] = look.advice
    if courses and look.read:
        body["over_time"] = courses_of(look.read[0], courses)
    if look.read:
        recording, *further = look.every
        body |= {
            "further": [{"name": each.name, "rows": each.rows, "sha256": each.digest} for each in further],
            "signals": dict(recording.units),
            "rows": recording.rows,
            "period_s": recording.period,
            "uniform": recording.uniform,
            "segments": [list(s) for s in recording.segments],
            "sha256": recording.digest,
            "reading": list(recording.notes),
        }
    print(dumps(body, indent=1, allow_nan=False))
