"""Plug-ins of other packages by name: found, named where they fail, hidden behind ours."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from erclutch import cli, registry
from erclutch.cli import main
from erclutch.cli.ending_signal import EndingSignal
from erclutch.errors import PluginError, SettingError
from erclutch.logs.readers.budget import _OutOfTime
from erclutch.registry import GROUPS, find, hidden, names, plugins, require
from tests.support.installed_plugin import Install


@pytest.mark.slow
def test_ours_are_files_and_need_no_list() -> None:
    assert {"bingham", "on-off", "rbfm"} <= set(names("erclutch.laws"))
    measured = {"mdf", "tdms", "rosbag", "hdf5", "spreadsheet", "lvm", "jsonl"}
    assert {"mat", "mcap", "parquet", "text", *measured} <= set(names("erclutch.readers"))
    assert {"lag", "rise-fall", "dahl", "effort-lag", "inertia", "stiffness"} <= set(
        names("erclutch.stages")
    )
    assert {"c", "python"} <= set(names("erclutch.targets"))
    for group in GROUPS:
        for plugin in plugins(group):
            assert plugin.own
            assert plugin.value is not None


def test_a_name_that_is_none_says_what_is_near() -> None:
    with pytest.raises(SettingError, match=r"unknown target 'pythn'\. Did you mean python\?"):
        find("erclutch.targets", "pythn")


@pytest.mark.slow
def test_ours_win_and_that_is_said(install: Install) -> None:
    install("their-laws", "[erclutch.laws]\nbingham = their_laws:LAW\n", "raise RuntimeError\n")
    assert find("erclutch.laws", "bingham").own
    assert [plugin.label for plugin in hidden("erclutch.laws")] == ["their-laws 1.5"]
    assert names("erclutch.laws").count("bingham") == 1


@pytest.mark.slow
def test_two_packages_of_one_name_are_refused(install: Install) -> None:
    for package in ("one-law", "two-law"):
        install(package, f"[erclutch.laws]\nmine = {package.replace('-', '_')}:LAW\n", "LAW = 1\n")
    with pytest.raises(
        PluginError, match=r"'mine' is in 2 packages: one-law, two-law.*pip uninstall two-law"
    ):
        find("erclutch.laws", "mine")


@pytest.mark.slow
@pytest.mark.parametrize(
    "ends",
    [
        "raise KeyboardInterrupt",
        "raise SystemExit(0)",
        "import sys; sys.exit()",
        "raise GeneratorExit",
        "raise type('Own', (BaseException,), {'__str__': lambda self: 1 / 0})()",
    ],
)
def test_a_plug_in_that_ends_the_program_is_an_error_that_names_it(
    install: Install, ends: str
) -> None:
    groups = "".join(
        f"[erclutch.{group}]\nmine = my_plug:THING\n" for group in ("laws", "readers", "commands")
    )
    install("my-plug", groups, f"def THING(*_):\n    {ends}\n")
    guarded = find("erclutch.commands", "mine")
    with pytest.raises(
        PluginError,
        match=r"'mine' of my-plug 1\.5 failed: (KeyboardInterrupt|SystemExit|GeneratorExit|Own)",
    ):
        guarded.guarded(guarded.value)()
    with (
        pytest.raises(PluginError, match="the law 'mine'"),
        find("erclutch.laws", "mine").working(),
    ):
        guarded.value()


@pytest.mark.slow
def test_control_c_and_a_signal_of_the_system_end_a_plug_in_too(install: Install) -> None:
    install(
        "my-plug",
        "[erclutch.laws]\nmine = my_plug:LAW\n",
        "import signal\nLAW = signal.raise_signal\n",
    )
    law = find("erclutch.laws", "mine")
    # A shell's background jobs do not hear Control-C, and these tests may run in one.
    at_control_c = signal.signal(signal.SIGINT, signal.default_int_handler)
    at_kill = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with pytest.raises(KeyboardInterrupt), law.working():
            law.value(signal.SIGINT)
        EndingSignal().begin()
        with pytest.raises(SystemExit), law.working():
            law.value(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGINT, at_control_c)
        signal.signal(signal.SIGTERM, at_kill)


@pytest.mark.slow
def test_a_reader_that_is_too_slow_is_no_faulty_plug_in(install: Install) -> None:
    install("my-plug", "[erclutch.readers]\nmine = my_plug:READER\n", "READER = 1\n")
    with pytest.raises(_OutOfTime), find("erclutch.readers", "mine").working():
        raise _OutOfTime


def test_what_a_file_needs() -> None:
    entry = {
        "group": "erclutch.laws",
        "name": "mine",
        "package": "erclutch-law-mine",
        "version": "2.0",
    }
    with pytest.raises(
        PluginError,
        match=r"m\.json: the law 'mine' of erclutch-law-mine 2\.0 .*Install the package erclutch-law-mine",
    ):
        require([entry], "m.json")
    require([{**entry, "name": "bingham"}], "m.json")
    for damaged in (
        5,
        None,
        [5],
        [{}],
        "x",
        [{**entry, "package": "x; rm -rf /"}],
        [{**entry, "group": "os"}],
    ):
        with pytest.raises(PluginError, match="names no plug-in"):
            require(damaged, "m.json")


@pytest.mark.slow
def test_a_reader_that_is_broken_is_left_out_and_said(install: Install, tmp_path: Path) -> None:
    from erclutch.logs import read_table

    install("my-reader", "[erclutch.readers]\nmine = my_reader:READER\n", "1 / 0\n")
    log = tmp_path / "log.csv"
    log.write_text("t [s],F [N]\n0,1\n0.1,2\n", encoding="utf-8")
    table = read_table(log)
    assert table.rows == 2
    assert any("my-reader 1.5" in note and "left out" in note for note in table.notes)


@pytest.mark.slow
def test_a_law_of_another_package_is_fitted_only_where_it_is_named(install: Install) -> None:
    """Installing a package changes no figure of the default fit; a broken one does not end it."""
    from erclutch.models.laws import ladder

    ours = ladder()
    text = "from erclutch.models.laws.bingham import LAW as OURS\nfrom dataclasses import replace\n"
    install(
        "my-law",
        "[erclutch.laws]\nmine = my_law:LAW\n",
        text + "LAW = replace(OURS, ladder={'mine': 35})\n",
    )
    install("no-law", "[erclutch.laws]\nbroken = no_law:LAW\n", "1 / 0\n")
    assert ladder() == ours
    assert "mine" in names("erclutch.laws")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "x\x1b]0;PWN\x07\x1b[2J",
        "<img src=x onerror=alert(1)>",
        "$(touch x);`touch x`",
        "../../etc/passwd",
        "--out",
        "m" * 1_000_000,
        "\u202egnp",
    ],
)
def test_a_name_that_is_none_is_not_used_and_that_is_said(
    name: str,
    install: Install,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It went to the terminal as it was: the page of all commands had 20 MB, or emptied the screen."""
    monkeypatch.setenv("COLUMNS", "300")  # no sentence of the table is broken
    points = "".join(f"[{group}]\n{name} = odd_names:X\n" for group in GROUPS)
    install("odd-names", points, "raise RuntimeError\n")
    assert all(plugin.own for group in GROUPS for plugin in plugins(group))
    assert main(["--help"]) == 0
    assert "odd-names" not in capsys.readouterr().out
    assert main(["laws", "--plugins"]) == 0
    listed = capsys.readouterr().out
    assert listed.count("odd-names 1.5") == len(GROUPS)
    assert listed.count("not used: names of plug-ins") == len(GROUPS)
    assert "\x1b" not in listed
    assert len(listed) < 100_000


