"""The server as a process, and the session's side of it.

The session writes JSON lines to the server's standard input: first all that it needs (the token travels here, not in
the command line, which others can read), then the session's state whenever it changes. The server answers with JSON
lines: first its port, then each command. When standard input ends, so does the server.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any, cast

from erclutch.errors import ErclutchError
from erclutch.live.commands import Command, CommandError, Limits, parse
from erclutch.live.page.access import Access, new_token

_START = 20.0  # s


class PageError(ErclutchError):
    """The page's server cannot start."""


class PageProcess:
    """The server of a session's page. Killed, it is started again at the same address.

    Args:
        ring: path of the ring.
        limits: of commands.
        port: to listen on; 0 lets the system choose.
        programs, stroke, lead: see `erclutch.live.page.server.Desk`.

    Attributes:
        access: where the page is, and its token.
        restarts: how often the server had to be started again.

    Raises:
        PageError: the extra ``live`` is not installed, or the port is taken.
    """

    def __init__(
        self,
        ring: str,
        limits: Limits,
        *,
        port: int = 0,
        programs: list[dict[str, str]] | None = None,
        stroke: float = 0.0,
        lead: float = 0.0,
    ) -> None:
        self._limits = limits
        self._said: dict[str, Any] = {}
        self._setting = {
            "ring": ring, "programs": programs or [], "stroke": stroke, "lead": lead,
            "names": list(limits.programs), "motor": limits.motor, "token": new_token(), "port": port,
        }  # fmt: skip
        self._answers: SimpleQueue[bytes] = SimpleQueue()
        self.restarts = 0
        self._process = self._start()
        first = self._answer(_START)
        if not first or "port" not in first:
            self.close()
            problem = str((first or {}).get("problem", "its server does not start"))
            remedy = str((first or {}).get("remedy", "Run erclutch live with --headless"))
            raise PageError(f"the page cannot be shown: {problem}", remedy=remedy)
        self._setting["port"] = int(first["port"])
        self.access = Access(int(first["port"]), str(self._setting["token"]))

    @property
    def pid(self) -> int:
        """Process of the server."""
        return self._process.pid

    def _start(self) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", "erclutch.live.page.process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self._listener = threading.Thread(target=self._listen, args=(process,), daemon=True)
        self._listener.start()
        self._write(process, self._setting)
        if self._said:
            self._write(process, self._said)
        return process

    def _listen(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        with contextlib.suppress(OSError, ValueError), process.stdout:
            for line in process.stdout:
                self._answers.put(line)
        self._answers.put(b"")

    def _answer(self, timeout: float) -> dict[str, Any] | None:
        try:
            line = self._answers.get(timeout=timeout)
            found: Any = json.loads(line)
        except (Empty, ValueError):
            return None
        return cast("dict[str, Any]", found) if isinstance(found, dict) else None

    @staticmethod
    def _write(process: subprocess.Popen[bytes], body: dict[str, Any]) -> None:
        assert process.stdin is not None
        with contextlib.suppress(OSError, ValueError):
            process.stdin.write(json.dumps(body).encode() + b"\n")
            process.stdin.flush()

    def tell(self, body: dict[str, Any]) -> None:
        """Renew what the session says of itself; sent only when it changed."""
        if body != self._said:
            self._said = body
            self._write(self._process, body)

    def poll(self, carry_out: Callable[[Command], None]) -> None:
        """Carry out the commands that came, and start the server again if it is gone."""
        while not self._answers.empty():
            line = self._answers.get()
            if line.startswith(b'{"port"') or not line.strip():
                continue
            with contextlib.suppress(CommandError):
                carry_out(parse(line.strip(), self._limits))
        if self._process.poll() is not None:
            self._drop()
            self.restarts += 1
            self._process = self._start()

    def _drop(self) -> None:
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()
        self._process.wait()

    def close(self) -> None:
        """End the server."""
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._listener.join(1.0)


# --- the server's side ------------------------------------------------------------------------------------------------


def main() -> int:
    """Read the setting, serve until standard input ends; returns the exit code."""
    # Not through the buffer of sys.stdin, which would keep what follows the line from the event loop.
    with open(sys.stdin.fileno(), "rb", buffering=0, closefd=False) as raw:
        line = raw.readline()
    if not line:
        return 0
    try:
        return asyncio.run(_serve(json.loads(line)))
    except ImportError as error:
        _say({"problem": f"{error.name} is not installed", "remedy": "pip install 'erclutch[live]'"})
    except ErclutchError as error:
        _say({"problem": error.problem, "remedy": error.remedy})
    except OSError as error:
        _say({"problem": error.strerror or str(error), "remedy": "Give another --port"})
    return 2


def _say(body: dict[str, Any]) -> None:
    with contextlib.suppress(OSError):
        os.write(sys.stdout.fileno(), json.dumps(body).encode() + b"\n")


def _bound(port: int) -> socket.socket:
    """A socket that listens on this machine's own address, and no other."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if os.name == "posix":  # elsewhere it would let two servers share a port
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(("127.0.0.1", port))
        found.listen(64)
    except OSError:
        found.close()
        raise
    return found


async def _serve(setting: dict[str, Any]) -> int:
    import uvicorn

    from erclutch.live.page.server import LONGEST_MESSAGE, Desk, Page

    limits = Limits(tuple(setting["names"]), float(setting["motor"]))
    listening = _bound(int(setting["port"]))
    access = Access(listening.getsockname()[1], setting["token"])
    desk = Desk(
        setting["ring"],
        limits,
        lambda command: _hand_over(command, limits),
        setting["programs"],
        setting["stroke"],
        setting["lead"],
    )
    page = Page(desk, access)
    config = uvicorn.Config(
        page.app,
        lifespan="off",
        log_config=None,
        access_log=False,
        http="h11",
        ws="websockets-sansio",
        ws_max_size=LONGEST_MESSAGE,
        ws_per_message_deflate=False,
        limit_concurrency=64,
        h11_max_incomplete_event_size=16384,
        server_header=False,
        timeout_graceful_shutdown=1,
    )
    server = _Server(config)
    listener = asyncio.create_task(_listen_to_session(desk, page, server))
    watcher = asyncio.create_task(page.watch())
    _say({"port": access.port})
    try:
        await server.serve(sockets=[listening])
    finally:
        for task in (listener, watcher):
            task.cancel()
        await asyncio.gather(listener, watcher, return_exceptions=True)
    return 0


def _Server(config: Any) -> Any:
    """Uvicorn's server without its signal handlers: SIGINT is the session's business, and it closes our input."""
    import signal

    import uvicorn

    class Server(uvicorn.Server):
        @contextlib.contextmanager
        def capture_signals(self) -> Any:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            yield

    return Server(config)


def _hand_over(command: Command, limits: Limits) -> None:
    with contextlib.suppress(OSError):
        os.write(sys.stdout.fileno(), command.to_message(limits) + b"\n")


async def _listen_to_session(desk: Any, page: Any, server: Any) -> None:
    """State of the session, line by line; its notes go into the log of events."""
    reader = asyncio.StreamReader(limit=1 << 20)
    loop = asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    told = 0
    try:
        while line := await reader.readline():
            body: Any = json.loads(line)
            notes: list[tuple[int, int, str, str]] = body.pop("notes", [])
            desk.session = body
            for number, at, text, level in notes:
                if number >= told:
                    page.watcher.say(text, at, level)
                    told = number + 1
    finally:
        transport.close()
        server.should_exit = True


if __name__ == "__main__":
    sys.exit(main())
