"""The page's server offers a few fixed files, and one socket that sends frames and state and takes commands."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from importlib.resources import files
from pathlib import PurePath
from typing import Any

from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from erclutch._version import __version__
from erclutch.wings.live.layout import EVENTS
from erclutch.wings.live.page.access import HEADERS, Access
from erclutch.wings.live.page.connections import Strangers
from erclutch.wings.live.page.ring_summary import EDGES, Watcher, level_of
from erclutch.wings.live.page.wire import as_text, pack, wire_of
from erclutch.wings.live.page_commands import LONGEST, CommandError, CommandLimits, parse
from erclutch.wings.live.ring import RingReader

RATE = 60.0  # messages of frames a second
_STATUS = 0.25  # s
_LOOK = 0.05  # s
_MOST_CLIENTS = 8
#: Code of a socket that made room for that of a newer page: its page does not open another.
_MADE_ROOM = 4001
_FAREWELL = 1.0  # s that a client has to take in that its socket is closed
_MOST_FRAMES = 2000  # in one message; a client that fell behind further starts anew at the newest
_SHARE = 20  # commands a second from one client
#: Longest message that a client may send; the socket is closed on a longer one.
LONGEST_MESSAGE = 4 * LONGEST

_KINDS = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
_SCRIPTS = (
    "live",
    "axis_ticks",
    "charts",
    "connection",
    "elements",
    "histogram",
    "number_texts",
    "picture",
    "screen_clock",
    "status_panel",
    "store",
)
_STATIC = ("live.css", "icon.svg", *(f"{name}.js" for name in _SCRIPTS))
_FILES = {
    "/": "wings/live/page/static/index.html",
    **{f"/{name}": f"wings/live/page/static/{name}" for name in _STATIC},
    "/uPlot.css": "report/assets/uplot/uPlot.min.css",
    "/uPlot.js": "report/assets/uplot/uPlot.iife.min.js",
}

_STATIC_FILES = files("erclutch") / "wings/live/page/static"
#: What a browser gets before it has shown the token.
_ENTRANCE: Mapping[str, tuple[str, str]] = {
    "/": ("enter.html", "text/html"),
    "/enter.js": ("enter.js", "text/javascript"),
}

_ENTRANCE_POLICY = (
    "default-src 'none'; script-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)


class Page:
    """The application of one session.

    Args:
        ring: path of the ring.
        limits: of commands.
        access: who gets an answer.
        hand_over: takes the text of each command that was checked.
        shown: what a page is told of its session besides the ring's header, as JSON values.

    Attributes:
        session: state of the session that the ring does not tell, as JSON values; the session renews it.
    """

    def __init__(
        self,
        ring: str,
        limits: CommandLimits,
        access: Access,
        hand_over: Callable[[str], None],
        shown: Mapping[str, Any],
    ) -> None:
        self._ring, self._limits, self._hand_over, self._shown = ring, limits, hand_over, shown
        self.session: dict[str, Any] = {}
        self.watcher = Watcher(RingReader(ring, "oldest"))
        # The oldest first; each is set where its client has to go.
        self._clients: deque[asyncio.Event] = deque()
        routes = [Route(path, self._file(name)) for path, name in _FILES.items()]
        sockets = WebSocketRoute("/frames", self._socket)
        self.app = Guard(Starlette(routes=[*routes, sockets]), access)

    @staticmethod
    def _file(name: str) -> Callable[[Request], Awaitable[Response]]:
        data = (files("erclutch") / name).read_bytes()
        kind = _KINDS[PurePath(name).suffix]

        async def answer(request: Request) -> Response:
            return Response(data, media_type=kind)

        return answer

    async def watch(self) -> None:
        """Follow the ring for as long as the server runs."""
        while True:
            self.watcher.look()
            await asyncio.sleep(_LOOK)

    def hello(self) -> dict[str, Any]:
        """What a client needs to know once."""
        info = self.watcher.reader.info
        return {
            "kind": "hello",
            "version": __version__,
            "session": f"{info.start_unix_ns}",
            "rig": info.rig,
            "origin": info.origin,
            "model": info.model,
            "digest": info.digest,
            "note": info.note,
            "period": info.period_ns * 1e-9,
            "field_limit": info.field_limit,
            "motor_limit": self._limits.motor,
            **self._shown,
            "edges": list(EDGES),
            "events": [[name, text, level_of(name)] for name, text in EVENTS],
            "channels": [asdict(channel) for channel in info.channels],
            "wire": wire_of(info),
        }

    async def _socket(self, socket: WebSocket) -> None:
        """Serve one client. The oldest makes room for one too many: whoever opens a page is never shut out."""
        while len(self._clients) >= _MOST_CLIENTS:
            self._clients.popleft().set()
        leave = asyncio.Event()
        self._clients.append(leave)
        await socket.accept()
        try:
            await socket.send_text(as_text(self.hello()))
            async with asyncio.TaskGroup() as group:
                for job in (self._frames, self._states, self._commands):
                    group.create_task(job(socket))
                group.create_task(self._farewell(socket, leave))
        except* (WebSocketDisconnect, RuntimeError, OSError):
            pass  # the page is gone, and with it the other jobs
        finally:
            if leave in self._clients:
                self._clients.remove(leave)

    async def _farewell(self, socket: WebSocket, leave: asyncio.Event) -> None:
        """Close a client's socket when it has to make room, though it reads nothing any more."""
        await leave.wait()
        with suppress(TimeoutError):
            async with asyncio.timeout(_FAREWELL):
                await socket.close(_MADE_ROOM)
        loop = asyncio.get_running_loop()
        loop.call_later(_FAREWELL, self.app.strangers.hang_up, socket.scope["client"])
        raise WebSocketDisconnect

    async def _frames(self, socket: WebSocket) -> None:
        """Frames as they come; a client that cannot follow loses the oldest and is told how many."""
        reader = RingReader(self._ring)
        dropped = 0
        loop = asyncio.get_running_loop()
        due = loop.time()
        try:
            while True:
                frames = reader.read()
                if frames.size > _MOST_FRAMES:
                    dropped += frames.size - _MOST_FRAMES
                    frames = frames[-_MOST_FRAMES:]
                if frames.size:
                    await socket.send_bytes(pack(frames, reader.info, reader.lost + dropped))
                due = max(due + 1 / RATE, loop.time())
                await asyncio.sleep(due - loop.time())
        finally:
            reader.close()

    async def _states(self, socket: WebSocket) -> None:
        seen = 0
        while True:
            body = {
                "kind": "status",
                **self.watcher.status(),
                "clients": len(self._clients),
                **self.session,
            }
            body["lines"] = self.watcher.lines(seen)
            seen = self.watcher.version
            await socket.send_text(as_text(body))
            await asyncio.sleep(_STATUS)

    async def _commands(self, socket: WebSocket) -> None:
        """Hand over what is a command; answer what is not, and hang up on a client that sends too many."""
        loop = asyncio.get_running_loop()
        credit = float(_SHARE)
        last = loop.time()
        while True:
            message = await socket.receive()
            if message["type"] != "websocket.receive":
                raise WebSocketDisconnect
            now = loop.time()
            credit = min(_SHARE, credit + (now - last) * _SHARE) - 1
            last = now
            if credit < 0:
                await socket.close(1008)
                raise WebSocketDisconnect
            text = message.get("text")
            if text is None:
                await socket.send_text(as_text({"kind": "refused", "why": "A command is text"}))
                continue
            try:
                command = parse(text, self._limits)
            except CommandError as error:
                await socket.send_text(as_text({"kind": "refused", "why": str(error)}))
                continue
            self._hand_over(text)
            await socket.send_text(as_text({"kind": "taken", "command": command.kind}))


