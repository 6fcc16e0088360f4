"""``erclutch live --program learn`` plays rounds until a law's numbers are as sure as asked, or no more is learned."""

from __future__ import annotations

import json as json_text
import math
import shlex
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli.quantities import SECONDS
from erclutch.errors import ErclutchError, RunError, SettingError
from erclutch.files import whole_file
from erclutch.files.given_files import plain_words, small_json
from erclutch.signals.percent import percent
from erclutch.wings.live.command_line.live_options import LEARN

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.signals.channels import LiveChannel
    from erclutch.wings.live.command_line.live_options import (
        ControlOptions,
        LoopOptions,
        RigOptions,
    )
    from erclutch.wings.live.companions import Observers
    from erclutch.wings.live.learning.foretold_motion import LoggedRound
    from erclutch.wings.live.learning.rounds import LearningRounds, RoundReport
    from erclutch.wings.live.session import RigChoice, Session
    from erclutch.wings.live.settings import LoopSettings

_SECONDS = 60.0  # in all, where --seconds does not say it
_SHORTEST = 2.0  # s of a round
_POLL = 0.02  # s
_INTERRUPTED = "it was interrupted"
_STILL = "the fields are held at zero; the log so far is kept"


@Parameter(name="*")
@dataclass(frozen=True)
class LearnOptions:
    """How ``--program learn`` goes on."""

    until: Annotated[str | None, Parameter(group=LEARN)] = None
    """End when the law's numbers leave this share of the largest effort open, such as 3%, by 95 % intervals."""
    round: Annotated[float, SECONDS, Parameter(group=LEARN)] = 10.0
    """Length of a round in s."""
    after: Annotated[Path | None, Parameter(group=LEARN)] = None
    """Folder of rounds that were interrupted: go on with the next one."""


NO_LEARN = LearnOptions()


def share_of(text: str | None) -> float:
    """``3%`` or ``0.03`` as a share; 0 where nothing is asked for.

    Raises:
        SettingError: no share between 0 and 1.
    """
    if text is None:
        return 0.0
    try:
        share = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        share = math.nan
    if not 0.0 < share < 1.0:
        raise SettingError(
            f"--until {text}", remedy="Give a share of the largest effort, such as 3%"
        )
    return share


def asks_for_rounds(
    control: ControlOptions,
    learning: LearnOptions,
    rig: RigOptions,
    adapt: bool,
) -> bool:
    """Whether ``--program learn`` is asked for.

    Raises:
        SettingError: with an option or a rig that makes no rounds, or options of rounds without it.
    """
    from erclutch.wings.live.offered_rig import offered_rig

    if control.program != "learn":
        if learning != NO_LEARN:
            problem = "--until, --round and --after are about rounds"
            raise SettingError(problem, remedy="Give --program learn too")
        return False
    offered = offered_rig(rig.rig)
    plays_rounds = offered is None or offered.learns
    if adapt or not plays_rounds:
        given = "--adapt" if adapt else f"--rig {rig.rig}"
        remedy = f"Leave out {given}: the rounds make the model"
        raise SettingError(f"--program learn with {given}", remedy=remedy)
    return True


@dataclass(frozen=True)
class Rig:
    """What the rounds are played on.

    Attributes:
        what: the rig.
        settings: of the loop, without the program of a round.
        channels: what the numbers of a frame are called.
        loop: options of the loop.
        seed: of the tables.
    """

    what: RigChoice
    settings: LoopSettings
    channels: tuple[LiveChannel, ...]
    loop: LoopOptions
    seed: int

    @property
    def effort_unit(self) -> str:
        """Unit of the measured effort; empty where nothing measures it."""
        units = [channel.unit for channel in self.channels if channel.role == "effort"]
        return units[0] if units else ""


