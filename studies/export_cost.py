r"""What each model of a run costs on a Cortex-M, and how far its C is from NumPy.

    erclutch simulate training --seconds 60 --out twin.parquet
    erclutch fit twin.parquet --device coaxial --derivative difference --lag none --out run \
      --models all paper rbfn-50 fnn-10-6
    python studies/export_cost.py run

Instructions are the mean over the export's own test vectors under QEMU, stack is that of step and inverse together.
"ulp" is the largest difference of the C from `predict` on 2000 random rows of the training range, in units of the last
place at the largest effort; "NumPy" that of `predict` in float64 from NumPy's own exp, tanh and powers. Needs
gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np

from erclutch.errors import ExportError
from erclutch.export import ExportedStep, ExportOptions, step_of
from erclutch.export.rounding import measured, refuse_noise
from erclutch.export.step_numbers import held_signals, named
from erclutch.export.step_record import step_record
from erclutch.export.step_vectors import ordinary, vectors_of
from erclutch.export.target_check import compare, ulps
from erclutch.export.targets.c import write
from erclutch.runs.run_folder import read_run
from erclutch.signals.clock import Clock, Span

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "export" / "cortex_m"))
from boards import BOARDS, run_board  # pyright: ignore[reportMissingImports]


def numpys_own(program: ExportedStep) -> float:
    """What NumPy's own functions make of the same rows, in ulp."""
    made = step_record(program)
    rows = ordinary(program, np.random.default_rng(0), 2000)
    _, elements, extras = held_signals(program, made, named(made, rows))
    clock = Clock(np.linspace(0.0, 1.999, 2000), (Span(0, 2000, 1e-3),))
    own, other = (
        program.model.effort(elements, clock, extras, exactly=flag) for flag in (True, False)
    )
    return ulps(program, float(np.max(np.abs(own - other))))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folder", metavar="RUN", help="a run folder")
    folder = parser.parse_args().folder
    if shutil.which("arm-none-eabi-gcc") is None:
        parser.error(
            "needs arm-none-eabi-gcc and qemu-system-arm: apt-get install gcc-arm-none-eabi qemu-system-arm"
        )
    run = read_run(folder)
    print(
        "| model | NumPy | ulp float64 | ulp float32 | M4F instructions | M7 | stack B | flash B |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in sorted(run.names):
        model = run.model(name)
        wide, program = (
            step_of(model, ExportOptions("m", p, 1e-3)) for p in ("float64", "float32")
        )
        far = [
            f"{numpys_own(wide):.3g}",
            *(f"{ulps(p, measured(p, 2000)[0]):.3g}" for p in (wide, program)),
        ]
        try:
            refuse_noise(program)
        except ExportError:
            print(
                f"| {name} | {' | '.join(far[:2])} | refused: no digits left | | | | |", flush=True
            )
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
    main()