class Guard:
    """Answers nobody else than `Access` lets in, whatever is asked for.

    Args:
        app: what answers.
        access: who gets an answer.
        headers: of each answer that does not say otherwise.
        command: that printed the address.
    """

    def __init__(
        self,
        app: Starlette,
        access: Access,
        headers: Mapping[str, str] = HEADERS,
        command: str = "erclutch live",
    ) -> None:
        self._app, self._access, self._headers, self._command = app, access, headers, command
        self.strangers = Strangers()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or socket (ASGI)."""
        if scope["type"] == "http":
            await self._http(scope, receive, _with_headers(send, self._headers, self._access.base))
        elif scope["type"] == "websocket":
            headers = _headers(scope)
            path = self._below(scope)
            is_from_here = self._access.from_here(headers, socket=True)
            if path is not None and is_from_here and self._may(headers):
                self.strangers.shown(scope["client"])
                await self._app({**scope, "path": path}, receive, send)
            else:
                await receive()
                await send({"type": "websocket.close", "code": 1008})

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = _headers(scope)
        method = str(scope["method"])
        path = str(scope["path"])
        changes = method not in ("GET", "HEAD")
        below = self._below(scope)
        alone = None if changes else self._access.alone_path(path)
        if not self._access.from_here(headers, socket=changes):
            answer: Response = PlainTextResponse("Only for this machine.\n", 403)
        elif not changes and path in _ENTRANCE:
            # For everybody: it holds no secret, and its script brings the token.
            name, kind = _ENTRANCE[path]
            own = {**HEADERS, "content-security-policy": _ENTRANCE_POLICY}
            answer = Response((_STATIC_FILES / name).read_bytes(), headers=own, media_type=kind)
        elif method == "POST" and path == "/enter" and self._enters(headers):
            self.strangers.shown(scope["client"])
            headers_of_answer = {"set-cookie": self._access.set_cookie()}
            answer = JSONResponse({"to": f"{self._access.base}/"}, headers=headers_of_answer)
        elif alone is not None or (below is not None and self._may(headers)):
            self.strangers.shown(scope["client"])
            await self._app({**scope, "path": below or alone}, receive, send)
            return
        else:
            answer = PlainTextResponse(
                f"Open the address that {self._command} printed; it holds a token.\n", 403
            )
        await answer(scope, receive, send)

    def _below(self, scope: Scope) -> str | None:
        """The path below the session's own; None for any other."""
        path = str(scope["path"])
        if path.startswith(f"{self._access.base}/"):
            return path.removeprefix(self._access.base)
        return None

    def _may(self, headers: list[tuple[str, str]]) -> bool:
        return self._access.by_own_page(headers) and self._access.by_cookie(headers)

    def _enters(self, headers: list[tuple[str, str]]) -> bool:
        return self._access.by_own_page(headers) and self._access.by_token(headers)


def _headers(scope: Scope) -> list[tuple[str, str]]:
    return [
        (name.decode("latin-1").lower(), value.decode("latin-1"))
        for name, value in scope["headers"]
    ]


def _with_headers(send: Send, headers: Mapping[str, str], base: str) -> Send:
    """Sends each answer with these headers where it has none of the name; it stays below the session's path."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            given = MutableHeaders(scope=message)
            for name, value in headers.items():
                given.setdefault(name, value)
            if given.get("location", "").startswith("/"):
                given["location"] = base + given["location"]
        await send(message)

    return sent
