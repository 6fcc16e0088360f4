"""What a session tells while it runs and when it ends, for people and for scripts."""

from __future__ import annotations

import json as json_text
import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from erclutch.errors import plural
from erclutch.signals.percent import percent
from erclutch.wings.live.layout import EVENTS
from erclutch.wings.live.ring import doubt_in_words

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.wings.live.companions import Observers
    from erclutch.wings.live.session import LiveModel, Session
    from erclutch.wings.live.session_figures import SessionFigures

_POLL = 0.05  # s
_PATIENCE = 3.0  # s
_ASTRAY = (
    "The fields that the model names do not give the wanted torque here. Try --observer sensor, another model of the "
    "run (--run RUN --model NAME, such as bingham+fnn-16), or a log of this motion (erclutch excite)."
)
_NO_SAMPLE = (
    "no sample came from the rig. Is it on, at this address, with this --session, of a {} device "
    "(byte 52: {})?"
)


def introduce(
    output: Console,
    session: Session,
    observers: Observers | None,
    model: LiveModel | None,
) -> None:
    """What is driven and by what, before the first frame."""
    output.print(f"{session.origin}: {session.rig.name}", markup=False)
    reader = session.reader()
    listed = [str(channel) for channel in reader.info.channels if channel.role != "reference"]
    output.print(f"channels: {', '.join(listed)}", markup=False, soft_wrap=True)
    if session.origin == "HARDWARE":
        output.print(f"largest field: {session.settings.field_limit:g}", markup=False)
    called = "none" if model is None else f"{model.name} ({model.digest[:12]})"
    output.print(f"model: {called}", markup=False)
    if model is not None and model.note:
        output.print(f"note: {model.note}.", markup=False)
    output.print(f"loop: {reader.realtime}", markup=False, soft_wrap=True)
    if observers is not None and observers.url:
        output.print(f"page: {observers.url}", markup=False, soft_wrap=True)


def follow(
    session: Session,
    watch: SessionFigures,
    told: list[int],
    output: Console,
) -> None:
    """Read frames until the loop ends, or until somebody says so."""
    from erclutch.wings.live.orders import Order

    known_reason = ""  # why the loop is tripped, as it was told last
    answers = False
    warn_at = time.monotonic() + _PATIENCE

    def look(known_reason: str) -> str:
        watch.poll()
        reason = watch.reader.trip_reason
        if reason not in ("", known_reason):
            output.print(
                f"fields are held at zero: {_why(reason)}",
                style="red",
                markup=False,
                soft_wrap=True,
            )
            if watch.busy:
                output.print(watch.busy, style="red", markup=False, soft_wrap=True)
        return reason

    while session.running and session.rig_running and not told:
        known_reason = look(known_reason)
        if not answers and watch.reader.sensor_seq:
            answers = True
            output.print("the rig answers", markup=False)
        if not answers and time.monotonic() > warn_at:
            warn_at = math.inf
            output.print(_no_sample(session), style="red", markup=False, soft_wrap=True)
        time.sleep(_POLL)
    session.order(Order.STOP)  # told to, or the rig is gone
    session.wait(2.0)
    look(known_reason)


def _no_sample(session: Session) -> str:
    from erclutch.wings.rig.packet import NUMBERS

    device = session.settings.device
    return _NO_SAMPLE.format(device, NUMBERS[device])


def _why(trip: str) -> str:
    """What tripped the loop, by name and in words."""
    doubt = doubt_in_words(trip)
    if doubt:
        return f"{doubt[:1].lower()}{doubt[1:]} ({trip})"
    meanings = [meaning for name, meaning in EVENTS if name in trip.split(": ")]
    if not meanings:
        return trip
    return f"{trip} ({'; '.join(meanings)})"


