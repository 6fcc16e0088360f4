"""Equations of laws as MathML, a term a formula, made from the functions that are fitted.

SymPy takes a second to make them. Those of the usual laws are kept in ``assets/equations.json``;
``python -m erclutch.report.equations`` makes that file again, and a test that they are what the code gives.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

from markupsafe import Markup

from erclutch.device import DeviceName
from erclutch.laws import LADDER, law_from_name

_FILE = "report/assets/equations.json"


@cache
def terms_of(specification: str, device: DeviceName) -> tuple[Markup, ...]:
    """Gain times column of each term of a law's effort for w > 0."""
    kept = _kept().get(device, {}).get(specification)
    return tuple(Markup(term) for term in (made_terms(specification, device) if kept is None else kept))


@cache
def _kept() -> Mapping[str, Mapping[str, list[str]]]:
    text = files("erclutch").joinpath(_FILE).read_text(encoding="utf-8")
    return cast("Mapping[str, Mapping[str, list[str]]]", json.loads(text))


def made_terms(specification: str, device: DeviceName) -> list[str]:
    """The same, made by SymPy now."""
    symbolic: Any = import_module("erclutch.laws.symbolic")
    printing: Any = import_module("sympy.printing.mathml")

    def written(gain: Any, column: Any) -> str:
        body = str(printing.mathml(column, printer="presentation"))
        fenced = f"<mo>(</mo>{body}<mo>)</mo>" if column.is_Add else body
        return str(printing.mathml(gain, printer="presentation")) + fenced

    return [written(gain, column) for gain, column in symbolic.short_terms(law_from_name(specification, device))]


def usual() -> dict[DeviceName, list[str]]:
    """Laws whose equations are kept: the default ones, and for the pair those in one direction too."""
    laws = [name for name in LADDER if not name.startswith("rbfm")]
    one_way = [f"{name}/forward" for name in laws if name not in ("on-off", "quadratic") and "/" not in name]
    return {"single": laws, "coaxial": [*laws, *one_way]}


def made_file() -> str:
    """The text of the file."""
    made = {device: {law: made_terms(law, device) for law in laws} for device, laws in usual().items()}
    return json.dumps(made, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    Path(str(files("erclutch").joinpath(_FILE))).write_text(made_file(), encoding="utf-8")
