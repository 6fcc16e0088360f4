"""The section of the recommended model: where it turns, what was not measured and why, what its network adds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError, SettingError
from erclutch.export.monotone import monotone_share, worst_turn
from erclutch.report.html.model_section import MODEL, few_fields, why_not_measured
from erclutch.report.html.parameters_section import negative_gains
from erclutch.report.html.report_page import report_html
from erclutch.report.html.verdict_section import RANKING, VERDICT, worries
from erclutch.report.numbers.flow_curves import dwelled_fields, field_curves, flow_curves
from erclutch.report.numbers.run_material import Material
from erclutch.runs.run_about import (
    RunAbout,
    about_with,
    kept_about,
    moment_of,
    read_about,
    write_about,
)
from tests.support.command import good, refused
from tests.support.exported_models import law_model


def test_fields_at_which_a_log_dwells_are_found() -> None:
    switched = np.repeat([0.01, 2.25, 0.01, 2.25], 500) + 0.001 * np.sin(np.arange(2000))
    assert dwelled_fields(switched) == pytest.approx([0.01, 2.25], abs=2e-3)
    assert dwelled_fields(np.linspace(0.0, 2.0, 2000)).size == 0
    assert dwelled_fields(np.ones(10)).tolist() == [1.0]


def test_an_exponent_between_two_fields_was_not_measured(material: Material) -> None:
    switched = np.repeat([0.0, 2.0], material.rows.data.rows // 2)
    (element,) = material.rows.data.elements
    data = replace(material.rows.data, elements=(replace(element, field=switched),))
    two_fields = replace(material, rows=replace(material.rows, data=data))
    exponent = {"name": "n", "value": 4.0, "low": 3.8, "high": 4.0, "at_bound": "upper"}
    assert "the log dwells at 2 fields (0 V and 2.0 V)" in why_not_measured(
        two_fields, exponent
    ).replace("\xa0", " ")
    assert "upper end of the range" in why_not_measured(two_fields, exponent | {"name": "h_l"})
    assert "without this part" in why_not_measured(
        two_fields, exponent | {"name": "T_v", "value": 0.0}
    )
    assert "other constants" in why_not_measured(
        two_fields, exponent | {"name": "r", "at_bound": None, "low": None}
    )
    assert why_not_measured(two_fields, exponent | {"at_bound": None}) == ""


@pytest.mark.slow
def test_a_part_that_the_fit_is_best_without_is_not_needed_and_no_worry(material: Material) -> None:
    """A yield effort of zero, which a memory's effort stands in for, was said to be not measured."""
    run = material.run
    entry = run.entry(material.recommended)
    first = {**entry["fit"]["parameters"][0], "value": 0.0, "at_bound": "lower"}
    ranking = [
        {**each, "fit": {**each["fit"], "parameters": [first]}} if each is entry else each
        for each in run.body["ranking"]
    ]
    changed = replace(material, run=replace(run, body={**run.body, "ranking": ranking}))
    filled = MODEL.fill(changed)
    assert filled["halves"][0][0]["mark"] == "not needed"
    assert filled["lost"] == []
    assert not any("not measured" in worry for worry in worries(changed))


def test_the_fields_of_a_pair_are_those_of_the_element_that_has_most(material: Material) -> None:
    """A report said that a pair whose second clutch swept its field had nearly all rows at two fields."""
    data = material.rows.data
    (element,) = data.elements
    levels = replace(element, field=np.where(np.arange(data.rows) % 2, 500.0, 0.0))
    sweep = replace(element, field=np.linspace(0.0, 2000.0, data.rows))
    for elements, fields in (((levels, levels), [0.0, 500.0]), ((levels, sweep), [])):
        rows = replace(material.rows, data=replace(data, elements=elements))
        assert few_fields(replace(material, rows=rows)).tolist() == fields


def test_a_spring_that_pushes_along_is_told_with_the_way_out() -> None:
    """The joint of a robot got a spring of -14 N m/rad in place of its inertia, and no word of that."""
    model = law_model("bingham", "single", "stiffness")
    along = replace(model, gains={**model.gains, "k": -14.0})
    (told,) = negative_gains(along)
    assert "k, stiffness beside the fluid, is negative" in told
    assert "try a wider --window" in told
    assert negative_gains(model) == []


@pytest.mark.slow
def test_curves_without_a_spring_are_told_by_the_stage_that_has_one(material: Material) -> None:
    law = material.models[material.recommended]
    for stages, is_told in (("stiffness", True), ("inertia", False)):
        model = law_model("bingham", "single", stages)
        models = {
            **material.models,
            material.recommended: replace(model, trained_on=law.trained_on),
        }
        said = MODEL.fill(replace(material, fitted=models))["says"]
        assert any("without the spring" in sentence for sentence in said) == is_told


@pytest.mark.slow
def test_curves_of_the_model_are_its_settled_effort(material: Material) -> None:
    model = material.models[material.recommended]
    (over_slip,), over_field = (
        flow_curves(material.rows, {model.name: model}, 0, 1),
        field_curves(material.rows, model, 0, 1),
    )
    for k, field in enumerate(over_slip.fields):
        effort = model.steady([np.full(over_slip.slip.size, field)], [over_slip.slip])
        assert np.array_equal(over_slip.effort[k], effort)
    for k, slip in enumerate(over_field.slips):
        effort = model.steady([over_field.field], [np.full(over_field.field.size, slip)])
        assert np.array_equal(over_field.effort[k], effort)


