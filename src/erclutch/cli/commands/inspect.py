"""``erclutch inspect`` says what is in a log and how it is read."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli import log_tables, terminal
from erclutch.cli.log_look import LogLook, look_at, table_of_first, write_fields
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.cli.quantities import SECONDS
from erclutch.cli.rheometer_points import (
    UNIT_TO_FILL_IN,
    flow_command,
    is_of_a_rheometer,
    may_be_flow_curves,
    points_command,
    tried_flow_command,
    without_their_unit,
)
from erclutch.cli.tried_answer import answer_to, tried_answer, with_options
from erclutch.errors import (
    AlikeRecordingsError,
    ErclutchError,
    LogError,
    SettingError,
    SeveralRecordingsError,
    UnloggedFieldError,
    plural,
    require,
)
from erclutch.files import may_fill, require_room
from erclutch.files.groups import together

if TYPE_CHECKING:
    from erclutch.logs import Table

COMMAND = {
    "help": "Show what is in a log and what each column is taken for.",
    "panel": "The road of a log",
    "place": 3,
}

#: Options that say which log of a file is meant, and not how its columns are read.
_WHICH_LOG = ("--variable", "--decimal")


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
    if plots is not None:
        may_fill(plots, "plots")
    if write_mapping is not None:
        require_room(write_mapping, "write-mapping")
    log, *others = expand(logs)
    read_table = table_of_first if json else _table_or_question
    asked = reading
    try:
        raw = read_table(log, reading)
    except AlikeRecordingsError:  # which of them is meant need not be asked: all of them are
        reading = replace(reading, variable="all")
        raw = read_table(log, reading)
    if raw is None:
        return 1
    look = look_at(log, others, raw, reading)
    drawn: list[Path] = []
    is_field_open = isinstance(look.problem, UnloggedFieldError)
    from erclutch.logs.saved_plan import save_plan

    if plots is not None:
        from erclutch.report.plots.log_plots import describe_coverage, describe_section, titled
        from erclutch.report.plots.matplotlib_painter import save_plot

        if look.problem is not None:
            raise look.problem
        recording = look.read[0]
        if start is not None and start >= recording.time[-1]:
            remedy = f"Give less than {recording.time[-1]:.4g} s, the log's end"
            raise SettingError(f"--start {start:g} s", remedy=remedy)
        section = describe_section(recording, start=start, seconds=seconds)
        coverage = describe_coverage(reading.dataset([recording]), titled(recording))
        with together():
            drawn += save_plot(section, plots / f"{log.stem}-section.png")
            drawn += save_plot(coverage, plots / f"{log.stem}-coverage.png")
            if write_mapping is not None:
                save_plan(look.plan, write_mapping)
    elif write_mapping is not None and not is_field_open:
        save_plan(look.plan, write_mapping)
    fields_to_fill_in = 0
    if write_mapping is not None and is_field_open:
        fields_to_fill_in = write_fields([log, *others], write_mapping)
        if not fields_to_fill_in:
            look = look_at(log, others, raw, reading)
    if json:
        body = _as_json(look, courses)
        terminal.say_json(body)
    else:
        _tell(look, write_mapping, asked)
        for path in drawn:
            terminal.say(f"drawn: {path}")
        if fields_to_fill_in:
            typed = shlex.join(map(str, logs))
            them = f"{fields_to_fill_in} {plural(fields_to_fill_in, 'field')}"
            terminal.say(f"Fill in {them} in {write_mapping}, then: erclutch inspect {typed}")
            return 1
        _tell_what_is_next(look, shlex.join(map(str, logs)), asked)
    return int(look.doubtful or bool(_held(look, asked)))


def _table_or_question(log: Path, reading: LogOptions) -> Table | None:
    """The log as it is; None where an option must say how it is read, and that option is printed as a command."""
    from erclutch.logs.columns.rheometer_names import of_oscillation, tells_a_flow_curve
    from erclutch.logs.log_file import looked_into, recordings_in, tables_in

    try:
        return table_of_first(log, reading)
    except AlikeRecordingsError:
        raise
    except LogError as error:
        if not error.option:
            raise
        settled = f"{shlex.join(['erclutch', 'inspect', str(log)])} {error.option}"
        swings: dict[str, None] = {}  # columns of oscillations, each once
        if isinstance(error, SeveralRecordingsError):
            by_name = tables_in(log, looked_into(recordings_in(log)))
            tables = [table for table in by_name.values() if not isinstance(table, LogError)]
            if any(tells_a_flow_curve(table.columns) for table in tables):
                settled = tried_flow_command(str(log), {})
                settled = settled or shlex.join(["erclutch", "flowcurve", str(log)])
            elif may_be_flow_curves(tables) and (flow := tried_flow_command(str(log), {})):
                settled = flow
            else:
                swings = {name: None for table in tables for name in of_oscillation(table.columns)}
                settled = _with_answers(settled, by_name, log, reading)
        if swings:
            terminal.say(f"Not understood yet: {log.name}: {_oscillates(list(swings))}")
            return None
        terminal.say(f"Not understood yet: {error}")
        terminal.say(f"What settles it: {with_options(settled, reading)}")
        return None


def _with_answers(
    command: str, by_name: Mapping[str, Table | LogError], log: Path, reading: LogOptions
) -> str:
    """The command that names one recording of several, with what would be asked about that recording next.

    Where only the user could answer, the command stays as it is: that question has words of its own.
    """
    words = shlex.split(command)
    if words[-2] != "--variable":
        return command
    table = by_name.get(words[-1])
    if table is None or isinstance(table, LogError):
        return command
    plan = replace(reading, variable=words[-1]).plan(table, log)
    is_clear = not plan.questions and not plan.doubts
    return command if is_clear or "COLUMN" in plan.command() else plan.command()


def _oscillates(columns: Sequence[str]) -> str:
    return f"an oscillation of a rheometer ({', '.join(columns[:3])}): no log of a device, no flow curve"


def _held(look: LogLook, reading: LogOptions) -> str:
    """What a creep, a relaxation or an oscillation is; "" for other logs, and where the user said how it is read."""
    from erclutch.logs.columns.rheometer_names import (
        held_in_time,
        of_oscillation,
        tells_a_flow_curve,
    )

    if reading.words():
        return ""
    columns = look.raw.columns
    swings = of_oscillation(columns)
    if swings and look.problem is None and not tells_a_flow_curve(columns):
        return f"an oscillation of a rheometer ({', '.join(swings[:3])})"
    return held_in_time(columns)


def _tell(look: LogLook, mapping: Path | None, asked: LogOptions) -> None:
    """Columns, signals, coverage and advice; where the mapping was written, or how to write it with what was asked."""
    log_tables.tell_columns(look.log, look.raw)
    if mapping is not None:
        missing = f"; {len(look.missing)} to fill in" if look.missing else ""
        from erclutch.logs.mapping import file_beside

        beside = file_beside(look.log)
        read = beside is not None and beside.resolve() == mapping.resolve()
        place = "" if read else f". It is read once it lies beside the log as {look.log}.toml"
        terminal.say(f"Mapping written: {mapping}{missing}{place}")
    elif look.missing:
        # With the sheet that was asked for: without it another log would be looked at.
        given = asked.words()
        pairs = pairwise(given)
        which = [word for pair in pairs if pair[0] in _WHICH_LOG for word in pair]
        command = ["erclutch", "inspect", str(look.log), *which]
        command += ["--write-mapping", f"{look.log}.toml"]
        terminal.say(f"A mapping file to fill in: {shlex.join(command)}")

    if look.rows is None or look.covered is None:
        for note in look.raw.notes:
            terminal.tell(f"  {note}")
        if look.further:
            terminal.tell(log_tables.several(look.further))
        return
    if len(look.every) > 1:
        terminal.tell(log_tables.several(look.every))
    log_tables.tell_signals(look.every[0], look.rows)
    log_tables.tell_coverage(look.covered)
    terminal.tell(*look.advice)


def _tell_what_is_next(look: LogLook, typed: str, reading: LogOptions) -> None:
    """What stands against the logs and the command that settles it; where nothing does, the command that fits them.

    Args:
        look: what was found.
        typed: the logs or the folder, as the user gave them.
        reading: how the user said that they are read.
    """
    from erclutch.logs.columns.rheometer_names import tells_a_flow_curve

    if held := _held(look, reading):
        terminal.say(
            f"Not for erclutch: {look.log.name}: {held}; neither fit nor flowcurve has a law for it"
        )
        return
    if look.kinds and log_tables.tell_kinds(look, reading):
        return
    alike = look.refused_alike
    for name, refusal in look.refused.items():
        if name not in alike:
            terminal.say(f"Not understood yet: {refusal.told_of(name)}")
    first = shlex.quote(look.plan.path)
    if look.problem is not None:
        _tell_what_settles(look, look.problem, typed, reading)
    elif look.joints and not look.refused and not look.unfit:
        _tell_fits_of_joints(look, typed, reading)
    elif look.plan.doubts and not look.joints:
        doubts = "; ".join(look.plan.doubts)
        command = look.plan.command().replace(first, typed)
        if is_of_a_rheometer(look.plan):
            terminal.say(f"Not understood yet: {look.log.name}: {doubts}")
            terminal.say(f"What settles it: {flow_command(look)}")
            return
        command = with_options(tried_answer(command, look, reading), reading)
        terminal.say(f"In doubt: {doubts}. If that is right, say so: {command}")
    elif look.unfit:
        terminal.say(f"Understood, but nothing can be fitted to it: {look.unfit}")
    elif look.refused:
        options = {refusal.option for refusal in look.refused.values()}
        # What a log had in a column, its pattern does not touch.
        if len(options) == 1 and (option := options.pop()):
            terminal.say(
                f"What settles it: {with_options(f'erclutch inspect {typed} {option}', reading)}"
            )
    else:
        words = map(shlex.quote, reading.words())
        command = " ".join(["erclutch fit", typed, *words])
        them = "them" if look.further else "it"
        if look.share is not None:
            command += f" --test {look.share:g}"
            them += ", and hold out less than usual, for the rows are few"
        terminal.say(f"Understood. Fit {them}: {command} --out RUN")
    is_understood = look.problem is None and not look.plan.doubts and not look.refused
    if is_understood and not reading.words() and tells_a_flow_curve(look.plan.labels):
        flow = flow_command(look)
        if flow.startswith("erclutch flowcurve"):
            terminal.say(f"Or as a flow curve: {flow}")


def _tell_fits_of_joints(look: LogLook, typed: str, reading: LogOptions) -> None:
    """The joints of a robot's logs, the command that fits each of them, and the command that fits the first."""
    log_tables.tell_joints(look.joints, look.raw)
    words = " ".join(["", *map(shlex.quote, reading.words())])
    alone = look.plan.command().replace(shlex.quote(look.plan.path), typed)
    alone = with_options(alone, reading).replace("erclutch inspect", "erclutch fit", 1)
    few = ""
    them = "each joint"
    if look.share is not None:
        few = f" --test {look.share:g}"
        them += ", and hold out less than usual, for the rows are few"
    terminal.say(f"Of one joint alone: {alone}{few} --out RUN")
    each = f"erclutch fit-many {typed} --by joint{words}{few} --out RUNS"
    terminal.say(f"Understood. Fit {them}: {each}")


