"""The page of `erclutch app`: who gets an answer, what a form becomes, and the whole road in a real browser."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, closing, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar
from urllib.parse import parse_qsl

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.runs.run_about import RunAbout, about_with
from erclutch.wings.app import actions
from erclutch.wings.app.jobs import Job, Jobs
from erclutch.wings.app.run_answers import run_row
from erclutch.wings.app.workbench_server import Workbench
from erclutch.wings.app.workspace import (
    SHOWN,
    Entry,
    Workspace,
    WorkspaceError,
    plain_name,
    shown_folder,
)
from erclutch.wings.live.page.access import TOKEN_HEADER, Access
from tests.support.command import good

CHROMIUM = Path("/usr/bin/chromium")
NEES = Path(__file__).parents[4] / "shared/data/mr_damper_nees/ranran_50_converted.csv"

# --- forms ------------------------------------------------------------------------------------------------------------


def test_help_names_the_folder_first() -> None:
    assert "Usage: erclutch app [FOLDER] [OPTIONS]" in good("app", "--help")


def test_a_form_becomes_the_choices_that_somebody_made() -> None:
    guessed = {
        "column.time": "t",
        "was.time": "t",
        "column.effort": "F",
        "unit.effort": "N",
        "was.effort": "F [N]",
    }
    assert actions.chosen_of(guessed).words() == []
    given = {
        "column.slip": "V",
        "unit.slip": "cm/s",
        "was.slip": "",
        "turn.slip": "on",
        "rate": "1 kHz",
    }
    words = actions.chosen_of({**guessed, **given}).words()
    assert words == ["--slip=-V [cm/s]", "--rate", "1 kHz"]
    kept = {
        "column.slip": "V",
        "unit.slip": "cm/s",
        "was.slip": "V [cm/s]",
        "given.slip": "V [cm/s]",
    }
    assert actions.chosen_of({**guessed, **kept}).words() == ["--slip", "V [cm/s]"]
    taken_away = {"column.field": "", "was.field": "I [A]"}
    assert actions.chosen_of({**guessed, **taken_away}).words() == ["--field", "none"]
    taken_away = {"column.position": "", "was.position": "x"}
    assert actions.chosen_of({**guessed, **taken_away}).words() == ["--position", "none"]
    assert actions.on_page("Or --position none.") == "Or “position”: not logged."
    run = {
        "device": "single",
        "reading": {"slip": "V [cm/s]", "constant": ["field=1 A"], "begin": "2s", "lead": None},
    }
    again = actions.chosen_of(dict(parse_qsl(actions.query_of(run)))).words()
    assert again == ["--slip", "V [cm/s]", "--constant", "field=1 A", "--from", "2s"]
    elsewhere = actions.chosen_of(
        dict(parse_qsl(actions.query_of(run, of_another_log=True)))
    ).words()
    assert elsewhere == [
        "--slip",
        "V [cm/s]",
        "--constant",
        "field=1 A",
    ]  # a window is of its own log


def test_a_log_is_read_again_with_each_zero_and_scale_of_its_run() -> None:
    zeros = ["effort=2048", "slip=3"]
    scales = ["effort=0.002 N*m", "slip=0.1 rad/s"]
    run = {"device": "single", "reading": {"scale": scales, "zero": zeros}}
    chosen = actions.chosen_of(dict(parse_qsl(actions.query_of(run))))
    of_scale = [word for each in scales for word in ("--scale", each)]
    of_zero = [word for each in zeros for word in ("--zero", each)]
    assert chosen.words() == [*of_scale, *of_zero]
    mapping = {
        "columns": {},
        "scales": {"effort": "0.002 N*m", "slip": "0.1 rad/s"},
        "zeros": {"effort": "2048", "slip": "3"},
    }
    assert chosen.keywords() == f", {mapping!r}"


def test_a_log_is_read_again_by_the_pattern_rate_and_inputs_of_its_run() -> None:
    read_by = {
        "name_pattern": "test-{field}A",
        "decimal": ",",
        "resample": "1 kHz",
        "input": ["accel", "jerk"],
    }
    run = {"device": "single", "reading": read_by}
    chosen = actions.chosen_of(dict(parse_qsl(actions.query_of(run))))
    words = ["--input", "accel", "--input", "jerk", "--name-pattern", "test-{field}A"]
    assert chosen.words() == [*words, "--decimal", ",", "--resample", "1 kHz"]
    assert "input=['accel', 'jerk'], name_pattern='test-{field}A'" in chosen.keywords()
    assert "decimal=',', resample='1 kHz'" in chosen.keywords()


def test_a_log_is_read_again_with_the_filter_of_speeds_and_the_kept_values_of_its_run() -> None:
    read_by = {"keep_values": True, "derivative": "lowpass", "cutoff": 40.0}
    run = {"device": "single", "reading": read_by}
    form = dict(parse_qsl(actions.query_of(run)))
    chosen = actions.chosen_of(form)
    assert chosen.words() == ["--keep-values", "--derivative", "lowpass", "--cutoff", "40.0"]
    assert chosen.keywords() == ", keep_values=True"
    python = actions.fit_in_python(form, ["log.csv"], "run")
    filtered = "derivative=erclutch.Derivative('lowpass', cutoff=40.0)"
    assert f"erclutch.build_dataset(logs, {filtered})" in python
    wider = actions.chosen_of({"window": "9"})
    assert wider.words() == ["--window", "9"]
    assert wider.derivative() == ", derivative=erclutch.Derivative(window=9)"
    told = actions.chosen_of({"cutoff": "0.04 kHz", "window": "wide"}).derivative()
    assert told == ", derivative=erclutch.Derivative(cutoff=40.0, window='wide')"


def test_a_log_is_read_again_as_a_run_of_python_read_it() -> None:
    """Such a run keeps what `erclutch.read` was told, and the app shows the script that writes such a run."""
    told = {"slip": "V [cm/s]", "scale": ["effort=0.002 N*m"]}
    run = {"device": "single", "reading": None, "told": told}
    chosen = actions.chosen_of(dict(parse_qsl(actions.query_of(run))))
    assert chosen.words() == ["--slip", "V [cm/s]", "--scale", "effort=0.002 N*m"]


def test_the_fit_in_python_holds_out_what_the_command_holds_out() -> None:
    form = {"test": "20%", "seed": "7", "lag": "none"}
    python = actions.fit_in_python(form, ["log.csv"], "run")
    assert "Settings(lag='none', test=0.2, seed=7)" in python
    assert "Settings(test=('day*',))" in actions.fit_in_python({"test": "day*"}, ["log.csv"], "run")
    assert "Settings(test=0.3)" in actions.fit_in_python({"test": "0.3"}, ["log.csv"], "run")
    assert "Settings()" in actions.fit_in_python({"test": "auto"}, ["log.csv"], "run")


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        (
            'Give it, such as --slip "V [cm/s]", or --field none if',
            'Give it, such as “slip”: "V [cm/s]", or “field”: not logged if',
        ),
        ("cut the log there with --invalid drop.", "cut the log there with “invalid”: drop."),
        ("Give --time or --rate HZ", "Give “time” or “rate”: HZ"),
        ("such as --lag lag+dahl/field", "such as “Lags and memory”: lag+dahl/field"),
        (
            'these: erclutch inspect \'a b.csv\' --E1 "x" --theta-dot "y"',
            'these: “E1”: "x", “theta_dot”: "y"',
        ),
        (
            'Give them all, with your columns in place of these: erclutch inspect odd.txt --time "c1 [s]" '
            '--field "COLUMN [A]" --effort "COLUMN [N]"; --field none if it was not logged.',
            'Choose a column for each below, such as “time”: "c1 [s]"; the foot of this page draws them; '
            "“field”: not logged if it was not logged.",
        ),
        (
            "Use --derivative central, without --lag",
            "Use “derivative”: central, without “Lags and memory”",
        ),
        ("Leave --polish out, or --seed", "Leave --polish out, or “Seed”"),
    ],
)
def test_a_message_names_the_fields_of_the_page(said: str, shown: str) -> None:
    assert actions.on_page(said) == shown


def test_a_fit_as_words_and_in_python() -> None:
    form = {
        "model.bingham": "on",
        "models": "hem/square",
        "lag": "none",
        "test": "auto",
        "constant": "field=1 A",
        "invalid": "drop",
    }
    words = actions.fit_words(form, ["a.csv", "b.csv"], "run")
    assert words[:3] == ["fit", "a.csv", "b.csv"]
    assert words[3:] == [
        *(
            "--constant",
            "field=1 A",
            "--invalid",
            "drop",
            "--models",
            "bingham",
            "hem/square",
            "--lag",
            "none",
        ),
        *("--out", "run"),
    ]
    script = actions.fit_in_python(form, ["a.csv"], "run")
    compile(script, "script", "exec")
    assert "{'columns': {}, 'constants': {'field': '1 A'}}, invalid='drop'" in script


@pytest.mark.slow
@given(st.text(max_size=130))
def test_a_name_is_refused_or_stays_in_the_folder(name: str) -> None:
    with suppress(WorkspaceError):
        kept = Path("/there") / plain_name(name)
        assert kept.parent == Path("/there")
        assert not kept.name.startswith(("-", "."))


@pytest.mark.slow
@given(
    st.dictionaries(
        st.sampled_from(["models", "lag", "test", "seed", "rate", "column.slip"]),
        st.text(max_size=30),
    )
)
def test_no_text_of_a_form_becomes_an_option(form: dict[str, str]) -> None:
    with suppress(WorkspaceError):
        words = actions.fit_words(form, ["log.csv"], "run")
        known = {"--models", "--lag", "--test", "--seed", "--rate", "--slip", "--out"}
        assert {word.split("=")[0] for word in words if word.startswith("-")} <= known


def test_an_upload_is_there_whole_or_not_at_all(tmp_path: Path) -> None:
    async def pieces(*parts: bytes, broken: bool = False) -> AsyncIterator[bytes]:
        for part in parts:
            yield part
        if broken:
            raise ConnectionError

    space = Workspace(tmp_path)
    assert asyncio.run(space.take("a.csv", pieces(b"1,", b"2\n"))) == ("a.csv", False)
    assert asyncio.run(space.take("a.csv", pieces(b"3\n"))) == ("a-2.csv", False)
    assert asyncio.run(space.take("a.csv", pieces(b"3", b"\n"))) == ("a-2.csv", True)
    assert (tmp_path / "a.csv").read_bytes() == b"1,2\n"
    for content in (pieces(b"1", broken=True), pieces()):
        with pytest.raises(WorkspaceError):
            asyncio.run(space.take("b.csv", content))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-2.csv", "a.csv"]
    (tmp_path / "a-run-estimate-2.csv").write_text("1")
    assert [entry.name for entry in space.logs()] == ["a-2.csv", "a.csv"]
    assert [entry.name for entry in space.results()] == ["a-run-estimate-2.csv"]


def test_what_is_said_of_a_log_is_kept_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    space = Workspace(tmp_path / "bench")
    space.folder.mkdir()
    assert space.about("a.csv") == RunAbout()
    said = about_with(RunAbout(), device="Brake 7", note="new oil")
    space.keep_about("a.csv", said)
    assert (space.about("a.csv"), space.about("b.csv")) == (said, RunAbout())
    assert (space.logs(), space.results()) == ([], [])
    monkeypatch.setenv("HOME", str(tmp_path))
    assert shown_folder(space.folder) == os.path.join("~", "bench")
    assert shown_folder(Path("/elsewhere")) == "/elsewhere"


@pytest.mark.slow
def test_what_was_damaged_of_what_is_said_of_logs_takes_nothing_else_along(tmp_path: Path) -> None:
    space = Workspace(tmp_path)
    said = about_with(RunAbout(), device="Brake 7", note="new oil")
    space.keep_about("a.csv", said)
    file = space.folder / ".erclutch-about.json"
    for other in (
        5,
        "title",
        None,
        [],
        {"date": "soon"},
        {"note": "\x1b"},
        {"more": 1},
        {"note": []},
    ):
        file.write_text(json.dumps({**json.loads(file.read_text()), "b.csv": other}))
        assert space.about("b.csv").date == ""  # it was a fault of the app
        space.keep_about("c.csv", RunAbout(note="dry"))
        assert space.about("a.csv") == said  # it was lost
    for text in ("[]", "{", '{"a.csv": {}, "a.csv": {}}'):
        file.write_text(text)
        assert space.about("a.csv") == RunAbout()
        with pytest.raises(WorkspaceError, match="cannot be understood"):
            space.keep_about("c.csv", said)
        assert file.read_text() == text


def test_a_sequence_to_log_next_is_a_result_and_no_log(tmp_path: Path) -> None:
    rows = "time [s],field,slip [rad/s]\n" + "".join(f"{k},0,0\n" for k in range(9))
    (tmp_path / "commands.csv").write_text('# COMMANDS: {"label": "COMMANDS"}\n' + rows)
    (tmp_path / "log.csv").write_text('# TWIN: {"label": "TWIN"}\n' + rows)
    space = Workspace(tmp_path)
    assert [entry.name for entry in space.logs()] == ["log.csv"]
    assert [entry.name for entry in space.results()] == ["commands.csv"]


def test_a_job_lists_the_models_that_it_has_fitted() -> None:
    job = Job.__new__(Job)
    job.fitted = {}
    for done, model, error in ((0.1, "", None), (0.2, "bingham", 0.4), (0.3, "casson+lag", 0.2)):
        line = {
            "done": done,
            "total": 1.0,
            "doing": f"fitted {model}",
            "fitted": model,
            "train_share": error,
        }
        job._take_progress(json.dumps(line))
    assert job.fitted == {"bingham": 0.4, "casson+lag": 0.2}
    assert (job.share, job.doing) == (0.3, "fitted casson+lag")


@pytest.mark.parametrize(
    "line", ["", "[]", "{}", '{"done": "x", "total": 1, "doing": ""}', '[1, 2, "a"]', "1e999"]
)
def test_a_line_that_is_no_progress_changes_nothing(line: str) -> None:
    job = Job.__new__(Job)
    job.fitted, job.share, job.doing = {}, 0.5, "fitting"
    job._take_progress(line)
    assert (job.fitted, job.share, job.doing) == ({}, 0.5, "fitting")


def test_a_link_that_leaves_the_workspace_is_not_there(tmp_path: Path) -> None:
    outside, inside = tmp_path / "outside", tmp_path / "space"
    for folder in (outside / "run", inside):
        folder.mkdir(parents=True)
    for path in (
        outside / "a.csv",
        outside / "a.html",
        outside / "a.toml",
        outside / "run" / "run.json",
    ):
        path.write_text("1")
    (inside / "own.csv").write_text("1")
    for path in outside.iterdir():
        (inside / f"link-{path.name}").symlink_to(path)
    (inside / "twin.csv").symlink_to(inside / "own.csv")
    (inside / "loop.csv").symlink_to(inside / "loop.csv")
    space = Workspace(inside)
    assert {entry.name for entry in space.logs()} == {"own.csv", "twin.csv"}
    assert (space.runs(), space.results(), space.mappings()) == ([], [], [])
    assert space.path("twin.csv").read_text() == "1"
    for name in ("link-a.csv", "link-run", "loop.csv"):
        with pytest.raises(WorkspaceError, match="no such file or folder"):
            space.path(name)


def test_a_link_in_a_folder_is_not_followed(tmp_path: Path) -> None:
    space = Workspace(tmp_path)
    run = tmp_path / "run"
    (run / "models").mkdir(parents=True)
    (run / "run.json").write_text("{}")
    (run / "rows.parquet").write_text("1")
    assert space.run("run") == run
    (run / "models" / "bingham.json").symlink_to(run / "rows.parquet")
    for ask in (space.path, space.run):
        with pytest.raises(
            WorkspaceError, match=r"holds the link models/bingham\.json, and links in a folder"
        ):
            ask("run")
    assert space.body("run") is None
    (run / "models" / "bingham.json").unlink()
    (run / "more").symlink_to("/etc")
    with pytest.raises(WorkspaceError, match="holds the link more"):
        space.path("run")


@pytest.mark.slow
def test_looks_at_logs_are_counted(tmp_path: Path) -> None:
    jobs = Jobs(tmp_path)
    words = ["simulate", "training", "--seconds", "3000", "--out"]
    try:
        looks = [jobs.look("look", [*words, f"{place}.csv"], place, "/") for place in range(4)]
        with pytest.raises(WorkspaceError, match="four logs are being looked at"):
            jobs.look("look", [*words, "4.csv"], 4, "/")
        assert jobs.look("look", [*words, "0.csv"], 0, "/") is looks[0]
        assert not jobs.full
        looks[1].cancel()
        looks[1].join(20.0)
        jobs.look("look", [*words, "4.csv"], 4, "/")
    finally:
        jobs.close()


@pytest.mark.slow
def test_a_command_ends_with_its_server(tmp_path: Path) -> None:
    job = Job(
        1, "twin", ["simulate", "training", "--seconds", "3000", "--out", "log.csv"], tmp_path
    )
    while not job.lines and job.code is None and job.seconds < 3.0:
        time.sleep(0.05)
    job.cancel()
    job.join(20.0)
    assert job.state == "cancelled"
    assert job.code == 130
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_log_is_looked_at_once_until_something_changes(tmp_path: Path) -> None:
    jobs, space = Jobs(tmp_path), Workspace(tmp_path)
    german(tmp_path / "log.csv")

    def look() -> Job:
        job = jobs.look(
            "look", ["inspect", "log.csv", "--json"], space.state("log.csv"), "/log/log.csv"
        )
        job.join(30.0)
        return job

    first = look()
    assert (first.state, json.loads(first.output)["choices"]["effort"]["unit"]) == ("done", "N m")
    assert look() is first
    (tmp_path / "log.csv.toml").write_text('[columns]\neffort = "-Drehmoment [mN*m]"\n')
    second = look()
    assert json.loads(second.output)["choices"]["effort"]["unit"] == "mN*m"
    assert not jobs.full


# --- the server -------------------------------------------------------------------------------------------------------


class Served:
    """A running `erclutch app`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        command = [sys.executable, "-m", "erclutch", "app", str(folder)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#token=(\S+)", self.url)
        assert found
        self.access = Access(int(found[1]), found[2])
        self.port, self.base = self.access.port, self.access.base
        self.cookie = self.access.set_cookie().partition(";")[0]

    def ask(
        self, method: str, path: str, body: bytes = b"", *, bare: bool = False, **headers: str
    ) -> tuple[int, str]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        origin = {} if method == "GET" else {"Origin": f"http://127.0.0.1:{self.port}"}
        connection.request(
            method,
            path if bare else self.base + path,
            body,
            {"Cookie": self.cookie, **origin, **headers},
        )
        with closing(connection), connection.getresponse() as answer:
            return answer.status, answer.read().decode("utf-8", "replace")

    def close(self) -> int:
        self.process.send_signal(signal.SIGINT)
        with self.process:
            return self.process.wait(20.0)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    server = Served(tmp_path_factory.mktemp("space"))
    yield server
    assert server.close() == 0


@pytest.mark.slow
def test_only_a_page_of_this_server_with_the_token_gets_an_answer(served: Served) -> None:
    assert served.ask("GET", "/")[0] == 200
    assert served.ask("GET", "/", Cookie="")[0] == 403
    assert served.ask("GET", "/", Cookie=f"erclutch-{served.port}=x")[0] == 403
    assert served.ask("GET", "/static/app.js", bare=True)[0] == 403
    other_pages: list[dict[str, Any]] = [
        {"Sec-Fetch-Site": site} for site in ("same-site", "cross-site")
    ]
    for headers in other_pages:
        assert served.ask("GET", "/", b"", **headers)[0] == 403
        assert served.ask("POST", "/twin", b"what=log", **headers)[0] == 403
    tokens: list[dict[str, Any]] = [
        {TOKEN_HEADER: text} for text in (served.access.token, served.cookie.partition("=")[2])
    ]
    assert [served.ask("POST", "/enter", b"", bare=True, **headers)[0] for headers in tokens] == [
        200,
        403,
    ]
    assert served.ask("GET", "/", Host="evil.example")[0] == 403
    assert served.ask("POST", "/twin", b"what=log", Origin="http://evil.example")[0] == 403
    assert served.ask("POST", "/twin", b"what=log", Origin="null")[0] == 403
    assert served.ask("PUT", "/upload/a.csv", b"1", Origin="http://evil.example")[0] == 403
    assert list(served.folder.iterdir()) == []


@pytest.mark.slow
def test_idle_connections_do_not_shut_the_owner_out(served: Served) -> None:
    with ExitStack() as stack:
        for place in range(100):
            raw = stack.enter_context(
                socket.create_connection(("127.0.0.1", served.port), timeout=5)
            )
            with suppress(OSError):
                raw.sendall(b"GET / HTTP/1.1\r\nHost: " if place % 2 else b"")
        assert [served.ask("GET", "/")[0] for _ in range(3)] == [200, 200, 200]


@pytest.mark.slow
def test_a_folder_with_many_runs_is_shown_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each run that was shown was read: 10^5 runs took minutes."""
    looked: list[str] = []
    monkeypatch.setattr(Workspace, "body", lambda self, name: looked.append(name))
    for number in range(SHOWN + 20):
        (tmp_path / f"run{number}").mkdir()
        (tmp_path / f"run{number}" / "run.json").write_text("{}")
    bench = Workbench(tmp_path, Access(1, "token"), tmp_path)
    page = bytes(bench._overview().body).decode()  # pyright: ignore[reportPrivateUsage]
    assert "Of 220 entries of a kind the newest 200 are shown." in page
    assert page.count('type="checkbox"') == len(looked) == SHOWN


def test_a_look_that_took_long_is_made_once_for_all_who_ask_until_a_name_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With 10^6 runs a look takes 7 s of a processor, and a page of a run asked for two."""
    space, looks, looked = Workspace(tmp_path), list[float](), Workspace._looked  # pyright: ignore[reportPrivateUsage]
    took = [1.0]

    def slow(self: Workspace) -> Any:
        looks.append(clock[0])
        clock[0] += took[0]
        return looked(self)

    clock = [100.0]
    monkeypatch.setattr(Workspace, "_looked", slow)
    monkeypatch.setattr("erclutch.wings.app.workspace.time.monotonic", lambda: clock[0])
    assert (space.logs(), space.runs(), space.results(), len(looks)) == ([], [], [], 1)
    os.utime(tmp_path, ns=(1, 1))  # a file system whose clock ticks seldom
    (tmp_path / "a.csv").write_text("1")
    assert [entry.name for entry in space.logs()] == ["a.csv"]
    (tmp_path / "a.csv").write_text("12")  # no name came: that is seen when the look is old
    assert [entry.size for entry in space.logs()] == [1]
    clock[0] += 4.0
    assert [entry.size for entry in space.logs()] == [2]
    took[0] = 0.1
    clock[0] += 4.0
    before = len(looks)
    assert space.logs() == space.logs()
    assert len(looks) == before + 2, "a quick look is made each time"


@pytest.mark.parametrize(
    "ask",
    [
        lambda bench: bench._together(_asked({"name": "a.csv"})),
        lambda bench: bench._compare(_asked({}), {}),
        lambda bench: bench._upload(_asked({"name": "a.csv"})),
        lambda bench: bench._fit(_asked({"name": "a.csv"}), {"run": "r"}),
    ],
)
def test_no_look_at_the_folder_holds_up_other_answers(
    ask: Callable[[Any], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The thread of the server answers everybody: it waited for the whole look."""
    (tmp_path / "a.csv").write_text("1")
    bench, by = Workbench(tmp_path, Access(1, "token"), tmp_path), set[str]()
    looked = Workspace._looked  # pyright: ignore[reportPrivateUsage]

    def look(self: Workspace) -> Any:
        by.add(threading.current_thread().name)
        return looked(self)

    monkeypatch.setattr(Workspace, "_looked", look)
    monkeypatch.setattr(Workbench, "_begin", lambda *_: None)
    with suppress(WorkspaceError):
        asyncio.run(ask(bench))
    assert by
    assert threading.main_thread().name not in by


def test_logs_go_not_together_as_long_as_nobody_has_looked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A look that took longer than the server waits was answered with no problem at all."""
    (tmp_path / "a.csv").write_text("1")
    (tmp_path / "b.csv").write_text("1")
    bench = Workbench(tmp_path, Access(1, "token"), tmp_path)

    async def look(*_: Any) -> Any:
        return SimpleNamespace(lines=[], output="", join=lambda _: None)

    monkeypatch.setattr(bench, "_look", look)
    answer = asyncio.run(bench._together(_asked({"name": "a.csv"})))
    assert json.loads(bytes(answer.body))["problem"] == "this takes a while: try again"


def _asked(path: dict[str, str]) -> Any:
    """A request for a path, with nothing else in it."""

    async def stream() -> AsyncIterator[bytes]:
        yield b"1"

    url = SimpleNamespace(query="log.b.csv=on")
    return SimpleNamespace(path_params=path, url=url, stream=stream)


@pytest.mark.slow
def test_a_run_that_cannot_be_read_stops_nobody(served: Served) -> None:
    """It is named in the overview; a page of it is one sentence, whatever it is."""
    bodies = {
        "deep": "[" * 100_000,
        "wrong": '{"kind": "erclutch run", "recommended": "nope", "ranking": []}',
    }
    for name, text in bodies.items():
        (served.folder / name).mkdir()
        (served.folder / name / "run.json").write_text(text)
    (served.folder / "empty").mkdir()
    (served.folder / "page.html").mkdir()
    (served.folder / "file.csv").write_text("1")
    (served.folder / "link.csv").symlink_to("/etc/passwd")
    try:
        status, home = served.ask("GET", "/")
        assert (status, home.count("not readable")) == (200, 2)
        assert "link.csv" not in home
        assert [served.ask("GET", f"/run/{name}")[0] for name in bodies] == [400, 400]
        for path in (
            "run/file.csv/report",
            "run/empty/report",
            "run/file.csv",
            "alone/page.html",
            "file/link.csv",
        ):
            status, text = served.ask("GET", f"/{path}")
            assert (path, status, text.count('role="alert"')) == (path, 404, 1)
    finally:
        for path in served.folder.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("GET", "/log/none.csv", b""),
        ("GET", "/file/..", b""),
        ("GET", "/file/%2e%2e", b""),
        ("GET", "/shown/%2Fetc%2Fpasswd", b""),
        ("GET", "/run/none", b""),
        ("GET", "/job/7", b""),
        ("GET", "/static/..%2F..%2Fjobs.py", b""),
        ("GET", "/log/a.csv?device=three", b""),
        ("POST", "/fit/none.csv", b"run=r"),
        ("POST", "/run/none/rename", b"to=x"),
        ("POST", "/compare", b""),
        ("POST", "/compare", b"&".join(b"a%d=1" % i for i in range(600))),
        ("POST", "/compare", b"a" * 200_000),
        ("PUT", "/upload/.hidden", b"1"),
        ("PUT", "/upload/--out", b"1"),
        ("PUT", "/upload/a%0A.csv", b"1"),
        ("PUT", "/upload/empty.csv", b""),
    ],
)
def test_what_cannot_be_is_told(served: Served, method: str, path: str, body: bytes) -> None:
    status, text = served.ask(method, path, body)
    assert status in (400, 404)
    assert "Traceback" not in text


@pytest.mark.slow
def test_a_killed_server_takes_its_commands_with_it(tmp_path: Path) -> None:
    server = Served(tmp_path)
    server.ask("POST", "/twin", b"what=live")
    children = Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children")
    until = time.monotonic() + 20.0
    pids: list[str] = []
    while not pids and time.monotonic() < until:
        pids = children.read_text().split()
    assert pids
    server.process.kill()
    with server.process:
        server.process.wait()
    while time.monotonic() < until + 20.0 and any(Path(f"/proc/{pid}").exists() for pid in pids):
        time.sleep(0.1)
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)


