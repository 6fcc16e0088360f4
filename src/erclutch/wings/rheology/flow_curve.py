"""A flow curve is shear stress against shear rate at one field (or none); this module finds the law that describes it.

`FlowLaw` fits one law. Here the laws are judged at rates that their fits did not see, and one of them is chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import CheckError
from erclutch.fit.solver.intervals import as_json
from erclutch.fit.solver.outcome import Estimate
from erclutch.signals.array import Array, rms
from erclutch.signals.shown import Shown, one_line
from erclutch.wings.rheology.flow_law import Effort, FlowLaw, flow_laws
from erclutch.wings.rheology.flow_plateau import plateau_of

if TYPE_CHECKING:
    from erclutch.report.notebook import Card
    from erclutch.report.plots.plot_description import Plot

FEWEST_POINTS = 4  # of a curve
_STRETCHES = 5  # of rates, each held out once
_OPEN = 100.0  # times the lower end of an interval: beyond it, it tells no yield stress
_NO_DIFFERENCE = 1e-12  # of two mean squares of ln(stress): below the rounding of a fit
NEAR = 1.5  # of the best error: a law beyond that is no match for the best


@dataclass(frozen=True, repr=False)
class FlowCurve(Shown):
    """One measured flow curve.

    Attributes:
        label: what the file calls it.
        rate: shear rate in 1/s, positive, shape (n,).
        stress: shear stress in ``stress_unit``, positive, shape (n,).
        field: at which it was measured, in ``field_unit``; nan where the file tells none.
        field_unit: as the file writes it.
        stress_unit: "Pa"; "?" where the file holds viscosities and says no unit of them.
        rounding: half a last digit of the file's numbers, in ``stress_unit``, of the stress at the lowest rate: so far
            the stress may be beside what was measured; 0 where the file does not tell.
    """

    label: str
    rate: Array
    stress: Array
    field: float = np.nan
    field_unit: str = ""
    rounding: float = 0.0
    stress_unit: str = "Pa"

    def __repr__(self) -> str:
        rates = f"{self.rate.min():.4g} to {self.rate.max():.4g} 1/s"
        stresses = f"{self.stress.min():.4g} to {self.stress.max():.4g} {self.stress_unit}"
        return one_line(self, self.label, f"{self.rate.size} points", rates, stresses)

    def notebook_card(self) -> Card:
        """What a notebook shows: the points."""
        from erclutch.report.notebook import Card, as_frame

        return Card(
            self.label,
            lambda: as_frame(
                {"rate [1/s]": self.rate, f"stress [{self.stress_unit}]": self.stress}
            ),
            plots={
                "points": lambda: _described(self, ()),
                "laws": lambda: _described(self, ranked(self)),
            },
        )


@dataclass(frozen=True, repr=False)
class FlowFit(Shown):
    """A law on a flow curve.

    Attributes:
        law: name of the law.
        validated: root mean square residual of log10(stress) at rates that were held out, a stretch of rates at a time;
            inf where the curve has too few points for that.
        yield_shown: whether the interval of the law's yield stress holds what the curve shows at low rates; None for
            a curve without a plateau there, which shows none.
        stop: how the solver ended.
        estimates: parameters with 95 % intervals (of their logarithms, so never below zero).
        log_rmse: root mean square residual of log10(stress).
        rmse: root mean square residual in ``stress_unit``.
        aicc: Akaike's criterion for few points, on the logarithms; lower is better; inf where there are too few points.
        predicted: stress at the curve's rates, shape (n,).
        stress_unit: of the curve, see `FlowCurve`.
    """

    law: str
    stop: str
    estimates: tuple[Estimate, ...]
    log_rmse: float
    rmse: float
    aicc: float
    predicted: Array
    validated: float = np.inf
    yield_shown: bool | None = None
    stress_unit: str = "Pa"

    def __repr__(self) -> str:
        errors = (
            f"RMSE {self.rmse:.3g} {self.stress_unit}",
            f"{self.log_rmse:.3g} of log10(stress)",
        )
        return one_line(self, self.law, *errors, self.stop)

    def notebook_card(self) -> Card:
        """What a notebook shows: the parameters."""
        from erclutch.report.notebook import Card, estimates_as_frame

        return Card(self.law, lambda: estimates_as_frame(self.estimates))

    @property
    def yield_stress(self) -> Estimate:
        """The law's yield stress."""
        return next(each for each in self.estimates if each.name in ("T_y", "T_sy"))

    def meets(self, plateau: tuple[float, float]) -> bool:
        """Whether the interval of the yield stress meets the plateau of the curve, and is no open one."""
        stress = self.yield_stress
        # At a bound there is no interval: the value alone is compared.
        low = stress.value if np.isnan(stress.low) else stress.low
        high = stress.value if np.isnan(stress.high) else stress.high
        if not high <= _OPEN * low:  # it meets any plateau
            return False
        lowest_shown, highest_shown = plateau
        return low <= highest_shown and high >= lowest_shown

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "law": self.law,
            "stop": self.stop,
            "log_rmse": self.log_rmse,
            "rmse_Pa" if self.stress_unit == "Pa" else "rmse": self.rmse,
            "aicc": as_json(self.aicc),
            "validated_log_rmse": as_json(self.validated),
            "yield_stress_is_what_the_curve_shows": self.yield_shown,
            "parameters": [e.to_dict() for e in self.estimates],
        }


