"""``erclutch verify`` runs an export and compares it with the model that it was made from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

COMMAND = {
    "help": "Run an export on its test vectors and compare it with the model.",
    "panel": "The road of a log",
    "place": 10,
}


def verify(export: Path, /, *, json: Annotated[bool, Parameter(negative=())] = False) -> int:
    """Run an export on its test vectors with every compiler and emulator found here.

    The exit code is 0 if all of them give what the model gives, and 3 otherwise.

    Args:
        export: Folder that erclutch export wrote.
        json: Print as JSON.
    """
    from dataclasses import asdict

    from erclutch.cli import terminal
    from erclutch.export import verify_export

    checks = verify_export(export)
    passed = all(check.passed for check in checks)
    if json:
        shown = [{**asdict(check), "allowed": None, "passed": check.passed} for check in checks]
        terminal.say_json(shown)
        return 0 if passed else 3

    screen = terminal.console()
    columns = ["where", "vectors", "not to the bit", "ulp from NumPy", "notes"]
    table = terminal.table(f"{export}", columns, [], left=1)
    for check in checks:
        bits = "-" if check.other_bits is None else str(check.other_bits)
        verdict = check.note if check.passed else f"FAILED {check.note}"
        table.add_row(check.where, str(check.count), bits, f"{check.ulp:.2f}", verdict)
    screen.print(table)
    failing = [check.where for check in checks if not check.passed]
    if passed:
        screen.print(
            f"Passed in all {len(checks)} places: what they give is what the model gives.",
            style="bold",
        )
    else:
        screen.print(
            f"FAILED in {len(failing)} of {len(checks)} places: {', '.join(failing)}.",
            style="bold red",
        )
    screen.print(
        "ulp: units in the last place at the largest training effort; NumPy is predict, in float64.",
        markup=False,
    )
    return 0 if passed else 3
