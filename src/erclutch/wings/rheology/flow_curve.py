"""A flow curve is shear stress against shear rate at one field (or none); this module finds the laws that describe it.

Shear stress spans decades, so what is minimised is the residual of its logarithm. The laws are those of the clutches
at a constant field, so one definition serves both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.errors import CheckError, SettingError
from erclutch.fit.intervals import as_json, uncertainty
from erclutch.fit.laws.law_starts import scan_points
from erclutch.fit.laws.variable_projection import Separable, coordinates, parameters, project, triangle_of
from erclutch.fit.levenberg_marquardt import Linearisation, Minimum, Problem, minimise
from erclutch.fit.outcome import Estimate
from erclutch.models.laws import Dimension, Gain, Law, ShapeParameter, law_from_name
from erclutch.signals.array import Array
from erclutch.signals.shown import Shown, one_line
from erclutch.wings.rheology.flow_plateau import plateau_of

if TYPE_CHECKING:
    from erclutch.report.notebook import Card
    from erclutch.report.plots.plot_description import Plot

#: Laws of shear stress that have a meaning at one field, from the simplest to the richest.
FLOW_LAWS = ("bingham", "casson", "herschel-bulkley", "seo-seo", "cho-choi-jhon")
_STIFF = 1e-9
_FAINTEST = 1e-6
_STRETCHES = 5  # of rates, each held out once
_NO_DIFFERENCE = 1e-12  # of two mean squares of ln(stress): below the rounding of a fit
_NEAR = 1.5  # of the best error: a law beyond that is no match for the best
_LEAST_INDEX = 0.02


@dataclass(frozen=True, repr=False)
class FlowCurve(Shown):
    """One measured flow curve.

    Attributes:
        label: what the file calls it.
        rate: shear rate in 1/s, positive, shape (n,).
        stress: shear stress in Pa, positive, shape (n,).
    """

    label: str
    rate: Array
    stress: Array

    def __repr__(self) -> str:
        ends = [f"{x.min():.4g} to {x.max():.4g} {unit}" for x, unit in ((self.rate, "1/s"), (self.stress, "Pa"))]
        return one_line(self, self.label, f"{self.rate.size} points", *ends)

    def notebook_card(self) -> Card:
        """What a notebook shows: the points."""
        from erclutch.report.notebook import Card, as_frame

        return Card(
            self.label,
            lambda: as_frame({"rate [1/s]": self.rate, "stress [Pa]": self.stress}),
            plots={"points": lambda: _described(self, ()), "laws": lambda: _described(self, ranked(self))},
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
        rmse: root mean square residual in Pa.
        aicc: Akaike's criterion for few points, on the logarithms; lower is better; inf where there are too few points.
        predicted: stress at the curve's rates, shape (n,).
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

    def __repr__(self) -> str:
        errors = (f"RMSE {self.rmse:.3g} Pa", f"{self.log_rmse:.3g} of log10(stress)")
        return one_line(self, self.law, *errors, self.stop)

    def notebook_card(self) -> Card:
        """What a notebook shows: the parameters."""
        from erclutch.report.notebook import Card, estimates_as_frame

        return Card(self.law, lambda: estimates_as_frame(self.estimates))

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "law": self.law,
            "stop": self.stop,
            "log_rmse": self.log_rmse,
            "rmse_Pa": self.rmse,
            "aicc": as_json(self.aicc),
            "validated_log_rmse": as_json(self.validated),
            "yield_stress_is_what_the_curve_shows": self.yield_shown,
            "parameters": [e.to_dict() for e in self.estimates],
        }


def _described(curve: FlowCurve, fits: Sequence[FlowFit]) -> Plot:
    """The points on two logarithmic axes, and the stress by each law as a line."""
    from erclutch.report.plots.plot_description import Axis, Dots, Line, Panel, Plot, PlotTable

    order = np.argsort(curve.rate)
    lines = [
        Line(curve.rate[order], fit.predicted[order], f"series{k + 1}", fit.law, dashed=k > 0)
        for k, fit in enumerate(fits)
    ]
    dots = Dots(curve.rate, curve.stress, "series0", curve.label if lines else "", 2.4)
    x = Axis("shear rate", "1/s", log=True)
    y = Axis("shear stress", "Pa", log=True)
    panel = Panel(x, y, [*lines, dots], f"Shear stress over shear rate of {curve.label}.")
    return Plot([panel], PlotTable((), ()), 2.6)


def fit_flow_curve(curve: FlowCurve, law_name: str) -> FlowFit:
    """Fit a law to a flow curve by least squares of log(stress).

    Args:
        curve: at least 4 points.
        law_name: one of `FLOW_LAWS`.

    Raises:
        SettingError: not a law of shear stress.
        CheckError: too few points, or rates or stresses that are not positive.
    """
    law = _law(law_name)
    _check(curve)
    reference = float(curve.rate.min())
    x = curve.rate / reference
    shapes = _bounded(law, float(x.max()))
    target = np.log(curve.stress)
    problem = _problem(law, shapes, x, target)
    found = min(
        (minimise(problem, u, tolerance=1e-12, max_iterations=300) for u in _starts(law, shapes, x, curve.stress)),
        key=lambda m: m.cost,
    )
    return _fit(curve, law, shapes, x, problem, found, reference)


def _law(name: str) -> Law:
    law = law_from_name(name)
    if law.name not in FLOW_LAWS:
        raise SettingError(
            f"{name} is no law of shear stress at one field", remedy=f"Choose from {', '.join(FLOW_LAWS)}"
        )
    return law_from_name(f"{law.name}/square")


def _check(curve: FlowCurve) -> None:
    if curve.rate.size < 4:
        raise CheckError(
            f"{curve.rate.size} points, at least 4 are needed", where=curve.label, remedy="Measure more rates"
        )
    for name, values in (("shear rate", curve.rate), ("shear stress", curve.stress)):
        bad = ~(np.isfinite(values) & (values > 0))
        if bad.any():
            raise CheckError(
                f"the {name} of point {int(np.argmax(bad)) + 1} is {values[bad][0]:g}, it must be above 0",
                where=curve.label,
                remedy="Remove the point, or give magnitudes",
            )


def _bounded(law: Law, highest: float) -> tuple[ShapeParameter, ...]:
    """The law's own shape parameters, times as wide as the data's rates (normalised, 1 to ``highest``).

    A gel's stress may hardly grow with the rate, so the flow index goes lower than that of a clutch.
    """
    wide = [
        replace(s, lower=1e-3 / highest, upper=1e3) if s.dimension == Dimension(slip=-1) else s for s in law.shape[1:]
    ]
    return tuple(replace(s, lower=_LEAST_INDEX) if s.name == "m" else s for s in wide)


def _stress(law: Law, x: Array, shape: Sequence[Any], gains: Sequence[Any]) -> Any:
    # At a constant field all rates are positive, so the sign is taken as stiff and its width is no parameter.
    columns = law.columns(np.ones_like(x), x, _STIFF, *shape)
    total = gains[0] * columns[0]
    for gain, column in zip(gains[1:], columns[1:], strict=True):
        total = total + gain * column
    return total


def _problem(law: Law, shapes: tuple[ShapeParameter, ...], x: Array, target: Array) -> Problem:
    """Over the coordinates of the shape parameters, then the logarithms of the gains."""
    k = len(shapes)
    ends = [coordinates(shapes, [getattr(s, end) for s in shapes]) for end in ("lower", "upper")]
    top = float(target.max()) + 3.0
    lower = np.concatenate(
        [ends[0], np.full(len(law.gains), float(target.min()) + np.log(_FAINTEST) - np.log(x.max()))]
    )
    upper = np.concatenate([ends[1], np.full(len(law.gains), top)])

    def log_stress(values: Sequence[Any]) -> Any:
        return np.log(_stress(law, x, values[:k], values[k:]))

    def numbers(u: Array) -> list[float]:
        return [*parameters(shapes, u[:k]), *np.exp(u[k:]).tolist()]

    def cost(u: Array) -> float:
        with np.errstate(all="ignore"):
            residual = target - log_stress(numbers(u))
        total = float(residual @ residual)
        return total if np.isfinite(total) else np.inf

    def linearise(u: Array) -> Linearisation:
        slopes = [1.0 if i < k and shapes[i].scale == "linear" else v for i, v in enumerate(numbers(u))]
        duals = [Dual(v, {i: s}) for i, (v, s) in enumerate(zip(numbers(u), slopes, strict=True))]
        with np.errstate(all="ignore"):
            model = log_stress(duals)
        residual = target - value_of(model)
        jacobian = np.column_stack([np.broadcast_to(partial_of(model, i), x.shape) for i in range(u.size)])
        r = triangle_of(np.column_stack([jacobian, residual]))
        return Linearisation(float(residual @ residual), r[:-1, :-1], r[:-1, -1])

    return Problem(cost, linearise, lower, upper)


def _starts(
    law: Law, shapes: tuple[ShapeParameter, ...], x: Array, stress: Array, *, least: bool = False
) -> list[Array]:
    """The best points of a scan of the shape, with the gains that minimise the relative residual there.

    ``least`` takes a tenth of the points: for the fits of the validation, whose minimum lies near that of all points.
    """

    def columns(q: Sequence[Any]) -> list[Any]:
        return [c / stress for c in law.columns(np.ones_like(x), x, _STIFF, *q)]

    relative = Separable(columns, np.ones_like(x), shapes, law.gains)
    lower, upper = relative.bounds
    scan, starts = _effort(len(shapes))
    if least:
        scan, starts = max(scan // 10, 20), max(starts // 6, 2)
    points = list(scan_points(lower, upper, scan)) if shapes else [np.zeros(0)]
    costed = sorted(
        ((project(relative, parameters(shapes, u)), tuple(u)) for u in points), key=lambda pair: pair[0].cost
    )
    faintest = _FAINTEST * float(stress.min()) / float(x.max())
    return [np.concatenate([u, np.log(np.maximum(p.gains, 10.0 * faintest))]) for p, u in costed[:starts]]


def _effort(unknowns: int) -> tuple[int, int]:
    """Points of the scan and local solves. On eight files of curves four times as many found nothing better."""
    return (1500, 24) if unknowns > 2 else (120, 4)


def _fit(
    curve: FlowCurve,
    law: Law,
    shapes: tuple[ShapeParameter, ...],
    x: Array,
    problem: Problem,
    found: Minimum,
    reference: float,
) -> FlowFit:
    k, n = len(shapes), x.size
    gains = np.exp(found.point[k:])
    predicted = np.asarray(_stress(law, x, parameters(shapes, found.point[:k]), gains.tolist()))
    residual = np.log(curve.stress) - np.log(predicted)
    unknowns = found.point.size
    cost = max(float(residual @ residual), float(np.finfo(float).tiny))  # a curve that the law meets to the last bit
    spare = n - unknowns - 2
    # Without noise a law may meet each point to the last bit: rounding is the least spread that a fit can claim.
    spread = max(cost / n, float(np.finfo(float).eps) ** 2)
    aicc = n * np.log(spread) + 2 * (unknowns + 1) * n / spare if spare > 0 else np.inf
    return FlowFit(
        law=law.name,
        stop=found.stop,
        estimates=_estimates(law, shapes, problem, found, reference, n),
        log_rmse=float(np.sqrt(cost / n) / np.log(10.0)),
        rmse=float(np.sqrt(np.mean((curve.stress - predicted) ** 2))),
        aicc=float(aicc),
        predicted=predicted,
    )


def _estimates(
    law: Law, shapes: tuple[ShapeParameter, ...], problem: Problem, found: Minimum, reference: float, n: int
) -> tuple[Estimate, ...]:
    model = problem.linearise(found.point)
    moving = ~(found.at_lower | found.at_upper)
    # The triangle has the Jacobian's column space; a residual of the right length gives the right variance.
    rows = model.triangle[:, moving]
    padded: Array = np.vstack([rows, np.zeros((max(n - rows.shape[0], 0), rows.shape[1]))])
    size = int(padded.shape[0])
    spread = uncertainty(padded, np.full(size, (found.cost / size) ** 0.5), ordered=False)
    everything = (*shapes, *law.gains)
    widths = np.full(len(everything), np.nan)
    widths[moving] = spread.quantile * spread.errors
    covariance = np.full((len(everything), len(everything)), 0.0)
    covariance[np.ix_(moving, moving)] = spread.covariance
    estimates: list[Estimate] = []
    for i, item in enumerate(everything):
        u, width = float(found.point[i]), float(widths[i])
        logarithmic = not isinstance(item, ShapeParameter) or item.scale == "log"
        unit, factor = _unit(item.dimension, reference)
        if item.name == "K":
            # Consistency at 1 1/s instead of at the reference rate: ln K_1 = ln K - m ln(reference).
            m = next(j for j, s in enumerate(shapes) if s.name == "m")
            shift = -float(np.log(reference))
            variance = covariance[i, i] + shift**2 * covariance[m, m] + 2 * shift * covariance[i, m]
            u, width, unit = u + float(found.point[m]) * shift, spread.quantile * float(np.sqrt(variance)), "Pa*s^m"
        ends = np.array([u, u - width, u + width])
        with np.errstate(over="ignore"):
            value, low, high = (np.exp(ends) if logarithmic else ends) * factor
        bound = "lower" if found.at_lower[i] else "upper" if found.at_upper[i] else None
        estimates.append(Estimate(item.name, _meaning(item), unit, float(value), float(low), float(high), bound))
    return tuple(estimates)


def _meaning(item: ShapeParameter | Gain) -> str:
    """A law's words for a clutch in those for a fluid."""
    if item.name == "K":
        return "consistency: viscous stress at 1 1/s"
    return item.meaning.replace("effort", "stress").replace("slip", "rate").removesuffix(" at the reference field")