# --- the browser ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def open_page(served: Served) -> Iterator[Callable[..., Any]]:
    if not CHROMIUM.exists():
        pytest.skip(f"needs {CHROMIUM}")
    sync: Any = import_module("playwright.sync_api")
    wrong: list[str] = []
    with sync.sync_playwright() as playwright:
        flags = [
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
        ]
        browser = playwright.chromium.launch(
            executable_path=str(CHROMIUM), args=[*flags, "--disable-component-update"]
        )

        def hear(message: Any) -> None:
            # The browser's own word on a page that tells a problem, and on an answer that a test holds back.
            is_expected = re.search("status of 40[04]|net::ERR_FAILED", message.text)
            if message.type == "error" and not is_expected:
                wrong.append(message.text)

        def opened(width: int = 1440, scheme: str = "light") -> Any:
            context = browser.new_context(
                viewport={"width": width, "height": 900}, color_scheme=scheme
            )
            page = context.new_page()
            page.on("pageerror", lambda error: wrong.append(str(error)))
            page.on("console", hear)
            page.goto(served.url)
            page.wait_for_url(f"**{served.base}/")
            return page

        yield opened
        browser.close()
    assert wrong == []


class _Foreign(BaseHTTPRequestHandler):
    """Another server of this machine. It keeps what a browser sends, and its page asks for whatever it can."""

    seen: ClassVar[list[str]] = []
    page = ""

    def do_GET(self) -> None:
        self.seen.append(f"{self.path} {self.headers}")
        self.send_response(200)
        self.send_header("content-type", "text/html")
        self.end_headers()
        self.wfile.write(self.page.encode())

    do_POST = do_GET

    def log_message(self, format: str, *args: object) -> None: ...


