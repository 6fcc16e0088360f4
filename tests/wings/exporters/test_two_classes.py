"""Two exports in one program of C++: each class has its own numbers."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import EXACT
from erclutch.models.model import Model
from erclutch.wings.exporters.targets import cpp


@pytest.mark.slow
def test_two_classes_in_one_program_have_their_own_numbers(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("g++")
    words = ["gcc", *EXACT, "-O1", "-c"]
    objects: list[str] = []
    included: list[str] = []
    asked: list[str] = []
    for name, label in (("one", "casson+lag, single"), ("two", "fnn-3+rise-fall, single")):
        home = tmp_path / name
        home.mkdir()
        cpp.write(step_of(models[label], ExportOptions(name, "float64", 1e-3)), home)
        objects.append(str(home / "core.o"))
        folders = [f"-I{home / 'include'}", f"-I{home / 'include' / name}"]
        subprocess.run(
            [*words, str(home / "src" / f"{name}.c"), *folders, "-o", objects[-1]], check=True
        )
        included.append(f'#include "{name}/{name}.hpp"')
        device = f"{name}_model::{name.capitalize()} device; {name}_model::Input in; in.field = 700; in.slip = 0.5;"
        asked.append(f'{{ {device} std::printf("%a\\n", (double)device.step(in).effort); }}')

    def printed(places: list[int]) -> str:
        lines = "\n".join(asked[k] for k in places)
        main = tmp_path / "main.cpp"
        main.write_text(
            "\n".join(["#include <cstdio>", *included, "int main() {", lines, "}"]) + "\n"
        )
        folders = [f"-I{tmp_path / name / 'include'}" for name in ("one", "two")]
        program = tmp_path / "main"
        subprocess.run(
            ["g++", "-std=c++11", "-Wall", "-Werror", str(main), *objects, *folders, "-o", program],
            check=True,
        )
        return subprocess.check_output([program], text=True)

    first, second = printed([0]), printed([1])
    assert printed([0, 1]) == first + second
    assert first != second
