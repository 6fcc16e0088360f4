"""The page's server: who gets an answer, what reaches the loop, and that it comes back."""

from __future__ import annotations

import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from erclutch.wings.live.companions import Observers
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.page.access import TOKEN_HEADER, Access
from erclutch.wings.live.page.page_process import PageError, PageProcess
from erclutch.wings.live.page.wire import pack, wire_of
from erclutch.wings.live.page_commands import (
    LONGEST,
    CommandError,
    CommandLimits,
    PageCommand,
    parse,
)
from erclutch.wings.live.ring import RingInfo, State
from tests.support.examples import examples

pytestmark = pytest.mark.timed

LIMITS = CommandLimits(("rest", "sine", "step"), 0.95)
PROGRAMS = [(name, f"what {name} does", "") for name in LIMITS.programs]


# --- commands ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("message", "command"),
    [
        ('{"command": "zero"}', PageCommand("zero")),
        ('{"command": "reset"}', PageCommand("reset")),
        ('{"command": "program", "name": "step"}', PageCommand("program", 2.0)),
        ('{"command": "motor",\n "torque": -0.95}', PageCommand("motor", -0.95)),
        ('{"command": "record", "on": true}', PageCommand("record", 1.0)),
    ],
)
def test_a_command_is_read_as_it_was_meant(message: str, command: PageCommand) -> None:
    assert parse(message, LIMITS) == parse(message.encode(), LIMITS) == command


@pytest.mark.parametrize(
    "message",
    [
        b"", b"null", b"[]", b"{}", b'{"command": "stop"}', b'{"command": ["zero"]}', b'{"command": "zero", "x": 1}',
        b'{"command": "program"}', b'{"command": "program", "name": "none"}', b'{"command": "program", "name": 1}',
        b'{"command": "motor", "torque": 0.96}', b'{"command": "motor", "torque": NaN}',
        b'{"command": "motor", "torque": Infinity}', b'{"command": "motor", "torque": true}',
        b'{"command": "motor", "torque": "0.1"}', b'{"command": "motor", "torque": 1e999}',
        b'{"command": "motor", "torque": ' + b"9" * 150 + b"}", b'{"command": "record", "on": 1}',
        b'{"command": "record", "on": true, "path": "/etc/passwd"}', b'{"command": "zero"}' + b" " * LONGEST,
        b"[" * 200, b'{"command": "zero"} {"command": "zero"}', b"\xff\xfe",
    ],
)  # fmt: skip
def test_what_is_no_command_is_refused(message: bytes) -> None:
    with pytest.raises(CommandError):
        parse(message, LIMITS)


_WORDS = st.sampled_from(
    ["command", "zero", "reset", "program", "motor", "record", "name", "torque", "on", "step"]
)
_VALUES: Any = st.recursive(
    _WORDS | st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_WORDS, inner, max_size=3),
    max_leaves=4,
)


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(
    st.binary(max_size=300)
    | st.dictionaries(_WORDS, _VALUES, max_size=4).map(lambda body: json.dumps(body).encode())
)
@example(b'{"command": "motor", "torque": -0.0}')
def test_nothing_but_commands_in_range_gets_through(message: bytes) -> None:
    try:
        command = parse(message, LIMITS)
    except CommandError:
        return
    assert command.kind in ("zero", "reset", "program", "motor", "record")
    largest = {"program": 2.0, "motor": 0.95, "record": 1.0}.get(command.kind, 0.0)
    assert abs(command.value) <= largest
    assert command.kind == "motor" or command.value == int(command.value) >= 0


# --- frames on the wire -----------------------------------------------------------------------------------------------


def test_frames_on_the_wire(frames: Any) -> None:
    some = frames[100:130].copy()
    some["lateness_ns"][3] = 400_000
    some["time_ns"][3] += 370_000
    some["torque"][4] = 1e300
    info = RingInfo(start_ns=10**12)
    message, wire = pack(some, info, 7), wire_of(info)
    row = np.dtype(
        [(name, "<u4" if name in ("flags", "events") else "<f4") for name in wire["columns"]]
    )
    assert len(message) == wire["head"] + 30 * row.itemsize
    assert np.frombuffer(message, "<u4", 2).tolist() == [0, 7]
    assert np.frombuffer(message, "<f8", 2, 8).tolist() == [pytest.approx(0.1), 100.0]
    sent = np.frombuffer(message, row, 30, wire["head"])
    assert sent["time"] == pytest.approx(np.arange(30) * 1e-3, abs=1e-7)
    assert sent["lateness"][3] == 400.0
    assert np.isinf(sent["torque"][4])
    assert sent["field1"] == pytest.approx(some["field1"], rel=1e-6)
    assert (sent["flags"] == some["flags"]).all()
    assert (sent["theta"] < 2 * np.pi).all()


