"""The report: from the run folder alone, complete in itself, the same bytes again, its figures those of the run."""

from __future__ import annotations

import ast
import base64
import hashlib
import json
import re
import shlex
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import erclutch
from erclutch.errors import printable
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.html.packed_rows import unpacked
from erclutch.report.html.provenance_section import command_of
from erclutch.report.html.report_file import may_write_report
from erclutch.report.html.report_page import SECTIONS, report_html, write_report
from erclutch.report.html.verdict_section import choice, next_steps
from erclutch.report.numbers.run_material import Material, material_of
from erclutch.report.plots.svg_painter import ticks as round_ticks
from erclutch.runs.run_folder import read_run
from erclutch.signals.origins import badge_of
from tests.support.command import good


@pytest.fixture(scope="module")
def html(material: Material) -> str:
    return report_html(material)


class Tags(HTMLParser):
    """Every start tag with its attributes, and the text of script elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self._inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = tag == "script"
        if self._inside:
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.scripts[-1] += data

    def handle_endtag(self, tag: str) -> None:
        self._inside = False


@pytest.mark.slow
def test_it_needs_nothing_from_outside(html: str) -> None:
    for tag, attributes in Tags(html).tags:
        assert tag not in ("link", "iframe", "img", "object", "embed", "form"), tag
        assert "src" not in attributes
        for name, value in attributes.items():
            assert not name.startswith("on"), f"{tag} {name}"
            assert name != "href" or (value or "").startswith("#")
    assert not re.search(r"@import|url\(", html)


@pytest.mark.slow
def test_only_its_own_scripts_may_run(html: str) -> None:
    tags = Tags(html)
    policy = next(a["content"] for t, a in tags.tags if t == "meta" and "http-equiv" in a) or ""
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    data, *scripts = tags.scripts
    json.loads(data)
    assert len(scripts) == 2
    for script in scripts:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy


def test_uplot_is_the_one_that_its_origin_names() -> None:
    folder = Path(erclutch.__file__).parent / "report" / "assets" / "uplot"
    origin = tomllib.loads((folder / "ORIGIN.toml").read_text())
    assert "MIT" in (folder / "LICENSE").read_text()
    for name, digest in origin["sha256"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest


@pytest.mark.slow
def test_all_sections_are_there(html: str) -> None:
    for section in SECTIONS:
        if section.folded:
            assert f'<details id="{section.name}"' in html
        else:
            assert f'<section id="{section.name}"' in html
            assert f'href="#{section.name}"' in html
    assert 'href="#details"' in html


def test_the_legend_over_the_band_names_what_is_drawn_and_nothing_else(html: str) -> None:
    """The grey band had no entry, and a model that the plot leaves out had one."""
    section = html.partition('<section id="band"')[2].partition("</section>")[0]
    legend, _, plot = section.partition('class="legend"')[2].partition("</p>")
    assert "band of the recommended model" in legend
    drawn = set(re.findall(r'<path class="line (\w+)"', plot))
    assert drawn == set(re.findall(r'<path class="line (\w+)"', legend))
    assert '<path class="band"' in plot


def test_the_verdict_says_what_the_run_says(html: str, material: Material) -> None:
    entry = material.run.entry(material.recommended)
    assert (
        f"<b>{entry['title']}</b> errs by <b>{material.effort.of(entry['test']['rmse'][0])}</b>"
        in html
    )
    for other in material.body["ranking"]:
        assert f'<span class="name">{other["title"]}' in html
        assert material.effort.band(other["test"]["rmse"]) in html


@pytest.mark.slow
def test_where_no_fit_is_sound_the_nearest_model_is_not_called_recommended(
    material: Material,
) -> None:
    unsound = [{**entry, "sound": False} for entry in material.body["ranking"]]
    run = replace(material.run, body={**material.body, "ranking": unsound})
    doubtful = report_html(replace(material, run=run))
    assert "Nothing can be recommended" in doubtful
    assert '<span class="tag">nearest</span>' in doubtful
    assert '<span class="tag">recommended</span>' not in doubtful
    assert '<span class="tag">recommended</span>' in report_html(material)


@pytest.mark.slow
def test_the_same_run_gives_the_same_bytes(html: str, kept_run: Path, tmp_path: Path) -> None:
    path = write_report(material_of(read_run(kept_run)), tmp_path / "again.html")
    assert path.read_text(encoding="utf-8") == html
    assert [p.name for p in tmp_path.iterdir()] == ["again.html"]


@pytest.mark.slow
def test_the_folder_alone_is_enough(html: str, kept_run: Path, tmp_path: Path) -> None:
    """Nothing is taken from the log or from where the run was made."""
    moved = Path(shutil.copytree(kept_run, tmp_path / kept_run.name))
    assert report_html(material_of(read_run(moved))) == html


@pytest.mark.slow
def test_packed_rows_are_those_of_the_run(html: str, material: Material) -> None:
    traces = json.loads(Tags(html).scripts[0])["traces"]
    rows = material.rows
    truth = {
        "measured": rows.data.effort,
        "field0": rows.data.elements[0].field,
        "slip0": rows.data.elements[0].slip,
    }
    truth |= {f"estimate:{n}": rows.predicted[n] for n in material.run.names}
    assert set(truth) < set(traces["channels"])
    for name, values in truth.items():
        made = traces["channels"][name]
        start, stop, bucket, data = made["layers"][-1]
        assert (start, stop, bucket) == (0, rows.data.rows, 1)
        back = unpacked(data) * made["step"] + made["middle"]
        assert np.abs(back - values).max() <= 0.51 * made["step"]
    (a, b), *_ = traces["test"]
    assert np.array_equal(np.flatnonzero(rows.test), np.arange(a, b))
    (first, begin), (last, end) = traces["time"]
    assert (first, last) == (0, rows.data.rows - 1)
    assert (begin, end) == (rows.data.clock.time[0], pytest.approx(rows.data.clock.time[-1]))


@pytest.mark.slow
def test_names_cannot_become_code(tmp_path: Path, kept_run: Path) -> None:
    """A log may be called anything."""
    from erclutch.models.model_file import digest_of

    run = Path(shutil.copytree(kept_run, tmp_path / "run"))
    body = json.loads((run / "run.json").read_text())
    evil = "</script><script>alert(1)</script><img src=x onerror=alert(1)>'\"&]]>\u2028\u202e\0\x1b${x}`x`.csv"
    body["logs"][0]["name"] = evil
    body["notes"] = [evil]
    body["findings"] = [{"level": "warning", "subject": "x", "message": evil, "remedy": evil}]
    body["digest"] = digest_of({k: v for k, v in body.items() if k != "digest"})
    (run / "run.json").write_text(json.dumps(body))
    html = report_html(material_of(read_run(run)))
    tags = Tags(html)
    assert len(tags.scripts) == 3
    assert not any(tag == "img" for tag, _ in tags.tags)
    assert json.loads(tags.scripts[0])["traces"]["logs"][0][0] == evil
    assert "alert(1)</script>" not in html


@pytest.mark.parametrize(
    ("origins", "badge"),
    [
        (["TWIN"], "TWIN"),
        (["SYNTHETIC", "SYNTHETIC"], "SYNTHETIC"),
        ([""], "RECORDING"),
        (["", "RECORDING", "HARDWARE"], "RECORDING"),
        (["", "TWIN"], "MIXED"),
    ],
)
def test_the_badge_comes_from_the_logs(origins: list[str], badge: str) -> None:
    assert badge_of(origins) == badge


def test_a_synthetic_run_says_so(html: str) -> None:
    assert 'class="badge synthetic"' in html
    assert "made by a computer" in html


# --- the command that repeats a run ----------------------------------------------------------------------------------


def test_the_command_repeats_the_run(material: Material) -> None:
    command = command_of(material.body)
    models = "quadratic bingham fnn-2 quadratic+lag bingham+lag fnn-2+lag bingham+lag+dahl/field"
    assert (
        command
        == f"erclutch fit log.csv --field 'field [V]' --models {models} --test 0.3 --lag none --out RUN"
    )


def test_every_setting_gets_into_the_command(material: Material) -> None:
    settings = {
        **material.body["settings"],
        "models": ["all"],
        "lag": "none",
        "test": ["b*", "c"],
        "blocks": 3,
    }
    settings |= {"friction": False, "offset": True, "seed": 4, "past": [1, 2], "polish": True}
    reading = {
        "device": "coaxial",
        "e1": "-A [V]",
        "input": ["D [cm]", "A"],
        "name_pattern": "{x}mm",
    }
    command = command_of({**material.body, "settings": settings, "reading": reading})
    assert command == (
        "erclutch fit log.csv --device coaxial '--E1=-A [V]' --input 'D [cm]' --input A --name-pattern '{x}mm' "
        "--test 'b*' --test c --lag none --blocks 3 --no-friction --offset --seed 4 --past 1 2 --polish --out RUN"
    )


def test_recordings_of_one_file_are_that_file_in_the_command(material: Material) -> None:
    """It named 'log.xlsx: Test A', which is no file."""
    names = ("two.xlsx: Test A", "two.xlsx: Test B", "a: b.csv")
    logs = [{**material.body["logs"][0], "name": name} for name in names]
    command = command_of({**material.body, "logs": logs, "reading": {"variable": "all"}})
    assert command.startswith("erclutch fit two.xlsx 'a: b.csv' --variable all --models ")


def test_a_fit_that_is_proposed_says_where_it_runs(
    material: Material, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run keeps names of logs, no paths: in another folder the command found no log."""
    monkeypatch.setitem(material.body["settings"], "lag", "none")
    (step,) = [
        step
        for step in next_steps(material)
        if step["text"].startswith("No model with a lag was tried.")
    ]
    assert step["text"].endswith("Fit again, in the folder of the log:")
    assert step["code"].startswith("erclutch fit log.csv ")