def _described(curve: FlowCurve, fits: Sequence[FlowFit]) -> Plot:
    """The points on two logarithmic axes, and the stress by each law as a line."""
    from erclutch.report.plots.plot_description import Axis, Dots, Line, Panel, Plot, PlotTable

    order = np.argsort(curve.rate)
    lines: list[Line] = []
    for place, fit in enumerate(fits):
        style = f"series{place + 1}"
        lines.append(
            Line(curve.rate[order], fit.predicted[order], style, fit.law, dashed=place > 0)
        )
    dots = Dots(curve.rate, curve.stress, "series0", curve.label if lines else "", 2.4)
    x = Axis("shear rate", "1/s", log=True)
    y = Axis("shear stress", curve.stress_unit, log=True)
    panel = Panel(x, y, [*lines, dots], f"Shear stress over shear rate of {curve.label}.")
    return Plot([panel], PlotTable((), ()), 2.6)


def fit_flow_curve(curve: FlowCurve, law_name: str) -> FlowFit:
    """Fit a law to a flow curve by least squares of log(stress).

    Args:
        curve: at least 4 points.
        law_name: one of `flow_laws`.

    Raises:
        SettingError: not a law of shear stress.
        CheckError: too few points, or rates or stresses that are not positive.
    """
    if curve.rate.size < FEWEST_POINTS:
        problem = f"{curve.rate.size} points, at least {FEWEST_POINTS} are needed"
        raise CheckError(problem, where=curve.label, remedy="Measure more rates")
    for name, values in (("shear rate", curve.rate), ("shear stress", curve.stress)):
        bad = ~(np.isfinite(values) & (values > 0))
        if bad.any():
            point = int(np.argmax(bad)) + 1
            problem = f"the {name} of point {point} is {values[bad][0]:g}, it must be above 0"
            raise CheckError(
                problem, where=curve.label, remedy="Remove the point, or give magnitudes"
            )

    law = FlowLaw.of(law_name, curve.rate)
    minimum = law.fit(curve.rate, curve.stress, Effort.whole(len(law.shapes)))
    predicted = law.stress(curve.rate, minimum.point)
    residual = np.log(curve.stress) - np.log(predicted)
    points = curve.rate.size

    # Where a law meets each point to the last bit, rounding is the least spread that a fit can claim.
    cost = max(float(residual @ residual), float(np.finfo(float).tiny))
    spread = max(cost / points, float(np.finfo(float).eps) ** 2)
    unknowns = law.unknowns + 1  # with the spread
    spare = points - unknowns - 1
    aicc = np.inf
    if spare > 0:
        aicc = points * np.log(spread) + 2 * unknowns * points / spare
    estimates = [
        replace(each, unit=each.unit.replace("Pa", curve.stress_unit))
        for each in law.estimates(law.problem(curve.rate, curve.stress), minimum, points)
    ]
    return FlowFit(
        law=law.law.name,
        stop=minimum.stop,
        estimates=tuple(estimates),
        log_rmse=float(np.sqrt(cost / points) / np.log(10.0)),
        rmse=rms(curve.stress - predicted),
        aicc=float(aicc),
        predicted=predicted,
        stress_unit=curve.stress_unit,
    )


