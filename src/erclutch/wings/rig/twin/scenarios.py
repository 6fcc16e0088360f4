"""The paper's runs on the twin say what is commanded, and for how long.

Sections III-B (training, test), IV-B (sine, square), IV-C (PD tracking), IV-D (zero field), IV-E (output held), V (two
encoders), and the 20 minutes of tracking over which the temperature was watched.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from erclutch._version import __version__
from erclutch.errors import SettingError, did_you_mean
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from erclutch.wings.rig.twin.excitation import (
    both_ways_torque,
    field_sequence,
    field_settings,
    half_sine_torque,
    held_peakedness,
    torque_sequence,
)
from erclutch.wings.rig.twin.kernel import OMEGA, SIZE
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.part_parameters import parts_of, single_clutch
from erclutch.wings.rig.twin.sampled_rows import LOGGED, TRUE, run_open, run_tracking
from erclutch.wings.rig.twin.twin import LABEL, PERIOD, substeps

_CHUNK = 2000  # rows that are simulated at once
_LONGEST = 24 * 3600.0  # [s]
_LARGEST = 1e15  # in SI: a log's number beyond comes of steps that are too long for the rig


@dataclass(frozen=True)
class Scenario:
    """One run.

    Attributes:
        name, meaning: what it is, with the paper's section.
        seconds: how long it lasts by default.
        excitation: what differs from the rig's own excitation in the field sequence; None is zero field.
        motor: makes the motor torque from (rows, generator, rig).
        locked: the output shaft is held.
        speed: initial speed of the motor in rad/s.
        tracking: frequency of a tracked sine in Hz, in place of a field sequence.
        changes: parameters of the rig that differ.
        single: CH1 alone, as a single device.
    """

    name: str
    meaning: str
    seconds: float
    excitation: Mapping[str, float] | None
    motor: _Motor
    locked: bool = False
    speed: float = 40.0
    tracking: float | None = None
    changes: Mapping[str, float] = field(default_factory=dict[str, float])
    single: bool = False


_Motor = Callable[[int, np.random.Generator, RigParameters], Array]


def _constant(rows: int, rng: np.random.Generator, rig: RigParameters) -> Array:
    return np.full(rows, 0.1)


def _own(rows: int, rng: np.random.Generator, rig: RigParameters) -> Array:
    settings = rig.section("excitation")
    return torque_sequence(
        rows, rng, settings["motor_low"], settings["motor_high"], settings=field_settings(rig)
    )


def _narrow(rows: int, rng: np.random.Generator, rig: RigParameters) -> Array:
    return torque_sequence(rows, rng, 0.05, 0.10, settings=field_settings(rig))


_EXCITED: Mapping[str, float] = {}
_LOOSE = {"screw.backlash": 1.0e-4}  # m: what an ordinary screw without preload has
_BRAKE = "CH1 alone, output shaft held"
_FLYWHEEL = "CH1 alone, driving a flywheel with friction"
_FREE = {"screw.half_stroke": 1e6, "screw.viscous": 5e-4}

SCENARIOS: Mapping[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("training", "data collection of III-B: 290,000 samples", 290.0, _EXCITED, _own),
        Scenario("test", "the same, shorter, for testing", 30.0, _EXCITED, _own),
        Scenario(
            "sine",
            "predefined sines at constant motor torque, IV-B",
            30.0,
            {"sines": 1.0},
            _constant,
        ),
        Scenario(
            "square",
            "predefined squares with random motor torque, IV-B",
            30.0,
            {"sines": 0.0},
            _narrow,
        ),
        Scenario(
            "tracking-slow", "PD tracking at 0.4 Hz, IV-C", 75.0, None, _constant, tracking=0.4
        ),
        Scenario("tracking-fast", "PD tracking at 2 Hz, IV-C", 15.0, None, _constant, tracking=2.0),
        Scenario(
            "zero-field",
            "no field, half-sine motor torque, IV-D",
            20.0,
            None,
            half_sine_torque,
            speed=1.0,
        ),
        Scenario("zero-motion", "output shaft held, IV-E", 20.0, _EXCITED, _narrow, locked=True),
        Scenario(
            "encoders",
            "linear and rotary encoder, no backlash, V",
            15.0,
            None,
            _constant,
            tracking=0.4,
        ),
        Scenario(
            "encoders-backlash",
            "the same with 0.1 mm of backlash",
            15.0,
            None,
            _constant,
            tracking=0.4,
            changes=_LOOSE,
        ),
        Scenario(
            "temperature",
            "20 minutes of tracking at 2 Hz, IV-C",
            1200.0,
            None,
            _constant,
            tracking=2.0,
        ),
        Scenario(
            "brake",
            _BRAKE,
            60.0,
            _EXCITED,
            lambda rows, rng, rig: both_ways_torque(rows, rng),
            locked=True,
            speed=0.0,
            single=True,
        ),
        Scenario("clutch", _FLYWHEEL, 60.0, _EXCITED, _own, changes=_FREE, single=True),
    )
}

#: Gains of equation (23) on the twin, per rad and per rad/s of the screw; the paper prints none and tuned none.
GAINS = np.array([0.08, 2.0e-3])
_AMPLITUDE = 0.02  # m: of the tracked sine
_NO_SIGNALS = ("time", "table", "alpha_rotary")


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
        """The log, stretch by stretch, each of shape (rows, names): what a rig logs, what only a twin knows.

        Raises:
            SettingError: a rig whose numbers grow without end.
        """
        state = np.zeros(SIZE)
        state[OMEGA] = self.scenario.speed
        step = _stepper(self.scenario, self.rig, self.rows, self.seed)
        turn = 2.0 * np.pi / self.rig.value("screw.lead")
        for first in range(0, self.rows, _CHUNK):
            at = slice(first, min(first + _CHUNK, self.rows))
            out = np.zeros((at.stop - first, len(LOGGED) + len(TRUE)))
            step(state, at, out)
            if not (np.abs(out) <= _LARGEST).all():
                problem = (
                    f"the TWIN's numbers grow beyond {_LARGEST:g} within {at.stop * PERIOD:g} s"
                )
                remedy = "Correct the rig, or make integration.step shorter"
                raise SettingError(problem, remedy=remedy, where=self.rig.name)
            time = np.arange(first, at.stop) * PERIOD
            field, motor, theta, table, rotary = (out[:, place] for place in (0, 2, 3, 4, 5))
            if self.scenario.single:
                position = theta - rotary
                parts = [time, field, motor, position, out[:, 6:13], out[:, 14]]
            else:
                alpha = table * turn
                parts = [time, out[:, :4], alpha, out[:, 4:]]
            yield np.column_stack(parts).astype(np.float64)

    def columns(self) -> dict[str, tuple[str, Array]]:
        """The whole log by column, with units."""
        rows = np.concatenate(list(self.chunks()))
        columns: dict[str, tuple[str, Array]] = {}
        for place, (name, unit) in enumerate(self.names):
            columns[name] = (unit, rows[:, place])
        return columns

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each column."""
        return SINGLE_COLUMNS if self.scenario.single else COLUMNS

    def recording(self) -> Recording:
        """The log as it would be read from a file, without the columns that only a twin knows."""
        columns = self.columns()
        no_unit = "?" if self.scenario.single else ""
        signals: dict[str, Array] = {}
        units: dict[str, str] = {}
        for name, (unit, values) in columns.items():
            if not name.startswith("true_") and name not in _NO_SIGNALS:
                signals[name] = values
                units[name] = unit or no_unit
        _, time = columns["time"]
        return Recording(
            name=f"{self.scenario.name}, seed {self.seed}",
            signals=signals,
            units=units,
            time=time,
            period=PERIOD,
            segments=((0, self.rows),),
            uniform=True,
            digest="",
            origin=LABEL,
        )

    def about(self) -> dict[str, object]:
        """Label, settings and parameters, as JSON values."""
        return {
            "label": LABEL,
            "device": "single" if self.scenario.single else "coaxial",
            "scenario": self.scenario.name,
            "meaning": self.scenario.meaning,
            "seed": self.seed,
            "rows": self.rows,
            "erclutch": __version__,
            "rig": {"name": self.rig.name, **self.rig.to_dict()},
        }