def test_a_run_from_python_has_no_command(material: Material) -> None:
    assert command_of({**material.body, "reading": None}) == ""


@pytest.mark.slow
def test_the_printed_command_gives_the_same_run(
    tmp_path: Path, run_maker: Callable[..., Path]
) -> None:
    """Byte for byte, as the report says."""
    import os
    import subprocess
    import sys

    run = run_maker(tmp_path, models=("quadratic",), lag="none")
    command = (
        command_of(read_run(run).body)
        .replace("RUN", "again")
        .replace("erclutch", f"{sys.executable} -m erclutch")
    )
    # The run was read by guesses; the option given agrees with them.
    subprocess.run(
        ["sh", "-c", command], cwd=tmp_path, check=True, capture_output=True, env=dict(os.environ)
    )
    for path in run.rglob("*"):
        if path.is_file() and path.name != "run.json":
            assert (tmp_path / "again" / path.relative_to(run)).read_bytes() == path.read_bytes()


# --- bad input --------------------------------------------------------------------------------------------------------


def test_never_over_what_is_no_report(tmp_path: Path) -> None:
    mine = tmp_path / "thesis.html"
    mine.write_text("<html>my thesis</html>")
    with pytest.raises(erclutch.ErclutchError, match="exists and is not a report"):
        may_write_report(mine)
    may_write_report(mine, force=True)
    with pytest.raises(erclutch.ErclutchError, match="its folder does not exist"):
        may_write_report(tmp_path / "no" / "report.html")
    with pytest.raises(erclutch.ErclutchError, match="this is a folder"):
        may_write_report(tmp_path)