def _unit(dimension: Dimension, reference: float) -> tuple[str, float]:
    """Unit of a parameter of shear stress, and the factor from normalised rates."""
    names = {(1, 0): "Pa", (1, -1): "Pa*s", (0, -1): "s", (0, 0): "1", (0, 1): "1/s"}
    return names[dimension.effort, dimension.slip], reference**dimension.slip


def ranked(curve: FlowCurve, laws: Sequence[str] = FLOW_LAWS) -> list[FlowFit]:
    """All laws on a curve, the chosen one first, the others by what they miss at rates that were held out.

    A curve is cut into stretches of rates. Each law is fitted without a stretch and judged on it, so that a law with
    many parameters gains nothing by following noise. Chosen is the law with the fewest parameters that is as good as
    the best within the standard error of the difference, and at most half as far off again. Too few points for that:
    the corrected criterion ranks.

    Raises:
        SettingError, CheckError: see `fit_flow_curve`.
    """
    fits = [fit_flow_curve(curve, name) for name in laws]
    residuals = [_held_out(curve, fit) for fit in fits]
    plateau = plateau_of(curve.rate, curve.stress)
    judged: list[tuple[FlowFit, Array | None]] = []
    for fit, residual in zip(fits, residuals, strict=True):
        error = np.inf if residual is None else float(np.sqrt(np.mean(residual**2)) / np.log(10.0))
        judged.append((replace(fit, validated=error, yield_shown=_shows(fit, plateau)), residual))
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
        within = difference.mean() <= difference.std(ddof=1) / np.sqrt(difference.size) + _NO_DIFFERENCE
        # One hard point makes any standard error large: the errors themselves must be near as well.
        if within and fit.validated <= _NEAR * best.validated + _NO_DIFFERENCE:
            as_good.append(fit)
    chosen = min(as_good, key=lambda fit: (len(fit.estimates), fit.validated))
    return [chosen, *(fit for fit, _ in judged if fit is not chosen)]


