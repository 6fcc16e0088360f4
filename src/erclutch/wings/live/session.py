"""A live session has a rig's process, the loop's process, and this process, which started both and only watches.

The loop ends at zero field when this process ends, however it ends; the rig's watchdog does so when the loop does not.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from erclutch.errors import ErclutchError
from erclutch.signals.channels import LiveChannel, NamedChannels, channels_of
from erclutch.signals.device import Units
from erclutch.wings.live.c_build import loop_program
from erclutch.wings.live.companion_process import end_process
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.page_commands import PageCommand
from erclutch.wings.live.ring import RingInfo, RingReader, make_ring, ring_folder
from erclutch.wings.live.settings import LoopSettings, config_of
from erclutch.wings.rig.rig_plugins import LibraryRig, UdpRig
from erclutch.wings.rig.rig_process import start_rig

#: The loop has so long to get its first sample.
_FIRST_SAMPLE = 10.0
_END = 5.0
_PREFIX = "erclutch-live-"


class LiveError(ErclutchError):
    """A live session could not start, or ended by itself."""

    exit_code = 3


@dataclass(frozen=True)
class ServedRig:
    """A rig of ours, run in a process of its own.

    Attributes:
        name: for people.
        origin: TWIN, RECORDING, or RECORDING of what a computer made.
        spec: what `erclutch.wings.rig.rig_process.start_rig` takes, without the session's number and the device.
        named: units of its channels, and which there are; None: those of the device.
    """

    name: str
    origin: str
    spec: dict[str, Any] = field(default_factory=dict[str, Any])
    named: NamedChannels | None = None


TWIN = ServedRig("twin", "TWIN", {"kind": "twin"})
RigChoice = ServedRig | UdpRig | LibraryRig


@dataclass(frozen=True)
class LiveModel:
    """The model that a session runs.

    Attributes:
        library: the compiled model.
        name, digest: of the model.
        units: of its effort, field and slip, where they are known.
        period: in s that it is compiled for; None: any.
        note: what to know of it at that period.
        adapts: a gain and an offset follow the torque sensor.
        effort, slip: the largest of its log, in their units; 0: not known.
        band: half width of its widest band under a settled field, in the unit of the effort; 0: it has none.
    """

    library: Path
    name: str
    digest: str
    units: Units | None = None
    period: float | None = None
    note: str = ""
    adapts: bool = False
    effort: float = 0.0
    slip: float = 0.0
    band: float = 0.0


@dataclass(frozen=True)
class SessionOptions:
    """How the loop runs.

    Attributes:
        seconds: it ends by itself after so long; None runs until told.
        priority: of SCHED_FIFO, 1 to 99; 0 does not ask for it.
        cpu: processor that it stays on; None leaves that to the system.
        note: what the session is for; kept in the ring and in recordings.
        channels: what the numbers of a frame are called; none: those of the settings' device, its units unknown.
    """

    seconds: float | None = None
    priority: int = 80
    cpu: int | None = None
    note: str = ""
    channels: tuple[LiveChannel, ...] = ()


class Session(contextlib.AbstractContextManager["Session"]):
    """A running session. Use it as a context: leaving it ends at zero field.

    Args:
        rig: what is driven.
        settings: limits, gains, programs.
        model: what estimates; None estimates nothing.
        options: how the loop runs.
        while_waiting: called again and again until the first frame is there; what it raises ends the session.

    Attributes:
        ring: path of the frames' ring.

    Raises:
        CompilerError: there is no C compiler, or it failed.
        LiveError: the loop did not start, or not on this system; RigStartError: the rig did not.
    """

    def __init__(
        self,
        rig: RigChoice,
        settings: LoopSettings,
        model: LiveModel | None = None,
        options: SessionOptions | None = None,
        while_waiting: Callable[[], None] = lambda: None,
    ) -> None:
        self.rig, self.settings, self.model = rig, settings, model
        self.options = options or SessionOptions()
        self._while_waiting = while_waiting
        if sys.platform == "win32":
            raise LiveError("erclutch live does not run on Windows", remedy="Use Linux or macOS")
        if model and model.period not in (None, settings.period):
            problem = (
                f"the model {model.name} is made for a period of {model.period:g} s, the loop has "
                f"{settings.period:g} s"
            )
            raise LiveError(problem, remedy="Give both the same period")
        if model and model.adapts and settings.observer != "off":
            # The observer holds what the device gives against the estimate, which then follows the device by itself.
            problem = f"the model adapts to the torque sensor, and so does the observer by {settings.observer}"
            raise LiveError(problem, remedy="Leave out --adapt, or give --observer off")
        self._program = loop_program()
        self._folder, self._lock = own_folder()
        self.ring = self._folder / "ring"
        self._rig: subprocess.Popen[str] | None = None
        self._loop: subprocess.Popen[bytes] | None = None
        self._messages = self._folder / "loop.err"
        try:
            self._start()
        except BaseException:
            self.close()
            raise

    @property
    def origin(self) -> str:
        """TWIN, RECORDING or HARDWARE."""
        return self.rig.origin

    def _start(self) -> None:
        config, table = config_of(self.settings)
        (self._folder / "config").write_bytes(config)
        config_file = self._folder / "config"
        words = ["--config", str(config_file), "--ring", str(self.ring), "--orders", "0"]
        if len(table):
            (self._folder / "table").write_bytes(table.tobytes())
            words += ["--table", str(self._folder / "table")]
        model = self.model
        make_ring(
            self.ring,
            RingInfo(
                period_ns=round(self.settings.period * 1e9),
                rig=self.rig.name,
                origin=self.origin,
                model=model.name if model else "",
                digest=model.digest if model else "",
                field_limit=self.settings.field_limit,
                motor_limit=self.settings.motor_limit,
                start_ns=time.monotonic_ns(),
                start_unix_ns=time.time_ns(),
                note=self.options.note,
                channels=self.options.channels or channels_of(self.settings.device),
            ),
        )
        words += [*self._rig_words(), *self._option_words()]
        with self._messages.open("wb") as errors:
            self._loop = subprocess.Popen(
                [str(self._program), *words],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=errors,
            )
        self._await_first_frame()

    def _rig_words(self) -> list[str]:
        if isinstance(self.rig, LibraryRig):
            return ["--library", str(self.rig.path), self.rig.options]
        if isinstance(self.rig, UdpRig):
            return [
                "--udp",
                self.rig.host,
                str(self.rig.port),
                str(self.rig.local_port),
                str(self.rig.session),
            ]
        session = secrets.randbits(32)
        about = {**self.rig.spec, "session": session, "device": self.settings.device}
        self._rig, port = start_rig(about, self._while_waiting)
        return ["--udp", "127.0.0.1", str(port), "0", str(session)]

    def _option_words(self) -> list[str]:
        words = ["--priority", str(self.options.priority)]
        if self.model is not None:
            words += ["--model", str(self.model.library), self.model.digest]
        if self.options.cpu is not None:
            words += ["--cpu", str(self.options.cpu)]
        if self.options.seconds is not None:
            steps = max(1, round(self.options.seconds / self.settings.period))
            words += ["--steps", str(steps)]
        return words

    def _await_first_frame(self) -> None:
        limit = time.monotonic() + _FIRST_SAMPLE
        with contextlib.closing(self.reader()) as reader:
            while reader.head == 0 and self.running and time.monotonic() < limit:
                self._while_waiting()
                time.sleep(0.005)
            if reader.head == 0:
                raise LiveError(
                    f"the loop did not start: {self.said() or 'it says nothing'}",
                    remedy="See its message",
                )

    @property
    def running(self) -> bool:
        """Whether the loop's process is there."""
        return self._loop is not None and self._loop.poll() is None

    @property
    def rig_running(self) -> bool:
        """Whether the rig's process is there; a rig that is not ours always is."""
        return self._rig is None or self._rig.poll() is None

    @property
    def pids(self) -> dict[str, int]:
        """Processes of the session."""
        processes = {"loop": self._loop, "rig": self._rig}
        return {name: process.pid for name, process in processes.items() if process is not None}

    def said(self) -> str:
        """What the loop wrote to its standard error."""
        with contextlib.suppress(OSError):
            return (
                self._messages.read_text(errors="replace").strip().removeprefix("erclutch-loop: ")
            )
        return ""

    def order(self, order: Order, value: float = 0.0) -> bool:
        """Give the loop an order; False if it is no longer there to take one. It counts what it refuses."""
        if self._loop is None or self._loop.stdin is None:
            return False
        try:
            os.write(self._loop.stdin.fileno(), order_bytes(order, value))
        except (OSError, ValueError):
            return False
        return True

    def run_again(self, program: int = 0) -> None:
        """Clear a trip and run a program: what an operator does in two steps, for scripts."""
        self.order(Order.RESET)
        self.order(Order.PROGRAM, program)

    def carry_out(self, command: PageCommand) -> None:
        """Turn a checked command of the page into an order."""
        if command.kind != "record":
            self.order(Order[command.kind.upper()], command.value)

    def reader(self, start: str = "oldest") -> RingReader:
        """A reader of the frames; the caller closes it."""
        return RingReader(self.ring, start)

    def wait(self, timeout: float | None = None) -> int | None:
        """Wait for the loop to end; its exit code, or None when the time is over."""
        assert self._loop is not None
        try:
            return self._loop.wait(timeout)
        except subprocess.TimeoutExpired:
            return None

    def stop(self) -> None:
        """End the loop at zero field, then the rig."""
        if self._loop is not None:
            self.order(Order.STOP)
            end_process(self._loop, _END)  # to close the pipe of orders says the same as the order
        if self._rig is not None:
            if self._rig.poll() is None:
                self._rig.terminate()
            end_process(self._rig, _END)
            if self._rig.stdout is not None:
                self._rig.stdout.close()

    def close(self) -> None:
        """Stop, and remove the ring."""
        try:
            self.stop()
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)
            with contextlib.suppress(OSError):
                os.close(self._lock)
            self._lock = -1

    def __exit__(self, *_: object) -> None:
        self.close()


def own_folder() -> tuple[Path, int]:
    """A folder for the ring, and its lock, which goes with this process. What dead sessions left is removed."""
    import fcntl

    for left in ring_folder().glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):  # another user's, or that of a session that lives
            lock = os.open(left, os.O_RDONLY)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(left, ignore_errors=True)
            finally:
                os.close(lock)
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=ring_folder()))
        try:
            lock = os.open(folder, os.O_RDONLY)
        except FileNotFoundError:  # removed as below
            continue
        # On a file system without locks nobody can take the folder for left over.
        with contextlib.suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX)
        # A session that starts at the same moment may have removed it, unlocked as it was.
        if folder.exists():
            return folder, lock
        os.close(lock)
