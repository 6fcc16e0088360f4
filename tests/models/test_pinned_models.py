"""What models of every kind compute and say stays as it is kept beside this file: efforts, units, equations, words.

`tests/conftest.py` says how to pin anew after a change that is meant.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from erclutch.models.band import Band, centres
from erclutch.models.covered_cells import CoveredCells, cells_of
from erclutch.models.gain_tracking import BASE, tracking_of
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.laws import at_one_field, families, ladder, law_from_name, shown_laws
from erclutch.models.laws.symbolic import equation_latex
from erclutch.models.model import Range, margins
from erclutch.models.model_file import digest_of
from erclutch.models.networks import network_from_name, table_shapes
from erclutch.models.networks.network_file import network_from_dict
from erclutch.models.networks.network_model import NetworkModel, Scaling
from erclutch.models.residual_model import BoundedResidual, ResidualModel
from erclutch.models.stages import canonical, needs_time, shown_stages, stage_equations, stages_of
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import POSITION, TEMPERATURE
from tests.support.pinning import Pinned, summed, told
from tests.support.slow_params import slow_behind

UNITS, ROWS = Units("N*m", "V", "rad/s"), 160
T = np.arange(ROWS) / 1000.0
#: Two stretches, and a row that comes late in the second.
CLOCK = Clock(
    np.where(np.arange(ROWS) > 130, T + 0.0004, T), (Span(0, 90, 1e-3), Span(90, ROWS, None))
)
FIELDS = [np.where(T % 0.05 < 0.03, 500.0, 90.0) * (1.0 + T), np.where(T % 0.05 < 0.03, 0.0, 300.0)]
SLIPS = [18.0 * np.sin(70.0 * T), 9.0 * np.cos(90.0 * T)]
EXTRAS = {TEMPERATURE: 300.0 + 200.0 * T, "u": np.sin(50.0 * T), POSITION: 9.0 * np.sin(31.0 * T)}


def law_model(
    name: str, device: Any = "single", dynamics: str = "none", extras: tuple[str, ...] = ()
) -> TorqueModel:
    structure = Structure(
        device, name, law_from_name(name, device), dynamics, device == "single", True, extras
    )
    shape = {s.name: s.lower * (s.upper / s.lower) ** 0.4 if s.scale == "log" else s.lower + 0.3 * (s.upper - s.lower)
             for s in structure.shapes(1e-3)}  # fmt: skip
    gains = {g.name: 0.1 + 0.07 * i for i, g in enumerate(structure.gains())}
    ranges = Range((0.0, 600.0), (-20.0, 20.0), (-2.0, 2.0), ((0xFF0F,) * 16,) * structure.elements)
    scales = tuple(310.0 if n == TEMPERATURE else 1.7 for n in structure.extras)
    reference = Reference(
        600.0, 11.0, 1e-3, scales, 310.0 if TEMPERATURE in structure.extras else 1.0
    )
    covered = tuple((280.0, 330.0) if n == TEMPERATURE else (-0.5, 0.5) for n in structure.extras)
    return TorqueModel(structure, reference, shape, gains, UNITS, ranges, extra_ranges=covered)


def network_model(
    name: str, device: Any = "single", dynamics: str = "none", **more: Any
) -> NetworkModel:
    structure = network_from_name(name, device, dynamics=dynamics, **more)
    rng, count = np.random.default_rng(7), len(structure.inputs)
    weights = {n: rng.uniform(-0.9, 1.1, shape) for n, shape in table_shapes(structure).items()}
    if structure.kind == "rbfn":
        weights["spreads"] = rng.uniform(0.4, 1.2, structure.hidden[0])
    numbers = {p.name: p.lower * (p.upper / p.lower) ** 0.4 if p.scale == "log" else p.lower + 0.3 * (p.upper - p.lower)
               for stage in stages_of(dynamics) for p in stage.parameters(1e-3)}  # fmt: skip
    if any(stage.place == "slip" for stage in stages_of(dynamics)):
        numbers |= {"n_m": 1.3, "E_m": 555.5}
    scale = np.array(
        [300.0 if "E" in n or "field" in n or n in EXTRAS else 20.0 for n in structure.inputs]
    )
    ranges = Range((0.0, 600.0), (-20.0, 20.0), (-2.0, 2.0))
    scaling = Scaling(0.01 * scale, scale, 0.013, 0.7)
    limits = np.column_stack([-np.ones(count), scale])
    return NetworkModel(
        structure, scaling, weights, numbers, UNITS, ranges, limits, {"seed": "7"}, 1e-3
    )


def residual_model() -> ResidualModel:
    law = law_model("bingham", "single", "lag")
    network = network_model("fnn-3", "single", "lag", extras=("u",))
    low = np.array([[0.0, -20.0, -1.0], [300.0, 2.0, -1.0]])
    boxes = CoveredCells(low, low + np.array([250.0, 15.0, 1.2]), np.array([60.0, 4.0, 0.3]))
    return ResidualModel(law, BoundedResidual(network, 0.3, boxes))


def stage_names() -> list[str]:
    return [stage.name for stage in shown_stages()]


def made(name: str) -> Any:
    """A law, a law with stages, a network, or both."""
    if name == "residual":
        return residual_model()
    name, _, device = name.partition(", ")
    first, _, stages = name.partition("+")
    device, stages = device or "single", stages or "none"
    if first.startswith(("fnn", "rbfn")):
        more: dict[str, Any] = {"past": (1, 3), "extras": ("u",)} if first.endswith("-3") else {}
        return network_model(first, device, stages, **more)
    return law_model(first, device, stages, ("u",) if stages != "none" else ())


NETWORKS = (
    "fnn-4",
    "fnn-3",
    "rbfn-3+lag",
    "fnn-4-2, coaxial",
    "rbfn-5+rise-fall+dahl, coaxial",
    "residual",
)
KINDS = (
    *shown_laws(),
    *(f"{name}, coaxial" for name in ladder()),
    *(f"bingham+{name}" for name in stage_names()),
    *(
        "hem+dahl/field, coaxial",
        "cho-choi-jhon+bouc-wen-2+arrhenius",
        "bingham/forward+stops-2+inertia, coaxial",
    ),
    *NETWORKS,
)


@pytest.mark.parametrize("name", KINDS)
def test_a_model(name: str, pinned: Pinned) -> None:
    model = told(lambda: made(name))
    if isinstance(model, str):
        pinned(model)
        return
    count = 2 if model.structure.device == "coaxial" else 1
    elements = [Element(f, w) for f, w in zip(FIELDS[:count], SLIPS, strict=False)]
    further = {n: EXTRAS[n] for n in model.extras}
    body = model.to_dict()
    found = {
        "effort": [
            told(lambda e=e: summed(model.effort(elements, CLOCK, further, exactly=e)))
            for e in (True, False)
        ],
        "steady": summed(model.steady(FIELDS[:count], SLIPS[:count], list(further.values()))),
        "words": [
            model.name,
            model.title,
            model.signed,
            model.past,
            list(model.extras),
            model.equation(),
        ],
        "numbers": {k: summed(v) for k, v in model.numbers.items()},
        "units": list(model.in_units()) if isinstance(model, TorqueModel) else model.times,
        "file": {
            k: v for k, v in body.items() if k not in ("digest", "weights", "network", "law_model")
        },
        "margins": [margins(model.trained_on.field), margins((0.0, 0.0)), margins((-2.0, -1.0))],
    }
    if isinstance(model, TorqueModel | NetworkModel):
        read = model_from_dict if isinstance(model, TorqueModel) else network_from_dict
        assert read(body).to_dict() == body
    found["file"] = {k: (sorted(v) if isinstance(v, dict) else v) for k, v in found["file"].items()}
    pinned(found)


@pytest.mark.slow
def test_laws_in_words(pinned: Pinned) -> None:
    laws = [law_from_name(name) for name in shown_laws()]
    kept = {law.name: [law.title, law.source, equation_latex(law)] for law in laws}
    fields = {
        name: [told(lambda n=name, d=d: at_one_field(n, d)) for d in ("single", "coaxial")]
        for name in shown_laws()
    }
    wrong = (
        "bingam",
        "rbfm",
        "rbfm-0",
        "rbfm-1",
        "rbfm-31",
        "rbfm-x",
        "bingham-3",
        "casson/none",
        "hem/forward/forward",
        "",
    )
    pinned(
        [
            kept,
            fields,
            {n: told(lambda n=n: law_from_name(n).name) for n in wrong},
            sorted(families()),
            ladder(),
        ]
    )


@pytest.mark.slow
def test_stages_in_words(pinned: Pinned) -> None:
    about = [
        [s.name, s.title, s.source, s.equation, s.place, s.switches]
        + [
            [p.name, p.lower, p.upper, p.scale, p.meaning, p.scanned]
            for period in (1e-3, 0.02)
            for p in s.parameters(period)
        ]
        for s in shown_stages()
    ]
    forms = (
        "lag+dahl",
        "dahl+lag",
        "lag+lag",
        "lag+rise-fall",
        "",
        "none",
        "dahl-9",
        "dahl-0",
        "dahl/none",
        "stops-2/field",
        "x",
    )
    kept = {s.name: needs_time(s) for s in shown_stages() if s.place == "slip"}
    pinned([about, kept, [told(lambda f=f: [canonical(f), stage_equations(f)]) for f in forms]])


def test_networks_in_words(pinned: Pinned) -> None:
    names = (
        "fnn-4",
        "fnn",
        "fnn-0",
        "fnn-1-2",
        "fnn-1-2-3",
        "fnn-x",
        "rbfn-4",
        "rbfn-4-4",
        "rbfn",
        "fnn-1000",
        "fnn-100000",
    )
    devices: tuple[Any, ...] = ("single", "coaxial")
    pinned([told(lambda n=n, d=d: network_from_name(n, d).inputs) for n in names for d in devices])


# --- files -----------------------------------------------------------------------------------------------------------

WRONG: tuple[Any, ...] = (None, -1, 0, 1e308, "x", True, [], {}, [1, 2], "a*/b", 1e-320)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    slow_behind(3, ["hem+rise-fall+dahl, coaxial", "bingham+arrhenius", "fnn-3", "rbfn-3+lag"]),
)
def test_damaged_files(name: str, pinned: Pinned) -> None:
    """Each entry in turn is something else, or is left out."""
    model = made(name)
    body = model.to_dict()
    read = model_from_dict if isinstance(model, TorqueModel) else network_from_dict

    def entries(part: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        inner = (
            part.items()
            if isinstance(part, dict)
            else enumerate(part[:2])
            if isinstance(part, list)
            else ()
        )
        return [path, *(p for key, value in inner for p in entries(value, (*path, key)))]

    found: dict[str, str] = {}
    for path in entries(body)[1:]:
        said = ""
        for wrong in (*WRONG, KeyError):
            other = copy.deepcopy(body)
            part = other
            for key in path[:-1]:
                part = part[key]
            if wrong is KeyError:
                del part[path[-1]]
            else:
                part[path[-1]] = wrong
            other = {
                **other,
                "digest": digest_of({k: v for k, v in other.items() if k != "digest"}),
            }
            said += "r" if isinstance(told(lambda other=other: read(other)), str) else "t"
        found["/".join(map(str, path))] = said  # taken or refused
    pinned(found)


# --- bands -----------------------------------------------------------------------------------------------------------

WIDTHS = tuple(0.01 * 1.1**k for k in range(24))
BAND = Band(
    0.95,
    0.01,
    40.0,
    (0.0, 600.0),
    (-20.0, 20.0),
    (100.0, 300.0, 500.0),
    (5.0, 15.0),
    WIDTHS,
    tuple(1.5 * w for w in WIDTHS),
)


def test_bands(pinned: Pinned) -> None:
    elements = [
        [Element(FIELDS[0], SLIPS[0])],
        [Element(f, w) for f, w in zip(FIELDS, SLIPS, strict=True)],
    ]
    effort = np.sin(30.0 * T)
    found: list[Any] = [
        BAND.shape,
        BAND.to_dict(),
        summed(centres(BAND.field)),
        summed(centres((-3.0, 5.0))),
    ]
    for each in elements:
        low, high = BAND.around(effort, each, CLOCK)
        found += [summed(BAND.cells(each, CLOCK)), summed(low), summed(high)]
    pinned(found)


@pytest.mark.slow
def test_tracking(pinned: Pinned) -> None:
    found: list[Any] = []
    for gain, offset, noise in (
        (1.2, 0.0, 0.0),
        (0.9, 0.1, 0.05),
        (3.0, 0.0, 0.0),
        (1.0, 0.0, 1e-6),
        (-1.0, 0.0, 0.0),
    ):
        tracking, state, given = tracking_of(2.0, (-2.5, 2.5)), BASE, []
        for k, effort in enumerate(2.0 * np.sin(0.05 * np.arange(400.0))):
            own, cost = tracking.moved(state, effort)
            out = own if cost < state.account else effort
            given.append(out)
            state = tracking.after(
                state, effort, out, gain * effort + offset + noise * np.sin(k * k)
            )
        found.append([summed(given), [float(x) for x in state]])
    pinned(found)


@pytest.mark.slow
def test_covered_cells(pinned: Pinned) -> None:
    rng = np.random.default_rng(3)
    rows: Array = np.hstack(
        [rng.uniform(0.0, 1.0, (3, 200)), rng.uniform(3.0, 4.0, (3, 300)), np.ones((3, 1)) * 9.0]
    )
    found: list[Any] = []
    for boxes in (1, 2, 4, 8):
        cells = cells_of(rows, boxes)
        weights = cells.weight(list(rng.uniform(-1.0, 10.0, (3, 100))))
        found.append(
            [
                summed(np.sort(cells.low, axis=0)),
                summed(np.sort(cells.high, axis=0)),
                cells.reach,
                summed(weights),
            ]
        )
    found.append(
        [
            summed(x)
            for x in (lambda c: (c.low, c.high, c.reach))(
                cells_of(np.ones((2, 9)) * [[3.0], [0.0]], 8)
            )
        ]
    )
    pinned(found)


# --- entries of files ------------------------------------------------------------------------------------------------


def test_entries(pinned: Pinned) -> None:
    """Both sides of every limit of an entry."""
    from erclutch.models import model_file as f

    def one(of: Callable[[], Any]) -> Any:
        try:
            return of()
        except (ValueError, TypeError, KeyError) as error:
            return f"{type(error).__name__}: {error}"[:70]

    numbers = (
        1e18,
        1.0000001e18,
        -1e18,
        -1.1e18,
        0,
        f.SMALLEST,
        0.99 * f.SMALLEST,
        True,
        "1",
        10**30,
    )
    found: dict[str, Any] = {
        "numbers": [
            [one(lambda v=v, p=p: f.number_of(v, "x", positive=p)) for p in (False, True)]
            for v in numbers
        ]
    }
    found["whole"] = [one(lambda v=v: f.whole_number_of(v, "x")) for v in (1, 1.0, True, "1")]
    found["truths"] = [one(lambda v=v: f.truth_of(v, "x")) for v in (True, False, 1, None)]
    tables: tuple[tuple[Any, ...], ...] = (
        ([1.0, 2.0], 2),
        ([1.0], 2),
        ([[1.0], [2.0]], 2, 1),
        ([[1.0], 2.0], 2, 1),
        (3.0,),
        ([], 0),
    )
    found["tables"] = [one(lambda t=t: f.table_of(t[0], "x", *t[1:]).tolist()) for t in tables]
    found["pairs"] = [
        one(lambda v=v: f.pair_of(v, "x")) for v in ([1, 2], [2, 1], [1, 1], [0.0, -0.0], [1, 2, 3])
    ]
    texts = ("a" * f._LONGEST_TEXT, "a" * (f._LONGEST_TEXT + 1), "", "a\nb", "é", 3)
    found["names"] = [one(lambda v=v: f.name_of(v, "x")) for v in texts]
    found["several"] = [one(lambda v=v: f.names_of(v, "x")) for v in (["a", "b"], ["a", "a"], [])]
    masks = ([0] * 16, [0] * 15, [0] * 17, [65535] * 16, [65536] * 16, [-1] * 16)
    found["masks"] = [one(lambda v=v: f.near_of([v], "single")[0]) for v in masks]
    edges = [[1.0 + k for k in range(n)] for n in (0, 1, f.MOST_EDGES, f.MOST_EDGES + 1)]
    found["edges"] = [
        one(lambda v=v: f._edges_of(v, "x")) for v in (*edges, [2.0, 1.0], [1.0, 1.0], "x")
    ]
    body = BAND.to_dict()
    for key, value in (
        ("level", 1.0),
        ("level", 0.999),
        ("threshold", 0.0),
        ("behind", [-1e-9, *WIDTHS[1:]]),
        ("behind", [0.0, *WIDTHS[1:]]),
    ):
        found[f"{key} {str(value)[:9]}"] = one(
            lambda k=key, v=value: summed(f.band_of({**body, k: v}).behind)
        )
    pinned(found)


def test_layers(pinned: Pinned) -> None:
    names = (
        "fnn-500",
        "fnn-501",
        "rbfn-500",
        "rbfn-501",
        "fnn-1-500",
        "fnn-501-1",
        "rbfm-30",
        "rbfm-31",
    )
    stages = [f"dahl-{n}" for n in (0, 1, 2, 6, 7, 12, 13, 99, 999, 1000, "03", "0003")]
    pinned(
        [
            [told(lambda n=n: network_from_name(n, "single").hidden) for n in names],
            [told(lambda s=s: canonical(s)) for s in stages],
        ]
    )