def _show(
    session: Session,
    watch: SessionFigures,
    notes: Sequence[str],
    output: Console,
) -> None:
    """What was seen, for people."""
    from erclutch.cli import terminal

    seconds = watch.frames * watch.reader.info.period_ns * 1e-9
    missed = watch.reader.missed
    late = f"{missed} {plural(missed, 'deadline')} missed"
    title = f"{session.origin}: {watch.frames:,} steps ({seconds:.1f} s), {late}"
    output.print(terminal.table(title, ["us", "p50", "p99", "p99.9", "largest"], watch.rows()))
    counts: list[str] = []
    for name, count in watch.reader.counts.items():
        if not count:
            continue
        share = count / max(watch.frames, 1)
        if count > 0.01 * watch.frames:
            counts.append(f"{name}: {count:,} ({percent(share)} of the steps)")
        else:
            counts.append(f"{name}: {count}")
    output.print(", ".join(counts) or "no event", markup=False)
    for name, meaning in EVENTS:
        if watch.reader.counts.get(name):
            output.print(
                f"  {name}: {meaning}",
                style="dim",
                markup=False,
                soft_wrap=True,
            )
    if watch.effort is not None and watch.estimated is not None:
        off, measured = watch.estimated
        unit = watch.effort.unit
        line = (
            f"estimate off the measured {watch.effort.label} by {off:.3g} {unit} rms; the measured "
            f"has {measured:.3g}"
        )
        output.print(f"{line} {unit}", markup=False)
    if watch.follower is not None and watch.followed is not None:
        off, wanted = watch.followed
        label = watch.follower.label
        unit = watch.follower.unit
        line = f"{label} off the reference by {off:.3g} {unit} rms; the reference has {wanted:.3g} {unit}"
        output.print(line, markup=False)
        if off > 0.5 * wanted and watch.role == "effort":
            output.print(_ASTRAY, style="yellow", markup=False, soft_wrap=True)
    for note in notes:
        output.print(note, markup=False, soft_wrap=True)


def ended(
    session: Session,
    watch: SessionFigures,
    observers: Observers | None,
    code: int | None,
    told: bool,
    output: Console | None,
) -> int:
    """Tells what was seen, as JSON without an output; the exit code: 0, or 3 and the reason for another end.

    A recording that is lost or lacks frames is such a reason: a script must not take it for what was asked.

    Raises:
        KeyboardInterrupt: the loop was told to end before the rig answered.
    """
    from erclutch.cli import terminal
    from erclutch.wings.live.ring import State
    from erclutch.wings.live.session_figures import SHARES

    if observers is not None:
        observers.record(False)  # so that its note says that the file is whole
    notes = () if observers is None else observers.notes
    answered = watch.reader.sensor_seq > 0
    reason = ""
    if code != 0 or watch.reader.state is not State.STOPPED:
        reason = f"the loop ended with code {code}: {session.said() or 'killed'}"
    elif not answered:
        reason = _no_sample(session)
    elif observers is not None:
        reason = "; ".join(observers.recordings.faults)
    if told and not answered and code == 0:
        raise KeyboardInterrupt
    ended = 3 if reason else 0
    if output is None:
        reader = watch.reader
        off_reference, reference = watch.followed or (None, None)
        off_effort, effort = watch.estimated or (None, None)
        body: dict[str, Any] = {
            "origin": session.origin,
            "frames": watch.frames,
            "missed": reader.missed,
            "lost_by_reader": reader.lost,
            "lateness_us": [*watch.lateness.percentiles(SHARES), watch.lateness.largest],
            "step_us": [*watch.step.percentiles(SHARES), watch.step.largest],
            "events": {name: count for name, count in reader.counts.items() if count},
            "realtime": reader.realtime,
            "tripped": reader.trip_reason,
            "off_reference_rms": off_reference,
            "reference_rms": reference,
            "off_effort_rms": off_effort,
            "effort_rms": effort,
            "notes": notes,
            "exit": ended,
        }
        print(json_text.dumps(body))
    else:
        _show(session, watch, notes, output)
        if watch.reader.trip_reason and session.rig_running:
            output.print(
                f"held at zero to the end: {_why(watch.reader.trip_reason)}",
                style="red",
                markup=False,
            )
    if reason:
        terminal.console(stderr=True).print(f"error: {reason}", style="red", soft_wrap=True)
    return ended
