"""Several commands share these options: which columns of a log are which signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from erclutch.cli.folded_help import folded
from erclutch.cli.quantities import HERTZ
from erclutch.errors import LogError

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

_Device = Literal["single", "coaxial"]
_DerivativeName = Literal["central", "savgol", "difference", "lowpass", "kalman"]


@Parameter(name="*")
@dataclass(frozen=True)
class LogOptions:
    """How to read a log."""

    device: Annotated[_Device | None, Parameter(group=_COLUMNS)] = None
    """single has a field, a slip and an effort; coaxial is the paper's pair with E1, E2, theta, alpha and T.
    Default: what a recording of live says, else single."""
    field: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Command to the fluid of a single device."""
    slip: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Relative speed across the fluid of a single device."""
    position: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Relative position; it is differentiated where the slip is not logged. none: no column is taken."""
    effort: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Torque or force of a single device."""
    e1: Annotated[str | None, Parameter(name="--E1", group=_PAIR, allow_leading_hyphen=True)] = None
    """Field of clutch CH1 (coaxial)."""
    e2: Annotated[str | None, Parameter(name="--E2", group=_PAIR, allow_leading_hyphen=True)] = None
    """Field of clutch CH2 (coaxial)."""
    e: Annotated[str | None, Parameter(name="--E", group=_PAIR, allow_leading_hyphen=True)] = None
    """Signed field E1 - E2 (coaxial), in place of E1 and E2."""
    theta: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Angle of the motor (coaxial)."""
    theta_dot: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Speed of the motor (coaxial)."""
    alpha: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Angle of the output (coaxial)."""
    alpha_dot: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Speed of the output (coaxial)."""
    alpha_raw: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Position of the table on the screw (coaxial); needs --lead."""
    t: Annotated[str | None, Parameter(name="--T", group=_PAIR, allow_leading_hyphen=True)] = None
    """Torque of the pair (coaxial)."""
    motor_torque: Annotated[str | None, Parameter(group=_PAIR, allow_leading_hyphen=True)] = None
    """Torque that the motor is commanded (coaxial); for figures and for calibrating the twin."""
    temperature: Annotated[str | None, Parameter(group=_COLUMNS)] = None
    """Temperature of the fluid in °C or K: laws may soften with it, and networks take it as input."""
    input: Annotated[
        tuple[str, ...], Parameter(group=_READING, consume_multiple=True, negative=(), show_default=False)
    ] = ()
    """Further columns that networks take as inputs, for example accelerations: --input A B."""
    time: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Column of time stamps."""
    rate: Annotated[str | None, Parameter(group=_COLUMNS)] = None
    """Sampling rate in place of a time column, for example '1000 Hz'."""
    lead: Annotated[str | None, Parameter(group=_READING)] = None
    """Travel of the table in one turn of the screw, for example '10 mm'."""
    constant: Annotated[tuple[str, ...], Parameter(group=_READING, negative=(), show_default=False)] = ()
    """A signal that was constant: 'field=0.5 A'. Where the log has gaps, also a number for each part: 'field=0,1 A'."""
    scale: Annotated[tuple[str, ...], Parameter(group=_READING, negative=(), show_default=False)] = ()
    """What a sensor in volts means: 'effort=2.5 N*m/V', or 'effort=0.02 N*m' for one of counts; more than once."""
    begin: Annotated[str | None, Parameter(name="--from", group=_READING, allow_leading_hyphen=True)] = None
    """Take each log from this time on, for example 2s or 500ms, on the clock that inspect shows."""
    end: Annotated[str | None, Parameter(name="--until", group=_READING, allow_leading_hyphen=True)] = None
    """Take each log up to this time."""
    skip: Annotated[str | None, Parameter(group=_READING)] = None
    """Leave out so much at the start of each log, for example 2s."""
    name_pattern: Annotated[str | None, Parameter(group=_READING)] = None
    """Numbers in the file's name, for example '{amplitude}mm{frequency}Hz{field}A'; x counts as a decimal point."""
    map: Annotated[Path | None, Parameter(group=_READING)] = None
    """A mapping file (TOML) in place of the one beside the log."""
    variable: Annotated[str | None, Parameter(group=_READING)] = None
    """Which recording of a file that holds several: a variable, group, sheet, topic, segment. All of them, and each
    effort of theirs as a log of its own: all; then also --effort 'F_* [N]'."""
    decimal: Annotated[Literal[".", ","] | None, Parameter(group=_READING)] = None
    """Decimal mark of a text log whose numbers may be read in two ways: 1.500 is 1.5 or 1500."""
    keep_values: Annotated[bool, Parameter(group=_READING, negative=())] = False
    """Keep values such as -999, which loggers write for no measurement; the rows are left out otherwise."""
    invalid: Annotated[Literal["error", "drop"] | None, Parameter(group=_READING)] = None
    """At missing or infinite values: error stops (the default), drop cuts the log there."""
    resample: Annotated[str | None, Parameter(group=_READING)] = None
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
        return self.variable == "all"

    def column_map(self) -> ColumnMap:
        """What the command line says about columns."""
        from erclutch.logs import ColumnMap

        return ColumnMap.from_options(self._given())

    def plan(self, table: Table, log: Path) -> Plan:
        """How the table of a log is read."""
        from erclutch.logs import ColumnMap, plan_of
        from erclutch.logs.mapping import beside

        base = beside(log) if self.map is None else ColumnMap.from_toml(self.map)
        return plan_of(table, self.column_map().over(base), device=self.device)

    def read(self, paths: Sequence[Path]) -> list[Recording]:
        """Read logs; folders stand for the logs in them.

        Raises:
            LogError: a log cannot be read; MappingError: or not be understood.
        """
        how = self.how()
        return [log for path in expand(paths) for log in how.read(path, self.device)]

    def how(self) -> Reading:
        """What the command line says of the reading of a log.

        Raises:
            MappingError: a signal that is none. SettingError: a time or a rate that is none.
        """
        from erclutch.logs.reading import Reading

        return Reading.from_options(self._given())

    def dataset(self, recordings: Sequence[Recording]) -> Dataset:
        """Recordings as one data set."""
        from erclutch.logs.dataset import build_dataset

        return build_dataset(recordings, device=self.device, derivative=self.how().derivative)

    def _given(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) != f.default}

    def like(self, run: Run | None, model: Model) -> LogOptions:
        """What was given over how the run's own logs were read; the device is the model's, unless given."""
        from erclutch.logs.name_pattern import still_needed

        own: dict[str, Any] = {} if run is None else dict(run.body.get("reading") or {})
        said = self.column_map()
        given = {*said.columns, *said.constants}
        gone = {"begin", "end", "skip", *(name.lower() for name in given)}  # a window is of the log it was given for
        gone |= {"time", "rate"} if self.time is not None or self.rate is not None else set()
        known = {f.name for f in fields(self)}
        own = {key: value for key, value in own.items() if key in known and key not in gone}
        own["name_pattern"] = still_needed(own.get("name_pattern"), given)
        own |= {key: tuple(own[key]) for key in ("input", "scale") if key in own}
        own |= {key: Path(own[key]) for key in ("map",) if key in own}
        kept = (each for each in own.get("constant", ()) if each.partition("=")[0].strip() not in given)
        constants = {"constant": (*kept, *self.constant)}
        return replace(self, **{**own, "device": model.structure.device, **self._given(), **constants})

    def without_effort(self, unit: str) -> LogOptions:
        """The same for logs of which the effort is not asked for: a constant stands for it."""
        signal = "T" if self.device == "coaxial" else "effort"
        zero = f"{signal}=0 {unit.replace('?', '')}".strip()
        kept = tuple(each for each in self.constant if each.partition("=")[0].strip() != signal)
        return replace(self, effort=None, t=None, constant=(*kept, zero))

    def to_dict(self) -> dict[str, object]:
        """What was given, as JSON values."""
        given = self._given()
        return {key: str(value) if isinstance(value, Path) else value for key, value in given.items()}


