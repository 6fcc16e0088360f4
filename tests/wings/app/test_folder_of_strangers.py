"""The folder of the app holds what others put there: odd names, files that go away, clocks that were set wrong."""

from __future__ import annotations

import asyncio
import io
import os
import zipfile
from pathlib import Path
from typing import Any

import pytest

from erclutch.wings.app.workbench_server import Workbench
from erclutch.wings.app.workspace import Workspace, zipped
from erclutch.wings.live.page.access import Access

ODD = (
    b"\xff\xfe.csv",
    b"a\nb.csv",
    b"x\x1b[31m.csv",
    b"12:30.csv",
    b"<b>.csv",
    b"\xe2\x80\xae.csv",
    b"a" * 150 + b".csv",
    b"\xff.html",
    b"\xff.toml",
)


def asked(bench: Workbench, path: str) -> tuple[int, str]:
    """What the owner gets, in this process."""
    access = bench.app._access
    cookie = access.set_cookie().partition(";")[0]
    headers = [(b"host", f"127.0.0.1:{access.port}".encode()), (b"cookie", cookie.encode())]
    scope = {
        "type": "http",
        "method": "GET",
        "path": access.base + path,
        "headers": headers,
        "query_string": b"",
        "client": ("127.0.0.1", 1),
    }
    status, body = 0, b""

    async def receive() -> Any:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        nonlocal status, body
        status = message.get("status", status)
        body += message.get("body", b"")

    asyncio.run(bench.app(scope, receive, send))
    return status, body.decode()


@pytest.fixture
def bench(tmp_path: Path) -> Workbench:
    return Workbench(tmp_path, Access(1, "token"), tmp_path)


def test_names_that_no_page_can_hold_are_told_and_stop_nothing(
    bench: Workbench, tmp_path: Path
) -> None:
    """One file with a name that is no UTF-8 took the whole overview away."""
    for name in ODD:
        Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name)).write_text("1")
    (tmp_path / "own.csv").write_text("1")
    assert [entry.name for entry in Workspace(tmp_path).logs()] == ["own.csv"]
    status, page = asked(bench, "/")
    assert status == 200
    assert "Not shown for their names: " in page
    assert "12:30.csv" in page
    assert f"({len(ODD)} in all)" in page
    assert not {"\x1b", "\u202e"} & set(page)
    assert "<b>" not in page


def test_a_plain_folder_says_nothing_of_names(bench: Workbench, tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text("1")
    assert "Not shown" not in asked(bench, "/")[1]


def test_a_file_that_goes_away_as_a_page_is_made_is_told(
    bench: Workbench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server said that it had an error, and the whole of that stood in its terminal."""
    monkeypatch.setattr(Workspace, "path", lambda space, name: tmp_path / name)
    for path in ("/file/gone.csv", "/run/gone/report"):
        monkeypatch.setattr(Workspace, "run", lambda space, name: tmp_path / name)
        status, page = asked(bench, path)
        assert (path, status) == (path, 404)
        assert "A file of the folder changed while this page was made" in page


def test_an_error_of_ours_is_no_file_that_went_away(
    bench: Workbench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(space: Workspace, name: str) -> Path:
        raise RuntimeError("ours")

    monkeypatch.setattr(Workspace, "path", broken)
    with pytest.raises(RuntimeError, match="ours"):
        asked(bench, "/file/a.csv")


@pytest.mark.parametrize("moment", [0.0, 2**33])
def test_a_folder_is_downloaded_whatever_its_clock_was(moment: float, tmp_path: Path) -> None:
    """A zip archive has times from 1980 on: one file of 1970 ended in an error of the server."""
    (tmp_path / "export").mkdir()
    (tmp_path / "export" / "m.c").write_text("int x;")
    os.utime(tmp_path / "export" / "m.c", (moment, moment))
    with zipfile.ZipFile(io.BytesIO(zipped(tmp_path / "export"))) as archive:
        assert archive.read("export/m.c") == b"int x;"