def _tell_what_settles(
    look: LogLook, problem: ErclutchError, typed: str, reading: LogOptions
) -> None:
    """What is not understood, of all logs of which the same is asked, and the command that settles it.

    Args:
        look: what was found.
        problem: what stands against the first log.
        typed: the logs or the folder, as the user gave them.
        reading: how the user said that they are read.
    """
    from erclutch.logs.columns.rheometer_names import of_oscillation

    alike = look.refused_alike
    first = shlex.quote(look.plan.path)
    plan = look.plan
    # Of several logs in one file their names are asked about, and not what one of them alone leaves open.
    is_of_all = isinstance(problem, UnloggedFieldError) or (reading.each and bool(problem.option))
    settled = "" if is_of_all else points_command(look, is_told=bool(reading.words()))
    if settled:
        pass
    elif plan.questions and not is_of_all:
        settled = plan.command()
    elif answer := answer_to(problem, plan):
        settled = f"{plan.command().rstrip()} {answer}"
    elif problem.option:
        settled = f"{shlex.join(['erclutch', 'inspect', plan.path])} {problem.option}"
    else:  # only another file helps
        settled = ""
    settled = tried_answer(settled, look, reading) if settled else ""
    settled = look.for_all(settled, typed)
    why = str(problem)
    is_of_points = settled.startswith("erclutch flowcurve")
    if is_of_points and f"[{UNIT_TO_FILL_IN}]" in settled:
        why = f"{look.log.name}: {without_their_unit(look.raw)}"
    elif settled and len(look.plan.questions) > 1:
        # The remedy of several questions is that command, which is printed once.
        why = f"{problem.where}: {problem.problem}"
    swings = of_oscillation(look.raw.columns)
    is_open = bool(look.plan.questions) or not reading.words()  # nobody said how it is read
    if swings and not is_of_points and is_open:
        why = f"{look.log.name}: {_oscillates(swings)}"
        settled = ""
    terminal.say(f"Not understood yet: {why}")  # one line: it may hold a command to copy
    if alike:
        more = f"{len(alike)} more {plural(len(alike), 'log')}"
        terminal.say(f"The same is asked of {more}, the last {alike[-1]}")
    # The command confirms them too.
    if look.plan.doubts and settled.startswith(look.plan.command().replace(first, typed)):
        terminal.say(f"In doubt besides: {'; '.join(look.plan.doubts)}")
    others = len(look.refused) - len(alike)
    if settled and alike and others:
        terminal.say(
            f"Another thing is asked of {others} more {plural(others, 'log')}, on their own"
        )
    if settled:
        terminal.say(f"What settles it: {with_options(settled, reading)}")


