"""A target check is the outcome of running an export on its test vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.precision import FLOAT64
from erclutch.errors import ExportError
from erclutch.export.exported_step import ExportedStep
from erclutch.export.rounding import NOISE, bound
from erclutch.export.step_vectors import Vectors
from erclutch.signals.array import largest_size


@dataclass(frozen=True)
class Check:
    """One artefact on one machine.

    Attributes:
        where: compiler, processor or tool.
        count: steps and inverses that were run.
        other_bits: how many of them differ from what is expected by a bit or a flag; None for a target that computes
            in another order and is not meant to give the same bits.
        ulp: largest difference from NumPy in float64, in units of the last place at the largest training effort.
        allowed: limit of `ulp` for targets that do not give the same bits.
        note: what else was measured.
    """

    where: str
    count: int
    other_bits: int | None
    ulp: float
    allowed: float = float("inf")
    note: str = ""

    @property
    def passed(self) -> bool:
        """Whether it does what the model does."""
        return not self.other_bits and self.ulp <= self.allowed


def to_the_bit(
    step: ExportedStep,
    vectors: Vectors,
    where: str,
    values: NDArray[Any],
    flags: NDArray[Any],
    note: str = "",
) -> Check:
    """Efforts of all steps, and fields of all inverses if they were run, against the vectors, bit by bit.

    First come the inverses at rest, then those of the next step, then the ends of the band if they were looked at.
    """
    p = step.precision
    count = len(values)  # a target may leave out what comes last
    no_flags = np.zeros(vectors.band.size, np.uint32)
    expected = np.concatenate(
        [vectors.effort, vectors.field, vectors.field_now, vectors.band.ravel()]
    )
    expected_flags = np.concatenate(
        [vectors.flags, vectors.field_flags, vectors.field_now_flags, no_flags]
    )
    held = values.astype(p.dtype)
    other_bits = held.view(p.bits) != expected[:count].view(p.bits)
    other_flags = flags != expected_flags[:count]
    other = int(np.count_nonzero(other_bits | other_flags))

    efforts = held[: len(vectors.effort)].astype(np.float64)
    largest = largest_size(efforts - vectors.numpy)
    return Check(where, count, other, ulps(step, largest), note=note)


def compare(
    step: ExportedStep,
    vectors: Vectors,
    where: str,
    printed: str,
    note: str = "",
) -> Check:
    """Lines ``bits flags`` of all steps, then of all inverses, then perhaps of the band, against the vectors.

    Raises:
        ExportError: not that many lines, or no numbers.
    """
    p = step.precision
    without_band = len(vectors.effort) + len(vectors.field) + len(vectors.field_now)
    with_band = without_band + vectors.band.size
    lines = [line.split() for line in printed.splitlines() if line.strip()]
    try:
        if len(lines) not in (without_band, with_band):
            raise ValueError(f"{len(lines)} results for {without_band} vectors")
        bits = [int(line[0], 16) for line in lines]
        values = np.array(bits, p.bits).view(p.dtype)
        words = [int(line[1]) for line in lines]
        flags = np.array(words, np.uint32)
    except (ValueError, IndexError) as error:
        raise ExportError(
            f"unreadable results: {error}", where=where, remedy="Export the model again"
        ) from error
    return to_the_bit(step, vectors, where, values, flags, note)


#: What the functions of other libraries may be worse by than ours.
_SLACK = 8.0


def near(
    step: ExportedStep,
    vectors: Vectors,
    where: str,
    effort: NDArray[Any],
    flags: NDArray[Any],
) -> Check:
    """Steps of a target with functions of somebody else: against NumPy in float64, within what rounding may make."""
    other_flags = np.asarray(flags, np.uint32) != vectors.flags
    other = int(np.count_nonzero(other_flags))
    off = np.asarray(effort, np.float64) - vectors.numpy
    difference = largest_size(off)
    largest = ulps(step, difference) if np.isfinite(difference) else float("inf")

    rounding = bound(step, vectors.rows) + bound(step, vectors.rows, FLOAT64)
    most = float(np.max(rounding))
    # A bound beyond the effort itself says nothing: no more is allowed than the export of a precision may be off.
    limit = most if most < step.scale else NOISE * step.scale
    return Check(where, len(vectors.flags), other or None, largest, _SLACK + ulps(step, limit))


def ulps(step: ExportedStep, difference: float) -> float:
    """A difference of efforts in units of the last place at the largest training effort."""
    one_ulp = float(np.spacing(step.precision.dtype.type(step.scale)))
    return difference / one_ulp
