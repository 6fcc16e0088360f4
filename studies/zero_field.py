"""Why the laws miss the drag at zero field: `python studies/zero_field.py [--seeds 5] [--seconds 60]`. TWIN.

The first table switches effects of the TWIN off, each in turn: does the drag at zero field change, does the fitted law
follow it? The second table fits the Bingham law to other rows and other torques of the same training run: what hides
the viscous drag from a fit? The third table changes the one number that makes the drag, and prints the errors of four
laws beside the paper's.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.tables import BASE, law_fit, rows_of
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.scenarios import prepare

LAWS = (BASE, "seo-seo/forward", "hem/forward", "rbfm-10/forward")

#: What is switched off, and how: a parameter at a value at which its effect is gone or as small as its range allows.
SWITCHED_OFF: Mapping[str, Mapping[str, float]] = {
    "nothing": {},
    "difference of the clutches": {"clutch.viscosity_2": 1.0},
    "seals": {"clutch.seal_1": 0.0002, "clutch.seal_2": 0.0002},
    "thinning of the fluid": {"fluid.thinning": 0.1},
    "structure that decays": {"fluid.decay_time": 0.0005, "fluid.building_time": 0.0005},
    "yield stress without field": {"fluid.residual_yield": 0.1},
    "heat": {"thermal.thinning": 0.0},
    "friction of the screw": {"screw.coulomb": 0.001, "screw.breakaway": 1.0},
    "rotors ahead of the meter": {"screw.rotor_inertia": 6e-6},
}

#: A slip below which a housing and the rotor move as one, rad/s.
STUCK = 2.0


def mean_square(errors: NDArray[np.float64]) -> float:
    """Mean of the squares."""
    return float(np.mean(errors**2))


def zero_field(rig: RigParameters, seeds: int) -> list[Dataset]:
    """Runs of section IV-D, none of them seen by a fit."""
    return [rows_of(prepare("zero-field", rig=rig, seed=3000 + seed)) for seed in range(seeds)]


def drags(model: TorqueModel, runs: Sequence[Dataset]) -> tuple[float, float, float]:
    """Root mean square of the measured torque and of the model's, N m, and the factor between both."""
    measured = np.concatenate([run.effort for run in runs])
    said = np.concatenate([model.predict(run) for run in runs])
    factor = float(measured @ said) / (float(said @ said) or 1.0)
    return float(np.sqrt(mean_square(measured))), float(np.sqrt(mean_square(said))), factor


def effects(seeds: int, seconds: float) -> None:
    """What makes the drag at zero field."""
    print("| switched off | measured at zero field [mN m] | Bingham says | measured over said | fastest slip [rad/s] |")
    print("| --- | --- | --- | --- | --- |")
    for name, changes in SWITCHED_OFF.items():
        rig = default_rig().changed(changes)
        model = law_fit(rows_of(prepare("training", rig=rig, seed=1, seconds=seconds)), BASE).model
        runs = zero_field(rig, seeds)
        measured, said, factor = drags(model, runs)
        fastest = max(float(np.abs(run.elements[0].slip).max()) for run in runs)
        print(f"| {name} | {1e3 * measured:.1f} | {1e3 * said:.1f} | {factor:.2f} | {fastest:.0f} |", flush=True)


def what_hides_it(seeds: int, seconds: float) -> None:
    """Which rows and which torque of the training run let a fit see the viscous drag."""
    run = prepare("training", seed=1, seconds=seconds)
    train = rows_of(run)
    skipped = run.rows - train.rows
    fluid_torque = run.columns()["true_torque"][1][skipped:]
    slips = [np.abs(element.slip) for element in train.elements]
    fields = np.array([element.field for element in train.elements])
    engaged = fields.max(axis=0) > 0.1
    slip_there = np.where(fields[0] > fields[1], slips[0], slips[1])
    print(f"rows with a command above 0.1 at which the clutch sticks: {np.mean(slip_there[engaged] < STUCK):.0%}")
    stronger = default_rig().changed({"excitation.motor_low": 0.2, "excitation.motor_high": 0.6})
    fitted_to: dict[str, Dataset] = {
        "all rows, torque at the meter": train,
        "all rows, torque of the fluid (true)": replace(train, effort=fluid_torque),
        "rows of small command, meter": train.take(fields.max(axis=0) < 0.02),
        "rows of small command, torque of the fluid": replace(train, effort=fluid_torque).take(
            fields.max(axis=0) < 0.02
        ),
        "a motor that is four times stronger, meter": rows_of(
            prepare("training", rig=stronger, seed=1, seconds=seconds)
        ),
    }
    runs = zero_field(default_rig(), seeds)
    print("| Bingham fitted to | said at zero field [mN m] | measured over said | error [1e-5 N2 m2] |")
    print("| --- | --- | --- | --- |")
    for name, rows in fitted_to.items():
        model = law_fit(rows, BASE).model
        _, said, factor = drags(model, runs)
        error = np.mean([mean_square(run.effort - model.predict(run)) for run in runs])
        print(f"| {name} | {1e3 * said:.1f} | {factor:.2f} | {1e5 * error:.1f} |", flush=True)


def one_number(seeds: int, seconds: float) -> None:
    """Errors of four laws at zero field, over the viscosity of the second clutch."""
    print(f"| viscosity of CH2 over CH1 | {' | '.join(LAWS)} | training, {BASE} | ratio of seo-seo |")
    print(f"|{' --- |' * (len(LAWS) + 3)}")
    for viscosity in (default_rig().value("clutch.viscosity_2"), 0.78, 0.80, 0.82, 0.86):
        rig = default_rig().changed({"clutch.viscosity_2": viscosity})
        train = rows_of(prepare("training", rig=rig, seed=1, seconds=seconds))
        runs = zero_field(rig, seeds)
        models = {name: law_fit(train, name).model for name in LAWS}
        at_zero = [np.mean([mean_square(run.effort - m.predict(run)) for run in runs]) for m in models.values()]
        errors = [mean_square(train.effort - m.predict(train)) for m in models.values()]
        cells = " | ".join(f"{1e5 * error:.1f}" for error in at_zero)
        print(f"| {viscosity:.2f} | {cells} | {1e5 * errors[0]:.1f} | {errors[1] / errors[0]:.3f} |", flush=True)
    theirs = [APPROACHES[name] for name in LAWS]
    cells = " | ".join("-" if known.zero_field is None else f"{1e5 * known.zero_field:.1f}" for known in theirs)
    print(f"| paper | {cells} | {1e5 * theirs[0].train:.1f} | {theirs[1].train / theirs[0].train:.3f} |")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Why the laws miss the drag at zero field, on the digital TWIN.")
    parser.add_argument("--seeds", type=int, default=5, help="runs at zero field")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the training run")
    asked = parser.parse_args()
    print(f"TWIN; training {asked.seconds:g} s (seed 1), {asked.seeds} runs at zero field of 20 s each\n")
    effects(asked.seeds, asked.seconds)
    print()
    what_hides_it(asked.seeds, asked.seconds)
    print()
    one_number(asked.seeds, asked.seconds)


if __name__ == "__main__":
    main()
