"""`erclutch effort-table` prints the settled effort of a model over fields and slips, for a data sheet."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def effort_table(
    run: Path,
    *,
    field: Annotated[tuple[float, ...], Parameter(consume_multiple=True)] = (),
    rows: int = 5,
    model: str | None = None,
) -> None:
    """Print the settled effort of a model over fields and slips, as CSV.

    Args:
        run: Folder of a run of a single device.
        field: Fields, one column each. Default: the smallest and the largest of the training rows.
        rows: How many slips, from one end of the training rows to the other.
        model: Model of the run. Default: the recommended one.
    """
    import numpy as np

    from erclutch import read_run
    from erclutch.errors import SettingError

    if not 2 <= rows <= 1000:
        raise SettingError(f"--rows {rows}", remedy="Give 2 to 1000")
    kept = read_run(run).model(model)
    if kept.structure.device != "single" or kept.extras:
        problem = f"the model {kept.name} needs more than one field and one slip"
        raise SettingError(
            problem, where=str(run), remedy="Give a run of a single device without further inputs"
        )
    fields = field or kept.trained_on.field
    slips = np.linspace(*kept.trained_on.slip, rows)
    # One column a field, one row a slip, in the units of the run.
    efforts = [kept.steady([np.full(rows, each)], [slips]) for each in fields]
    units = kept.units
    print(
        f"slip [{units.slip}]",
        *(f"effort at {each:g} {units.field} [{units.effort}]" for each in fields),
        sep=",",
    )
    for slip, *row in zip(slips, *efforts, strict=True):
        print(f"{slip:.6g}", *(f"{effort:.6g}" for effort in row), sep=",")
