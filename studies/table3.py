"""Why the laws miss table III on the digital TWIN: `python studies/table3.py [--seeds 5] [--seconds 60]`.

`--run zero-field`. The first table switches effects of the TWIN off, each in turn: does the drag at zero field change,
does the fitted law follow it? The second table fits the Bingham law to other rows and other torques of the same
training run: what hides the viscous drag from a fit? The third table changes the one number that makes the drag, and
prints the errors of four laws beside the paper's.

`--run zero-motion`. The first table compares what training and held output show, by field. The second switches effects
off. The third trains on other runs: what must a training run hold so that a model knows the held output?

`--run pictures` draws docs/images/table3-zero-field.svg and table3-zero-motion.svg.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

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

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
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
    estimated = np.concatenate([model.predict(run) for run in runs])
    factor = float(measured @ estimated) / (float(estimated @ estimated) or 1.0)
    return float(np.sqrt(mean_square(measured))), float(np.sqrt(mean_square(estimated))), factor


def effects(seeds: int, seconds: float) -> None:
    """What makes the drag at zero field."""
    print(
        "| switched off | measured at zero field [mN m] | Bingham says | measured over said | fastest slip [rad/s] |"
    )
    print("| --- | --- | --- | --- | --- |")
    for name, changes in SWITCHED_OFF.items():
        rig = default_rig().changed(changes)
        model = law_fit(rows_of(prepare("training", rig=rig, seed=1, seconds=seconds)), BASE).model
        runs = zero_field(rig, seeds)
        measured, estimated, factor = drags(model, runs)
        fastest = max(float(np.abs(run.elements[0].slip).max()) for run in runs)
        torques = f"{1e3 * measured:.1f} | {1e3 * estimated:.1f}"
        print(f"| {name} | {torques} | {factor:.2f} | {fastest:.0f} |", flush=True)


def meter_and_fluid(seconds: float) -> tuple[Dataset, Dataset]:
    """The training run with the torque at the meter, and with the fluid's true one."""
    run = prepare("training", seed=1, seconds=seconds)
    at_meter = rows_of(run)
    skipped = run.rows - at_meter.rows
    _, true_torque = run.columns()["true_torque"]
    return at_meter, replace(at_meter, effort=true_torque[skipped:])


def what_hides_it(seeds: int, seconds: float) -> None:
    """Which rows and which torque of the training run let a fit see the viscous drag."""
    train, of_fluid = meter_and_fluid(seconds)
    slips = [np.abs(element.slip) for element in train.elements]
    fields = np.array([element.field for element in train.elements])
    largest = fields.max(axis=0)
    engaged = largest > 0.1
    slip_there = np.where(fields[0] > fields[1], slips[0], slips[1])
    print(
        f"rows with a command above 0.1 at which the clutch sticks: {np.mean(slip_there[engaged] < STUCK):.0%}"
    )
    small = largest < 0.02
    stronger = default_rig().changed({"excitation.motor_low": 0.2, "excitation.motor_high": 0.6})
    strong_run = prepare("training", rig=stronger, seed=1, seconds=seconds)
    fitted_to: dict[str, Dataset] = {
        "all rows, torque at the meter": train,
        "all rows, torque of the fluid (true)": of_fluid,
        "rows of small command, meter": train.take(small),
        "rows of small command, torque of the fluid": of_fluid.take(small),
        "a motor that is four times stronger, meter": rows_of(strong_run),
    }
    runs = zero_field(default_rig(), seeds)
    print(
        "| Bingham fitted to | said at zero field [mN m] | measured over said | error [1e-5 N2 m2] |"
    )
    print("| --- | --- | --- | --- |")
    for name, rows in fitted_to.items():
        model = law_fit(rows, BASE).model
        _, estimated, factor = drags(model, runs)
        error = np.mean([mean_square(run.effort - model.predict(run)) for run in runs])
        print(f"| {name} | {1e3 * estimated:.1f} | {factor:.2f} | {1e5 * error:.1f} |", flush=True)


def one_number(seeds: int, seconds: float) -> None:
    """Errors of four laws at zero field, over the viscosity of the second clutch."""
    print(
        f"| viscosity of CH2 over CH1 | {' | '.join(LAWS)} | training, {BASE} | ratio of seo-seo |"
    )
    print(f"|{' --- |' * (len(LAWS) + 3)}")
    for viscosity in (default_rig().value("clutch.viscosity_2"), 0.78, 0.80, 0.82, 0.86):
        rig = default_rig().changed({"clutch.viscosity_2": viscosity})
        train = rows_of(prepare("training", rig=rig, seed=1, seconds=seconds))
        runs = zero_field(rig, seeds)
        models = {name: law_fit(train, name).model for name in LAWS}
        at_zero = [
            np.mean([mean_square(run.effort - m.predict(run)) for run in runs])
            for m in models.values()
        ]
        errors = [mean_square(train.effort - m.predict(train)) for m in models.values()]
        cells = " | ".join(f"{1e5 * error:.1f}" for error in at_zero)
        print(
            f"| {viscosity:.2f} | {cells} | {1e5 * errors[0]:.1f} | {errors[1] / errors[0]:.3f} |",
            flush=True,
        )
    theirs = [APPROACHES[name] for name in LAWS]
    cells = " | ".join(
        "-" if known.zero_field is None else f"{1e5 * known.zero_field:.1f}" for known in theirs
    )
    print(
        f"| paper | {cells} | {1e5 * theirs[0].train:.1f} | {theirs[1].train / theirs[0].train:.3f} |"
    )


