r"""What each model of a run costs on a Cortex-M, and how far its C is from NumPy.

    erclutch simulate training --seconds 60 --out twin.parquet
    erclutch fit twin.parquet --device coaxial --derivative difference --lag none --out run \
      --models all paper rbfn-50 fnn-10-6
    python studies/export_cost.py run

Instructions are the mean over the export's own test vectors under QEMU, stack is that of step and inverse together.
"ulp" is the largest difference from NumPy in float64 on 2000 random rows of the training range, in units of the last
place at the largest effort. Needs gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from erclutch.errors import ExportError
from erclutch.export import Options, program_of
from erclutch.export.boards import BOARDS, run_board
from erclutch.export.c import write
from erclutch.export.check import compare, ulps
from erclutch.export.rounding import measured, refuse_noise
from erclutch.export.vectors import vectors_of
from erclutch.runs import read_run


def main(folder: str) -> None:
    """Print the table."""
    run = read_run(folder)
    print("| model | ulp float64 | ulp float32 | M4F instructions | M7 | stack B | flash B |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name in sorted(run.names):
        model = run.model(name)
        wide, program = (program_of(model, Options("m", p, 1e-3)) for p in ("float64", "float32"))
        far = [f"{ulps(p, measured(p, 2000)[0]):.3g}" for p in (wide, program)]
        try:
            refuse_noise(program)
        except ExportError:
            print(f"| {name} | {far[0]} | refused: no digits left | | | | |", flush=True)
            continue
        with tempfile.TemporaryDirectory() as scratch:
            work = Path(scratch)
            write(program, work)
            found = [run_board(board, program, work, work) for board in BOARDS]
        vectors = vectors_of(program)
        for board, outcome in zip(BOARDS, found, strict=True):
            assert compare(program, vectors, board.name, outcome.printed).passed, (name, board.name)
        m4, m7 = found
        cost = f"{m4.instructions:.0f} | {m7.instructions:.0f} | {m4.stack} | {m4.flash}"
        print(f"| {name} | {' | '.join(far)} | {cost} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
