"""Exports of rheometers in further forms; oscillations, holds and relaxations are named, and never flow curves."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import read_table
from erclutch.wings.rheology.flow_curve_file import FlowFile, read_flow_curves
from tests.support.examples import examples

RATES = np.array([0.1, 0.4642, 2.154, 10.0, 46.42, 215.4])
STRESSES = np.array([80.3, 81.1, 83.2, 88.4, 102.7, 139.5])
VISCOSITIES = STRESSES / RATES


def file_of(folder: Path, text: str, name: str = "export.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def holds_the_curve(file: FlowFile, count: int = 1) -> bool:
    return len(file.curves) == count and all(
        np.allclose(curve.rate, RATES, rtol=1e-5) and np.allclose(curve.stress, STRESSES, rtol=1e-5)
        for curve in file.curves
    )


def lines(*columns: np.ndarray, before: str = "", between: str = "\t") -> str:
    rows = zip(*columns, strict=True)
    return "".join(before + between.join(f"{value:.9g}" for value in row) + "\n" for row in rows)


# --- TRIOS ------------------------------------------------------------------------------------------------------------

TRIOS_HEAD = "Filename\tsample\nInstrument name\t5332-1\nOperator\tsomebody\n"
SWEPT = np.full(6, 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("version", [True, False])
def test_trios_is_told_by_its_head_and_an_oscillation_is_left_out(
    tmp_path: Path, version: bool
) -> None:
    text = TRIOS_HEAD + ("Trios version\t5.1\n" if version else "") + "Remark\tlong\n" * 200
    text += "[step]\nFrequency sweep - 1\nAngular frequency\tStress\tShear rate\tViscosity\tStorage modulus\n"
    text += "rad/s\tMPa\t1/s\tPa.s\tMPa\n" + lines(RATES, SWEPT, RATES, SWEPT, SWEPT)
    text += "[step]\nFlow ramp - 2\nStress\tShear rate\tViscosity\tStorage modulus\nMPa\t1/s\tPa.s\tMPa\n"
    text += "".join(
        f"{s * 1e-6:.9g}\t{r:.9g}\t{v:.9g}\t\n"
        for s, r, v in zip(STRESSES, RATES, VISCOSITIES, strict=True)
    )
    file = read_flow_curves(file_of(tmp_path, text, "trios.txt"))
    assert holds_the_curve(file)
    left = next(note for note in file.notes if note.startswith("Frequency sweep - 1"))
    assert "the test is an oscillation (Storage modulus), which has no flow curve" in left
    with pytest.raises(ErclutchError, match="is an oscillation"):
        read_flow_curves(tmp_path / "trios.txt", sheet=["1"])


@pytest.mark.parametrize("between", ["\t", ","])
def test_trios_writes_data_points_under_variables(tmp_path: Path, between: str) -> None:
    text = TRIOS_HEAD.replace("\t", between) + f"Number of points{between}6\n"
    text += between.join(("Variables", "Shear Rate", "Viscosity", "Shear Stress", "Step")) + "\n"
    text += between.join(("", "1/s", "Pa.s", "Pa")) + "\n"
    text += lines(
        RATES, VISCOSITIES, STRESSES, np.ones(6), before="Data point" + between, between=between
    )
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, text)))


def test_a_hold_at_one_rate_is_no_flow_curve(tmp_path: Path) -> None:
    text = (
        TRIOS_HEAD
        + "[step]\nPeak hold - 1\nStress\tShear rate\nPa\t1/s\n"
        + lines(STRESSES, 200 + RATES / 100)
    )
    text += "[step]\nFlow sweep - 2\nStress\tShear rate\nPa\t1/s\n" + lines(STRESSES, RATES)
    file = read_flow_curves(file_of(tmp_path, text, "trios.txt"))
    assert [curve.label for curve in file.curves] == ["Flow sweep - 2"]
    assert any(
        "Peak hold - 1: no flow curve (all points have the shear rate 200 to 202.2 1/s" in n
        for n in file.notes
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "test", ["Peak hold - 1", "Creep - 2", "Stress relaxation", "Stress growth - 1"]
)
def test_a_hold_is_no_flow_curve_though_its_rate_goes_astray(tmp_path: Path, test: str) -> None:
    table = "Stress\tShear rate\nPa\t1/s\n" + lines(
        STRESSES, 20 + np.sqrt(RATES)
    )  # the sample leaves the gap
    path = file_of(tmp_path, f"{TRIOS_HEAD}[step]\n{test}\n{table}")
    with pytest.raises(
        ErclutchError, match=f"is a {test.rstrip(' -12').lower()}, which holds .* --sheet"
    ):
        read_flow_curves(path)
    assert len(read_flow_curves(path, sheet=[test]).curves) == 1
    flow = "[step]\nFlow sweep - 1\nStress\tShear rate\nPa\t1/s\n" + lines(STRESSES, RATES)
    assert holds_the_curve(
        read_flow_curves(file_of(tmp_path, f"{path.read_text()}{flow}", "both.txt"))
    )


def test_a_column_that_repeats_the_stress_is_no_second_curve(tmp_path: Path) -> None:
    text = TRIOS_HEAD + "[step]\nFlow ramp - 1\nShear rate\tStress\tStress (step)\n1/s\tPa\tPa\n"
    file = read_flow_curves(file_of(tmp_path, text + lines(RATES, STRESSES, STRESSES), "trios.txt"))
    assert holds_the_curve(file)
    assert any("not used: Stress (step)" in note for note in file.notes)


def test_a_plain_table_below_a_head_of_trios_is_read_as_text(tmp_path: Path) -> None:
    text = TRIOS_HEAD + "\n\nShear rate\tStress\n1/s\tPa\n" + lines(RATES, STRESSES)
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, text)))


# --- RheoCompass ------------------------------------------------------------------------------------------------------


def compass(margin: str) -> str:
    text = "Project:\tfluids\nTest:\tFlow Curve\nInterval and data points:\t1\t6\n"
    text += "Interval data:\tShear Rate\tShear Stress\tViscosity\n\t[1/s]\t[Pa]\t[Pa·s]\n"
    return text + lines(RATES, STRESSES, VISCOSITIES, before=margin)


@pytest.mark.parametrize("margin", ["\t", ""])
def test_rows_of_rheocompass_with_and_without_their_first_cell(tmp_path: Path, margin: str) -> None:
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, compass(margin))))


def test_a_blank_line_below_the_units_ends_no_table(tmp_path: Path) -> None:
    text = compass("\t").replace("[Pa·s]\n", "[Pa·s]\n\n")
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, text)))


def test_a_row_with_a_cell_too_many_is_refused(tmp_path: Path) -> None:
    text = compass("\t").replace(f"{STRESSES[2]:.9g}\t", f"{STRESSES[2]:.9g}\t7\t")
    with pytest.raises(LogError, match=r"line 8 has 4 cells where 3 are expected"):
        read_flow_curves(file_of(tmp_path, text))


# --- RheoWin ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first", ["", "Nr-Seg"])
@pytest.mark.parametrize("link", ["in", "en", "/"])
def test_names_of_rheowin(tmp_path: Path, link: str, first: str) -> None:
    head = "C:\\job.rwd\nDate / Time / Version: - / - / HAAKE RheoWin 4.30\n\n"
    head += f"{first};GP {link} 1/s;Tau {link} Pa;t {link} s;\n"
    rows = [
        f"1|{i};{r:.9g};{s:.9g};{i},5;"
        for i, (r, s) in enumerate(zip(RATES, STRESSES, strict=True), 1)
    ]
    text = head + "\n".join(rows).replace(".", ",") + "\n"
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, text, "job.txt", "latin-1")))


def test_an_oscillation_of_rheowin_is_named(tmp_path: Path) -> None:
    text = "HAAKE RheoWin 4\n\n;t / s;f / Hz;G' / Pa;G'' / Pa;|Eta*| / Pas;\n"
    text += "".join(f"1|{i};{i},5;1,0;4,4;1,1;0,72;\n" for i in range(1, 6))
    with pytest.raises(ErclutchError, match=r"is an oscillation \(G', G'', \|Eta\*\|\)"):
        read_flow_curves(file_of(tmp_path, text, "job.txt"))


# --- rSpace -----------------------------------------------------------------------------------------------------------


def kinexus(between: str, decimal: str) -> str:
    names = [
        "Point Index",
        "Sample Description",
        "Action Name",
        "Time (action)(s)",
        "Shear rate(s-¹)",
    ]
    names += ["Shear stress(Pa)", "Shear viscosity(Pa s)", "Shear modulus (elastic component)(Pa)"]
    rows = [names]
    for i in range(6):
        rows.append([f"{i + 1}", "oil", "Oscillation amplitude table", f"{i}", "", "", "", "500.5"])
    for name in ("Shear rate ramp up", "Shear rate ramp down"):
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True)):
            rows.append(
                [f"{i + 1}", "oil", name, f"{i}.5", f"{x:.9g}", f"{y:.9g}", f"{y / x:.9g}", ""]
            )
    return (
        "\n".join(between.join(cell.replace(".", decimal) for cell in row) for row in rows) + "\n"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("between", "decimal", "encoding"),
    [(",", ".", "utf-8-sig"), (";", ",", "utf-8"), ("\t", ".", "utf-16")],
)
def test_an_export_of_rspace_has_an_action_a_recording(
    tmp_path: Path, between: str, decimal: str, encoding: str
) -> None:
    path = file_of(tmp_path, kinexus(between, decimal), encoding=encoding)
    file = read_flow_curves(path)
    assert holds_the_curve(file, count=2)
    assert [curve.label for curve in file.curves] == ["Shear rate ramp up", "Shear rate ramp down"]
    assert any(
        note.startswith("Oscillation amplitude table: no flow curve (the test is an oscil")
        for note in file.notes
    )
    assert holds_the_curve(read_flow_curves(path, sheet=["3"]))
    with pytest.raises(LogError, match="--variable"):
        read_table(path)


# --- tables of people -------------------------------------------------------------------------------------------------


def test_rows_in_oscillation_are_left_out_of_a_table(tmp_path: Path) -> None:
    text = "rate [1/s],stress [Pa],storage modulus [Pa]\n5,7,100\n6,8,110\n"
    text += "".join(f"{r:.9g},{s:.9g},\n" for r, s in zip(RATES, STRESSES, strict=True))
    file = read_flow_curves(file_of(tmp_path, text))
    assert holds_the_curve(file)
    assert any(
        "2 of 8 points left out: in oscillation (storage modulus)" in note for note in file.notes
    )


def test_samples_below_names_and_units_do_not_hide_them(tmp_path: Path) -> None:
    """Time and stress under a rate are no pairs of rate and stress."""
    times = "Time,Stress,Time,Stress\ns,Pa,s,Pa\n1.0 1/s,,2.5 1/s,\n0.07,2.9,0.07,6.0\n0.08,3.1,0.09,7.0\n"
    with pytest.raises(ErclutchError, match="no column is surely the shear rate"):
        read_flow_curves(file_of(tmp_path, times))
    pairs = "shear rate,stress,shear rate,stress\n1/s,kPa,1/s,kPa\nsweep up,,sweep down,\n"
    pairs += lines(RATES, STRESSES / 1000, RATES, STRESSES / 1000, between=",")
    assert holds_the_curve(read_flow_curves(file_of(tmp_path, pairs)), count=2)


def test_a_row_of_units_that_lacks_its_last_cell_is_not_moved(tmp_path: Path) -> None:
    table = read_table(file_of(tmp_path, "row,I,v,n\n,A,mm/s\n1,0.5,3,7\n2,0.6,4,8\n"))
    assert table.units["I"] == "A"
    assert table.units["v"] == "mm/s"


# --- damage -----------------------------------------------------------------------------------------------------------


def trios() -> str:
    """Two steps of TRIOS."""
    table = "Stress\tShear rate\tViscosity\nPa\t1/s\tPa.s\n" + lines(STRESSES, RATES, VISCOSITIES)
    return TRIOS_HEAD + f"[step]\nFlow sweep - 1\n{table}\n[step]\nFlow sweep - 2\n{table}"


def rheowin() -> str:
    """A segment of RheoWin with decimal commas."""
    points = (
        f"1|{i};{x:.9g};{y:.9g};{i},5;\n"
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True), 1)
    )
    return "HAAKE RheoWin 4\n\n;GP in 1/s;Tau in Pa;t in s;\n" + "".join(points).replace(".", ",")


EXPORTS = {
    "compass": compass("\t"),
    "bare": compass(""),
    "kinexus": kinexus(",", "."),
    "trios": trios(),
    "rheowin": rheowin(),
}


@pytest.mark.slow
@settings(max_examples=examples(25), deadline=None)
@example(kind="trios", place=160, damage=".")  # of two sweeps one has no number
@example(kind="trios", place=60, damage="\t")  # the mark of a step is in two halves
@example(kind="trios", place=63, damage="\t")  # the name of a step stands behind its mark
@example(kind="kinexus", place=43, damage=",")  # a name too many, which is empty
@example(kind="kinexus", place=44, damage=",")  # a name too many, of two halves
@given(
    kind=st.sampled_from(list(EXPORTS)),
    place=st.integers(0, 4000),
    damage=st.sampled_from(["", *"0123456789.,;\t -[]|x"]),
)
def test_a_changed_byte_never_moves_a_column(
    tmp_path_factory: pytest.TempPathFactory, kind: str, place: int, damage: str
) -> None:
    """A curve has its points, all but one number as they were; a point or a curve that is missing is told."""
    text = EXPORTS[kind]
    place %= len(text)
    path = tmp_path_factory.getbasetemp() / "changed.txt"
    whole = {"kinexus": 2, "trios": 2}.get(kind, 1)
    path.write_text(text[:place] + damage + text[place + 1 :], encoding="utf-8")
    try:
        file = read_flow_curves(path)
    except ErclutchError:
        return
    if len(file.curves) == whole and all(curve.rate.size == 6 for curve in file.curves):
        others = [
            int((c.rate != RATES).sum() + (np.abs(c.stress / STRESSES - 1) > 1e-8).sum())
            for c in file.curves
        ]
        assert sum(others) <= 1 or told(file)
    elif not told(file):
        # A damaged name of an action makes a test of its own; no point of it is lost or moved.
        pairs = np.array(
            [(x, y) for curve in file.curves for x, y in zip(curve.rate, curve.stress, strict=True)]
        )
        assert np.array_equal(np.sort(pairs[:, 0]), np.sort(np.tile(RATES, whole)))
        assert np.allclose(np.sort(pairs[:, 1]), np.sort(np.tile(STRESSES, whole)), rtol=1e-8)


def test_names_without_their_mark_are_not_moved_over_the_rows(tmp_path: Path) -> None:
    path = tmp_path / "bare.txt"
    path.write_text(EXPORTS["bare"].replace("Interval data:", "Interval data"), encoding="utf-8")
    with pytest.raises(ErclutchError, match="where a point has its number"):
        read_flow_curves(path)


def told(file: FlowFile) -> bool:
    """Whether a note says more than which columns were taken."""
    usual = re.compile(
        r"(shear rate|shear stress|viscosity): column '|not used: |recording read|is empty: left|Oscillation"
    )
    return any(not usual.search(note) for note in file.notes)


def test_an_interval_that_lost_its_mark_is_told(tmp_path: Path) -> None:
    text = compass("\t") + "\n" + compass("\t").replace("Interval data:", "Interval dta:")
    with pytest.raises(
        ErclutchError, match=r"2 intervals are announced, and 1 have a line|outside of any table"
    ):
        read_flow_curves(file_of(tmp_path, text))


def test_a_lost_delimiter_is_told(tmp_path: Path) -> None:
    text = trios().replace("88.4\t10\t", "88.410\t", 1)
    notes = read_flow_curves(file_of(tmp_path, text, "broken.txt")).notes
    assert any(
        note.startswith("Flow sweep - 1: no flow curve") and "has 2 cells where 3" in note
        for note in notes
    )
    with pytest.raises(ErclutchError, match="line"):
        read_flow_curves(file_of(tmp_path, rheowin().replace("1|3;2,154;", "1|32,154;"), "job.txt"))


def test_a_name_of_rheowin_that_fell_apart_moves_no_column(tmp_path: Path) -> None:
    path = tmp_path / "broken.txt"
    path.write_text(EXPORTS["rheowin"].replace("Tau in Pa", "T;u in Pa"), encoding="utf-8")
    with pytest.raises(LogError, match=r"line 4 has 3 values below 4 names"):
        read_flow_curves(path)
