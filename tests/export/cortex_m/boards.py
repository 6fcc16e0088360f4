"""Cortex-M boards under QEMU: the exported C on bare metal, instructions a step, stack and flash.

QEMU runs with -icount shift=0, one instruction a nanosecond of virtual time; SysTick ticks at the board's 25 MHz, so a
tick is 40 instructions. A step is the mean over the vectors with the call and its loop, the empty loop taken off.
"""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from erclutch.export.c.compilers import EXACT, run
from erclutch.export.exported_step import ExportedStep

_HERE = Path(__file__).parent
_COMPILER, _EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"


@dataclass(frozen=True)
class Board:
    """A board that QEMU knows.

    Attributes:
        name: for people.
        machine: QEMU's name.
        cpu: the compiler's name of the core.
        fpu: and of its floating-point unit.
    """

    name: str
    machine: str
    cpu: str
    fpu: str

    def here(self) -> bool:
        """Whether compiler and emulator are installed."""
        return shutil.which(_COMPILER) is not None and shutil.which(_EMULATOR) is not None


BOARDS = (
    Board("Cortex-M4F", "mps2-an386", "cortex-m4", "fpv4-sp-d16"),
    Board("Cortex-M7", "mps2-an500", "cortex-m7", "fpv5-sp-d16"),
)


@dataclass(frozen=True)
class Outcome:
    """What a board said.

    Attributes:
        printed: bits and flags of each vector.
        instructions: mean of a step.
        stack: bytes of stack at most, below main's own.
        flash: bytes of code and constants of the exported file.
    """

    printed: str
    instructions: float
    stack: int
    flash: int

    @property
    def note(self) -> str:
        """As words."""
        return f"{self.instructions:.0f} instructions a step, {self.stack} B stack, {self.flash} B flash"


def run_board(
    board: Board,
    program: ExportedStep,
    folder: Path,
    work: Path,
    repeats: int = 8,
    traced: Path | None = None,
) -> Outcome:
    """Compile for a board, run under QEMU; instructions are counted over so many rounds of the vectors.

    Args:
        board: to run on.
        program: exported.
        folder: that its files are in.
        work: a folder for what is compiled; the program for the board is `board.elf`.
        repeats: rounds.
        traced: a file for the address of each instruction that runs; the program then says which line it is of.

    Raises:
        ExportError: the compiler or the emulator failed.
    """
    n = program.name
    words = [
        _COMPILER,
        *EXACT,
        "-O2",
        f"-mcpu={board.cpu}",
        "-mthumb",
        f"-mfpu={board.fpu}",
        "-mfloat-abi=hard",
    ]
    words += ["-ffunction-sections", "-fdata-sections"]
    words += ["-g"] if traced else []
    step = work / "step.o"
    what = f"cannot be compiled for the {board.name}"
    run(
        [*words, "-c", str(folder / f"{n}.c"), "-o", str(step)],
        f"{n}.c {what}",
        "Export the model again",
    )
    link = [
        "-ffreestanding",
        "-nostartfiles",
        "-Wl,--gc-sections",
        "-T",
        str(_HERE / "board.ld"),
        "-I",
        str(folder),
    ]
    link += [f'-DHEADER="{n}.h"', f'-DVECTORS="{n}_vectors.h"', f"-DINPUTS={len(program.inputs)}u"]
    link += [f"-DREPEATS={repeats}u"]
    link += [
        f"-D{name}={n}_{name}"
        for name in ("state", "reset", "step", "inverse", "inverse_now", "real")
    ]
    image = work / "board.elf"
    sources = [str(_HERE / "board.c"), str(step)]
    run(
        [*words, *link, *sources, "-o", str(image)],
        f"the test bench {what}",
        "Install libnewlib-arm-none-eabi",
    )
    log = work / "board.log"
    log.unlink(missing_ok=True)
    emulator = [
        _EMULATOR,
        "-M",
        board.machine,
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        "none",
    ]
    emulator += ["-chardev", f"file,id=out,path={log}"]
    emulator += ["-semihosting-config", "enable=on,target=native,chardev=out", "-icount", "shift=0"]
    emulator += ["-singlestep", "-d", "exec,nochain", "-D", str(traced)] if traced else []
    run(
        [*emulator, "-kernel", str(image)],
        f"{n} on the {board.name} under QEMU did not end well",
        "Export it again",
    )
    return _outcome(log.read_text(encoding="ascii"), _flash(step))


def _outcome(text: str, flash: int) -> Outcome:
    counts = {
        k: float(v) for k, v in re.findall(r"^(TICKS|EMPTY|CALLS|STACK) (\d+)$", text, re.MULTILINE)
    }
    printed = "\n".join(
        line for line in text.splitlines() if re.match(r"[0-9a-f]{8,16} \d+$", line)
    )
    each = 40.0 * (counts["TICKS"] - counts["EMPTY"]) / counts["CALLS"]
    return Outcome(printed, each, int(counts["STACK"]), flash)


def _flash(step: Path) -> int:
    """Code, constants and initial data of the object file."""
    text = (
        run(["arm-none-eabi-size", str(step)], "no size", "Install binutils-arm-none-eabi")
        .splitlines()[1]
        .split()
    )
    return int(text[0]) + int(text[1])
