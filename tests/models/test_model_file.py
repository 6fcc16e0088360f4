"""What a saved model may hold, entry by entry, on both sides of each limit; and names of networks."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import CheckError, RunError, SettingError
from erclutch.models import model_file as mf
from erclutch.models.band import MOST_EDGES
from erclutch.models.laws import law_from_name
from erclutch.models.load import _READERS, load_model
from erclutch.models.model import CELLS
from erclutch.models.networks import base_inputs, is_network, network_from_name
from tests.support.exported_models import MODELS

BAND: dict[str, Any] = {
    "level": 0.95,
    "settling_s": 0.1,
    "threshold": 0.2,
    "field": [0.0, 1.0],
    "slip": [-2.0, 2.0],
    "field_edges": [0.5],
    "slip_edges": [],
    "behind": [1.0, 0.0, 2.0, 3.0],
    "ahead": [1.0, 2.0, 0.0, 3.0],
}
RANGE: dict[str, Any] = {"field": [0, 1], "slip": [-1, 1], "effort": [-2, 2]}
NEAR = [[0, (1 << CELLS) - 1, *[5] * (CELLS - 2)]]


@pytest.mark.parametrize(
    ("read", "good", "bad"),
    [
        (
            mf.number_of,
            [0, 1.5, -1e18, 1e18],
            [True, "1", None, 1.01e18, -1.01e18, float("nan"), float("inf"), 10**19],
        ),
        (lambda v, n: mf.number_of(v, n, positive=True), [1e-18, 1e18, 1], [0.0, 0.99e-18, -1.0]),
        (mf.whole_number_of, [0, -3, 7], [True, 1.0, "1", None]),
        (mf.truth_of, [True, False], [0, 1, "true", None]),
        (
            lambda v, n: mf.table_of(v, n, 2),
            [[1, 2]],
            [[1], [1, 2, 3], (1, 2), "ab", 3, [1, "b"], [[1], [2]]],
        ),
        (
            lambda v, n: mf.table_of(v, n, 1, 2, positive=True),
            [[[1, 2]]],
            [[1, 2], [[1, 0]], [[1, 2], [3, 4]]],
        ),
        (
            mf.pair_of,
            [[1, 2], [0.0, 0.0], [-0.0, 0.0], [2, 2]],
            [[2, 1], [0.0, -0.0], [1], [1, 2, 3]],
        ),
        (mf.name_of, ["a", "x" * 1000, "µ (1)"], ["", "x" * 1001, "a\nb", "\x00", 3, None]),
        (mf.names_of, [[], ["a", "b"], ("a",)], [["a", "a"], ["a", ""], 3]),
        (
            mf.specification_of,
            ["fnn-16", "a/b+c.d e", "x" * 200],
            ["", "x" * 201, "a*b", "é", "a\n", 3],
        ),
        (lambda v, n: mf.device_of({"device": v}), ["single", "coaxial"], ["triple", "", None]),
        (
            lambda v, n: mf.units_of(
                {"units": dict(zip(("effort", "field", "slip"), v, strict=True))}
            ),
            [["N*m", "V", "rad/s"], ["?", "", "?"]],
            [["N*m", "V", 3], ["N*m", "*/", "rad/s"], ["N", "V", None]],
        ),
        (
            lambda v, n: mf.range_of({"device": "single", "trained_on": v}),
            [RANGE, {**RANGE, "near": NEAR}],
            [
                {**RANGE, "near": NEAR * 2},
                {**RANGE, "near": [NEAR[0][:-1]]},
                {**RANGE, "near": [[1 << CELLS, *NEAR[0][1:]]]},
                {**RANGE, "near": [[-1, *NEAR[0][1:]]]},
                {**RANGE, "effort": [2, -2]},
                {"field": [0, 1]},
            ],
        ),
        (
            lambda v, n: mf.range_of({"device": "coaxial", "trained_on": {**RANGE, "near": v}}),
            [NEAR * 2],
            [NEAR, NEAR * 3],
        ),
        (
            lambda v, n: mf.band_of({**BAND, **v}),
            [{}, {"level": 0.999}, {"field_edges": [], "behind": [1.0, 1.0], "ahead": [0.0, 0.0]}],
            [
                {"level": 1.0},
                {"level": 0.0},
                {"settling_s": 0.0},
                {"behind": [1.0, -1e-9, 2.0, 3.0]},
                {"ahead": [1.0]},
                {"field_edges": [0.5, 0.5]},
                {"field_edges": [0.0]},
                {"slip_edges": (1.0,)},
                {"slip": [2.0, -2.0]},
            ],
        ),
        (
            lambda v, n: mf._edges_of(v, n),
            [[], [1.0, 2.0], [float(k + 1) for k in range(MOST_EDGES)]],
            [[2.0, 1.0], [1.0, 1.0], [float(k + 1) for k in range(MOST_EDGES + 1)], 3],
        ),
        (
            lambda v, n: mf.about_of({"about": v}),
            [{}, {"a": "b"}],
            [{"": "b"}, {"a": 3}, {"a": "\x1b"}, []],
        ),
    ],
)
def test_each_entry_from_both_sides(
    read: Callable[[Any, str], Any], good: list[Any], bad: list[Any]
) -> None:
    for value in good:
        found = read(value, "it")
        if isinstance(value, int | float | str | bool):
            assert found == value
            assert isinstance(found, float if isinstance(value, float) else type(found))
    for value in bad:
        with pytest.raises(mf.UNFIT):
            read(value, "it")


def test_what_is_read_is_what_was_there() -> None:
    assert mf.table_of([[1, 2], [3, 4]], "t", 2, 2).tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert mf.pair_of([1, 2], "p") == (1.0, 2.0)
    assert mf.names_of(["b", "a"], "n") == ("b", "a")
    assert mf.range_of({"device": "single", "trained_on": {**RANGE, "near": NEAR}}).near == (
        tuple(NEAR[0]),
    )
    assert mf.band_of(BAND).to_dict() == BAND
    units = mf.units_of({"units": {"effort": "N", "field": "A", "slip": "m/s"}})
    assert (units.effort, units.field, units.slip) == ("N", "A", "m/s")


def test_a_seal_is_over_all_but_itself() -> None:
    body = mf.sealed({"b": 1, "a": [2.5, "x"]}, None)
    assert body["digest"] == mf.digest_of({"a": [2.5, "x"], "b": 1})
    assert mf.keeps_digest(body)
    assert not mf.keeps_digest({**body, "b": 2})
    assert not mf.keeps_digest({**body, "c": float("nan")})
    assert not mf.keeps_digest({"b": 1})


@pytest.mark.parametrize(
    ("found", "newer"),
    [(2, True), (0, False), ("1", False), (None, False), (True, False), (1.5, False)],
)
def test_another_schema(found: Any, newer: bool) -> None:
    mf.require_schema(1, 1, "f")
    with pytest.raises(RunError) as caught:
        mf.require_schema(found, 1, "f", older="Make it again")
    assert ("of a newer version" in str(caught.value)) == newer
    assert caught.value.remedy == (
        "Update erclutch: pip install --upgrade erclutch" if newer else "Make it again"
    )
    with pytest.raises(CheckError):
        mf.require_schema(found, 1, "f", error=CheckError)


@dataclass(frozen=True)
class Kept:
    """A model whose file has one number."""

    n: int

    def to_dict(self) -> dict[str, Any]:
        return mf.sealed({"kind": "k", "schema": 1, "n": self.n}, None)


def test_what_a_reader_of_models_refuses() -> None:
    body = Kept(3).to_dict()
    assert mf.read_model(body, "k", "f", lambda b: Kept(b["n"])) == Kept(3)
    for wrong, said in (
        ({**body, "kind": "other"}, "this is no model but 'other'"),
        ({**body, "schema": 2}, "schema 2, of a newer version"),
        ({**body, "n": 4}, "the numbers do not match their digest"),
    ):
        with pytest.raises(RunError, match=said):
            mf.read_model(wrong, "k", "f", lambda b: b["n"])
    with pytest.raises(RunError, match="unfit entry: no 'm'"):
        mf.read_model(body, "k", "f", lambda b: b["m"])
    with pytest.raises(RunError, match="unfit entry: n is 3, not true or false"):
        mf.read_model(body, "k", "f", lambda b: mf.truth_of(b["n"], "n"))


def test_an_entry_of_a_model_that_nobody_reads_is_refused() -> None:
    """A gain of a newer version, or a term whose name was changed, was left out of the torque in silence."""
    body = {"kind": "k", "schema": 1, "n": 3}
    with pytest.raises(RunError, match="unfit entry: 'm' is 4, and no such entry is read"):
        mf.read_model(mf.sealed({**body, "m": 4}, None), "k", "f", lambda b: Kept(b["n"]))
    with pytest.raises(RunError, match="unfit entry: n is 3, and is read as 4"):
        mf.read_model(mf.sealed(body, None), "k", "f", lambda b: Kept(b["n"] + 1))


@pytest.mark.parametrize(
    "label", ["bingham, single", "fnn-3+rise-fall, single", "bingham+fnn-3, single"]
)
def test_no_part_of_a_model_has_an_entry_that_nobody_reads(label: str) -> None:
    """Gains, weights, units, references, a unit of a further input: each part took entries of any name."""
    whole = MODELS[label].to_dict()
    parts: list[tuple[str, ...]] = [()]
    for path in parts:
        inside = part_of(whole, path)
        parts += [(*path, key) for key, value in inside.items() if isinstance(value, dict)]
    for path in parts:
        if path[-1:] == ("about",):  # remarks, of any name
            continue
        body = copy.deepcopy(whole)
        part_of(body, path)["T_more"] = 1.5
        for above in range(len(path), -1, -1):  # the digests of the parts, then that of all
            part = part_of(body, path[:above])
            if "digest" in part:
                part["digest"] = mf.digest_of({k: v for k, v in part.items() if k != "digest"})
        with pytest.raises(RunError, match="T_more"):
            _READERS[body["kind"]](body, "f")


def part_of(body: dict[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
    return reduce(lambda part, key: part[key], path, body)


@pytest.mark.parametrize("name", ["kind", "gains"])
def test_an_entry_that_stands_twice_is_refused(tmp_path: Path, name: str) -> None:
    """The last of two gains of one name was the torque, and the digest fitted."""
    path = tmp_path / "m.json"
    text = json.dumps(MODELS["bingham, single"].to_dict())
    path.write_text(text.replace(f'"{name}"', f'"{name}": 0, "{name}"', 1), encoding="utf-8")
    with pytest.raises(RunError, match=f"'{name}' stands in it twice"):
        load_model(path)


@pytest.mark.slow
def test_files_that_are_no_model(tmp_path: Path) -> None:
    for text, said in (
        ("[1]", "not a JSON object"),
        ("{", "no readable model"),
        (json.dumps({"kind": "x"}), "no model but 'x'"),
    ):
        path = tmp_path / "m.json"
        path.write_text(text, encoding="utf-8")
        with pytest.raises(RunError, match=said):
            load_model(path)
    with pytest.raises(RunError, match="a folder, not a model's file"):
        load_model(tmp_path)
    with pytest.raises(RunError, match="no readable model"):
        load_model(tmp_path / "none.json")


# --- names of networks ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "hidden", "centres", "specification"),
    [
        ("fnn-16", (16,), "forward", "fnn-16"),
        (" FNN-10-6 ", (10, 6), "forward", "fnn-10-6"),
        ("fnn-1-1-1-1-1", (1,) * 5, "forward", "fnn-1-1-1-1-1"),
        ("rbfn-500", (500,), "forward", "rbfn-500"),
        ("rbfn-50/refined", (50,), "refined", "rbfn-50/refined"),
        ("rbfn-50/forward", (50,), "forward", "rbfn-50"),
    ],
)
def test_names_of_networks(
    name: str, hidden: tuple[int, ...], centres: str, specification: str
) -> None:
    made = network_from_name(name, past=(1, 1000))
    assert (made.hidden, made.centres, made.specification) == (hidden, centres, specification)
    assert is_network(name)
    assert not is_network("bingham")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("fnn", "unknown network"),
        ("fnn-a", "unknown network"),
        ("cnn-3", "unknown network"),
        ("fnn-3/refined", "unknown"),
        ("fnn-0", "a layer of 0 neurons"),
        ("fnn-3-501", "a layer of 501 neurons"),
        ("fnn-1-1-1-1-1-1", "unknown network"),
        ("rbfn-3-3", "an RBFN has one layer"),
        ("rbfn-3/odd", "an RBFN has one layer"),
    ],
)
def test_what_is_no_network(name: str, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        network_from_name(name)


@pytest.mark.parametrize("past", [(0,), (1, 1001), (-1,)])
def test_past_samples_lie_one_to_a_thousand_rows_back(past: tuple[int, ...]) -> None:
    with pytest.raises(SettingError, match="past samples"):
        network_from_name("fnn-3", past=past)


def test_inputs_in_their_order() -> None:
    assert base_inputs("single", "fnn") == ("field", "slip")
    assert base_inputs("coaxial", "rbfn") == ("E1-E2", "w1", "w2")
    assert base_inputs("coaxial", "fnn", field=False) == ("theta_dot", "alpha_dot")
    made = network_from_name("fnn-3", "single", past=(2, 5), extras=("D",), dynamics="dahl")
    assert made.inputs[:8] == (
        "field",
        "slip",
        "field[-2]",
        "slip[-2]",
        "D[-2]",
        "field[-5]",
        "slip[-5]",
        "D[-5]",
    )
    assert made.inputs[-1] == "D"


@pytest.mark.parametrize(("kernels", "fine"), [(1, False), (2, True), (100, True), (101, False)])
def test_kernels_of_the_rbfm(kernels: int, fine: bool) -> None:
    if fine:
        made = law_from_name(f"rbfm-{kernels}", "single")
        assert np.isfinite(len(made.name))
    else:
        with pytest.raises(
            SettingError, match=f"{kernels} kernels for the RBFM, allowed are 2 to 100"
        ):
            law_from_name(f"rbfm-{kernels}", "single")
