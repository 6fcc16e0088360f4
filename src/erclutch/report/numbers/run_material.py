"""Sections and figures of a report are made from a run, its rows, and the way its numbers are shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from erclutch.fit.choice.standing import chosen_name
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import Model
from erclutch.report.numbers.correlation import (
    Autocorrelation,
    Spectrum,
    autocorrelation,
    period_of,
    spectrum,
)
from erclutch.report.numbers.effort_loops import EffortLoop, LoopAreas, effort_loops, loop_areas
from erclutch.report.numbers.error_map import ErrorMap, error_maps
from erclutch.report.numbers.flow_curves import (
    FieldCurves,
    FlowCurves,
    field_curves,
    flow_curves,
    grouped,
    law_names,
    rare_fields,
    waited,
)
from erclutch.report.numbers.model_stages import is_law, remembers_slip, specification_of
from erclutch.report.numbers.number_text import Scale, effort_word, scale_for
from erclutch.report.numbers.parity import Distribution, distributions
from erclutch.report.numbers.switching import (
    AfterSwitch,
    StepResponse,
    after_switch,
    step_responses,
)
from erclutch.report.numbers.windows import Windows, windows
from erclutch.runs.run_about import RunAbout, read_about
from erclutch.runs.run_folder import Run
from erclutch.runs.run_rows import RunRows, read_rows
from erclutch.runs.written_run import run_to_dict
from erclutch.signals.array import Array
from erclutch.signals.origins import RECORDING, badge_of

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison

Role = Literal["recommended", "best", "baseline"]


def shown_models(body: Mapping[str, Any]) -> dict[str, Role]:
    """Models that pictures show: the recommended, the best and the plainest one of a run (`run.json`), and why."""
    # The plainest is Bingham without memory where it was fitted, else the model with the fewest parameters.
    ranking: Sequence[Mapping[str, Any]] = body["ranking"]
    finite = [entry for entry in ranking if entry["test"]["rmse"][0] is not None]
    without_memory = [entry for entry in finite if "+" not in entry["name"]]
    bingham = [entry for entry in without_memory if entry["name"].startswith("bingham")]
    candidates = bingham or finite or ranking
    plainest = min(candidates, key=lambda entry: (entry["parameters_count"], entry["name"]))

    picks: tuple[tuple[Role, str], ...] = (
        ("recommended", chosen_name(body)),
        ("best", body["best"]),
        ("baseline", str(plainest["name"])),
    )
    shown: dict[str, Role] = {}
    for role, name in picks:
        shown.setdefault(name, role)
    return shown


BADGE_MEANS = {
    "TWIN": "Data of a digital twin: made by a computer, not a measurement.",
    "SYNTHETIC": "Made-up data for trying things out: not a measurement.",
    "RECORDING": "Measured data, as far as the log tells.",
    "MIXED": "Logs of different origins: measured and made by a computer.",
}
_LONG_BEFORE = 1e5  # s before a log from which its clock may count: epochs have ten digits and more


@dataclass(frozen=True)
class Material:
    """A run that is being reported, with the numbers that several sections and figures show, each made once.

    Attributes:
        run: the run.
        rows: its rows.
        fitted: models of a comparison that is in no folder, by name.
    """

    run: Run
    rows: RunRows
    _: KW_ONLY
    fitted: Mapping[str, Model] | None = None

    @property
    def body(self) -> Mapping[str, Any]:
        """run.json."""
        return self.run.body

    @cached_property
    def about(self) -> RunAbout:
        """What people say of the run."""
        return read_about(self.run.folder)

    @property
    def recommended(self) -> str:
        """Name of the recommended model, or of the nearest where none is recommended."""
        return chosen_name(self.body)

    @cached_property
    def titles(self) -> Mapping[str, str]:
        """What each model is called in plain words, by its name."""
        return {entry["name"]: str(entry["title"]) for entry in self.body["ranking"]}

    @property
    def title(self) -> str:
        """What the recommended model is called."""
        return self.titles[self.recommended]

    @cached_property
    def rival(self) -> str | None:
        """The model to show beside the recommended one: the best of another kind that is sound; None where none is.

        Of a model with a network it is the best law alone, of a law the best other law.
        """
        own = self.run.entry(self.recommended)
        own_law = specification_of(own).partition("+")[0]
        for entry in self.body["ranking"]:
            name = str(entry["name"])
            another_law = specification_of(entry).partition("+")[0] != own_law
            of_another_kind = not is_law(own) or another_law
            scored = entry["test"]["rmse"][0] is not None
            if is_law(entry) and of_another_kind and scored and name != self.recommended:
                return name
        return None

    @cached_property
    def shown(self) -> dict[str, Role]:
        """Models in the pictures, and why each is shown."""
        return shown_models(self.body)

    @cached_property
    def badge(self) -> str:
        """Where the data come from, in a word."""
        return badge_of(str(log["origin"]) for log in self.body["logs"])

    @property
    def print_badge(self) -> str:
        """The badge of a figure that stands alone; empty for a recording."""
        return "" if self.badge == RECORDING else self.badge

    @property
    def badge_means(self) -> str:
        """Where the data come from, in a sentence."""
        return BADGE_MEANS.get(self.badge, "Made by a computer, not a measurement.")

    @property
    def word(self) -> str:
        """What the effort is: torque, force."""
        units = self.body["units"]
        return effort_word(units["effort"], units["slip"])

    @cached_property
    def effort(self) -> Scale:
        """How efforts and their errors are shown."""
        spread = float(np.std(self.rows.data.effort))
        return scale_for(self.body["units"]["effort"], spread)

    @cached_property
    def field(self) -> Scale:
        """How fields are shown."""
        fields = [np.abs(element.field) for element in self.rows.data.elements]
        largest = max(float(field.max()) for field in fields)
        return scale_for(self.body["units"]["field"], largest)

    @cached_property
    def slip(self) -> Scale:
        """How slips are shown."""
        usual = max(float(np.std(element.slip)) for element in self.rows.data.elements)
        return scale_for(self.body["units"]["slip"], usual)

    @cached_property
    def period(self) -> float:
        """Sampling period in s."""
        return period_of(self.rows)

    def clock_start(self, row: int) -> float:
        """From when a row's time is shown, in s: 0, or its log's start where the clock counts from long before."""
        first_rows = [first for first, _ in self.rows.data.source_rows if first <= row]
        start = float(self.rows.data.clock.time[max(first_rows)])
        return start if abs(start) >= _LONG_BEFORE else 0.0

    @cached_property
    def windows(self) -> Windows:
        """Sections of the log worth a close look."""
        return windows(self.rows, self.recommended)

    @cached_property
    def models(self) -> Mapping[str, Model]:
        """All models of the run, read from their files if they are in any."""
        return self.fitted or {name: self.run.model(name) for name in self.run.names}

    @cached_property
    def band_ends(self) -> tuple[Array, Array] | None:
        """Low and high end of the recommended model's band over all rows; None where it has none."""
        band = self.models[self.recommended].band
        if band is None:
            return None
        data = self.rows.data
        estimated = self.rows.predicted[self.recommended]
        return band.around(estimated, data.elements, data.clock)

    @cached_property
    def laws(self) -> Mapping[str, TorqueModel]:
        """Those of them that are laws."""
        return {name: law for name, law in self.law_parts.items() if law is self.models[name]}

    @cached_property
    def law_parts(self) -> Mapping[str, TorqueModel]:
        """The law of each model that has one: of a law itself, and of a law with a network."""
        parts: dict[str, TorqueModel] = {}
        for name, model in self.models.items():
            # A law with a network has its law beside the correction; a law's structure has the law, a network's none.
            part: Any = getattr(model, "law", model)
            if hasattr(part.structure, "law"):
                parts[name] = part
        return parts

    @cached_property
    def error_maps(self) -> tuple[ErrorMap, ...]:
        """Where the recommended model errs, an element each."""
        return error_maps(self.rows, self.recommended)

    @cached_property
    def distributions(self) -> tuple[Distribution, ...]:
        """Residuals of the shown models."""
        return distributions(self.rows, list(self.shown))

    @cached_property
    def spectrum(self) -> Spectrum | None:
        """Spectra of the shown models' residuals."""
        return spectrum(self.rows, list(self.shown))

    @cached_property
    def autocorrelation(self) -> Autocorrelation | None:
        """Autocorrelations of the shown models' residuals."""
        return autocorrelation(self.rows, list(self.shown))

    @cached_property
    def after_switch(self) -> AfterSwitch | None:
        """Errors of the shown models after a switch."""
        return after_switch(self.rows, list(self.shown))

    @cached_property
    def step_responses(self) -> tuple[StepResponse, ...]:
        """Step responses of the shown models."""
        return step_responses(self.body, list(self.shown))

    @cached_property
    def looped(self) -> dict[str, Role]:
        """Models whose loops are shown: the recommended one, and the best law that does not remember the slip."""
        shown: dict[str, Role] = {self.recommended: "recommended"}
        for entry in self.body["ranking"]:
            if is_law(entry) and not remembers_slip(entry):
                shown.setdefault(entry["name"], "baseline")
                break
        return shown

    @cached_property
    def effort_loops(self) -> list[EffortLoop]:
        """Effort around a few periods of the motion, at a few fields."""
        return effort_loops(self.rows, list(self.looped))

    @cached_property
    def loop_areas(self) -> LoopAreas | None:
        """How wide loops of effort over slip are, over all periods held out."""
        return loop_areas(self.rows, list(self.looped))

    @property
    def travel(self) -> Scale:
        """How travels are shown: slips summed up over time."""
        travels = [np.abs(loop.travel) for loop in self.effort_loops]
        largest = max((float(travel.max()) for travel in travels), default=0.0)
        of_slip = self.body["units"]["slip"]
        unit = of_slip.removesuffix("/s") if of_slip.endswith("/s") else f"{of_slip}*s"
        return scale_for(unit, largest)

    @cached_property
    def flow_curves(self) -> tuple[tuple[FlowCurves, ...], ...]:
        """Curves of each element, of each law in its best form; laws that are alike in one."""
        laws = {name: self.laws[name] for name in law_names(self.body)}
        elements = range(len(self.rows.data.elements))
        of_elements = [flow_curves(self.rows, laws, element) for element in elements]
        return grouped(of_elements, self.unexplained)

    @cached_property
    def recommended_curves(self) -> list[tuple[list[FlowCurves], FieldCurves]]:
        """The recommended model and its rival over slip, and the recommended one over the field, of each element."""
        recommended = self.models[self.recommended]
        models: dict[str, Model] = {self.recommended: recommended}
        if self.rival is not None:
            models[self.rival] = self.models[self.rival]
        curves: list[tuple[list[FlowCurves], FieldCurves]] = []
        for element in range(len(self.rows.data.elements)):
            over_slip = flow_curves(self.rows, models, element, self.dot_wait)
            over_field = field_curves(self.rows, recommended, element, self.dot_wait)
            curves.append((over_slip, over_field))
        return curves

    @property
    def without_field(self) -> bool:
        """Whether no log has a field: it is zero all along, in no unit."""
        if self.rows.data.units.field != "?":
            return False
        return not any(element.field.any() for element in self.rows.data.elements)

    @cached_property
    def dot_wait(self) -> int:
        """Rows that the field has stayed before each dot of these curves."""
        model = self.models[self.recommended]
        elements = range(len(self.rows.data.elements))
        return min(waited(self.rows, model, element) for element in elements)

    @property
    def unexplained(self) -> float:
        """RMSE of the best model on the rows held out: what no model of the run explains; 0 where nobody knows."""
        errors = [e["test"]["rmse"][0] for e in self.body["ranking"]]
        return min((error for error in errors if error is not None), default=0.0)

    @property
    def about_flow_curves(self) -> str:
        """What to know of the flow curves, in words: laws drawn once, fields without rows, laws without dots."""
        curves = self.flow_curves[0]
        sentences: list[str] = []
        stand_for: list[str] = []
        for law in curves:
            if law.alike:
                others = ", ".join(self.titles[other.model] for other in law.alike)
                stand_for.append(f"{self.titles[law.model]} stands for {others} too")
        if stand_for:
            limit = f"{self.effort.of(self.unexplained, 2)}, the RMSE of the best model"
            sentences.append(
                f"Curves nowhere further apart than {limit}, are drawn once: {'; '.join(stand_for)}."
            )

        rare: set[float] = set()
        for element in range(len(self.flow_curves)):
            rare.update(rare_fields(self.rows, element).tolist())
        if rare:
            at = ", ".join(self.field.of(field, 2) for field in sorted(rare))
            sentences.append(
                f"The log has hardly any rows at {at}: there the curves are the laws' guess."
            )

        dots = {law.model: sum(map(len, law.dots)) for law in curves}
        enough = 0.25 * max(dots.values(), default=0)
        few = [self.titles[name] for name, count in dots.items() if count < enough]
        if few:
            why = "for a dot is a row whose field was still as long as the law's lag"
            sentences.append(f"{', '.join(few)}: few dots or none, {why}.")
        return " ".join(sentences)

    def element_name(self, element: int) -> str:
        """CH1 and CH2 for a pair; empty for a single device."""
        return f"CH{element + 1}" if len(self.rows.data.elements) > 1 else ""


def material_of(run: Run) -> Material:
    """All that is needed of a run.

    Raises:
        RunError: a file of the run is missing or was changed.
    """
    made = Material(run, read_rows(run))
    run.file("table.csv")
    _ = made.models
    return made


def material_in_memory(comparison: Comparison) -> Material:
    """All that is needed of a comparison that is kept in no folder."""
    data = comparison.data
    origins = data.origins or ("",) * len(data.sources)
    logs: list[dict[str, str]] = []
    for name, origin in zip(data.sources, origins, strict=True):
        logs.append({"name": name, "origin": origin})
    body = {**run_to_dict(comparison, (), None), "logs": logs}
    estimates = {e.name: e.predicted for e in comparison.entries}
    rows = RunRows(data, comparison.test, estimates)
    models = {entry.name: entry.outcome.model for entry in comparison.entries}
    return Material(Run(Path("RUN"), body), rows, fitted=models)
