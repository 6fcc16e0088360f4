"""What a notebook shows of a value: its line, a few sentences, a small table; beside it DataFrames and plots.

This module is the presenter that `erclutch.signals.shown` asks. What a class of the core shows stands below under the
name of the class; a value of a wing, or of another package, has a method ``notebook_card`` that returns a `Card`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
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
from erclutch.signals.origins import RECORDING, badge_of
from erclutch.signals.recording import TEMPERATURE

if TYPE_CHECKING:
    from pandas import DataFrame

    from erclutch.fit.comparison import Comparison, RankedModel
    from erclutch.fit.solver.outcome import Estimate, FitOutcome
    from erclutch.logs.dataset import Dataset
    from erclutch.models.model import Model
    from erclutch.report.numbers.run_material import Material
    from erclutch.runs.run_folder import Run
    from erclutch.signals.recording import Recording

_MOST = 8  # rows of a table in a notebook
_SECTION = 600  # rows of a log in a plot that nobody gave a length
_WORRIES = 3  # sentences of worry that a card has room for
_CURVES = 5  # of a model's plot
_POINTS = 81  # of a curve
#: The column of a ranking that only a program or a command needs.
_IN_FULL = "specification"
#: Of an equation's lines those that only give a number, which the table has.
_NUMBER = re.compile(r"  \w+ +=  *-?[\d.e+-]+$")


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
    says: Callable[[], Sequence[str]] = lambda: ()
    frame: Callable[[], DataFrame] | None = None
    plots: Mapping[str, Callable[..., Plot]] = field(default_factory=dict[str, Callable[..., Plot]])


def card_of(value: Any) -> Card:
    """The card of a value: its own, or the one that stands here under the name of its class."""
    if hasattr(value, "notebook_card"):
        return value.notebook_card()
    classes = [kind.__name__ for kind in type(value).__mro__]
    nearest = next(name for name in classes if name in _CARDS)
    return _CARDS[nearest](value)


# --- the presenter ----------------------------------------------------------------------------------------------------


def html(value: Any) -> str:
    """A value as HTML without a picture or a script: its line, sentences, the first rows of its table."""
    from erclutch.report.html.report_page import templates

    card = card_of(value)
    rows = card.table()
    shown = rows.head(_MOST).drop(columns=_IN_FULL, errors="ignore")
    as_html = shown.to_html(
        index=False, border=0, na_rep="–", float_format=partial(number, digits=4)
    )
    left_out = max(0, len(rows) - _MOST)
    template = templates().get_template("notebook.html.j2")
    return template.render(line=repr(value), card=card, table=Markup(as_html), left=left_out)


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
        raise SettingError(
            f"{card.name} has no plot", remedy="Plot the log, the comparison or the run"
        )
    chosen = name or next(iter(card.plots))
    if chosen not in card.plots:
        known = ", ".join(card.plots)
        raise SettingError(
            f"no plot {chosen!r}", remedy=f"Plots of a {type(value).__name__}: {known}"
        )
    described = card.plots[chosen](**options)
    # A notebook's backend sets itself up when it is loaded: here, not in a style that ends.
    cast(Any, pyplot).draw_if_interactive()
    with style():
        size = (described.width, described.height)
        figure: Any = cast(Any, pyplot).figure(figsize=size, layout="constrained")
        paint(figure, described)
    # Colour bars are axes too, and behind them all; they have no place in the grid of panels.
    in_grid = [axis for axis in figure.axes if axis.get_subplotspec() is not None]
    axes = in_grid[: len(described.panels)]
    return axes[0] if len(axes) == 1 else np.array(axes, dtype=object)


@dataclass(frozen=True)
class InlineReport:
    """A report in a frame of its own; `html` is the document."""

    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        frame = '<iframe title="Report" sandbox="allow-scripts" style="{}" srcdoc="{}"></iframe>'
        return str(
            Markup(frame).format("width:100%;height:720px;border:0;background:#fff", self.html)
        )


def report(value: Run) -> InlineReport:
    """See `Run.report`."""
    from erclutch.report.html.report_page import report_html
    from erclutch.report.numbers.run_material import material_of

    return InlineReport(report_html(material_of(value)))


# --- tables that cards share ------------------------------------------------------------------------------------------


def titled_column(name: str, unit: str | None) -> str:
    """A column's name with its unit, as readers of logs understand it."""
    if not unit or unit == "?":
        return name
    readable = "temperature" if name == TEMPERATURE else name
    return f"{readable} [{unit}]"


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
    rows: list[tuple[Any, ...]] = []
    for fitted in estimates:
        interval = (fitted.value, fitted.low, fitted.high)
        rows.append((fitted.name, *interval, fitted.unit, fitted.meaning))
    return rows_as_frame(("parameter", "value", "low", "high", "unit", "meaning"), rows)