DEFAULT_READING = LogOptions()


def expand(paths: Sequence[Path]) -> list[Path]:
    """Logs, with folders replaced by the logs in them, by name; a folder that is one log (a ROS 2 bag) stays.

    Files that hold a log only together, a signal each, become one log.

    Raises:
        LogError: a folder without a log.
    """
    from erclutch.cli import terminal
    from erclutch.logs.log_reader import folder_reader, log_suffixes, require_no_run
    from erclutch.logs.readers.signal_files import together
    from erclutch.logs.readers.text_tables import is_prose

    if joined := together(paths):
        return [joined]
    files: list[Path] = []
    for path in paths:
        require_no_run(path)
        if not path.is_dir() or folder_reader(path):
            files.append(path)
            continue
        suffixes = log_suffixes()
        named = [p for p in path.iterdir() if p.suffix.lower() in suffixes and p.is_file()]
        words = sorted(p.name for p in named if is_prose(p))
        if words and len(words) < len(named):
            note = f"note: {', '.join(words)} left out: words and no rows of numbers"
            terminal.console(stderr=True).print(note, soft_wrap=True)  # what is asked for as JSON stays JSON
            named = [p for p in named if p.name not in words]
        inside = sorted([*named, *(p for p in path.iterdir() if p.is_dir() and folder_reader(p))])
        if not inside:
            remedy = f"Logs end in {', '.join(log_suffixes())}"
            raise LogError("the folder holds no log", where=str(path), remedy=remedy)
        files.extend(inside)
    return files
