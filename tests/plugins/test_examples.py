"""The example packages, installed into a fresh environment, do what our own plug-ins do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from erclutch.registry import names
from tests.support.warm_start import OF_OTHERS, WarmStart

pytestmark = pytest.mark.slow
ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(path.parent for path in (ROOT / "examples").glob("erclutch-*/pyproject.toml"))


TARGETS = (*names("erclutch.targets"), "arduino")
PACKAGES = {path.name for path in EXAMPLES}
#: Advice and points have one file of ours each and no how-to page yet.
WITHOUT_EXAMPLE = {"erclutch.advice", "erclutch.points"}
MODEL = "robertson-stiff+slew-rate"
#: Another order of operations, by ONNX Runtime and Octave: as for our own laws.
OTHER_ORDER = ("ONNX Runtime", "GNU Octave")


@dataclass(frozen=True)
class Environment:
    """A Python of its own; where it is warm, its commands start without the second that the start takes."""

    folder: Path
    warm: WarmStart | None = None

    @property
    def python(self) -> Path:
        return self.folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")

    @property
    def site(self) -> Path:
        """Where pip puts packages."""
        (place,) = self.folder.glob(
            "Lib/site-packages" if os.name == "nt" else "lib/python*/site-packages"
        )
        return place

    def run(self, *words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        environment = {
            key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "COLUMNS")
        }
        command = [str(self.python), *map(str, words)]
        if self.warm is not None and command[1:3] == ["-m", "erclutch"]:
            command[:3] = [str(self.warm.folder / "erclutch")]
        return subprocess.run(
            command,
            cwd=cwd,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )

    def erclutch(self, *words: object, cwd: Path | None = None) -> str:
        """What a command prints; it must succeed."""
        done = self.run("-m", "erclutch", *words, cwd=cwd)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def one_after_another(self, *commands: tuple[object, ...]) -> list[str]:
        """What each command prints; one Python runs them, which spares its start and the imports."""
        code = (
            "import contextlib, io, json, sys\nfrom erclutch.cli import main\nprinted = []\n"
            "for words in json.loads(sys.argv[1]):\n    with contextlib.redirect_stdout(io.StringIO()) as out:\n"
            "        assert main(words) == 0, words\n    printed.append(out.getvalue())\n"
            "print(json.dumps(printed))"
        )
        done = self.run(
            "-c", code, json.dumps([[str(word) for word in words] for words in commands])
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return json.loads(done.stdout)

    def fails(self, *words: object, cwd: Path | None = None) -> str:
        """What a command says on standard error; it must fail in one line, never with a traceback."""
        done = self.run("-m", "erclutch", *words, cwd=cwd)
        assert done.returncode in (2, 3), done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
        return done.stderr

    def pip(self, *words: object) -> None:
        """The pip of this Python acts on that one; nothing comes from the network."""
        command = [sys.executable, "-m", "pip", "--python", str(self.python), *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == 0, done.stdout + done.stderr

    def install(self, *packages: Path) -> None:
        self.pip("install", "-q", "--no-deps", "--no-index", "--no-build-isolation", *packages)


def fresh(folder: Path) -> Environment:
    """An environment that sees erclutch and what it depends on, and nothing that is installed in it."""
    venv.create(folder, with_pip=False)
    made = Environment(folder)
    (made.site / "below.pth").write_text(
        f"{ROOT / 'src'}\n{sysconfig.get_path('purelib')}\n", encoding="utf-8"
    )
    return made


@contextmanager
def started(made: Environment) -> Iterator[Environment]:
    """The environment with its Python warm: of erclutch and of its packages nothing is imported before a command."""
    # Only the path of a short folder fits a socket.
    with (
        tempfile.TemporaryDirectory(prefix="erclutch-") as place,
        WarmStart(Path(place), OF_OTHERS, made.python) as warm,
    ):
        yield replace(made, warm=warm)


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Environment]:
    """All examples, installed once for all tests."""
    made = fresh(tmp_path_factory.mktemp("plugins") / "env")
    made.install(*EXAMPLES)
    with started(made) as warm:
        yield warm


@pytest.fixture(scope="module")
def run(environment: Environment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run on a log of the TWIN: outside reader, outside law, outside stage."""
    folder = tmp_path_factory.mktemp("run")
    environment.erclutch(
        "simulate", "tracking-slow", "--seconds", 4, "--out", "twin.csv", cwd=folder
    )
    header, *rows = [
        line for line in (folder / "twin.csv").read_text("utf-8").splitlines() if line[:1] != "#"
    ]
    attributes = [f"@attribute '{label}' numeric" for label in header.split(",")]
    (folder / "twin.arff").write_text(
        "\n".join(["@relation twin", *attributes, "@data", *rows]), "utf-8"
    )
    words = ("--device", "coaxial", "--models", "rs", "--lag", "slew-rate", "--out", "run")
    said = environment.erclutch("fit", "twin.arff", *words, cwd=folder)
    assert MODEL in said
    return folder / "run"


