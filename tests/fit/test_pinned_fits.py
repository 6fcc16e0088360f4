"""What fits of small made-up logs report stays as it is kept beside this file: estimates, intervals, findings, words.

Data are SYNTHETIC. Numbers that a search ends at are compared loosely, those of one pass closely: processors differ in
the last digits (`tests/conftest.py` says how to pin anew).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from erclutch.fit.bands.band_pieces import pieces
from erclutch.fit.bands.prediction_bands import calibrated
from erclutch.fit.candidate import Fitted
from erclutch.fit.checks.data_check import check, steady_command
from erclutch.fit.checks.sensor_check import sensor_findings
from erclutch.fit.choice import recommending, scoring
from erclutch.fit.choice.ranking import scored, with_bands
from erclutch.fit.choice.stage_families import families, feels, is_next, with_stage
from erclutch.fit.choice.validation import cross_validated
from erclutch.fit.fit_settings import Settings
from erclutch.fit.history import effort_finding, history_finding
from erclutch.fit.kinds.law_alone import LawCandidate, structures_for
from erclutch.fit.kinds.law_with_network import residuals_for
from erclutch.fit.kinds.network_alone import networks_for
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.log_zeros import log_differences, per_log
from erclutch.fit.past_samples import past_finding, past_rows
from erclutch.fit.recalibration import recalibrate
from erclutch.fit.solver.intervals import (
    bandwidth_of,
    correlated_rows,
    long_run,
    uncertainty,
    unknown,
)
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.synthetic import synthetic_log
from erclutch.models.adaptive_band import adapted
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.recording import TEMPERATURE
from tests.support.pinning import Pinned, summed, told


@cache
def data(rows: int = 1500, seed: int = 0, **more: float) -> Dataset:
    """The demonstration log, perhaps with a gain, an offset, a constant field, steps of resolution."""
    columns = {name: values for name, (_, values) in synthetic_log(rows / 1000.0, seed).items()}
    effort = more.get("gain", 1.0) * columns["torque"] + more.get("offset", 0.0)
    effort = np.round(effort / more["step"]) * more["step"] if "step" in more else effort
    effort = np.clip(effort, -more["most"], more["most"]) if "most" in more else effort
    field = np.full(rows, more["field"]) if "field" in more else columns["field"]
    slip = columns["slip"] * more.get("speed", 1.0) + more.get("shift", 0.0)
    if "stuck" in more:
        effort[300 : 300 + int(more["stuck"])] = effort[300]
    if "spikes" in more:
        effort[:: int(more["spikes"])] *= 40.0
    units = {"field": "V", "slip": "rad/s", "effort": "N*m"}
    signals = {"field": field, "slip": slip, "effort": columns["torque"]}
    recording = recording_from_arrays(signals, units, time=columns["time"], name=f"log {seed}")
    # The effort comes behind the reading, which would leave out what no sensor measured.
    return build_dataset(replace(recording, signals={**recording.signals, "effort": effort}))


def pair(rows: int = 800) -> Dataset:
    """A coaxial pair."""
    t = np.arange(rows) / 1000.0
    e1, e2 = np.maximum(np.sin(9.0 * t), 0.0) * 0.4, np.maximum(-np.sin(9.0 * t), 0.0) * 0.4
    theta, alpha = 20.0 + 4.0 * np.sin(31.0 * t), 6.0 * np.cos(23.0 * t)
    noise = np.random.default_rng(2).normal(size=rows)
    effort = (
        (2.0 * e1**2 + 0.02 * (theta - alpha))
        - (1.7 * e2**2 + 0.02 * (theta + alpha))
        + 0.01 * noise
    )
    signals = {"E1": e1, "E2": e2, "theta_dot": theta, "alpha_dot": alpha, "T": effort}
    log = recording_from_arrays(signals, {"T": "N*m"}, rate=1000.0, name="pair", device="coaxial")
    return build_dataset(log, device="coaxial")


# --- laws ------------------------------------------------------------------------------------------------------------

LAWS = ("bingham", "quadratic", "casson", "hem", "bingham+lag", "herschel-bulkley/critical")


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_laws(name: str, pinned: Pinned) -> None:
    law, _, dynamics = name.partition("+")
    rows = data(600)
    structure = Structure("single", law, law_from_name(law), dynamics or "none", True, True)
    found = fit_structure(rows, structure)
    said = found.to_dict()
    model = said.pop("model")
    pinned(
        {
            "numbers": [[e.value, e.at_bound] for e in found.estimates],
            "about": [[e.name, e.meaning, e.unit] for e in found.estimates],
            "said": [
                found.stop,
                found.rank,
                found.unknowns,
                found.train_rows,
                found.parameters,
                sorted(said),
            ],
            "ranges": {
                k: v
                for k, v in model.items()
                if k.startswith("trained") or k in ("units", "reference")
            },
            "cost": found.train_cost,
        },
        rel=1e-3,
        least=1e-9,
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bingham", "casson", "bingham+lag"])
def test_intervals_of_laws(name: str, pinned: Pinned) -> None:
    law, _, dynamics = name.partition("+")
    structure = Structure("single", law, law_from_name(law), dynamics or "none", True, True)
    found = fit_structure(data(600), structure)
    pinned([[[e.low, e.high] for e in found.estimates], found.bandwidth, found.condition], rel=0.01)


@pytest.mark.slow
def test_laws_of_a_pair(pinned: Pinned) -> None:
    """Slip at which a sign turns is far from the rows here, so numbers are no more than rounding leaves of them."""
    found = [
        fit_structure(
            pair(), Structure("coaxial", law, law_from_name(law, "coaxial"), "none", False, False)
        )
        for law in ("bingham", "hem")
    ]
    pinned(
        [
            [[[e.name, e.unit] for e in f.estimates], f.train_cost, sorted(f.paper_form)]
            for f in found
        ],
        rel=1e-3,
    )


def banded(entry: Any) -> list[Any]:
    return [] if entry.band is None else [vars(entry.band.held), entry.band.plain]


@pytest.mark.slow
def test_a_comparison(pinned: Pinned) -> None:
    """Scores, criteria, bands and notes of models that are fitted once."""
    rows = data()
    test = np.arange(rows.rows) >= 1050
    train = rows.take(~test)
    laws = [
        LawCandidate(s)
        for s in structures_for(rows, Settings(models=("bingham", "quadratic"), lag="none"))
    ]
    fitted = [Fitted(law, law.fit(train, (), 1)) for law in laws]
    folds = [cross_validated(train, law, 3) for law in fitted]
    outcomes = [law.outcome for law in fitted]
    entries = with_bands(rows, test, scored(rows, train, test, outcomes, Settings(seed=4), folds))
    pinned(
        [
            [
                e.name,
                e.train.to_dict(),
                e.test.to_dict(),
                e.criteria,
                e.folds,
                e.excess.to_list(),
                e.sound,
                e.notes,
                *banded(e),
            ]
            for e in entries
        ],
        rel=1e-3,
        least=1e-9,
    )


NAMED: dict[str, dict[str, Any]] = {
    "all": {},
    "paper": {"models": ("paper",)},
    "no lag": {"models": ("bingham", "fnn-3"), "lag": "none"},
    "own stages": {
        "models": ("bingham+dahl", "casson", "rbfn-4+lag", "bingham+fnn-2+lag"),
        "lag": "auto",
    },
    "friction": {
        "models": ("bingham", "hem"),
        "friction": False,
        "offset": False,
        "lag": "rise-fall",
    },
    "past": {"models": ("fnn-2", "bingham+fnn-2"), "past": (1, "3ms")},
    "unknown": {"models": ("bingam",)},
    "unknown stage": {"models": ("bingham",), "lag": "lagg"},
}


def named(structure: Any) -> list[Any]:
    if hasattr(structure, "network"):
        return [*named(structure.law), *named(structure.network)]
    names = (
        "specification",
        "kind",
        "dynamics",
        "friction",
        "offset",
        "extras",
        "hidden",
        "inputs",
        "past",
    )
    return [getattr(structure, name) for name in names if hasattr(structure, name)]


@pytest.mark.parametrize("name", list(NAMED))
def test_names(name: str, pinned: Pinned) -> None:
    settings = Settings(**NAMED[name])
    found: list[Any] = [settings.to_dict()]
    for rows in (data(), pair(), data(field=700.0)):
        for what in (structures_for, networks_for, residuals_for):
            found.append(
                told(lambda rows=rows, what=what: [named(s) for s in what(rows, settings)])
            )
    pinned(found)


# --- checks ----------------------------------------------------------------------------------------------------------

ODD: dict[str, dict[str, float]] = {
    "as it is": {},
    "few": {"rows": 70},
    "sixty": {"rows": 60},
    "coarse": {"step": 0.05},
    "less coarse": {"step": 0.004},
    "saturated": {"most": 0.25},
    "stuck": {"stuck": 200},
    "stuck for a while": {"stuck": 40},
    "spikes": {"spikes": 400},
    "many spikes": {"spikes": 60},
    "one field": {"field": 700.0},
    "no field": {"field": 0.0},
    "one way": {"shift": 200.0},
    "turned": {"gain": -1.0},
    "far off": {"offset": 5.0},
    "huge": {"gain": 1e9},
    "tiny": {"gain": 1e-9},
    "fast": {"speed": 1e5},
    "no slip": {"speed": 0.0},
    "no effort": {"gain": 0.0},
}


@pytest.mark.parametrize("name", list(ODD))
def test_findings(name: str, pinned: Pinned) -> None:
    more = dict(ODD[name])
    rows = data(int(more.pop("rows", 1500)), **more)
    test = np.arange(rows.rows) >= 0.7 * rows.rows
    found = [
        told(lambda: [vars(f) for f in check(rows, test)]),
        [vars(f) for f in sensor_findings(rows)],
    ]
    memory = told(lambda: effort_finding(rows))
    pinned([found, steady_command(rows), None if memory is None else vars(memory)], rel=1e-3)


@pytest.mark.slow
def test_rows_that_are_just_enough(pinned: Pinned) -> None:
    """Fifty to train on, a thousand for a memory, twenty to recalibrate with; one less is too few."""
    base = fit_structure(
        data(600), Structure("single", "bingham", law_from_name("bingham"), "none", True, True)
    ).model
    found: list[Any] = []
    for rows in (49, 50):
        found.append(told(lambda n=rows: len(check(data(80), np.arange(80) >= n))))
    for rows in (999, 1000):
        log = data(rows)
        error = 0.3 * np.roll(log.effort, 40)
        for own in (error, np.where(np.arange(rows) == 7, np.nan, error)):
            memory = history_finding(log, own, "own", "none")
            found.append(None if memory is None else vars(memory))
    for rows in (19, 20):
        found.append(told(lambda n=rows: recalibrate(base, data(900, 5), np.arange(900) < n).way))
    pinned(found, rel=1e-3)


@pytest.mark.slow
def test_findings_of_several_logs(pinned: Pinned) -> None:
    logs = [
        recorded(seed, gain, offset)
        for seed, gain, offset in ((1, 1.0, 0.0), (2, 1.3, 0.05), (3, 1.0, -0.1))
    ]
    rows = build_dataset(logs)
    predicted = (
        np.concatenate([data(900, seed).effort for seed in (1, 2, 3)])
        + 0.01 * walk(2700, 0.5, 6)[:, 0]
    )
    test = np.arange(rows.rows) % 900 > 600
    found: list[Any] = [vars(f) for f in (*log_differences(rows, predicted), *check(rows, test))]
    memory = history_finding(
        rows, rows.effort - predicted + 0.1 * np.roll(predicted, 30), "own", "lag"
    )
    fewer = [slice(0, 500), slice(900, 1500)]
    each = per_log(
        [rows.effort[s] for s in fewer], [predicted[s] for s in fewer], [np.ones(500), np.ones(600)]
    )
    at = pieces(rows, test)
    pinned(
        [
            found,
            None if memory is None else vars(memory),
            vars(each),
            [[n, summed(p)] for n, p in at],
        ],
        rel=1e-3,
    )


def recorded(seed: int, gain: float, offset: float) -> Any:
    columns = {name: values for name, (_, values) in synthetic_log(0.9, seed).items()}
    signals = {
        "field": columns["field"],
        "slip": columns["slip"],
        "effort": gain * columns["torque"] + offset,
    }
    return recording_from_arrays(signals, {"effort": "N*m"}, rate=1000.0, name=f"log {seed}")


# --- numbers ---------------------------------------------------------------------------------------------------------


def walk(rows: int, pole: float, seed: int, columns: int = 1) -> Array:
    found = np.random.default_rng(seed).normal(size=(rows, columns))
    for k in range(1, rows):
        found[k] += pole * found[k - 1]
    return found


@pytest.mark.slow
def test_standard_errors(pinned: Pinned) -> None:
    found: list[Any] = []
    for rows, pole, columns in (
        (30, 0.0, 2),
        (300, 0.5, 3),
        (700, 0.95, 2),
        (400, -0.6, 1),
        (500, 0.9999, 2),
    ):
        jacobian, residual = walk(rows, 0.8, 1, columns), walk(rows, pole, 2)[:, 0]
        scores = jacobian * residual[:, None]
        for ordered in (True, False):
            found.append(vars(uncertainty(jacobian, residual, ordered=ordered)))
        found += [
            vars(unknown(jacobian)),
            bandwidth_of(scores),
            long_run(scores),
            correlated_rows(residual),
        ]
    twice = np.repeat(walk(90, 0.3, 4), 2, axis=1)
    found += [vars(uncertainty(twice, walk(90, 0.3, 5)[:, 0], ordered=o)) for o in (True, False)]
    gone = np.column_stack([walk(90, 0.3, 4), np.zeros(90)])
    found += [vars(uncertainty(gone, walk(90, 0.3, 5)[:, 0], ordered=o)) for o in (True, False)]
    pinned(
        [
            {k: v for k, v in f.items() if k != "condition"} if isinstance(f, dict) else f
            for f in found
        ]
    )


def test_scores(pinned: Pinned) -> None:
    y, error, other = (walk(240, pole, seed)[:, 0] for pole, seed in ((0.9, 1), (0.7, 2), (0.2, 3)))
    found: list[Any] = [scoring.score(y, y - e, block=b, seed=s).to_dict() for e, b, s in (
        (error, None, 0), (other, 7, 1), (0.0 * y, 3, 0), (np.where(y > 2, np.nan, y), None, 0))]  # fmt: skip
    found += [
        scoring.block_rows([error]),
        scoring.block_rows([error, other]),
        scoring.independent_rows(error),
    ]
    found += [
        f(error, o, block=9, seed=2).to_list()
        for f in (scoring.excess, scoring.difference)
        for o in (other, error)
    ]
    found.append(scoring.excess(error, 0.0 * error, block=9).to_list())
    found += [scoring.information_criteria(12.5, 240, n, 7) for n in (240.0, 30.0, 1.0)]
    rows = {
        name: scoring.score(y, y - scale * error, block=9)
        for name, scale in (("a", 1.0), ("b", 1.04), ("c", 1.3))
    }
    best = [scoring.excess(scale * error, error, block=9) for scale in (1.0, 1.04, 1.3)]
    for sizes in ((9, 5, 1), (5, 5, 5), (3, 9, 1)):
        given = dict(zip("abc", best, strict=True)), dict(zip("abc", sizes, strict=True))
        found += [
            recommending.recommend(rows, *given, sound)
            for sound in (None, {"b", "c"}, {"c"}, set())
        ]
    pinned(found)


@pytest.mark.slow
def test_bands(pinned: Pinned) -> None:
    rows = data()
    train = np.arange(rows.rows) < 1050
    errors = [
        0.02 * walk(rows.rows, pole, 7)[:, 0] * (1.0 + rows.elements[0].field / 500.0)
        for pole in (0.2, 0.9)
    ]
    found = calibrated(rows, train, [*errors, np.full(rows.rows, np.nan)], [3, 40, 1])
    assert found[0] is not None
    ends = found[0][0].around(rows.effort - errors[0], rows.elements, rows.clock)
    taught = adapted(found[0][0], ends, rows.effort - errors[0], rows.effort, rows.clock)
    pinned(
        [
            [None if f is None else [vars(f[0]), f[1]] for f in found],
            [summed(end) for end in taught],
        ]
    )


def test_steps_of_the_ladder(pinned: Pinned) -> None:
    names = [name for family in families() for name in family]
    forms = ("none", "lag", "rise-fall+dahl", "lag+dahl-2/field+inertia")
    laws = [
        Structure("single", law, law_from_name(law), "none")
        for law in ("bingham", "on-off", "rbfm-2", "casson", "hem")
    ]
    felt = [
        [feels(data(), law, n, extras) for law in laws for extras in ((), ("u",), (TEMPERATURE,))]
        for n in names
    ]
    left = [[is_next(names[k:], n) for n in names[k:]] for k in range(len(names))]
    pinned(
        [
            families(),
            felt,
            left,
            [[told(lambda f=f, n=n: with_stage(f, n)) for n in names] for f in forms],
        ]
    )


def test_past_samples(pinned: Pinned) -> None:
    asked: tuple[Any, ...] = (
        (),
        (1,),
        (0,),
        (1000,),
        (1001,),
        ("2ms", 2),
        ("0.4 ms",),
        ("1.5 s",),
        ("5",),
        ("x",),
        (-1,),
    )
    pinned(
        [
            [
                told(lambda a=a: past_rows(a, data())),
                told(lambda a=a: [vars(f) for f in past_finding(a, data())]),
            ]
            for a in asked
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "change", [{"gain": 1.3}, {"offset": 0.05}, {"gain": 0.7, "offset": -0.2}, {}]
)
def test_recalibrations(change: dict[str, float], pinned: Pinned) -> None:
    base = fit_structure(
        data(600), Structure("single", "bingham", law_from_name("bingham"), "none", True, True)
    ).model
    found = recalibrate(base, data(900, 5, **change), np.arange(900) < 300)
    pinned(
        [found.way, found.reason, {k: list(v) for k, v in found.folds.items()}, found.numbers],
        rel=5e-3,
    )