#: What is switched off or made another, for the run with the output held.
HELD_CHANGES: Mapping[str, Mapping[str, float]] = {
    "nothing": {},
    "difference of the clutches": {"clutch.viscosity_2": 1.0},
    "seals": {"clutch.seal_1": 0.0002, "clutch.seal_2": 0.0002},
    "thinning of the fluid": {"fluid.thinning": 0.1},
    "thickening by the field": {"fluid.field_thickening": 0.0},
    "breaking of the structure": {"fluid.breaking_rate": 2e6},
    "structure that builds and decays": {"fluid.decay_time": 0.0005, "fluid.building_time": 0.0005},
    "rotors ahead of the meter": {"screw.rotor_inertia": 6e-6},
    "half of the inertia of motor and housings": {"drive.inertia": 1.15e-4},
    "a load five times heavier": {"screw.load_inertia": 8e-5},
}


def law_errors(train: Dataset, runs: Sequence[Dataset]) -> str:
    """Errors of four laws over runs, 1e-5 N^2 m^2, as cells of a table."""
    models = [law_fit(train, name).model for name in LAWS]
    errors = [
        np.mean([mean_square(run.effort - model.predict(run)) for run in runs]) for model in models
    ]
    return " | ".join(f"{1e5 * error:.0f}" for error in errors)


def held(rig: RigParameters, seeds: int) -> list[Dataset]:
    """Runs of section IV-E, none of them seen by a fit."""
    return [rows_of(prepare("zero-motion", rig=rig, seed=3000 + seed)) for seed in range(seeds)]


def by_field(seeds: int, seconds: float) -> None:
    """Slip and torque of training and of the held output, and what Bingham says, over the command."""
    train = rows_of(prepare("training", seed=1, seconds=seconds))
    model = law_fit(train, BASE).model
    print(
        "| command | run | share of rows | slip, median [rad/s] | torque measured, mean [mN m] | Bingham says |"
    )
    print("| --- | --- | --- | --- | --- | --- |")
    for low, high in ((0.02, 0.1), (0.1, 0.2), (0.2, 0.3), (0.3, 0.5)):
        for name, runs in (("training", [train]), ("output held", held(default_rig(), seeds))):
            fields = np.concatenate([[e.field for e in run.elements] for run in runs], axis=1)
            slips = np.concatenate([[np.abs(e.slip) for e in run.elements] for run in runs], axis=1)
            first = fields[0] > fields[1]
            largest = fields.max(axis=0)
            there = (low <= largest) & (largest < high)
            way = np.where(first, 1.0, -1.0)[there]  # in which the engaged clutch drives
            measured = np.concatenate([run.effort for run in runs])[there] * way
            estimated = np.concatenate([model.predict(run) for run in runs])[there] * way
            slip = np.where(first, slips[0], slips[1])[there]
            cells = f"{np.mean(there):.0%} | {np.median(slip):.1f} | {1e3 * measured.mean():.1f}"
            print(
                f"| {low:g} to {high:g} | {name} | {cells} | {1e3 * estimated.mean():.1f} |",
                flush=True,
            )


def held_effects(seeds: int, seconds: float) -> None:
    """What makes the error with the output held."""
    print(f"| switched off, or made another | measured [mN m] | {' | '.join(LAWS)} |")
    print(f"|{' --- |' * (len(LAWS) + 2)}")
    for name, changes in HELD_CHANGES.items():
        rig = default_rig().changed(changes)
        train = rows_of(prepare("training", rig=rig, seed=1, seconds=seconds))
        runs = held(rig, seeds)
        measured = np.sqrt(np.mean([mean_square(run.effort) for run in runs]))
        print(f"| {name} | {1e3 * measured:.0f} | {law_errors(train, runs)} |", flush=True)
    print(
        f"| paper | - | {' | '.join(f'{1e5 * (APPROACHES[name].zero_motion or 0.0):.0f}' for name in LAWS)} |"
    )


