r"""What Frama-C's Eva proves of exported C (see docs/proof.md); `tests.support.live_proof` is for the live loop's.

The exported functions are called in a loop of unknown length, with any bits as inputs: numbers, NaN and infinities.
`studies/proof.py` prints the table, kind by kind of model. Needs frama-c-base.
"""

from __future__ import annotations

import csv
import os
import re
import resource
import subprocess
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from erclutch.export import ExportedStep
from erclutch.export.c.c_printer import rings_of
from erclutch.export.step_record import step_record
from erclutch.export.targets.c import write_core

#: Models that also go through Eva with positions as inputs, which are differentiated inside.
ANGLES = ("bingham, single", "hem+rise-fall, coaxial")
#: Models that also go through Eva with a gain and an offset that follow a torque sensor.
ADAPTING = ("bingham, single", "fnn-16, coaxial")

#: What Eva is told, the cheapest first, the next where a proof is not complete. A level is how many states it keeps
#: apart at each place of a function. Ranges of products and quotients that are subdivided take twice the time.
_SUBDIVIDED = ("-eva-subdivide-non-linear", "10")
_EFFORTS = (
    ("-eva-slevel", "12"),
    ("-eva-slevel", "12", *_SUBDIVIDED),
    ("-eva-slevel", "30", *_SUBDIVIDED),
)


@dataclass(frozen=True)
class Proof:
    """What Eva says of one file.

    Attributes:
        alarms: what it cannot exclude.
        functions, of_functions: how many it has analysed, and how many there are.
        statements: how many of these functions it has reached.
        assumed: assertions of the exported file that are proved elsewhere.
        shown: for each name of a check in the driver, whether each such check is proved.
        seconds: CPU time.
    """

    alarms: int
    functions: int
    of_functions: int
    statements: str
    assumed: int
    shown: Mapping[str, list[bool]]
    seconds: float


def proved(step: ExportedStep, folder: Path) -> Proof:
    """Run Eva on the exported files of a step.

    Raises:
        subprocess.CalledProcessError: Frama-C fails.
    """
    write_core(step, folder)
    (folder / "driver.c").write_text(driver(step), encoding="ascii")
    loops = ("-eva-auto-loop-unroll", str(longest_loop(step)))
    for effort in _EFFORTS:
        proof = analysed(folder, ["driver.c", f"{step.name}.c"], *effort, *loops)
        if proof.alarms == 0 and all(map(all, proof.shown.values())):
            break
    return proof


def any_real(kind: str) -> str:
    """C that makes a number of any bits."""
    return f"""static {kind} any_real(void)
{{
    union {{ uint64_t bits; {kind} real; }} both;
    both.bits = source;
    return both.real;
}}
"""


def analysed(folder: Path, files: list[str], *options: str) -> Proof:
    """Run Eva on C files of a folder, the driver first; in it each check is a line with a name."""
    words = ["frama-c", "-eva", *options]
    words += ["-warn-special-float", "none", *files, "-then", "-report-csv", "report.csv"]
    began = _cpu()
    # Frama-C looks for files where the shell's variable says that it is.
    run = subprocess.run(
        words,
        cwd=folder,
        env={**os.environ, "PWD": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )
    seconds = _cpu() - began
    alarms, coverage = (re.search(x, run.stdout) for x in (r"(\d+) alarms? generated", _COVERAGE))
    if run.returncode or alarms is None or coverage is None:
        raise RuntimeError(f"Frama-C fails on {folder}: {(run.stderr or run.stdout)[-800:]}")
    rows = csv.DictReader(
        (folder / "report.csv").read_text(encoding="utf-8").splitlines(), delimiter="\t"
    )
    asked = dict(enumerate((folder / files[0]).read_text(encoding="ascii").splitlines(), start=1))
    shown: dict[str, list[bool]] = {}
    assumed = Counter[str]()
    for row in rows:
        name = (
            re.search(r"/\*@ check (\w+):", asked.get(int(row["line"]), ""))
            if row["file"] == files[0]
            else None
        )
        if name:
            shown.setdefault(name[1], []).append(row["status"] == "Valid")
        elif row["property kind"] == "user assertion" and row["status"] != "Valid":
            assumed[row["property"]] += 1
    return Proof(
        int(alarms[1]),
        int(coverage[1]),
        int(coverage[2]),
        coverage[3],
        assumed.total(),
        shown,
        seconds,
    )


#: Functions analysed and in all, statements reached.
_COVERAGE = r"(\d+) functions analyzed \(out of (\d+)\)[^\n]*\n *In these functions, (\d+ statements reached[^:]*)"


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def driver(step: ExportedStep) -> str:
    """C that calls every function in a loop of unknown length, and says what is to be proved."""
    n, N, k = f"{step.name}_", f"{step.name}_".upper(), step.precision.constant
    least, most = (k(x) for x in (min(step.limits[0], 0.0), max(step.limits[1], 0.0)))
    s = step.search
    number = step.precision.dtype.type
    ends = [
        number(s.origin) + number(s.segments) * number((end - s.origin) / s.segments)
        for end in (s.minus, s.plus)
    ]
    first, last = (k(float(x)) for x in ends)
    switch = (
        f"        if (any()) {{ {n}use_residual(&state, any()); }}\n"
        if step.model.correction
        else ""
    )
    checks = "\n".join(
        f"        /*@ check state: \\is_finite(state.{place}); */" for place in places(step)
    )
    return f"""#include "{step.name}.h"
volatile uint64_t source;
static uint32_t any(void) {{ return (uint32_t)source; }}
{any_real(f"{n}real")}int main(void)
{{
    {n}state state;
    {n}real input[{N}INPUTS], wanted, found;
    uint32_t i;
    {n}reset(&state);
    while (any())
    {{
        for (i = 0u; i < {N}INPUTS; i++) {{ input[i] = any_real(); }}
        if (any()) {{ {n}reset(&state); }}
{switch}        {n}step(&state, input, &found);
        /*@ check step: \\is_finite(found) && {least} <= found <= {most}; */
{checks}
        for (i = 0u; i < {N}INPUTS; i++) {{ input[i] = any_real(); }}
        {n}steady(input, &found);
        /*@ check steady: \\is_finite(found) && {least} <= found <= {most}; */
        wanted = any_real();
        {n}inverse(input, wanted, &found);
        /*@ check inverse: \\is_finite(found) && {first} <= found <= {last}; */
        for (i = 0u; i < {N}INPUTS; i++) {{ input[i] = any_real(); }}
        {n}inverse_now(&state, input, wanted, &found);
        /*@ check inverse_now: \\is_finite(found) && {first} <= found <= {last}; */
    }}
    return 0;
}}
"""


def places(step: ExportedStep) -> Iterator[str]:
    """The real numbers of the state, as C."""
    record = step_record(step).record
    yield from (name for name, node in record.after.items() if node.kind == "real")
    for length, count in rings_of(record).items():
        yield from (f"ring{length}[{i}][{j}]" for i in range(length) for j in range(count))


def longest_loop(step: ExportedStep) -> int:
    """Turns of the longest loop over an array; the search of the inverse may have more."""
    network = step.network
    hidden = () if network is None else (*network.structure.hidden, len(network.structure.inputs))
    return max(8, len(step.inputs), *hidden, *rings_of(step_record(step).record))
