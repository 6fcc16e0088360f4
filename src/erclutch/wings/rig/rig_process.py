"""A rig runs in a process of its own: ``python -m erclutch.wings.rig.rig_process SPEC``, SPEC in JSON; see `start_rig`.

It prints ``port N`` once it can be spoken to, and at its end what it counted. It ends with its parent, when told to
(SIGTERM), or when a replay is over; at zero field in any case.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from erclutch import registry
from erclutch.errors import ErclutchError
from erclutch.wings.rig.interface import SteppedRig
from erclutch.wings.rig.rig_plugins import GROUP
from erclutch.wings.rig.rig_server import RigServer

_PRIORITY = 70  # in real time, of 1 to 99


class RigStartError(ErclutchError):
    """A rig's process did not come up."""


#: Seconds that the twin may compile.
_START_WITHIN = 120.0
_LOOK = 0.05  # s


def start_rig(
    spec: Mapping[str, Any], while_waiting: Callable[[], None] = lambda: None
) -> tuple[subprocess.Popen[str], int]:
    """Start a rig's process.

    Args:
        spec: ``kind``, the name of a rig of ours, and what its own file makes the rig of; ``session``, ``device``,
            ``port`` (0: any).
        while_waiting: called again and again; what it raises ends the rig.

    Returns:
        The process and its UDP port on loopback.

    Raises:
        RigStartError: it ended, or said nothing in time.
    """
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "erclutch.wings.rig.rig_process", json.dumps(dict(spec))],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for the loop first: the rig ends with its parent or when told to
    )
    assert process.stdout is not None
    try:
        limit = time.monotonic() + _START_WITHIN
        ready = False
        while not ready and time.monotonic() < limit:
            while_waiting()
            ready = bool(select.select([process.stdout], [], [], _LOOK)[0])
        line = process.stdout.readline() if ready else ""
    except (
        BaseException
    ):  # Control-C: a notebook that goes on would keep this process as long as it lives
        with process:
            process.kill()
        raise
    if not line.startswith("port "):
        process.kill()
        process.wait()
        raise RigStartError(
            f"the rig's process did not start within {_START_WITHIN:g} s",
            where=str(spec["kind"]),
            remedy="See its message",
        )
    return process, int(line.split()[1])


def rig_of(spec: Mapping[str, Any]) -> tuple[SteppedRig, float]:
    """The rig of a specification, ready to be stepped, and its lead in m."""
    rig = registry.find(GROUP, spec["kind"]).value
    return rig.stepped(spec)


def main(text: str) -> int:
    """Serve until told to stop."""
    spec = json.loads(text)
    parent = os.getppid()
    told: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda number, _frame: told.append(number))
    rig, lead = rig_of(spec)
    device = spec.get("device", "coaxial")
    server = RigServer(
        rig,
        session=int(spec["session"]),
        lead=lead,
        device=device,
        port=int(spec.get("port", 0)),
    )
    try:
        sys.stdout.write(f"port {server.port}\n")
        sys.stdout.flush()
    except BrokenPipeError:  # a signal ended the session before it began
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 0
    # Ahead of ordinary processes where that is permitted, but behind the loop: a real rig does not wait either.
    with contextlib.suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    gc.collect()
    gc.freeze()
    gc.disable()
    server.run(lambda: bool(told) or os.getppid() != parent)
    counts = {**server.counts, **getattr(rig, "events", {})}
    try:
        sys.stdout.write(json.dumps(counts) + "\n")
    except BrokenPipeError:  # nobody is left to read it
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
