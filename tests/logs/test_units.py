from __future__ import annotations

import math
import subprocess
import sys
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import UnitError
from erclutch.logs.readers.rows_of_units import are_units
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

CASES = [
    ("cm/s", "slip", 0.01, "m/s"),
    ("rpm", "slip", 2 * math.pi / 60, "rad/s"),
    ("U/min", "slip", 2 * math.pi / 60, "rad/s"),
    ("rev/min", "theta_dot", 2 * math.pi / 60, "rad/s"),
    ("deg/s", "slip", math.pi / 180, "rad/s"),
    ("°/s", "theta_dot", math.pi / 180, "rad/s"),
    ("1/s", "slip", 1.0, "1/s"),
    ("s^-1", "slip", 1.0, "1/s"),
    ("1/s", "theta_dot", 1.0, "rad/s"),
    ("rad/s", "slip", 1.0, "rad/s"),
    ("m/s", "slip", 1.0, "m/s"),
    ("deg", "theta", math.pi / 180, "rad"),
    ("°", "position", math.pi / 180, "rad"),
    ("rev", "position", 2 * math.pi, "rad"),
    ("revs", "theta", 2 * math.pi, "rad"),
    ("-", "theta", 1.0, "rad"),
    ("in", "position", 0.0254, "m"),
    ("um", "position", 1e-6, "m"),
    ("µm", "position", 1e-6, "m"),
    ("μm", "alpha_raw", 1e-6, "m"),
    ("kN", "effort", 1000.0, "N"),
    ("980.665 N", "effort", 980.665, "N"),
    ("Nm", "effort", 1.0, "N*m"),
    ("N m", "T", 1.0, "N*m"),
    ("N·m", "T", 1.0, "N*m"),
    ("N-m", "T", 1.0, "N*m"),
    ("mNm", "T", 1e-3, "N*m"),
    ("mN*m", "T", 1e-3, "N*m"),
    ("Ncm", "T", 1e-2, "N*m"),
    ("kgf", "effort", 9.80665, "N"),
    ("kPa", "effort", 1000.0, "Pa"),
    ("kV", "field", 1000.0, "V"),
    ("kV/mm", "field", 1e6, "V/m"),
    ("mA", "field", 1e-3, "A"),
    ("mT", "field", 1e-3, "T"),
    ("G", "field", 1e-4, "T"),
    ("Oe", "field", 79.57747154594767, "A/m"),
    ("%", "field", 0.01, ""),
    ("1", "field", 1.0, ""),
    ("-", "field", 1.0, ""),
]


@pytest.mark.parametrize(("unit", "signal", "factor", "si"), CASES)
def test_a_unit_becomes_the_first_fitting_si_unit(
    unit: str, signal: str, factor: float, si: str
) -> None:
    assert units.conversion(unit, SIGNALS[signal], "V") == (pytest.approx(factor, rel=1e-14), si)


@pytest.mark.parametrize(
    ("unit", "signal"),
    [
        ("m/s", "theta_dot"),
        ("rad", "alpha_raw"),
        ("deg", "field"),
        ("%", "theta"),
        ("degC", "field"),
        ("dB", "field"),
        ("count", "field"),
        ("bit", "field"),
        ("s", "slip"),
        ("N", "T"),
        ("3", "field"),
        ("furlongs per week or so", "slip"),
    ],
)
def test_a_unit_that_does_not_fit_is_named_with_what_does(unit: str, signal: str) -> None:
    with pytest.raises(UnitError) as caught:
        units.conversion(unit, SIGNALS[signal], "col")
    message = str(caught.value)
    assert "column 'col'" in message
    assert f"'{unit}'" in message
    assert f"--{signal}" in message
    assert (SIGNALS[signal].si_units[0] or "dimensionless") in message


@pytest.mark.parametrize("unit", ["Hz", "1/min", "min^-1"])
def test_turns_or_plain_is_not_guessed(unit: str) -> None:
    with pytest.raises(UnitError, match="may mean turns"):
        units.conversion(unit, SIGNALS["slip"], "n")


@pytest.mark.parametrize(
    "text", ["9**9**9**9", "2^99", "1e400 N", "__import__('os')", "(" * 50, "m" * 100, "N**(9**9)"]
)
def test_arithmetic_is_no_unit(text: str) -> None:
    assert not units.is_unit(text)


@pytest.mark.slow
@given(st.text(max_size=30) | st.text("mNsradVA/*^-.() 0123456789%µ°kg", max_size=20))
def test_any_text_is_a_unit_or_a_unit_error(text: str) -> None:
    with suppress(UnitError):
        assert 0 < units.parse(text).factor < math.inf


def test_a_quantity_is_split() -> None:
    assert units.quantity("0.5 A") == (0.5, "A")
    assert units.quantity("-1e-3") == (-1e-3, None)
    with pytest.raises(UnitError, match="not a number"):
        units.quantity("half an ampere")


