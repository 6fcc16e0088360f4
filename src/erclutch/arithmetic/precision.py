"""A model is exported in one of two number formats; this module says what is the same in NumPy and in C."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.signals.array import Array

PrecisionName = Literal["float32", "float64"]


@dataclass(frozen=True)
class Precision:
    """An IEEE 754 format.

    Attributes:
        name: float32 or float64, NumPy's name.
        c_type: C's name.
        suffix: of a C constant.
        width: bits.
        fraction: bits of the fraction, without the hidden one.
        bias: of the exponent.
    """

    name: PrecisionName
    c_type: str
    suffix: str
    width: int
    fraction: int
    bias: int

    @property
    def dtype(self) -> np.dtype[Any]:
        """NumPy's type of numbers."""
        return np.dtype(self.name)

    @property
    def bits(self) -> np.dtype[Any]:
        """NumPy's unsigned type of the same width."""
        return np.dtype(f"uint{self.width}")

    @property
    def c_bits(self) -> str:
        """C's unsigned type of the same width."""
        return f"uint{self.width}_t"

    @property
    def bits_suffix(self) -> str:
        """Suffix of a C constant of `c_bits`."""
        return "u" if self.width == 32 else "ULL"

    @property
    def epsilon(self) -> float:
        """Distance from 1 to the next number."""
        return 2.0**-self.fraction

    def round(self, value: float) -> float:
        """A number as this format holds it."""
        return float(np.asarray(value).astype(self.dtype))

    def constant(self, value: float) -> str:
        """A C constant: hexadecimal, so that every compiler reads the same bits."""
        held = self.round(value)
        if held == int(held) and abs(held) < 1000:
            return f"{held:.1f}{self.suffix}"
        mantissa, _, exponent = held.hex().partition("p")
        digits = mantissa.rstrip("0") if "." in mantissa else mantissa
        return f"{digits}{'0' if digits.endswith('.') else ''}p{exponent}{self.suffix}"

    def steps(self, value: NDArray[Any], expected: NDArray[Any]) -> Array:
        """How many numbers of this format lie between two, 0 where they are the same bits but for the sign of zero."""
        return np.abs(self._place(value) - self._place(expected)).astype(np.float64)

    def _place(self, value: NDArray[Any]) -> NDArray[Any]:
        signed = np.asarray(value, self.dtype).view(f"int{self.width}").astype(object)
        lowest = -(2 ** (self.width - 1))
        return np.where(signed < 0, lowest - signed, signed)


FLOAT32 = Precision("float32", "float", "f", 32, 23, 127)
FLOAT64 = Precision("float64", "double", "", 64, 52, 1023)
PRECISIONS: dict[PrecisionName, Precision] = {"float32": FLOAT32, "float64": FLOAT64}
