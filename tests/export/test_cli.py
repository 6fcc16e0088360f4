"""erclutch export and erclutch verify."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.export.target_check import Check
from erclutch.models.law_model import TorqueModel
from tests.support.command import good, run

pytestmark = pytest.mark.slow


@pytest.fixture
def saved(law: Callable[..., TorqueModel], tmp_path: Path) -> Path:
    path = tmp_path / "hem.json"
    path.write_text(json.dumps(law("hem").to_dict()), encoding="utf-8")
    return path


def test_export_writes_the_folder(saved: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("export", str(saved), "--out", str(out), "--precision", "float32", "--name", "hem1")
    said = good(*words)
    made = {p.name for p in out.iterdir()}
    assert made == {
        "hem1.c",
        "hem1.h",
        "hem1_check.c",
        "hem1_vectors.h",
        "Makefile",
        "model.json",
        "export.json",
    }
    assert f"erclutch verify {out}" in said.replace("\n", "")


def test_angles_of_a_slow_loop_need_no_cutoff(saved: Path, tmp_path: Path) -> None:
    """The usual 150 Hz are beyond what a loop at 100 Hz carries, and nobody had asked for them."""
    out = tmp_path / "out"
    good("export", saved, "--out", out, "--inputs", "angles", "--period", "10ms")
    asked = json.loads((out / "export.json").read_text(encoding="utf-8"))["options"]
    assert asked["derivative"]["cutoff"] == 40.0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--to", "matlab"), "unknown target"),
        (("--name", "9"), "no name for C functions"),
        (("--limits", "1"), "no two efforts"),
        (("--limits=2,1",), "Give the smaller one first"),
        (("--model", "hem"), "needs the folder of a run"),
        (("--period", "-1"), "a period of -1 s"),
        (("--cutoff", "20"), "Add --inputs angles, or leave --cutoff out"),
        (("--derivative", "lowpass"), "Add --inputs angles, or leave --derivative out"),
    ],
)
def test_bad_words_give_one_error(
    saved: Path, tmp_path: Path, words: tuple[str, ...], says: str
) -> None:
    before = sorted(tmp_path.iterdir())
    done = run("export", saved, "--out", tmp_path / "out", *words)
    said = done.error
    assert done.code == 2
    assert says in said.replace("\n", " ")
    assert said.count("error:") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_verify_prints_a_difference_that_is_no_number_as_null(
    saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(folder: Path) -> list[Check]:
        return [Check("gcc", 7, other_bits=7, ulp=float("nan"))]

    monkeypatch.setattr("erclutch.export.verify_export", broken)
    (check,) = json.loads(
        good("verify", saved.parent, "--json", code=3), parse_constant=pytest.fail
    )
    assert check["ulp"] is None
    assert check["passed"] is False


def test_verify_prints_a_line_each(saved: Path, tmp_path: Path, need: Callable[..., None]) -> None:
    need("gcc")
    out = tmp_path / "out"
    good("export", saved, "--to", "python", "--out", out)
    said = good("verify", out)
    assert "Python, step" in said
    assert "Passed in all 2 places" in said
    checks = json.loads(good("verify", out, "--json"))
    assert [c["other_bits"] for c in checks] == [0, 0]
    assert all(c["passed"] for c in checks)
