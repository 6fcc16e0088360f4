"""Tools that the export tests need; `.ci/run` installs them."""

from __future__ import annotations

import shutil

import pytest


def need(*tools: str) -> None:
    """Skip where a program is missing, saying what to install."""
    packages = {
        "clang": "clang",
        "gcc": "gcc libc6-dev",
        "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
        "qemu-system-arm": "qemu-system-arm",
        "qemu-aarch64": "qemu-user",
        "qemu-ppc": "qemu-user",
        "aarch64-linux-gnu-gcc": "gcc-aarch64-linux-gnu libc6-dev-arm64-cross",
        "powerpc-linux-gnu-gcc": "gcc-powerpc-linux-gnu libc6-dev-powerpc-cross",
        "cppcheck": "cppcheck",
    }
    missing = [packages.get(tool, tool) for tool in tools if shutil.which(tool) is None]
    if missing:
        pytest.skip(f"apt install {' '.join(missing)}")
