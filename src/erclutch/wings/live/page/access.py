"""The server answers requests to this machine by name, from a page of this server, with the session's token.

A foreign page cannot reach the server by a name of its own (Host), nor speak to it from the browser (Origin,
Sec-Fetch-Site), and no other user of the machine knows the token. The printed address holds the token behind its #,
which no browser sends: a script shows it once, in a header, and gets a cookie.

A browser sends a cookie to every port of a host. So the cookie is for one path alone, which holds the port and a
secret: a server at another port is never asked for that path, and never sees the cookie. Path, cookie and token are
three secrets; none of them tells another.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
from base64 import urlsafe_b64encode
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie

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
#: Header in which the first page shows the token.
TOKEN_HEADER = "x-erclutch-token"


def new_token() -> str:
    """256 random bits as text."""
    return secrets.token_urlsafe(32)


@dataclass(frozen=True)
class Access:
    """The rules of one server. A server that is started again with its token keeps its paths and cookies.

    Attributes:
        port: that it listens on.
        token: that it asks for.
    """

    port: int
    token: str

    @property
    def cookie(self) -> str:
        """Name of the cookie."""
        return f"erclutch-{self.port}"

    @property
    def url(self) -> str:
        """What to open."""
        return f"http://127.0.0.1:{self.port}/#token={self.token}"

    @property
    def base(self) -> str:
        """Path below which all is; the cookie is sent there alone."""
        return f"/{self.port}-{self._secret('path')}"

    def alone_place(self, path: str) -> str:
        """What stands before a path that needs no cookie: who runs in that page learns nothing but this path."""
        return f"/{self.port}-alone-{self._secret(f'alone {path}')}"

    def alone_path(self, path: str) -> str | None:
        """The path behind its `alone_place`; None for any other."""
        place, slash, rest = path.removeprefix("/").partition("/")
        if self._same(f"/{place}", self.alone_place(slash + rest)):
            return slash + rest
        return None

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

    def by_own_page(self, headers: list[tuple[str, str]]) -> bool:
        """Whether a page of ours asks, or somebody who types; another port of this machine is another page."""
        return all(
            value in ("same-origin", "none") for name, value in headers if name == "sec-fetch-site"
        )

    def by_cookie(self, headers: list[tuple[str, str]]) -> bool:
        """Whether the cookie is the session's."""
        for name, value in headers:
            with suppress(CookieError):
                cookie = SimpleCookie(value).get(self.cookie) if name == "cookie" else None
                if cookie is not None and self._same(cookie.value, self._secret("cookie")):
                    return True
        return False

    def by_token(self, headers: list[tuple[str, str]]) -> bool:
        """Whether a header shows the token."""
        given = [value for name, value in headers if name == TOKEN_HEADER]
        return len(given) == 1 and self._same(given[0], self.token)

    def _secret(self, use: str) -> str:
        words = use.encode("utf-8", "surrogateescape")
        digest = hmac.new(self.token.encode(), words, hashlib.sha256).digest()
        return urlsafe_b64encode(digest[:24]).decode()

    @staticmethod
    def _same(given: str, right: str) -> bool:
        return hmac.compare_digest(
            given.encode("utf-8", "replace"), right.encode("utf-8", "replace")
        )

    def set_cookie(self) -> str:
        """Header that gives the browser the session's cookie."""
        return (
            f"{self.cookie}={self._secret('cookie')}; Path={self.base}/; HttpOnly; SameSite=Strict"
        )
