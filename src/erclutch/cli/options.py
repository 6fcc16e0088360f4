"""Several commands share these options: which columns of a log are which signals."""

from __future__ import annotations

import itertools
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from cyclopts import Group, Parameter

from erclutch.cli.folded_help import folded
from erclutch.cli.quantities import HERTZ
from erclutch.errors import TYPED, LogError, listed

if TYPE_CHECKING:
    from erclutch.logs import ColumnMap, Plan, Table
    from erclutch.logs.dataset import Dataset
    from erclutch.logs.reading import Reading
    from erclutch.models.model import Model
    from erclutch.runs.run_folder import Run
    from erclutch.signals.recording import Recording

_COLUMNS = Group("Columns: 'NAME', 'NAME \\[unit]' or a number; '-NAME' turns the sign", sort_key=2)
_PAIR = folded("Columns of a pair (coaxial)", 2.1)
_READING = folded("Reading", 3)
_SPEEDS = folded("Speeds from positions", 4)

# Types of options, and where they stand in the help. A column may begin with a minus, which turns its sign.
_Column = Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)]
_PairColumn = Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)]
_Reading = Annotated[str | None, Parameter(group=_READING)]
_Readings = Annotated[tuple[str, ...], Parameter(group=_READING, negative=(), show_default=False)]
_Device = Literal["single", "coaxial"]
_DerivativeName = Literal["central", "savgol", "difference", "lowpass", "kalman"]


_MOST_FOLDERS = 12  # that are told in one command
_MOST_LOOKED_AT = 10_000  # folders, to find those that hold logs
# Options whose name on the command line is not that of their attribute.
_TYPED = {name: f"--{typed}" for name, typed in TYPED.items()}