def _as_json(look: LogLook, courses: int) -> dict[str, Any]:
    """All that was seen, with the columns' courses in as many stretches as are asked for."""
    from erclutch.cli.column_courses import courses_of, sketch
    from erclutch.logs.columns.two_shafts import with_differences
    from erclutch.logs.saved_plan import mapping_text

    # A page offers what two shafts differ by as a column.
    table, _ = with_differences(look.raw, look.plan.told)
    units = table.units
    columns: dict[str, object] = {}
    for name, values in table.columns.items():
        shown: dict[str, object] = {"unit": units.get(name)}
        for figure, value in log_tables.figures(values)._asdict().items():
            shown[figure] = None if isnan(value) else value
        shown["sketch"] = sketch(values)
        columns[name] = shown
    choices: dict[str, object] = {}
    for name, choice in look.plan.choices.items():
        file_unit = units.get(str(choice.column))
        choices[name] = {**asdict(choice), "file_unit": file_unit}
    findings = log_tables.findings(look.covered) if look.covered else []
    if look.unfit:
        findings.append(f"warning: nothing can be fitted: {look.unfit}")
    elif look.share is not None:
        findings.append(f"note: the rows are few: fit them with --test {look.share:g}")
    body: dict[str, Any] = {
        "columns": columns,
        "damage": look.raw.damage,
        "notes": list(look.raw.notes),
        "problem": str(look.problem) if look.problem else None,
        "findings": findings,
        "missing": list(look.missing),
        "doubts": list(look.plan.doubts),
        "joints": [asdict(joint) for joint in look.joints],
        "refused": {name: refusal.why for name, refusal in look.refused.items()},
        "mapping": tomllib.loads(mapping_text(look.plan)),
        "choices": choices,
    }
    if look.advice:
        body["advice"] = look.advice
    if not look.read:
        return body

    recording, *further = look.every
    if courses:
        body["over_time"] = courses_of(recording, courses)
    body["further"] = [
        {"name": each.name, "rows": each.rows, "sha256": each.digest} for each in further
    ]
    body["signals"] = dict(recording.units)
    body["rows"] = recording.rows
    body["period_s"] = recording.period
    body["uniform"] = recording.uniform
    body["segments"] = [list(segment) for segment in recording.segments]
    body["sha256"] = recording.digest
    body["reading"] = list(recording.notes)
    return body
