"""No attack on the page and no bad day of its server shuts the owner out, or keeps an order from the loop."""

from __future__ import annotations

import json
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from erclutch.wings.live.companion_process import CompanionProcess
from erclutch.wings.live.companions import Observers
from erclutch.wings.live.page.wire import as_text
from erclutch.wings.live.page_commands import PageCommand
from tests.wings.live.page.test_page import Site, texts, wait_for

pytestmark = pytest.mark.timed


@pytest.fixture
def site(tmp_path: Path, start_loop: Callable[..., Any]) -> Iterator[Site]:
    found = Site(start_loop(), tmp_path)
    yield found
    found.observers.close()


def test_what_a_browser_is_told_is_json_whatever_a_name_or_a_number_is() -> None:
    body = {"folder": "a\udcffb", "stroke": float("inf"), "rows": [float("nan"), (1.5, "\u202e")]}
    text = as_text(body)
    assert text.isascii()
    text.encode()
    read = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert read == {"folder": "a\udcffb", "stroke": None, "rows": [None, [1.5, "\u202e"]]}


@pytest.mark.slow
def test_a_folder_whose_name_is_no_text_shuts_nobody_out(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    folder = tmp_path / os.fsdecode(b"rec\xff")
    site = Site(start_loop(), folder)
    try:
        with site.connect() as client:
            assert wait_for(lambda: "recording" in texts(client, "status")[0])
            told = texts(client, "status")[0]["recording"]["folder"]
        assert told == str(folder / "recordings")
    finally:
        site.observers.close()


@pytest.mark.slow
def test_whoever_opens_a_page_is_let_in_and_the_oldest_makes_room(site: Site) -> None:
    with ExitStack() as stack:
        clients = [stack.enter_context(site.connect()) for _ in range(8)]
        for client in clients:
            assert texts(client, "hello")
        newest = stack.enter_context(site.connect())
        assert texts(newest, "status")
        with pytest.raises(ConnectionClosed) as closed:
            texts(clients[0], "never")
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 4001  # at which its page does not come back by itself
        assert texts(clients[1], "status")
        assert wait_for(lambda: texts(newest, "status")[0]["clients"] == 8)
        newest.send('{"command": "zero"}')
        assert wait_for(lambda: site.commands == [PageCommand("zero")])


@pytest.mark.slow
def test_clients_that_read_nothing_make_room_too(site: Site) -> None:
    address = f"127.0.0.1:{site.access.port}"
    request = (
        f"GET {site.access.base}/frames HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n"
        f"Cookie: {site.cookie}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n"
    )
    with ExitStack() as stack:
        for _ in range(20):
            raw = stack.enter_context(socket.create_connection(("127.0.0.1", site.access.port)))
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            raw.sendall(request.encode())
            assert raw.recv(12) == b"HTTP/1.1 101"
        with site.connect() as client:
            assert texts(client, "status")
            files = Path(f"/proc/{site.page.pid}/fd")
            assert wait_for(lambda: len(list(files.iterdir())) < 32)  # two a client


@pytest.mark.slow
def test_thousands_of_connections_of_strangers_shut_nobody_out(site: Site) -> None:
    """All at once, each with half a request: more come than the server can look at."""
    ended = threading.Event()
    held: list[list[socket.socket]] = [[], []]

    def storm(mine: list[socket.socket]) -> None:
        while not ended.is_set():
            with suppress(OSError):
                mine.append(socket.create_connection(("127.0.0.1", site.access.port), timeout=5))
                mine[-1].sendall(b"GET / HT")
            if len(mine) > 100:
                mine.pop(0).close()

    threads = [threading.Thread(target=storm, args=(mine,)) for mine in held]
    for thread in threads:
        thread.start()
    try:
        time.sleep(1.0)
        for _ in range(5):
            with site.connect() as client:
                assert texts(client, "status")
        assert len(list(Path(f"/proc/{site.page.pid}/fd").iterdir())) < 400
    finally:
        ended.set()
        for thread in threads:
            thread.join()
        for raw in (*held[0], *held[1]):
            raw.close()


@pytest.mark.slow
def test_no_order_waits_for_recordings(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """A recording that takes long to begin and to end, asked for again and again, and then the fields to zero."""
    asked: list[bool] = []

    def slow(on: bool, **_: Any) -> None:
        asked.append(on)
        time.sleep(1.0)

    monkeypatch.setattr(site.observers, "record", slow)
    with site.connect() as client:
        for click in range(15):
            on = json.dumps(click % 2 == 0)
            client.send(f'{{"command": "record", "on": {on}}}')
            time.sleep(0.06)
        began = time.monotonic()
        client.send('{"command": "zero"}')
        assert wait_for(lambda: PageCommand("zero") in site.commands)
        assert time.monotonic() - began < 0.8
        assert wait_for(lambda: asked[-1:] == [True] and not site.observers._asked)
        assert len(asked) <= 4


@pytest.mark.slow
def test_a_disk_that_takes_no_recording_stops_no_order(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(**_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(site.observers.recordings, "start", full)
    with site.connect() as client:
        client.send('{"command": "record", "on": true}')
        assert wait_for(lambda: any("No space left" in note for note in site.observers.notes))
        client.send('{"command": "zero"}')
        assert wait_for(lambda: site.commands == [PageCommand("zero")])
        client.send('{"command": "record", "on": true}')
        assert wait_for(lambda: sum("No space" in note for note in site.observers.notes) == 2)


@pytest.mark.slow
def test_a_server_that_hangs_holds_up_neither_the_session_nor_its_end(site: Site) -> None:
    os.kill(site.page.pid, signal.SIGSTOP)
    stopped = site.page.pid
    ended = threading.Thread(
        target=lambda: [
            site.page.tell({"notes": [], "fill": "x" * 9999, "n": n}) for n in range(99)
        ]
    )
    ended.start()
    ended.join(5.0)
    assert not ended.is_alive()
    site.page._process._took -= 30.0  # as if it had read nothing for so long
    assert wait_for(lambda: site.page.pid != stopped)
    assert site.page.restarts == 1

    def serves() -> bool:
        with suppress(OSError), site.connect() as client:
            return bool(texts(client, "status"))
        return False

    assert wait_for(serves, 20.0)


@pytest.mark.slow
def test_a_session_may_have_more_to_say_than_a_pipe_holds(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """Names and meanings of a rig's programs, of 300,000 letters."""
    long = [(f"{letter * 50_000}", letter * 50_000, "") for letter in "abc"]
    with Observers(
        start_loop().path, lambda command: None, programs=long, folder=tmp_path
    ) as observers:
        assert observers.url


def test_a_line_for_a_process_is_never_cut_by_a_newer_one() -> None:
    process = CompanionProcess("json.tool", "--json-lines", "--compact", listens=True)
    for number in range(50):
        process.tell({"number": number, "fill": "x" * 30_000})
    while process._begun or process._next:
        process.push()
        time.sleep(0.005)
    assert process.stdin is not None
    process.stdin.close()
    process.wait()
    numbers = [json.loads(line)["number"] for line in process.lines() if line]
    assert numbers[-1] == 49
    assert numbers == sorted(set(numbers))


def test_notes_are_kept_to_a_number_and_told_once(tmp_path: Path) -> None:
    observers = Observers(tmp_path / "ring", lambda command: None, page=False)
    try:
        for number in range(1500):
            observers.say(f"note {number}")
        assert observers.notes[-1] == "note 1499"
        assert len(observers.notes) == 1000
        assert observers._notes[-1][0] == 1499
    finally:
        observers.close()
