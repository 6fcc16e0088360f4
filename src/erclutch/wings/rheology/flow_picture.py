"""The picture of flow curves: points with a law through them, and the yield stress against the field beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.plots.plot_description import (
    COLUMN,
    PAGE,
    Axis,
    Dots,
    Line,
    Mark,
    Panel,
    Plot,
    PlotTable,
)
from erclutch.signals.array import Array
from erclutch.wings.rheology.field_series import FieldSeries
from erclutch.wings.rheology.flow_curve import FlowCurve, FlowFit

_SHADES = 6  # the last shade of the ramp of fields
_SERIES = 8  # colours of curves without a field; the next as many curves are dashed
_HEIGHT = 2.8  # inches
_MOST_INSIDE = 5  # names that have room beside the curves
_NAME_ABOVE = 0.16  # inches, of a name above the curves


def picture_of(fitted: Sequence[tuple[FlowCurve, FlowFit]], series: FieldSeries | None) -> Plot:
    """Curves on two logarithmic axes, each with a law; of a series one law for all, and a panel of the yield stress.

    Args:
        fitted: curves with their chosen laws; those of a series stand in it.
        series: of the same curves.
    """
    drawn = list(series.curves) if series else list(fitted)
    last = max(len(drawn) - 1, 1)
    marks: list[Mark] = []
    rows: list[tuple[object, ...]] = []
    for place, (curve, fit) in enumerate(drawn):
        style = f"level{round(_SHADES * place / last)}" if series else f"series{place % _SERIES}"
        label = f"{curve.field:.4g} {curve.field_unit}" if series else curve.label
        order = np.argsort(curve.rate, kind="stable")
        marks.append(Dots(curve.rate, curve.stress, style, size=2.0))
        is_repeated = series is None and place // _SERIES % 2 == 1
        marks.append(
            Line(curve.rate[order], fit.predicted[order], style, label, dashed=is_repeated)
        )
        field = curve.field if curve.field_unit else ""
        for rate, stress, predicted in zip(curve.rate, curve.stress, fit.predicted, strict=True):
            rows.append(
                (
                    curve.label,
                    field,
                    curve.field_unit,
                    float(rate),
                    float(stress),
                    fit.law,
                    float(predicted),
                ),
            )

    unit = drawn[0][0].stress_unit  # of all curves of a file
    law = series.law if series else "the chosen laws"
    flow = Panel(
        Axis("shear rate", "1/s", log=True),
        Axis("shear stress", unit, log=True),
        marks,
        f"Shear stress over shear rate of {len(drawn)} curves, with {law} through the points.",
        f"points, and {law}",
    )
    panels = [flow]

    # Beside it the yield stresses with their intervals, and the power law through them; not for fewer than two.
    points: list[tuple[float, float, float, float]] = []  # field, yield stress, its interval
    for curve, fit in series.curves if series else ():
        by_law = fit.yield_stress
        if fit.yield_shown:
            points.append((curve.field, by_law.value, by_law.low, by_law.high))
    if series is not None and len(points) > 1:
        numbers: Array = np.array(points)
        fields, yields, lows, highs = (numbers[:, column] for column in range(4))
        of_yield: list[Mark] = []
        for at, lowest, highest in zip(fields, lows, highs, strict=True):
            # A band between the fields would tell of fields that nobody measured.
            if np.isfinite([lowest, highest]).all():
                interval = np.array([lowest, highest])
                of_yield.append(Line(np.array([at, at]), interval, "measured"))
        of_yield.append(Dots(fields, yields, "measured", f"by {series.law}", 2.4))
        if series.growth is not None:
            exponent = series.growth.exponent
            line: Array = np.linspace(0.0, float(fields.max()), 60)
            power_law: Array = series.growth.factor * line**exponent
            of_yield.append(Line(line, power_law, "recommended", f"field^{exponent:.3g}"))
        yields_over_field = Panel(
            Axis("field", series.unit),
            Axis("yield stress", unit),
            of_yield,
            f"Yield stress over field, by {series.law} for all curves.",
            "yield stress",
        )
        panels.append(yields_over_field)

    header = (
        "curve",
        "field",
        "unit of the field",
        "shear rate [1/s]",
        f"stress [{unit}]",
        "law",
        f"stress by the law [{unit}]",
    )
    is_crowded = len(drawn) > _MOST_INSIDE
    # A name above has a line of its own; those of fields are short and share lines.
    names_above = len(drawn) if is_crowded and not series else 0
    return Plot(
        panels,
        PlotTable(header, rows),
        _HEIGHT + _NAME_ABOVE * names_above,
        PAGE if len(panels) > 1 else COLUMN,
        len(panels),
        legend="above" if is_crowded else "inside",
    )