def _held_out(curve: FlowCurve, fit: FlowFit) -> Array | None:
    """Residuals of ln(stress) at each rate by a fit without the stretch of rates around it; None: too few points."""
    law = _law(fit.law)
    unknowns = len(law.shape) - 1 + len(law.gains)
    points = curve.rate.size
    stretches = min(_STRETCHES, points)
    if points - -(-points // stretches) < unknowns + 1:
        return None
    reference = float(curve.rate.min())
    x = curve.rate / reference
    shapes = _bounded(law, float(x.max()))
    residuals = np.empty(points)
    for held in np.array_split(np.argsort(curve.rate, kind="stable"), stretches):
        train = np.setdiff1d(np.arange(points), held)
        problem = _problem(law, shapes, x[train], np.log(curve.stress[train]))
        starts = _starts(law, shapes, x[train], curve.stress[train], least=True)
        found = min((minimise(problem, u, tolerance=1e-10, max_iterations=200) for u in starts), key=lambda m: m.cost)
        k = len(shapes)
        gains = np.exp(found.point[k:]).tolist()
        predicted = _stress(law, x[held], parameters(shapes, found.point[:k]), gains)
        residuals[held] = np.log(curve.stress[held]) - np.log(predicted)
    return residuals


def yield_text(fit: FlowFit) -> str:
    """The yield stress of a fit with its interval in Pa, where the curve shows it; else that it is not identified."""
    if not fit.yield_shown:
        return "not identified"
    stress = yield_stress_of(fit)
    if not np.isfinite([stress.low, stress.high]).all():
        return f"{stress.value:.4g}"
    return f"{stress.value:.4g} ({stress.low:.4g} - {stress.high:.4g})"


def yield_stress_of(fit: FlowFit) -> Estimate:
    """The law's yield stress."""
    return next(estimate for estimate in fit.estimates if estimate.name in ("T_y", "T_sy"))


def _shows(fit: FlowFit, plateau: tuple[float, float] | None) -> bool | None:
    """Whether the interval of a fit's yield stress meets the plateau of the curve."""
    if plateau is None:
        return None
    stress = yield_stress_of(fit)
    low, high = (stress.value if np.isnan(end) else end for end in (stress.low, stress.high))
    return low <= plateau[1] and high >= plateau[0]
