"""Options that several commands share: which columns of a log are which signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter

from erclutch.errors import LogError, MappingError

if TYPE_CHECKING:
    from erclutch.dataset import Dataset
    from erclutch.differentiate import Derivative
    from erclutch.logs import ColumnMap
    from erclutch.signals import Recording

_COLUMNS = Group("Columns: 'NAME', 'NAME \\[unit]' or a number; '-NAME' turns the sign", sort_key=2)
_READING = Group("Reading", sort_key=3)
_SPEEDS = Group("Speeds from positions", sort_key=4)

_Device = Literal["single", "coaxial"]
_DerivativeName = Literal["central", "savgol", "difference", "lowpass", "kalman"]


@Parameter(name="*")
@dataclass(frozen=True)
class LogOptions:
    """How to read a log."""

    device: Annotated[_Device, Parameter(group=_READING)] = "single"
    """single: field, slip, effort. coaxial: the paper's pair, E1, E2, theta, alpha, T."""
    field: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Command to the fluid of a single device."""
    slip: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Relative speed across the fluid of a single device."""
    position: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Relative position, where the slip is not logged."""
    effort: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Torque or force of a single device."""
    e1: Annotated[str | None, Parameter(name="--E1", group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Field of clutch CH1 (coaxial)."""
    e2: Annotated[str | None, Parameter(name="--E2", group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Field of clutch CH2 (coaxial)."""
    e: Annotated[str | None, Parameter(name="--E", group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Signed field E1 - E2 (coaxial), in place of E1 and E2."""
    theta: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Angle of the motor (coaxial)."""
    theta_dot: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Speed of the motor (coaxial)."""
    alpha: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Angle of the output (coaxial)."""
    alpha_dot: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Speed of the output (coaxial)."""
    alpha_raw: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Position of the table on the screw (coaxial); needs --lead."""
    t: Annotated[str | None, Parameter(name="--T", group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Torque of the pair (coaxial)."""
    motor_torque: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Torque that the motor is commanded (coaxial); for figures and for calibrating the twin."""
    input: Annotated[tuple[str, ...], Parameter(group=_COLUMNS, negative=(), show_default=False)] = ()
    """A further column that networks take as input, for example an acceleration; more than once for several."""
    time: Annotated[str | None, Parameter(group=_COLUMNS, allow_leading_hyphen=True)] = None
    """Time stamps."""
    rate: Annotated[str | None, Parameter(group=_READING)] = None
    """Sampling rate in place of a time column, for example '1000 Hz'."""
    lead: Annotated[str | None, Parameter(group=_READING)] = None
    """Lead of the screw, for example '10 mm'."""
    constant: Annotated[tuple[str, ...], Parameter(group=_READING, negative=(), show_default=False)] = ()
    """A constant signal, for example 'field=0.5 A', or one number a segment between gaps: 'field=0,0.5,1 A'."""
    name_pattern: Annotated[str | None, Parameter(group=_READING)] = None
    """Numbers in the file's name, for example '{amplitude}mm{frequency}Hz{field}A'; x counts as a decimal point."""
    map: Annotated[Path | None, Parameter(group=_READING)] = None
    """A mapping file (TOML) in place of the one beside the log."""
    variable: Annotated[str | None, Parameter(group=_READING)] = None
    """Which recording of a MATLAB file, or which topic of an MCAP file."""
    invalid: Annotated[Literal["error", "drop"] | None, Parameter(group=_READING)] = None
    """Missing or infinite values: an error (the default), or cut the log there."""
    derivative: Annotated[_DerivativeName, Parameter(group=_SPEEDS)] = "savgol"
    """Filter for speeds that are not logged; difference, lowpass and kalman can run live."""
    cutoff: Annotated[float, Parameter(group=_SPEEDS)] = 150.0
    """Bandwidth of lowpass and kalman in Hz."""
    window: Annotated[int, Parameter(group=_SPEEDS)] = 5
    """Rows of the Savitzky-Golay window."""

    def column_map(self) -> ColumnMap:
        """What the command line says about columns."""
        from erclutch.logs import ColumnMap
        from erclutch.signals import SIGNALS

        names = {"e1": "E1", "e2": "E2", "e": "E", "t": "T"}
        signals = ("field", "slip", "position", "effort", "e1", "e2", "e", "theta", "theta_dot")
        signals += ("alpha", "alpha_dot", "alpha_raw", "t", "motor_torque")
        columns = {names.get(s, s): getattr(self, s) for s in signals if getattr(self, s) is not None}
        values = {key: getattr(self, key) for key in ("time", "rate", "lead", "name_pattern", "variable", "invalid")}
        constants = {name.strip(): value for name, _, value in (pair.partition("=") for pair in self.constant)}
        unknown = [name for name in constants if name not in SIGNALS]
        if unknown:
            raise MappingError(
                f"--constant {unknown[0]!r} is no signal",
                remedy=f"Write it like --constant 'field=0.5 A'; signals are {', '.join(SIGNALS)}",
            )
        given = {key: value for key, value in values.items() if value is not None}
        return ColumnMap.from_dict({**given, "columns": columns, "constants": constants, "inputs": list(self.input)})

    def read(self, paths: Sequence[Path]) -> list[Recording]:
        """Read logs; folders stand for the logs in them.

        Raises:
            LogError: a log cannot be read; MappingError: or not be understood.
        """
        from erclutch.logs import read

        mapping = self.column_map()
        return [read(path, mapping, device=self.device, mapping_file=self.map) for path in expand(paths)]

    def filter(self) -> Derivative:
        """The filter for speeds."""
        from erclutch.differentiate import Derivative

        return Derivative(self.derivative, self.cutoff, self.window)

    def dataset(self, recordings: Sequence[Recording]) -> Dataset:
        """Recordings as one data set."""
        from erclutch.dataset import build_dataset

        return build_dataset(recordings, device=self.device, derivative=self.filter())

    def to_dict(self) -> dict[str, object]:
        """What was given, as JSON values."""
        given = {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) != f.default}
        return {key: str(value) if isinstance(value, Path) else value for key, value in given.items()}


DEFAULT_READING = LogOptions()

_SUFFIXES = {".csv", ".txt", ".tsv", ".dat", ".asc", ".log", ".mat", ".parquet", ".pq", ".mcap"}


def expand(paths: Sequence[Path]) -> list[Path]:
    """Files, with folders replaced by the logs in them, by name.

    Raises:
        LogError: a folder without a log.
    """
    files: list[Path] = []
    for path in paths:
        if not path.is_dir():
            files.append(path)
            continue
        inside = sorted(p for p in path.iterdir() if p.suffix.lower() in _SUFFIXES and p.is_file())
        if not inside:
            raise LogError(
                "the folder holds no log", where=str(path), remedy=f"Logs end in {', '.join(sorted(_SUFFIXES))}"
            )
        files.extend(inside)
    return files
