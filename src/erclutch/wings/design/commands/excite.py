"""``erclutch excite`` writes what to log next: field and motion within the limits of a rig."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import HERTZ, SECONDS, TORQUE, quantity
from erclutch.errors import SettingError, require
from erclutch.files import may_write_file

if TYPE_CHECKING:
    from erclutch.signals.array import Array
    from erclutch.wings.design.courses import Commands
    from erclutch.wings.design.limits import DeviceKind, RigLimits

COMMAND = {
    "help": "Write what to log next: field and motion within your rig's limits, for a good log in little time.",
    "panel": "The road of a log",
    "place": 2,
}

_LIMITS = Group("Limits of the rig, in SI units (a damper's motion in m, others' in rad)", sort_key=2)
_PAPER = Group("Of --sequence paper", sort_key=3)

_Number = Annotated[float | None, Parameter(group=_LIMITS)]


def excite(
    *,
    out: Path = Path("commands.csv"),
    device: Literal["brake", "clutch", "damper", "pair"] = "brake",
    seconds: Annotated[float | None, SECONDS] = None,
    rate: Annotated[float, HERTZ] = 1000.0,
    seed: int = 0,
    sequence: Literal["fill", "paper"] = "fill",
    force: Annotated[bool, Parameter(negative=())] = False,
    rig_limits: Annotated[Path | None, Parameter(group=_LIMITS)] = None,
    largest: _Number = None,
    field_rate: _Number = None,
    speed: _Number = None,
    acceleration: _Number = None,
    stroke: _Number = None,
    rest: Annotated[float | None, SECONDS, Parameter(group=_LIMITS)] = None,
    heat: Annotated[float | None, quantity("W"), Parameter(group=_LIMITS)] = None,
    largest_effort: _Number = None,
    one_way: Annotated[bool, Parameter(group=_LIMITS, negative=())] = False,
    field_unit: Annotated[str, Parameter(group=_LIMITS)] = "",
    lowest: Annotated[float, HERTZ, Parameter(group=_PAPER)] = 2.0,
    highest: Annotated[float, HERTZ, Parameter(group=_PAPER)] = 100.0,
    torque: Annotated[tuple[float, float], TORQUE, Parameter(group=_PAPER, negative=())] = (0.04, 0.15),
) -> None:
    """Write references of field and motion that fill the space of field, slip and their rates within limits.

    Switches show the lag, slow turns the memory, zero field the friction, rests the zero of the sensor. Acceleration
    and stroke hold in every row that is written. Of a pair the motion is that of the motor, which turns one way; its
    output moves as the clutches drive it.

    Args:
        out: Sequence to write: .csv, .parquet, .mat, or .h for a table of C.
        device: What hangs on the rig.
        seconds: Length of the sequence. Default: 60, of the paper's 290.
        rate: Rows a second.
        seed: Seed of the sequence; the same seed gives the same sequence.
        sequence: fill, or paper: pseudorandom squares and sines of field and motor torque for a pair (section III-B).
        force: Replace a file that is there.
        rig_limits: TOML file with a table named limits, or a log of the rig: what it did there it may do again.
        largest: Largest field. Of the paper: 0.5, which is 2000 V.
        field_rate: How fast the field may change, in a second. Default: it may step.
        speed: Largest slip to either side; of a pair the motor's speed.
        acceleration: Largest change of the speed, in a second.
        stroke: Way from end to end; the motion begins in the middle. Default: no end.
        rest: Seconds without field and motion at the start and at the end. Default: 0.5.
        heat: Largest mean power in W; needs --largest-effort.
        largest_effort: Torque or force that the device never exceeds.
        one_way: The motion never turns back.
        field_unit: Unit of the field, for the column's name: A, V, T, kV/mm.
        lowest: Lowest frequency in Hz.
        highest: Highest frequency in Hz.
        torque: Smallest and largest motor torque in N m.
    """
    import numpy as np

    from erclutch.wings.design.command_file import columns_of, motion_unit, write_commands
    from erclutch.wings.design.courses import Bounds
    from erclutch.wings.design.fill import chosen_sequence
    from erclutch.wings.design.limits import limits_of

    if seconds is None:
        seconds = 290.0 if sequence == "paper" else 60.0
    require(0.1, 86400, " s", seconds=seconds)
    require(0.001, min(1e6, 1e7 / seconds), " Hz", rate=rate)
    require(0, seed=seed)
    options = {"field": largest, "field_rate": field_rate, "speed": speed, "acceleration": acceleration}
    options |= {"stroke": stroke, "rest": rest, "heat": heat, "effort": largest_effort}
    if sequence == "paper":
        unused = [name for name, limit in options.items() if limit is not None and name != "field"]
        if unused or rig_limits is not None:
            raise SettingError(
                "--sequence paper looks at no limits but --largest", remedy="Leave the others out, or take fill"
            )
        _papers_commands(
            out, seconds, seed, rate, 0.5 if largest is None else largest, (lowest, highest), torque, force
        )
        return
    signed = device == "pair"
    turning = one_way or signed
    known = limits_of(options, {} if rig_limits is None else _known(rig_limits, signed))
    if turning and known.stroke < float("inf"):
        raise SettingError(
            f"--stroke {known.stroke:g} of a motion that never turns back",
            remedy="Leave out --stroke" + ("" if signed else " or --one-way"),
        )
    Bounds.of(known, rate, seconds)  # refuses what leaves no sequence, before a file's name is taken
    may_write_file(out, force)
    commands = chosen_sequence(known, rate, seconds, np.random.default_rng(seed), signed=signed, one_way=turning)
    unit = motion_unit(device)
    columns, rows = columns_of(commands, device, rate, field_unit)
    about = {"label": "COMMANDS", "device": device, "seed": seed, "rate": rate, "seconds": seconds}
    path = write_commands(out, columns, rows, about | {"limits": known.line(unit, field_unit)})
    _tell(commands, known, device, (rate, seconds, seed), field_unit)
    terminal.say(path)


def _known(path: Path, signed: bool) -> dict[str, float]:
    """Limits of a TOML file or of a log."""
    from erclutch.cli.options import LogOptions
    from erclutch.wings.design.limits import limits_of_file, limits_of_log

    if path.suffix.lower() == ".toml":
        return limits_of_file(path)
    reading = LogOptions(device="coaxial" if signed else None)
    known = limits_of_log(reading.dataset(reading.read((path,))))
    if signed:
        known.pop("stroke", None)
    return known


def _tell(
    commands: Commands, known: RigLimits, device: DeviceKind, made: tuple[float, float, int], field_unit: str
) -> None:
    """What was written within which limits, and what it covers beside the paper's draws."""
    import numpy as np

    from erclutch.wings.design.command_file import motion_unit
    from erclutch.wings.design.courses import Bounds
    from erclutch.wings.design.fill import coverage_share, papers_sequence

    rate, seconds, seed = made
    unit = motion_unit(device)
    signed, one_way = device == "pair", bool(commands.speed.min() >= 0.0)
    terminal.tell(
        f"COMMANDS for a {device}, seed {seed}: {commands.speed.size:,} rows, {seconds:g} s; nothing was measured",
        f"Limits: {known.line(unit, field_unit)}",
        *(f"Note: {note}" for note in Bounds.of(known, rate, seconds).notes),
        terminal.coverage(commands.field, commands.speed, " of the commands", (field_unit, f"{unit}/s")),
    )
    papers = papers_sequence(known, rate, seconds, np.random.default_rng(seed), signed=signed, one_way=one_way)
    ours, theirs = (
        coverage_share(each, known, rate, seconds, signed=signed, one_way=one_way) for each in (commands, papers)
    )
    terminal.tell(
        f"Of the cells over field, slip and their directions {ours:.0%} are visited; by the paper's draws of section "
        f"III-B within the same limits {theirs:.0%}"
    )


