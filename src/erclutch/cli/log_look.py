"""`erclutch inspect` looks at logs: the table of the first, how each is read, and what stands against it."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.cli import terminal
from erclutch.cli.log_advice import advice_on
from erclutch.cli.log_kinds import LogKind, LogKinds
from erclutch.cli.options import LogOptions
from erclutch.errors import (
    AlikeRecordingsError,
    CheckError,
    ErclutchError,
    SettingError,
    UnloggedFieldError,
)

if TYPE_CHECKING:
    from erclutch.logs import Plan, Table
    from erclutch.logs.dataset import Dataset
    from erclutch.logs.plan import Joint
    from erclutch.signals.recording import Recording

_NUMBER = re.compile(r"-?\d+(?:[.,]\d+)?")


@dataclass(frozen=True)
class Refusal:
    """What stands against a log.

    Attributes:
        why: for people.
        option: that the remedy gives, see ``option`` of `ErclutchError`.
    """

    why: str
    option: str

    def told_of(self, name: str) -> str:
        """What stands against the log, with the log's name in front."""
        return self.why if self.why.startswith(name) else f"{name}: {self.why}"


@dataclass(frozen=True)
class LogLook:
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
        paths: the file of each log, by its name.
        rows: the first recording.
        covered: all recordings, as far as they fit together.
        unfit: why no model can be fitted to them; "" where nothing stands against it.
        share: what few rows may hold out at most, so that a fit has enough to train on; None for the usual share.
        advice: what logs teach nothing new, and what no log has.
        kinds: logs of the same columns, where there are several kinds of them.
        joints: how each joint of a robot's log is read; none where more is open than which joint is meant.
    """

    log: Path
    raw: Table
    plan: Plan
    missing: tuple[str, ...]
    read: list[Recording]
    problem: ErclutchError | None
    further: list[Recording]
    refused: dict[str, Refusal]
    paths: dict[str, Path]
    rows: Dataset | None
    covered: Dataset | None
    unfit: str
    share: float | None
    advice: list[str]
    kinds: list[LogKind]
    joints: dict[Joint, Plan]

    @property
    def every(self) -> list[Recording]:
        """All recordings; none where the first log is not understood."""
        return [*self.read, *self.further] if self.read else []

    @property
    def refused_alike(self) -> tuple[str, ...]:
        """The further logs for which the first log's problem stands too: it is told once.

        Numbers may differ, such as the field in the name of each file, where one remedy holds for all.
        """
        if self.problem is None:
            return ()

        def without_name(text: str, path: str, name: str) -> str:
            return text.replace(path, "").replace(name, "")

        remedy = without_name(self.problem.remedy, self.plan.path, self.log.name)

        def without(text: str, path: str, name: str) -> str:
            text = without_name(text, path, name)
            if not remedy or remedy not in text:
                return text
            problem, _, rest = text.partition(remedy)
            return _NUMBER.sub("0", problem) + remedy + rest

        of_first = without(str(self.problem), self.plan.path, self.log.name)
        alike: list[str] = []
        for name, refusal in self.refused.items():
            path = self.paths.get(name)
            if path is None:  # of several recordings in a file
                continue
            of_file = refusal.why.replace(name, path.name)
            if without(of_file, str(path), path.name) == of_first:
                alike.append(name)
        return tuple(alike)

    def for_all(self, command: str, typed: str) -> str:
        """A command that settles the first log, for all logs of which the same is asked.

        Args:
            command: of the first log; "" stays so.
            typed: the logs or the folder, as the user gave them.
        """
        from erclutch.logs.columns.name_pattern import pattern_among

        alike = self.refused_alike
        names = [Path(name).stem for name in (self.log.name, *alike)]
        if len(self.plan.questions) > 1 and pattern_among(names):
            # Once the logs are read, their efforts show whether the number in the names is a field.
            command = command.replace(" --field none", "")
        first = shlex.quote(self.plan.path)
        if len(alike) == len(self.refused):
            return command.replace(first, typed)
        same = [self.plan.path, *(str(self.paths[name]) for name in alike)]
        return command.replace(first, shlex.join(same))

    @property
    def doubtful(self) -> bool:
        """Whether anything is missing, in doubt or not understood."""
        in_doubt = bool(self.plan.doubts) and not self.joints
        return self.problem is not None or bool(self.refused) or in_doubt


def look_at(
    log: Path,
    others: Sequence[Path],
    raw: Table,
    reading: LogOptions,
) -> LogLook:
    """Read the first log, whose table is there already, and the others beside it.

    Raises:
        SettingError: an option cannot be as it is; what a log has against it is kept instead.
    """
    from erclutch.logs import apply
    from erclutch.logs.field_between_logs import require_no_plan, with_paths
    from erclutch.logs.joints_of_log import mapping_of_joint, plans_of_joints
    from erclutch.logs.names_of_logs import called, names_apart

    plan = reading.plan(raw, log)
    missing: tuple[str, ...] = ()
    if not reading.each:  # where each recording is read on its own, each has its own effort
        missing = tuple(question.short for question in plan.questions)

    read: list[Recording] = []
    problem: ErclutchError | None = None
    try:
        if reading.each:
            read = reading.read([log])
        else:
            read = [reading.how().finished(apply(plan, raw))]
    except SettingError:
        raise
    except ErclutchError as error:
        problem = error

    names = names_apart([log, *others])
    read = [called(recording, log, names[0]) for recording in read]
    further: list[Recording] = []
    refused: dict[str, Refusal] = {}
    joints = plans_of_joints(plan, raw)
    # Of further logs of a robot the first joint stands for the others.
    of_first = [mapping_of_joint(plan, joint, reading.column_map()) for joint in joints][:1]
    how = replace(reading.how(), mapping=of_first[0]) if of_first else reading.how()
    kinds = LogKinds()
    if others:
        kinds.add(log, raw, reading)
    for other, name in zip(others, names[1:], strict=True):
        try:
            table = _table_of(other, reading)
            if table is not None:
                kinds.add(other, table, reading)
            further += how.read(other, reading.device, table, name)
        except SettingError:
            raise
        except ErclutchError as error:
            why = str(error).replace(other.name, name, 1)
            refused[name] = Refusal(why, error.option)

    problem, refused = _asked_at_once(problem, refused, [log, *others], kinds)
    rows: Dataset | None = None
    try:
        rows = reading.dataset(read[:1]) if read else None
    except UnloggedFieldError as error:  # of stretches of this log
        problem = error
    covered = rows
    if rows is not None and len(read) + len(further) > 1:
        try:
            covered = reading.dataset([*read, *further])
            require_no_plan(covered.notes, [log, *others])
        except ErclutchError as error:  # such as logs in different units
            # No column holds the field: the user is asked.
            if isinstance(error, UnloggedFieldError):
                problem = with_paths(error, [log, *others])
            else:
                refused[error.where] = Refusal(str(error), error.option)
    unfit, share = ("", None) if covered is None else _few_or_steady(covered)
    advice: list[str] = []
    if covered is not None and len(covered.sources) > 1:
        advice = advice_on(covered)

    return LogLook(
        log=log,
        raw=raw,
        plan=plan,
        missing=missing,
        read=read,
        problem=problem,
        further=further,
        refused=refused,
        paths=dict(zip(names, [log, *others], strict=True)),
        rows=rows,
        covered=covered,
        unfit=unfit,
        share=share,
        advice=advice,
        kinds=kinds.found,
        joints=joints,
    )


def _asked_at_once(
    problem: ErclutchError | None,
    refused: dict[str, Refusal],
    logs: Sequence[Path],
    kinds: LogKinds,
) -> tuple[ErclutchError | None, dict[str, Refusal]]:
    """One question in place of several, where each would be answered by a pattern of logs' names, one by its own alone.

    Patterns that several logs have each may be of several devices, and each has its command; so have logs of kinds.
    """
    from erclutch.logs.field_between_logs import fields_in_unlike_names

    options = [refusal.option for refusal in refused.values()]
    if problem is not None:
        options.insert(0, problem.option)
    logs_of: Counter[str] = Counter()  # by the pattern that answers the question of each
    has_a_number_of_its_own = False
    for option in options:
        if option.startswith("--name-pattern "):
            logs_of[option] += 1
        elif option.startswith('--constant "field=NUMBER '):
            has_a_number_of_its_own = True
        else:
            return problem, refused
    is_of_one_log = has_a_number_of_its_own or min(logs_of.values(), default=0) == 1
    is_one_pattern = len(logs) < 2 or (len(logs_of) < 2 and not has_a_number_of_its_own)
    if kinds.found or is_one_pattern or not is_of_one_log:
        return problem, refused
    return fields_in_unlike_names(logs), {}


def _table_of(log: Path, reading: LogOptions) -> Table | None:
    """The table of a further log; None where it holds several recordings, each of which is a log.

    Raises:
        LogError: it cannot be read.
    """
    from erclutch.logs import table_of_log
    from erclutch.logs.mapping import file_mapping

    if reading.each:
        return None
    told = reading.column_map().over(file_mapping(log, reading.map))
    try:
        return table_of_log(log, told, reading.device, reading.variable or told.variable)
    except AlikeRecordingsError:
        return None


def table_of_first(log: Path, reading: LogOptions) -> Table:
    """The log as it is; of a file that holds several recordings and all are wanted, the first.

    Raises:
        LogError: it cannot be read, or an option must say how.
    """
    from erclutch.logs import recordings_in, table_of_log
    from erclutch.logs.planning.recording_choice import logs_among

    variable = reading.variable
    if reading.each:
        # A sheet of settings may stand before the first that is a log of a device.
        names = recordings_in(log, variable)
        of_devices = logs_among(log, names, reading.column_map(), reading.device)
        variable = next(iter([*of_devices, *names]), None)
    with terminal.progress("reading") as bar:

        def show(done: int, size: int) -> None:
            """How far the reader is, in bytes."""
            if done < size:
                bar(done, size, f"{done / 1e6:.0f} of {size / 1e6:.0f} MB read")
            else:
                bar(done, None, "columns, clock and checks")

        return table_of_log(log, reading.column_map(), reading.device, variable, show)


def _few_or_steady(rows: Dataset) -> tuple[str, float | None]:
    """Why no model can be fitted to rows, "" where nothing stands against it; what few rows may hold out at most."""
    from erclutch.fit.checks.data_check import fewest_rows, require_change, smaller_share

    unfit = ""
    share = smaller_share(rows)
    if share == 0.0:
        needed = fewest_rows(rows)
        unfit = (
            f"{rows.rows} rows are too few: a fit trains on {needed} and holds others out. Log more"
        )
    try:
        require_change(rows)
    except CheckError as error:
        unfit = str(error)
    return unfit, share


def write_fields(logs: Sequence[Path], mapping: Path) -> int:
    """Write a mapping file that names the logs and their fields; how many of these are left to fill in."""
    from erclutch.logs.field_between_logs import mapping_of_fields
    from erclutch.logs.saved_plan import save_mapping

    text, to_fill_in = mapping_of_fields(logs)
    save_mapping(text, mapping)
    return to_fill_in