@Parameter(name="*")
@dataclass(frozen=True)
class LogOptions:
    """How to read a log."""

    device: Annotated[_Device | None, Parameter(group=_COLUMNS)] = None
    """single has a field, a slip and an effort; coaxial is the paper's pair with E1, E2, theta, alpha and T.
    Default: what a recording of live says, else single."""
    field: _Column = None
    """Command to the fluid of a single device."""
    slip: _Column = None
    """Relative speed across the fluid of a single device."""
    position: _Column = None
    """Relative position; it is differentiated where the slip is not logged. none: no column is taken."""
    effort: _Column = None
    """Torque or force of a single device."""
    e1: Annotated[_PairColumn, Parameter(name=_TYPED["e1"])] = None
    """Field of clutch CH1 (coaxial)."""
    e2: Annotated[_PairColumn, Parameter(name=_TYPED["e2"])] = None
    """Field of clutch CH2 (coaxial)."""
    e: Annotated[_PairColumn, Parameter(name=_TYPED["e"])] = None
    """Signed field E1 - E2 (coaxial), in place of E1 and E2."""
    theta: _PairColumn = None
    """Angle of the motor (coaxial)."""
    theta_dot: _PairColumn = None
    """Speed of the motor (coaxial)."""
    alpha: _PairColumn = None
    """Angle of the output (coaxial)."""
    alpha_dot: _PairColumn = None
    """Speed of the output (coaxial)."""
    alpha_raw: _PairColumn = None
    """Position of the table on the screw (coaxial); needs --lead."""
    t: Annotated[_PairColumn, Parameter(name=_TYPED["t"])] = None
    """Torque of the pair (coaxial)."""
    motor_torque: _PairColumn = None
    """Torque that the motor is commanded (coaxial); for figures and for calibrating the twin."""
    temperature: Annotated[str | None, Parameter(group=_COLUMNS)] = None
    """Temperature of the fluid in °C, °F or K: laws may soften with it, and networks take it as input."""
    input: Annotated[_Readings, Parameter(consume_multiple=True)] = ()
    """Further columns that networks take as inputs, for example accelerations: --input A B."""
    time: _Column = None
    """Column of time stamps."""
    rate: Annotated[str | None, Parameter(group=_COLUMNS)] = None
    """Sampling rate in place of a time column, for example '1000 Hz'."""
    lead: _Reading = None
    """Travel of the table in one turn of the screw, for example '10 mm'."""
    constant: _Readings = ()
    """A signal that was constant: 'field=0.5 A'. Where the log has gaps, also a number for each part: 'field=0,1 A'."""
    scale: _Readings = ()
    """What a sensor in volts means: 'effort=2.5 N*m/V', or 'effort=0.02 N*m' for one of counts; more than once."""
    zero: _Readings = ()
    """What a column reads where its signal is zero: 'effort=2048' for the middle of a converter; more than once."""
    begin: Annotated[_Reading, Parameter(name=_TYPED["begin"], allow_leading_hyphen=True)] = None
    """Take each log from this time on, for example 2s or 500ms, on the clock that inspect shows."""
    end: Annotated[_Reading, Parameter(name=_TYPED["end"], allow_leading_hyphen=True)] = None
    """Take each log up to this time."""
    skip: _Reading = None
    """Leave out so much at the start of each log, for example 2s."""
    name_pattern: _Reading = None
    """Numbers in the name of the file, for example '{amplitude}mm{frequency}Hz{field}A', or of its folder too:
    'I{field}/run{n}'; x counts as a decimal point."""
    map: Annotated[Path | None, Parameter(group=_READING)] = None
    """A mapping file (TOML) in place of the one beside the log."""
    variable: _Reading = None
    """Which recording of a file that holds several: a variable, group, sheet, topic, segment. All of them, and each
    effort of theirs as a log of its own: all; then also --effort 'F_* [N]'. Rows that a column parts: 'COLUMN=WORD', or
    'COLUMN=all'."""
    decimal: Annotated[Literal[".", ","] | None, Parameter(group=_READING)] = None
    """Decimal mark of a text log whose numbers may be read in two ways: 1.500 is 1.5 or 1500."""
    keep_values: Annotated[bool, Parameter(group=_READING, negative=())] = False
    """Keep values such as -999, which loggers write for no measurement; the rows are left out otherwise."""
    invalid: Annotated[Literal["error", "drop"] | None, Parameter(group=_READING)] = None
    """At missing or infinite values: error stops, drop cuts the log there. Default: a few that are missing cut it."""
    resample: _Reading = None
    """Bring the log to another sampling rate, for example 1kHz, behind a filter against aliases."""
    derivative: Annotated[_DerivativeName, Parameter(group=_SPEEDS)] = "savgol"
    """Filter for speeds that are not logged; difference, lowpass and kalman can run live."""
    cutoff: Annotated[float, HERTZ, Parameter(group=_SPEEDS)] = 150.0
    """Bandwidth of lowpass and kalman in Hz."""
    window: Annotated[int, Parameter(group=_SPEEDS)] = 5
    """Rows of the Savitzky-Golay window."""

    @property
    def each(self) -> bool:
        """Whether all recordings of a file are wanted, and all their efforts."""
        from erclutch.logs.log_file import wants_each

        return wants_each(self.variable)

    def column_map(self) -> ColumnMap:
        """What the command line says about columns."""
        from erclutch.logs import ColumnMap

        return ColumnMap.from_options(self._given())

    def plan(self, table: Table, log: Path) -> Plan:
        """How the table of a log is read."""
        from erclutch.logs import plan_of
        from erclutch.logs.columns.name_pattern import fits_name
        from erclutch.logs.mapping import file_mapping

        columns = self.column_map().over(file_mapping(log, self.map))
        pattern = columns.name_pattern
        if self.each and pattern and not fits_name(pattern, str(log.resolve())):
            # It is of the names of recordings or efforts, which `read` gives their numbers.
            columns = replace(columns, name_pattern=None)
        return plan_of(table, columns, device=self.device)

    def read(self, paths: Sequence[Path]) -> list[Recording]:
        """Read logs; folders stand for the logs in them.

        Raises:
            LogError: a log cannot be read; MappingError: or not be understood.
        """
        from erclutch.logs.names_of_logs import names_apart

        how = self.how()
        files = expand(paths)
        logs: list[Recording] = []
        for path, name in zip(files, names_apart(files), strict=True):
            logs += how.read(path, self.device, name=name)
        return logs

    def how(self) -> Reading:
        """What the command line says of the reading of a log.

        Raises:
            MappingError: a signal that is none. SettingError: a time or a rate that is none, or a setting of another
                filter of speeds.
        """
        from erclutch.errors import SettingError
        from erclutch.logs.reading import Reading

        given = self._given()
        for option, filters in _OF_FILTERS.items():
            if option in given and self.derivative not in filters:
                of = " and ".join(filters)
                raise SettingError(
                    f"--{option} is of {of}, and the filter of speeds is {self.derivative}",
                    remedy=f"Add --derivative {filters[-1]}, or leave --{option} out",
                )
        return Reading.from_options(given)

    def dataset(self, recordings: Sequence[Recording]) -> Dataset:
        """Recordings as one data set."""
        from erclutch.logs.dataset import build_dataset

        return build_dataset(recordings, device=self.device, derivative=self.how().derivative)

    def _given(self) -> dict[str, Any]:
        """The options that are not as they are by default."""
        given: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            if value != each.default:
                given[each.name] = value
        return given

    def words(self) -> list[str]:
        """The options that are not as they are by default, as they are typed."""
        words: list[str] = []
        for name, value in self._given().items():
            option = _TYPED.get(name) or f"--{name.replace('_', '-')}"
            if isinstance(value, bool):
                words.append(option)
            elif isinstance(value, tuple):
                for each in cast("tuple[str, ...]", value):
                    words += [option, str(each)]
            else:
                words += [option, str(value)]
        return words

    def like(self, run: Run | None, model: Model) -> LogOptions:
        """What was given over how the run's own logs were read; the device is the model's, unless given."""
        from erclutch.logs.mapping import still_needed

        of_run: Mapping[str, Any] = {} if run is None else run.reading
        columns = self.column_map()
        given = {*columns.columns, *columns.constants}

        # What the run says goes where the command line says another thing, and a window is of the log it was given for.
        gone = {"begin", "end", "skip", *(name.lower() for name in given)}
        if self.time is not None or self.rate is not None:
            gone |= {"time", "rate"}
        if "derivative" in self._given():
            gone |= _OF_FILTERS.keys()
        wanted = {each.name for each in fields(self)} - gone
        own = {key: value for key, value in of_run.items() if key in wanted}

        # The run was kept as JSON, which has lists and no paths.
        if "input" in own:
            own["input"] = tuple(own["input"])
        if "map" in own:
            own["map"] = Path(own["map"])
        own["name_pattern"] = still_needed(own.get("name_pattern"), given)
        settings = {**own, "device": model.structure.device, **self._given()}

        # These may stand several times, each for a signal: what is said of one signal leaves those of others.
        told_anew = {
            "constant": given,
            "scale": {_signal_of(each) for each in self.scale},
            "zero": {_signal_of(each) for each in self.zero},
        }
        for option, signals in told_anew.items():
            kept = [each for each in own.get(option, ()) if _signal_of(each) not in signals]
            settings[option] = (*kept, *getattr(self, option))
        return replace(self, **settings)

    def without_effort(self, unit: str) -> LogOptions:
        """The same for logs of which the effort is not asked for: a constant stands for it."""
        signal = "T" if self.device == "coaxial" else "effort"
        zero = f"{signal}=0 {unit.replace('?', '')}".strip()
        others = [each for each in self.constant if _signal_of(each) != signal]
        return replace(self, effort=None, t=None, constant=(*others, zero))

    def to_dict(self) -> dict[str, object]:
        """What was given, as JSON values."""
        values: dict[str, object] = {}
        for key, value in self._given().items():
            values[key] = str(value) if isinstance(value, Path) else value
        return values


