"""The verdict says which model, how good it is, what to worry about and do next; the ranking shows every model."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.errors import plural, printable
from erclutch.fit.choice.scoring import MANY_AT_REST, TOLERATED, independent_rows
from erclutch.fit.choice.standing import NEXT_TO_NOTHING, standing_of_run
from erclutch.registry import names
from erclutch.report.html.model_section import WITHOUT, why_not_measured
from erclutch.report.html.parameters_section import negative_gains
from erclutch.report.html.provenance_section import command_of
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import plain_symbol
from erclutch.report.numbers.model_stages import is_law
from erclutch.report.numbers.number_text import (
    capital,
    count,
    number,
    percent_text,
    r2_text,
    share_span,
    span,
)
from erclutch.report.numbers.run_material import Material
from erclutch.runs.every_row_folder import read_every_row
from erclutch.signals.array import rms
from erclutch.signals.origins import MIXED, RECORDING

_FEW_INDEPENDENT = 0.02
#: How a finding asks for a memory of the slip (`fit.history`).
_SETTING = re.compile(r"Fit with --lag (?P<stages>\S+)")
#: Models of the ranking that are read at once; the others are folded.
SHOWN = 8
#: How notes begin of which the section of the model tells more.
_TOLD_WITH_ITS_CONSTANTS = ("at a bound", "not identified", "test RMSE")


def _fill(material: Material) -> dict[str, Any]:
    """The first thing that is read."""
    body = material.body
    about = material.about
    effort = material.effort
    test = material.run.entry(material.recommended)["test"]
    rest = _rest(material)
    against = ""  # how much better than the plainest model
    plain = next((name for name, role in material.shown.items() if role == "baseline"), None)
    mine = test["rmse"][0]
    theirs = plain and material.run.entry(plain)["test"]["rmse"][0]
    if plain and mine and theirs and mine < theirs:
        less = percent_text(1 - mine / theirs, 2)
        against = (
            f"{material.titles[plain]}, the plainest model here, errs by {effort.of(theirs)}: "
            f"this one by {less} less."
        )
    # Rows at rest flatter a model. Where there are many, the error in motion comes first.
    matters = rest.held_out >= MANY_AT_REST and rest.moving > 0

    # Figures of the recommended model on the rows held out: what, how much, and a word on it.
    facts: list[tuple[str, str, str]] = []
    rows = count(body["test_rows"])
    error = effort.of(test["rmse"][0])
    if matters:
        moving = f"on {count(rest.moving)} rows held out that move"
        facts.append(("RMSE in motion", effort.of(rest.rmse), moving))
    over = f"RMSE on {'all ' if matters else ''}{rows} rows held out"
    facts.append((over, error, f"95 % band {effort.band(test['rmse'])}"))
    share, low, high = test["share"]
    of_spread = "of the standard deviation, all rows" if matters else "of the standard deviation"
    facts.append((of_spread, percent_text(share), f"{share_span(_or_nan(low), _or_nan(high))} %"))
    if not matters:
        texts = [r2_text(_or_nan(figure), 4).replace("-", "−") for figure in test["r2"]]
        r2, *ends = texts
        facts.append(("of the variance explained (R²)", r2, " to ".join(ends)))
    bias = f"bias {effort.of(test['bias'], 2)}"
    facts.append(("largest error", effort.of(test["largest"][0]), bias))
    return {
        "about": [text for text in (about.device, about.author, about.date) if text],
        "note": about.note,
        "tags": about.tags,
        "headline": {
            "model": material.title,
            "recommended": standing_of_run(body).word == "recommended",
            "error": effort.of(rest.rmse if matters else test["rmse"][0]),
            "share": percent_text(rest.share if matters else test["share"][0]),
            "word": material.word,
            "over_all": error if matters else "",
            "at_rest": percent_text(rest.held_out, 2),
        },
        "why": choice(material),
        "facts": facts,
        "against": against,
        "worries": worries(material),
        "next": next_steps(material),
    }


VERDICT = Section("verdict", "Verdict", "Verdict", _fill)


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


@dataclass(frozen=True)
class _Rest:
    """Rows at rest, where every model is right.

    Attributes:
        held_out, training: share of these rows that are at rest.
        moving: number of rows held out that move.
        rmse: over these rows; 0 where there are none.
        share: of the standard deviation of the effort over these rows.
    """

    held_out: float
    training: float
    moving: int
    rmse: float
    share: float


def _rest(material: Material) -> _Rest:
    still = material.rows.data.at_rest
    test = material.rows.test
    moving = test & ~still
    error = material.rows.residual(material.recommended)[moving]
    effort = material.rows.data.effort[moving]
    rmse = rms(error) if error.size else 0.0
    spread = float(np.std(effort)) if effort.size else 0.0
    return _Rest(
        held_out=float(still[test].mean()),
        training=float(still[~test].mean()),
        moving=error.size,
        rmse=rmse,
        share=rmse / spread if spread else float("nan"),
    )


def choice(material: Material) -> str:
    """Why this model, in a sentence."""
    if "recalibration" in material.body:
        return str(material.body["recalibration"]["verdict"])
    best = material.run.entry(material.body["best"])
    chosen = material.run.entry(material.recommended)
    alone = len(material.run.names) == 1
    why_none = standing_of_run(material.body).why_none
    if why_none:
        nearest = (
            "This is the only one that was fitted, and" if alone else "This one comes nearest, but"
        )
        return f"No model is recommended. {nearest} it {why_none}."
    if alone:
        return "It is the only model that was fitted, so there is nothing to recommend it over."
    if not chosen["sound"]:
        return "Nothing can be recommended: these data identify no model's parameters. This one comes nearest."
    if "chosen_by" in material.body:
        better = ""  # the first model that errs by less on the rows held out, and why it is not recommended
        for entry in material.body["ranking"]:
            if entry.get("turned_down"):
                error = material.effort.of(entry["test"]["rmse"][0])
                better = f" {entry['title']} errs by {error} there and is not recommended: {entry['turned_down']}."
                break
        return (
            f"The training rows chose it. They were divided into {material.body['chosen_by']}; each part was left out "
            f"in turn and estimated by models fitted to the others. On the parts left out no model with as much "
            f"physics erred clearly less, and no model with less physics erred less on every part. The rows "
            f"held out chose nothing.{better}"
        )
    if best is chosen:
        return "It is the best of all models, and no simpler one is as good."
    more, low, high = map(_or_nan, chosen["excess_over_best"])
    extra = f"{number(100 * more, 2)} % ({span(100 * low, 100 * high, 2)} %)"
    if more > TOLERATED and low > 0.0:
        return (
            f"It is the best model that can be trusted. {best['title']} errs by less, but: "
            f"{'; '.join(best['notes'])}. The error here is larger by {extra}."
        )
    doubt = ""
    if best["notes"] and not best["sound"]:
        doubt = f" {best['title']} is not to be trusted: {'; '.join(best['notes'])}."
    band = f"{material.effort.band(best['test']['rmse'])} {material.effort.unit}"
    return (
        f"With {chosen['parameters_count']} parameters it is the simplest model that is as good as the best one, "
        f"{best['title']} with {best['parameters_count']}: inside its 95 % band of {band}, with an error {extra} over "
        f"its own.{doubt}"
    )


def worries(material: Material) -> list[str]:
    """What may mislead, the gravest first; each a sentence or two."""
    body = material.body
    entry = material.run.entry(material.recommended)
    sentences = [f"{capital(finding['message'])}." for finding in body["findings"]]
    sentences += [
        f"{capital(note)}."
        for note in entry["notes"]
        if not note.startswith(_TOLD_WITH_ITS_CONSTANTS)
    ]

    # How many constants the data do not tell, and why the first of them.
    constants = entry["fit"]["parameters"]
    reasons = [(constant, why_not_measured(material, constant)) for constant in constants]
    lost = [(constant, why) for constant, why in reasons if why and why != WITHOUT]
    if lost:
        first, why = lost[0]
        symbols = ", ".join(plain_symbol(constant["name"]) for constant, _ in lost)
        were = "were" if len(lost) > 1 else "was"
        sentences.append(
            f"{len(lost)} of its {len(constants)} constants {were} not measured: {symbols}. "
            f"For {plain_symbol(first['name'])} ({first['meaning']}) {why}."
        )
    if entry["name"] in material.laws:
        sentences += negative_gains(material.laws[entry["name"]])

    # What is special about the rows held out.
    train = entry["train"]["share"][0]
    test = entry["test"]["share"][0]
    if test is not None and test > NEXT_TO_NOTHING:
        sentences.append(
            "It explains next to nothing of the rows held out: it errs there by about as much as they vary, or by more."
        )
    rest = _rest(material)
    if rest.held_out >= MANY_AT_REST and rest.moving:
        held_out = percent_text(rest.held_out, 2)
        sentences.append(
            f"{held_out} of the rows held out are at rest ({percent_text(rest.training, 2)} of the training rows). "
            f"Over those in motion the RMSE is {material.effort.of(rest.rmse)}."
        )
    if train is not None and test is not None and test >= 1.25 * train:
        on_those_held_out = percent_text(test, 2)
        sentences.append(
            f"The error is {percent_text(train, 2)} of the standard deviation on the training rows and "
            f"{on_those_held_out} on those held out: the two parts of the log differ, or the model has learnt its rows "
            "by heart."
        )

    # What is special about the errors: bouts, a bias.
    residual = material.rows.residual(material.recommended)[material.rows.test]
    independent = independent_rows(residual**2) / residual.size  # a share of all rows
    if independent <= _FEW_INDEPENDENT:
        as_many = count(max(1, round(independent * residual.size)))
        sentences.append(
            f"Errors come in bouts: {count(residual.size)} rows tell as much of their size as "
            f"{as_many} independent ones. The bands allow for that."
        )
    bias = entry["test"]["bias"]
    rmse = entry["test"]["rmse"][0]
    if bias is not None and rmse is not None and abs(bias) >= 0.25 * rmse > 0.0:
        share = percent_text(abs(bias) / rmse, 2)
        sentences.append(
            f"The mean error is {material.effort.of(bias, 2)}, {share} of the RMSE: a drift or an offset."
        )
    if material.badge not in (RECORDING, MIXED):
        sentences.append(
            "The data were made by a computer. What the figures say of a real device is a guess."
        )
    elif len(body["logs"]) == 1:
        sentences.append(
            "One recording: the intervals know nothing of another day, another temperature or another device."
        )
    return sentences


def next_steps(material: Material) -> list[dict[str, str]]:
    """What to do, with commands where there are any."""
    body = material.body
    steps: list[tuple[str, str]] = []  # what to do, and the command
    # A run keeps names of logs and no paths, which are of one machine.
    where = f", in the folder of the {plural(len(body['logs']), 'log')}"
    for remedy in dict.fromkeys(finding["remedy"] for finding in body["findings"]):
        setting = _SETTING.fullmatch(remedy)
        if setting is None:
            steps.append((f"{capital(remedy)}.", ""))
        else:  # a remedy that is a setting of the fit becomes the whole command
            command = _fit_again(body, {"lag": setting["stages"]})
            steps.append((f"Fit again with the memory of the slip{where}:", command))
    if body["settings"]["lag"] == "none":
        text = (
            "No model with a lag was tried. On a switched device it often matters more than the "
            f"law. Fit again{where}:"
        )
        steps.append((text, _fit_again(body, {"lag": "auto"})))
    folder = printable(material.run.folder.name)  # copied into a shell: it must see one word
    if not body["settings"]["blocks"] and "chosen_by" not in body:
        text = f"Ranking on the rows held out flatters the winner a little. Cross-validate{where}:"
        steps.append((text, _fit_again(body, {"blocks": 5})))
    empty = float(np.mean([cells.empty_share_at_its_fields for cells in material.error_maps]))
    if empty > 0.5:
        text = (
            "At the fields of the log more than half of the slip's range holds no row (error map): log there too, or "
            "keep away from it."
        )
        # The command is a wing's. It needs a law of the run, a field and a motion: else there is none to give.
        laws = [entry for entry in body["ranking"] if is_law(entry)]
        has_motion = not material.without_field and not material.rows.data.in_no_time
        command = ""
        if laws and has_motion and "excite" in names("erclutch.commands"):
            words = ["erclutch", "excite", "--run", folder, "--criterion", "fill"]
            if standing_of_run(body).why_none:  # the command has no law of its own to take
                words += ["--model", material.run.id_of(laws[0]["name"])]
            command = shlex.join([*words, "--out", "next.csv"])
        steps.append((text, command))
    if standing_of_run(body).why_none:
        return [{"text": text, "code": code} for text, code in steps]
    name = material.run.c_name
    text = f"Take it to a controller: {name}_c/{name}.c, C99 in one file, with its check."
    steps.append((text, shlex.join(["erclutch", "export", folder, "--precision", "float32"])))
    if "final" in body:
        text = f"The same model fitted to all {count(body['final']['rows'])} rows, which no figure here judges:"
        words = ["erclutch", "export", folder, "--model", "final"]
        steps.append((text, shlex.join([*words, "--precision", "float32"])))
    code = f'erclutch.predict({json.dumps(folder, ensure_ascii=False)}, "LOG")'
    steps.append(("Use the model in Python: LOG is a file, or a DataFrame in its place.", code))
    return [{"text": text, "code": code} for text, code in steps]


def _fit_again(body: Mapping[str, Any], changed: Mapping[str, Any]) -> str:
    """The command of this run's fit with some settings changed."""
    if body.get("recalibration") or not command_of(body):
        options: list[str] = []
        for key, value in changed.items():
            options += [f"--{key}", str(value)]
        return shlex.join(["erclutch", "fit", "LOG", *options])
    return command_of({**body, "settings": {**body["settings"], **changed}})


