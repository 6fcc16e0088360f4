"""The server answers requests to this machine by name, from a page of this server, with the session's token.

A foreign page cannot reach the server by a name of its own (Host), nor speak to it from the browser (Origin), and no
other user of the machine knows the token. The token comes once in the printed address; then it is a cookie that scripts
cannot read.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

HEADERS: Mapping[str, str] = {
    "cache-control": "no-store",
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
}


def new_token() -> str:
    """256 random bits as text."""
    return secrets.token_urlsafe(32)


@dataclass(frozen=True)
class Access:
    """The rules of one server.

    Attributes:
        port: that it listens on.
        token: that it asks for.
    """

    port: int
    token: str

    @property
    def cookie(self) -> str:
        """Name of the cookie; cookies of one host are shared by all its ports, so it carries the port."""
        return f"erclutch-{self.port}"

    @property
    def url(self) -> str:
        """What to open."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    def _hosts(self) -> tuple[str, ...]:
        return (f"127.0.0.1:{self.port}", f"localhost:{self.port}")

    def from_here(self, headers: list[tuple[str, str]], *, socket: bool) -> bool:
        """Whether Host and Origin are ours. A browser's socket or form always has an Origin; a request may not."""
        hosts = [value for name, value in headers if name == "host"]
        origins = [value for name, value in headers if name == "origin"]
        if len(hosts) != 1 or hosts[0] not in self._hosts() or len(origins) > 1:
            return False
        if not origins:
            return not socket
        return origins[0] in {f"http://{host}" for host in self._hosts()}

    def by_cookie(self, headers: list[tuple[str, str]]) -> bool:
        """Whether the cookie holds the token."""
        for name, value in headers:
            with suppress(CookieError):
                found = SimpleCookie(value).get(self.cookie) if name == "cookie" else None
                if found is not None and self._same(found.value):
                    return True
        return False

    def by_query(self, query: str) -> bool:
        """Whether the address holds the token."""
        try:
            given = parse_qs(query, max_num_fields=4).get("token", [])
        except ValueError:
            return False
        return len(given) == 1 and self._same(given[0])

    def _same(self, given: str) -> bool:
        return hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())

    def set_cookie(self) -> str:
        """Header that gives the browser the token for the session's time."""
        return f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