@pytest.mark.slow
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_page_of_another_port_gets_no_token_and_starts_nothing(
    host: str, served: Served, open_page: Callable[..., Any]
) -> None:
    """The owner has the app open, and visits a page of another port (the same site), or of another origin."""
    page = open_page()
    page.wait_for_selector("#drop")
    assert page.url == f"http://127.0.0.1:{served.port}{served.base}/"
    before = served.ask("GET", "/")[1].count("/job/")
    target = f"http://127.0.0.1:{served.port}"
    log = german(served.folder / "stolen.csv").name
    asked = [
        f"{target}/",
        f"{target}/log/{log}",
        f"{target}{served.base}/log/{log}",
        f"{target}{served.base}/job/1",
    ]
    forms = "".join(
        f'<form id="f{n}" method="post" action="{target}{path}" target="i{n}"><input name="what" value="log"></form>'
        f'<iframe name="i{n}"></iframe>'
        for n, path in enumerate(("/twin", f"{served.base}/twin"))
    )
    script = (
        f"const asked = {json.dumps(asked)}; const answers = [];"
        "for (const form of document.forms) form.submit();"
        "const ask = (to, how) => fetch(to, how).then(a => a.text()).then(t => answers.push(t), () => 0);"
        f"const enter = ask('{target}/enter', {{method: 'POST', credentials: 'include'}});"
        "const all = asked.map(to => ask(to, {credentials: 'include'}));"
        "Promise.all([enter, ...all]).then(() => document.title = 'done ' + answers.length);"
    )
    _Foreign.page = "".join(f'<img src="{to}"><script src="{to}"></script>' for to in asked) + forms
    _Foreign.page += f"<script>{script}</script>"
    _Foreign.seen.clear()
    with ThreadingHTTPServer(("127.0.0.1", 0), _Foreign) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        visit = page.context.new_page()
        visit.goto(f"http://{host}:{other.server_port}/")
        visit.wait_for_function("document.title.startsWith('done')")
        visit.wait_for_timeout(500)
        assert visit.title() == "done 0"  # not one answer could be read
        page.reload()
        visit.close()
        other.shutdown()
    secrets = (served.access.token, served.cookie.partition("=")[2])
    assert _Foreign.seen
    assert not any(secret in request for secret in secrets for request in _Foreign.seen)
    assert served.ask("GET", "/")[1].count("/job/") == before
    assert not list(served.folder.glob("twin-log*"))
    (served.folder / log).unlink()
    page.close()