#: Columns of a twin's log. alpha is the table's position as an angle of the screw, equation (4).
COLUMNS = (("time", "s"), *LOGGED[:4], ("alpha", "rad"), *LOGGED[4:], *TRUE)
#: Of a single clutch or brake; position is the angle of the housing against the rotor.
SINGLE_COLUMNS = (
    ("time", "s"),
    ("field", ""),
    ("motor_torque", "N*m"),
    ("position", "rad"),
    ("effort", "N*m"),
    *TRUE[:6],
    TRUE[7],
)


def prepare(
    name: str,
    *,
    rig: RigParameters | None = None,
    seconds: float | None = None,
    seed: int = 0,
) -> TwinRun:
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
        hint = did_you_mean(name, SCENARIOS)
        raise SettingError(
            f"there is no scenario {name!r}", remedy=f"{hint}Choose one of {', '.join(SCENARIOS)}"
        )
    scenario = SCENARIOS[name]
    length = scenario.seconds if seconds is None else seconds
    if not 0.1 <= length <= _LONGEST or seed < 0:
        raise SettingError(
            f"{length:g} s with seed {seed}",
            remedy=f"Give 0.1 to {_LONGEST:g} s and a seed of 0 or more",
        )
    changed = (rig or default_rig()).changed(scenario.changes)
    return TwinRun(scenario, changed, seed, round(length / PERIOD))


