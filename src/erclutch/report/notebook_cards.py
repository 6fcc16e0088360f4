"""Each class that shows itself has a card: a name, facts, a table, and how its pictures and its DataFrame are made.

Only the name and the facts are made at once. `erclutch.report.notebook` draws cards.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.report.numbers.number_text import capital, count, number, percent, span, unit_text
from erclutch.report.plots.plot_description import Axis, Dots, Line, Mark, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.signals.recording import TEMPERATURE

if TYPE_CHECKING:
    from pandas import DataFrame

    from erclutch.fit.comparison import Comparison, RankedModel
    from erclutch.fit.outcome import Estimate, FitOutcome
    from erclutch.logs.dataset import Dataset
    from erclutch.models.model import Model
    from erclutch.report.numbers.run_material import Material
    from erclutch.runs.run_folder import Run
    from erclutch.signals.recording import Recording
    from erclutch.wings.align.aligned_logs import AlignedLogs
    from erclutch.wings.fleet.fleet import Fleet
    from erclutch.wings.rheology.flow_curve import FlowCurve, FlowFit

_SECTION = 600  # rows of a log in a small picture
_WORRIES = 3
_CURVES, _POINTS = 5, 81
_ESTIMATES = ("parameter", "value", "low", "high", "unit", "meaning")
_FITS = ("device", "model", "parameters", "rmse", "rmse_low", "rmse_high", "effort_unit", "share")
_NUMBER = re.compile(r"  \w+ +=  *-?[\d.e+-]+$")  # of an equation's lines; the table has the numbers
_EXTENT = ("signal", "unit", "lowest", "mean", "highest")


def _nothing() -> Sequence[Any]:
    return ()


@dataclass(frozen=True)
class NotebookCard:
    """What is shown of a value.

    Attributes:
        name: of the value, as its file or its model calls it.
        facts: phrases for a line.
        table: the summary, unrounded.
        badge: TWIN or another word where the data are no recording.
        lines: of an equation.
        says: sentences: the verdict and what to worry about.
        panels: small pictures.
        frame: all rows as a DataFrame; None: they are the table.
        plots: what each plot draws, the first by default.
    """

    name: str
    facts: Sequence[str]
    table: Callable[[], PlotTable]
    badge: str = ""
    lines: Sequence[str] = ()
    says: Callable[[], Sequence[str]] = _nothing
    panels: Callable[[], Sequence[Panel]] = _nothing
    frame: Callable[[], DataFrame] | None = None
    plots: Mapping[str, Callable[..., Plot]] = field(default_factory=dict[str, Callable[..., Plot]])


def card_of(value: Any) -> NotebookCard:
    """The card of a value, by the name of its class."""
    return next(_CARDS[kind.__name__] for kind in type(value).__mro__ if kind.__name__ in _CARDS)(value)


def _named(name: str, unit: str | None) -> str:
    """A column's name with its unit, as readers of logs understand it."""
    return f"{'temperature' if name == TEMPERATURE else name} [{unit}]" if unit and unit != "?" else name


def _frame(columns: Mapping[str, Any], index: str | None = None) -> DataFrame:
    from pandas import DataFrame

    made = DataFrame(dict(columns))
    return made if index is None else made.set_index(index)


def _extent(columns: Mapping[str, tuple[Array, str]]) -> PlotTable:
    rows = [(name, unit, float(x.min()), float(x.mean()), float(x.max())) for name, (x, unit) in columns.items()]
    return PlotTable(_EXTENT, rows)


def _stretches(found: int) -> list[str]:
    return [f"{count(found)} stretches"] if found > 1 else []


def _rate(period: float) -> str:
    return f"{number(1 / period, 4)} Hz"


# --- logs -------------------------------------------------------------------------------------------------------------


def _recording(log: Recording) -> NotebookCard:
    from erclutch.report.plots.log_plots import describe_section

    columns = {name: (x, log.units.get(name, "")) for name, x in log.signals.items()}
    columns |= {n: (x, "") if n != TEMPERATURE else (x, "K") for n, x in {**log.extras, **log.spare}.items()}

    def section(*, start: float | None = None, seconds: float | None = None) -> Plot:
        width = min(log.duration, _SECTION * log.period) if seconds is None else seconds
        return describe_section(log, start=start, seconds=width)

    return NotebookCard(
        log.name,
        [f"{count(log.rows)} rows", f"{number(log.duration, 4)} s at {_rate(log.period)}"]
        + _stretches(len(log.segments))
        + [_named(name, unit) for name, (_, unit) in list(columns.items())[:8]],
        lambda: _extent(columns),
        badge=log.origin,
        panels=lambda: section().panels if {"effort", "T"} & set(log.signals) else (),
        frame=lambda: _frame(
            {"time [s]": log.time, **{_named(name, unit): x for name, (x, unit) in columns.items()}}, "time [s]"
        ),
        plots={"section": section} if {"effort", "T"} & set(log.signals) else {},
    )