@pytest.mark.slow
def test_an_earlier_report_is_replaced(tmp_path: Path, material: Material) -> None:
    path = write_report(material, tmp_path / "report.html")
    whole = path.read_bytes()
    path.write_bytes(whole + b" ")
    may_write_report(path)
    write_report(material, path)
    assert path.read_bytes() == whole, "it was written anew"


# --- axes -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 1.0), (-1910.0, 1863.0), (1e-5, 3e-5), (-0.5, 0.0)]
)
def test_ticks_are_round_and_inside(low: float, high: float) -> None:
    ticks = round_ticks(low, high, 6)
    assert 2 <= len(ticks) <= 7
    assert all(low - 1e-12 <= t <= high + 1e-12 for t in ticks)
    steps = np.diff(ticks)
    assert np.allclose(steps, steps[0])
    assert f"{steps[0]:e}"[0] in "125"


@pytest.mark.parametrize(("low", "high"), [(-4.8, 4.4), (-1.9, 1.9), (-0.99, 0.99)])
def test_no_axis_has_a_zero_alone(low: float, high: float) -> None:
    assert len(round_ticks(low, high, 4)) >= 3


def test_logarithmic_ticks() -> None:
    assert round_ticks(0.2, 2000.0, 6, log=True) == pytest.approx([1, 10, 100, 1000])
    assert len(round_ticks(30.0, 90.0, 6, log=True)) >= 1