def badge_of_origins(origins: Sequence[str]) -> str:
    """The word that all logs say of themselves, such as TWIN; MIXED where they differ, "" for measurements."""
    badge = badge_of(origins)
    return "" if badge == RECORDING else badge


def _extent(columns: Mapping[str, tuple[Array, str]]) -> DataFrame:
    """Lowest, mean and highest value of each signal."""
    rows: list[tuple[str, str, float, float, float]] = []
    for name, (values, unit) in columns.items():
        lowest = float(values.min())
        mean = float(values.mean())
        highest = float(values.max())
        rows.append((name, unit, lowest, mean, highest))
    return rows_as_frame(("signal", "unit", "lowest", "mean", "highest"), rows)


# --- logs -------------------------------------------------------------------------------------------------------------


def _recording(log: Recording) -> Card:
    from erclutch.report.plots.log_plots import describe_section

    columns: dict[str, tuple[Array, str]] = {}  # values and unit of each signal
    for name, values in log.signals.items():
        columns[name] = (values, log.units.get(name, ""))
    for name, values in {**log.extras, **log.spare}.items():
        columns[name] = (values, "K" if name == TEMPERATURE else "")

    def section(*, start: float | None = None, seconds: float | None = None) -> Plot:
        if seconds is None:
            seconds = min(log.duration, _SECTION * log.period)
        return describe_section(log, start=start, seconds=seconds)

    def rows() -> DataFrame:
        titled = {"time [s]": log.time}
        for name, (values, unit) in columns.items():
            titled[titled_column(name, unit)] = values
        return as_frame(titled, "time [s]")

    has_effort = "effort" in log.signals or "T" in log.signals
    return Card(
        log.name,
        lambda: _extent(columns),
        badge=log.origin,
        frame=rows,
        plots={"section": section} if has_effort else {},
    )


def _signals_of(data: Dataset) -> dict[str, tuple[Array, str]]:
    """Values and unit of each signal."""
    signals = dict(data.named_signals)
    signals["effort"] = (data.effort, data.units.effort)
    for name, values in data.extras.items():
        signals[name] = (values, "")
    return signals


def _rows_of(data: Dataset, more: Mapping[str, Any] | None = None) -> DataFrame:
    """All rows with their time, the log's name where there are several, and further columns."""
    columns: dict[str, Any] = {"time [s]": data.clock.time}
    if len(data.sources) > 1:
        rows_a_log = [stop - start for start, stop in data.source_rows]
        columns["log"] = np.repeat(data.sources, rows_a_log)
    for name, (values, unit) in _signals_of(data).items():
        columns[titled_column(name, unit)] = values
    columns |= more or {}
    return as_frame(columns, "time [s]")


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


def _model(model: Model) -> Card:
    """A law has its numbers in the data's units; every model has the range that it was trained on."""

    def numbers() -> DataFrame:
        base: Any = model  # each model of ours is a `ModelBase`, which knows its numbers in units
        rows: list[tuple[Any, ...]] = list(base.in_units())
        for name in ("field", "slip", "effort"):
            unit = getattr(model.units, name)
            low, high = getattr(model.trained_on, name)
            rows.append((f"lowest {name}", float(low), unit, "of the training rows"))
            rows.append((f"highest {name}", float(high), unit, "of the training rows"))
        return rows_as_frame(("parameter", "value", "unit", "meaning"), rows)

    def flow_curves() -> Plot:
        """Effort over slip in settled fields, the other element at rest without field, further inputs at mid-range."""
        covered = model.trained_on
        strongest = max(map(abs, covered.field))
        weakest = 0.0
        if min(covered.field) > 0:
            weakest = min(map(abs, covered.field))
        slip = np.linspace(*covered.slip, _POINTS)
        elements = 1 if model.structure.device == "single" else 2
        at_rest = [np.zeros(_POINTS)] * (elements - 1)  # field and slip of the other element
        middles = [0.5 * (low + high) for low, high in model.extras.values()]
        extras = [np.full(_POINTS, middle) for middle in middles]

        unit = unit_text(model.units.field) if model.units.field != "?" else ""
        levels = np.unique(np.linspace(weakest, strongest, _CURVES))
        lines: list[Mark] = []
        for place, level in enumerate(levels):
            field = np.full(_POINTS, level)
            at_level = model.steady([field, *at_rest], [slip, *at_rest], extras)
            effort = np.asarray(at_level)
            style = f"level{round(6 * place / (_CURVES - 1))}"
            label = f"{number(float(level), 3)} {unit}".strip()
            lines.append(Line(slip, effort, style, label))
        panel = Panel(
            Axis("slip", unit_text(model.units.slip)),
            Axis("effort", unit_text(model.units.effort)),
            lines,
            f"Effort over slip of the {title_of(model.name)} in settled fields.",
            "effort in settled fields",
        )
        return Plot([panel], PlotTable((), ()), height=2.6)

    equation: list[str] = []
    for line in model.equation():
        if not _NUMBER.match(line):
            equation.append(line.replace(" + -", " - "))
    return Card(title_of(model.name), numbers, lines=equation, plots={"flow-curves": flow_curves})