def _signals_of(data: Dataset) -> dict[str, tuple[Array, str]]:
    extras = {name: (x, "") for name, x in data.extras.items()}
    return {**data.named_signals, "effort": (data.effort, data.units.effort), **extras}


def _rows_of(data: Dataset, more: Mapping[str, Any] | None = None) -> DataFrame:
    columns: dict[str, Any] = {"time [s]": data.clock.time}
    if len(data.sources) > 1:
        columns["log"] = np.repeat(data.sources, [b - a for a, b in data.source_rows])
    columns |= {_named(name, unit): x for name, (x, unit) in _signals_of(data).items()}
    return _frame({**columns, **(more or {})}, "time [s]")


def _badge(origins: Sequence[str]) -> str:
    found = {*origins} - {""}
    return "MIXED" if found and len({*origins}) > 1 else next(iter(found), "")


def _dataset(data: Dataset) -> NotebookCard:
    from erclutch.report.plots.log_plots import describe_coverage

    facts = [data.device, f"{count(data.rows)} rows", f"{number(data.duration, 4)} s at {_rate(data.period)}"]
    return NotebookCard(
        data.where,
        [*facts, *_stretches(len(data.clock.spans))],
        lambda: _extent(_signals_of(data)),
        badge=_badge(data.origins),
        panels=lambda: describe_coverage(data, data.where).panels,
        frame=lambda: _rows_of(data),
        plots={"coverage": lambda: describe_coverage(data, data.where)},
    )


def _aligned(logs: AlignedLogs) -> NotebookCard:
    from erclutch.wings.align.aligned_logs import said
    from erclutch.wings.align.clocks_plot import describe_clocks

    header = ("offset_s", "offset_low", "offset_high", "drift_ppm", "drift_low", "drift_high")
    columns, units = logs.joined.columns, logs.joined.units
    rows = [
        (m.offset, *m.offset_interval, *(1e6 * drift for drift in (m.drift, *m.drift_interval))) for m in logs.matches
    ]
    return NotebookCard(
        logs.joined.name,
        [f"{count(logs.joined.rows)} rows", *(said(match) for match in logs.matches)],
        lambda: PlotTable(header, rows),
        badge=logs.joined.origin,
        says=lambda: logs.notes,
        panels=lambda: describe_clocks(logs).panels[:2],
        frame=lambda: _frame({_named(name, units.get(name)): x for name, x in columns.items()}, "time [s]"),
        plots={"clocks": lambda: describe_clocks(logs)},
    )


# --- models -----------------------------------------------------------------------------------------------------------


def _model(model: Any) -> NotebookCard:
    """A law has its numbers in the data's units; every model has the range that it was trained on."""
    band = "with a prediction band" if model.band else "without a prediction band"
    return NotebookCard(
        model.name,
        [model.structure.device, model.title, f"effort in {unit_text(model.units.effort) or '1'}", band],
        lambda: PlotTable(("parameter", "value", "unit", "meaning"), [*model.in_units(), *_trained(model)]),
        lines=[line.replace(" + -", " - ") for line in model.equation() if not _NUMBER.match(line)],
        panels=lambda: [_curves(model)],
        plots={"flow-curves": lambda: Plot([_curves(model)], PlotTable((), ()), 2.6)},
    )


def _trained(model: Model) -> Iterator[tuple[str, float, str, str]]:
    units = model.units
    for name, unit in (("field", units.field), ("slip", units.slip), ("effort", units.effort)):
        low, high = getattr(model.trained_on, name)
        yield f"lowest {name}", float(low), unit, "of the training rows"
        yield f"highest {name}", float(high), unit, "of the training rows"


