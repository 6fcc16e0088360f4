"""``erclutch flowcurve`` fits laws of shear stress to measured flow curves."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from erclutch.cli import terminal

COMMAND = {
    "help": "Fit laws of shear stress to flow curves.",
    "panel": "More logs",
    "place": 5,
}


def flowcurve(
    files: Annotated[tuple[Path, ...], Parameter(name="FILE", negative=())],
    *,
    laws: Annotated[tuple[str, ...], Parameter(consume_multiple=True, negative=())] = (),
    parameters: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Fit laws of shear stress to flow curves (shear rate [1/s] and shear stress [Pa]) and say which wins where.

    Args:
        files: CSV: pairs of columns with a label over each pair, or one column of rates and one of stresses a curve.
        laws: Which laws to fit. Default: all laws that have a meaning at one field.
        parameters: Also print the best law's parameters with intervals.
        json: Print everything as JSON.
    """
    from collections import Counter

    import numpy as np

    from erclutch.wings.rheology.flow_curve import FLOW_LAWS, FlowCurve, FlowFit, ranked
    from erclutch.wings.rheology.flow_curve_file import read_flow_curves

    chosen = laws or FLOW_LAWS
    curves = [(path.name, *curve) for path in files for curve in read_flow_curves(path)]
    found: list[tuple[str, str, int, list[FlowFit]]] = []
    with terminal.progress("fitting flow curves") as bar:
        for done, (file, label, rates, stresses) in enumerate(curves, start=1):
            curve = FlowCurve(label, np.array(rates), np.array(stresses))
            found.append((file, label, len(rates), ranked(curve, chosen)))
            bar(done, len(curves), "fitting flow curves")
    if json:
        body = [
            {"file": file, "curve": label, "points": n, "fits": [fit.to_dict() for fit in fits]}
            for file, label, n, fits in found
        ]
        print(dumps(body, indent=1, allow_nan=False))
        return
    names = sorted({fit.law for *_, fits in found for fit in fits}, key=FLOW_LAWS.index)
    rows: list[list[str]] = []
    for file, label, n, fits in found:
        errors = {fit.law: fit.log_rmse for fit in fits}
        rows.append([file, label, str(n), *(f"{errors[name]:.4f}" for name in names), fits[0].law])
    title = "Root mean square residual of log10(shear stress)"
    table = terminal.table(title, ["file", "curve", "points", *names, "best by AICc"], rows, left=2)
    terminal.tell(table)
    wins = Counter(fits[0].law for *_, fits in found)
    terminal.tell("Best on: " + ", ".join(f"{law} {count} of {len(found)}" for law, count in wins.most_common()))
    if parameters:
        for file, label, _, fits in found:
            terminal.tell(terminal.estimates(f"{file}, {label}: {fits[0].law}", fits[0].estimates))
