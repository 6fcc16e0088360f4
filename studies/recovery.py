#!/usr/bin/env python
"""Known-truth recovery: does the stated 95 % interval hold the true parameter in 95 % of repetitions?

For each law: inputs that excite all of it, effort from the law itself with known numbers, noise drawn anew in each
repetition, a fit from the default scan (the truth is never a start), and a count of how often each true number lies in
its interval. Once with white noise and once with noise whose neighbours are correlated (AR(1), 0.6; "ar1-0.9": 0.9).

    python studies/recovery.py [--repetitions 200] [--laws bingham casson] [--workers 2] [--noises ar1-0.9]

The case "cho-choi-jhon (loud)" has so much noise that a fifth of its fits end at a bound.

Exits with 1 where a law's coverage, pooled over its parameters, misses 95 % by more than 3 points. Fewer than 100
repetitions cannot tell that, and get no verdict.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

# One BLAS thread a fit; before NumPy is imported, here and in the workers, which inherit it.
if __name__ == "__main__":
    for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(_name, "1")

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.recovery import (
    CORRELATIONS,
    ENOUGH,
    ROWS,
    TARGET,
    TOLERANCE,
    TRUTHS,
    Coverage,
    study,
)

_HEAD = (
    f"{'law':22} {'noise':6} {'pooled':>7} {'least':>15} {'most':>15} {'error':>9} {'converged':>10} {'at bound':>9}"
    f" {'width':>6} {'bias':>6}"
)


def row_of(c: Coverage) -> str:
    """One line of the table."""
    least, most = min(c.inside, key=c.inside.__getitem__), max(c.inside, key=c.inside.__getitem__)

    def single(parameter: str) -> str:
        return f"{parameter} {c.inside[parameter] / c.repetitions:.1%}"

    worst_bias = max(c.bias.values(), key=abs)
    return (
        f"{c.name:22} {c.noise:6} {c.pooled:7.1%} {single(least):>15} {single(most):>15} "
        f"{np.median(list(c.error.values())):9.2%} {c.converged:6}/{c.repetitions:<3} {c.at_bounds:9} "
        f"{np.mean(list(c.width.values())):6.2f} {worst_bias:+6.2f}{'' if c.hit else '  MISSED'}"
    )


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(
        description="Known-truth recovery: coverage of the 95 % intervals."
    )
    parser.add_argument("--repetitions", type=int, default=200)
    parser.add_argument(
        "--laws", nargs="+", choices=list(TRUTHS), default=list(TRUTHS), metavar="LAW"
    )
    parser.add_argument(
        "--noises", nargs="+", choices=list(CORRELATIONS), default=["white", "ar1"], metavar="NOISE"
    )
    parser.add_argument("--rows", type=int, default=ROWS)
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--parameters", action="store_true", help="print each parameter besides")
    options = parser.parse_args(arguments)
    began = time.perf_counter()
    print(
        f"{options.repetitions} repetitions of {options.rows} rows; target {TARGET:.0%} +- {TOLERANCE:.0%} a law"
    )
    print(
        "error: median over parameters of the median relative error; width: half width over 1.96 times the scatter"
    )
    print(
        f"of the estimates, mean over parameters; bias: the largest, in standard deviations of the estimates\n\n{_HEAD}"
    )
    missed: list[str] = []
    for c in study(
        options.laws, options.noises, options.repetitions, options.workers, options.rows
    ):
        print(row_of(c), flush=True)
        if options.parameters:
            for p, count in c.inside.items():
                print(
                    f"    {p:10} inside {count / c.repetitions:6.1%}  error {c.error[p]:8.2%}"
                    f"  width {c.width[p]:5.2f}  bias {c.bias[p]:+5.2f}"
                )
        if not c.hit:
            missed.append(f"{c.name} ({c.noise})")
    verdict = (
        "all laws hit"
        if options.repetitions >= ENOUGH
        else f"no verdict from fewer than {ENOUGH} repetitions"
    )
    print(
        f"\n{time.perf_counter() - began:.0f} s; {'missed: ' + ', '.join(missed) if missed else verdict}"
    )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