# --- access -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("headers", "file", "socket_"),
    [
        ([("host", "127.0.0.1:80")], True, False),
        ([("host", "localhost:80"), ("origin", "http://localhost:80")], True, True),
        ([("host", "127.0.0.1:80"), ("origin", "http://localhost:80")], True, True),
        ([("host", "evil.example:80"), ("origin", "http://evil.example:80")], False, False),
        ([("host", "127.0.0.1:80"), ("origin", "http://evil.example")], False, False),
        ([("host", "127.0.0.1:80"), ("origin", "null")], False, False),
        ([("host", "127.0.0.1:81")], False, False),
        ([("host", "127.0.0.1")], False, False),
        ([("host", "127.0.0.1:80"), ("host", "evil.example:80")], False, False),
        (
            [("host", "127.0.0.1:80"), ("origin", "http://127.0.0.1:80"), ("origin", "null")],
            False,
            False,
        ),
        ([("origin", "http://127.0.0.1:80")], False, False),
    ],
)
def test_host_and_origin(headers: list[tuple[str, str]], file: bool, socket_: bool) -> None:
    access = Access(80, "t")
    assert access.from_here(headers, socket=False) is file
    assert access.from_here(headers, socket=True) is socket_


@pytest.mark.slow
@settings(max_examples=examples(300), deadline=None)
@given(st.text(max_size=60))
def test_only_the_token_is_the_token(text: str) -> None:
    access = Access(80, "the token")
    assert access.by_token([("x-erclutch-token", text)]) is (text == "the token")
    assert access.by_cookie([("cookie", f"erclutch-80={text}; other=1")]) is False
    assert access.alone_path(f"/{text}") is None


# --- the server -------------------------------------------------------------------------------------------------------


class Site:
    """A running server and what came through it."""

    def __init__(self, loop: Any, folder: Path) -> None:
        self.loop = loop
        self.commands: list[PageCommand] = []
        self.observers = Observers(
            loop.path,
            self.commands.append,
            programs=PROGRAMS,
            motor_limit=0.95,
            folder=folder / "recordings",
        )
        assert self.observers.page is not None
        self.page = self.observers.page
        self.access = self.page.access
        self.cookie = self.access.set_cookie().partition(";")[0]

    def get(
        self,
        path: str,
        *,
        token: bool = True,
        method: str = "GET",
        bare: bool = False,
        **headers: Any,
    ) -> tuple[int, bytes, Any]:
        connection = http.client.HTTPConnection("127.0.0.1", self.access.port, timeout=10)
        own = {"Cookie": self.cookie} if token else {}
        try:
            connection.request(
                method, path if bare else self.access.base + path, headers={**own, **headers}
            )
            answer = connection.getresponse()
            return answer.status, answer.read(), answer.headers
        finally:
            connection.close()

    def connect(
        self, *, cookie: str | None = None, host: str = "", origin: str | None = "own"
    ) -> ClientConnection:
        address = f"127.0.0.1:{self.access.port}"
        headers = {"Cookie": self.cookie if cookie is None else f"{self.access.cookie}={cookie}"}
        with socket.create_connection(("127.0.0.1", self.access.port)) as raw:
            return connect(
                f"ws://{host or address}{self.access.base}/frames",
                sock=raw.dup(),
                origin=f"http://{address}" if origin == "own" else origin,  # type: ignore[arg-type]
                additional_headers=headers,
                max_size=1 << 24,
                max_queue=None,  # what a test does not read must not hold up the closing
            )


