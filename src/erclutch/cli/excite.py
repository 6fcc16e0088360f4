"""``erclutch excite``: command sequences for collecting a good log, on hardware or on the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from erclutch.errors import SettingError


def excite(
    *,
    out: Path = Path("commands.csv"),
    seconds: float = 290.0,
    seed: int = 0,
    rate: float = 1000.0,
    largest: float = 0.5,
    lowest: float = 2.0,
    highest: float = 100.0,
    torque: Annotated[tuple[float, float], Parameter(negative=())] = (0.04, 0.15),
) -> None:
    """Write the commands of section III-B: pseudorandom square and sine fields, pseudorandom square motor torque.

    Only one clutch is ever under field. The sequence does not look at the rig: keeping the table within its stroke is
    the rig's to do.

    Args:
        out: Sequence to write: .csv, .mat or .parquet.
        seconds: Its length.
        seed: Its seed; the same seed gives the same sequence.
        rate: Rows a second.
        largest: Largest field command (0.5 is 2000 V on the paper's rig).
        lowest: Lowest frequency in Hz.
        highest: Highest frequency in Hz.
        torque: Smallest and largest motor torque in N m.
    """
    import numpy as np

    from erclutch.cli import show
    from erclutch.rig.excitation import FieldSettings, field_sequence, torque_sequence
    from erclutch.rig.log_file import write_log

    low, high = torque
    if not (0.1 <= seconds <= 86400 and 0 < rate <= 1e6 and seed >= 0 and 0 <= low < high and seconds * rate <= 1e8):
        raise SettingError(
            f"{seconds:g} s at {rate:g} Hz, seed {seed}, torque {low:g} to {high:g} N*m",
            remedy="Give 0.1 to 86400 s, a rate above 0, a seed of 0 or more, and torques from low to high",
        )
    if highest > rate / 4:
        raise SettingError(
            f"{highest:g} Hz at {rate:g} rows a second", remedy="Give --highest at most a quarter of --rate"
        )
    rng = np.random.default_rng(seed)
    rows = round(seconds * rate)
    field = field_sequence(rows, rng, FieldSettings(largest=largest, lowest=lowest, highest=highest), rate)
    motor = torque_sequence(rows, rng, low, high, rate)
    first, second = np.maximum(field, 0.0), np.maximum(-field, 0.0)
    columns = (("time", "s"), ("E1", ""), ("E2", ""), ("motor_torque", "N*m"))
    about = {"label": "COMMANDS", "seed": seed, "rate": rate, "seconds": seconds, "largest": largest}
    about |= {"lowest": lowest, "highest": highest, "torque": list(torque)}
    rows_of = np.column_stack([np.arange(rows) / rate, first, second, motor])
    path = write_log(out, columns, [rows_of], about, rows=rows)
    screen = show.console()
    screen.print(f"COMMANDS, seed {seed}: {rows:,} rows, {seconds:g} s; nothing was measured", markup=False)
    for name, values in (("E1 - E2", field), ("motor torque", motor)):
        screen.print(f"{name}: {values.min():.3g} .. {values.max():.3g}; power by band of frequency:", markup=False)
        screen.print("  " + ", ".join(f"{a:g}-{b:g} Hz {s:.0%}" for a, b, s in show.bands(values, rate)), markup=False)
    screen.print(show.coverage(field, motor, " of the commands (torque across)"), markup=False)
    screen.print(f"{path}", markup=False, soft_wrap=True)
