r"""What Frama-C's Eva proves of the exported C, kind by kind of model, and of the interlock (see docs/proof.md).

    python studies/proof.py
    python studies/proof.py --only casson fnn-16 --precision float32

For each model the exported functions are called in a loop of unknown length, with any bits as inputs: numbers, NaN and
infinities. "alarms" counts what Eva cannot exclude: a read out of bounds or of memory that nobody has written, a shift
too far, an overflow of a signed number. "effort" and "field" say whether these are shown to be finite and within their
limits, "state" how many numbers of the state are shown to be finite after any number of steps. "assumed" counts the
assertions of the file that Eva takes for true; tests/export/test_proof.py proves them. Needs frama-c-base.
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from erclutch.arithmetic.precision import PrecisionName
from erclutch.export import ExportOptions, step_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.exported_models import MODELS
from tests.support.live_proof import (
    CONTROLLED,
    proved_controller,
    proved_interlock,
    proved_plausibility,
)
from tests.support.proof import ADAPTING, ANGLES, Proof, proved


def _row(name: str, kind: str, proof: Proof) -> str:
    """A row of the table."""

    def said(*names: str) -> str:
        found = [x for name in names for x in proof.shown.get(name, [])]
        return "-" if not found else ("shown" if all(found) else f"{sum(found)} of {len(found)}")

    effort, field = (
        said("step", "steady"),
        said("inverse", "inverse_now", "first", "second", "motor", "never_both"),
    )
    functions = f"{proof.functions} of {proof.of_functions}"
    cells = (
        name,
        kind,
        functions,
        proof.alarms,
        effort,
        field,
        said("state"),
        proof.assumed,
        f"{proof.seconds:.0f}",
    )
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        "--only", metavar="WORD", nargs="+", default=[""], help="models whose name has one of these"
    )
    parser.add_argument(
        "--precision", nargs="+", choices=["float32", "float64"], default=["float32", "float64"]
    )
    asked = parser.parse_args()
    precisions: list[PrecisionName] = asked.precision
    if shutil.which("frama-c") is None:
        parser.error("needs frama-c: apt-get install frama-c-base")
    print("| model | numbers | functions | alarms | effort | field | state | assumed | CPU s |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for label, model in MODELS.items():
        if not any(word in label for word in asked.only):
            continue
        variants: dict[str, dict[str, Any]] = {"": {}}
        if label in ANGLES:
            variants[", angles"] = {"inputs": "angles"}
        if label in ADAPTING:
            variants[", adapting"] = {"adapt": True}
        for (kind, options), precision in itertools.product(variants.items(), precisions):
            step = step_of(model, ExportOptions("m", precision, 1e-3, **options))
            with tempfile.TemporaryDirectory() as folder:
                print(_row(label, f"{precision}{kind}", proved(step, Path(folder))), flush=True)
    for label in CONTROLLED:
        step = step_of(MODELS[label], ExportOptions("m", "float32", 1e-3))
        with tempfile.TemporaryDirectory() as folder:
            print(
                _row(f"controller of {label}", "float32", proved_controller(step, Path(folder))),
                flush=True,
            )
    with tempfile.TemporaryDirectory() as folder:
        print(_row("interlock of the live loop", "float64", proved_interlock(Path(folder))))
    with tempfile.TemporaryDirectory() as folder:
        print(_row("sensors of the live loop", "float64", proved_plausibility(Path(folder))))


if __name__ == "__main__":
    main()
