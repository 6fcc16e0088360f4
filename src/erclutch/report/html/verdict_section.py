"""Verdict: which model, how good, what to worry about, what to do next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from erclutch.diagnostics.correlation import follows_acceleration
from erclutch.diagnostics.error_map import error_maps
from erclutch.diagnostics.material import Material
from erclutch.diagnostics.text import count, number, percent, span
from erclutch.evaluate import MANY_AT_REST, NEXT_TO_NOTHING, TOLERATED, independent_rows
from erclutch.export.program import c_name
from erclutch.report.section import Section

_FEW_INDEPENDENT = 0.02
_BLIND = 0.01
#: Share of the error's power that follows the acceleration from which the device is said to remember.
_LOOP = 0.1


class Verdict(Section):
    """The first thing that is read."""

    name: ClassVar[str] = "verdict"
    title: ClassVar[str] = "Verdict"
    short: ClassVar[str] = "Verdict"

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        body, effort = material.body, material.effort
        entry = material.run.entry(material.recommended)
        test = entry["test"]
        return {
            "headline": _headline(material, entry),
            "why": choice(body, effort.unit, effort.band),
            "facts": [
                (
                    f"RMSE on {count(body['test_rows'])} rows held out",
                    effort.of(test["rmse"][0]),
                    f"95 % band {effort.band(test['rmse'])}{_in_motion(material)}",
                ),
                (
                    "of the standard deviation",
                    percent(test["share"][0]),
                    f"{span(100 * _or_nan(test['share'][1]), 100 * _or_nan(test['share'][2]))} %",
                ),
                ("of the variance explained (R²)", number(test["r2"][0], 4), span(test["r2"][1], test["r2"][2], 4)),
                ("largest error", effort.of(test["largest"][0]), f"bias {effort.of(test['bias'], 2)}"),
            ],
            "against": _against(material),
            "worries": worries(material),
            "next": _next(material),
        }


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def _moving(material: Material) -> tuple[float, float, str]:
    """Shares of rows at rest, held out and training, and the error over the rows held out that move."""
    still, test = material.rows.data.at_rest, material.rows.test
    error = material.rows.residual(material.recommended)[test & ~still]
    rmse = material.effort.of(float(np.sqrt(np.mean(error**2)))) if error.size else ""
    return float(still[test].mean()), float(still[~test].mean()), rmse


def _in_motion(material: Material) -> str:
    """The error over rows in motion, where many of those held out are at rest."""
    share, _, rmse = _moving(material)
    return f"; in motion {rmse}" if share >= MANY_AT_REST and rmse else ""


def _headline(material: Material, entry: Mapping[str, Any]) -> dict[str, str]:
    test = entry["test"]
    return {
        "model": entry["name"],
        "title": entry["title"],
        "error": material.effort.of(test["rmse"][0]),
        "band": material.effort.band(test["rmse"]),
        "share": percent(test["share"][0]),
        "word": material.word,
    }


def choice(body: Mapping[str, Any], unit: str, band: Any) -> str:
    """Why this model, in a sentence."""
    entries = {e["name"]: e for e in body["ranking"]}
    best, chosen = entries[body["best"]], entries[body["recommended"]]
    more = chosen["excess_over_best"]
    if len(entries) == 1:
        return "It is the only model that was fitted, so there is nothing to recommend it over."
    if not chosen["sound"]:
        return "Nothing can be recommended: these data identify no model's parameters. This one comes nearest."
    if best is chosen:
        return "It is the best of all models, and no simpler one is as good."
    extra = f"{number(100 * more[0], 2)} % ({span(100 * _or_nan(more[1]), 100 * _or_nan(more[2]), 2)} %)"
    if more[0] > TOLERATED and more[1] > 0.0:
        return (
            f"It is the best model that can be trusted. {best['name']} errs by less, but: "
            f"{'; '.join(best['notes'])}. The error here is larger by {extra}."
        )
    doubt = (
        ""
        if best["sound"] or not best["notes"]
        else f" {best['name']} is not to be trusted: {'; '.join(best['notes'])}."
    )
    return (
        f"With {chosen['parameters_count']} parameters it is the simplest model that is as good as the best one, "
        f"{best['name']} with {best['parameters_count']}: inside its 95 % band of {band(best['test']['rmse'])} {unit}, "
        f"with an error {extra} over its own.{doubt}"
    )


def _against(material: Material) -> str:
    """How much better than the plainest model."""
    plain = next((s.name for s in material.shown if s.role == "baseline"), None)
    if plain is None:
        return ""
    mine = material.run.entry(material.recommended)["test"]["rmse"][0]
    theirs = material.run.entry(plain)["test"]["rmse"][0]
    if not mine or not theirs or mine >= theirs:
        return ""
    less = percent(1 - mine / theirs, 2)
    return f"{plain}, the plainest model here, errs by {material.effort.of(theirs)}: this one by {less} less."


def worries(material: Material) -> list[str]:
    """What may mislead, the gravest first; each a sentence or two."""
    body, entry = material.body, material.run.entry(material.recommended)
    found = [f"{_capital(f['message'])}." for f in body["findings"]]
    found += [f"{material.recommended}: {note}." for note in entry["notes"]]
    looks = (
        _empty(entry),
        _rest(material),
        _blind(material),
        _gap(material, entry),
        _loop(material),
        _memory(material),
        _bias(material, entry),
    )
    found += [text for text in looks if text]
    if material.badge in ("TWIN", "SYNTHETIC"):
        found.append("The data were made by a computer. What the figures say of a real device is a guess.")
    elif len(body["logs"]) == 1:
        found.append("One recording: the intervals know nothing of another day, another temperature or another device.")
    return found


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _empty(entry: Mapping[str, Any]) -> str:
    """Even the best of models may say nothing."""
    share = entry["test"]["share"][0]
    if share is None or share <= NEXT_TO_NOTHING:
        return ""
    return "It explains next to nothing of the rows held out: a constant would do about as well."


def _rest(material: Material) -> str:
    """Rows at rest are easy: many of them flatter the figures."""
    share, usual, rmse = _moving(material)
    if share < MANY_AT_REST or not rmse:
        return ""
    return (
        f"{percent(share, 2)} of the rows held out are at rest ({percent(usual, 2)} of the training rows), where "
        f"effort and errors are small: over those in motion the RMSE is {rmse}."
    )


def _blind(material: Material) -> str:
    share = max(m.blind_share for m in error_maps(material.rows, material.recommended))
    if share < _BLIND or any(f["subject"] == "coverage" for f in material.body["findings"]):
        return ""
    return f"{percent(share, 2)} of the rows held out lie where no training row does: see the error map."


def _gap(material: Material, entry: Mapping[str, Any]) -> str:
    train, test = entry["train"]["share"][0], entry["test"]["share"][0]
    if train is None or test is None or test < 1.25 * train:
        return ""
    return (
        f"The error is {percent(train, 2)} of the standard deviation on the training rows and {percent(test, 2)} on "
        "those held out: the two parts of the log differ, or the model has learnt its rows by heart."
    )


def _memory(material: Material) -> str:
    residual = material.rows.residual(material.recommended)[material.rows.test]
    free = independent_rows(residual**2) / residual.size
    if free > _FEW_INDEPENDENT:
        return ""
    return (
        f"Errors come in bouts: {count(residual.size)} rows tell as much of their size as "
        f"{count(max(1, round(free * residual.size)))} independent ones. The bands allow for that."
    )


def _loop(material: Material) -> str:
    """A hysteresis, as dampers with a compliant mount or a compressible fluid have it."""
    share = follows_acceleration(material.rows, material.recommended)
    if share < _LOOP:
        return ""
    return (
        f"{percent(share, 2)} of the error's power follows the acceleration: the device remembers (a loop of effort "
        "over slip), and a law of field and slip cannot."
    )


def _bias(material: Material, entry: Mapping[str, Any]) -> str:
    bias, rmse = entry["test"]["bias"], entry["test"]["rmse"][0]
    if bias is None or rmse is None or abs(bias) < 0.25 * rmse:
        return ""
    share = percent(abs(bias) / rmse, 2)
    return f"The mean error is {material.effort.of(bias, 2)}, {share} of the RMSE: a drift or an offset."


def _next(material: Material) -> list[dict[str, str]]:
    """What to do, with commands where there are any."""
    body = material.body
    steps = [(f"{_capital(f['remedy'])}.", "") for f in body["findings"]]
    if body["settings"]["lag"] == "none":
        text = "No model with a lag was tried. On a switched device it often matters more than the law."
        steps.append((text, "erclutch fit LOG --lag auto"))
    if not body["settings"]["blocks"]:
        text = "Ranking on the rows held out flatters the winner a little: cross-validate."
        steps.append((text, "erclutch fit LOG --blocks 5"))
    maps = error_maps(material.rows, material.recommended)
    if float(np.mean([m.empty_share for m in maps])) > 0.5:
        text = (
            "More than half of the field and slip range holds no row (error map): log there too, or keep away from it."
        )
        steps.append((text, ""))
    if follows_acceleration(material.rows, material.recommended) >= _LOOP:
        text = "Let networks see past rows, which can hold such a loop; test them on speeds that training did not have."
        steps.append((text, "erclutch fit LOG --past 5 20"))
    name = c_name(material.recommended)
    text = f"Take {material.recommended} to a controller: {name}_c/{name}.c, C99 in one file, with its check."
    steps.append((text, f"erclutch export {material.run.folder.name} --precision float32"))
    code = f'erclutch.read_run("{material.run.folder.name}").model().predict(rows)'
    steps.append(("Use the model in Python.", code))
    return [{"text": text, "code": code} for text, code in steps]