def test_each_example_passes_its_own_tests(environment: Environment) -> None:
    words = ("-m", "pytest", "-v", "-p", "no:cacheprovider", "--import-mode=importlib")
    done = environment.run(*words, *EXAMPLES)
    assert done.returncode == 0, done.stdout + done.stderr
    for package in EXAMPLES:
        assert f"{package.name}/" in done.stdout, "it has no test"


def test_lists_name_package_and_version(environment: Environment) -> None:
    words = (("laws", "--plugins", "--json"), ("--help",), ("laws", "--json"), ("export", "--help"))
    plugins, page, laws, export_help = environment.one_after_another(*words)
    listed = json.loads(plugins)
    outside = {entry["package"]: entry for entry in listed if entry["package"] != "erclutch"}
    assert set(outside) == PACKAGES
    shown = {entry["group"] for entry in outside.values()}
    assert shown == {entry["group"] for entry in listed} - WITHOUT_EXAMPLE
    assert "effort-table" in page.partition("Of other packages")[2]
    assert "effort-table" not in page.partition("Of other packages")[0]
    assert all(entry["version"] == "0.1.0" and not entry["problem"] for entry in outside.values())
    names = [law["name"] for law in json.loads(laws)]
    place = names.index("robertson-stiff")  # on the ladder
    assert names[place - 1 : place + 2] == ["herschel-bulkley", "robertson-stiff", "seo-seo"]
    assert "arduino" in export_help


def test_a_run_and_its_report_name_them(environment: Environment, run: Path) -> None:
    model = json.loads((run / "models" / f"{MODEL}.json").read_text("utf-8"))
    needed = {entry["name"]: f"{entry['package']} {entry['version']}" for entry in model["plugins"]}
    assert needed == {
        "robertson-stiff": "erclutch-law-robertson-stiff 0.1.0",
        "slew-rate": "erclutch-stage-slew-rate 0.1.0",
    }
    assert "read by 'arff' of erclutch-reader-arff 0.1.0" in (run / "run.json").read_text("utf-8")
    environment.erclutch("report", run)
    page = (run / "report.html").read_text("utf-8")
    assert "<math>" in page
    assert "<mi>C</mi>" in page


@pytest.fixture(scope="module")
def exports(
    environment: Environment, run: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Path]:
    """The folder of each target, with what `verify` says of it in a file beside; one Python exports all."""
    place = tmp_path_factory.mktemp("exports")
    folders = {target: place / target for target in TARGETS}
    made = [("export", run, "--to", target, "--out", folder) for target, folder in folders.items()]
    said = environment.one_after_another(
        *made, *(("verify", folder, "--json") for folder in folders.values())
    )
    for folder, checks in zip(folders.values(), said[len(made) :], strict=True):
        folder.with_suffix(".json").write_text(checks, "utf-8")
    return folders