def held_training(seeds: int, seconds: float) -> None:
    """Which training run lets a law know the held output."""
    rig = default_rig()
    train, of_fluid = meter_and_fluid(seconds)
    stronger = rig.changed({"excitation.motor_low": 0.2, "excitation.motor_high": 0.6})
    even = rig.changed({"excitation.peakedness": 1.0})
    trained: dict[str, Dataset] = {
        "training run, meter": train,
        "training run, torque of the fluid (true)": of_fluid,
        "a motor that is four times stronger": rows_of(
            prepare("training", rig=stronger, seed=1, seconds=seconds)
        ),
        "amplitudes of the field drawn evenly": rows_of(
            prepare("training", rig=even, seed=1, seconds=seconds)
        ),
        "output held, another seed": rows_of(prepare("zero-motion", seed=1, seconds=seconds)),
    }
    runs = held(rig, seeds)
    print(f"| fitted to | {' | '.join(LAWS)} |")
    print(f"|{' --- |' * (len(LAWS) + 1)}")
    for name, rows in trained.items():
        print(f"| {name} | {law_errors(rows, runs)} |", flush=True)


def over(
    bins: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean of y between the edges of bins over x; nan where there are fewer than 30 rows."""
    inside = [(x >= low) & (x < high) for low, high in pairwise(bins)]
    return np.array([y[rows].mean() if rows.sum() >= 30 else np.nan for rows in inside])


def pictures(seeds: int, seconds: float) -> None:
    """Torque over speed at zero field, and over the command with the output held."""
    import matplotlib
    from matplotlib.figure import Figure

    matplotlib.rcParams.update({"svg.hashsalt": "erclutch", "svg.fonttype": "none", "font.size": 8})
    train = rows_of(prepare("training", seed=1, seconds=seconds))
    model = law_fit(train, BASE).model

    speeds = np.arange(0.0, 280.0, 10.0)
    figure = Figure(figsize=(4.2, 2.8), layout="constrained")
    axes = figure.subplots()
    for colour, viscosity in (("C0", default_rig().value("clutch.viscosity_2")), ("C1", 0.79)):
        runs = zero_field(default_rig().changed({"clutch.viscosity_2": viscosity}), seeds)
        speed = np.concatenate(
            [0.5 * np.abs(run.elements[0].slip - run.elements[1].slip) for run in runs]
        )
        measured = 1e3 * over(speeds, speed, np.concatenate([run.effort for run in runs]))
        axes.plot(
            speeds[:-1] + 5.0, measured, colour, label=f"measured, CH2 {viscosity:.2f} of CH1"
        )
        if colour == "C0":
            said = 1e3 * over(speeds, speed, np.concatenate([model.predict(run) for run in runs]))
            axes.plot(speeds[:-1] + 5.0, said, "k--", label="Bingham, fitted to the training run")
    axes.set(
        xlabel="speed of the housings [rad/s]",
        ylabel="torque at the meter [mN m]",
        title="TWIN, no field",
    )
    axes.legend(frameon=False)
    figure.savefig(IMAGES / "table3-zero-field.svg", metadata={"Date": None})

    commands = np.linspace(0.0, 0.5, 21)
    figure = Figure(figsize=(4.2, 2.8), layout="constrained")
    axes = figure.subplots()
    for colour, name, runs in (
        ("C0", "output held", held(default_rig(), seeds)),
        ("C1", "training run", [train]),
    ):
        fields = np.concatenate([[e.field for e in run.elements] for run in runs], axis=1)
        way = np.where(fields[0] > fields[1], 1.0, -1.0)
        measured = np.concatenate([run.effort for run in runs]) * way
        axes.plot(
            commands[:-1],
            1e3 * over(commands, fields.max(axis=0), measured),
            colour,
            label=f"measured, {name}",
        )
        if name == "output held":
            said = np.concatenate([model.predict(run) for run in runs]) * way
            axes.plot(
                commands[:-1],
                1e3 * over(commands, fields.max(axis=0), said),
                "k--",
                label="Bingham there",
            )
    axes.set(xlabel="command", ylabel="mean torque at the meter [mN m]", title="TWIN")
    axes.legend(frameon=False)
    figure.savefig(IMAGES / "table3-zero-motion.svg", metadata={"Date": None})


TABLES = {
    "pictures": (pictures,),
    "zero-field": (effects, what_hides_it, one_number),
    "zero-motion": (by_field, held_effects, held_training),
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description="Why the laws miss table III, on the digital TWIN."
    )
    parser.add_argument(
        "--run", choices=list(TABLES), action="append", help="default: both runs of table III"
    )
    parser.add_argument("--seeds", type=int, default=5, help="runs that no fit saw")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the training run")
    asked = parser.parse_args()
    for run in asked.run or ("zero-field", "zero-motion"):
        print(
            f"TWIN; training {asked.seconds:g} s (seed 1), {asked.seeds} runs {run} of 20 s each\n"
        )
        for table in TABLES[run]:
            table(asked.seeds, asked.seconds)
            print()


if __name__ == "__main__":
    main()