@pytest.fixture(scope="module")
def _shared(shared_loop: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    found = Site(shared_loop, tmp_path_factory.mktemp("site"))
    yield found
    found.observers.close()


@pytest.fixture
def site(_shared: Site) -> Site:
    """A server that a test leaves as it is."""
    _shared.commands.clear()
    return _shared


@pytest.fixture
def own_site(tmp_path: Path, start_loop: Callable[..., Any]) -> Iterator[Site]:
    """A server that a test may harm."""
    found = Site(start_loop(), tmp_path)
    yield found
    found.observers.close()


def texts(socket_: ClientConnection, kind: str, count: int = 1, seconds: float = 10.0) -> list[Any]:
    """The next text messages of a kind."""
    found: list[Any] = []
    limit = time.monotonic() + seconds
    while len(found) < count and time.monotonic() < limit:
        message = socket_.recv(timeout=seconds)
        if isinstance(message, str) and json.loads(message)["kind"] == kind:
            found.append(json.loads(message))
    return found


@pytest.mark.slow
def test_no_answer_without_the_token(site: Site) -> None:
    for path in ("/", "/live.js", "/uPlot.js", "/frames", "/none"):
        for bare in (False, True) if path != "/" else (False,):
            status, body, _ = site.get(path, token=bare, bare=bare)
            assert (status, b"erclutch live printed" in body) == (403, True), path
    own: dict[str, Any] = {"Origin": f"http://127.0.0.1:{site.access.port}"}
    right = site.access.token
    right_header: dict[str, Any] = {TOKEN_HEADER: right}
    for wrong in ("wrong", right[:-1], right + "x", ""):
        assert (
            site.get(
                "/enter", method="POST", bare=True, token=False, **{**own, TOKEN_HEADER: wrong}
            )[0]
            == 403
        )
    assert (
        site.get("/enter", method="POST", bare=True, token=False, **right_header)[0] == 403
    )  # no Origin
    good = site.cookie.partition("=")[2]
    for cookie in ("wrong", good[:-1], good + "x", right):
        with pytest.raises(InvalidStatus, match="403"):
            site.connect(cookie=cookie)


@pytest.mark.slow
def test_the_token_gives_a_cookie_for_one_path_alone(site: Site) -> None:
    """A browser sends a cookie to all ports of a host; to a path that no other server knows, it is never asked for."""
    own: dict[str, Any] = {
        "Origin": f"http://127.0.0.1:{site.access.port}",
        TOKEN_HEADER: site.access.token,
    }
    status, body, headers = site.get("/enter", method="POST", bare=True, token=False, **own)
    assert (status, json.loads(body)) == (200, {"to": f"{site.access.base}/"})
    cookie = headers["set-cookie"]
    assert {"HttpOnly", "SameSite=Strict", f"Path={site.access.base}/"} <= {
        part.strip() for part in cookie.split(";")
    }
    assert cookie.startswith(f"erclutch-{site.access.port}=")
    secrets = [
        cookie.partition("=")[2].partition(";")[0],
        site.access.base.partition("-")[2],
        site.access.token,
    ]
    assert len(set(secrets)) == 3
    for path, bare in (("/", True), ("/enter.js", True), ("/", False)):
        status, body, headers = site.get(path, bare=bare)
        assert status == 200
        assert not any(secret.encode() in body for secret in secrets)
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"


def fetched(site_of: str) -> dict[str, Any]:
    """The header by which a browser says whose page asks."""
    return {"Sec-Fetch-Site": site_of}


@pytest.mark.slow
@pytest.mark.parametrize("site_of", ["same-site", "cross-site"])
def test_nothing_for_a_page_of_another_port(site: Site, site_of: str) -> None:
    """A page of another port of this machine is of the same site: its cookie and its Origin may be ours."""
    assert site.get("/", **fetched("same-origin"))[0] == 200
    assert site.get("/", **fetched("none"))[0] == 200
    assert site.get("/", **fetched(site_of))[0] == 403
    own: dict[str, Any] = {
        "Origin": f"http://127.0.0.1:{site.access.port}",
        TOKEN_HEADER: site.access.token,
    }
    assert site.get("/enter", method="POST", bare=True, **own, **fetched(site_of))[0] == 403


def test_nothing_for_a_foreign_host_or_origin(site: Site) -> None:
    assert site.get("/", Host="evil.example")[0] == 403
    assert site.get("/", Host=f"evil.example:{site.access.port}")[0] == 403
    assert site.get("/", Origin="http://evil.example")[0] == 403
    for host, origin in (
        ("evil.example", "own"),
        ("", "http://evil.example"),
        ("", "null"),
        ("", None),
    ):
        with pytest.raises(InvalidStatus, match="403"):
            site.connect(host=host, origin=origin)


@pytest.mark.parametrize(
    "path",
    [
        "/../server.py", "/..%2f..%2fserver.py", "/static/../server.py", "//etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
        "/live.js/../../server.py", "/live.js%00.css", "/index.html", "/page/server.py", "/.git/config", "/live.js/",
    ],
)  # fmt: skip
def test_no_path_but_the_files_of_the_page(site: Site, path: str) -> None:
    assert site.get(path)[0] in (404, 307, 400)


def test_nothing_can_be_changed_by_a_request(site: Site) -> None:
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE"):
        assert site.get("/", method=method)[0] == 403  # without an Origin
        assert site.get("/", method=method, Origin=f"http://127.0.0.1:{site.access.port}")[0] == 405


def test_it_listens_on_this_machine_only(site: Site) -> None:
    mine = [
        line
        for line in Path("/proc/net/tcp").read_text(encoding="ascii").splitlines()
        if line.split()[3] == "0A"
    ]
    bound = [
        line.split()[1] for line in mine if line.split()[1].endswith(f":{site.access.port:04X}")
    ]
    assert bound == [f"0100007F:{site.access.port:04X}"]


def test_the_token_is_in_no_command_line(site: Site) -> None:
    assert site.access.token.encode() not in Path(f"/proc/{site.page.pid}/cmdline").read_bytes()


@pytest.mark.slow
def test_frames_and_state_arrive(site: Site) -> None:
    with site.connect() as client:
        (hello,) = texts(client, "hello")
        assert (hello["origin"], hello["model"], hello["motor_limit"]) == ("TWIN", "fnn-16", 0.95)
        assert [program["name"] for program in hello["programs"]] == list(LIMITS.programs)
        messages, seqs, wire = 0, [], hello["wire"]
        while len(seqs) < 1000:
            message = client.recv(timeout=10)
            if isinstance(message, bytes):
                messages += 1
                first = int(np.frombuffer(message, "<f8", 1, 16)[0])
                seqs += range(
                    first, first + (len(message) - wire["head"]) // (4 * len(wire["columns"]))
                )
        assert seqs == list(range(seqs[0], seqs[0] + len(seqs)))
        assert messages > 5  # 60 a second where the machine is free: the study measures
        site.loop.events = EVENT_BITS["overrun"] | EVENT_BITS["trip"]
        lines = [line for status in texts(client, "status", 4) for line in status["lines"]]
        assert {(line["name"], line["level"]) for line in lines} >= {
            ("overrun", "warning"),
            ("trip", "alarm"),
        }
        seen: list[Any] = []
        assert wait_for(
            lambda: bool(seen.extend(texts(client, "status")) or seen[-1]["state"] == "running")
        )
        assert seen[-1]["lateness"]["p50"] == pytest.approx(31, abs=2)
        assert seen[-1]["counts"] == {"overrun": 1, "trip": 1}


@pytest.mark.slow
def test_a_loop_that_is_silent_is_said_to_be(own_site: Site) -> None:
    with own_site.connect() as client:
        own_site.loop.stop()
        assert wait_for(lambda: texts(client, "status")[0]["state"] == "silent")
        own_site.loop.writer.put(state=State.STOPPED)
        assert wait_for(lambda: texts(client, "status")[0]["state"] == "stopped")


def wait_for(what: Callable[[], Any], seconds: float = 10.0) -> bool:
    limit = time.monotonic() + seconds
    while time.monotonic() < limit:
        if what():
            return True
        time.sleep(0.02)
    return False


def frames_seen(client: ClientConnection, count: int) -> list[int]:
    """The numbers of the next frames."""
    (hello,) = texts(client, "hello")
    wire, seqs = hello["wire"], list[int]()
    while len(seqs) < count:
        message = client.recv(timeout=10)
        if isinstance(message, bytes):
            first = int(np.frombuffer(message, "<f8", 1, 16)[0])
            rows = (len(message) - wire["head"]) // (4 * len(wire["columns"]))
            seqs += range(first, first + rows)
    return seqs


@pytest.mark.slow
def test_two_pages_at_once_beside_one_that_reads_nothing(site: Site) -> None:
    """Each sees all frames and gives orders; a page that hangs and one that dies hold up nobody."""
    hangs = socket.create_connection(("127.0.0.1", site.access.port))
    hangs.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    address = f"127.0.0.1:{site.access.port}"
    hangs.sendall(
        f"GET {site.access.base}/frames HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n"
        f"Cookie: {site.cookie}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n".encode()
    )
    with closing(hangs), site.connect() as first, site.connect() as second:
        for client in (first, second):
            seqs = frames_seen(client, 300)
            assert seqs == list(range(seqs[0], seqs[0] + len(seqs)))
        assert wait_for(lambda: texts(second, "status")[0]["clients"] == 3)
        first.send('{"command": "program", "name": "step"}')
        assert wait_for(lambda: len(site.commands) == 1)
        second.send('{"command": "zero"}')
        assert wait_for(lambda: len(site.commands) == 2)
        assert site.commands == [PageCommand("program", 2.0), PageCommand("zero")]
        first.socket.shutdown(socket.SHUT_RDWR)
        assert wait_for(lambda: texts(second, "status")[0]["clients"] == 2)
        assert texts(second, "status")[0]["state"] == "running"


def test_commands_go_through_and_nothing_else(site: Site) -> None:
    with site.connect() as client:
        client.send('{"command": "program",\n\r "name": "step"}')
        client.send('{"command": "motor", "torque": 2}')
        client.send('{"command": "nonsense"}')
        client.send(b'{"command": "zero"}')
        client.send('{"command": "zero"}')
        assert len(texts(client, "refused", 3)) == 3
        assert wait_for(lambda: len(site.commands) == 2)
        assert site.commands == [PageCommand("program", 2.0), PageCommand("zero")]


@pytest.mark.slow
def test_fuzzed_messages_never_reach_the_loop(site: Site) -> None:
    """1,500 messages over real sockets; the server answers each with a refusal or hangs up."""
    random = np.random.default_rng(5)
    base = b'{"command": "motor", "torque": 0.5}'
    sent = 0
    while sent < 1500:
        with suppress(ConnectionClosed), site.connect() as client:
            for _ in range(15):
                data = bytearray(base)
                for _ in range(random.integers(1, 5)):
                    data[random.integers(len(data))] = random.integers(256)
                text = bytes(data)
                with suppress(CommandError):
                    parse(text.decode("latin-1"), LIMITS)
                    continue  # it happens to be a command
                client.send(text if sent % 3 else text.decode("latin-1"))
                sent += 1
    time.sleep(0.3)
    assert site.commands == []
    assert site.page.restarts == 0
    assert site.get("/")[0] == 200


def test_an_oversized_message_is_refused(site: Site) -> None:
    with site.connect() as client:
        client.send('{"command": "zero"' + " " * 2000 + "}")
        with pytest.raises(ConnectionClosed) as caught:
            texts(client, "never", 1)
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.code == 1009
    assert site.commands == []


@pytest.mark.slow
def test_a_client_that_sends_too_much_is_hung_up_on(site: Site) -> None:
    def talk() -> None:
        with site.connect() as client:
            for _ in range(2000):
                client.send('{"command": "nonsense"}')
            texts(client, "never", 1)

    with pytest.raises(ConnectionClosed):
        talk()
    assert site.commands == []


@pytest.mark.slow
def test_raw_noise_does_not_bring_the_server_down(site: Site) -> None:
    random = np.random.default_rng(1)
    for k in range(50):
        with (
            suppress(OSError),
            socket.create_connection(("127.0.0.1", site.access.port), timeout=2) as raw,
        ):
            raw.sendall(
                random.bytes(200)
                if k % 2
                else b"GET / HTTP/1.1\r\n" + random.bytes(100) + b"\r\n\r\n"
            )
    with (
        suppress(OSError),
        socket.create_connection(("127.0.0.1", site.access.port), timeout=2) as raw,
    ):
        raw.sendall(b"GET / HTTP/1.1\r\nX: " + b"a" * 100_000)
    assert site.get("/")[0] == 200
    assert site.page.restarts == 0


@pytest.mark.slow
def test_half_open_connections_turn_no_page_away_and_are_dropped(site: Site) -> None:
    """Strangers that send half a request, or nothing; the last has come before the page asks."""
    with ExitStack() as stack:
        strangers: list[socket.socket] = []
        for k in range(300):
            raw = stack.enter_context(
                socket.create_connection(("127.0.0.1", site.access.port), timeout=5)
            )
            strangers.append(raw)
            with suppress(OSError):
                raw.sendall(b"GET / HTTP/1.1\r\nHost: " if k % 2 else b"")
        with site.connect() as client:
            assert site.get("/")[0] == 200
            assert texts(client, "status")
            for raw in strangers:
                with suppress(OSError):
                    assert raw.recv(1) == b""  # within the 5 s that the socket waits
            assert texts(client, "status")


@pytest.mark.slow
def test_recordings_from_the_page(site: Site) -> None:
    with site.connect() as client:
        client.send('{"command": "record", "on": true}')
        assert wait_for(lambda: (texts(client, "status")[0]["recording"].get("frames") or 0) > 0)
        client.send('{"command": "record", "on": false}')
        assert wait_for(lambda: not texts(client, "status")[0]["recording"]["on"])
        assert wait_for(lambda: site.observers.recordings.files)
    (path,) = site.observers.recordings.files
    from erclutch.logs import read_table

    assert read_table(path).rows > 10
    assert any("is complete" in note for note in site.observers.notes)


@pytest.mark.slow
def test_the_server_comes_back_at_the_same_address(own_site: Site) -> None:
    os.kill(own_site.page.pid, signal.SIGKILL)
    assert wait_for(lambda: own_site.page.restarts == 1)

    def answers() -> bool:
        with suppress(OSError):
            return own_site.get("/")[0] == 200
        return False

    assert wait_for(answers)
    with own_site.connect() as client:
        notes = [line["text"] for status in texts(client, "status", 3) for line in status["lines"]]
    assert any("was started again" in note for note in notes)


@pytest.mark.slow
def test_the_server_ends_with_its_session(tmp_path: Path, start_loop: Callable[..., Any]) -> None:
    """A session that is killed leaves no server and no recorder behind; the recording is whole."""
    loop = start_loop()
    code = (
        "import sys, time\nfrom erclutch.wings.live.companions import Observers\n"
        f"found = Observers({str(loop.path)!r}, print, folder={str(tmp_path)!r})\n"
        "found.record(True); found.recordings.wait_for_frames()\n"
        "print(found.page.pid, found.recordings.pid, flush=True)\ntime.sleep(60)\n"
    )
    session = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert session.stdout is not None
    pids = [int(word) for word in session.stdout.readline().split()]
    session.kill()
    session.wait()
    session.stdout.close()

    def gone(pid: int) -> bool:
        with suppress(OSError):
            return "\nState:\tZ" in Path(f"/proc/{pid}/status").read_text(encoding="ascii")
        return True

    assert wait_for(lambda: all(gone(pid) for pid in pids))
    assert len(list(tmp_path.glob("*.mcap"))) == 1


@pytest.mark.slow
def test_a_port_that_is_taken(start_loop: Callable[..., Any]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(PageError, match=r"Address already in use. Give another --port"):
            PageProcess(str(start_loop().path), LIMITS, port=taken.getsockname()[1])


@pytest.mark.slow
def test_uplot_is_what_its_origin_says() -> None:
    import hashlib
    import tomllib
    from importlib.resources import files

    folder = files("erclutch") / "report" / "assets" / "uplot"
    origin = tomllib.loads((folder / "ORIGIN.toml").read_text(encoding="utf-8"))
    for name, digest in origin["sha256"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest
    assert "MIT" in (folder / "LICENSE").read_text(encoding="utf-8")


@pytest.mark.slow
def test_no_text_becomes_markup_or_code_in_the_page() -> None:
    """Names of rigs, models and programs are put into the page as text."""
    package = files("erclutch")
    for folder in ("wings/live/page/static", "report/assets"):
        for file in package.joinpath(folder).iterdir():
            if file.name.endswith(".js"):
                found = re.findall(
                    r"(?:inner|outer)HTML|insertAdjacent|document\.write|\beval\(|new Function",
                    file.read_text(),
                )
                assert not found, file.name
