"""Coefficients of the exported C's own exp, expm1, log and tanh, and how they were found.

    python studies/elementary.py

prints them as hex floats, as `erclutch.arithmetic.elementary` holds them (a test compares the two). Polynomials are
Chebyshev fits of 60 digits; tanh for float32 is an odd rational by Lawson's weighted least squares, and its largest
error on every float32 comes last. Needs mpmath, which comes with SymPy.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.elementary_coefficients import found, largest_tanh_error

if __name__ == "__main__":
    for name, numbers in found().items():
        print(f"{name} = ({', '.join(n.hex() for n in numbers)})")
    print(f"tanh in float32 is at most {largest_tanh_error():.2f} units of the last place off")