def german(path: Path) -> Path:
    """A SYNTHETIC brake with decimal commas, revolutions a minute and a column in °C."""
    random = np.random.default_rng(3)
    time_, rows = (
        np.arange(4000) / 500,
        ["Zeit [s];Strom [A];Drehzahl [1/min];Drehmoment [N m];Temperatur [°C]"],
    )
    current = 1.0 + np.sin(2 * time_) * np.sign(np.sin(0.5 * time_))
    speed = 200 * np.sin(5 * time_)
    torque = (
        (0.3 + current**2) * np.tanh(speed / 10)
        + 0.002 * speed
        + random.normal(0, 0.02, time_.size)
    )
    for row in zip(time_, current, speed, torque, 25 + 0.1 * time_, strict=True):
        rows.append(";".join(f"{value:.6f}".replace(".", ",") for value in row))
    path.write_text("\n".join(rows), encoding="latin-1")
    return path


def follow(page: Any, what: str, to: str = "**/log/**") -> None:
    """Click on what leads to another page, and wait until that page is whole.

    A browser shows a page while it still arrives, and a menu whose lines are not all there has none of them chosen.
    A look at a log that takes long leads to the page of its progress first: hence the address.
    """
    with page.expect_navigation(url=to, timeout=60_000):
        page.click(what)


