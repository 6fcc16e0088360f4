"""``erclutch laws``: the table of laws."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter


def laws(*, json: Annotated[bool, Parameter(negative=())] = False) -> None:
    """List the laws: name, equation (made from the code that is fitted, for w > 0), parameters, source.

    E is the field over the largest one of the training data, w the slip over its root mean square.

    Args:
        json: Print as JSON.
    """
    from erclutch.laws import LADDER, law_from_name
    from erclutch.laws.symbolic import equation_text

    names = [name for name in LADDER if not name.startswith("rbfm")] + ["rbfm-2"]
    found = [(name, law_from_name(name)) for name in names]
    if json:
        from json import dumps

        rows = [
            {
                "name": name,
                "equation": equation_text(law),
                "source": law.source,
                "parameters": [
                    {"name": s.name, "meaning": s.meaning, "lower": s.lower, "upper": s.upper}
                    for s in (*law.stimulus_shape, *law.shape)
                ]
                + [{"name": g.name, "meaning": g.meaning, "lower": 0.0 if g.nonnegative else None} for g in law.gains],
            }
            for name, law in found
        ]
        print(dumps(rows, indent=1))
        return
    from erclutch.cli import show

    screen = show.console()
    table = show.table("Laws of one element (effort for w > 0)", ["model", "effort", "source"], [], left=3)
    table.columns[1].overflow = "fold"
    for name, law in found:
        label = "rbfm-N (N = 2 kernels shown)" if name == "rbfm-2" else name
        table.add_row(label, equation_text(law), law.source)
    screen.print(table)
    screen.print(
        "NAME/square, NAME/power or NAME/critical chooses how the yield effort grows with the field.", markup=False
    )
    screen.print("Any of them with a lag: --lag lag (delay and time constant) or --lag rise-fall (two).", markup=False)