def learn(
    rig: Rig,
    options: LearnOptions,
    told: list[int],
    observed: Callable[
        [Session, LoopSettings, LoopOptions], AbstractContextManager[Observers | None]
    ],
    output: Console,
) -> int:
    """Play rounds; returns the exit code: 0, or 3 where a fault ended them.

    Args:
        rig: that they are played on.
        options: how long, and how far.
        told: gets a number when somebody says so.
        observed: the recorder and the page of a session.
        output: for people.

    Raises:
        SettingError: nothing measures the effort, or an option that cannot be.
        RunError: a folder that cannot be resumed.
    """
    until = share_of(options.until)
    total = _SECONDS if rig.loop.seconds is None else rig.loop.seconds
    if not _SHORTEST <= options.round <= 60.0:
        remedy = f"Give {_SHORTEST:g} to 60 s: the ring holds a minute"
        raise SettingError(f"--round {options.round:g}", remedy=remedy)
    roles = {channel.role for channel in rig.channels}
    if "effort" not in roles:
        problem = "--program learn needs a sensor of the effort"
        raise SettingError(problem, where=rig.what.name, remedy="Add its channel")
    of_now = time.strftime("learn-%Y-%m-%dT%H-%M-%SZ", time.gmtime())
    folder = options.after or rig.loop.folder / of_now

    from erclutch.wings.live.learning.drawn_tables import TableLimits
    from erclutch.wings.live.learning.rounds import LearningRounds

    settings = rig.settings
    drive = settings.motor_limit if "motor" in roles else 0.0
    limits = TableLimits(settings.device, settings.field_limit, drive, 1.0 / settings.period)
    rounds = LearningRounds(limits, rig.seed, settings.theta_fastest)
    if options.after is not None:
        _take_again(rounds, folder, rig.settings.device)

    ended = ""
    code = 0
    while not ended:
        # A log goes on where its table ends, and behind a trip it holds the wait until somebody runs the loop again:
        # neither takes time from the rounds to come.
        played = sum(min(report.seconds, options.round) for report in rounds.reports)
        left = min(options.round, total - played)
        if left < _SHORTEST:
            ended = f"{total:g} s are logged"
            break
        table = rounds.next_table(left)
        if told:
            ended = _INTERRUPTED
            break
        file, tripped, whole = _played(
            rig, table, folder, len(rounds.reports) + 1, told, observed, output
        )
        if file is None:
            ended = tripped or "no frame was logged"
            code = 0 if told else 3
            break
        try:
            logged = _logged(file, rig.settings.device)
        except ErclutchError as error:
            # A trip after a few samples leaves a log that nothing reads as one.
            ended = f"{tripped or 'no trip'}: nothing can be learned of {file.name}, which is kept: {error}"
            code = 3
            break
        if not logged.teaches:
            ended = (
                f"{tripped or 'nothing moved'}: no law can be fitted to {file.name}, which is kept"
            )
            code = 3
            break
        report = rounds.take(logged, file.name, tripped)
        _write(folder, rig, rounds, "")
        output.print(line_of(report, rig), markup=False, soft_wrap=True)
        if told:
            ended = _INTERRUPTED
        elif not whole:
            ended = f"{tripped}; {_STILL}"
            code = 3
        else:
            ended = rounds.enough(until)
    _write(folder, rig, rounds, ended)
    _tell(rounds, rig, folder, ended, output)
    if code and folder.is_dir():
        output.print(
            f"go on with: --program learn --after {shlex.quote(str(folder))}",
            markup=False,
            soft_wrap=True,
        )
    if rig.loop.json:
        print(json_text.dumps(_body(rig, rounds, ended) | {"folder": str(folder), "exit": code}))
    return code


def _played(
    rig: Rig,
    table: Any,
    folder: Path,
    number: int,
    told: list[int],
    observed: Callable[
        [Session, LoopSettings, LoopOptions], AbstractContextManager[Observers | None]
    ],
    output: Console,
) -> tuple[Path | None, str, bool]:
    """One session that plays a table; its log, why it tripped, and whether the next round may follow."""
    from erclutch.wings.live.command_line.told_signals import end_where_told
    from erclutch.wings.live.session import ServedRig, Session, SessionOptions
    from erclutch.wings.live.settings import REST, LoopProgram, Mode, Waveform

    soft = rig.settings.stroke * 0.2 if rig.settings.device == "coaxial" else 0.0
    name = f"learn, round {number}"
    program = LoopProgram(
        "learn",
        Mode.FIELDS,
        Waveform.TABLE,
        table=table,
        soft=soft,
        meaning=name,
    )
    settings = replace(rig.settings, programs=(program, REST))
    what = rig.what
    if isinstance(what, ServedRig):  # another noise in each round
        what = replace(what, spec=what.spec | {"seed": rig.seed + number})
    loop = replace(rig.loop, record=True, folder=folder)
    run_as = SessionOptions(None, loop.priority, loop.cpu, name, rig.channels)
    try:
        with (
            Session(what, settings, None, run_as, partial(end_where_told, told)) as session,
            observed(session, settings, loop) as observers,
        ):
            assert observers is not None
            page = not loop.headless
            if page:
                output.print(
                    f"page of round {number}: {observers.url}", markup=False, soft_wrap=True
                )
            tripped, whole = follow_round(session, len(table), told, output, wait=page)
            session.stop()
            observers.record(False)
            files = observers.recordings.files
            faults = observers.recordings.faults
    except (KeyboardInterrupt, SystemExit):
        if not told:
            raise
        return None, _INTERRUPTED, True  # before the round began: the rounds so far are told
    if faults:  # a log that lacks frames teaches what it has, and the next one would lack them too
        return (files[0] if files else None), "; ".join(faults), False
    return (files[0] if files else None), tripped, whole


