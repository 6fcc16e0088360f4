"""What a step of the exported controller (stages, inverse, interlock, model) costs on a Cortex-M4F and an M7, in QEMU.

    python studies/controller_cost.py [--models NAME ...] [--where]

The models are fitted to the TWIN, in float32. Instructions are the mean over samples of a drive that turns while the
wanted torque swings by 0.3 and by 1.2 times the largest effort of the log, with each observer, and by the model where
no meter is read: then nothing is asked of it. Needs gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm.

With --where it prints in which functions the instructions of a step run on the M4F at 0.3: of the function itself, and
with those that the compiler put into it.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from erclutch.cli import terminal
from erclutch.export import ExportedStep, ExportOptions, step_of
from erclutch.export.c.c_printer import table
from erclutch.export.targets.c import rows_of_bits
from erclutch.models.load import load_model
from erclutch.wings.live.controller_check import INPUTS
from erclutch.wings.live.targets import controller
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin_model import twin_models

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "export" / "cortex_m"))
from boards import BOARDS, run_board  # pyright: ignore[reportMissingImports]

MODELS = ("bingham/forward", "hem", "hem+rise-fall", "fnn-16")
NO_METER = "BY_MODEL, no meter"
OBSERVERS = (NO_METER, "BY_MODEL", "BY_SENSOR", "BY_MOTION")
#: The board's bench calls a step of a state, an input and an effort: here the controller's.
_HEADER = """#include "ctl.h"
typedef ctl_controller bench_state;
typedef ctl_real bench_real;
void bench_reset(bench_state *state);
uint32_t bench_step(bench_state *state, const ctl_real *in, ctl_real *effort);
uint32_t bench_inverse(const ctl_real *in, ctl_real wanted, ctl_real *field);
uint32_t bench_inverse_now(const bench_state *state, const ctl_real *in, ctl_real wanted, ctl_real *field);
"""
_CODE = """#include "ctl.c"
#include "bench.h"
void bench_reset(bench_state *state)
{{
    ctl_settings settings = CTL_CONTROL_DEFAULTS;
    settings.observer = CTL_{observer};
    settings.gain_rate = 2.0f;
    settings.integral_rate = 5.0f;
    settings.drive_inertia = 0.000244f;
    (void)ctl_control_reset(state, &settings);
}}
uint32_t bench_step(bench_state *state, const ctl_real *in, ctl_real *effort)
{{
    const ctl_input input = {{in[0], in[1], in[2], in[3], in[4], in[5], in[6]}};
    ctl_output output;
    const uint32_t flags = ctl_control_step(state, &input, &output);
    *effort = output.field1 - output.field2;
    return flags;
}}
uint32_t bench_inverse(const ctl_real *in, ctl_real wanted, ctl_real *field)
{{
    return ctl_inverse(in, wanted, field);
}}
uint32_t bench_inverse_now(const bench_state *state, const ctl_real *in, ctl_real wanted, ctl_real *field)
{{
    return ctl_inverse_now(&state->model, in, wanted, field);
}}
"""


def bench(program: ExportedStep, observer: str, small: bool, folder: Path) -> SimpleNamespace:
    """The controller as the bench's step; its folder gets the files."""
    controller.write_core(program, folder)
    half = slice(0, 256) if small else slice(256, 512)
    rows = controller.sample_rows(program, odd=0)[half]
    rows = np.column_stack([rows, 0.0 * rows[:, :2]])
    if observer == NO_METER:
        rows[:, INPUTS.index("torque")] = np.nan
    names = ("steps", "fields", "ahead")
    parts = (rows, rows[:1], rows[:1, :2])
    vectors = [rows_of_bits(program, name, part) for name, part in zip(names, parts, strict=True)]
    vectors += [table("uint32_t", f"{name}_flags", ["0u"]) for name in ("step", "field", "ahead")]
    counts = f"#include <stdint.h>\n#define STEPS {len(rows)}u\n#define FIELDS 1u\n#define AHEAD 1u\n#define ULP 1.0\n"
    (folder / "bench_vectors.h").write_text(counts + "\n".join(vectors), encoding="ascii")
    (folder / "bench.h").write_text(_HEADER, encoding="ascii")
    (folder / "bench.c").write_text(_CODE.format(observer=observer.split(",")[0]), encoding="ascii")
    return SimpleNamespace(name="bench", inputs=INPUTS)


_ADDRESS = re.compile(r"\[[0-9a-f]+/([0-9a-f]+)/")  # in a line of QEMU's trace


def where(program: ExportedStep, observer: str) -> list[tuple[str, float, float]]:
    """Functions of the controller with the instructions of a step in themselves, and with what was put into them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        named, trace = bench(program, observer, small=True, folder=folder), folder / "trace"
        run_board(BOARDS[0], named, folder, folder, repeats=1, traced=trace)  # pyright: ignore
        with trace.open(encoding="ascii") as lines:
            ran = Counter(found[1] for line in lines if (found := _ADDRESS.search(line)))
        told = subprocess.run(
            ["arm-none-eabi-addr2line", "-a", "-f", "-i", "-s", "-e", str(folder / "board.elf")],
            input="\n".join(ran),
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    own, whole, steps = Counter[str](), Counter[str](), 0
    for address, text in zip(ran, re.split(r"^0x", told, flags=re.MULTILINE)[1:], strict=True):
        functions = text.splitlines()[1::2]  # the innermost first; a line of the source behind each
        own[functions[0]] += ran[address]
        whole.update(dict.fromkeys(functions, ran[address]))
        if (
            functions[-1] == "bench_step"
        ):  # its first instruction runs once a step, as most of its others
            steps = max(steps, ran[address])
    return [
        (function, own[function] / steps, count / steps)
        for function, count in whole.most_common()
        if function.startswith("ctl_")
    ]


def _program(name: str) -> ExportedStep:
    path = twin_models(default_rig(), (name,), terminal.console())[0]
    return step_of(load_model(path), ExportOptions("ctl", "float32", 1e-3))


def print_where(name: str, program: ExportedStep) -> None:
    """A table for each observer."""
    for observer in OBSERVERS:
        print(f"| {name}, {observer} | itself | with what was put into it |\n| --- | ---: | ---: |")
        for function, own, whole in where(program, observer):
            if whole >= 1.0:
                print(f"| {function} | {own:.0f} | {whole:.0f} |", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--models", nargs="+", default=MODELS)
    parser.add_argument("--where", action="store_true", help="in which functions")
    asked = parser.parse_args()
    if shutil.which("arm-none-eabi-gcc") is None:
        parser.error(
            "needs arm-none-eabi-gcc and qemu-system-arm: apt-get install gcc-arm-none-eabi qemu-system-arm"
        )
    if asked.where:
        for name in asked.models:
            print_where(name, _program(name))
        return
    print(
        "| model | observer | M4F at 0.3 | M4F at 1.2 | M7 at 0.3 | M7 at 1.2 | stack B | flash B |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in asked.models:
        program = _program(name)
        for observer in OBSERVERS:
            counts: list[str] = []
            for board in BOARDS:
                for small in (True, False):
                    with tempfile.TemporaryDirectory() as folder:
                        named = bench(program, observer, small, Path(folder))
                        found = run_board(board, named, Path(folder), Path(folder))  # pyright: ignore
                        counts.append(f"{found.instructions:.0f}")
            print(
                f"| {name} | {observer} | {' | '.join(counts)} | {found.stack} | {found.flash} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
