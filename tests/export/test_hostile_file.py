"""A model's file whose digest is good and whose entries make no sense ends in one line."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError, RunError
from erclutch.export import ExportOptions, export_model, step_of
from erclutch.export.c.c_header import header
from erclutch.export.c.c_source import source
from erclutch.export.export_folder import read_export
from erclutch.models.band import Band
from erclutch.models.law_model import TorqueModel
from erclutch.models.load import load_model
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of
from erclutch.models.networks.network_model import NetworkModel

NUMBERS: tuple[Any, ...] = (
    *(
        float("nan"),
        float("inf"),
        -float("inf"),
        1e308,
        -1e308,
        1e200,
        1e-200,
        1e-308,
        5e-324,
        1e16,
        -1.0,
        0.0,
        -0.0,
    ),
    *(0, -1, -3, 10**9, 2**64, 10**400, -(10**400)),
)
OTHERS: tuple[Any, ...] = (
    True,
    False,
    None,
    "",
    "x",
    "1.0",
    "nan",
    [],
    {},
    [[]],
    [1],
    [1, 2, 3],
    [1, [2]],
    {"a": 1},
)
BAND = Band(
    0.95, 0.01, 5.0, (0.0, 100.0), (-1.0, 1.0), (10.0, 60.0), (0.3,), (0.1, 0.2) * 6, (0.2, 0.1) * 6
)
FACTORS = (-1, 1e3, 1e-3, 0.5, 1e30, 1e-30, 1e300)


def _places(body: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    entries = (
        body.items()
        if isinstance(body, dict)
        else enumerate(body)
        if isinstance(body, list)
        else ()
    )
    for key, value in entries:
        if key != "digest":
            yield (*at, key)
            yield from _places(value, (*at, key))


def _nested(depth: int) -> Any:
    value: Any = 1
    for _ in range(depth):
        value = [value]
    return value


def _mutate(rng: random.Random, body: dict[str, Any]) -> None:
    """One entry is taken away, doubled, scaled, or becomes something else."""
    *keys, last = rng.choice(list(_places(body)))
    inner: Any = body
    for key in keys:
        inner = inner[key]
    value, kind = inner[last], rng.randrange(8)
    if kind == 0:
        del inner[last]
    elif kind == 1 and isinstance(inner, list):
        inner.append(value)
    elif kind == 2 and isinstance(inner, dict):
        inner[rng.choice(("x", "n", "tau", ""))] = rng.choice((*NUMBERS, *OTHERS))
    elif kind == 3:
        inner[last] = _nested(rng.choice((3, 50, 400)))
    elif kind <= 5 and isinstance(value, int | float):
        inner[last] = value * rng.choice(FACTORS)
    else:
        inner[last] = rng.choice((*NUMBERS, *OTHERS))


def _sealed(body: dict[str, Any]) -> dict[str, Any]:
    """The body with its digest redone, also those of a law and a network inside; NaN has no digest."""
    for part in (body.get("law"), body.get("network")):
        if isinstance(part, dict):
            _sealed(part)
    try:
        body["digest"] = digest_of({key: value for key, value in body.items() if key != "digest"})
    except (ValueError, RecursionError):
        body["digest"] = "0" * 64
    return body


def _use(model: Model) -> None:
    """Export it and ask it for efforts."""
    step = step_of(model, ExportOptions(name="m", period=None if model.period else 1e-3))
    assert header(step)
    assert source(step)
    e = step.elements
    rows = [np.array([0.0, 1.0, 2.0, 1e3])] * e, [np.array([-1.0, 0.0, 2.0, 1e3])] * e
    assert model.steady(*rows, [np.ones(4)] * len(model.extras)).shape == (4,)
    assert model.to_dict()


def _attack(bodies: list[dict[str, Any]], count: int, used: int, path: Path) -> tuple[int, int]:
    """Load mutated files, and use every so many of those that load; how many load and how many are used."""
    rng = random.Random(20)
    loaded = tried = 0
    for k in range(count):
        body = json.loads(json.dumps(rng.choice(bodies)))
        for _ in range(rng.choice((1, 1, 1, 2))):
            _mutate(rng, body)
        # A new file each time: a disk waits for what it still writes of the old one before it empties that.
        path.unlink(missing_ok=True)
        path.write_text(json.dumps(_sealed(body)), encoding="utf-8")
        try:
            model = load_model(path)
            loaded += 1
            if loaded % used == 0:
                tried += 1
                _use(model)
        except ErclutchError as error:
            if not str(error).isprintable():
                pytest.fail(f"mutation {k} has no error of one line")
        except Exception as error:
            raise AssertionError(f"mutation {k}: {type(error).__name__}: {error!s:.200}") from error
    return loaded, tried


@pytest.fixture
def bodies(
    law: Callable[..., TorqueModel], network: Callable[..., NetworkModel], models: dict[str, Model]
) -> list[dict[str, Any]]:
    residual = next(model for model in models.values() if model.correction is not None)
    made: tuple[Any, ...] = (
        law("bingham/power", "single", "lag", further=("temperature",)),
        law("rbfm-2", "coaxial", "rise-fall"),
        law("casson", "single", "dahl"),
        law("casson", "single", "arrhenius+softening"),
        network("fnn-2", "single", "lag", extras=("temperature",), past=(1,)),
        network("rbfn-2/spreads", "coaxial"),
        network("fnn-2", "single", "dahl"),
        residual,
    )
    return [replace(model, band=BAND).to_dict() for model in made]


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, '{"kind": ' + "9" * 5000 + "}"])
def test_a_file_that_is_too_deep_or_long(text: str, tmp_path: Path) -> None:
    path = tmp_path / "m.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RunError, match="no readable model"):
        load_model(path)


def test_what_fits_may_leave_is_taken(network: Callable[..., NetworkModel], tmp_path: Path) -> None:
    """A spread is squared, so its sign is chance; a network on a residual that helps nowhere is multiplied by 0."""
    path = tmp_path / "m.json"
    for spread, scale, good in ((-0.5, 0.7, True), (0.5, 0.0, True), (0.0, 0.7, False)):
        body = network("rbfn-2/spreads").to_dict()
        body["weights"]["spreads"][1] = spread
        body["scaling"]["effort_scale"] = scale
        path.write_text(json.dumps(_sealed(body)), encoding="utf-8")
        if good:
            assert load_model(path).to_dict() == body
        else:
            with pytest.raises(RunError, match="a spread is 0"):
                load_model(path)


def test_an_exponent_that_would_overflow(
    network: Callable[..., NetworkModel], tmp_path: Path
) -> None:
    body = network("fnn-2", "single", "dahl").to_dict()
    body["dynamics"]["n_m"] = 5e15
    path = tmp_path / "m.json"
    path.write_text(json.dumps(_sealed(body)), encoding="utf-8")
    with pytest.raises(RunError, match="n_m is 5e\\+15"):
        load_model(path)


@pytest.mark.slow
def test_mutated_files(bodies: list[dict[str, Any]], tmp_path: Path) -> None:
    loaded, _ = _attack(bodies, 300, 10**9, tmp_path / "m.json")
    assert loaded < 100


@pytest.mark.slow
def test_ten_thousand_mutated_files(bodies: list[dict[str, Any]], tmp_path: Path) -> None:
    loaded, used = _attack(bodies, 10_000, 12, tmp_path / "m.json")
    assert loaded < 3000
    assert used > 50


@pytest.mark.slow
def test_mutated_descriptions_of_an_export(law: Callable[..., TorqueModel], tmp_path: Path) -> None:
    folder, rng, refused = tmp_path / "out", random.Random(3), 0
    export_model(law("bingham", "single", "lag"), folder, "c", ExportOptions(name="m"))
    body = json.loads((folder / "export.json").read_text())
    for _ in range(120):
        changed = json.loads(json.dumps(body))
        _mutate(rng, changed)
        (folder / "export.json").write_text(json.dumps(changed))
        try:
            read_export(folder)
        except ErclutchError as error:
            refused += 1 if str(error).isprintable() else -1000
    assert refused > 40
