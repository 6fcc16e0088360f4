"""The steps of the page "Onto an STM32" as far as QEMU goes: interrupt, flags, and the bits of the vectors."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import good

ROOT = Path(__file__).resolve().parents[2]
BOARD = ROOT / "examples" / "stm32"
PAGE = ROOT / "docs" / "stm32.md"

needs_board = pytest.mark.skipif(
    not all(map(shutil.which, ("arm-none-eabi-gcc", "qemu-system-arm", "make"))),
    reason="needs arm-none-eabi-gcc and qemu-system-arm",
)


@pytest.fixture(scope="module")
def export(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The export that the page makes, of a shorter log."""
    folder = tmp_path_factory.mktemp("stm32")
    write_synthetic_log(folder / "bench.csv", 4)
    good("fit", "bench.csv", "--models", "casson", "--lag", "lag", "--out", "run", cwd=folder)
    words = ("--precision", "float32", "--period", "1ms", "--name", "brake", "--out", "brake_c")
    good("export", "run", *words, cwd=folder)
    return folder / "brake_c"


def made(export: Path, build: Path, *more: str) -> subprocess.CompletedProcess[str]:
    words = ["make", "-C", str(BOARD), "run", f"EXPORT={export}", f"BUILD={build}", *more]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.slow
@needs_board
def test_the_timer_interrupt_gives_the_bits_of_the_vectors(export: Path, tmp_path: Path) -> None:
    done = made(export, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == "", "the compiler warns"
    figures = dict(re.findall(r"^([a-z0-9 ]+): (\d+)$", done.stdout, re.MULTILINE))
    assert figures["periods of 1 ms"] == figures["the same to the bit"] == "256"
    stated = re.search(r"State: (\d+) bytes", (export / "brake.h").read_text())
    assert stated is not None
    assert figures["bytes of state"] == stated[1]
    shown = re.search(r"instructions of the longest: (\d+)", PAGE.read_text("utf-8"))
    assert shown is not None
    assert 0.5 * int(shown[1]) < int(figures["instructions of the longest"]) < 1.5 * int(shown[1])


@pytest.mark.slow
@needs_board
def test_flags_that_change_the_arithmetic_are_told_on_the_board(
    export: Path, tmp_path: Path
) -> None:
    done = made(export, tmp_path, "EXACT=-std=c99 -ffast-math")
    assert done.returncode != 0
    assert "INEXACT" in done.stdout or "bit: 256" not in done.stdout


def test_the_page_and_the_makefile_name_the_same_flags() -> None:
    makefile = (BOARD / "Makefile").read_text("utf-8")
    page = PAGE.read_text("utf-8")
    for flags in re.findall(r"^(?:CPU|EXACT) = (.*)$", makefile, re.MULTILINE):
        for flag in flags.split():
            assert flag in page, flag
