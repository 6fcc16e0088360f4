"""Plug-ins of other packages by name: found, named where they fail, hidden behind ours."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from pathlib import Path

import pytest

from erclutch import registry
from erclutch.errors import PluginError, SettingError
from erclutch.registry import GROUPS, find, hidden, names, plugins, require
from erclutch.wings.rig.rig_plugins import UdpRig, hardware

Install = Callable[[str, str, str], None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Install, None, None]:
    """Makes a package with a module and entry points, as pip would."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(package: str, points: str, text: str) -> None:
        module = package.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
        about = tmp_path / f"{module}-1.5.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.5\n", encoding="utf-8")
        (about / "entry_points.txt").write_text(points, encoding="utf-8")
        registry._others.cache_clear()
        monkeypatch.delitem(sys.modules, module, raising=False)

    yield make
    monkeypatch.undo()
    registry._others.cache_clear()


def test_ours_are_files_and_need_no_list() -> None:
    assert {"bingham", "on-off", "rbfm"} <= set(names("erclutch.laws"))
    measured = {"mdf", "tdms", "ros2", "hdf5", "spreadsheet", "lvm", "jsonl"}
    assert {"mat", "mcap", "parquet", "text", *measured} <= set(names("erclutch.readers"))
    assert {"lag", "rise-fall", "dahl", "effort-lag", "inertia", "stiffness"} <= set(names("erclutch.stages"))
    assert {"c", "cpp", "simulink"} <= set(names("erclutch.targets"))
    for group in GROUPS:
        for plugin in plugins(group):
            assert plugin.own
            assert plugin.value is not None


def test_a_name_that_is_none_says_what_is_near() -> None:
    with pytest.raises(SettingError, match=r"unknown target 'pythn'\. Did you mean python\?"):
        find("erclutch.targets", "pythn")


def test_ours_win_and_that_is_said(install: Install) -> None:
    install("their-laws", "[erclutch.laws]\nbingham = their_laws:LAW\n", "raise RuntimeError\n")
    assert find("erclutch.laws", "bingham").own
    assert [plugin.label for plugin in hidden("erclutch.laws")] == ["their-laws 1.5"]
    assert names("erclutch.laws").count("bingham") == 1


def test_two_packages_of_one_name_are_refused(install: Install) -> None:
    for package in ("one-law", "two-law"):
        install(package, f"[erclutch.laws]\nmine = {package.replace('-', '_')}:LAW\n", "LAW = 1\n")
    with pytest.raises(PluginError, match=r"'mine' is in 2 packages: one-law, two-law.*pip uninstall two-law"):
        find("erclutch.laws", "mine")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def rig():\n    raise OSError('not plugged\\n in')", "failed: OSError: not plugged in"),
        ("def rig():\n    return 5", "returns a int; it must return a UdpRig"),
        ("rig = 5", "is of type int, it must be Callable"),
        ("import nothing_of_this_name", "cannot be loaded: ModuleNotFoundError"),
        ("import sys\nsys.exit(3)", "cannot be loaded: SystemExit: 3"),
        ("", "cannot be loaded: AttributeError"),
    ],
)
def test_a_rig_that_fails_is_named(install: Install, text: str, said: str) -> None:
    install("my-bench", "[erclutch.rigs]\nmine = my_bench:rig\n", text)
    with pytest.raises(PluginError, match=r"the rig .mine. of my-bench 1\.5") as caught:
        hardware("mine")
    assert said in str(caught.value)
    assert "pip uninstall my-bench" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_rig_comes_by_name(install: Install) -> None:
    text = (
        "from erclutch.wings.rig.rig_plugins import UdpRig\n"
        "def rig():\n    return UdpRig('mine', '10.0.0.1', 5005, 3)\n"
    )
    install("my-bench", "[erclutch.rigs]\nmine = my_bench:rig\n", text)
    assert hardware("mine") == UdpRig("mine", "10.0.0.1", 5005, 3)
    with pytest.raises(SettingError, match=r"unknown rig 'yours'.*Known are twin, twin-brake, replay, udp, mine"):
        hardware("yours")


@pytest.mark.parametrize(
    "wrong",
    [
        {"channels": {"speed": "x"}},
        {"channels": {"position": "wheel"}},
        {"device": "single", "channels": {"field2": "x"}},
        {"device": "single", "channels": {"position": "wheel [deg]"}},
        {"device": "single", "channels": {"effort": "[N]"}},
        {"device": "triple"},
        {"field_limit": 0.0},
        {"field_limit": float("nan")},
    ],
)
def test_a_rig_that_cannot_be(wrong: dict[str, object]) -> None:
    with pytest.raises(SettingError):
        UdpRig("mine", "10.0.0.1", 5005, **wrong)  # pyright: ignore[reportArgumentType]


def test_what_a_file_needs() -> None:
    entry = {"group": "erclutch.laws", "name": "mine", "package": "erclutch-law-mine", "version": "2.0"}
    with pytest.raises(
        PluginError, match=r"m\.json: the law 'mine' of erclutch-law-mine 2\.0 .*Install the package erclutch-law-mine"
    ):
        require([entry], "m.json")
    require([{**entry, "name": "bingham"}], "m.json")
    for damaged in (5, None, [5], [{}], "x", [{**entry, "package": "x; rm -rf /"}], [{**entry, "group": "os"}]):
        with pytest.raises(PluginError, match="names no plug-in"):
            require(damaged, "m.json")


def test_a_reader_that_is_broken_is_left_out_and_said(install: Install, tmp_path: Path) -> None:
    from erclutch.logs import read_table

    install("my-reader", "[erclutch.readers]\nmine = my_reader:READER\n", "1 / 0\n")
    log = tmp_path / "log.csv"
    log.write_text("t [s],F [N]\n0,1\n0.1,2\n", encoding="utf-8")
    table = read_table(log)
    assert table.rows == 2
    assert any("my-reader 1.5" in note and "left out" in note for note in table.notes)
