"""The runs of the paper on the twin: what is commanded in each, and for how long.

Sections III-B (training, test), IV-B (sine, square), IV-C (PD tracking), IV-D (zero field), IV-E (output held), V (two
encoders), and the 20 minutes of tracking over which the temperature was watched.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from erclutch._version import __version__
from erclutch.errors import SettingError
from erclutch.rig.excitation import FieldSettings, field_sequence, half_sine_torque, torque_sequence
from erclutch.rig.kernel import OMEGA, SIZE
from erclutch.rig.loop import LOGGED, TRUE, run_open, run_tracking
from erclutch.rig.parameters import RigParameters, default_rig
from erclutch.rig.parts import parts_of
from erclutch.rig.twin import LABEL, PERIOD, substeps

Array = NDArray[np.float64]

_CHUNK = 2000
_LONGEST = 24 * 3600.0


@dataclass(frozen=True)
class Scenario:
    """One run.

    Attributes:
        name, meaning: what it is, with the paper's section.
        seconds: how long it lasts by default.
        excitation: settings of the field sequence; None is zero field.
        motor: makes the motor torque from (rows, generator).
        locked: the output shaft is held.
        speed: initial speed of the motor in rad/s.
        tracking: frequency of a tracked sine in Hz, in place of a field sequence.
        changes: parameters of the rig that differ.
    """

    name: str
    meaning: str
    seconds: float
    excitation: FieldSettings | None
    motor: Callable[[int, np.random.Generator], Array]
    locked: bool = False
    speed: float = 40.0
    tracking: float | None = None
    changes: Mapping[str, float] = field(default_factory=dict[str, float])


def _constant(rows: int, rng: np.random.Generator) -> Array:
    return np.full(rows, 0.1)


def _narrow(rows: int, rng: np.random.Generator) -> Array:
    return torque_sequence(rows, rng, 0.05, 0.10)


_EXCITED = FieldSettings()
_BACKLASH = 1.0e-4  # m: what an ordinary screw without preload has

SCENARIOS: Mapping[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("training", "data collection of III-B: 290,000 samples", 290.0, _EXCITED, torque_sequence),
        Scenario("test", "the same, shorter, for testing", 30.0, _EXCITED, torque_sequence),
        Scenario(
            "sine", "predefined sines at constant motor torque, IV-B", 30.0, replace(_EXCITED, sines=1.0), _constant
        ),
        Scenario(
            "square", "predefined squares with random motor torque, IV-B", 30.0, replace(_EXCITED, sines=0.0), _narrow
        ),
        Scenario("tracking-slow", "PD tracking at 0.4 Hz, IV-C", 75.0, None, _constant, tracking=0.4),
        Scenario("tracking-fast", "PD tracking at 2 Hz, IV-C", 15.0, None, _constant, tracking=2.0),
        Scenario("zero-field", "no field, half-sine motor torque, IV-D", 20.0, None, half_sine_torque, speed=1.0),
        Scenario("zero-motion", "output shaft held, IV-E", 20.0, _EXCITED, _narrow, locked=True),
        Scenario("encoders", "linear and rotary encoder, no backlash, V", 15.0, None, _constant, tracking=0.4),
        Scenario(
            "encoders-backlash",
            "the same with 0.1 mm of backlash",
            15.0,
            None,
            _constant,
            tracking=0.4,
            changes={"screw.backlash": _BACKLASH},
        ),
        Scenario("temperature", "20 minutes of tracking at 2 Hz, IV-C", 1200.0, None, _constant, tracking=2.0),
    )
}

#: Gains of equation (23) on the twin, per rad and per rad/s of the screw; the paper prints none and tuned none.
GAINS = np.array([0.08, 2.0e-3])
_AMPLITUDE = 0.02  # m: of the tracked sine


@dataclass(frozen=True)
class TwinRun:
    """A scenario that is about to run.

    Attributes:
        scenario, rig, seed: what is run.
        rows: how many rows it gives.
    """

    scenario: Scenario
    rig: RigParameters
    seed: int
    rows: int

    def chunks(self) -> Iterator[Array]:
        """The log, stretch by stretch, each of shape (rows, 17): time, what a rig logs, what only a twin knows."""
        state = np.zeros(SIZE)
        state[OMEGA] = self.scenario.speed
        start = _tracking if self.scenario.tracking else _open
        stepper = start(self.scenario, self.rig, self.rows, self.seed)
        turn = 2.0 * np.pi / self.rig.value("screw.lead")
        for first in range(0, self.rows, _CHUNK):
            at = slice(first, min(first + _CHUNK, self.rows))
            logged, true = np.zeros((at.stop - first, len(LOGGED))), np.zeros((at.stop - first, len(TRUE)))
            stepper(state, at, logged, true)
            time, alpha = np.arange(first, at.stop) * PERIOD, logged[:, 4] * turn
            yield np.column_stack([time, logged[:, :4], alpha, logged[:, 4:], true]).astype(np.float64)

    def columns(self) -> dict[str, tuple[str, Array]]:
        """The whole log by column, with units."""
        rows = np.concatenate(list(self.chunks()))
        return {name: (unit, rows[:, i]) for i, (name, unit) in enumerate(COLUMNS)}

    def about(self) -> dict[str, object]:
        """Label, settings and parameters, as JSON values."""
        return {
            "label": LABEL,
            "scenario": self.scenario.name,
            "meaning": self.scenario.meaning,
            "seed": self.seed,
            "rows": self.rows,
            "erclutch": __version__,
            "rig": {"name": self.rig.name, **self.rig.to_dict()},
        }


#: Columns of a twin's log. alpha is the table's position as an angle of the screw, equation (4).
COLUMNS = (("time", "s"), *LOGGED[:4], ("alpha", "rad"), *LOGGED[4:], *TRUE)


def prepare(name: str, *, rig: RigParameters | None = None, seconds: float | None = None, seed: int = 0) -> TwinRun:
    """A run of a scenario on the twin.

    Args:
        name: one of `SCENARIOS`.
        rig: parameters; None is the default rig.
        seconds: rig time; None is the scenario's own.
        seed: of the commands and the noise.

    Raises:
        SettingError: an unknown scenario, or a length that is not above 0 or beyond a day.
    """
    if name not in SCENARIOS:
        raise SettingError(f"there is no scenario {name!r}", remedy=f"Choose one of {', '.join(SCENARIOS)}")
    scenario = SCENARIOS[name]
    length = scenario.seconds if seconds is None else seconds
    if not 0.1 <= length <= _LONGEST or seed < 0:
        raise SettingError(
            f"{length:g} s with seed {seed}", remedy=f"Give 0.1 to {_LONGEST:g} s and a seed of 0 or more"
        )
    return TwinRun(scenario, (rig or default_rig()).changed(scenario.changes), seed, round(length / PERIOD))


_Stepper = Callable[[Array, slice, Array, Array], None]


def _open(scenario: Scenario, rig: RigParameters, rows: int, seed: int) -> _Stepper:
    rng = np.random.default_rng(seed)
    wanted = np.zeros(rows) if scenario.excitation is None else field_sequence(rows, rng, scenario.excitation)
    motor, noise = scenario.motor(rows, rng), rng.standard_normal(rows)
    parts, steps, guard = parts_of(rig), substeps(rig), np.zeros(2)
    soft = 0.0 if scenario.locked else 0.18 * rig.value("screw.half_stroke") / rig.value("screw.lead") * 2.0 * np.pi

    def step(state: Array, at: slice, logged: Array, true: Array) -> None:
        run_open(
            state,
            parts,
            wanted[at],
            motor[at],
            noise[at],
            scenario.locked,
            soft,
            guard,
            PERIOD / steps,
            steps,
            logged,
            true,
        )

    return step


def _tracking(scenario: Scenario, rig: RigParameters, rows: int, seed: int) -> _Stepper:
    rng = np.random.default_rng(seed)
    motor, noise = scenario.motor(rows, rng), rng.standard_normal(rows)
    omega = 2.0 * np.pi * (scenario.tracking or 1.0)
    phase = omega * np.arange(rows) * PERIOD
    height = _AMPLITUDE / (5.0 if omega > 2 * np.pi else 1.0) * 2.0 * np.pi / rig.value("screw.lead")
    reference = np.column_stack([height * np.sin(phase), height * omega * np.cos(phase)])
    parts, steps, memory = parts_of(rig), substeps(rig), np.array([np.nan])

    def step(state: Array, at: slice, logged: Array, true: Array) -> None:
        run_tracking(
            state, parts, reference[at], motor[at], noise[at], GAINS, memory, PERIOD / steps, steps, logged, true
        )

    return step
