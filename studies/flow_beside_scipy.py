"""Herschel-Bulkley by `flowcurve` beside a plain SciPy fit: `python studies/flow_beside_scipy.py FILE ...`.

Both minimise the residual of ln(stress) = ln(tau_y + K rate^m); SciPy starts from nine points. Printed for each curve:
the parameters by both, the largest difference in per cent, and the root mean square residual of log10(stress) by both.
A parameter that SciPy's own covariance leaves open by more than a fifth, or a yield stress that both find to be
nothing, is shown and not compared. The curves are REAL.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from erclutch.errors import ErclutchError
from erclutch.signals.array import Array
from erclutch.wings.rheology.flow_curve import FlowCurve, fit_flow_curve
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

NAMES = ("tau_y", "K", "m")
ENOUGH = 5  # rates for three parameters
NOTHING = 1e-6  # of the smallest stress
OPEN = 0.2  # relative standard error from which on a parameter is not compared


def by_scipy(curve: FlowCurve) -> tuple[Array, Array, float]:
    """Yield stress in Pa, consistency at 1 1/s and exponent, shape (3,), their relative errors, and the residual."""
    target = np.log(curve.stress)

    def residual(u: Array) -> Array:
        return np.log(np.exp(u[0]) + np.exp(u[1]) * curve.rate ** np.exp(u[2])) - target

    low, high = float(curve.stress.min()), float(curve.stress.max())
    starts = [
        [np.log(share * low), np.log(high / curve.rate.max() ** power), np.log(power)]
        for share in (0.9, 0.1, 1e-3)
        for power in (0.3, 0.6, 1.0)
    ]
    fits = [
        least_squares(residual, start, xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=4000)
        for start in starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    jacobian = np.asarray(best.jac, dtype=np.float64)
    spread = 2 * best.cost / max(curve.rate.size - 3, 1) * np.linalg.pinv(jacobian.T @ jacobian)
    rms = float(np.sqrt(2 * best.cost / curve.rate.size) / np.log(10))
    return np.exp(best.x), np.sqrt(np.diag(spread)), rms


def main() -> int:
    """Print a row a curve; the exit code is 1 where a known parameter differs by more than 1 %."""
    worst = 0.0
    compared = curves = 0
    for path in map(Path, sys.argv[1:]):
        try:
            file = read_flow_curves(path)
        except ErclutchError as error:
            print(f"{path.name}: {str(error)[:150]}")
            continue
        for curve in file.curves:
            rates = np.unique(np.round(np.log10(curve.rate), 2))
            if rates.size < ENOUGH:  # a course in time at two rates tells no three parameters
                continue
            curves += 1
            fit = fit_flow_curve(curve, "herschel-bulkley")
            yield_stress, *_ = [each for each in fit.estimates if each.name not in NAMES[1:]]
            rest = {each.name: each.value for each in fit.estimates}
            ours = np.array([yield_stress.value, rest["K"], rest["m"]])
            theirs, errors, rms = by_scipy(curve)
            known = errors < OPEN
            if max(ours[0], theirs[0]) < NOTHING * curve.stress.min():
                known[0] = False  # no yield stress by both
            apart = np.abs(ours / theirs - 1.0)
            compared += int(known.sum())
            worst = max(worst, float(apart[known].max(initial=0.0)))
            shown = ", ".join(
                f"{name} {a:.4g} / {b:.4g}{'' if k else ' (open)'}"
                for name, a, b, k in zip(NAMES, ours, theirs, known, strict=True)
            )
            most = float(apart[known].max(initial=0.0))
            print(
                f"{path.name}, {curve.label}: {shown}; {most:.2%}; {fit.log_rmse:.5f} / {rms:.5f}",
                flush=True,
            )
    print(f"{curves} curves, {compared} parameters that the data tell: {worst:.2%} apart at most")
    return int(worst > 0.01)


if __name__ == "__main__":
    sys.exit(main())