def follow_round(
    session: Session,
    rows: int,
    told: list[int],
    output: Console,
    *,
    wait: bool,
) -> tuple[str, bool]:
    """Watch a round until its table is played, or it tripped.

    Args:
        session: that plays the table as its first program.
        rows: of the table.
        told: gets a number when somebody says so.
        output: for people.
        wait: after a trip, wait until somebody runs the loop again.

    Returns:
        Why it tripped, else nothing; and whether the next round may follow.
    """
    from erclutch.wings.live.ring import State

    reader = session.reader()
    tripped = ""
    while session.running and session.rig_running and not told:
        reader.read()
        if reader.state is State.TRIPPED and not tripped:
            tripped = reader.trip_reason or "a trip"
            hint = "Run on the page goes on with the next round" if wait else ""
            output.print(
                f"{tripped}: {_STILL}. {hint}".strip(),
                style="red",
                markup=False,
                soft_wrap=True,
            )
            if not wait:
                return tripped, False
        if tripped and reader.state is State.RUNNING:
            return tripped, True
        if not tripped and reader.head >= rows:
            return "", True
        time.sleep(_POLL)
    gone = "" if told else session.said() or "the rig or the loop ended"
    return tripped or gone, bool(told)


def _logged(file: Path, device: Any) -> LoggedRound:
    """A recording as a round."""
    from erclutch.logs import read
    from erclutch.logs.dataset import build_dataset
    from erclutch.wings.live.learning.foretold_motion import LoggedRound

    recording = read(file)
    rows = build_dataset(recording, device=device)
    drive = rows.spare.get("drive", recording.signals.get("motor_torque"))
    return LoggedRound(rows, drive if drive is not None and drive.size == rows.rows else None)


def _take_again(rounds: LearningRounds, folder: Path, device: Any) -> None:
    """Take the rounds of a folder.

    Raises:
        RunError: it has no report of rounds, or a log is missing.
    """
    from erclutch.logs.log_reader import LEARN_REPORT

    path = folder / LEARN_REPORT
    try:
        body = small_json(path)
        entries = [(str(entry["file"]), str(entry["tripped"])) for entry in body["rounds"]]
    except (OSError, ValueError, TypeError, KeyError) as error:
        why = plain_words(error) if isinstance(error, OSError) else "is no report of rounds"
        raise RunError(
            why, where=str(path), remedy="Give a folder of --program learn to --after"
        ) from error
    for name, tripped in entries:
        file = folder / Path(name).name
        rounds.take(_logged(file, device), file.name, tripped)


def _body(rig: Rig, rounds: LearningRounds, ended: str) -> dict[str, Any]:
    return {
        "rig": rig.what.name,
        "origin": rig.what.origin,
        "seed": rig.seed,
        "ended": ended,
        "rounds": [report.to_dict() for report in rounds.reports],
    }


def _write(
    folder: Path,
    rig: Rig,
    rounds: LearningRounds,
    ended: str,
) -> None:
    """The report beside the logs; it is there whole after each round."""
    from erclutch.logs.log_reader import LEARN_REPORT

    if not folder.is_dir():
        return
    with whole_file(folder / LEARN_REPORT) as unfinished:
        text = json_text.dumps(_body(rig, rounds, ended), indent=1) + "\n"
        unfinished.write_text(text, encoding="utf-8")


def line_of(report: RoundReport, rig: Rig) -> str:
    """A round as one line, while the next one is being chosen."""
    unit = rig.effort_unit
    return (
        f"round {report.number}: {report.seconds:.3g} s, {report.law}, band +-{report.band:.3g} {unit} "
        f"({percent(report.share, 2)} of the largest effort). The numbers leave {percent(report.open_share, 2)} open; "
        f"the floor is {percent(report.floor_share, 2)}, of which the sensor's noise is "
        f"{percent(report.noise_share, 2)}"
    )


def _tell(
    rounds: LearningRounds,
    rig: Rig,
    folder: Path,
    ended: str,
    output: Console,
) -> None:
    """What each round taught, as tables."""
    from erclutch.cli import terminal

    if rounds.reports:
        words = ("round", "s", "law", "new rows", "fitted", "left open", "foretold", "band")
        head = [*words, "open %", "floor %", "band %"]
        rows: list[list[str]] = []
        for each in rounds.reports:
            number = f"{each.number}{' *' if each.tripped else ''}"
            errors = (each.before, each.residual, each.open, each.open_foretold, each.band)
            shares = (each.open_share, each.floor_share, each.share)
            row = [number, f"{each.seconds:.1f}", each.law]
            row += [terminal.number(error, 3) for error in errors]
            row += [percent(share, 2) for share in shares]
            rows.append(row)
        title = f"{rig.what.origin}: what each round taught, {rig.effort_unit}"
        output.print(terminal.table(title, head, rows))
        last = rounds.reports[-1]
        numbers: list[list[str]] = []
        for name, three in last.half_widths.items():
            numbers.append([name, *(terminal.number(each, 3) for each in three)])
        title = f"{last.law} after round {last.number}: half width of the 95 % interval"
        output.print(terminal.table(title, ["", "value", "got", "foretold"], numbers))
    output.print(f"ended: {ended}", markup=False, soft_wrap=True)
    output.print(
        f"fit them all: erclutch fit {shlex.quote(str(folder))}/*.mcap",
        markup=False,
        soft_wrap=True,
    )