def accessible(page: Any) -> None:
    axe: Any = import_module("axe_playwright_python.sync_playwright")
    only = {
        "resultTypes": ["violations"]
    }  # to tell what is right, node by node, takes most of its time
    found = axe.Axe().run(page, options=only).response["violations"]
    assert [
        (each["id"], [node["html"][:120] for node in each["nodes"][:3]]) for each in found
    ] == []


@pytest.mark.slow
@pytest.mark.parametrize("log", ["german", "NEES"])
def test_from_a_dropped_file_to_exported_c(
    log: str, served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    if log == "NEES" and not NEES.exists():
        pytest.skip(f"needs the measured data beside the project: {NEES}")
    page = open_page()
    page.set_input_files(
        "#file", str(NEES if log == "NEES" else german(tmp_path / "Prüfstand 1.csv"))
    )
    page.wait_for_url("**/log/**", timeout=120_000)  # a busy machine reads for long
    if log == "german":
        assert page.locator("[name='column.effort']").input_value() == "Drehmoment"
        page.select_option("[name='column.temperature']", "Temperatur")
        follow(page, "text=Read it so")
        assert "--temperature Temperatur" in page.locator("code").first.inner_text()
        page.wait_for_selector(
            "main:has-text('the file says 1/min')"
        )  # a Drehzahl in 1/min is certain
        assert page.locator(".check").count() == 0
    else:
        assert "no column for field" in page.locator("[role=alert]").inner_text()
        assert (
            page.locator(".check").count() == 4
        )  # time, slip, position and effort are guessed without a unit
        signals = (
            ("time", "t", "s"),
            ("field", "Y", "V"),
            ("slip", "V", "cm/s"),
            ("effort", "F", "N"),
        )
        signals += (("position", "D", "cm"),)
        for signal_, column, unit in signals:
            page.select_option(f"[name='column.{signal_}']", column)
            page.fill(f"[name='unit.{signal_}']", unit)
        assert (
            "--effort 'F [N]'" in page.locator("#read:has-text('--effort')").inner_text()
        )  # it follows the form
        follow(page, "text=Read it so")
        assert "understood" in page.locator(".good").inner_text()
        assert (
            "\N{MINUS SIGN}48.04 to 59.22 cm/s"
            in page.locator("tr:has([name='column.slip'])").inner_text()
        )
    page.check("[name='model.bingham']")
    page.fill("[name=lag]", "none")
    page.fill("[name=run]", f"run-{log}")
    page.click("button:has-text('Fit')")
    page.wait_for_url("**/run/**", timeout=120_000)  # the verdict, not the terminal
    assert "Bingham law" in page.locator("main").inner_text()
    report = page.frame_locator("iframe")
    report.locator("h1").wait_for(timeout=60_000)
    assert "Bingham law" in report.locator("body").inner_text()
    page.click("button:has-text('Export')")
    with page.expect_download(timeout=60_000) as download:
        page.get_by_text("Download").click(timeout=60_000)
    assert download.value.suggested_filename.endswith(".zip")
    made = next(path for path in served.folder.iterdir() if path.name.startswith(f"run-{log}-m1-c"))
    assert (
        json.loads((made / "export.json").read_text())["options"]["precision"] == "float32"
    )  # as usual in C
    follow(page, "text=Back to the run", "**/run/**")
    follow(page, f"a:has-text('{NEES.name if log == 'NEES' else 'Prüfstand 1.csv'}')")
    assert page.locator("[name='column.effort']").input_value() in ("F", "Drehmoment")
    run = json.loads((served.folder / f"run-{log}" / "run.json").read_text())
    assert run["recommended"] == "bingham"


@pytest.mark.slow
def test_a_log_is_remembered_fitted_again_and_nothing_is_offered_that_cannot_work(
    served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page, place = open_page(), f"http://127.0.0.1:{served.port}{served.base}"
    page.set_input_files("#file", str(german(tmp_path / "again.csv")))
    page.wait_for_url("**/log/**")
    page.select_option("[name='column.temperature']", "Temperatur")
    follow(page, "text=Read it so")
    for _ in range(2):  # the second time on the page as it stood before the first fit
        page.check("[name='model.quadratic']")
        page.fill("[name=lag]", "none")
        page.click("button:has-text('Fit')")
        page.wait_for_url("**/run/**", timeout=120_000)
        page.go_back()
        if "/job/" in page.url:
            page.go_back()
        page.wait_for_url("**/log/**")
    made = sorted(
        path.name for path in served.folder.iterdir() if path.name.startswith("again-run")
    )
    assert len(made) == 2
    page.goto(f"{place}/log/again.csv")
    assert page.locator("[name='column.temperature']").input_value() == "Temperatur"
    assert page.locator("[name=run]").input_value() not in made
    page.goto(f"{place}/run/{made[0]}")
    assert "this run has field in A" in page.locator("form[action$='/live']").inner_text()
    assert page.locator("form[action$='/live'] button").count() == 0
    assert served.ask("POST", f"/run/{made[0]}/live", b"model=quadratic")[0] == 400
    with page.expect_download(timeout=60_000) as download:
        page.get_by_text("Download the report").click(timeout=60_000)
    assert download.value.suggested_filename == f"{made[0]}-report.html"
    page.select_option("form[action$='/predict'] [name=log]", "again.csv")
    follow(page, "text=Look at it first", "**/log/again.csv?**")
    assert page.locator("[name='column.temperature']").input_value() == "Temperatur"


@pytest.mark.slow
def test_a_broken_log_a_cancelled_fit_and_two_tabs(
    served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page, other = open_page(390, "dark"), open_page()
    (tmp_path / "broken.parquet").write_bytes(b"PAR1" + os.urandom(500))
    page.set_input_files("#file", str(tmp_path / "broken.parquet"))
    # The page of the log says it, or on a busy machine the page of the progress.
    assert "broken.parquet" in page.locator("[role=alert]", has_text="broken").inner_text()
    for tab, log in ((page, "one.csv"), (other, "two.csv")):
        tab.goto(f"http://127.0.0.1:{served.port}{served.base}/")
        tab.set_input_files("#file", str(german(tmp_path / log)))
        tab.wait_for_url("**/log/**")
        tab.fill("[name=run]", f"run-{log}")
        tab.focus("button:has-text('Fit')")
        tab.keyboard.press("Enter")
        tab.wait_for_url("**/job/**")
    assert page.url != other.url
    body = b"run=run-two.csv&models=bingham"
    status, text = served.ask("POST", "/fit/two.csv", body)
    assert (status, "there is such a run already" in text) == (400, True)
    page.click("text=Cancel")
    page.locator("#state.cancelled").wait_for(timeout=20_000)
    follow(page, "text=Back to the log")
    assert page.locator("[name=run]").input_value() == "run-one.csv"
    assert not (served.folder / "run-one.csv").exists()
    other.click("text=Cancel")
    for width in (1440, 390):
        page.set_viewport_size({"width": width, "height": 900})
        for place in ("", "log/two.csv", "job/1"):
            page.goto(f"http://127.0.0.1:{served.port}{served.base}/{place}")
            assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_accessible(
    width: int, scheme: str, served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page = open_page(width, scheme)
    accessible(page)
    page.set_input_files("#file", str(german(tmp_path / "look.csv")))
    page.wait_for_url("**/log/**")
    page.locator("details").evaluate_all("all => all.forEach(d => d.open = true)")
    accessible(page)
    page.goto(f"http://127.0.0.1:{served.port}{served.base}/log/none.csv")
    accessible(page)


@pytest.mark.parametrize(
    ("low", "shown"), [(0.9, "Bingham law"), (-0.1, "none; nearest: Bingham law")]
)
def test_the_overview_says_that_a_run_recommends_nothing(low: float, shown: str) -> None:
    test = {"rmse": [1.0, 0.9, 1.1], "share": [0.3, 0.2, 0.4], "r2": [0.91, low, 0.95]}
    entry = {"name": "bingham", "title": "Bingham law", "sound": True, "test": test}
    body = {
        "ranking": [entry],
        "recommended": "bingham",
        "findings": [],
        "logs": [{"name": "bench.csv", "sha256": "0"}],
    }
    assert (
        run_row(Entry("bench.run", 0, 0.0), {**body, "units": {"effort": "N*m"}})["model"] == shown
    )