def _outcome(outcome: FitOutcome[Any]) -> Card:
    """The model's card, with intervals where the fit has them."""
    card = replace(_model(outcome.model), lines=())
    estimates = outcome.estimates
    if not estimates:
        return card
    return replace(card, table=lambda: estimates_as_frame(estimates))


def _entry(entry: RankedModel) -> Card:
    def notes() -> list[str]:
        return [f"{capital(note)}." for note in entry.notes]

    return replace(_outcome(entry.outcome), name=title_of(entry.name), says=notes)


# --- comparisons and runs ---------------------------------------------------------------------------------------------


def _judged(
    material: Callable[[], Material],
    name: str,
    body: Mapping[str, Any],
    origins: Sequence[str],
) -> Card:
    """What a comparison and a run have in common."""
    from erclutch.report.plots.run_plots import FIGURES

    def verdict() -> list[str]:
        from erclutch.fit.choice.standing import standing_of_run
        from erclutch.report.html.verdict_section import choice, worries

        judged = material()
        word = capital(standing_of_run(judged.body).word)
        sentences = [f"{word}: {judged.title}. {choice(judged)}"]
        all_worries = worries(judged)
        sentences += all_worries[:_WORRIES]
        left_out = len(all_worries) - _WORRIES
        if left_out > 0:
            sentences.append(f"{left_out} more worries are in the report.")
        return sentences

    def ranking() -> DataFrame:
        """Every model: parameters, RMSE on the rows held out with its band, share of the spread, R², its name."""
        unit = body["units"]["effort"]
        errors = [titled_column(name, unit) for name in ("rmse", "low", "high")]
        header = ("id", "model", "parameters", *errors, "share", "r2", _IN_FULL)
        rows: list[list[Any]] = []
        for place, entry in enumerate(body["ranking"]):
            test = entry["test"]
            row = [
                id_of(place),
                entry["title"],
                entry["parameters_count"],
                *test["rmse"],
                test["share"][0],
                test["r2"][0],
                entry["name"],
            ]
            rows.append(row)
        return rows_as_frame(header, rows)

    def predicted() -> DataFrame:
        rows = material().rows
        estimates = {f"effort:{name}": values for name, values in rows.predicted.items()}
        return _rows_of(rows.data, {"test": rows.test, **estimates})

    def drawn(describe: Callable[..., Plot], **options: Any) -> Plot:
        return describe(material(), **options)

    return Card(
        name,
        ranking,
        badge=badge_of_origins(origins),
        says=verdict,
        frame=predicted,
        plots={figure: partial(drawn, describe) for figure, (_, describe) in FIGURES.items()},
    )


def _comparison(comparison: Comparison) -> Card:
    from erclutch.report.numbers.run_material import material_in_memory

    material = material_in_memory(comparison)
    return _judged(lambda: material, comparison.data.where, material.body, comparison.data.origins)


def _run(run: Run) -> Card:
    from erclutch.report.numbers.run_material import material_of

    origins = [log["origin"] for log in run.body["logs"]]
    return _judged(lambda: material_of(run), run.folder.name, run.body, origins)


#: The card of a value of the core, by the name of its class, so that this module imports none of them.
_CARDS: Mapping[str, Callable[[Any], Card]] = {
    "Recording": _recording,
    "Dataset": _dataset,
    "ModelBase": _model,
    "FitOutcome": _outcome,
    "RankedModel": _entry,
    "Comparison": _comparison,
    "Run": _run,
}
