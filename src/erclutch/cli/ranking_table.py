"""The terminal shows a comparison: the ranking, the recommendation, what to worry about."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from erclutch.cli.terminal import estimates, narrowed, number, with_unit
from erclutch.fit.choice.scoring import MANY_AT_REST, TOLERATED
from erclutch.logs.covering_stretches import STRETCHES
from erclutch.logs.held_out import constant_stretches, steps_without_a_gap
from erclutch.report.numbers.number_text import r2_text
from erclutch.signals.array import rms
from erclutch.signals.clock import stretches
from erclutch.signals.percent import percent
from erclutch.signals.units import amount

#: Models that are shown where not all of them are asked for.
SHOWN = 8

if TYPE_CHECKING:
    from erclutch.fit.choice.scoring import BandedFigure
    from erclutch.fit.comparison import Comparison, RankedModel


def _band(figure: BandedFigure) -> str:
    """The ends of a figure's band."""
    return f"{number(figure.low, 3)} - {number(figure.high, 3)}"


def _percent(figure: BandedFigure) -> str:
    """A share with its band in per cent; without one where it is ten times as much."""
    value, low, high = (100.0 * share for share in figure.to_list())
    if abs(value) >= 1e3:
        return "far worse"
    return f"{value:+.1f} % ({low:+.1f} .. {high:+.1f})"


def ranking(comparison: Comparison, width: int, *, whole: bool = False) -> Table:
    """Models, best test error first; on a narrow screen the less needed columns are left out.

    Args:
        comparison: what is shown.
        width: of the screen, in characters.
        whole: all models; else the first ones, and the recommended one in any case.
    """
    unit = comparison.data.units.effort
    shown = list(comparison.entries)
    if not whole:
        shown = shown[:SHOWN]
        if all(entry.name != comparison.recommended for entry in shown):
            shown[-1] = comparison.entry(comparison.recommended)  # it stands further down
    cells: dict[str, list[str]] = {
        "": ["*" if e.name == comparison.recommended else "" for e in shown],
        "id": [comparison.id_of(e.name) for e in shown],
        "model": [comparison.titles[e.name] for e in shown],
        "par.": [str(e.outcome.parameters) for e in shown],
        with_unit("test RMSE", unit): [number(e.test.rmse.value, zeros=True) for e in shown],
        "95 % band": [_band(e.test.rmse) for e in shown],
    }
    if any(e.by_log for e in shown):
        cells["by log"] = []
        for entry in shown:
            reach = ""  # smallest and largest error over the logs
            if entry.by_log is not None:
                low, high, _ = entry.by_log
                reach = f"{number(low, 3)} - {number(high, 3)}"
            cells["by log"].append(reach)
    cells["over the best"] = [
        "" if e.name == comparison.best else _percent(e.excess) for e in shown
    ]
    cells["of std"] = [percent(e.test.share.value, 1) for e in shown]
    cells["R2"] = [r2_text(e.test.r2.value) for e in shown]
    cells["max error"] = [number(e.test.largest.value, 3) for e in shown]
    cells["train RMSE"] = [number(e.train.rmse.value, zeros=True) for e in shown]
    cells["condition"] = ["" if e.outcome.weights else f"{e.outcome.condition:.0e}" for e in shown]
    if any(e.folds for e in shown):
        heading = f"{len(shown[0].folds)}-block RMSE"
        cells[heading] = []
        for entry in shown:
            of_all_blocks = np.sqrt(np.mean(np.square(entry.folds)))
            cells[heading].append(number(float(of_all_blocks)))
    less_needed = (
        "condition",
        "max error",
        "R2",
        "train RMSE",
        "over the best",
        "par.",
        "95 % band",
    )
    star = comparison.standing.word
    title = f"Models on the rows held out (* {star}; bands: for more rows of the same logs, not for other logs)"
    made = narrowed(title, cells, less_needed, width, left=3)
    made.columns[2].no_wrap = False  # a long title breaks; a number is never cut
    return made


def left_out(comparison: Comparison) -> str:
    """How many models the short table leaves out; empty for none."""
    more = len(comparison.entries) - SHOWN
    if more <= 0:
        return ""
    return f"{more} more model{'s' if more > 1 else ''}: --all shows every one, with its notes."


