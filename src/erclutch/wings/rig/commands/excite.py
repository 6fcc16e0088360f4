"""``erclutch excite`` writes command sequences for collecting a good log, on hardware or on the twin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import HERTZ, SECONDS, TORQUE
from erclutch.errors import SettingError, require
from erclutch.files import may_write_file

if TYPE_CHECKING:
    from erclutch.signals.array import Array

COMMAND = {
    "help": "Write a command sequence that excites a pair of clutches well (section III-B).",
    "panel": "The digital TWIN and the paper",
    "place": 2,
}


def excite(
    *,
    out: Path = Path("commands.csv"),
    seconds: Annotated[float, SECONDS] = 290.0,
    seed: int = 0,
    rate: Annotated[float, HERTZ] = 1000.0,
    largest: float = 0.5,
    lowest: Annotated[float, HERTZ] = 2.0,
    highest: Annotated[float, HERTZ] = 100.0,
    torque: Annotated[tuple[float, float], TORQUE, Parameter(negative=())] = (0.04, 0.15),
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Write the commands of section III-B: pseudorandom square and sine fields, pseudorandom square motor torque.

    Only one clutch is under field at a time. The sequence does not look at the rig: the rig must keep the table within
    its stroke.

    Args:
        out: Sequence to write: .csv, .mat or .parquet.
        seconds: Length of the sequence.
        seed: Seed of the sequence; the same seed gives the same sequence.
        rate: Rows a second.
        largest: Largest field command (0.5 is 2000 V on the paper's rig).
        lowest: Lowest frequency in Hz.
        highest: Highest frequency in Hz.
        torque: Smallest and largest motor torque in N m.
        force: Replace a file that is there.
    """
    import numpy as np

    from erclutch.logs.log_writer import write_log
    from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence, torque_sequence

    low, high = torque
    require(0.1, 86400, " s", seconds=seconds)
    require(0.001, min(1e6, 1e8 / seconds), " Hz", rate=rate)
    require(0, seed=seed)
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
    about = {"label": "COMMANDS", "seed": seed, "rate": rate, "seconds": seconds, "largest": largest}
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
