"""A model as an Arduino library: the C files, what the Arduino IDE wants to know of a library, and a sketch.

The folder goes into the sketchbook's ``libraries``. The sketch reads the inputs from its serial line, so that the model
can be tried on a board with no bench.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from erclutch.errors import ExportError
from erclutch.export.c.compilers import natives, run
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, compare
from erclutch.export.targets import c

TITLE = "an Arduino library with a sketch"


def write(step: ExportedStep, folder: Path) -> None:
    """The library: ``library.properties``, the C files in ``src``, a sketch in ``examples``."""
    (folder / "src").mkdir()
    c.write_core(step, folder / "src")
    sketch = folder / "examples" / step.name
    sketch.mkdir(parents=True)
    (sketch / f"{step.name}.ino").write_text(_sketch(step), encoding="ascii", errors="replace")
    (folder / "library.properties").write_text(
        _properties(step), encoding="ascii", errors="replace"
    )


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The library's C files on the test vectors, by each compiler of this machine.

    Raises:
        ExportError: there is no compiler.
    """
    if not natives():
        raise ExportError(
            "no C compiler is found", where=str(folder), remedy="Install one, for example gcc"
        )
    vectors = vectors_of(step)
    with tempfile.TemporaryDirectory() as made:
        work = Path(made)
        (work / f"{step.name}_vectors.h").write_text(
            c.vectors_header(step, vectors), encoding="ascii"
        )
        main = work / "main.c"
        main.write_text(c.check_source(step), encoding="ascii")
        for compiler in natives():
            sources = [main, folder / "src" / f"{step.name}.c"]
            compiler.build(
                sources, work / "check", "-DPRINT", "-O2", f"-I{folder / 'src'}", f"-I{work}"
            )
            printed = run(
                [str(work / "check")], "the library does not run", "Export the model again"
            )
            yield compare(step, vectors, f"{compiler.name}, src", printed)


def _properties(step: ExportedStep) -> str:
    return f"""name={step.name}
version=0.1.0
author=erclutch
maintainer=erclutch
sentence=Torque model {step.model.name}.
paragraph=Model {step.digest}.
category=Device Control
url=https://example.com
architectures=*
includes={step.name}.h
"""


def _sketch(step: ExportedStep) -> str:
    n, period = step.name, 1000.0 * (step.period or 1e-3)
    inputs = ", ".join(
        f"{name} [{unit}]" for name, unit in zip(step.inputs, step.units, strict=True)
    )
    return f"""// {step.model.title}: send {inputs} as numbers on a line; the effort comes back.
// In your own sketch call {n}_step every {period:g} ms.
#include <{n}.h>

static {n}_state state;

void setup() {{
    Serial.begin(115200);
    {n}_reset(&state);
}}

void loop() {{
    if (Serial.available() == 0) {{
        return;
    }}
    {n}_real input[{n.upper()}_INPUTS], effort;
    for (unsigned i = 0; i < {n.upper()}_INPUTS; ++i) {{
        input[i] = ({n}_real)Serial.parseFloat();
    }}
    while (Serial.available() > 0 && Serial.read() != '\\n') {{
    }}
    const uint32_t flags = {n}_step(&state, input, &effort);
    Serial.print((double)effort, 6);
    Serial.println((flags & {n.upper()}_OUTSIDE_RANGE) != 0u ? " outside the training range" : "");
}}
"""