def _signal_of(told: str) -> str:
    """The signal of a constant, a scale or a zero such as 'field=0.5 A'."""
    signal, _, _ = told.partition("=")
    return signal.strip()


DEFAULT_READING = LogOptions()
#: Settings of some filters of speeds alone, with these filters.
_OF_FILTERS = {"cutoff": ("lowpass", "kalman"), "window": ("savgol",)}


def expand(paths: Sequence[Path]) -> list[Path]:
    """Logs, with folders replaced by the logs in them, by name; a folder that is one log (a ROS 2 bag) stays.

    A folder without logs stands for those of its folders whose names tell a field: each holds the logs at one.
    Files that hold a log only together, a signal each, become one log.

    Raises:
        LogError: a folder without a log.
    """
    from erclutch.cli import terminal
    from erclutch.logs.columns.name_pattern import pattern_among
    from erclutch.logs.log_reader import (
        LEARN_REPORT,
        folder_reader,
        log_suffixes,
        may_be_log,
        require_no_run,
    )
    from erclutch.logs.planning.tables_beside_logs import are_notes_above, tables_beside_logs
    from erclutch.logs.readers.signal_files import together
    from erclutch.logs.readers.text_tables import is_prose

    joined = together(paths)
    if joined:
        return [joined]
    files: list[Path] = []
    for path in paths:
        require_no_run(path)
        if not path.is_dir() or folder_reader(path):
            files.append(path)
            continue
        suffixes = log_suffixes()
        tables = [file for file in path.iterdir() if may_be_log(file, suffixes)]
        tables = [file for file in tables if file.name != LEARN_REPORT]
        words = sorted(file.name for file in tables if is_prose(file))
        if words and len(words) < len(tables):
            note = f"note: {', '.join(words)} left out: words and no rows of numbers"
            # What is asked for as JSON stays JSON.
            terminal.console(stderr=True).print(note, soft_wrap=True)
            tables = [file for file in tables if file.name not in words]
        no_logs = sorted(tables_beside_logs(tables)) if len(tables) > 1 else []
        if no_logs:
            names = ", ".join(file.name for file in no_logs)
            note = f"note: {names} left out: no motion, no effort, no column of the logs beside"
            terminal.console(stderr=True).print(note, soft_wrap=True)
            tables = [file for file in tables if file not in no_logs]
        folders = [folder for folder in path.iterdir() if folder.is_dir() and folder_reader(folder)]
        if not folders and (len(words) == len(tables) or are_notes_above(tables)):
            # The folders below that hold logs, by their ways from here; hidden ones are none of the user's.
            below: list[str] = []
            for folder, inner, inside in itertools.islice(os.walk(path), _MOST_LOOKED_AT):
                inner[:] = sorted(name for name in inner if not name.startswith("."))
                holds_logs = any(may_be_log(Path(folder, name), suffixes) for name in inside)
                if holds_logs and Path(folder) != path:
                    below.append(Path(folder).relative_to(path).as_posix())
            if pattern_among(below, called_so=True):  # 0A, 0.5A, 1A: one device at several fields
                files.extend(expand([path / folder for folder in below]))
                continue
            named = f"Logs end in {', '.join(suffixes)}"
            if below:
                named = f"Give one of its folders: {listed(below)}"
            if 1 < len(below) <= _MOST_FOLDERS:
                together = " ".join(shlex.quote(str(path / name)) for name in below)
                named += f"; or, where all are of one device, several: {together}"
            raise LogError("the folder holds no log", where=str(path), remedy=named)
        files.extend(sorted([*tables, *folders]))
    return files