def test_a_turn_lies_where_the_effort_goes_back(material: Material) -> None:
    """A law is monotone; the network of this run is not."""
    law = next(model for name, model in material.laws.items() if name.startswith("bingham"))
    assert monotone_share(law) == 1.0
    assert worst_turn(law).back == 0.0
    network = material.models[next(name for name in material.run.names if name.startswith("fnn"))]
    turn = worst_turn(network)
    assert (turn.back > 0.0) == (monotone_share(network) < 1.0)
    if turn.back:
        fields, slips = np.array(turn.fields), np.full(2, turn.slips[0])
        first, last = network.steady([fields], [slips])
        assert abs(first - last) == pytest.approx(turn.back)


@pytest.mark.slow
def test_the_model_stands_before_the_ranking_with_every_constant(material: Material) -> None:
    values = MODEL.fill(material)
    assert sum(map(len, values["halves"])) == len(
        material.run.entry(material.recommended)["fit"]["parameters"]
    )
    assert len(values["figures"]) == 3
    html = report_html(material)
    assert html.index('id="model"') < html.index('id="ranking"')


def test_eight_models_are_ranked_and_the_others_folded(material: Material) -> None:
    values = RANKING.fill(material)
    names = [entry["name"] for entry in (*values["first"], *values["left"])]
    assert len(values["first"]) == min(8, len(names))
    assert sorted(names) == sorted(material.run.names)
    last = replace(material.run, body={**material.body, "recommended": material.run.names[-1]})
    assert material.run.names[-1] in [
        entry["name"] for entry in RANKING.fill(replace(material, run=last))["first"]
    ]


@pytest.mark.slow
def test_figures_of_every_row_stand_in_the_page(
    material: Material, monkeypatch: pytest.MonkeyPatch
) -> None:
    scores = {
        entry["name"]: {"test": entry["test"], "train": entry["train"]}
        for entry in material.body["ranking"]
    }
    found = {
        "rows": 7_654_321,
        "models": scores,
        "not_scored": {material.run.names[-1]: "it needs its past rows"},
    }
    monkeypatch.setattr("erclutch.report.html.verdict_section.read_every_row", lambda run: found)
    html = report_html(material)
    assert "On every row" in html
    assert "7\xa0654\xa0321 rows" in html
    assert "it needs its past rows" in html


@pytest.mark.slow
def test_a_run_without_a_recommendation_shows_the_nearest(material: Material) -> None:
    run = replace(material.run, body={**material.body, "recommended": None})
    html = report_html(replace(material, run=run))
    assert "No model is recommended. The nearest" in html
    assert '<span class="tag">nearest</span>' in html


@pytest.mark.slow
def test_what_is_said_of_a_run_is_kept_and_shown(
    kept_run: Path, tmp_path: Path, material: Material
) -> None:
    import shutil

    run = Path(shutil.copytree(kept_run, tmp_path / "run"))
    said = (
        "--device-name",
        "Brake 7",
        "--author",
        "A. Smith",
        "--note",
        "after the\n repair",
        "--date",
        "2026-07-31",
    )
    good("report", run, "--title", "Winter test", *said)
    html = (run / "report.html").read_text(encoding="utf-8")
    for text in ("<h1>Winter test</h1>", "Brake 7", "A. Smith", "2026-07-31", "after the repair"):
        assert text in html
    good("report", run, "--note", "")
    assert kept_about(run) == RunAbout("Winter test", "Brake 7", "A. Smith", "2026-07-31")
    assert "2026-07-31 is no date" not in refused(
        "report", run, "--date", "31.07.2026", cwd=tmp_path
    )
    write_about(run, RunAbout())
    assert not (run / "about.json").exists()
    assert read_about(run).date, "the day on which the run was written"
    assert VERDICT.fill(material)["note"] == ""


@pytest.mark.parametrize("text", ['{"title": 3}', "[" * 100_000])
def test_a_spoilt_about_is_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "about.json").write_text(text)
    with pytest.raises(RunError, match=r"about\.json: cannot be understood"):
        read_about(tmp_path)
    with pytest.raises(SettingError, match="3,000 letters"):
        about_with(RunAbout(), note="x" * 3000)


@pytest.mark.parametrize(("panels", "four"), [(3, False), (4, True), (6, False)])
def test_four_curves_of_a_pair_without_a_rival_stand_in_one_row(
    material: Material, panels: int, four: bool
) -> None:
    from erclutch.report.html import report_page

    values = MODEL.fill(material)
    assert values is not None
    figures = [values["figures"][0]] * panels
    values |= {"figures": figures, "standing": "recommended"}
    html = report_page._body(report_page.templates(), MODEL, values)["html"]
    assert ('class="many four figures"' in html) == four


@pytest.mark.parametrize("changed", [0.0, -1e10, 1e12, -1e12, 2.0**62])
def test_a_time_that_no_calendar_has_is_left_out(changed: float) -> None:
    """Of a clock that was set wrong: the report, the table of a fleet and the page of all runs ended in a traceback."""
    moment = moment_of(changed)
    assert (moment is None) == (abs(changed) > 1e11)
