"""``erclutch live`` estimates, controls, records and shows at 1 kHz."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import require
from erclutch.files import may_fill, scratch_folder
from erclutch.wings.live.command_line.learn import NO_LEARN, LearnOptions
from erclutch.wings.live.command_line.live_options import (
    DEFAULTS,
    EVERY_DAY,
    LOOP,
    TORQUE,
    ControlOptions,
    LoopOptions,
    RigOptions,
)

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.wings.live.companions import Observers
    from erclutch.wings.live.ring import State
    from erclutch.wings.live.session import LiveModel, Session
    from erclutch.wings.live.settings import LoopSettings
    from erclutch.wings.rig.twin.parameters import RigParameters

COMMAND = {
    "help": "Estimate, control, record and watch at 1 kHz, on the digital TWIN or on your rig.",
    "panel": "Live",
    "place": 1,
}


def live(
    *,
    run: Annotated[Path | None, Parameter(group=EVERY_DAY)] = None,
    model: Annotated[str | None, Parameter(group=EVERY_DAY)] = None,
    no_model: Annotated[bool, Parameter(group=LOOP, negative=())] = False,
    adapt: Annotated[bool, Parameter(group=TORQUE, negative=())] = False,
    explain: Annotated[bool, Parameter(group=LOOP, negative=())] = False,
    rig: RigOptions = DEFAULTS[0],
    control: ControlOptions = DEFAULTS[1],
    loop: LoopOptions = DEFAULTS[2],
    learning: LearnOptions = NO_LEARN,
    reading: LogOptions = DEFAULT_READING,
) -> int:
    """Estimate torque, control, record and watch at 1 kHz, on the digital TWIN or on your rig. Ctrl-C: zero field, end.

    Args:
        run: The folder of a run, or a model's JSON file. Default on the twin: a network, fitted to it once.
        model: Which model of the run; the recommended one by default.
        no_model: Control and record without an estimate.
        adapt: Let a gain and an offset of the model follow the torque sensor; at most 2 % worse in RMSE.
        explain: Only print what the loop does on each event in each of its states.
        rig: What is driven.
        control: What is done.
        loop: How the loop runs.
        learning: How --program learn goes on.
        reading: How to read the log of a replay.
    """
    from erclutch.cli import terminal
    from erclutch.wings.live.c_build import loop_program
    from erclutch.wings.live.command_line.chosen_rig import (
        channels_of_rig,
        device_of,
        file_of,
        model_of,
        rig_of,
    )
    from erclutch.wings.live.command_line.chosen_settings import (
        knows_inertia,
        settings_of,
        supported,
        tuned,
    )
    from erclutch.wings.live.command_line.learn import Rig, asks_for_rounds, learn
    from erclutch.wings.live.command_line.session_report import ended, follow, introduce
    from erclutch.wings.live.command_line.told_signals import end_where_told, signals_told
    from erclutch.wings.live.offered_programs import standard_programs, starting_with
    from erclutch.wings.live.session import Session, SessionOptions
    from erclutch.wings.live.session_figures import SessionFigures
    from erclutch.wings.rig.twin.parameters import load_rig

    if explain:
        return _explained(terminal.console())
    # With --json standard output is one JSON document: all that is for people goes to standard error.
    output = terminal.console(stderr=loop.json)
    seconds = math.inf if loop.seconds is None else loop.seconds
    require(0.001, unit=" s", seconds=seconds)
    require(0, 99, priority=loop.priority)
    if loop.record or control.program == "learn":
        may_fill(loop.folder, "folder")  # before models are fitted and compiled
    learns = asks_for_rounds(control, learning, rig, adapt)
    if learns:
        control, no_model = replace(control, program="rest"), True
    with ExitStack() as stack:
        folder = Path(stack.enter_context(scratch_folder()))
        file = file_of(run, model)
        parameters = load_rig(rig.rig_file)
        control, tuning = tuned(control)
        knows_inertia(control)
        what, program = rig_of(rig, reading, folder, file, control, loop)
        device = device_of(what)
        if control.program is not None and program is None:
            # A misspelt program is told before a model is fitted to the twin.
            starting_with(
                standard_programs(parameters, model=not no_model, device=device), control.program
            )
        chosen: LiveModel | None = None
        if not no_model:
            chosen = model_of(file, rig, what, parameters, output, device, adapt)
        control = supported(control, what, chosen, adapt)
        channels = channels_of_rig(what, device, chosen)
        settings = settings_of(
            what, device, chosen, channels, parameters, (rig, control), tuning, program
        )
        first = settings.programs[0]
        loop_program()  # compiled here, where Ctrl-C ends the command at once
        told = stack.enter_context(signals_told())
        until_told = partial(end_where_told, told)
        observed = partial(_observers, parameters, until_told)
        if learns:
            played_on = Rig(what, settings, channels, loop, rig.seed)
            return learn(played_on, learning, told, observed, output)
        run_as = SessionOptions(loop.seconds, loop.priority, loop.cpu, first.name, channels)
        session = stack.enter_context(Session(what, settings, chosen, run_as, until_told))
        observers = stack.enter_context(observed(session, settings, loop))
        watch = SessionFigures(session.reader(), first.mode.reference)
        introduce(output, session, observers, chosen)
        follow(session, watch, told, output)
        code = session.wait(5.0)
        watch.poll()
        return ended(session, watch, observers, code, bool(told), None if loop.json else output)


def _explained(output: Console) -> int:
    from erclutch.cli import terminal
    from erclutch.wings.live.explained_states import transitions

    rows_of: dict[State, list[list[str]]] = {}  # of the table of each state
    for answer in transitions():
        events = ", ".join(answer.said)
        row = [answer.event, answer.next.name.lower(), answer.field, events]
        rows_of.setdefault(answer.state, []).append(row)
    headings = ["event", "next state", "field", "events in the frame"]
    for state, rows in rows_of.items():
        states = terminal.table(f"In the state {state.name.lower()}", headings, rows, left=4)
        output.print(states)
    output.print("Asked of tracking. Torque, impedance and wall are answered alike.")
    return 0


@contextmanager
def _observers(
    parameters: RigParameters,
    while_waiting: Callable[[], None],
    session: Session,
    settings: LoopSettings,
    loop: LoopOptions,
) -> Generator[Observers | None]:
    if loop.headless and not loop.record:
        yield None
        return
    from erclutch.wings.live.companions import Observers

    offered = [
        (program.name, program.meaning, program.mode.reference) for program in settings.programs
    ]
    with Observers(
        session.ring,
        session.carry_out,
        programs=offered,
        motor_limit=settings.motor_limit,
        folder=loop.folder,
        page=not loop.headless,
        port=loop.port,
        stroke=settings.stroke,
        lead=parameters.value("screw.lead"),
        while_waiting=while_waiting,
    ) as observers:
        if loop.record:
            observers.record(True, whole=True)
        yield observers