def ranked(curve: FlowCurve, laws: Sequence[str] = ()) -> list[FlowFit]:
    """All laws on a curve, the chosen one first, the others by what they miss at rates that were held out.

    A curve is cut into stretches of rates. Each law is fitted without a stretch and judged on it, so that a law with
    many parameters gains nothing by following noise. Chosen is the law with the fewest parameters that is as good as
    the best within the standard error of the difference, and at most half as far off again. Too few points for that:
    the corrected criterion ranks.

    Args:
        curve: at least 4 points.
        laws: their names; all of `flow_laws` by default.

    Raises:
        SettingError, CheckError: see `fit_flow_curve`.
    """
    names = laws or flow_laws()
    fits = [fit_flow_curve(curve, name) for name in names]
    plateau = plateau_of(curve.rate, curve.stress, curve.rounding)
    points = curve.rate.size
    stretches = np.array_split(np.argsort(curve.rate, kind="stable"), min(_STRETCHES, points))
    longest_stretch = max(held.size for held in stretches)
    # Each law with its residuals of ln(stress) at each rate, by a fit without the stretch of rates around that rate;
    # None: too few points.
    judged: list[tuple[FlowFit, Array | None]] = []
    for name, fit in zip(names, fits, strict=True):
        law = FlowLaw.of(name, curve.rate)
        residual = None
        validated = np.inf
        if points - longest_stretch >= law.unknowns + 1:
            residual = np.empty(points)
            for held in stretches:
                train = np.setdiff1d(np.arange(points), held)
                effort = Effort.of_validation(len(law.shapes))
                minimum = law.fit(curve.rate[train], curve.stress[train], effort)
                predicted = law.stress(curve.rate[held], minimum.point)
                residual[held] = np.log(curve.stress[held]) - np.log(predicted)
            validated = float(rms(residual) / np.log(10.0))
        shown = None if plateau is None else fit.meets(plateau)
        judged.append((replace(fit, validated=validated, yield_shown=shown), residual))
    judged.sort(key=lambda pair: (pair[0].validated, pair[0].aicc, pair[0].log_rmse))
    best, reference = judged[0]
    if reference is None:
        return [fit for fit, _ in judged]
    as_good: list[FlowFit] = [best]
    for fit, residual in judged[1:]:
        if residual is None:
            continue
        # Squared residuals of the same points, so that what is hard for all laws cancels.
        difference = residual**2 - reference**2
        standard_error = difference.std(ddof=1) / np.sqrt(difference.size)
        within = difference.mean() <= standard_error + _NO_DIFFERENCE
        # One hard point makes any standard error large: the errors themselves must be near as well.
        is_near = fit.validated <= NEAR * best.validated + _NO_DIFFERENCE
        if within and is_near:
            as_good.append(fit)
    chosen = min(as_good, key=lambda fit: (len(fit.estimates), fit.validated))
    return [chosen, *(fit for fit, _ in judged if fit is not chosen)]


def yield_text(fit: FlowFit) -> str:
    """The yield stress of a fit with its interval, where the curve shows it; else that it is not identified."""
    if not fit.yield_shown:
        return "not identified"
    stress = fit.yield_stress
    if not np.isfinite([stress.low, stress.high]).all():
        return f"{stress.value:.4g}"
    return f"{stress.value:.4g} ({stress.low:.4g} - {stress.high:.4g})"
