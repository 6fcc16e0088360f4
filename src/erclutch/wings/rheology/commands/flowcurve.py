"""``erclutch flowcurve`` fits laws of shear stress to measured flow curves."""

from __future__ import annotations

from collections.abc import Sequence
from json import dumps
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli import terminal

if TYPE_CHECKING:
    from erclutch.wings.rheology.field_series import FieldSeries
    from erclutch.wings.rheology.flow_curve import FlowCurve, FlowFit

COMMAND = {
    "help": "Fit laws of shear stress to flow curves.",
    "panel": "More logs",
    "place": 5,
}


_Names = Annotated[tuple[str, ...], Parameter(consume_multiple=True, negative=())]


def flowcurve(
    files: Annotated[tuple[Path, ...], Parameter(name="FILE", negative=())],
    /,
    *,
    laws: _Names = (),
    shear_rate: str | None = None,
    stress: _Names = (),
    sheet: _Names = (),
    parameters: Annotated[bool, Parameter(negative=())] = False,
    figure: Path | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Fit laws of shear stress to flow curves (shear stress against shear rate) and say which law holds for which.

    Columns are recognised by name and unit; viscosities become stresses. Laws are ranked by what they miss at rates
    that were held out. A yield stress that the curve does not show is called not identified.

    Args:
        files: Any log format, workbooks with several sheets, exports of rheometers with several tests; or pairs of
            columns with a label over each pair.
        laws: Which laws to fit. Default: all laws that have a meaning at one field.
        shear_rate: The column of shear rates with its unit, such as "D [1/min]". Default: by name and unit.
        stress: Columns of shear stress or viscosity with their units, such as "tau [kPa]". Default: by name and unit.
            Of pairs of columns the unit alone, such as "[mPa*s]".
        sheet: Sheets or tests of the file, by name or number, or the rows that a column of words parts: "material=all"
            for a curve of each word. Default: all that hold a flow curve.
        parameters: Also print the chosen law's parameters with intervals.
        figure: Draw the curves of one file, and the yield stress against the field: a .pdf, .png or .svg, with the
            numbers beside it as CSV.
        json: Print everything as JSON.
    """
    from erclutch.errors import SettingError
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.rheology.field_series import series_of, with_fields
    from erclutch.wings.rheology.flow_curve import ranked
    from erclutch.wings.rheology.flow_curve_file import read_flow_curves
    from erclutch.wings.rheology.flow_picture import picture_of

    if figure is not None and len(files) > 1:
        raise SettingError(
            "a figure is of one file", where="--figure", remedy="Give the files one after another"
        )
    if figure is not None and files and figure.with_suffix(".csv").resolve() == files[0].resolve():
        problem = f"its numbers would be written over {files[0].name}"
        raise SettingError(problem, where="--figure", remedy="Choose another name for the figure")
    notes: list[str] = []
    curves: list[tuple[str, FlowCurve]] = []  # with the name of the file
    for path in files:
        file = read_flow_curves(path, shear_rate=shear_rate, stress=stress, sheet=sheet)
        notes += [f"{path.name}: {note}" for note in file.notes]
        curves += [(path.name, curve) for curve in file.curves]
    of_files: list[str] = []  # a note where the names of several files hold the fields
    names = [name for name, _ in curves]
    if _may_be_a_series(curves):
        with_field, of_files = with_fields([curve for _, curve in curves], [{} for _ in curves])
        curves = [*zip(names, with_field, strict=True)]
    fitted: list[tuple[str, FlowCurve, list[FlowFit]]] = []
    with terminal.progress("fitting flow curves") as bar:
        for done, (name, curve) in enumerate(curves, start=1):
            fitted.append((name, curve, ranked(curve, laws)))
            bar(done, len(curves), "fitting flow curves")

    drawn: list[Path] = []
    of_all = series_of([(curve, fits) for _, curve, fits in fitted]) if of_files else None
    every_series: list[tuple[str, FieldSeries]] = [] if of_all is None else [("", of_all)]
    for path in files:
        of_file = [(curve, fits) for name, curve, fits in fitted if name == path.name]
        series = series_of(of_file)
        if series is not None and of_all is None:
            every_series.append((path.name, series))
        if figure is not None:
            chosen_laws = [(curve, fits[0]) for curve, fits in of_file]
            drawn += save_plot(picture_of(chosen_laws, series), figure)

    if json:
        entries: list[dict[str, Any]] = [
            {
                "file": name,
                "curve": curve.label,
                "points": curve.rate.size,
                "stress_unit": curve.stress_unit,
                "field": curve.field if curve.field_unit else None,
                "field_unit": curve.field_unit or None,
                "fits": [fit.to_dict() for fit in fits],
            }
            for name, curve, fits in fitted
        ]
        print(dumps(entries, indent=1, allow_nan=False))
        return
    several = len(files) > 1
    terminal.tell(*notes, *of_files)
    _tell_curves(fitted, several)
    for name, series in every_series:
        _tell_series(series, name if several else "")
    if drawn:
        terminal.tell("written: " + ", ".join(map(str, drawn)))
    if parameters:
        for name, curve, (chosen, *_) in fitted:
            title = f"{name}, {curve.label}: {chosen.law}"
            terminal.tell(terminal.estimates(title, chosen.estimates))


def _may_be_a_series(curves: Sequence[tuple[str, FlowCurve]]) -> bool:
    """Whether names of files may hold the fields: a curve a file, all in one unit, and none with a field of its own."""
    names = [name for name, _ in curves]
    units = {curve.stress_unit for _, curve in curves}
    have_fields = any(curve.field_unit for _, curve in curves)
    return 1 < len(names) == len({*names}) and len(units) == 1 and not have_fields


def _tell_curves(fitted: Sequence[tuple[str, FlowCurve, list[FlowFit]]], several: bool) -> None:
    """The chosen law of each curve, and how often each law was chosen.

    Args:
        fitted: name of the file, curve, and its laws from the chosen one on.
        several: whether there are several files, so that a curve needs the name of its own.
    """
    from collections import Counter

    from erclutch.wings.rheology.flow_curve import yield_text

    def missed(fit: FlowFit) -> str:
        if isfinite(fit.validated):
            return f"{fit.law} {fit.validated:.4f}"
        return fit.law

    # Files whose viscosities have no unit may stand beside files in Pa.
    units = {curve.stress_unit for _, curve, _ in fitted}
    unit = units.pop() if len(units) == 1 else ""
    rows: list[list[str]] = []
    for name, curve, (chosen, *others) in fitted:
        row = [
            f"{name}: {curve.label}" if several else curve.label,
            str(curve.rate.size),
            missed(chosen),
            f"{yield_text(chosen)}{'' if unit else f' {curve.stress_unit}'}",
            missed(others[0]) if others else "",
        ]
        rows.append(row)
    title = "Chosen laws, with what each misses at rates held out (RMS of log10 of the stress)"
    yields = f"yield stress [{unit}]" if unit else "yield stress"
    columns = ["curve", "points", "chosen", yields, "next best"]
    terminal.tell(terminal.table(title, columns, rows, left=1))
    wins = Counter(fits[0].law for *_, fits in fitted)
    counts = [f"{law} {count} of {len(fitted)}" for law, count in wins.most_common()]
    terminal.tell("Chosen for: " + ", ".join(counts))


def _tell_series(series: FieldSeries, name: str) -> None:
    """The yield stress against the field, and how it grows."""
    from erclutch.wings.rheology.flow_curve import yield_text

    rows: list[list[str]] = []
    for curve, fit in series.curves:
        rows.append([f"{curve.field:.4g}", yield_text(fit), curve.label])
    title = f"Yield stress against field, by {series.law} for all curves"
    if name:
        title = f"{name}: {title[0].lower()}{title[1:]}"
    stress_unit = series.curves[0][0].stress_unit
    columns = [f"field [{series.unit}]", f"yield stress [{stress_unit}]", "curve"]
    terminal.tell(terminal.table(title, columns, rows, left=0))
    if series.growth is not None:
        growth = series.growth
        exponent = f"{growth.exponent:.3g} ({growth.low:.3g} - {growth.high:.3g})"
        terminal.tell(
            f"Yield stress = {growth.factor:.4g} {stress_unit} x (field in {series.unit})^n, with n = {exponent} "
            f"by {growth.fields} fields"
        )
