"""The outcome of running an exported artefact on the test vectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.errors import ExportError
from erclutch.export.program import Program
from erclutch.export.vectors import Vectors
from erclutch.precision import Precision


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


def compare(program: Program, vectors: Vectors, where: str, printed: str, note: str = "") -> Check:
    """Lines ``bits flags`` of all steps, then of all inverses, against the vectors.

    Raises:
        ExportError: not that many lines, or no numbers.
    """
    p = program.precision
    steps, fields = len(vectors.effort), len(vectors.field)
    lines = [line.split() for line in printed.splitlines() if line.strip()]
    try:
        if len(lines) != steps + fields:
            raise ValueError(f"{len(lines)} results for {steps + fields} vectors")
        values = np.array([int(line[0], 16) for line in lines], p.bits).view(p.dtype)
        flags = np.array([int(line[1]) for line in lines], np.uint32)
    except (ValueError, IndexError) as error:
        raise ExportError(f"unreadable results: {error}", where=where, remedy="Export the model again") from error
    expected = np.concatenate([vectors.effort, vectors.field])
    expected_flags = np.concatenate([vectors.flags, vectors.field_flags])
    other = (values.view(p.bits) != expected.view(p.bits)) | (flags != expected_flags)
    difference = np.abs(values[:steps].astype(np.float64) - vectors.numpy)
    return Check(where, len(lines), int(np.count_nonzero(other)), ulps(program, float(difference.max())), note=note)


def ulps(program: Program, difference: float, precision: Precision | None = None) -> float:
    """A difference of efforts in units of the last place at the largest training effort."""
    p = precision or program.precision
    return difference / float(np.spacing(p.dtype.type(program.scale)))