def _curves(model: Model) -> Panel:
    """Effort over slip in settled fields, the other element at rest without field, further inputs at mid-range."""
    covered, elements = model.trained_on, 1 if model.structure.device == "single" else 2
    strongest = max(map(abs, covered.field))
    levels = np.linspace(min(map(abs, covered.field)) if min(covered.field) > 0 else 0.0, strongest, _CURVES)
    slip, rest = np.linspace(*covered.slip, _POINTS), [np.zeros(_POINTS)] * (elements - 1)
    extras = [np.full(_POINTS, 0.5 * (low + high)) for low, high in model.extras.values()]
    unit = unit_text(model.units.field) if model.units.field != "?" else ""
    lines: list[Mark] = []
    for k, level in enumerate(np.unique(levels)):
        effort = np.asarray(model.steady([np.full(_POINTS, level), *rest], [slip, *rest], extras))
        style = f"level{round(6 * k / max(_CURVES - 1, 1))}"
        lines.append(Line(slip, effort, style, f"{number(float(level), 3)} {unit}".strip()))
    x, y = (Axis(n, unit_text(u)) for n, u in (("slip", model.units.slip), ("effort", model.units.effort)))
    return Panel(x, y, lines, f"Effort over slip of {model.name} in settled fields.", "effort in settled fields")


def _estimates(found: Sequence[Estimate]) -> PlotTable:
    return PlotTable(_ESTIMATES, [(e.name, e.value, e.low, e.high, e.unit, e.meaning) for e in found])


def _outcome(outcome: FitOutcome[Any]) -> NotebookCard:
    known = f"rank {outcome.rank} of {outcome.unknowns}"
    card = _model(outcome.model)
    kinds = f"{outcome.weights} weights" if outcome.weights else f"{outcome.parameters} parameters"
    return replace(
        card,
        facts=[kinds, f"{outcome.stop}, last solver {outcome.iterations} steps", known],
        table=lambda: _estimates(outcome.estimates) if outcome.estimates else card.table(),
        lines=(),
    )


def _entry(entry: RankedModel) -> NotebookCard:
    unit, test = unit_text(entry.outcome.model.units.effort), entry.test
    band = f"95 % band {span(test.rmse.low, test.rmse.high)}"
    return replace(
        _outcome(entry.outcome),
        name=entry.name,
        facts=[
            f"{entry.outcome.parameters} parameters",
            f"RMSE {number(test.rmse.value, 4)} {unit} on {count(test.rows)} rows held out ({band})",
            f"{percent(test.share.value)} of the standard deviation",
        ],
        says=lambda: [f"{capital(note)}." for note in entry.notes],
    )


# --- comparisons and runs ---------------------------------------------------------------------------------------------

_RANKING = ("model", "parameters", "rmse", "low", "high", "share", "r2")


def ranking_rows(body: Mapping[str, Any]) -> PlotTable:
    """Every model of a run: parameters, RMSE on the rows held out with its band, its share of the spread, R²."""
    unit = body["units"]["effort"]
    header = [_named(name, unit) if name in ("rmse", "low", "high") else name for name in _RANKING]
    rows = [
        (e["name"], e["parameters_count"], *e["test"]["rmse"], e["test"]["share"][0], e["test"]["r2"][0])
        for e in body["ranking"]
    ]
    return PlotTable(header, rows)


def _judged(
    material: Callable[[], Material], name: str, body: Mapping[str, Any], origins: Sequence[str]
) -> NotebookCard:
    """What a comparison and a run have in common."""
    from erclutch.report.numbers.run_material import standing
    from erclutch.report.plots.run_plots import FIGURES
    from erclutch.report.plots.trace_plot import describe_trace

    chosen = next(e for e in body["ranking"] if e["name"] == body["recommended"])
    share, unit = chosen["test"]["share"][0], unit_text(body["units"]["effort"])
    held = f"{count(body['test_rows'])} rows held out"
    error = f"RMSE {number(chosen['test']['rmse'][0], 4)} {unit}".strip()

    def predicted() -> DataFrame:
        rows = material().rows
        more = {f"effort:{name}": x for name, x in rows.predicted.items()}
        return _rows_of(rows.data, {"test": rows.test, **more})

    return NotebookCard(
        name,
        [
            f"{len(body['ranking'])} models",
            f"{standing(body)} {body['recommended']}",
            f"{error} on {held}",
            f"{percent(share)} of the standard deviation",
        ],
        lambda: ranking_rows(body),
        badge=_badge(origins),
        says=lambda: _verdict(material()),
        panels=lambda: [describe_trace(material()).panels[0]],
        frame=predicted,
        plots={key: partial(_drawn, describe, material) for key, (_, describe) in FIGURES.items()},
    )


def _drawn(describe: Callable[..., Plot], material: Callable[[], Material], **options: Any) -> Plot:
    return describe(material(), **options)


