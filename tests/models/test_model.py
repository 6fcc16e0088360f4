from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError, RunError
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.laws import law_from_name
from erclutch.models.laws.law import Dimension, Gain
from erclutch.models.load import load_model
from erclutch.models.model import Range, margins
from erclutch.models.model_file import digest_of
from erclutch.models.parameter_units import (
    gain_in_user_units,
    in_user_units,
    known_unit,
    unit_of_gain,
    unit_text,
)
from erclutch.models.structure import Reference, Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.recording import POSITION, TEMPERATURE

UNITS = Units("N*m", "V", "rad/s")


def model_of(
    specification: str = "hem",
    device: DeviceName = "single",
    dynamics: str = "none",
    extra: bool = True,
) -> TorqueModel:
    """A model whose numbers do not end in a binary fraction."""
    structure = Structure(
        device, specification, law_from_name(specification, device), dynamics, extra, extra
    )
    shapes, gains = structure.shapes(1e-3), structure.gains()
    inside = {
        s.name: s.lower * (s.upper / s.lower) ** 0.4 if s.scale == "log" else 0.37 for s in shapes
    }
    for name, value in {"delay": 2.3e-3, "tau": 7e-3, "tau_rise": 4e-3, "tau_fall": 1.1e-2}.items():
        if name in inside:
            inside[name] = value
    return TorqueModel(
        structure,
        Reference(2000.0 / 3, 17.1, 1e-3),
        inside,
        {g.name: 0.1 + 0.07 * i for i, g in enumerate(gains)},
        UNITS,
        Range((0.0, 2000.0 / 3), (-30.1, 30.1), (-1.1, 1.1)),
        {"fitted": "by hand"},
    )


