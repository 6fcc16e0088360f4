"""The solver on the NIST StRD problems: 27 nonlinear regressions with certified answers, each from two starts.

    python studies/nist.py [FOLDER]

FOLDER holds the ``.dat`` files of https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml; without it, those beside the
project. Solver, derivatives and standard errors are the project's own (`erclutch.fit.solver.levenberg_marquardt`,
`erclutch.arithmetic.dual`, `erclutch.fit.solver.intervals`). Digits are -log10 of the largest relative difference from
a certified number, at most 11. Exits with 1 where a problem is missed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.nist_problems import DIGITS, FOLDER, MODELS, ROUNDING, read, solve


def main(arguments: Sequence[str]) -> int:
    """Print the table; 0 if every problem is solved from both starts."""
    if len(arguments) > 1:
        sys.stderr.write("usage: python studies/nist.py [FOLDER]\n")
        return 2
    folder = Path(arguments[0]) if arguments else FOLDER
    absent = [name for name in MODELS if not (folder / f"{name}.dat").is_file()]
    if absent:
        sys.stderr.write(
            f"error: {folder} lacks {', '.join(f'{name}.dat' for name in absent)}. Give the folder.\n"
        )
        return 2
    print(f"{'problem':<10}{'start 1':>9}{'start 2':>9}{'std. errors':>13}{'iterations':>15}")
    solved: list[str] = []
    with_errors: list[str] = []
    for name in MODELS:
        problem = read(name, folder)
        one, two = (solve(name, problem, start) for start in problem.starts)
        error_digits = min(one.error_digits, two.error_digits)
        steps = f"{one.iterations} + {two.iterations}"
        print(f"{name:<10}{one.digits:>9.1f}{two.digits:>9.1f}{error_digits:>13.1f}{steps:>15}")
        if min(one.digits, two.digits) >= DIGITS:
            solved.append(name)
        if error_digits >= DIGITS:
            with_errors.append(name)
    short = [name for name in MODELS if name not in with_errors]
    exception = f" (all but {', '.join(short)})" if short else ""
    print(
        f"digits, {DIGITS:g} needed, 11 shown at most; standard errors: {len(with_errors)} of {len(MODELS)}{exception}"
    )
    print(f"{len(solved)} of {len(MODELS)} to {DIGITS:g} digits from both starts")
    return 0 if len(solved) == len(MODELS) and set(short) <= {ROUNDING} else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