@pytest.mark.slow
def test_the_next_step_is_the_controller(material: Material, tmp_path: Path) -> None:
    """The file that the report names is the one that its command writes."""
    from erclutch.report.html.verdict_section import VERDICT

    steps = VERDICT.fill(material)["next"]
    (step,) = (s for s in steps if s["code"].startswith("erclutch export"))
    assert step["code"] == f"erclutch export {material.run.folder.name} --precision float32"
    (file,) = re.findall(r"(\S+\.c),", step["text"])
    folder, name = file.split("/")
    good("export", material.run.folder, *step["code"].split()[3:], cwd=tmp_path)
    assert (tmp_path / folder / name).is_file()


@pytest.mark.parametrize(
    "name", ["$(touch stolen)", "`touch stolen`", "a b;c", "it's", "x\x1b[31m\u202ey\nz", '"']
)
def test_a_command_to_copy_is_one_command_whatever_the_folder_is_called(
    material: Material, name: str, tmp_path: Path
) -> None:
    from erclutch.report.html.verdict_section import VERDICT

    (tmp_path / name).symlink_to(material.run.folder)
    run = replace(material.run, folder=tmp_path / name)
    codes = [step["code"] for step in VERDICT.fill(replace(material, run=run))["next"]]
    assert all(code.isprintable() for code in codes)
    shell = [
        shlex.split(code)
        for code in codes
        if code.startswith(("erclutch export", "erclutch excite"))
    ]
    assert len(shell) > 0
    for words in shell:
        assert printable(name) in words
    (call,) = (code for code in codes if code.startswith("erclutch.predict"))
    arguments = call.removeprefix("erclutch.predict")
    assert ast.literal_eval(arguments) == (printable(name), "LOG")


def test_each_law_has_its_equation(html: str, material: Material) -> None:
    laws = [e["name"] for e in material.body["ranking"] if not e["fit"]["weights"]]
    assert len(laws) > 1
    for name in laws:
        (equation,) = re.findall(
            rf'aria-label="Equation of {re.escape(name)}">(.*?)</div>', html, re.DOTALL
        )
        symbols = unescape(re.sub(r"<[^>]+>", "", equation))
        for p in material.run.entry(name)["fit"]["parameters"]:
            if p["name"] in ("T_y", "eta", "T_f", "T_0"):
                assert p["name"].replace("_", "").replace("eta", "η") in symbols


@pytest.mark.slow
def test_a_mapping_file_is_part_of_what_repeats_the_run(tmp_path: Path) -> None:
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs import read
    from erclutch.logs.dataset import build_dataset
    from erclutch.logs.synthetic import write_synthetic_log
    from erclutch.runs.written_run import write_run

    log = tmp_path / "log.csv"
    write_synthetic_log(log, 3.0)
    toml = tmp_path / "log.toml"
    toml.write_text('[columns]\nfield = "field [V]"\n', encoding="utf-8")
    recording = read(log)
    found = compare(build_dataset(recording), Settings(models=("bingham",), lag="none"))
    run = write_run(tmp_path / "run", found, [recording], reading={})
    html = report_html(material_of(read_run(run)))
    assert "The same log, mapping file and this command" in html
    assert hashlib.sha256(toml.read_bytes()).hexdigest() in html
    assert "All by default" not in html


