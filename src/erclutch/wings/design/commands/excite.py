"""``erclutch excite`` writes what to log next: field and motion within the limits of a rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import HERTZ, SECONDS, TORQUE
from erclutch.errors import SettingError, require
from erclutch.files import LOG_ENDINGS, may_write_file, refuse_ending
from erclutch.signals.percent import percent
from erclutch.wings.design.limit_options import NO_LIMITS, LimitOptions

if TYPE_CHECKING:
    import numpy as np

    from erclutch.wings.design.courses import Commands
    from erclutch.wings.design.information import Criterion, Region
    from erclutch.wings.design.limits import DeviceKind, RigLimits
    from erclutch.wings.design.run_design import LawOfRun

COMMAND = {
    "help": "Write what to log next: field and motion within your rig's limits, for a good log in little time.",
    "panel": "The road of a log",
    "place": 2,
}

_RUN = Group("With --run: what the run does not know yet", sort_key=3)
_PAPER = Group("With --sequence paper", sort_key=4)


def excite(
    *,
    out: Path = Path("commands.csv"),
    device: Literal["brake", "clutch", "damper", "pair"] = "brake",
    seconds: Annotated[float | None, SECONDS] = None,
    rate: Annotated[float | None, HERTZ] = None,
    seed: int = 0,
    sequence: Literal["fill", "paper"] = "fill",
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
    limits: LimitOptions = NO_LIMITS,
    run: Annotated[Path | None, Parameter(group=_RUN)] = None,
    model: Annotated[str | None, Parameter(group=_RUN)] = None,
    where: Annotated[str | None, Parameter(group=_RUN)] = None,
    criterion: Annotated[Literal["D", "A", "I", "fill"] | None, Parameter(group=_RUN)] = None,
    lowest: Annotated[float, HERTZ, Parameter(group=_PAPER)] = 2.0,
    highest: Annotated[float, HERTZ, Parameter(group=_PAPER)] = 100.0,
    torque: Annotated[tuple[float, float], TORQUE, Parameter(group=_PAPER, negative=())] = (
        0.04,
        0.15,
    ),
) -> None:
    """Write references of field and motion within limits: what to log next.

    Without a run they fill the space of field, slip and their rates. With a run they are those that take most off what
    its law does not know. Acceleration and stroke hold in every row that is written. Of a pair the motion is that of
    the motor, which turns one way; its output moves as the clutches drive it.

    Args:
        out: Sequence to write: .csv, .parquet, .mat, or .h for a table of C.
        device: Kind of device on the rig.
        seconds: Length of the sequence. Default: 60 s; 10 s with --run; 290 s with --sequence paper.
        rate: Rows a second. Default: 1000 Hz; with --run the rate of its log.
        seed: Seed of the sequence; the same seed gives the same sequence.
        sequence: fill covers field and motion within the limits; paper takes pseudorandom squares and sines of field
            and motor torque, as section III-B does for a pair.
        force: Replace a file that is there.
        json: Print what the sequence covers and teaches as JSON.
        limits: What the rig may do.
        run: The folder of a run. Limits that are not given come from its rows.
        model: A law of the run. Default: the recommended model, or the best law where that is none.
        where: Where the device is used, in the units of the run: 'field 0..2 A, slip +-5 rad/s'.
        criterion: What the sequence makes small. D: the doubt about all numbers of the law at once; A: their mean
            relative variance; I: the variance of the effort where the device is used, by a law that may be wrong;
            fill: the cells without a row. Default: I.
        lowest: Lowest frequency in Hz.
        highest: Highest frequency in Hz.
        torque: Smallest and largest motor torque in N m.
    """
    if seconds is None:
        of_its_own = 60.0 if run is None else 10.0
        seconds = 290.0 if sequence == "paper" else of_its_own
    require(0.1, 86400, " s", seconds=seconds)
    require(0, seed=seed)
    refuse_ending(out, LOG_ENDINGS if sequence == "paper" else (*LOG_ENDINGS, ".h"))
    if sequence == "paper":
        rate = 1000.0 if rate is None else rate
        require(0.001, min(1e6, 1e7 / seconds), " Hz", rate=rate)
        if limits != replace(NO_LIMITS, largest=limits.largest) or run is not None:
            raise SettingError(
                "--sequence paper looks at no run and no limits but --largest",
                remedy="Leave them out, or take fill",
            )
        largest = 0.5 if limits.largest is None else limits.largest
        _papers_commands(out, _Draw(rate, seconds, seed), largest, (lowest, highest), torque, force)
        return
    if run is None and (model, where, criterion) != (None, None, None):
        raise SettingError(
            "--model, --where and --criterion are about a run", remedy="Give --run too"
        )
    from erclutch.wings.design.command_file import motion_unit
    from erclutch.wings.design.information import region_of
    from erclutch.wings.design.run_design import law_of_run

    region = None if where is None else region_of(where)
    law = None if run is None else law_of_run(run, model)
    if law is not None:  # the run knows better
        unit = law.rows.units.slip
        moves_otherwise = unit in ("m/s", "rad/s") and unit != f"{motion_unit(device)}/s"
        if law.pair:
            device = "pair"
        elif device == "pair" or moves_otherwise:
            device = "damper" if unit == "m/s" else "brake"
    if rate is None:
        rate = 1000.0 if law is None else law.rate
    require(0.001, min(1e6, 1e7 / seconds), " Hz", rate=rate)
    draw = _Draw(rate, seconds, seed)
    _designed(out, force, device, draw, limits, law, region, criterion or "I", json)


@dataclass(frozen=True)
class _Draw:
    """A sequence as it is asked for.

    Attributes:
        rate: rows a second.
        seconds: length.
        seed: of what is drawn.
    """

    rate: float
    seconds: float
    seed: int

    @property
    def rng(self) -> np.random.Generator:
        """Random numbers from the start."""
        import numpy as np

        return np.random.default_rng(self.seed)


def _designed(
    out: Path,
    force: bool,
    device: DeviceKind,
    draw: _Draw,
    options: LimitOptions,
    law: LawOfRun | None,
    region: Region | None,
    criterion: Criterion,
    json: bool,
) -> None:
    """Choose the sequence, write it, and say what it covers and what it is expected to teach."""
    from erclutch.wings.design.command_file import columns_of, motion_unit, write_commands
    from erclutch.wings.design.courses import Bounds
    from erclutch.wings.design.fill import chosen_sequence
    from erclutch.wings.design.lessons import lessons_of
    from erclutch.wings.design.run_design import designed_for

    rate = draw.rate
    seconds = draw.seconds
    seed = draw.seed
    signed = device == "pair"
    one_way = options.one_way or signed
    known = options.limits({} if law is None else law.limits, pair=signed)
    # Refuses what leaves no sequence, before a file's name is taken.
    Bounds.of(known, rate, seconds)
    may_write_file(out, force)
    expected = None
    if law is None:
        commands = chosen_sequence(known, rate, seconds, draw.rng, signed=signed, one_way=one_way)
    else:
        commands, expected = designed_for(
            law,
            known,
            rate,
            seconds,
            seed,
            criterion=criterion,
            where=region,
            one_way=one_way,
        )

    field_unit = options.field_unit
    if not field_unit:
        field_unit = "" if law is None else law.rows.units.field.replace("?", "")
    columns, rows = columns_of(commands, device, rate, field_unit)
    about = {
        "label": "COMMANDS",
        "device": device,
        "seed": seed,
        "rate": rate,
        "seconds": seconds,
        "limits": known.line(motion_unit(device), field_unit),
    }
    path = write_commands(out, columns, rows, about)
    coverage = _coverage(commands, known, draw, law)
    if json:
        covers = {"file": str(path), **coverage}
        teaches: dict[str, Any] = {}
        if law is not None and expected is not None:
            teaches = expected.to_dict(law.estimates) | {
                "logs": lessons_of(law.model, law.rows).to_dict()
            }
        terminal.say_json({**about, **covers, **teaches})
        return
    _tell(commands, known, device, draw, field_unit, coverage)
    if law is not None and criterion != "fill":
        terminal.tell(
            f"Criterion {criterion} asks what the law does not know; --criterion fill asks for empty cells"
        )
    if law is not None and expected is not None:
        # Intervals and band before and after, as the law expects them.
        lines: list[list[str]] = []
        half_widths = expected.half_widths(law.estimates)
        for estimate, (before, after) in zip(law.estimates, half_widths, strict=True):
            row = [estimate.name, terminal.number(estimate.value)]
            for size in (before, after):
                row.append("not identified" if size == float("inf") else terminal.number(size, 3))
            lines.append([*row, estimate.unit])
        title = f"What {law.name} expects: half width of the 95 % interval"
        terminal.tell(terminal.table(title, ["", "value", "now", "with the log", ""], lines))
        effort_unit = law.rows.units.effort.replace("?", "")
        terminal.tell(
            f"What the numbers leave open of the effort: +-{expected.band_before:.3g} now, +-{expected.band_after:.3g} "
            f"{effort_unit} with the log; the residual's standard deviation is {expected.noise:.3g} {effort_unit}"
        )
        lessons = lessons_of(law.model, law.rows)
        if lessons.repeat:
            count = len(lessons.teach) + len(lessons.repeat)
            terminal.tell(
                f"Of {count} logs {len(lessons.repeat)} repeat what the others show. Without them no interval grows "
                f"by more than {percent(lessons.growth - 1.0)}: {', '.join(lessons.repeat)}"
            )
    terminal.say(path)


def _coverage(
    commands: Commands, known: RigLimits, draw: _Draw, law: LawOfRun | None
) -> dict[str, float]:
    """Share of the cells that the commands visit, and the paper's draws; with a run's rows, where there is a run."""
    from erclutch.wings.design.fill import coverage_share, papers_sequence
    from erclutch.wings.design.run_design import cells_of_run

    rate = draw.rate
    seconds = draw.seconds
    signed = bool(commands.field.min() < 0.0)
    one_way = bool(commands.speed.min() >= 0.0)
    papers = papers_sequence(known, rate, seconds, draw.rng, signed=signed, one_way=one_way)
    shares: dict[str, float] = {}
    for name, sequence in (("coverage", commands), ("coverage_of_paper", papers)):
        shares[name] = coverage_share(
            sequence, known, rate, seconds, signed=signed, one_way=one_way
        )
        if law is not None:
            cells = cells_of_run(law, known, rate, seconds, one_way=one_way)
            shares["coverage_of_run"] = cells.share()
            cells.known(sequence.field, sequence.speed)
            shares[f"{name}_with_run"] = cells.share()
    return shares


def _tell(
    commands: Commands,
    known: RigLimits,
    device: DeviceKind,
    draw: _Draw,
    field_unit: str,
    coverage: Mapping[str, float],
) -> None:
    """What was written within which limits, and what it covers beside the paper's draws."""
    from erclutch.wings.design.command_file import motion_unit
    from erclutch.wings.design.courses import Bounds

    unit = motion_unit(device)
    rows = f"{commands.speed.size:,} rows, {draw.seconds:g} s"
    share = {name: percent(value) for name, value in coverage.items()}
    papers = "the paper's draws of section III-B within the same limits"
    visited = f"{share['coverage']} are visited; by {papers} {share['coverage_of_paper']}"
    if "coverage_of_run" in share:
        after = f"with this sequence {share['coverage_with_run']}, with {papers} {share['coverage_of_paper_with_run']}"
        visited = f"the log of the run visits {share['coverage_of_run']}; {after}"
    terminal.tell(
        f"COMMANDS for a {device}, seed {draw.seed}: {rows}; nothing was measured",
        f"Limits: {known.line(unit, field_unit)}",
        *(f"Note: {note}" for note in Bounds.of(known, draw.rate, draw.seconds).notes),
        terminal.coverage(
            commands.field, commands.speed, " of the commands", (field_unit, f"{unit}/s")
        ),
        f"Of the cells over field, slip and their directions {visited}",
    )


