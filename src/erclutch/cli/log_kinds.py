"""A folder may hold logs of two kinds, calibrations beside trials: they are told apart by their columns."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.errors import listed, plural

if TYPE_CHECKING:
    from erclutch.cli.options import LogOptions
    from erclutch.logs import Plan, Table

_MOST = 4  # kinds that are told


@dataclass
class LogKind:
    """Logs of the same columns.

    Attributes:
        plan: how the first of them is read.
        paths: of all of them.
    """

    plan: Plan
    paths: list[Path] = field(default_factory=list[Path])

    @property
    def is_sure(self) -> bool:
        """Whether nothing is asked about the first of them."""
        return not self.plan.questions and not self.plan.doubts

    @property
    def files(self) -> str:
        """The logs as words of a command: by a star where that names these logs alone."""
        first = self.paths[0]
        names = {path.name for path in self.paths}
        shared = takewhile(lambda letters: len({*letters}) == 1, zip(*names, strict=False))
        start = "".join(letters[0] for letters in shared)
        is_one_folder = len({path.parent for path in self.paths}) == 1
        if len(names) > 1 and start and is_one_folder:
            ending = first.suffix
            alike = {path.name for path in first.parent.glob("*") if path.name.startswith(start)}
            if {name for name in alike if name.endswith(ending)} == names:
                return f"{shlex.quote(str(first.parent / start))}*{ending}"
        return shlex.join(map(str, self.paths))

    def command(self, reading: LogOptions) -> str:
        """What fits the logs, or looks at them where a field may tell them apart; what settles what is asked."""
        from erclutch.signals.recording import NO_FIELD

        field = self.plan.signal("field")
        if self.is_sure:
            options = map(shlex.quote, reading.words())
            if field is not None and field.reason == NO_FIELD:
                return " ".join(["erclutch inspect", self.files, *options])
            return " ".join(["erclutch fit", self.files, *options, "--out RUN"])
        return self.plan.command().replace(shlex.quote(self.plan.path), self.files, 1).rstrip()

    def __str__(self) -> str:
        count = len(self.paths)
        logs = f"{count} {plural(count, 'log')}"
        return (
            f"{logs} such as {self.paths[0].name}, with {listed(list(self.plan.labels.values()))}"
        )


class LogKinds:
    """The kinds of some logs, as they are read one after another."""

    def __init__(self) -> None:
        self._by_labels: dict[frozenset[str], LogKind] = {}

    def add(self, path: Path, table: Table, reading: LogOptions) -> None:
        """Add a log to those of its columns; numbers in the names, as of a field, are passed over."""
        from erclutch.logs.columns.names import without_numbers

        labels = frozenset(without_numbers(table.label(name)) for name in table.columns)
        if labels not in self._by_labels:
            self._by_labels[labels] = LogKind(reading.plan(table, path))
        self._by_labels[labels].paths.append(path)

    @property
    def found(self) -> list[LogKind]:
        """The kinds of several logs, of which one column more makes no other; none where there are not two of them."""
        kinds: list[LogKind] = []
        for kind in self._by_labels.values():
            read_as = _read_as(kind.plan)
            alike = next((each for each in kinds if _read_as(each.plan) == read_as), None)
            if alike is None:
                kinds.append(LogKind(kind.plan, [*kind.paths]))
            else:
                alike.paths += kind.paths
        kinds = [kind for kind in kinds if len(kind.paths) > 1]  # a single log is told on its own
        return kinds if 1 < len(kinds) <= _MOST else []


def _read_as(plan: Plan) -> list[object]:
    """What is the same of logs that are read alike: names and units of the signals' columns, and what is asked."""
    from erclutch.logs.columns.names import without_numbers

    columns = [(each.signal, without_numbers(each.column), each.unit) for each in plan.signals]
    clock = plan.clock.kind if plan.clock is not None else ""
    return [columns, clock, [question.signal for question in plan.questions]]