@pytest.mark.parametrize(
    ("file", "content"),
    [
        ("entry_points.txt", b"[erclutch.laws]\nna\xff\xfeme = odd:LAW\n"),
        ("entry_points.txt", b"[[[\n= = =\nno point\n"),
        ("METADATA", b"\xff\xfe\x00"),
        ("METADATA", b""),
    ],
)
def test_a_package_whose_own_files_cannot_be_read_stops_no_command(
    file: str, content: bytes, install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each command ended in a traceback."""
    install("odd", "[erclutch.commands]\nours = odd:run\n", "")
    install("sound", "[erclutch.commands]\ntheirs = sound:run\n", "")
    (tmp_path / "odd-1.5.dist-info" / file).write_bytes(content)
    registry._others.cache_clear()
    assert main(["--help"]) == 0
    assert "theirs" in capsys.readouterr().out


@pytest.mark.slow
def test_what_a_package_says_of_itself_is_short_and_only_shown(
    install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install("odd", "[erclutch.commands]\nours = odd:run\n", "")
    about = tmp_path / "odd-1.5.dist-info" / "METADATA"
    about.write_text(f"Name: odd\nVersion: 1\x1b[31m\nSummary: \x1b]0;PWN\x07{'s ' * 10**6}\n")
    assert main(["--help"]) == 0
    page = capsys.readouterr().out
    assert "ours" in page
    assert "\x1b" not in page
    assert len(page) < 10_000


@pytest.mark.slow
def test_a_library_that_stumbles_over_another_package_is_told_in_a_line(
    install: Install,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Numba looks through the plug-ins of all packages: `fit` ended in its traceback."""

    def run(words: object) -> int:
        raise UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte")

    monkeypatch.setattr(cli, "_run", run)
    with pytest.raises(UnicodeDecodeError):
        main(["fit"])
    install("odd", "[erclutch.laws]\nours = odd:LAW\n", "")
    (tmp_path / "odd-1.5.dist-info" / "entry_points.txt").write_bytes(b"[x]\n\xff = odd:LAW\n")
    assert main(["fit"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: the package odd in {tmp_path} has a list of plug-ins that")
    assert "pip uninstall odd" in said


@pytest.mark.slow
def test_who_ends_a_plug_in_that_hangs_is_told_its_name(
    install: Install, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(
        "hanging",
        "[erclutch.laws]\nmine = hanging:LAW\n",
        "import signal\nsignal.raise_signal(signal.SIGINT)\n",
    )
    monkeypatch.setattr(cli, "_run", lambda words: find("erclutch.laws", "mine").value)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert main(["fit"]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert "; the plug-in mine of hanging 1.5 was at work" in capsys.readouterr().err