@pytest.mark.parametrize("target", TARGETS)
def test_export_gives_the_bits(exports: dict[str, Path], target: str) -> None:
    folder = exports[target]
    body = json.loads((folder / "export.json").read_text("utf-8"))
    assert len(body["plugins"]) == (3 if target == "arduino" else 2)
    checks = json.loads(folder.with_suffix(".json").read_text("utf-8"))
    assert checks
    for check in checks:
        assert check["passed"], check
        assert check["other_bits"] == 0 or check["where"].startswith(OTHER_ORDER), check


@pytest.mark.timed
def test_live_on_the_twin(environment: Environment, run: Path) -> None:
    model = run / "models" / f"{MODEL}.json"
    words = ("--run", model, "--headless", "--seconds", 1, "--priority", 0, "--json")
    figures = json.loads(environment.erclutch("live", *words))
    assert figures["frames"] > 500
    assert figures["origin"] == "TWIN"


@pytest.mark.timed
def test_live_on_a_rig_with_a_single_device(environment: Environment, tmp_path: Path) -> None:
    """Its recording is a log of one device as it stands: a model of it is fitted, and runs on the rig."""
    words = ("--rig", "brake", "--headless", "--priority", 0, "--json", "--program", "sine")
    recorded = ("--no-model", "--seconds", 6, "--record", "--folder", tmp_path)
    done = environment.run("-m", "erclutch", "live", *words, *recorded)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] > 3000
    assert (
        "field = coil current [A], drive = motor torque [N*m], effort = brake torque [N*m]"
        in done.stderr
    )
    (log,) = tmp_path.glob("*.mcap")
    said = environment.erclutch("inspect", log)
    assert "effort <- column effort [N*m] (guessed from its name)" in said
    assert "field2" not in said
    environment.erclutch(
        "fit", log, "--models", "bingham", "--lag", "lag", "--out", tmp_path / "run"
    )
    model = tmp_path / "run" / "models" / "bingham+lag.json"
    done = environment.run("-m", "erclutch", "live", *words, "--run", model, "--seconds", 1)
    assert done.returncode == 0, done.stderr
    assert "estimate [N*m]" in done.stderr
    refused = environment.fails("live", "--rig", "twin-brake", "--run", model)
    assert "the model's field is in A, and that of the rig in 1" in refused


def test_where_a_package_is_absent_one_line_says_what_to_install(
    environment: Environment, run: Path, tmp_path: Path
) -> None:
    exported = tmp_path / "exported"
    environment.erclutch("export", run, "--to", "arduino", "--out", exported)
    with started(fresh(tmp_path / "bare")) as bare:
        said = bare.fails("export", run, "--out", tmp_path / "more")
        assert "Install the package erclutch-law-robertson-stiff" in said
        said = bare.fails("verify", exported)
        assert "Install the package erclutch-law-robertson-stiff" in said
        said = bare.fails("live", "--run", run / "models" / f"{MODEL}.json")
        assert "Install the package erclutch-law-robertson-stiff" in said
        bare.install(*(path for path in EXAMPLES if "law" in path.name))
        assert "Install the package erclutch-stage-slew-rate" in bare.fails("verify", exported)
        bare.install(*(path for path in EXAMPLES if "stage" in path.name))
        assert "Install the package erclutch-target-arduino" in bare.fails("verify", exported)


_BROKEN = {
    "import": ("laws", "raise OSError('no licence')", "cannot be loaded: OSError: no licence"),
    "type": ("laws", "LAW = 5", "is of type int"),
    "works": (
        "laws",
        "from erclutch.models.laws.law import LawFamily\nLAW = LawFamily(lambda f: 1 / 0, '', '')",
        "Zero",
    ),
    "stage": ("stages", "STAGE = None", "is of type NoneType"),
    "target": ("targets", "LAW = lambda: None", "has no TITLE and no write and no verify"),
}


