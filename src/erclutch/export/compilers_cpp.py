"""C++ compilers of this machine."""

from __future__ import annotations

import importlib.util
import shutil
import sys
from functools import cache


@cache
def cpp_compilers() -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Name and command of each."""
    found: list[tuple[str, tuple[str, ...]]] = [(name, (name,)) for name in ("g++", "clang++") if shutil.which(name)]
    if not found and importlib.util.find_spec("ziglang") is not None:
        found.append(("zig", (sys.executable, "-m", "ziglang", "c++")))
    return tuple(found)
