"""The page's server: a few fixed files, and one socket that sends frames and state and takes commands."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from erclutch._version import __version__
from erclutch.live.commands import LONGEST, Command, CommandError, Limits, parse
from erclutch.live.frame import EVENTS, FLAGS, RingReader
from erclutch.live.page.access import HEADERS, Access
from erclutch.live.page.watcher import ALARMS, EDGES, NOTES, Watcher
from erclutch.live.page.wire import pack

RATE = 60.0  # messages of frames a second
_STATUS = 0.25  # s
_LOOK = 0.05  # s
_MOST_CLIENTS = 8
_MOST_FRAMES = 2000  # in one message; a client that fell behind further starts anew at the newest
_SHARE = 20  # commands a second from one client

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

_FILES = {
    "/": ("live/page/static/index.html", "text/html; charset=utf-8"),
    "/live.css": ("live/page/static/live.css", "text/css; charset=utf-8"),
    "/live.js": ("live/page/static/live.js", "text/javascript; charset=utf-8"),
    "/store.js": ("live/page/static/store.js", "text/javascript; charset=utf-8"),
    "/charts.js": ("live/page/static/charts.js", "text/javascript; charset=utf-8"),
    "/picture.js": ("live/page/static/picture.js", "text/javascript; charset=utf-8"),
    "/icon.svg": ("live/page/static/icon.svg", "image/svg+xml"),
    "/uPlot.css": ("vendor/uplot/uPlot.min.css", "text/css; charset=utf-8"),
    "/uPlot.js": ("vendor/uplot/uPlot.iife.min.js", "text/javascript; charset=utf-8"),
}


@dataclass
class Desk:
    """What the page knows of its session, and how its commands leave.

    Attributes:
        ring: path of the ring.
        limits: of commands.
        hand_over: takes each checked command.
        programs: for people, one a program: name and what it does.
        stroke: how far the output may go either way in rad; 0 if nobody knows.
        lead: of the screw in m; 0 if there is none.
        session: state of the session that the ring does not tell, as JSON values; the session renews it.
    """

    ring: str
    limits: Limits
    hand_over: Callable[[Command], None]
    programs: list[dict[str, str]] = field(default_factory=list[dict[str, str]])
    stroke: float = 0.0
    lead: float = 0.0
    session: dict[str, Any] = field(default_factory=dict[str, Any])


class Page:
    """The application of one session.

    Args:
        desk: the session.
        access: who gets an answer.
    """

    def __init__(self, desk: Desk, access: Access) -> None:
        self.desk, self.access = desk, access
        self.watcher = Watcher(RingReader(desk.ring, "oldest"))
        self.clients = 0
        routes = [Route(path, self._file(*entry)) for path, entry in _FILES.items()]
        self.app = Guard(Starlette(routes=[*routes, WebSocketRoute("/frames", self._socket)]), access)

    @staticmethod
    def _file(name: str, kind: str) -> Callable[[Request], Awaitable[Response]]:
        data = (files("erclutch") / name).read_bytes()

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
        levels = [("alarm" if n in ALARMS else "note" if n in NOTES else "warning") for n, _ in EVENTS]
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
            "motor_limit": self.desk.limits.motor,
            "stroke": self.desk.stroke,
            "lead": self.desk.lead,
            "programs": self.desk.programs,
            "edges": list(EDGES),
            "events": [[n, text, level] for (n, text), level in zip(EVENTS, levels, strict=True)],
            "flags": [list(pair) for pair in FLAGS],
        }

    async def _socket(self, socket: WebSocket) -> None:
        if self.clients >= _MOST_CLIENTS:
            await socket.close(1013)
            return
        self.clients += 1
        await socket.accept()
        try:
            await socket.send_json(self.hello())
            tasks = [
                asyncio.create_task(job) for job in (self._frames(socket), self._states(socket), self._commands(socket))
            ]
            try:
                done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for task in tasks:
                    task.cancel()
                await asyncio.gather(*tasks, return_exceptions=True)
            for task in done:
                error = task.exception()
                if error is not None and not isinstance(error, (WebSocketDisconnect, RuntimeError, OSError)):
                    raise error
        finally:
            self.clients -= 1

    async def _frames(self, socket: WebSocket) -> None:
        """Frames as they come; a client that cannot follow loses the oldest and is told how many."""
        reader = RingReader(self.desk.ring)
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
            body = {"kind": "status", **self.watcher.status(), "clients": self.clients, **self.desk.session}
            body["lines"] = self.watcher.lines(seen)
            seen = self.watcher.version
            await socket.send_json(body)
            await asyncio.sleep(_STATUS)

    async def _commands(self, socket: WebSocket) -> None:
        """Hand over what is a command; answer what is not, and hang up on a client that sends too many."""
        loop = asyncio.get_running_loop()
        credit, last = float(_SHARE), loop.time()
        while True:
            message = await socket.receive()
            if message["type"] != "websocket.receive":
                return
            now = loop.time()
            credit, last = min(_SHARE, credit + (now - last) * _SHARE) - 1, now
            if credit < 0:
                await socket.close(1008)
                return
            text = message.get("text")
            if text is None:
                await socket.send_json({"kind": "refused", "why": "A command is text"})
                continue
            try:
                command = parse(text, self.desk.limits)
            except CommandError as error:
                await socket.send_json({"kind": "refused", "why": str(error)})
                continue
            self.desk.hand_over(command)
            await socket.send_json({"kind": "taken", "command": command.kind})


class Guard:
    """Answers nobody else than `Access` lets in, whatever is asked for."""

    def __init__(self, app: Starlette, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or socket (ASGI)."""
        if scope["type"] == "http":
            await self._http(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            if self._access.from_here(_headers(scope), socket=True) and self._access.by_cookie(_headers(scope)):
                await self._app(scope, receive, send)
            else:
                await receive()
                await send({"type": "websocket.close", "code": 1008})

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = _headers(scope)
        if not self._access.from_here(headers, socket=False):
            await PlainTextResponse("Only for this machine.\n", 403)(scope, receive, send)
        elif scope["path"] == "/" and self._access.by_query(scope["query_string"].decode("latin-1")):
            answer = RedirectResponse("/", 303, {"set-cookie": self._access.set_cookie()})
            await answer(scope, receive, send)
        elif self._access.by_cookie(headers):
            await self._app(scope, receive, send)
        else:
            text = "Open the address that erclutch live printed; it holds a token.\n"
            await PlainTextResponse(text, 403)(scope, receive, send)


def _headers(scope: Scope) -> list[tuple[str, str]]:
    return [(name.decode("latin-1").lower(), value.decode("latin-1")) for name, value in scope["headers"]]


def _with_headers(send: Send) -> Send:
    async def sent(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            own = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
            message["headers"] = [*message.get("headers", []), *own]
        await send(message)

    return sent


#: Longest message that a client may send; the socket is closed on a longer one.
LONGEST_MESSAGE = 4 * LONGEST