def prediction(entry: RankedModel, unit: str) -> list[str]:
    """What the band of a model holds, and what its figures say of other logs."""
    sentences: list[str] = []
    if entry.band is not None:
        held = entry.band.held
        over = (
            f", {percent(held.width / entry.band.plain)} of one width for all rows"
            if entry.band.plain
            else ""
        )
        worst = ""
        if held.worst < held.share:
            worst = f" ({percent(held.worst, 1)} in {held.where})"
        of_band = (
            f"Its 95 % prediction band holds {percent(held.share, 1)} of the rows held out{worst}; "
            f"mean width {amount(number(held.width, 3), unit)}{over}."
        )
        taught = entry.band.with_sensor
        if taught is not None:
            of_band += f" With a torque sensor: {percent(taught.share, 1)}, {amount(number(taught.width, 3), unit)}."
        sentences.append(of_band)
    if entry.by_log is None:
        sentences.append(
            "Rows of one log were held out: nothing here says how far another motion is off."
        )
    else:
        low, high, logs = entry.by_log
        # A further log is the lowest or the highest of all with a chance of 2 in logs + 1, if they are alike.
        between = (logs - 1) / (logs + 1)
        reach = amount(f"{number(low, 3)} to {number(high, 3)}", unit)
        sentences.append(
            f"By log its RMSE is {reach} ({logs} logs): for a further log like "
            f"these the RMSE lies between with a chance of {percent(between)}."
        )
    return sentences


def headline(comparison: Comparison) -> str:
    """The recommended model and how far it is off, in motion first; where none is recommended, the verdict."""
    chosen = comparison.entry(comparison.recommended)
    standing = comparison.standing
    if standing.sign_open or standing.why_none or not chosen.sound:
        return verdict(comparison)
    unit = comparison.data.units.effort
    overall = amount(number(chosen.test.rmse.value, zeros=True), unit)
    moving = _error_in_motion(comparison)
    in_motion = ""
    if moving is not None:
        in_motion = f"{amount(number(moving, zeros=True), unit)} in motion, and by "
    recommended = "is recommended: it errs by" if len(comparison.entries) > 1 else "errs by"
    return (
        f"{comparison.called(chosen.name)}, {recommended} {in_motion}{overall} over the rows held out, "
        f"{percent(chosen.test.share.value, 1)} of their standard deviation."
    )


def verdict(comparison: Comparison) -> str:
    """The recommendation in a sentence or two."""
    chosen = comparison.entry(comparison.recommended)
    called = comparison.called(chosen.name)
    standing = comparison.standing
    if standing.sign_open:
        return f"No model is recommended before the sign is settled: see the warning. The nearest is {called}."
    if standing.why_none:
        r2 = chosen.test.r2
        return (
            f"No model is recommended: the nearest, {called}, {standing.why_none} (R2 "
            f"{r2_text(r2.value)}, 95 % band {r2_text(r2.low)} to {r2_text(r2.high)}; a constant "
            f"would err by {percent(1 / chosen.test.share.value)} of that)."
        )
    if len(comparison.entries) == 1:
        return f"Only {called}, was fitted, so there is nothing to recommend it over."
    if not chosen.sound:
        return f"Nothing to recommend: these data identify no model's parameters. The nearest is {called}."
    unit = comparison.data.units.effort
    if chosen.validation is not None:
        # Training rows that no fit has seen chose it.
        known = {e.name: e.validation for e in comparison.entries if e.validation is not None}
        least = min(known, key=lambda name: known[name].value)
        place = "the least"
        if least != chosen.name:
            apart = f"by less than {percent(TOLERATED)} or by less than these rows can tell"
            place = f"as good as {comparison.called(least)}, by {number(known[least].value)}: they differ {apart}"
        over_physics = f" {why}" if (why := worth_its_freedom(comparison)) else ""
        validated = amount(number(known[chosen.name].value), unit)
        judged = amount(number(chosen.test.rmse.value), unit)
        better = ""  # the first model that errs by less on the rows held out, and why it is not recommended
        for entry in comparison.entries:
            if entry.turned_down:
                error = amount(number(entry.test.rmse.value), unit)
                of_better = comparison.called(entry.name)
                better = f" {of_better}, errs by {error} there and is not recommended: {entry.turned_down}."
                break
        return (
            f"Recommended: {called} ({chosen.outcome.parameters} parameters). The training rows chose it: with "
            f"{comparison.chosen_by} left out in turn it errs by {validated}, {place}."
            f"{over_physics} The rows held out chose nothing: there it errs by {judged}.{better}"
        )

    best = comparison.entry(comparison.best)
    of_best = comparison.called(best.name)
    if best.name == chosen.name:
        return f"Recommended: {called}. It is the best, and no simpler model is as good."
    if chosen.excess.value > TOLERATED and chosen.excess.low > 0.0:
        return (
            f"Recommended: {called}, the best model that can be trusted. {of_best}, errs by less, but see its "
            f"note above; the recommended model errs by {_percent(chosen.excess)} more."
        )
    doubt = "" if best.sound else ", not to be trusted: see its note above"
    return (
        f"Recommended: {called} ({chosen.outcome.parameters} parameters), the simplest model that is as good as "
        f"the best one, {of_best} ({best.outcome.parameters} parameters{doubt}): inside its 95 % band, "
        f"{amount(_band(best.test.rmse), unit)}, with an error {_percent(chosen.excess)} over its own."
    )


