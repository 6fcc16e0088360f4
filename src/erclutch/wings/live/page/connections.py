"""Connections of strangers are few and short, however many come at once; the owner of the token gets through."""

from __future__ import annotations

import asyncio
import logging
import socket
from typing import Any
from weakref import WeakValueDictionary

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

_MOST_STRANGERS = 64
_PATIENCE = 3.0  # s that a connection has to show the token
#: Connections that the server takes at once, before it reads any. Far fewer than strangers may be: what a new
#: connection says is read before others can have taken its place.
_AT_ONCE = 8
_WAITING = 128  # connections that the system holds until the server takes them
_MOST = 256  # connections in all; strangers and eight pages have fewer


class Strangers:
    """Connections that have not shown the token. Each has a few seconds, and the oldest makes room for a new one."""

    def __init__(self) -> None:
        self._transports: dict[Any, asyncio.Transport] = {}
        self._known: WeakValueDictionary[Any, asyncio.Transport] = WeakValueDictionary()

    def add(self, client: Any, transport: asyncio.Transport) -> None:
        """Count a new connection."""
        if len(self._transports) >= _MOST_STRANGERS:
            oldest = next(iter(self._transports))
            self._drop(oldest, self._transports[oldest])
        self._transports[client] = transport
        asyncio.get_running_loop().call_later(_PATIENCE, self._drop, client, transport)

    def shown(self, client: Any) -> None:
        """A client showed the token."""
        transport = self._transports.pop(client, None)
        if transport is not None:
            self._known[client] = transport

    def gone(self, client: Any) -> None:
        """A connection ended."""
        self._transports.pop(client, None)

    def hang_up(self, client: Any) -> None:
        """End the connection of a client that showed the token, whatever it has still to read."""
        transport = self._known.pop(client, None)
        if transport is not None:
            transport.abort()

    def _drop(self, client: Any, transport: asyncio.Transport) -> None:
        if self._transports.get(client) is transport:
            del self._transports[client]
            transport.abort()


class ListeningSocket(socket.socket):
    """A socket on this machine's own address, which has room for many connections while few are taken at once."""

    def __init__(self, port: int) -> None:
        super().__init__(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self.bind(("127.0.0.1", port))
            self.listen()
        except BaseException:
            self.close()
            raise

    def listen(self, backlog: int = _WAITING, /) -> None:
        """Listen. asyncio has one number for connections that wait and for those that it takes at once."""
        super().listen(max(backlog, _WAITING))

    @property
    def port(self) -> int:
        """Port that it listens on."""
        return self.getsockname()[1]


def server_of(app: Any, strangers: Strangers, **further: Any) -> Any:
    """Uvicorn's server of an application whose guard counts these strangers."""
    logger = logging.getLogger("uvicorn")
    if not logger.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(_OneLine())
        logger.addHandler(handler)
        logger.setLevel(logging.WARNING)
    config = uvicorn.Config(
        app,
        http=counted_connection(strangers),
        lifespan="off",
        log_config=None,
        access_log=False,
        server_header=False,
        backlog=_AT_ONCE,
        limit_concurrency=_MOST,
        h11_max_incomplete_event_size=16384,
        timeout_graceful_shutdown=1,
        **further,
    )
    return uvicorn.Server(config)


class _OneLine(logging.Formatter):
    """A line for what a client did wrong, without a traceback: the client chooses how often."""

    def format(self, record: logging.LogRecord) -> str:
        """What happened, and the error that it was."""
        said = record.getMessage().strip()
        error: Any = record.exc_info[1] if record.exc_info else None
        error = getattr(error, "exceptions", (error,))[0]  # of a group the first
        if error is None:
            return f"page: {said}"
        return f"page: {said} {type(error).__name__}: {error}"


def counted_connection(strangers: Strangers) -> Any:
    """Uvicorn's class of a connection, each of which is a stranger until it shows the token."""

    class Connection(H11Protocol):
        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            strangers.add(self.client, transport)

        def connection_lost(self, exc: Exception | None) -> None:
            super().connection_lost(exc)
            strangers.gone(self.client)

    return Connection