@pytest.fixture(scope="module")
def spoilt(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Environment]:
    """An environment for one package, which a test writes."""
    with started(fresh(tmp_path_factory.mktemp("spoilt") / "env")) as place:
        yield place


@pytest.mark.parametrize("case", _BROKEN)
def test_what_fails_is_named(run: Path, tmp_path: Path, spoilt: Environment, case: str) -> None:
    kind, text, said = _BROKEN[case]
    value = (
        "erclutch_law_robertson_stiff" + {"laws": ":LAW", "stages": ":STAGE", "targets": ""}[kind]
    )
    # What pip would leave there, without the seconds of its build.
    (spoilt.site / "erclutch_law_robertson_stiff.py").write_text(text, encoding="utf-8")
    info = spoilt.site / "erclutch_law_robertson_stiff-0.2.0.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: erclutch-law-robertson-stiff\nVersion: 0.2.0\n"
    )
    (info / "entry_points.txt").write_text(f"[erclutch.{kind}]\nrobertson-stiff = {value}\n")
    fit = ("fit", run.parent / "twin.csv", "--device", "coaxial", "--models")
    words = {
        "laws": (*fit, "robertson-stiff", "--lag", "none"),
        "stages": (*fit, "bingham", "--lag", "robertson-stiff"),
        "targets": ("export", tmp_path / "own", "--to", "robertson-stiff"),
    }[kind]
    if kind == "targets":
        spoilt.erclutch(*fit, "bingham", "--lag", "none", "--out", tmp_path / "own")
    line = spoilt.fails(*words)
    assert "'robertson-stiff' of erclutch-law-robertson-stiff 0.2.0" in line
    assert said in line
    assert "pip uninstall erclutch-law-robertson-stiff" in line
    listed = spoilt.run("-m", "erclutch", "laws", "--plugins").stdout.replace("\n", "")
    assert "erclutch-law-robertson-stiff 0.2.0" in listed


#: What another package's command may do wrong, and what is said of it.
_COMMANDS = {
    "import": ("raise OSError('no licence')", "cannot be loaded: OSError: no licence"),
    "exit at import": ("raise SystemExit(3)", "cannot be loaded: SystemExit: 3"),
    "no function": ("effort_table = 5", "is of type int, it must be Callable"),
    "nothing": ("", "has no attribute 'effort_table'"),
    "crash": ("def effort_table() -> None:\n    raise KeyError('run')", "failed: KeyError: 'run'"),
    "exit": ("def effort_table() -> None:\n    raise SystemExit('bye')", "failed: SystemExit: bye"),
    "error of ours": (
        "def effort_table() -> None:\n    from erclutch.errors import SettingError\n"
        "    raise SettingError('--rows 1', remedy='Give 2 or more')",
        "effort-table of erclutch-command-effort-table 0.2.0: --rows 1. Give 2 or more.",
    ),
}


@pytest.fixture(scope="module")
def hasty(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Environment]:
    """An environment with a package in the state that pip would leave, whose module a test writes."""
    place = fresh(tmp_path_factory.mktemp("hasty") / "env")
    info = place.site / "erclutch_command_effort_table-0.2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: erclutch-command-effort-table\nVersion: 0.2.0\n"
    )
    value = "erclutch_command_effort_table:effort_table"
    (info / "entry_points.txt").write_text(f"[erclutch.commands]\neffort-table = {value}\n")
    with started(place) as warm:
        yield warm


@pytest.mark.parametrize("case", _COMMANDS)
def test_a_command_that_fails_is_told_with_its_package(hasty: Environment, case: str) -> None:
    text, said = _COMMANDS[case]
    (hasty.site / "erclutch_command_effort_table.py").write_text(text, encoding="utf-8")
    line = hasty.fails("effort-table")
    assert said in line
    assert "effort-table" in line
    assert "erclutch-command-effort-table 0.2.0" in line
    page = hasty.erclutch("--help")
    assert "effort-table" in page.partition("Of other packages")[2]
    assert "hem" in hasty.erclutch("laws")