def _papers_commands(
    out: Path,
    seconds: float,
    seed: int,
    rate: float,
    largest: float,
    frequencies: tuple[float, float],
    torque: tuple[float, float],
    force: bool,
) -> None:
    """The commands of section III-B for a pair: one clutch under field at a time, and a random motor torque.

    The sequence does not look at the rig: the rig must keep the table within its stroke.
    """
    import numpy as np

    from erclutch.logs.log_writer import write_log
    from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence, torque_sequence

    lowest, highest = frequencies
    low, high = torque
    if not 0 <= low < high:
        raise SettingError(f"--torque {low:g} {high:g}", remedy="Give two torques of 0 or more, the smaller first")
    if highest > rate / 4:
        raise SettingError(
            f"{highest:g} Hz at {rate:g} rows a second", remedy="Give --highest at most a quarter of --rate"
        )
    commands = FieldSettings(largest=largest, lowest=lowest, highest=highest)
    may_write_file(out, force)
    rng = np.random.default_rng(seed)
    rows = round(seconds * rate)
    field = field_sequence(rows, rng, commands, rate)
    motor = torque_sequence(rows, rng, low, high, rate)
    first, second = np.maximum(field, 0.0), np.maximum(-field, 0.0)
    columns = (("time", "s"), ("E1", ""), ("E2", ""), ("motor_torque", "N*m"))
    about: dict[str, Any] = {"label": "COMMANDS", "seed": seed, "rate": rate, "seconds": seconds, "largest": largest}
    about |= {"lowest": lowest, "highest": highest, "torque": list(torque)}
    rows_of = np.column_stack([np.arange(rows) / rate, first, second, motor])
    path = write_log(out, columns, [rows_of], about, rows=rows)
    _show(path, field, motor, rate, f"COMMANDS, seed {seed}: {rows:,} rows, {seconds:g} s; nothing was measured")


def _show(path: Path, field: Array, motor: Array, rate: float, line: str) -> None:
    """What was written, on the screen."""
    terminal.tell(line)
    for name, values in (("E1 - E2", field), ("motor torque", motor)):
        terminal.tell(f"{name}: {values.min():.3g} .. {values.max():.3g}; power by band of frequency:")
        terminal.tell("  " + ", ".join(f"{a:g}-{b:g} Hz {s:.0%}" for a, b, s in terminal.bands(values, rate)))
    terminal.tell(terminal.coverage(field, motor, " of the commands (torque across)"))
    terminal.say(path)