def rows_of(device: DeviceName = "single", rows: int = 300) -> Dataset:
    rng = np.random.default_rng(1)
    elements = tuple(
        Element(600 * np.repeat(rng.random(rows // 20), 20), 30 * rng.normal(size=rows))
        for _ in range(2 if device == "coaxial" else 1)
    )
    spans = (Span(0, 100, 1e-3), Span(100, rows, 1e-3))
    return Dataset(
        device, elements, np.zeros(rows), Clock(np.arange(float(rows)) * 1e-3, spans), UNITS
    )


CASES: list[tuple[str, DeviceName, str]] = [
    ("hem", "single", "none"),
    ("hem/square", "coaxial", "rise-fall"),
    ("rbfm-10", "coaxial", "none"),
    ("on-off", "single", "lag"),
    ("bingham/critical", "coaxial", "lag"),
    ("cho-choi-jhon", "single", "rise-fall"),
]


@pytest.mark.parametrize(("specification", "device", "dynamics"), CASES)
def test_a_saved_model_predicts_the_same_bits(
    tmp_path: Path, specification: str, device: DeviceName, dynamics: str
) -> None:
    model, data = model_of(specification, device, dynamics), rows_of(device)
    path = tmp_path / "model.json"
    path.write_text(json.dumps(model.to_dict(), indent=2), encoding="utf-8")
    back = load_model(path)
    assert isinstance(back, TorqueModel)
    assert back.to_dict() == model.to_dict()
    assert back.name == model.name
    expected = model.predict(data)
    assert np.isfinite(expected).all()
    assert np.array_equal(back.predict(data), expected)
    fields, slips = [e.field for e in data.elements], [e.slip for e in data.elements]
    assert np.array_equal(back.steady(fields, slips), model.steady(fields, slips))


def test_keys_in_another_order_are_the_same_model() -> None:
    model = model_of("cho-choi-jhon", dynamics="rise-fall")
    body = json.loads(json.dumps(model.to_dict(), sort_keys=True))
    back = model_from_dict(body)
    assert list(back.shape) == list(model.shape)
    assert list(back.gains) == list(model.gains)
    assert np.array_equal(back.predict(rows_of()), model.predict(rows_of()))


def _edit_gain(body: dict[str, Any]) -> None:
    body["gains"]["T_y"] += 1e-9


def _edit_unit(body: dict[str, Any]) -> None:
    body["units"]["effort"] = "mN*m"


def _edit_about(body: dict[str, Any]) -> None:
    body["about"]["fitted"] = "by nobody"


def _add_key(body: dict[str, Any]) -> None:
    body["remark"] = "harmless"


def _drop_digest(body: dict[str, Any]) -> None:
    del body["digest"]


def _drop_gain(body: dict[str, Any]) -> None:
    del body["gains"]["T_y"]


@pytest.mark.parametrize(
    "edit", [_edit_gain, _edit_unit, _edit_about, _add_key, _drop_digest, _drop_gain]
)
def test_an_edited_file_is_refused(edit: Callable[[dict[str, Any]], None]) -> None:
    body = copy.deepcopy(model_of().to_dict())
    edit(body)
    with pytest.raises(RunError, match="do not match their digest"):
        model_from_dict(body)


@pytest.mark.parametrize("edit", [{"schema": 2}, {"schema": None}])
def test_another_schema_is_refused(edit: dict[str, Any]) -> None:
    body = {**model_of().to_dict(), **edit}
    with pytest.raises(RunError, match="this version reads schema 1"):
        model_from_dict(
            {**body, "digest": digest_of({k: v for k, v in body.items() if k != "digest"})}
        )


def forged(edit: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """An unfitting body whose digest is right: as a faulty writer would make it."""
    body = copy.deepcopy(model_of().to_dict())
    del body["digest"]
    edit(body)
    return {**body, "digest": digest_of(body)}


def test_a_file_with_the_other_name_of_a_stage_has_the_canonical_one() -> None:
    body = model_of(dynamics="dahl/field").to_dict()
    body = {**body, "dynamics": "dahl-1/field"}
    back = model_from_dict(
        {**body, "digest": digest_of({k: v for k, v in body.items() if k != "digest"})}
    )
    assert back.name == "hem+dahl/field"
    assert back.to_dict()["dynamics"] == "dahl/field"


KEYS = (
    "device",
    "law",
    "dynamics",
    "friction",
    "offset",
    "units",
    "reference",
    "shape",
    "gains",
    "trained_on",
    "about",
)


@pytest.mark.parametrize("key", KEYS)
def test_a_missing_key_is_refused(key: str) -> None:
    with pytest.raises(RunError, match="unfit entry"):
        model_from_dict(forged(lambda body: body.pop(key)))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("device", "triple"),
        ("dynamics", "second-order"),
        ("shape", {}),
        ("shape", [1, 2]),
        ("gains", {"T_y": "much"}),
        ("units", None),
        ("reference", {"field": 1.0}),
        ("trained_on", {"field": [0.0], "slip": [0.0, 1.0], "effort": [0.0, 1.0]}),
        *(
            (
                "trained_on",
                {"field": [0.0, 1.0], "slip": [0.0, 1.0], "effort": [0.0, 1.0], "near": near},
            )
            for near in (
                3,
                [[0] * 15],
                [[0] * 16] * 2,
                [[1 << 16] + [0] * 15],
                [[-1] + [0] * 15],
                [[0.5] * 16],
            )
        ),
    ],
)
def test_an_unfitting_entry_is_refused(key: str, value: Any) -> None:
    with pytest.raises(RunError, match="unfit entry"):
        model_from_dict(forged(lambda body: body.update({key: value})))


@pytest.mark.parametrize("content", [b"", b"{", b"not json", b"\xff\xfe\x00", b"[1, 2]", b"3"])
def test_what_is_no_model_file(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "model.json"
    path.write_bytes(content)
    with pytest.raises(RunError) as caught:
        load_model(path)
    assert str(path) in str(caught.value)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    for path, message in ((tmp_path / "none.json", "no readable model"), (tmp_path, "read_run")):
        with pytest.raises(RunError, match=message):
            load_model(path)


def test_another_kind_is_refused() -> None:
    with pytest.raises(RunError, match="this is no model but 'something else'"):
        model_from_dict({**model_of().to_dict(), "kind": "something else"})


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_a_number_that_is_none(tmp_path: Path, number: str) -> None:
    path = tmp_path / "model.json"
    path.write_text(
        json.dumps(model_of().to_dict()).replace('"kappa": 0.37', f'"kappa": {number}'),
        encoding="utf-8",
    )
    with pytest.raises(RunError):
        load_model(path)


@pytest.mark.parametrize(
    "edit", [{"law": "from-the-future"}, {"law": "hem/cubic"}, {"about": None}]
)
def test_an_unfitting_entry_is_a_run_error(edit: dict[str, Any]) -> None:
    with pytest.raises(RunError):
        model_from_dict(forged(lambda body: body.update(edit)))


def test_a_lag_over_a_segment_of_a_single_row() -> None:
    time = np.array([0.0, 1.1e-3, 1.9e-3, 3.0e-3, 1.0])
    clock = Clock(time, (Span(0, 4, None), Span(4, 5, None)))
    field = np.array([0.0, 1.0, 1.0, 0.0, 0.5])
    effort = model_of("bingham", dynamics="lag").effort([Element(field, np.ones(5))], clock)
    assert np.isfinite(effort).all()


def test_data_in_other_units_or_of_another_device() -> None:
    model, data = model_of(), rows_of()
    model.predict(data)
    for other, problem in (
        (replace(data, units=Units("N*m", "kV", "rad/s")), "field in kV.*for the model"),
        (replace(data, units=Units("N", "V", "rad/s")), "effort in N,.*for the model"),
        (replace(data, units=Units("N*m", "V", "m/s")), "slip in m/s.*for the model"),
        (rows_of("coaxial"), "data of device"),
    ):
        with pytest.raises(ErclutchError, match=problem):
            model.predict(other)


@pytest.mark.parametrize(("specification", "device", "dynamics"), CASES)
def test_steady_is_the_effort_after_settling(
    specification: str, device: DeviceName, dynamics: str
) -> None:
    model = model_of(specification, device, dynamics)
    rng = np.random.default_rng(2)
    count = model.structure.elements
    for _ in range(5):
        before, after, slip = (
            rng.uniform(0, 650, count),
            rng.uniform(0, 650, count),
            rng.uniform(-30, 30, count),
        )
        rows = 400
        elements = [
            Element(np.where(np.arange(rows) < 50, before[i], after[i]), np.full(rows, slip[i]))
            for i in range(count)
        ]
        effort = model.effort(
            elements, Clock(np.arange(float(rows)) * 1e-3, (Span(0, rows, 1e-3),))
        )
        steady = model.steady(list(after), list(slip))
        assert steady.shape == (1,)
        assert effort[-1] == pytest.approx(steady[0], rel=1e-9)
        assert effort[0] == pytest.approx(model.steady(list(before), list(slip))[0], rel=1e-9)


def test_effort_is_gains_times_columns_plus_friction_and_offset() -> None:
    law = law_from_name("bingham/square")
    structure = Structure("coaxial", "bingham/square", law, friction=True, offset=True)
    assert [g.name for g in structure.gains()] == [
        "T_y_1",
        "eta_1",
        "T_f_1",
        "T_y_2",
        "eta_2",
        "T_f_2",
        "T_0",
    ]
    gains = dict(
        zip(
            [g.name for g in structure.gains()],
            [0.5, 0.1, 0.03, 0.6, 0.2, 0.05, -0.01],
            strict=True,
        )
    )
    anywhere = Range((0, 1), (0, 1), (0, 1))
    model = TorqueModel(
        structure, Reference(0.5, 10.0, 1e-3), {"w_s": 1e-3}, gains, UNITS, anywhere
    )
    # CH1 half on and slipping forward, CH2 off and slipping backward.
    got = model.steady([np.array(0.25), np.array(0.0)], [np.array(20.0), np.array(-5.0)])
    expected = 0.5 * 0.25 + 0.1 * 2 + 0.03 - 0.2 * 0.5 - 0.05 - 0.01
    np.testing.assert_allclose(got, expected, rtol=1e-12)


def test_names_units_and_conversions() -> None:
    assert model_of("hem", dynamics="rise-fall").name == "hem+rise-fall"
    assert model_of().name == "hem"
    structure = model_of(dynamics="lag").structure
    dimensions = {p.name: p.dimension for p in (*structure.shapes(1e-3), *structure.gains())}
    reference = Reference(4.0, 10.0, 1e-3)
    assert in_user_units(1.0, dimensions["beta"], reference) == 0.25
    assert in_user_units(1.0, dimensions["w_s"], reference) == 10.0
    assert in_user_units(1.0, dimensions["eta_0"], reference) == 0.1
    assert in_user_units(1.0, dimensions["T_y"], reference) == 1.0
    assert in_user_units(3e-3, dimensions["tau"], reference) == 3e-3
    assert unit_text(dimensions["eta_0"], Units("N", "", "m/s")) == "N/(m/s)"
    assert unit_text(dimensions["beta"], Units("N", "V", "m/s")) == "1/V"
    assert unit_text(dimensions["beta"], Units("N", "", "m/s")) == "1"
    assert unit_text(dimensions["tau"], UNITS) == "s"
    assert unit_text(Dimension(effort=1, slip=-2), Units("N*m", "A", "rad/s")) == "N*m/(rad/s)^2"
    assert unit_text(Dimension(effort=1, field=-2), Units("N", "A", "m/s")) == "N/A^2"
    assert unit_text(Dimension(slip=2), Units("N", "A", "m/s")) == "(m/s)^2"


def test_a_gain_of_a_further_input_is_an_effort_per_unit_of_that_input() -> None:
    reference = Reference(field=1.0, slip=1.0, period=1e-3, extras=(4.0, 5.0))
    units = {"load": "?", POSITION: "m", "acceleration": "mm/s^2"}
    gains = [
        Gain("c", "effort per input", Dimension(effort=1), extra=place) for place in (None, 0, 1, 2)
    ]
    assert [gain_in_user_units(20.0, gain, reference) for gain in gains[:3]] == [20.0, 5.0, 4.0]
    of_gains = [unit_of_gain(gain, Units("N", "A", "m/s"), units) for gain in gains]
    assert of_gains == ["N", "N/?", "N/m", "N/(mm/s^2)"]


def test_the_unit_of_a_further_input_is_that_of_its_logs_or_what_its_name_tells() -> None:
    assert known_unit("load", UNITS, "kg") == "kg"
    assert known_unit("load", UNITS) == "?"
    assert known_unit(TEMPERATURE, UNITS) == "K"
    assert known_unit(POSITION, Units("N", "A", "m/s")) == "m"
    assert known_unit(POSITION, Units("N", "A", "?")) == "?"


def with_an_input(unit: str) -> TorqueModel:
    """A model with a load as a further input, in this unit."""
    plain = model_of("bingham", extra=False)
    structure = replace(plain.structure, extras=("load",))
    return replace(
        plain,
        structure=structure,
        reference=replace(plain.reference, extras=(2.5,)),
        gains={**plain.gains, "c_1": 0.5},
        extra_ranges=((-1.0, 1.0),),
        units_as_logged=(unit,),
    )


def test_the_equation_has_the_terms_of_further_inputs() -> None:
    """The sum in the headers of C and MATLAB was another one than that of the step below."""
    assert "An effort c_1 load / 2.5 is added." in with_an_input("kg").equation()


def test_the_equation_of_a_law_in_one_direction_has_no_transition_slip() -> None:
    both_ways = model_of("bingham").equation()
    one_way = model_of("bingham/critical/forward").equation()
    assert "A friction effort T_f tanh(w / w_s) is added for each element." in both_ways
    assert "A friction effort T_f is added for each element." in one_way


def test_the_unit_of_a_further_input_is_saved_with_the_model() -> None:
    model = with_an_input("kg")
    back = model_from_dict(json.loads(json.dumps(model.to_dict())))
    assert back.extra_units == {"load": "kg"}
    assert dict((name, unit) for name, _, unit, _ in back.in_units())["c_1"] == "N*m/kg"
    assert "unit" not in with_an_input("?").to_dict()["extras"][0]


def test_rows_with_a_further_input_in_another_unit_are_refused() -> None:
    """Grams for kilograms gave a thousand times the effort of that input, in silence."""
    model = with_an_input("kg")
    rows = rows_of()
    load = np.ones(rows.rows)
    model.predict(replace(rows, extras={"load": load}, extra_units={"load": "kg"}))
    model.predict(replace(rows, extras={"load": load}))  # nobody said in which unit
    with pytest.raises(ErclutchError, match="further input load is in g, for a model of it in kg"):
        model.predict(replace(rows, extras={"load": load}, extra_units={"load": "g"}))


def test_a_margin_is_one_percent_of_the_width_or_of_a_single_value() -> None:
    assert margins((0.0, 10.0)) == pytest.approx((-0.1, 10.1), rel=1e-12)
    assert margins((5.0, 5.0)) == pytest.approx((4.95, 5.05), rel=1e-12)
    assert margins((-5.0, -5.0)) == pytest.approx((-5.05, -4.95), rel=1e-12)
