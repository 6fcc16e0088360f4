"""How full the pages of a PDF are."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np


def page_fills(pdf: Path) -> list[float]:
    """How far down each page its ink reaches, 0 .. 1; empty without pdftoppm."""
    pixels = shutil.which("pdftoppm")
    if pixels is None:
        return []
    fills: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([pixels, "-r", "30", "-gray", pdf, f"{folder}/page"], check=True)
        for page in sorted(Path(folder).glob("page-*.pgm")):
            _, size, _, grey = page.read_bytes().split(b"\n", 3)
            width, height = map(int, size.split())
            rows = np.frombuffer(grey, np.uint8).reshape(height, width)[
                : int(0.93 * height)
            ]  # without its number
            fills.append(round(float(np.flatnonzero((rows < 200).any(axis=1))[-1]) / height, 2))
    return fills
