"""What a notebook shows of a value: its line, a few sentences, a small table; beside it DataFrames and plots.

This module is the presenter that `erclutch.signals.shown` asks. What a class of the core shows stands below under the
name of the class; a value of a wing, or of another package, has a method ``notebook_card`` that returns a `Card`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from markupsafe import Markup

from erclutch.errors import SettingError
from erclutch.models.model_titles import id_of, title_of
from erclutch.report.numbers.number_text import capital, number, unit_text
from erclutch.report.plots.plot_description import Axis, Line, Mark, Panel, Plot, PlotTable
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

_MOST = 8  # rows of a table in a notebook
_SECTION = 600  # rows of a log in a plot that nobody gave a length
_WORRIES = 3
_CURVES, _POINTS = 5, 81
#: The column of a ranking that only a program or a command needs.
_IN_FULL = "specification"
#: Of an equation's lines those that only give a number, which the table has.
_NUMBER = re.compile(r"  \w+ +=  *-?[\d.e+-]+$")


def _nothing() -> Sequence[str]:
    return ()


@dataclass(frozen=True)
class Card:
    """What is shown of a value beside its line.

    Attributes:
        name: of the value, as its file or its model calls it.
        table: the summary, unrounded.
        badge: TWIN or another word where the data are no recording.
        lines: of an equation.
        says: sentences: the verdict and what to worry about.
        frame: all rows as a DataFrame; None: they are the table.
        plots: what each plot draws, the first by default.
    """

    name: str
    table: Callable[[], DataFrame]
    badge: str = ""
    lines: Sequence[str] = ()
    says: Callable[[], Sequence[str]] = _nothing
    frame: Callable[[], DataFrame] | None = None
    plots: Mapping[str, Callable[..., Plot]] = field(default_factory=dict[str, Callable[..., Plot]])


def card_of(value: Any) -> Card:
    """The card of a value: its own, or the one that stands here under the name of its class."""
    if hasattr(value, "notebook_card"):
        return value.notebook_card()
    return next(_CARDS[kind.__name__] for kind in type(value).__mro__ if kind.__name__ in _CARDS)(value)


# --- the presenter ----------------------------------------------------------------------------------------------------


def html(value: Any) -> str:
    """A value as HTML without a picture or a script: its line, sentences, the first rows of its table."""
    from erclutch.report.html.report_page import templates

    card = card_of(value)
    rows = card.table()
    shown = (
        rows.head(_MOST)
        .drop(columns=_IN_FULL, errors="ignore")
        .to_html(index=False, border=0, na_rep="–", float_format=partial(number, digits=4))
    )
    template = templates().get_template("notebook.html.j2")
    return template.render(line=repr(value), card=card, table=Markup(shown), left=max(0, len(rows) - _MOST))


def table(value: Any) -> DataFrame:
    """See `Shown.table`."""
    return card_of(value).table()


def frame(value: Any) -> DataFrame:
    """See `Shown.to_frame`; a value without rows of its own gives its table."""
    card = card_of(value)
    return card.table() if card.frame is None else card.frame()


def plot(value: Any, name: str | None = None, **options: Any) -> Any:
    """See `Shown.plot`."""
    from matplotlib import pyplot  # pyright: ignore[reportUnknownVariableType]

    from erclutch.report.plots.matplotlib_painter import paint
    from erclutch.report.plots.paper_style import style

    card = card_of(value)
    if not card.plots:
        raise SettingError(f"{card.name} has no plot", remedy="Plot the log, the comparison or the run")
    chosen = name or next(iter(card.plots))
    if chosen not in card.plots:
        raise SettingError(f"no plot {chosen!r}", remedy=f"Plots of a {type(value).__name__}: {', '.join(card.plots)}")
    described = card.plots[chosen](**options)
    # A notebook's backend sets itself up when it is loaded: here, not in a style that ends.
    cast(Any, pyplot).draw_if_interactive()
    with style():
        figure: Any = cast(Any, pyplot).figure(figsize=(described.width, described.height), layout="constrained")
        paint(figure, described)
    axes = [axis for axis in figure.axes if axis.get_subplotspec() is not None][: len(described.panels)]
    return axes[0] if len(axes) == 1 else np.array(axes, dtype=object)


@dataclass(frozen=True)
class InlineReport:
    """A report in a frame of its own; `html` is the document."""

    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        frame = '<iframe title="Report" sandbox="allow-scripts" style="{}" srcdoc="{}"></iframe>'
        return str(Markup(frame).format("width:100%;height:720px;border:0;background:#fff", self.html))


def report(value: Run) -> InlineReport:
    """See `Run.report`."""
    from erclutch.report.html.report_page import report_html
    from erclutch.report.numbers.run_material import material_of

    return InlineReport(report_html(material_of(value)))


# --- tables that cards share ------------------------------------------------------------------------------------------


def titled_column(name: str, unit: str | None) -> str:
    """A column's name with its unit, as readers of logs understand it."""
    return f"{'temperature' if name == TEMPERATURE else name} [{unit}]" if unit and unit != "?" else name


