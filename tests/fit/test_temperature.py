"""The temperature of the fluid is read, fitted, chosen by the data, and kept with the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.dual import partial_of, seed
from erclutch.errors import ErclutchError, SettingError, UnitError
from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.logs import read
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.laws import law_from_name
from erclutch.models.model_file import digest_of
from erclutch.models.parameter_units import in_user_units
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import TEMPERATURE
from erclutch.signals.units import to_kelvin

ROWS, RATE, FALL = 4000, 1800.0, 0.004
TRUTH = {
    "w_s": 0.05,
    "n": 1.6,
    "T_y": 900.0,
    "eta": 300.0,
    "T_f": 40.0,
    "T_0": 15.0,
    "B_eta": RATE,
    "b_y": FALL,
}


def log(
    stages: str = "arrhenius+softening",
    law: str = "bingham",
    noise: float = 5.0,
    device: Any = "single",
) -> Dataset:
    """A made-up device that warms up by 45 K; without stages its effort does not feel it."""
    rng, t = np.random.default_rng(3), np.arange(float(ROWS)) * 1e-3
    warm = 293.0 + 45.0 * (1.0 - np.exp(-t)) + 2.0 * np.sin(9.0 * t)
    field = np.repeat(rng.choice([0.0, 0.5, 1.0, 1.5, 2.0], ROWS // 40), 40)
    slip = 0.3 * np.sin(14.5 * t) + 0.1 * np.sin(32.0 * t + 1.0)
    clock, units = Clock(t, (Span(0, ROWS, 1e-3),)), Units("N", "A", "m/s")
    elements = (
        (Element(field, slip),)
        if device == "single"
        else (Element(field, slip), Element(field[::-1], -slip))
    )
    data = Dataset(device, elements, np.zeros(ROWS), clock, units, extras={TEMPERATURE: warm})
    structure = Structure(
        device, law, law_from_name(law, device), stages, friction=True, offset=True
    )
    reference, known = reference_of(data, structure.extras), {**TRUTH, "r": 0.4}
    shape = {
        s.name: known[s.name] / in_user_units(1.0, s.dimension, reference)
        for s in structure.shapes(1e-3)
    }
    gains = {g.name: known[g.name.removesuffix("_1").removesuffix("_2")] for g in structure.gains()}
    nowhere: Any = None
    model = TorqueModel(
        structure, reference, shape, gains, units, nowhere, extra_ranges=((290.0, 340.0),)
    )
    model = replace(model, extra_ranges=model.extra_ranges[: len(structure.extras)])
    effort = model.effort(elements, clock, data.extras)
    return replace(data, effort=effort + noise * rng.standard_normal(ROWS))


def structure(stages: str, law: str = "bingham", device: Any = "single") -> Structure:
    return Structure(device, law, law_from_name(law, device), stages, friction=True, offset=True)


@pytest.mark.slow
def test_known_numbers_are_found_in_kelvin() -> None:
    found = {e.name: e for e in fit_structure(log(), structure("arrhenius+softening")).estimates}
    assert found["B_eta"].unit == "K"
    assert found["b_y"].unit == "1/K"
    for name, value in {"B_eta": RATE, "b_y": FALL, "n": 1.6, "T_f": 40.0, "T_0": 15.0}.items():
        assert found[name].low < value < found[name].high, name
        assert found[name].high - found[name].low < 0.2 * value, name


def test_by_hand() -> None:
    """The effort is the equation that the pages print, the friction of seals and the offset left alone."""
    data = log(noise=0.0)
    warm, element = data.extras[TEMPERATURE], data.elements[0]
    reference = reference_of(data, (TEMPERATURE,))
    scale, field = reference.temperature, element.field / reference.field
    way = np.tanh(element.slip / (0.05 * 1.0))
    viscosity = TRUTH["eta"] / reference.slip * np.exp(RATE * (1.0 / warm - 1.0 / scale))
    by_hand = (
        TRUTH["T_y"] * field**1.6 * (1.0 - FALL * (warm - scale)) * way + viscosity * element.slip
    )
    np.testing.assert_allclose(data.effort, by_hand + 40.0 * way + 15.0, rtol=1e-9)


def test_cassons_one_gain_keeps_both_efforts_apart() -> None:
    """sqrt of yield effort plus sqrt of viscous effort, each with its own factor."""
    data = log(law="casson", noise=0.0)
    warm, element = data.extras[TEMPERATURE], data.elements[0]
    reference = reference_of(data, (TEMPERATURE,))
    soft = 1.0 - FALL * (warm - reference.temperature)
    thin = np.exp(RATE * (1.0 / warm - 1.0 / reference.temperature))
    slip = np.abs(element.slip)
    roots = np.sqrt(900.0 * soft * (element.field / reference.field) ** 1.6) + np.sqrt(
        900.0 * 0.4 * thin * slip
    )
    way = np.tanh(element.slip / 0.05)
    np.testing.assert_allclose(data.effort, (roots**2 + 40.0) * way + 15.0, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("device", ["single", "coaxial"])
@pytest.mark.parametrize(
    "stages", ["arrhenius+softening+dahl", "softening/exponential+lugre/field+viscous"]
)
def test_derivatives_are_those_of_differences(stages: str, device: Any) -> None:
    data, made = log("none", device=device), structure(stages, "casson", device)
    reference = reference_of(data, made.extras)
    q = [
        0.3 * s.lower + 0.7 * s.upper if s.scale == "linear" else (s.lower * s.upper) ** 0.5
        for s in made.shapes(1e-3)
    ]
    names = [s.name for s in made.shapes(1e-3)]
    q[names.index("b_y")] = 1.3

    def columns(values: Any) -> list[Any]:
        return made.columns(
            data.elements, data.clock, reference, values, slice(0, 400), extras=data.extras
        )

    found = columns(seed(q))
    for k in (names.index("r"), len(q) - 1, names.index("b_y")):
        h = 1e-5 * q[k]
        ends = [columns([*q[:k], q[k] + s * h, *q[k + 1 :]]) for s in (1, -1)]
        for column, up, down in zip(found, *ends, strict=True):
            slope = (up - down) / (2 * h)
            np.testing.assert_allclose(
                partial_of(column, k) + 0.0 * slope,
                slope,
                atol=2e-5 * float(np.max(np.abs(slope))) + 1e-9,
            )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("feels", "taken"), [("arrhenius+softening", {"arrhenius", "softening"}), ("none", set())]
)
def test_the_ladder_takes_what_the_data_say(feels: str, taken: set[str]) -> None:
    data = log(feels)
    rungs = grown(data, structure("none"), (TEMPERATURE,))
    assert {
        name for name in rungs[-1].structure.dynamics.split("+") if "soft" in name or "arr" in name
    } == taken
    without = grown(replace(data, extras={}), structure("none"))
    assert not {"arrhenius", "softening"} & set(without[-1].structure.dynamics.split("+"))


def write(path: Path, unit: str, values: Array) -> Path:
    label = f"Oil [{unit}]" if unit else "Oil"
    n = values.size
    rows = np.column_stack(
        [np.arange(n) * 1e-3, np.arange(n) % 2, np.sin(np.arange(n)), np.cos(np.arange(n)), values]
    )
    lines = [",".join(map(str, row)) for row in rows.tolist()]
    path.write_text("\n".join([f"t [s],I [A],V [m/s],F [N],{label}", *lines]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("unit", "offset"), [("°C", 0.0), ("degC", 0.0), ("C", 0.0), ("K", 273.15)]
)
def test_a_column_is_read_in_kelvin(unit: str, offset: float, tmp_path: Path) -> None:
    celsius = np.linspace(20.0, 60.0, 200)
    file = write(tmp_path / "log.csv", unit, celsius + offset)
    found = read(file, {"field": "I", "slip": "V", "effort": "F", "temperature": "Oil"})
    np.testing.assert_allclose(found.extras[TEMPERATURE], celsius + 273.15, rtol=1e-12)
    assert "Oil" not in found.spare


@pytest.mark.parametrize(
    ("unit", "values", "message"),
    [
        ("", np.full(50, 20.0), "no unit, and a temperature needs °C, °F or K"),
        ("V", np.full(50, 2.0), "the unit 'V', and a temperature needs °C, °F or K"),
        ("°C", np.r_[np.full(49, 20.0), -999.0], "goes from -725.85 K to 293.15 K"),
        ("K", np.full(50, 20.0), "goes from 20 K to 20 K"),
    ],
)
def test_no_temperature_of_a_fluid_is_refused(
    unit: str, values: Array, message: str, tmp_path: Path
) -> None:
    file = write(tmp_path / "log.csv", unit, values)
    with pytest.raises(UnitError, match=message) as caught:
        read(file, {"field": "I", "slip": "V", "effort": "F", "temperature": "Oil"})
    assert "--temperature" in str(caught.value)


def test_gaps_stay_gaps() -> None:
    assert to_kelvin(np.array([20.0, np.nan]), "°C", "x") == (1.0, 273.15)


@pytest.mark.slow
def test_a_log_without_the_column_is_refused(model: TorqueModel) -> None:
    with pytest.raises(ErclutchError, match="--temperature"):
        model.predict(replace(log(), extras={}))


@pytest.mark.slow
def test_it_comes_back_from_its_file_and_says_its_equation(model: TorqueModel) -> None:
    data, again = log(), model_from_dict(model.to_dict())
    np.testing.assert_array_equal(again.predict(data), model.predict(data))
    text = "\n".join(model.equation())
    assert "viscous effort times exp(B_eta (1/t - 1))" in text
    assert f"t is temperature_K over {model.reference.temperature:.9g}." in text
    assert "c_1" not in text


@pytest.fixture(scope="module")
def model() -> TorqueModel:
    return fit_structure(log(), structure("arrhenius+softening"), intervals=False).model


@pytest.mark.slow
@pytest.mark.parametrize("reference", [1e-6, 20.0, 1e9])
def test_a_file_with_an_absurd_reference_is_refused(reference: float, model: TorqueModel) -> None:
    body = model.to_dict()
    body["extras"][0]["reference"] = reference
    body["digest"] = digest_of({key: value for key, value in body.items() if key != "digest"})
    with pytest.raises(ErclutchError, match="reference temperature") as caught:
        model_from_dict(body)
    assert str(caught.value).isprintable()


def test_a_law_that_keeps_no_efforts_apart_is_refused() -> None:
    law = law_from_name("bingham", "single")
    bare = replace(law, gains=tuple(replace(gain, part=None) for gain in law.gains))
    with pytest.raises(
        SettingError, match="does not say which of its gains are the viscous effort"
    ):
        Structure("single", "bare", bare, "arrhenius")


@pytest.mark.slow
def test_a_report_of_a_law_with_a_temperature(tmp_path: Path) -> None:
    from erclutch.cli import app

    data = log()
    names = ("time [s]", "field [A]", "slip [m/s]", "effort [N]", "oil [°C]")
    warm = data.extras[TEMPERATURE] - 273.15
    table = np.column_stack(
        [data.clock.time, data.elements[0].field, data.elements[0].slip, data.effort, warm]
    )
    path, run = tmp_path / "log.csv", tmp_path / "log.run"
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", encoding="utf-8")
    chosen = ["--models", "bingham", "--lag", "arrhenius", "--temperature", "oil [°C]"]
    app(["fit", str(path), *chosen, "--out", str(run)], exit_on_error=False)
    app(["report", str(run), "--out", str(tmp_path / "report.html")], exit_on_error=False)
    assert "Flow curves" in (tmp_path / "report.html").read_text("utf-8")