def _ranking(material: Material) -> dict[str, Any]:
    """The table of models: the first ones, and the others folded."""
    ranking = material.body["ranking"]
    first = ranking[:SHOWN]
    if all(entry["name"] != material.recommended for entry in first):
        first = [*first[:-1], material.run.entry(material.recommended)]
    left = [entry for entry in ranking if entry not in first]
    errors = [entry["test"]["rmse"] for entry in first]
    finite = [error for error in errors if error[0] is not None]
    longest_bar = 0.0
    if finite:
        # One model gone wild must not flatten the bars of all others.
        best_error, _, _ = finite[0]
        highest_end = max(high for _, _, high in finite)
        longest_bar = min(highest_end, 4.0 * best_error)

    folds: dict[str, float] = {}
    for entry in ranking:
        of_folds = entry["folds_rmse"]
        if of_folds and None not in of_folds:
            mean_square = sum(rmse * rmse for rmse in of_folds) / len(of_folds)
            folds[entry["name"]] = mean_square**0.5

    # Figures of every row of logs of which stretches were fitted.
    every_row: dict[str, Any] | None = None
    figures = read_every_row(material.run)
    if figures is not None:
        # Of the rows held out, and of those to fit, by model.
        known: dict[str, tuple[Any, Any]] = {}
        error_of: dict[str, float] = {}
        for name, scored in figures["models"].items():
            test = scored.get("test")
            train = scored.get("train")
            rmse = (test or train)["rmse"][0]
            if rmse is not None:
                known[name] = (test, train)
                error_of[name] = rmse
        ranked = sorted(error_of, key=lambda name: error_of[name])
        not_scored = figures["not_scored"].items()
        every_row = {
            "rows": count(figures["rows"]),
            "held_out": count(next((test["rows"] for test, _ in known.values() if test), 0)),
            "models": [(name, *known[name]) for name in ranked[:SHOWN]],
            "left": max(0, len(ranked) - SHOWN),
            "not_scored": {material.titles[name]: why for name, why in not_scored},
        }
    return {
        "first": first,
        "left": left,
        "every_row": every_row,
        "most": longest_bar or 1.0,
        "torn": any(error > longest_bar for error, _, _ in finite),  # bars that leave the scale
        "standing": standing_of_run(material.body).word,
        "folds": folds,
    }


RANKING = Section("ranking", "Models, best first", "Ranking", _ranking)
