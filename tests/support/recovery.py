"""Known-truth recovery: how often the stated 95 % interval holds the true parameter.

For each law: inputs that excite all of it, effort from the law itself with known numbers, noise drawn anew in each
repetition, a fit from the default scan (the truth is never a start), and a count of how often each true number lies in
its interval. White noise, or noise whose neighbours are correlated (AR(1), 0.6; "ar1-0.9": 0.9).
The case "cho-choi-jhon (loud)" has so much noise that a fifth of its fits end at a bound. SYNTHETIC.
`studies/recovery.py` prints the table.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Literal

# One BLAS thread a fit; before NumPy is imported, here and in the workers, which inherit it.
if __name__ == "__main__":
    for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(_name, "1")

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.model import Range
from erclutch.models.parameter_units import in_user_units
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

Array = NDArray[np.float64]
Noise = Literal["white", "ar1", "ar1-0.9"]

ROWS = 3000
PERIOD = 1e-3
#: Correlation of neighbouring rows.
CORRELATIONS: dict[Noise, float] = {"white": 0.0, "ar1": 0.6, "ar1-0.9": 0.9}
TARGET, TOLERANCE = 0.95, 0.03
ENOUGH = 100  # repetitions for a verdict

_LARGEST_FIELD, _LARGEST_SLIP = 2000.0, 60.0
_SINH = 3.0


@dataclass(frozen=True)
class Truth:
    """A law or a law with a stage, its numbers, and what its data must be like to tell them.

    Attributes:
        specification: the law.
        shape, gains: its numbers, normalised as in the model.
        dynamics: the stages.
        focus: normalised fields that a third of the steps are drawn from, where the law has a narrow feature.
        noise: as a share of the effort's standard deviation.
        remark: tells the case from others of the same law.
    """

    specification: str
    shape: Mapping[str, float]
    gains: Mapping[str, float]
    dynamics: str = "none"
    focus: tuple[float, float] | None = None
    noise: float = 0.02
    remark: str = ""

    @property
    def name(self) -> str:
        """What the case is called in the table and after ``--laws``."""
        return (
            self.specification
            + (f"+{self.dynamics}" if self.dynamics != "none" else "")
            + self.remark
        )

    @property
    def structure(self) -> Structure:
        """The law with its stages, and with friction where the truth has some."""
        law = law_from_name(self.specification)
        friction = "T_f" in self.gains
        return Structure("single", self.specification, law, self.dynamics, friction)


_DIRECTION = {"w_s": 0.05}
_POWER = {"n": 1.6}
_TWO = {"T_y": 0.5, "eta": 0.15}
_CCJ = {**_DIRECTION, "t_1": 2.0, "a": 1.3, "t_2": 2.0, "b": 0.4, **_POWER}


def _with_stage(dynamics: str, shape: Mapping[str, float], **gains: float) -> Truth:
    """A Bingham law with a stage; its sign turns over a wide slip, so that rows tell it from a memory."""
    law = {"w_s": 0.2, **_POWER}
    return Truth("bingham", {**law, **shape}, {"T_y": 0.3, "eta": 0.15, **gains}, dynamics)


_STAGES = (
    _with_stage("second-order", {"tau_c": 4e-3, "zeta_c": 0.5}),
    _with_stage("two-lags", {"tau_1": 3e-3, "m_1": 12.0, "p_1": 0.6}),
    _with_stage("effort-lag", {"tau_e": 4e-3}),
    _with_stage("effort-second-order", {"tau_s": 3e-3, "zeta_s": 0.3}),
    _with_stage("inertia", {}, m_a=1e-3),
    _with_stage("inertia/smooth", {"tau_a": 4e-3}, m_a=1e-3),
    _with_stage("stiffness", {"tau_x": 0.2}, k=5.0),
    _with_stage("viscous", {"p": 0.5}, T_v=0.15, T_vy=0.2),
    _with_stage("sides", {"w_a": 0.2}, eta_a=0.08, T_a=0.1, T_ay=0.15),
    _with_stage("knees", {"w_f": 0.6, "w_b": 0.9}, eta_f=-0.1, eta_b=0.08),
    _with_stage("stribeck", {"w_st": 0.25}, T_st=0.1, T_sty=0.2),
    _with_stage("self-heating", {"tau_h": 0.3}, T_h=-0.08),
    _with_stage("remanence", {"r_h": 0.3, "s_h": 0.6}),
    _with_stage("dahl", {"r_1": 8e-3}, T_s1=0.1, T_z1=0.4),
    _with_stage("dahl-2/field", {"r_1": 3e-3, "r_2": 0.03}, T_z1=0.3, T_z2=0.4),
    _with_stage("stops", {"r_p1": 8e-3}, T_p1=0.1, T_p1y=0.4),
    _with_stage("stops-2/field", {"r_p1": 3e-3, "r_p2": 0.02}, T_q1y=0.3, T_q2y=0.4),
    _with_stage(
        "lugre", {"r_l": 8e-3, "h_l": 1.6, "w_l": 0.15}, T_l=0.1, T_ld=0.1, T_ly=0.4, T_ldy=0.1
    ),
    _with_stage("lugre/field", {"r_l": 8e-3, "h_l": 1.6, "w_l": 0.15}, T_ly=0.4, T_ldy=0.1),
    _with_stage(
        "lugre/field/sides",
        {"r_l": 8e-3, "h_l": 1.6, "w_l": 0.15, "a_l": 0.1},
        T_ly=0.4,
        T_ldy=0.1,
    ),
    _with_stage("bouc-wen", {"r_b": 8e-3, "beta_b": 0.7}, T_b=0.1, T_by=0.4),
    _with_stage("bouc-wen-2", {"r_b": 8e-3, "beta_b": 0.7}, T_b=0.1, T_by=0.4),
    _with_stage("hysteretic-tanh", {"w_t": 0.4, "t_w": 0.02, "tau_m": 0.3}, T_t=0.2, T_ty=0.5),
    _with_stage(
        "spencer",
        {
            "e_y": 0.3,
            "p_y": 0.1,
            "p_yb": 0.1,
            "q_y": 0.1,
            "q_yb": 0.6,
            "k_y": 3.0,
            "r_y": 8e-3,
            "beta_y": 0.7,
        },
        c_y=0.5,
    ),
)

TRUTHS = {
    truth.name: truth
    for truth in (
        Truth(
            "on-off", {"E_on": 0.41, **_DIRECTION}, {"T_on": 0.5, "eta": 0.15}, focus=(0.38, 0.44)
        ),
        Truth("quadratic", _DIRECTION, _TWO),
        Truth("bingham", {**_DIRECTION, **_POWER}, _TWO),
        Truth("bingham/critical", {**_DIRECTION, "E_c": 0.5}, _TWO),
        Truth(
            "eddy-current",
            {"w_s": 0.1, "w_c": 0.8, **_POWER},
            {"T_d": 0.5, "eta": 0.15, "T_f": 0.2},
        ),
        Truth("casson", {**_DIRECTION, "r": 0.3, **_POWER}, {"T_y": 0.5}),
        Truth("herschel-bulkley", {**_DIRECTION, "m": 0.7, **_POWER}, {"T_y": 0.5, "K": 0.15}),
        Truth("seo-seo", {**_DIRECTION, "a": 3.0, "b": 0.9, **_POWER}, {"T_sy": 0.5, "eta": 0.15}),
        Truth("cho-choi-jhon", _CCJ, _TWO),
        Truth(
            "hem", {**_DIRECTION, "kappa": 2.0, "beta": 1.6, **_POWER}, {"T_y": 0.5, "eta_0": 0.15}
        ),
        Truth(
            "rbfm-5",
            {**_DIRECTION, **_POWER},
            {"T_y": 0.5, "eta_0": 0.15, "k_2": 0.05, "k_3": -0.1, "k_4": 0.1, "k_5": 0.1},
            focus=(0.0, 0.1),
        ),
        Truth(
            "rbfm-10",
            {**_DIRECTION, **_POWER},
            {"T_y": 0.5, "eta_0": 0.15, **{f"k_{i}": 0.05 * (-1) ** i for i in range(2, 11)}},
            focus=(0.0, 0.1),
        ),
        Truth("bingham", {**_DIRECTION, **_POWER, "delay": 3.4e-3, "tau": 8e-3}, _TWO, "lag"),
        Truth(
            "bingham",
            {**_DIRECTION, **_POWER, "delay": 3.4e-3, "tau_rise": 6e-3, "tau_fall": 12e-3},
            _TWO,
            "rise-fall",
        ),
        *_STAGES,
        Truth("cho-choi-jhon", _CCJ, _TWO, noise=0.3, remark=" (loud)"),
    )
}


@dataclass(frozen=True)
class Coverage:
    """What the repetitions of one law with one noise came to.

    Attributes:
        name: law and dynamics.
        noise: which noise.
        repetitions: how many.
        inside: parameter -> how often the true value lay in its interval.
        error: parameter -> median relative error.
        bias: parameter -> mean error over the standard deviation of the estimates.
        width: parameter -> mean half width over what the estimates' scatter asks for: 1 is right, below is too narrow.
        converged: fits that met their tolerance.
        at_bounds: fits with a parameter on a bound.
    """

    name: str
    noise: Noise
    repetitions: int
    inside: Mapping[str, int]
    error: Mapping[str, float]
    bias: Mapping[str, float]
    width: Mapping[str, float]
    converged: int
    at_bounds: int

    @property
    def pooled(self) -> float:
        """Coverage over all parameters together."""
        return sum(self.inside.values()) / (self.repetitions * len(self.inside))

    @property
    def hit(self) -> bool:
        """Whether it is what the intervals promise, as far as the repetitions can tell."""
        return self.repetitions < ENOUGH or abs(self.pooled - TARGET) <= TOLERANCE + 1e-12


def inputs(truth: Truth, rows: int = ROWS) -> tuple[Element, Clock]:
    """Field and slip that excite the whole law, the same in each repetition.

    Fields are steps to random heights, off in a fifth of the cases; for dynamics they last 10 to 80 ms. Slips run
    through zero both ways and spend as long at a hundredth of their amplitude as near it, so that the sign's
    transition and the laws' low-slip branches are seen.
    """
    rng = np.random.default_rng(20240 + len(truth.dynamics))
    t = np.arange(float(rows)) * PERIOD
    shortest, longest = (3, 9) if truth.dynamics == "none" else (10, 80)
    widths = rng.integers(shortest, longest, rows)
    heights = rng.random(rows)
    if truth.focus is not None:
        heights = np.where(rng.random(rows) < 1 / 3, rng.uniform(*truth.focus, rows), heights)
    heights[rng.random(rows) < 0.2] = 0.0
    field = _LARGEST_FIELD * np.repeat(heights, widths)[:rows]
    swing = 0.6 * np.sin(2 * np.pi * 11.3 * t) + 0.4 * np.sin(2 * np.pi * 27.1 * t + 1.0)
    slip = _LARGEST_SLIP * np.sinh(_SINH * swing) / np.sinh(_SINH)
    return Element(field, slip), Clock(t, (Span(0, rows, PERIOD),))


def dataset(truth: Truth, rows: int = ROWS) -> tuple[Dataset, dict[str, float]]:
    """The rows without noise, and the true parameters in the data's units."""
    element, clock = inputs(truth, rows)
    units = Units("N*m", "V", "rad/s")
    blank = Dataset("single", (element,), np.zeros(rows), clock, units)
    reference = reference_of(blank)
    structure = truth.structure
    shapes, gains = structure.shapes(reference.period), structure.gains()
    everywhere = Range((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    model = TorqueModel(
        structure,
        reference,
        {s.name: truth.shape[s.name] for s in shapes},
        {g.name: truth.gains[g.name] for g in gains},
        units,
        everywhere,
    )
    true = {
        p.name: in_user_units({**truth.shape, **truth.gains}[p.name], p.dimension, reference)
        for p in (*shapes, *gains)
    }
    return Dataset("single", (element,), model.effort((element,), clock), clock, units), true


@cache
def _clean(name: str, rows: int) -> tuple[Dataset, dict[str, float]]:
    """`dataset` of a case, made once for all its repetitions."""
    return dataset(TRUTHS[name], rows)


def noise_of(kind: Noise, rng: np.random.Generator, rows: int) -> Array:
    """Unit noise: white, or with neighbours correlated as `CORRELATIONS` says."""
    rho = CORRELATIONS[kind]
    white = rng.standard_normal(rows)
    if kind == "white":
        return white
    from scipy.signal import lfilter

    innovation = white * np.sqrt(1 - rho**2)
    innovation[0] = white[0]  # stationary from the first row on
    return lfilter([1.0], [1.0, -rho], innovation)


@dataclass(frozen=True)
class _Fit:
    values: dict[str, float]
    low: dict[str, float]
    high: dict[str, float]
    converged: bool
    at_bounds: bool


def _fit(job: tuple[str, Noise, int, int]) -> _Fit:
    name, kind, repetition, rows = job
    truth = TRUTHS[name]
    clean, _ = _clean(name, rows)
    rng = np.random.default_rng([list(TRUTHS).index(name), kind != "white", repetition])
    effort = clean.effort + truth.noise * float(np.std(clean.effort)) * noise_of(kind, rng, rows)
    data = Dataset("single", clean.elements, effort, clean.clock, clean.units)
    structure = truth.structure
    with one_thread():
        outcome = fit_structure(data, structure)
    return _Fit(
        {e.name: e.value for e in outcome.estimates},
        {e.name: e.low for e in outcome.estimates},
        {e.name: e.high for e in outcome.estimates},
        outcome.converged,
        bool(outcome.at_bounds),
    )


def _summary(name: str, noise: Noise, fits: list[_Fit], rows: int) -> Coverage:
    _, true = _clean(name, rows)
    inside: dict[str, int] = {}
    error: dict[str, float] = {}
    bias: dict[str, float] = {}
    width: dict[str, float] = {}
    for parameter, value in true.items():
        estimates = np.array([f.values[parameter] for f in fits])
        low, high = (
            np.array([f.low[parameter] for f in fits]),
            np.array([f.high[parameter] for f in fits]),
        )
        scatter = float(np.std(estimates)) or 1.0
        # A parameter on a bound has no interval (nan): it counts as missed.
        inside[parameter] = int(np.sum((low <= value) & (value <= high)))
        error[parameter] = float(np.median(np.abs(estimates / value - 1)))
        bias[parameter] = float(np.mean(estimates) - value) / scatter
        width[parameter] = float(np.nanmean(high - low)) / 2 / (1.96 * scatter)
    return Coverage(
        name,
        noise,
        len(fits),
        inside,
        error,
        bias,
        width,
        sum(f.converged for f in fits),
        sum(f.at_bounds for f in fits),
    )


def study(
    laws: Iterable[str],
    noises: Iterable[Noise] = ("white", "ar1"),
    repetitions: int = 200,
    workers: int = 1,
    rows: int = ROWS,
) -> Iterator[Coverage]:
    """Coverage of each law with each noise, as it becomes known."""
    kinds: list[Noise] = list(noises)
    cases: list[tuple[str, Noise]] = [(name, kind) for name in laws for kind in kinds]
    if workers <= 1:
        for name, kind in cases:
            yield _summary(
                name, kind, [_fit((name, kind, i, rows)) for i in range(repetitions)], rows
            )
        return
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        running = [
            pool.map(
                _fit,
                [(name, kind, i, rows) for i in range(repetitions)],
                chunksize=max(1, repetitions // 8),
            )
            for name, kind in cases
        ]
        for (name, kind), fits in zip(cases, running, strict=True):
            yield _summary(name, kind, list(fits), rows)