_Stepper = Callable[[Array, slice, Array], None]


def _stepper(
    scenario: Scenario,
    rig: RigParameters,
    rows: int,
    seed: int,
) -> _Stepper:
    """Runs a slice of the rows from a state, and fills what is logged and what is true."""
    # The order of the draws is part of what a seed means: field, motor, noise.
    rng = np.random.default_rng(seed)
    wanted = np.zeros(rows)
    if scenario.excitation is not None:
        drawn = dict(scenario.excitation)
        if scenario.locked and not scenario.single:
            drawn["peakedness"] = held_peakedness(rig)
        wanted = field_sequence(rows, rng, field_settings(rig, **drawn))
    motor = scenario.motor(rows, rng, rig)
    noise = rng.standard_normal(rows)
    parts = parts_of(rig)
    steps = substeps(rig)
    dt = PERIOD / steps
    if scenario.tracking:
        # The tracked sine and its speed.
        omega = 2.0 * np.pi * scenario.tracking
        phase = omega * np.arange(rows) * PERIOD
        share = 5.0 if omega > 2 * np.pi else 1.0  # beyond 1 Hz a fifth of the way
        height = _AMPLITUDE / share * 2.0 * np.pi / rig.value("screw.lead")
        sine = height * np.sin(phase)
        speed = height * omega * np.cos(phase)
        tracked = np.column_stack([motor, noise, sine, speed])
        memory = np.array([np.nan])
        return lambda state, at, out: run_tracking(
            state, parts, tracked[at], GAINS, memory, dt, steps, out
        )
    stroke = rig.value("screw.half_stroke") / rig.value("screw.lead") * 2.0 * np.pi
    locked = scenario.locked
    guard = np.zeros(2)
    soft = 0.0 if locked or scenario.single else 0.18 * stroke
    if scenario.single:
        wanted = np.abs(wanted)
        parts = single_clutch(parts)
    commands = np.column_stack([wanted, motor, noise])
    return lambda state, at, out: run_open(
        state, parts, commands[at], locked, soft, guard, dt, steps, out
    )