def _papers_commands(
    out: Path,
    draw: _Draw,
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

    rate = draw.rate
    seconds = draw.seconds
    seed = draw.seed
    lowest, highest = frequencies
    low, high = torque
    if not 0 <= low < high:
        raise SettingError(
            f"--torque {low:g} {high:g}", remedy="Give two torques of 0 or more, the smaller first"
        )
    if highest > rate / 4:
        raise SettingError(
            f"{highest:g} Hz at {rate:g} rows a second",
            remedy="Give --highest at most a quarter of --rate",
        )
    settings = FieldSettings(
        largest=largest,
        lowest=lowest,
        highest=highest,
    )
    may_write_file(out, force)
    rng = draw.rng
    rows = round(seconds * rate)
    field = field_sequence(rows, rng, settings, rate)
    motor = torque_sequence(rows, rng, low, high, rate)

    time = np.arange(rows) / rate
    first = np.maximum(field, 0.0)
    second = np.maximum(-field, 0.0)
    columns = (("time", "s"), ("E1", ""), ("E2", ""), ("motor_torque", "N*m"))
    about: dict[str, Any] = {
        "label": "COMMANDS",
        "seed": seed,
        "rate": rate,
        "seconds": seconds,
        "largest": largest,
        "lowest": lowest,
        "highest": highest,
        "torque": list(torque),
    }
    table = np.column_stack([time, first, second, motor])
    path = write_log(out, columns, [table], about, rows=rows)
    terminal.tell(f"COMMANDS, seed {seed}: {rows:,} rows, {seconds:g} s; nothing was measured")
    for name, values in (("E1 - E2", field), ("motor torque", motor)):
        terminal.tell(
            f"{name}: {values.min():.3g} .. {values.max():.3g}; power by band of frequency:"
        )
        shares = [
            f"{low:g}-{high:g} Hz {percent(share)}"
            for low, high, share in terminal.bands(values, rate)
        ]
        terminal.tell("  " + ", ".join(shares))
    terminal.tell(terminal.coverage(field, motor, " of the commands (torque across)"))
    terminal.say(path)
