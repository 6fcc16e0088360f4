"""The server runs as a process; this module holds the session's side of it too.

The session writes JSON lines to the server's standard input: first all that it needs (the token travels here, not in
the command line, which others can read), then the session's state whenever it changes. The server answers with JSON
lines: first its port, then each command. When standard input ends, so does the server.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from erclutch.errors import ErclutchError
from erclutch.wings.live.companion_process import CompanionProcess, end_process
from erclutch.wings.live.page.access import Access, new_token
from erclutch.wings.live.page_commands import CommandError, CommandLimits, PageCommand, parse

_START = 20.0  # s
_PATIENCE = 20.0  # s that the server may read nothing
_LONGEST_STATE = 1 << 24  # bytes


class PageError(ErclutchError):
    """The page's server cannot start."""


class PageProcess:
    """The server of a session's page. Killed, it is started again at the same address.

    Args:
        ring: path of the ring.
        limits: of commands.
        port: to listen on; 0 lets the system choose.
        shown: what a page is told of its session: see `erclutch.wings.live.page.page_server.Page`.
        while_waiting: called again and again until the server answers; what it raises ends the server.

    Attributes:
        access: where the page is, and its token.
        restarts: how often the server had to be started again.

    Raises:
        PageError: the extra ``live`` is not installed, or the port is taken.
    """

    def __init__(
        self,
        ring: str,
        limits: CommandLimits,
        *,
        port: int = 0,
        shown: Mapping[str, Any] | None = None,
        while_waiting: Callable[[], None] = lambda: None,
    ) -> None:
        self._limits = limits
        self._said: dict[str, Any] = {}
        self._setting: dict[str, Any] = {
            "ring": ring,
            "limits": asdict(limits),
            "shown": dict(shown or {}),
        }
        self._setting |= {"port": port, "token": new_token()}
        self.restarts = 0
        self._process = self._start()
        try:
            first = self._process.answer(_START, while_waiting)
        except BaseException:
            self._process.kill()  # nobody has seen its page yet
            self.close()
            raise
        if "port" not in first:
            self.close()
            problem = first.get("problem", "its server does not start")
            remedy = first.get("remedy", "Run erclutch live with --headless")
            raise PageError(f"the page cannot be shown: {problem}", remedy=remedy)
        self._setting["port"] = first["port"]
        self.access = Access(first["port"], self._setting["token"])

    @property
    def pid(self) -> int:
        """Process of the server."""
        return self._process.pid

    def _start(self) -> CompanionProcess:
        process = CompanionProcess("erclutch.wings.live.page.page_process", listens=True)
        process.tell(self._setting)
        if self._said:
            process.tell(self._said)
        return process

    def tell(self, body: dict[str, Any]) -> None:
        """Renew what the session says of itself; sent only when it changed."""
        if body != self._said:
            self._said = body
            self._process.tell(body)

    def poll(self, carry_out: Callable[[PageCommand], None]) -> None:
        """Carry out the commands that came, and start the server again if it is gone."""
        for line in self._process.lines():
            if line.startswith(b'{"port"') or not line.strip():
                continue
            with contextlib.suppress(CommandError):
                carry_out(parse(line.strip(), self._limits))
        self._process.push()
        if self._process.deaf > _PATIENCE:
            self._process.kill()  # it hangs, or was stopped, and would never show a thing again
            self._process.wait()
        if self._process.poll() is not None:
            self.close()
            self.restarts += 1
            self._process = self._start()

    def close(self) -> None:
        """End the server."""
        end_process(self._process, 5.0)


# --- the server's side ------------------------------------------------------------------------------------------------


def main() -> int:
    """Read the setting, serve until standard input ends; returns the exit code."""
    # Not through the buffer of sys.stdin, which would keep what follows the line from the event loop.
    with open(sys.stdin.fileno(), "rb", buffering=0, closefd=False) as raw:
        line = raw.readline()
    if not line.endswith(b"\n"):  # the session ended before it had said all
        return 0
    try:
        return asyncio.run(_serve(json.loads(line)))
    except ImportError as error:
        _say(
            {
                "problem": f"{error.name} is not installed",
                "remedy": 'Run: pip install "erclutch[live]"',
            }
        )
    except ErclutchError as error:
        _say({"problem": error.problem, "remedy": error.remedy})
    except OSError as error:
        _say(
            {
                "problem": os.strerror(error.errno) if error.errno else str(error),
                "remedy": "Give another --port",
            }
        )
    return 2


def _say(body: dict[str, Any]) -> None:
    """Tell the session something about the server."""
    _hand_over(json.dumps(body))


async def _serve(setting: dict[str, Any]) -> int:
    from erclutch.wings.live.page.connections import ListeningSocket, server_of
    from erclutch.wings.live.page.page_server import LONGEST_MESSAGE, Page

    limits = CommandLimits(tuple(setting["limits"]["programs"]), setting["limits"]["motor"])
    listening = ListeningSocket(int(setting["port"]))
    access = Access(listening.port, setting["token"])
    page = Page(setting["ring"], limits, access, _hand_over, setting["shown"])
    server = server_of(
        page.app,
        page.app.strangers,
        ws="websockets-sansio",
        ws_max_size=LONGEST_MESSAGE,
        ws_per_message_deflate=False,
    )
    # SIGINT is the session's business, and it closes our input.
    server.capture_signals = contextlib.nullcontext
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    listener = asyncio.create_task(_listen_to_session(page, server))
    watcher = asyncio.create_task(page.watch())
    _say({"port": access.port})
    try:
        await server.serve(sockets=[listening])
    finally:
        for task in (listener, watcher):
            task.cancel()
        await asyncio.gather(listener, watcher, return_exceptions=True)
    return 0


def _hand_over(body: str) -> None:
    """A line for the session: a command as it came, which the session checks again. A line break in JSON is a space."""
    with contextlib.suppress(OSError):
        line = body.replace("\n", " ").encode() + b"\n"
        os.write(sys.stdout.fileno(), line)


async def _listen_to_session(page: Any, server: Any) -> None:
    """State of the session, line by line; its notes go into the log of events."""
    reader = asyncio.StreamReader(limit=_LONGEST_STATE)
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), sys.stdin
    )
    told = 0
    try:
        while line := await reader.readline():
            body: Any = json.loads(line)
            notes: list[tuple[int, int, str, str]] = body.pop("notes", [])
            page.session = body
            for number, at, text, level in notes:
                if number >= told:
                    page.watcher.say(text, at, level)
                    told = number + 1
    finally:
        transport.close()
        server.should_exit = True


if __name__ == "__main__":
    sys.exit(main())
