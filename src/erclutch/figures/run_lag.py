"""Error after a switch of the command, and step responses of the models with a lag."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.switching import after_switch, step_responses
from erclutch.errors import CheckError
from erclutch.figures.parts import Numbers, role_line, titled


def height(material: Material) -> float:
    """Height that the panels need, in inches."""
    return 1.9 * (2 if any(e["dynamics"] for e in material.body["ranking"]) else 1)


def draw_lag(figure: Any, material: Material) -> Numbers:
    """One or two panels, as far as the run has switches and models with a lag.

    Raises:
        CheckError: it has neither.
    """
    after = after_switch(material.rows, material.shown_names)
    steps = step_responses(material.body, material.shown_names)
    if after is None and not steps:
        raise CheckError(
            "the command hardly ever switches and no model has a lag",
            where=str(material.run.folder),
            remedy="Fit with --lag auto, or log with a switched field",
        )
    axes: Any = figure.subplots(2 if after is not None and steps else 1, 1, squeeze=False)[:, 0]
    roles = {s.name: s.role for s in material.shown}
    rows: list[tuple[object, ...]] = []
    if after is not None:
        since = np.maximum(after.since * 1e3, 0.5e3 * material.period)
        for name, rmse in after.rmse.items():
            axes[0].semilogx(since, rmse * material.effort.factor, label=name, **role_line(roles[name]))
            rows += [("rmse", name, float(t), float(v)) for t, v in zip(after.since, rmse, strict=True)]
        axes[0].set_xlabel(titled(material, "Time since a switch [ms]"))
        axes[0].set_ylabel(material.effort.titled("RMSE"))
        axes[0].set_ylim(bottom=0.0)
    if steps:
        t = np.linspace(0.0, 1.15 * max(s.delay + 4.5 * max(s.rise, s.fall) for s in steps), 241)
        for step in steps:
            axes[-1].plot(t * 1e3, step.up(t), label=step.model, **role_line(roles[step.model]))
            rows += [("step", step.model, float(a), float(b)) for a, b in zip(t, step.up(t), strict=True)]
            if step.fall != step.rise:
                axes[-1].plot(t * 1e3, step.down(t), **role_line(roles[step.model]))
                rows += [("fall", step.model, float(a), float(b)) for a, b in zip(t, step.down(t), strict=True)]
        axes[-1].set_xlabel("Time since a step [ms]")
        axes[-1].set_ylabel("Field in the fluid, share")
        axes[-1].set_ylim(0.0, 1.05)
    axes[0].legend(handlelength=1.6)
    return Numbers(["curve", "model", "time_s", "value"], rows)