def worth_its_freedom(comparison: Comparison) -> str:
    """Why a model with a network goes before the best one with more physics; empty where there is none in question.

    `fit.choice.validation` recommends a freer model only where both hold.
    """
    chosen = comparison.entry(comparison.recommended)
    bound: dict[str, float] = {}
    for entry in comparison.entries:
        if entry.validation is not None and entry.outcome.freedom < chosen.outcome.freedom:
            bound[entry.name] = entry.validation.value
    if chosen.validation is None or not bound:
        return ""
    nearest = min(bound, key=lambda name: bound[name])
    error = amount(number(bound[nearest]), comparison.data.units.effort)
    return (
        f"The best model with more physics, {comparison.called(nearest)}, errs by {error} "
        f"over the same parts: clearly more, and nowhere less by as much."
    )


def held_out(comparison: Comparison) -> str:
    """Which rows were held out, where that is not the end of each log."""
    test = comparison.settings.test
    data = comparison.data
    if test == (STRETCHES,):
        count = len(stretches(comparison.test))
        return f"held out: {count} stretches that cover field, slip and motion as all rows do"
    if not isinstance(test, float | int):
        logs: list[str] = []
        for name, (start, stop) in zip(data.sources, data.source_rows, strict=True):
            if comparison.test[start:stop].all():
                logs.append(name)
        more = f" and {len(logs) - 6} more" if len(logs) > 6 else ""
        return f"held out: {', '.join(logs[:6])}{more}"
    if any(steps_without_a_gap(data, *rows) for rows in data.source_rows):
        where = "in the middle or at the beginning, so that some steps of the field are fitted and others judged"
        return f"held out: {percent(test)} of each stretch of one field, {where}"
    if any(constant_stretches(data, *rows) for rows in data.source_rows):
        end = f"the last {percent(test)} of each stretch of one field"
        return f"held out: {end}, since the end of the log has one field only"
    return ""


def at_rest(comparison: Comparison) -> str:
    """The error over rows in motion, where many of those held out are at rest."""
    error = _error_in_motion(comparison)
    if error is None:
        return ""
    chosen = comparison.entry(comparison.recommended)
    share = float(comparison.data.at_rest[comparison.test].mean())
    moving = amount(number(error, zeros=True), comparison.data.units.effort)
    overall = number(chosen.test.rmse.value, zeros=True)
    return (
        f"{percent(share)} of the rows held out are at rest. Over those in motion "
        f"{comparison.id_of(chosen.name)} errs by {moving}, not {overall}."
    )


def _error_in_motion(comparison: Comparison) -> float | None:
    """RMSE of the recommended model over the rows held out that move; None where few or all are at rest."""
    still = comparison.data.at_rest[comparison.test]
    share = float(still.mean())
    if share < MANY_AT_REST or share == 1.0:
        return None
    chosen = comparison.entry(comparison.recommended)
    error = (comparison.data.effort - chosen.predicted)[comparison.test]
    return rms(error[~still])


def parameters(comparison: Comparison) -> list[Table | str]:
    """Constants of the recommended model with intervals, published symbols where they differ; a network's count."""
    name = comparison.recommended
    outcome = comparison.entry(name).outcome
    shown: list[Table | str] = []
    if outcome.estimates:
        shown.append(estimates(f"Parameters of {comparison.called(name)}", outcome.estimates))
        published = [f"{symbol} = {number(value)}" for symbol, value in outcome.paper_form.items()]
        if published:
            shown.append(
                f"In the symbols as published, and the units above: {', '.join(published)}."
            )
    if outcome.weights:
        shown.append(f"{outcome.weights} weights of a network, which mean nothing one by one.")
    return shown


def notes(comparison: Comparison, *, whole: bool) -> list[str]:
    """What to worry about, a line a model.

    Args:
        comparison: what came out.
        whole: every model with its specification; else the recommended model, and the best where it is not sound.
    """
    lines: list[str] = []
    if whole:
        for entry in comparison.entries:
            name = f"{comparison.id_of(entry.name)} is {entry.name}"
            lines.append(f"  {'; '.join([name, *entry.notes])}")
        return lines
    spoken_of = [comparison.recommended]
    best = comparison.entry(comparison.best)
    if not best.sound and best.name != comparison.recommended:
        spoken_of.append(best.name)
    for name in spoken_of:
        entry = comparison.entry(name)
        if entry.notes:
            lines.append(f"  {comparison.called(name)}: {'; '.join(entry.notes)}")
    return lines
