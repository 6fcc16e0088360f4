"""How logs are read is said once: columns, filters, a window in time and a rate, for logs in memory and on disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from erclutch.errors import AlikeRecordingsError, SettingError, placed
from erclutch.logs.batches import WHOLE_FILE, Batch, RowRange
from erclutch.logs.clock.resample import resampled
from erclutch.logs.keywords import Window, window_and_rate
from erclutch.logs.log_file import wants_each
from erclutch.logs.mapping import ColumnMap, map_over
from erclutch.logs.names_of_logs import called
from erclutch.logs.plan import Invalid
from erclutch.logs.read_logs import read, read_all, read_batches
from erclutch.logs.table import Table
from erclutch.logs.time_window import batches_within, within
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative


@dataclass(frozen=True)
class Reading:
    """How logs are read; see `erclutch.read`.

    Attributes:
        mapping: which column is which signal.
        mapping_file: a mapping file in place of those beside the logs.
        invalid: "error", "drop", or None for what the mapping says.
        variable: which recording of a file that holds several; "all" for each of them.
        derivative: filter for speeds that are not logged.
        rows: of a batch.
        window: first and last time that are taken, and how much is left out of the start, in s; None: all is taken.
        rate: in Hz, to which logs are brought; None: they keep their own.
    """

    mapping: ColumnMap | Mapping[str, Any] | None = None
    mapping_file: str | Path | None = None
    invalid: Invalid | None = None
    variable: str | None = None
    derivative: Derivative = field(default_factory=Derivative)
    rows: int = 65_536
    window: Window = (None, None, None)
    rate: float | None = None

    @classmethod
    def from_options(cls, options: Mapping[str, Any], source: str = "given") -> Reading:
        """From options of the command line by their names, as a run keeps them.

        Raises:
            MappingError: a signal that is none. SettingError: a time or a rate that is none.
        """
        with placed("" if source == "given" else source):
            mapping = ColumnMap.from_options(options, source)
        window, rate = window_and_rate(options)
        return cls(
            mapping,
            options.get("map"),
            variable=options.get("variable"),
            derivative=Derivative(
                options.get("derivative", "savgol"),
                options.get("cutoff", 150.0),
                options.get("window", 5),
            ),
            window=window,
            rate=rate,
        )

    def read(
        self,
        path: str | Path,
        device: DeviceName | None,
        table: Table | None = None,
        name: str = "",
    ) -> list[Recording]:
        """The recordings of one log; a table that was read before is that of the first of them.

        Args:
            path: the log.
            device: how signals become elements.
            table: what was read before.
            name: what the log is called in place of its file's name, which another log may have; "" for that name.

        Raises:
            LogError, MappingError: see `erclutch.read`.
            SettingError: a window or a rate that the log cannot have.
        """
        logs = self._recordings(path, device, table)
        return [called(log, Path(path), name) for log in logs] if name else logs

    def _recordings(
        self, path: str | Path, device: DeviceName | None, table: Table | None
    ) -> list[Recording]:
        how = self._how(device)
        if not wants_each(self.variable):
            try:
                return [
                    self.finished(
                        read(path, self.mapping, variable=self.variable, table=table, **how)
                    )
                ]
            except AlikeRecordingsError:
                pass  # each of them is a log
        return [self.finished(log) for log in read_all(path, map_over(self.mapping, None), **how)]

    def finished(self, log: Recording) -> Recording:
        """A recording in its window and at its rate.

        Raises:
            SettingError: a window or a rate that it cannot have.
        """
        log = within(log, *self.window)
        return log if self.rate is None else resampled(log.without_jumps(), self.rate)

    @property
    def divisible(self) -> bool:
        """Whether rows of a log can be read without those before; a window in time counts from the first row."""
        return self.window == (None, None, None)

    def batches(
        self,
        path: str | Path,
        device: DeviceName | None,
        part: RowRange = WHOLE_FILE,
    ) -> Iterator[Batch]:
        """The batches of one log, or of some of its rows.

        Raises:
            SettingError: a rate, for which the whole log must be in memory; a window that the log cannot have.
        """
        if self.rate is not None:
            remedy = "Give a larger --memory, or resample the log before"
            raise SettingError(
                "--resample needs the whole log in memory", where=str(path), remedy=remedy
            )
        how = self._how(device)
        batches = read_batches(
            path,
            self.mapping,
            variable=self.variable,
            rows=self.rows,
            part=part,
            **how,
        )
        return batches if self.divisible else batches_within(batches, *self.window)

    def _how(self, device: DeviceName | None) -> dict[str, Any]:
        return {"device": device, "invalid": self.invalid, "mapping_file": self.mapping_file}
