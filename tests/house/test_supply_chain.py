"""Packages and licences as `sbom.cdx.json` lists them; wheel and sdist as `make dist` builds them."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement

import erclutch

ROOT = Path(__file__).parents[2]
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
        asked = any(
            not wanted.marker or wanted.marker.evaluate({"extra": extra}) for extra in (*extras, "")
        )
        if asked and normal(wanted.name) not in found:
            found.add(normal(wanted.name))
            needed(wanted.name, frozenset(wanted.extras), found)
    return found


def stated(component: dict[str, Any]) -> str:
    """All that a component says of its licence."""
    entries = component["licenses"]
    return " ".join(
        e.get("expression") or e["license"].get("id") or e["license"]["name"] for e in entries
    )


def listed() -> dict[str, dict[str, Any]]:
    return {
        part["name"]: part for part in BILL["components"] if part["purl"].startswith("pkg:pypi/")
    }


@pytest.mark.slow
def test_the_bill_lists_each_package_that_runs_in_its_locked_version() -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    pins = {
        normal(name): version
        for name, version in re.findall(r"^([\w.-]+)==([^\s;]+)", lock, re.MULTILINE)
    }
    extras = frozenset(
        tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"][
            "optional-dependencies"
        ]
    )
    needs = needed("erclutch", extras, set())
    if any(metadata.version(name) != pins[name] for name in needs & set(pins)):
        pytest.skip(
            "the packages that are installed are others than the locked ones (make test-oldest, test-newest)"
        )
    assert len(needs) > 30
    assert needs <= set(listed()), "make sbom"
    assert {name: part["version"] for name, part in listed().items()} == {
        name: pins[name] for name in listed()
    }
    assert BILL["bomFormat"] == "CycloneDX"


@pytest.mark.slow
def test_what_only_an_extra_needs_is_optional() -> None:
    always = needed("erclutch", frozenset(), set())
    for name, part in listed().items():
        assert name not in always or part["scope"] == "required", name
    assert listed()["onnx"]["scope"] == "optional"


def test_the_bill_lists_what_stands_in_the_package() -> None:
    origin = tomllib.loads(
        (ROOT / "src/erclutch/report/assets/uplot/ORIGIN.toml").read_text(encoding="utf-8")
    )
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
    [
        ("GPL-3.0-only", True),
        ("GNU General Public License v3", True),
        ("MIT OR GPL-2.0-only", False),
        ("MIT", False),
    ],
)
def test_a_gpl_alone_is_seen(licence: str, alone: bool) -> None:
    assert all(GPL_ONLY.search(choice) for choice in re.split(r"\bOR\b", licence)) is alone


def test_the_conda_recipe_asks_for_what_the_wheel_asks_for() -> None:
    recipe = yaml.safe_load((ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    asked = [f"python{project['requires-python']}", *project["dependencies"]]
    assert [line.replace(" ", "") for line in recipe["requirements"]["run"]] == asked
    assert recipe["package"]["version"] == erclutch.__version__
    assert recipe["about"]["license_file"] == project["license-files"]


# --- wheel and sdist -------------------------------------------------------------------------------------------------


def built(folder: Path, umask: int, zone: str) -> dict[str, Path]:
    """What `make dist` makes of a clone of the last commit: files by ending."""
    clone = ["git", "clone", "--quiet", str(ROOT), str(folder)]
    subprocess.run(clone, check=True, umask=umask)
    surroundings = {**os.environ, "TZ": zone}
    # The environment that runs this test builds; the clone makes none of its own.
    command = [
        "make",
        "--no-print-directory",
        "dist",
        "-o",
        ".venv/.ready",
        f"BIN={Path(sys.executable).parent}",
    ]
    done = subprocess.run(
        command, cwd=folder, env=surroundings, umask=umask, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return {path.suffix: path for path in (folder / "dist").iterdir()}


@pytest.fixture(scope="module")
def wheel_and_sdist(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return built(tmp_path_factory.mktemp("one") / "clone", 0o022, "UTC")


@pytest.mark.slow
def test_another_folder_time_and_umask_make_the_same_bytes(
    wheel_and_sdist: dict[str, Path], tmp_path: Path
) -> None:
    again = built(tmp_path / "a longer name of a folder", 0o077, "Asia/Tokyo")
    assert set(again) == set(wheel_and_sdist) == {".whl", ".gz"}
    for ending, path in again.items():
        first = wheel_and_sdist[ending]
        assert path.name == first.name
        assert (
            hashlib.sha256(path.read_bytes()).digest()
            == hashlib.sha256(first.read_bytes()).digest()
        ), path.name


@pytest.mark.slow
def test_the_wheel_holds_the_licences_and_nothing_of_a_run(
    wheel_and_sdist: dict[str, Path],
) -> None:
    names = zipfile.ZipFile(wheel_and_sdist[".whl"]).namelist()
    licences = [
        name.partition(".dist-info/licenses/")[2]
        for name in names
        if ".dist-info/licenses/" in name
    ]
    assert sorted(licences) == ["LICENSE", "src/erclutch/report/assets/uplot/LICENSE"]
    assert "erclutch/report/assets/uplot/LICENSE" in names
    assert all(name.startswith(("erclutch/", "erclutch-")) for name in names)
    assert not [name for name in names if name.endswith((".pyc", ".so", ".o"))]


@pytest.mark.slow
def test_the_sdist_makes_the_same_wheel(wheel_and_sdist: dict[str, Path], tmp_path: Path) -> None:
    with tarfile.open(wheel_and_sdist[".gz"]) as archive:
        epoch = str(archive.getmembers()[0].mtime)
    # Python extracts without a warning only where it knows filters, which came with 3.11.4.
    subprocess.run(["tar", "-xf", wheel_and_sdist[".gz"], "-C", tmp_path], check=True)
    (source,) = tmp_path.iterdir()
    command = [
        sys.executable,
        "-m",
        "hatchling",
        "build",
        "-t",
        "wheel",
        "-d",
        str(tmp_path / "dist"),
    ]
    done = subprocess.run(
        command, cwd=source, env={**os.environ, "SOURCE_DATE_EPOCH": epoch}, capture_output=True
    )
    assert done.returncode == 0, done.stderr
    (again,) = (tmp_path / "dist").iterdir()
    assert again.read_bytes() == wheel_and_sdist[".whl"].read_bytes()


def link_packages(extras: frozenset[str], folder: Path) -> None:
    """Fill a folder with what erclutch says that it needs with some extras, and nothing else."""
    folder.mkdir(exist_ok=True)
    for name in needed("erclutch", extras, set()):
        package = metadata.distribution(name)
        for top in {file.parts[0] for file in package.files or ()} - {"..", "__pycache__"}:
            if not (folder / top).exists():
                (folder / top).symlink_to(Path(str(package.locate_file(top))).resolve())


class Installed:
    """The wheel in an environment of its own, run from an empty folder."""

    def __init__(self, wheel: Path, place: Path) -> None:
        self.folder = place / "empty"
        self.folder.mkdir()
        self.python = place / "venv" / "bin" / "python"
        subprocess.run(
            [sys.executable, "-m", "venv", "--without-pip", str(place / "venv")], check=True
        )
        self.site = Path(
            self.run(self.python, "-c", "import site; print(site.getsitepackages()[0])").strip()
        )
        link_packages(frozenset(), self.site)
        pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", self.python)
        self.run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel)

    def run(self, *command: str | Path, path: Path | None = None) -> str:
        surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        surroundings |= {} if path is None else {"PYTHONPATH": str(path)}
        done = subprocess.run(
            command, cwd=self.folder, env=surroundings, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def erclutch(self, *words: str) -> str:
        return self.run(self.python.parent / "erclutch", *words)


@pytest.fixture(scope="module")
def installed(
    wheel_and_sdist: dict[str, Path], tmp_path_factory: pytest.TempPathFactory
) -> Installed:
    return Installed(wheel_and_sdist[".whl"], tmp_path_factory.mktemp("installed"))


@pytest.mark.slow
def test_the_wheel_runs_in_an_empty_environment(
    installed: Installed, wheel_and_sdist: dict[str, Path]
) -> None:
    """Only the packages that it requires are there: no extra, no tool, no repository."""
    assert installed.run(
        installed.python, "-c", "import erclutch; print(erclutch.__file__)"
    ).startswith(str(installed.site))
    assert installed.erclutch("--version").split()[0] in wheel_and_sdist[".whl"].name
    assert "Recommended: " in installed.erclutch("demo", "--seconds", "10", "--out", "demo")
    log, model = "demo/twin.parquet", ("--models", "bingham", "--lag", "lag")
    assert "bingham" in installed.erclutch(
        "fit", log, "--device", "coaxial", *model, "--out", "one.run"
    )
    assert "one.html" in installed.erclutch("report", "one.run", "--out", "one.html")
    installed.erclutch("export", "one.run", "--out", "one_c")
    assert "gcc -O2" in installed.erclutch("verify", "one_c")


#: What each extra is for, as code that needs nothing else.
EXTRAS = {
    "sklearn": "from erclutch.estimators import LawRegressor",
    "calibrate": "import cma, erclutch.wings.paper.calibration.calibrate",
    "export": "import onnx, ziglang, erclutch.wings.exporters.targets.onnx",
    "live": "import ziglang, erclutch.wings.live.page.page_server",
    "compiler": "import ziglang",
    "formats": "import asammdf, nptdms, python_calamine, rosbags.highlevel",
    "cluster": "import distributed, erclutch.runs.cluster",
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "extra",
    tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"],
)
def test_each_extra_alone_brings_what_it_is_for(
    extra: str, installed: Installed, tmp_path: Path
) -> None:
    link_packages(frozenset({extra}), tmp_path / "more")
    assert "missing" not in installed.run(
        installed.python, "-c", EXTRAS[extra], path=tmp_path / "more"
    )
    alone = f"try:\n    {EXTRAS[extra]}\nexcept ImportError:\n    print('missing')"
    assert "missing" in installed.run(installed.python, "-c", alone)
