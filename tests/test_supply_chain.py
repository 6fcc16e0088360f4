"""Packages and licences as `sbom.cdx.json` lists them; wheel and sdist as `make dist` builds them."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
BILL: dict[str, Any] = json.loads((ROOT / "sbom.cdx.json").read_text(encoding="utf-8"))
#: Packages under the LGPL, which may be used by an Apache-2.0 program: readers of MDF4 and TDMS, both of an extra.
LESSER = {"asammdf", "nptdms"}
GPL_ONLY = re.compile(r"(?<![L])GPL|(?<!Lesser )General Public")


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def needed(name: str, extras: frozenset[str], found: set[str]) -> set[str]:
    """Packages that an installed package needs here, as their own metadata says it."""
    for line in metadata.requires(name) or ():
        wanted = Requirement(line)
        asked = any(not wanted.marker or wanted.marker.evaluate({"extra": extra}) for extra in (*extras, ""))
        if asked and normal(wanted.name) not in found:
            found.add(normal(wanted.name))
            needed(wanted.name, frozenset(wanted.extras), found)
    return found


def stated(component: dict[str, Any]) -> str:
    """All that a component says of its licence."""
    entries = component["licenses"]
    return " ".join(e.get("expression") or e["license"].get("id") or e["license"]["name"] for e in entries)


def listed() -> dict[str, dict[str, Any]]:
    return {part["name"]: part for part in BILL["components"] if part["purl"].startswith("pkg:pypi/")}


def test_the_bill_lists_each_package_that_runs_in_its_locked_version() -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    pins = {normal(name): version for name, version in re.findall(r"^([\w.-]+)==([^\s;]+)", lock, re.MULTILINE)}
    extras = frozenset(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"])
    needs = needed("erclutch", extras, set())
    assert len(needs) > 30
    assert needs <= set(listed()), "make sbom"
    assert {name: part["version"] for name, part in listed().items()} == {name: pins[name] for name in listed()}
    assert BILL["bomFormat"] == "CycloneDX"


def test_what_only_an_extra_needs_is_optional() -> None:
    always = needed("erclutch", frozenset(), set())
    for name, part in listed().items():
        assert name not in always or part["scope"] == "required", name
    assert listed()["onnx"]["scope"] == "optional"


def test_the_bill_lists_what_stands_in_the_package() -> None:
    origin = tomllib.loads((ROOT / "src/erclutch/report/assets/uplot/ORIGIN.toml").read_text(encoding="utf-8"))
    vendored = next(part for part in BILL["components"] if part["name"] == origin["name"])
    assert (vendored["version"], stated(vendored)) == (origin["version"], origin["licence"])


@pytest.mark.parametrize("part", BILL["components"], ids=lambda part: part["name"])
def test_no_licence_is_the_gpl_alone(part: dict[str, Any]) -> None:
    licence = stated(part)
    assert licence
    choices = re.split(r"\bOR\b", licence)
    assert not all(GPL_ONLY.search(choice) for choice in choices), licence
    assert "LGPL" not in licence or part["name"] in LESSER, licence


@pytest.mark.parametrize(
    ("licence", "alone"),
    [("GPL-3.0-only", True), ("GNU General Public License v3", True), ("MIT OR GPL-2.0-only", False), ("MIT", False)],
)
def test_a_gpl_alone_is_seen(licence: str, alone: bool) -> None:
    assert all(GPL_ONLY.search(choice) for choice in re.split(r"\bOR\b", licence)) is alone


# --- wheel and sdist -------------------------------------------------------------------------------------------------


def built(folder: Path, umask: int, zone: str) -> dict[str, Path]:
    """What `make dist` makes of a clone of the last commit: files by ending."""
    clone = ["git", "clone", "--quiet", str(ROOT), str(folder)]
    subprocess.run(clone, check=True, umask=umask)
    surroundings = {**os.environ, "TZ": zone}
    # The environment that runs this test builds; the clone makes none of its own.
    command = ["make", "--no-print-directory", "dist", "-o", ".venv/.ready", f"BIN={Path(sys.executable).parent}"]
    done = subprocess.run(command, cwd=folder, env=surroundings, umask=umask, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {path.suffix: path for path in (folder / "dist").iterdir()}


@pytest.fixture(scope="module")
def wheel_and_sdist(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return built(tmp_path_factory.mktemp("one") / "clone", 0o022, "UTC")


@pytest.mark.slow
def test_another_folder_time_and_umask_make_the_same_bytes(wheel_and_sdist: dict[str, Path], tmp_path: Path) -> None:
    again = built(tmp_path / "a longer name of a folder", 0o077, "Asia/Tokyo")
    assert set(again) == set(wheel_and_sdist) == {".whl", ".gz"}
    for ending, path in again.items():
        first = wheel_and_sdist[ending]
        assert path.name == first.name
        assert hashlib.sha256(path.read_bytes()).digest() == hashlib.sha256(first.read_bytes()).digest(), path.name


@pytest.mark.slow
def test_the_wheel_holds_the_licences_and_nothing_of_a_run(wheel_and_sdist: dict[str, Path]) -> None:
    names = zipfile.ZipFile(wheel_and_sdist[".whl"]).namelist()
    licences = [name.partition(".dist-info/licenses/")[2] for name in names if ".dist-info/licenses/" in name]
    assert sorted(licences) == ["LICENSE", "src/erclutch/report/assets/uplot/LICENSE"]
    assert "erclutch/report/assets/uplot/LICENSE" in names
    assert all(name.startswith(("erclutch/", "erclutch-")) for name in names)
    assert not [name for name in names if name.endswith((".pyc", ".so", ".o"))]


@pytest.mark.slow
def test_the_wheel_runs_in_an_empty_environment(wheel_and_sdist: dict[str, Path], tmp_path: Path) -> None:
    """Packages it needs come from this environment, erclutch itself from the wheel alone."""
    venv = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    python = venv / "bin" / "python"
    site = Path(
        subprocess.check_output([python, "-c", "import site; print(site.getsitepackages()[0])"], text=True).strip()
    )
    here = next(Path(place) for place in sys.path if (Path(place) / "numpy").is_dir())
    (site / "needed.pth").write_text(f"{here}\n", encoding="utf-8")
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def run(*command: str | Path) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=surroundings, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    install = ("install", "--quiet", "--no-deps", "--no-index", wheel_and_sdist[".whl"])
    run(sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", python, *install)
    assert run(python, "-c", "import erclutch; print(erclutch.__file__)").startswith(str(site))
    assert run(venv / "bin" / "erclutch", "--version").strip() in wheel_and_sdist[".whl"].name
    write = "from erclutch.logs.synthetic import write_synthetic_log; write_synthetic_log('log.csv')"
    run(python, "-c", write)
    assert "bingham" in run(venv / "bin" / "erclutch", "fit", "log.csv", "--models", "bingham", "--out", "one.run")
    assert (tmp_path / "one.run" / "run.json").is_file()
