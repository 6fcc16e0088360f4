"""A compiled module that a full disk left torn is one line, and the next command works."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
@pytest.mark.parametrize("module", ["overview", "__init__"])
@pytest.mark.parametrize("end", [b"", b"\0" * 4000])
def test_a_compiled_module_that_is_not_whole_is_told_once(
    tmp_path: Path, module: str, end: bytes
) -> None:
    """Each command ended in `EOFError: marshal data too short` until somebody found and removed the file."""
    env = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    env |= {"PYTHONPYCACHEPREFIX": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}

    def helped() -> tuple[int, str]:
        words = [sys.executable, "-m", "erclutch", "--help"]
        done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    assert helped() == (0, "")
    (torn,) = tmp_path.rglob(f"erclutch/cli/{module}.*.pyc")
    whole = torn.read_bytes()
    torn.write_bytes(whole[: len(whole) // 2] + end)
    code, said = helped()
    assert (code, len(said.splitlines())) == (2, 1)
    assert f"{torn}: Python's copy of a module is not whole" in said
    assert helped() == (0, "")