def as_frame(columns: Mapping[str, Any], index: str | None = None) -> DataFrame:
    """Columns by name as a DataFrame; ``index`` names the column that is its index."""
    from pandas import DataFrame

    made = DataFrame(dict(columns))
    return made if index is None else made.set_index(index)


def rows_as_frame(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> DataFrame:
    """Rows under a header as a DataFrame."""
    from pandas import DataFrame

    return DataFrame([list(row) for row in rows], columns=list(header))


def estimates_as_frame(estimates: Sequence[Estimate]) -> DataFrame:
    """Parameters with their 95 % intervals."""
    rows = [(e.name, e.value, e.low, e.high, e.unit, e.meaning) for e in estimates]
    return rows_as_frame(("parameter", "value", "low", "high", "unit", "meaning"), rows)


def badge_of_origins(origins: Sequence[str]) -> str:
    """The word that all logs say of themselves, such as TWIN; MIXED where they differ, "" for measurements."""
    words = {*origins} - {""}
    return "MIXED" if words and len({*origins}) > 1 else next(iter(words), "")


def _extent(columns: Mapping[str, tuple[Array, str]]) -> DataFrame:
    """Lowest, mean and highest value of each signal."""
    rows = [(name, unit, float(x.min()), float(x.mean()), float(x.max())) for name, (x, unit) in columns.items()]
    return rows_as_frame(("signal", "unit", "lowest", "mean", "highest"), rows)


# --- logs -------------------------------------------------------------------------------------------------------------


def _recording(log: Recording) -> Card:
    from erclutch.report.plots.log_plots import describe_section

    columns = {name: (x, log.units.get(name, "")) for name, x in log.signals.items()}
    columns |= {n: (x, "") if n != TEMPERATURE else (x, "K") for n, x in {**log.extras, **log.spare}.items()}

    def section(*, start: float | None = None, seconds: float | None = None) -> Plot:
        width = min(log.duration, _SECTION * log.period) if seconds is None else seconds
        return describe_section(log, start=start, seconds=width)

    def rows() -> DataFrame:
        named = {titled_column(name, unit): x for name, (x, unit) in columns.items()}
        return as_frame({"time [s]": log.time, **named}, "time [s]")

    return Card(
        log.name,
        lambda: _extent(columns),
        badge=log.origin,
        frame=rows,
        plots={"section": section} if {"effort", "T"} & set(log.signals) else {},
    )


def _signals_of(data: Dataset) -> dict[str, tuple[Array, str]]:
    extras = {name: (x, "") for name, x in data.extras.items()}
    return {**data.named_signals, "effort": (data.effort, data.units.effort), **extras}


def _rows_of(data: Dataset, more: Mapping[str, Any] | None = None) -> DataFrame:
    columns: dict[str, Any] = {"time [s]": data.clock.time}
    if len(data.sources) > 1:
        columns["log"] = np.repeat(data.sources, [b - a for a, b in data.source_rows])
    columns |= {titled_column(name, unit): x for name, (x, unit) in _signals_of(data).items()}
    return as_frame({**columns, **(more or {})}, "time [s]")


def _dataset(data: Dataset) -> Card:
    from erclutch.report.plots.log_plots import describe_coverage

    return Card(
        data.where,
        lambda: _extent(_signals_of(data)),
        badge=badge_of_origins(data.origins),
        frame=lambda: _rows_of(data),
        plots={"coverage": lambda: describe_coverage(data, data.where)},
    )


# --- models -----------------------------------------------------------------------------------------------------------


def _model(model: Any) -> Card:
    """A law has its numbers in the data's units; every model has the range that it was trained on."""
    header = ("parameter", "value", "unit", "meaning")
    return Card(
        title_of(model.name),
        lambda: rows_as_frame(header, [*model.in_units(), *_trained(model)]),
        lines=[line.replace(" + -", " - ") for line in model.equation() if not _NUMBER.match(line)],
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
    covered = model.trained_on
    elements = 1 if model.structure.device == "single" else 2
    strongest = max(map(abs, covered.field))
    weakest = min(map(abs, covered.field)) if min(covered.field) > 0 else 0.0
    slip = np.linspace(*covered.slip, _POINTS)
    rest = [np.zeros(_POINTS)] * (elements - 1)
    extras = [np.full(_POINTS, 0.5 * (low + high)) for low, high in model.extras.values()]
    unit = unit_text(model.units.field) if model.units.field != "?" else ""
    lines: list[Mark] = []
    for k, level in enumerate(np.unique(np.linspace(weakest, strongest, _CURVES))):
        effort = np.asarray(model.steady([np.full(_POINTS, level), *rest], [slip, *rest], extras))
        colour = f"level{round(6 * k / (_CURVES - 1))}"
        lines.append(Line(slip, effort, colour, f"{number(float(level), 3)} {unit}".strip()))
    x = Axis("slip", unit_text(model.units.slip))
    y = Axis("effort", unit_text(model.units.effort))
    return Panel(
        x, y, lines, f"Effort over slip of the {title_of(model.name)} in settled fields.", "effort in settled fields"
    )


def _outcome(outcome: FitOutcome[Any]) -> Card:
    card = _model(outcome.model)
    estimates = outcome.estimates
    return replace(card, table=lambda: estimates_as_frame(estimates) if estimates else card.table(), lines=())


def _entry(entry: RankedModel) -> Card:
    return replace(
        _outcome(entry.outcome), name=title_of(entry.name), says=lambda: [f"{capital(n)}." for n in entry.notes]
    )


# --- comparisons and runs ---------------------------------------------------------------------------------------------


def _ranking(body: Mapping[str, Any]) -> DataFrame:
    """Every model of a run: parameters, RMSE on the rows held out with its band, share of the spread, R², its name."""
    unit = body["units"]["effort"]
    errors = [titled_column(name, unit) for name in ("rmse", "low", "high")]
    rows = [
        (
            *(id_of(place), e["title"], e["parameters_count"], *e["test"]["rmse"]),
            *(e["test"]["share"][0], e["test"]["r2"][0], e["name"]),
        )
        for place, e in enumerate(body["ranking"])
    ]
    return rows_as_frame(("id", "model", "parameters", *errors, "share", "r2", _IN_FULL), rows)


def _judged(material: Callable[[], Material], name: str, body: Mapping[str, Any], origins: Sequence[str]) -> Card:
    """What a comparison and a run have in common."""
    from erclutch.report.plots.run_plots import FIGURES

    def predicted() -> DataFrame:
        rows = material().rows
        more = {f"effort:{name}": x for name, x in rows.predicted.items()}
        return _rows_of(rows.data, {"test": rows.test, **more})

    return Card(
        name,
        lambda: _ranking(body),
        badge=badge_of_origins(origins),
        says=lambda: _verdict(material()),
        frame=predicted,
        plots={key: partial(_drawn, describe, material) for key, (_, describe) in FIGURES.items()},
    )


def _drawn(describe: Callable[..., Plot], material: Callable[[], Material], **options: Any) -> Plot:
    return describe(material(), **options)


def _verdict(material: Material) -> list[str]:
    from erclutch.fit.standing import standing_of_run
    from erclutch.report.html.verdict_section import choice, worries

    told = worries(material)
    more = [f"{len(told) - _WORRIES} more worries are in the report."] if len(told) > _WORRIES else []
    word = capital(standing_of_run(material.body).word)
    return [f"{word}: {material.title}. {choice(material)}", *told[:_WORRIES], *more]


def _comparison(comparison: Comparison) -> Card:
    from erclutch.report.numbers.run_material import material_in_memory

    material = material_in_memory(comparison)
    return _judged(lambda: material, comparison.data.where, material.body, comparison.data.origins)


def _run(run: Run) -> Card:
    from erclutch.report.numbers.run_material import material_of

    return _judged(lambda: material_of(run), run.folder.name, run.body, [log["origin"] for log in run.body["logs"]])


_CARDS: Mapping[str, Callable[[Any], Card]] = {
    "Recording": _recording,
    "Dataset": _dataset,
    "ModelBase": _model,
    "FitOutcome": _outcome,
    "RankedModel": _entry,
    "Comparison": _comparison,
    "Run": _run,
}
