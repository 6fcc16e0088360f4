"""What the compilers of this machine cost the live loop: time to compile, and time of a step.

    python studies/live_compilers.py

Each compiler builds the loop's program and an exported model into an empty cache. zig is the compiler in the wheel
``ziglang``, and its own cache is empty, too: it compiles parts of the C library at its first use.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import tempfile
import time
from importlib.metadata import distribution
from pathlib import Path

import numpy as np

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.export.c.compilers import Compiler, natives
from erclutch.export.targets.python import build as build_model
from erclutch.export.targets.python import library_name
from erclutch.models.load import load_model
from erclutch.wings.live.c_build import CORE, SOURCES, build, loop_program
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform, config_of

MODEL = Path(__file__).resolve().parents[1] / "tests" / "wings" / "live" / "model.json"
_STEPS = 2_000_000
_BENCH = """
#include "erc_core.h"
#include <stdio.h>
#include <time.h>
int main(int count, char **words) {
    static erc_config config; static erc_core core; erc_command command; erc_frame frame;
    FILE *file = fopen(words[1], "rb");
    if (count != 2 || file == 0 || fread(&config, sizeof config, 1, file) != 1) { return 1; }
    erc_core_init(&core, &config, 0, 0);
    const clock_t start = clock();
    for (uint64_t k = 0; k < STEPS; k++) {
        erc_sample sample = {k + 1u, (k + 1u) * 1000000u, 0.04 * (double)k, 5.0, 0.1, 0u, 0u};
        erc_core_step(&core, &sample, 1u, k, 0u, 0u, &command, &frame);
    }
    printf("%g", 1e9 * (double)(clock() - start) / CLOCKS_PER_SEC / STEPS);
    return 0;
}
"""


def compiling() -> float:
    """CPU time of all compilers so far in s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def step_time(compiler: Compiler, folder: Path) -> float:
    """Time of the loop's core on one sample that tracks a sine, in ns."""
    (folder / "bench.c").write_text(_BENCH)
    sine = LoopProgram("sine", Mode.TRACK, Waveform.SINE, 5.0, 1.0, motor_torque=0.1)
    (folder / "config").write_bytes(config_of(LoopSettings(programs=(sine,)))[0])
    sources = [folder / "bench.c", *(SOURCES / name for name in CORE)]
    made = build("bench", sources, flags=(f"-I{SOURCES}", f"-DSTEPS={_STEPS}u"), compiler=compiler)
    return min(float(subprocess.check_output([made, folder / "config"])) for _ in range(5))


def model_times(compiler: Compiler, folder: Path) -> tuple[float, float]:
    """CPU time to compile the model in s, and time of its step in ns."""
    program = step_of(
        load_model(MODEL), ExportOptions(name="live", precision="float64", period=1e-3)
    )
    start = compiling()
    build_model(program, folder, compiler)
    compiled = compiling() - start
    model = CompiledModel(folder / library_name(program))
    rows = np.random.default_rng(0).uniform((0, 0, 20, -10), (0.5, 0, 60, 10), (200_000, 4))
    times = []
    for _ in range(5):
        start = time.process_time()
        model.run(rows)
        times.append(time.process_time() - start)
    return compiled, min(times) / len(rows) * 1e9


def main() -> None:
    """Print a line a compiler."""
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    ).parse_args()
    wheel = distribution("ziglang")
    size = sum(Path(str(wheel.locate_file(file))).stat().st_size for file in wheel.files or ())
    print(f"ziglang {wheel.version}: {size / 1e6:.0f} MB installed")
    print(
        "| compiler | loop compiled [CPU s] | model compiled [CPU s] | core's step [ns] | model's step [ns] |"
    )
    print("| --- | --- | --- | --- | --- |")
    for compiler in natives():
        with tempfile.TemporaryDirectory() as name:
            os.environ["ERCLUTCH_CACHE"] = os.environ["ZIG_GLOBAL_CACHE_DIR"] = f"{name}/cache"
            start = compiling()
            loop_program(compiler)
            loop = compiling() - start
            compiled, model = model_times(compiler, Path(name))
            core = step_time(compiler, Path(name))
        print(f"| {compiler.name} | {loop:.1f} | {compiled:.1f} | {core:.0f} | {model:.0f} |")


if __name__ == "__main__":
    main()