@pytest.mark.slow
@pytest.mark.parametrize("still", [0.0, 0.3])
def test_the_error_over_rows_in_motion(still: float, tmp_path: Path) -> None:
    """Where many rows held out are at rest, the figure over the others stands beside that over all."""
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs import recording_from_arrays
    from erclutch.logs.dataset import build_dataset
    from erclutch.report.html.verdict_section import VERDICT
    from erclutch.runs.written_run import write_run

    rng = np.random.default_rng(0)
    n = 4000
    slip = 3.0 * np.sin(np.arange(n) / 50)
    slip[n - int(0.3 * still * n) :] = 0.0
    field = np.repeat(rng.choice([0.0, 1.0, 2.0], n // 100), 100)
    effort = field * np.tanh(slip / 0.3) + rng.normal(size=n) * np.abs(slip)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    log = recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, units, rate=1000.0
    )
    found = compare(build_dataset(log), Settings(models=("bingham",), lag="none"))
    made = material_of(read_run(write_run(tmp_path / "run", found, [log])))
    moving = found.test & ~found.data.at_rest
    rmse = float(np.sqrt(np.mean((effort - found.entries[0].predicted)[moving] ** 2)))
    values = VERDICT.fill(made)
    assert (values["facts"][0][:2] == ("RMSE in motion", made.effort.of(rmse))) == (still > 0.1)
    assert (values["headline"]["error"] == made.effort.of(rmse)) == (still > 0.1)
    assert any(
        "at rest" in text and made.effort.of(rmse) in text for text in values["worries"]
    ) == (still > 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("mass", [0.05, -0.05])
def test_a_negative_inertia_is_explained(mass: float, tmp_path: Path) -> None:
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs import recording_from_arrays
    from erclutch.logs.dataset import build_dataset
    from erclutch.runs.written_run import write_run

    slip = 3.0 * np.sin(np.arange(3000) / 50)
    field = np.repeat(np.random.default_rng(0).choice([0.0, 1.0, 2.0], 30), 100)
    effort = field * np.tanh(slip / 0.3) + slip + mass * 1000 * np.gradient(slip)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    log = recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, units, rate=1000.0
    )
    found = compare(build_dataset(log), Settings(models=("bingham+inertia",), lag="none"))
    html = report_html(material_of(read_run(write_run(tmp_path / "run", found, [log]))))
    assert html.count("is negative. No mass is negative") == (
        2 if mass < 0 else 0
    )  # a worry, and below its table


@pytest.mark.slow
def test_both_clutches_of_a_pair_have_flow_curves(tmp_path: Path) -> None:
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs import recording_from_arrays
    from erclutch.logs.dataset import build_dataset
    from erclutch.report.html.picture_sections import FLOW_CURVES
    from erclutch.runs.written_run import write_run

    t = np.arange(4000) / 1000
    command = 0.4 * np.sin(5 * t)
    signals = {
        "E1": np.maximum(command, 0.0),
        "E2": np.maximum(-command, 0.0),
        "theta_dot": 40.0 + 10 * np.sin(9 * t),
        "alpha_dot": np.sin(3 * t),
        "T": command * 0.3 + 0.001 * np.sin(50 * t),
    }
    units = {"E1": "", "E2": "", "theta_dot": "rad/s", "alpha_dot": "rad/s", "T": "N*m"}
    log = recording_from_arrays(signals, units, rate=1000.0, device="coaxial")
    found = compare(
        build_dataset(log, device="coaxial"), Settings(models=("bingham/forward",), lag="none")
    )
    made = material_of(read_run(write_run(tmp_path / "run", found, [log])))
    values = FLOW_CURVES.fill(made)
    assert values is not None
    assert [(g["element"], len(g["plots"])) for g in values["groups"]] == [("CH1", 1), ("CH2", 1)]


def test_a_single_model_that_explains_nothing_is_not_recommended() -> None:
    figures = {"share": [1.2, 1.1, 1.3], "r2": [-0.4, -0.6, -0.2]}
    entry = {
        "name": "bingham",
        "sound": True,
        "test": figures,
        "excess_over_best": [0.0, 0.0, 0.0],
        "notes": [],
    }
    body = {"best": "bingham", "recommended": "bingham", "ranking": [entry], "findings": []}
    run = SimpleNamespace(names=["bingham"], entry=lambda name: entry)
    told = choice(cast(Any, SimpleNamespace(body=body, run=run, recommended="bingham")))
    assert told == (
        "No model is recommended. This is the only one that was fitted, and it explains nothing of the rows held out."
    )


@pytest.mark.slow
def test_a_log_without_a_field_has_no_curve_over_the_field(tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv", 2.0)
    good(
        "fit",
        "log.csv",
        "--field",
        "none",
        "--models",
        "bingham",
        "--lag",
        "none",
        "--out",
        "run",
        cwd=tmp_path,
    )
    good("report", "run", cwd=tmp_path)
    text = unescape((tmp_path / "run" / "report.html").read_text(encoding="utf-8"))
    model = text[text.index('id="model"') : text.index('id="ranking"')]
    assert "The log has no field" in model
    assert "Nearest, over slip" in model
    assert "over the field" not in model
    assert "as logged" not in model