@pytest.mark.slow
def test_heavy_modules_wait_until_they_are_needed() -> None:
    heavy = {"pint", "pandas", "scipy", "h5py", "pyarrow"}
    code = f"import sys, erclutch.logs; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_common_units_are_what_pint_says() -> None:
    for text, (factor, dimension) in units.COMMON.items():
        spelled = text
        for pattern, replacement in units.SPELLINGS:
            spelled = pattern.sub(replacement, spelled)
        assert units.evaluated(text, spelled) == units.Unit(text, factor, dimension)


def test_a_log_in_si_units_or_turns_a_minute_does_not_wait_for_pint() -> None:
    wanted: set[str] = set()
    for kind in SIGNALS.values():
        # What a column is held against, too: each log would wait for a unit that is not among them.
        wanted |= {*kind.si_units, *kind.if_named} - units._NO_DIMENSION
    turning = {"turn/min", "rev/min", "r/min", "U/min", "1/min", "Hz", "°", "m/s^2", "µs", "min"}
    assert wanted | turning <= units.COMMON.keys() | {"%"}


def test_temperatures_and_lines_of_names_do_not_wait_for_pint(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def asked(text: str, spelled: str) -> None:
        raise AssertionError(f"pint is asked for {text}")

    monkeypatch.setattr(units, "evaluated", asked)
    for text in ("K", "kelvin", "Kelvin", "°C"):
        assert not units.is_unit(text)
    assert not are_units(["time", "E1", "E2", "theta_dot", "T"])
    assert are_units(["s", "kV", "rad/s", "N*m"])


@pytest.mark.parametrize(
    ("written", "means"),
    [("VDC", "V"), ("mVac", "mV"), ("kVrms", "kV"), ("A DC", "A"), ("mArms", "mA")],
)
def test_what_kind_of_voltage_or_current_it_is_changes_no_unit(written: str, means: str) -> None:
    assert units.parse(written).factor == units.parse(means).factor
    assert units.parse(written).dimension == units.parse(means).dimension


def test_an_adc_may_be_a_converter() -> None:
    assert not units.is_unit("ADC")


@pytest.mark.parametrize("unit", ["seg", "Seg.", "Segs", "Segundos", "Sek.", "Sekunden"])
def test_seconds_are_written_with_a_small_letter_or_a_large_one(unit: str) -> None:
    assert units.parse(unit).factor == 1.0
    assert units.in_unit(f"3 {unit}", "s") == 3.0


@pytest.mark.parametrize(
    "unit",
    [
        *("dev/dak", "d/dak", "devir / dakika", "об/мин", "обор/мин", "tr/mn", "t/min", "tr.min-1"),
        *("tours/min", "vueltas/min", "ford/perc", "f/perc", "στρ/λεπτό", "vòng/phút", "รอบ/นาที"),
        *("회전/분", "r.p.m.", "upm", "Umdr./min", "kierr/min", "ot./min", "REV/MIN", "R/MIN"),
    ],
)
def test_turns_a_minute_in_many_languages(unit: str) -> None:
    assert units.conversion(unit, SIGNALS["slip"], "n") == (
        pytest.approx(2.0 * math.pi / 60.0, rel=1e-14),
        "rad/s",
    )


@pytest.mark.parametrize(
    ("unit", "means"),
    [
        ("Grad", "deg"),  # German; a G before rad is a thousand million radians to pint
        ("Grad/s", "deg/s"),
        ("grados/s", "deg/s"),
        ("Nmeter", "N*m"),  # in small letters a nanometre
        ("ms-1", "m/s"),  # with a blank too few: nothing moves once a millisecond
        ("mms^-1", "mm/s"),
        ("rads-1", "rad/s"),
        ("Min", "min"),  # a million inches
        ("mseg", "ms"),
        ("кгс·м", "kgf*m"),
    ],
)
def test_a_unit_is_read_as_a_bench_means_it(unit: str, means: str) -> None:
    assert units.parse(unit).factor == pytest.approx(units.parse(means).factor, rel=1e-14)
    assert units.parse(unit).dimension == units.parse(means).dimension


@pytest.mark.parametrize(
    ("unit", "factor", "si"),
    [("kG", 0.1, "T"), ("mG", 1e-7, "T"), ("kOe", 79577.47154594767, "A/m")],
)
def test_a_field_in_old_units_may_have_a_prefix(unit: str, factor: float, si: str) -> None:
    """Without this a prefix was a constant of nature."""
    assert units.conversion(unit, SIGNALS["field"], "B") == (pytest.approx(factor), si)


@pytest.mark.parametrize("unit", ["Mm", "Ms", "Mrad", "Mm/s", "a"])
def test_no_bench_moves_by_megametres(unit: str) -> None:
    """``Mm`` is a slip of the shift key, for mm or for m: nobody knows which."""
    assert not units.is_unit(unit)


@pytest.mark.parametrize("unit", ["grad", "grad/s", "Grade"])
def test_a_degree_or_a_gon_is_not_guessed(unit: str) -> None:
    with pytest.raises(UnitError, match="degrees or in gons"):
        units.parse(unit)