def _verdict(material: Material) -> list[str]:
    from erclutch.report.html.verdict_section import choice, worries
    from erclutch.report.numbers.run_material import standing

    found = worries(material)
    more = [f"{len(found) - _WORRIES} more worries are in the report."] if len(found) > _WORRIES else []
    return [f"{capital(standing(material.body))}: {material.recommended}. {choice(material)}", *found[:_WORRIES], *more]


def _comparison(comparison: Comparison) -> NotebookCard:
    from erclutch.report.numbers.run_material import material_in_memory

    material = material_in_memory(comparison)
    return _judged(lambda: material, comparison.data.where, material.body, comparison.data.origins)


def _run(run: Run) -> NotebookCard:
    from erclutch.report.numbers.run_material import material_of

    return _judged(lambda: material_of(run), run.folder.name, run.body, [log["origin"] for log in run.body["logs"]])


def _fleet(fleet: Fleet) -> NotebookCard:
    from erclutch.wings.fleet.fleet_page import fleet_panels, named

    out = sorted({device for series in fleet.series if series.model == fleet.model for device in series.outliers})
    facts = [
        f"{count(fleet.devices)} devices",
        f"{len(fleet.failed)} failed",
        f"most often {fleet.model or 'no model'}",
    ]
    says = [f"Stands out: {named(tuple(out))}."] if out else []
    says += [f"{device} failed: {why}" for device, why in list(fleet.failed.items())[:_WORRIES]]
    fits = [row for row in fleet.fits if row["model"] == fleet.model and not row["failed"]]
    names = dict.fromkeys(key for row in fleet.parameters for key in row)
    return NotebookCard(
        fleet.folder.name,
        facts,
        lambda: PlotTable(_FITS, [[row.get(key) for key in _FITS] for row in fits]),
        badge=_badge(fleet.origins),
        says=lambda: says,
        panels=lambda: fleet_panels(fleet)[:2],
        frame=lambda: _frame({key: [row.get(key) for row in fleet.parameters] for key in names}),
        plots={"charts": lambda: Plot(p := fleet_panels(fleet), PlotTable((), ()), 0.5 + 1.4 * len(p))},
    )


# --- flow curves ------------------------------------------------------------------------------------------------------


def _log_panel(curve: FlowCurve, lines: Sequence[Line] = ()) -> Panel:
    dots = Dots(curve.rate, curve.stress, "series0", curve.label if lines else "", 2.4)
    x, y = Axis("shear rate", "1/s", log=True), Axis("shear stress", "Pa", log=True)
    return Panel(x, y, [*lines, dots], f"Shear stress over shear rate of {curve.label}.")


def _flow_curve(curve: FlowCurve) -> NotebookCard:
    def with_laws() -> Plot:
        from erclutch.wings.rheology.flow_curve import ranked

        order = np.argsort(curve.rate)
        lines = [
            Line(curve.rate[order], fit.predicted[order], f"series{k + 1}", fit.law, dashed=k > 0)
            for k, fit in enumerate(ranked(curve))
        ]
        return Plot([_log_panel(curve, lines)], PlotTable((), ()), 2.6)

    ranges = ((curve.rate, "1/s"), (curve.stress, "Pa"))
    ends = [f"{span(float(x.min()), float(x.max()))} {unit}" for x, unit in ranges]
    return NotebookCard(
        curve.label,
        [f"{curve.rate.size} points", *ends],
        lambda: PlotTable(("rate [1/s]", "stress [Pa]"), np.column_stack([curve.rate, curve.stress]).tolist()),
        panels=lambda: [_log_panel(curve)],
        plots={"points": lambda: Plot([_log_panel(curve)], PlotTable((), ()), 2.6), "laws": with_laws},
    )


def _flow_fit(fit: FlowFit) -> NotebookCard:
    facts = [f"RMSE {number(fit.rmse, 3)} Pa", f"{number(fit.log_rmse, 3)} of log10(stress)", fit.stop]
    return NotebookCard(fit.law, facts, lambda: _estimates(fit.estimates))


_CARDS: Mapping[str, Callable[[Any], NotebookCard]] = {
    "Recording": _recording,
    "Dataset": _dataset,
    "AlignedLogs": _aligned,
    "SharedAnswers": _model,
    "FitOutcome": _outcome,
    "RankedModel": _entry,
    "Comparison": _comparison,
    "Run": _run,
    "Fleet": _fleet,
    "FlowCurve": _flow_curve,
    "FlowFit": _flow_fit,
}
