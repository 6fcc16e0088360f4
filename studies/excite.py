"""How many seconds of log make a model: `python studies/excite.py twin`, and the parts below in place of `twin`.

    twin      TWIN brake: test RMSE over seconds of log, for what `erclutch excite` chooses without and with a model,
              for the paper's draws, random steps and a chirp within the same limits, beside a fit to a long log
    files     FOLDER holds the preprocessed recordings of the UTFSM damper: k of its 30 files chosen by what the earlier
              ones taught, beside random choices
    devices   made-up devices: intervals as foretold beside intervals as got
    limits    random limits: how many sequences break one, and how many are refused

The drive of the TWIN follows the references by a servo; the log holds what it did. Sequences are chosen and fitted on
their own rows; the test log is only scored. Each fit takes the law that its own rows choose, or the one of --law. Small
by default; --seeds, --long and --draws make it large. --out FILE keeps each error of the TWIN, so a run that was ended
goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from erclutch.errors import SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.wings.design.courses import Bounds, Commands, GrowingSequence, course
from erclutch.wings.design.fill import chosen_sequence, papers_sequence
from erclutch.wings.design.information import Knowledge, Sensitivity
from erclutch.wings.design.limits import RigLimits, limits_of_log
from erclutch.wings.design.run_design import LawOfRun, designed_for
from erclutch.wings.rig.interface import RigCommand
from erclutch.wings.rig.twin.scenarios import prepare
from erclutch.wings.rig.twin.twin import Twin
from studies.memory import utfsm
from tests.support.rig_limits import broken, random_limits

RATE = 1000.0
#: Within this many times of the fit to the long log a short log is as good.
AS_GOOD = 1.1
FIRST = 2.0  # s of filling sequence before the model has a say
_MEMORY = "lag+dahl/field"
#: The next law is taken where it lowers the error on the rows of the fit by so much, as `live --program learn` does.
LAWS = ("bingham", "casson")
_BETTER = 0.98
SERVO = 2.0 * math.pi * 20.0  # 1/s

Play = Callable[[RigLimits, float, int], Commands]


def fitted(rows: Dataset, laws: Sequence[str] = LAWS, stages: str = "lag") -> TorqueModel:
    """The fit of the law that the rows choose."""
    chosen: FitOutcome[TorqueModel] | None = None
    for name in laws:
        single = rows.device == "single"
        structure = Structure(
            rows.device, name, law_from_name(name, rows.device), stages, single, single
        )
        tried = fit_structure(rows, structure, intervals=False)
        if chosen is None or tried.train_cost < _BETTER**2 * chosen.train_cost:
            chosen = tried
    assert chosen is not None
    return chosen.model


class Servo:
    """The drive of the TWIN follows speeds.

    Args:
        speeds: in rad/s, one a row.
        inertia: of the drive in kg m2.
    """

    def __init__(self, speeds: Array, inertia: float) -> None:
        self._speeds: list[float] = np.append(speeds, 0.0).tolist()
        self._inertia = inertia
        self._angle = 0.0
        self._integral = 0.0

    def asked(self, row: int, angle: float) -> tuple[float, float]:
        """The drive's speed in rad/s at a row, and the torque in N m that brings it to the next speed if it is free."""
        speed = (angle - self._angle) * RATE
        self._angle = angle
        off = self._speeds[row] - speed
        self._integral += off / RATE
        change = (self._speeds[row + 1] - self._speeds[row]) * RATE
        return speed, self._inertia * (change + SERVO * off + 0.25 * SERVO**2 * self._integral)


def played(commands: Commands, seed: int) -> Dataset:
    """The log of a brake whose drive follows the speed by a servo, and whose field is the command."""
    twin = Twin(seed=seed, locked=True, single=True)
    servo = Servo(commands.speed, twin.rig.value("drive.inertia"))
    rows = np.zeros((commands.speed.size, 3))
    measured = twin.sense()
    for row, field in enumerate(commands.field.tolist()):
        _, torque = servo.asked(row, measured.theta)
        rows[row] = field, measured.theta - measured.alpha_rotary, measured.torque
        twin.command(RigCommand(E1=field, motor_torque=torque + measured.torque))
        twin.step()
        measured = twin.sense()
    field, position, effort = rows.T
    columns = {"field": field, "position": position, "effort": effort}
    log = recording_from_arrays(
        columns, rate=RATE, units={"field": "", "position": "rad", "effort": "N*m"}
    )
    return build_dataset(log)


def random_steps(limits: RigLimits, seconds: float, seed: int) -> Commands:
    """Field and speed step to even draws every 0.1 to 1 s."""
    return _stepwise(
        limits, seconds, np.random.default_rng(seed), lambda rng, share: rng.uniform(-1.0, 1.0, 2)
    )


def chirp(limits: RigLimits, seconds: float, seed: int) -> Commands:
    """Field and speed are sines whose frequencies grow from 0.3 to 20 and from 0.2 to 5 Hz."""

    def at(_: np.random.Generator, share: float) -> Array:
        turns = [
            seconds * low / math.log(high / low) * ((high / low) ** share - 1.0)
            for low, high in _CHIRPS
        ]
        return np.sin(2.0 * math.pi * np.array(turns))

    return _stepwise(limits, seconds, np.random.default_rng(seed), at, rows=1)


_CHIRPS = ((0.3, 20.0), (0.2, 5.0))  # Hz


def _stepwise(
    limits: RigLimits,
    seconds: float,
    rng: np.random.Generator,
    at: Callable[[np.random.Generator, float], Array],
    rows: int | None = None,
) -> Commands:
    """References that go to drawn targets within the limits; a field is the size of its draw."""
    bounds = Bounds.of(limits, RATE, seconds)
    sequence = GrowingSequence(bounds)
    while sequence.left > 0:
        field, speed = at(rng, sequence.rows / bounds.rows)
        hold = rows or int(rng.uniform(0.1, 1.0) * RATE)
        fields = course(
            sequence.field, [(round(bounds.field * abs(float(field))), bounds.field_step, hold)]
        )[:hold]
        speeds = course(
            sequence.speed, [(round(bounds.speed * float(speed)), bounds.speed_step, hold)]
        )[:hold]
        safe = sequence.safe(fields, speeds)
        if safe < min(hold, sequence.left):
            fields, speeds = sequence.stop()
            safe = sequence.safe(fields, speeds)
        sequence.append(fields[:safe], speeds[:safe])
    return sequence.end()


def filling(limits: RigLimits, seconds: float, seed: int) -> Commands:
    """What `erclutch excite` chooses without a model."""
    return chosen_sequence(limits, RATE, seconds, np.random.default_rng(seed))


def papers(limits: RigLimits, seconds: float, seed: int) -> Commands:
    """The paper's draws within the limits."""
    return papers_sequence(limits, RATE, seconds, np.random.default_rng(seed))


def by_model(
    limits: RigLimits, seconds: float, seed: int, laws: Sequence[str], *, believed: bool
) -> Dataset:
    """Some seconds that fill, a fit, and the rest chosen by that law: as `erclutch excite --run` does, or D-optimal."""
    first = played(filling(limits, FIRST, seed), seed)
    law = fitted(first, laws, _MEMORY)
    rng = np.random.default_rng(seed)
    if believed:
        knowledge = Knowledge(law, first, RATE, "D")
    else:
        use = filling(limits, 10.0, seed + 7)
        rows = Sensitivity(law).of_commands([(use.field, use.speed)], 1.0 / RATE)
        knowledge = Knowledge(law, first, RATE, "I", rows)
    rest = chosen_sequence(limits, RATE, seconds - FIRST, rng, knowledge, candidates=16)
    return joined([first, played(rest, seed + 1000)])


def error(model: TorqueModel, test: Dataset) -> float:
    """Root mean square of measured less estimated effort."""
    return float(np.sqrt(np.mean((test.effort - model.predict(test)) ** 2)))


def kept_errors(out: Path | None) -> dict[str, list[float]]:
    """Errors that a run before kept, by what they are of."""
    if out is None or not out.exists():
        return {}
    return dict(json.loads(line) for line in out.read_text(encoding="utf-8").splitlines())


def keep(out: Path | None, key: str, errors: list[float]) -> None:
    """Add an error to a file."""
    if out is not None:
        with out.open("a", encoding="utf-8") as kept:
            kept.write(json.dumps([key, errors]) + "\n")


def print_rows(
    device: str,
    makers: Sequence[tuple[str, Callable[[float, int], Dataset]]],
    tests: Sequence[Dataset],
    best: Sequence[float],
    *,
    seeds: range,
    long: float,
    lengths: Sequence[float],
    laws: Sequence[str],
    out: Path | None,
) -> None:
    """A line of the table for each kind of sequence: medians of its errors over those of the fit to long logs.

    Args:
        device: what the TWIN is of.
        makers: name of a kind, and what makes a log of so many seconds of a seed.
        tests: logs that judge.
        best: the error of the fit to long logs on each test, in N m.
        seeds: of the logs.
        long: seconds of the long logs.
        lengths: seconds of the short ones.
        laws: that each log chooses from.
        out: where errors are kept as they come, so that a run that was stopped goes on.
    """
    known = kept_errors(out)
    for name, made in makers:
        cells: list[str] = []
        after = "-"
        for seconds in lengths:
            errors: list[list[float]] = []  # of each seed, by test, in N m
            for seed in seeds:
                key = f"{device}, {name}, {seconds:g} s, seed {seed}, {long:g} s, {' '.join(laws)}"
                if key not in known:
                    model = fitted(made(seconds, seed), laws)
                    known[key] = [error(model, test) for test in tests]
                    keep(out, key, known[key])
                errors.append(known[key])
            medians = np.median(errors, axis=0) / best
            cells.append(" / ".join(f"{median:.2f}" for median in medians))
            if after == "-" and medians.max() <= AS_GOOD:
                after = f"{seconds:g} s"
        print(f"| {name} | " + " | ".join([*cells, after]) + " |", flush=True)


def twin(
    seeds: range, long: float, lengths: Sequence[float], laws: Sequence[str], out: Path | None
) -> None:
    """Print errors over seconds of log as multiples of those of a long log of both kinds that are tested."""
    scenario = build_dataset(prepare("brake", seconds=long, seed=1).recording())
    limits = RigLimits(**(limits_of_log(scenario) | {"rest": 0.1}))
    whole = joined([scenario, played(random_steps(limits, long, 98), 98)])
    tests = (
        build_dataset(prepare("brake", seconds=20.0, seed=3).recording()),
        played(random_steps(limits, 20.0, 97), 97),
    )
    reference = fitted(whole, laws)
    best = [error(reference, test) for test in tests]
    print(
        f"TWIN brake; {' or '.join(laws)}+lag; seeds {seeds.start} to {seeds.stop - 1}; "
        "tests: 20 s of the scenario brake / 20 s of random steps"
    )
    print(
        f"RMSE of {reference.name}, fitted to {long:g} s of each: {best[0]:.4g} / {best[1]:.4g} N m; "
        "below: medians as multiples of it"
    )
    print(
        "| sequence | "
        + " | ".join(f"{seconds:g} s" for seconds in lengths)
        + f" | within {AS_GOOD:g} of both after |"
    )
    print("|---|" + "---:|" * (len(lengths) + 1))
    makers: list[tuple[str, Callable[[float, int], Dataset]]] = [
        ("excite, filling", lambda seconds, seed: played(filling(limits, seconds, seed), seed)),
        (
            "excite, by model",
            lambda seconds, seed: by_model(limits, seconds, seed, laws, believed=False),
        ),
        (
            "a law that is believed (D)",
            lambda seconds, seed: by_model(limits, seconds, seed, laws, believed=True),
        ),
        ("the paper's draws", lambda seconds, seed: played(papers(limits, seconds, seed), seed)),
        (
            "scenario brake",
            lambda s, seed: build_dataset(prepare("brake", seconds=s, seed=10 + seed).recording()),
        ),
        ("random steps", lambda seconds, seed: played(random_steps(limits, seconds, seed), seed)),
        ("chirp", lambda seconds, seed: played(chirp(limits, seconds, seed), seed)),
    ]
    print_rows(
        "brake", makers, tests, best, seeds=seeds, long=long, lengths=lengths, laws=laws, out=out
    )


def exchanged(
    starts: Sequence[Sequence[int]], count: int, judged: Callable[[Sequence[int]], float]
) -> tuple[list[int], float, int]:
    """The best choice that is reached by exchanging one file at a time, its error, and how many choices were judged.

    It is an oracle: the errors that it looks at are those on the files that are not chosen.
    """
    known: dict[tuple[int, ...], float] = {}

    def of(numbers: Sequence[int]) -> float:
        key = tuple(sorted(numbers))
        if key not in known:
            known[key] = judged(key)
        return known[key]

    ends: list[list[int]] = []
    for start in starts:
        here = list(start)
        better = True
        while better:
            near = [
                [*here[:place], other, *here[place + 1 :]]
                for place in range(len(here))
                for other in range(count)
            ]
            best = min((numbers for numbers in near if len(set(numbers)) == len(numbers)), key=of)
            better = of(best) < of(here)
            here = best if better else here
        ends.append(here)
    best = min(ends, key=of)
    return sorted(best), of(best), len(known)


def files(folder: Path, draws: int, least: int, most: int, *, search: bool) -> None:
    """Print the error on the files that were not chosen, over the number that were."""
    data, motions, of_row = utfsm(folder)
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "dahl/field", False, True
    )
    logs = [data.take(of_row == number) for number in range(len(motions))]

    def fitted(numbers: Sequence[int]) -> TorqueModel:
        return fit_structure(
            joined([logs[number] for number in numbers]), structure, intervals=False
        ).model

    def rest(model: TorqueModel, numbers: Sequence[int]) -> float:
        errors = [error(model, log) for number, log in enumerate(logs) if number not in numbers]
        return float(np.sqrt(np.mean(np.square(errors))))

    whole = fitted(range(len(logs)))
    # The first file is the one that a rig would begin with: the largest field at the fastest motion.
    chosen = [
        max(
            range(len(logs)),
            key=lambda number: (motions[number].current, np.abs(logs[number].effort).max()),
        )
    ]
    rng = np.random.default_rng(0)
    print(
        f"UTFSM damper, 30 files; bingham+dahl/field; random: {draws} draws; RMSE on the files not chosen, N"
    )
    print(
        "| files | by what the earlier ones taught | of all 30, on the same | random: median (best - worst) | beaten |"
    )
    print("|---:|---|---:|---:|---:|")
    while len(chosen) <= most:
        model = fitted(chosen)
        ours, all_files = rest(model, chosen), rest(whole, chosen)
        drawn = [
            sorted(rng.choice(len(logs), len(chosen), replace=False).tolist()) for _ in range(draws)
        ]
        random = [rest(fitted(numbers), numbers) for numbers in drawn if len(chosen) >= least] or [
            math.nan
        ]
        names = ", ".join(
            f"{motions[number].name} {motions[number].current:g} A" for number in chosen
        )
        shares = f"{np.median(random):.1f} ({min(random):.1f} - {max(random):.1f})"
        beaten = f"{np.mean([ours < other for other in random]):.0%}"
        print(
            f"| {len(chosen)} | {ours:.1f}: {names} | {all_files:.1f} | {shares} | {beaten} |",
            flush=True,
        )
        if search and len(chosen) == most:
            starts = [chosen, drawn[int(np.argmin(random))]]
            best, error_of_best, fits = exchanged(
                starts, len(logs), lambda numbers: rest(fitted(numbers), numbers)
            )
            found = ", ".join(
                f"{motions[number].name} {motions[number].current:g} A" for number in best
            )
            share = ours / error_of_best
            of_all = rest(whole, best)
            print(
                f"best found by exchange, {fits} fits, from ours and from the best draw: {error_of_best:.1f}: {found}"
            )
            print(f"of all 30, on the same: {of_all:.1f}; ours over the best found: {share:.3f}")
        knowledge = Knowledge(model, joined([logs[number] for number in chosen]), RATE)
        left = [number for number in range(len(logs)) if number not in chosen]
        chosen.append(max(left, key=lambda number: knowledge.worth(logs[number])))


_DEVICE = RigLimits(field=1.0, speed=20.0, acceleration=400.0, rest=0.1)
_DEVICE_RATE, _DEVICE_SECONDS = 500.0, 5.0  # Hz; s of each log
_DEVICE_NOISE = 0.03  # of the RMS of the first log's effort


def devices(count: int, first_seed: int) -> None:
    """Print how intervals that were foretold compare with those that were got, over made-up devices (SYNTHETIC)."""
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "lag", True, True
    )
    ratios: dict[str, list[float]] = {}
    for seed in range(first_seed, first_seed + count):
        rng = np.random.default_rng(seed)
        first_commands = chosen_sequence(_DEVICE, _DEVICE_RATE, _DEVICE_SECONDS, rng)
        truth = _made_up(first_commands, structure, rng)
        bare = truth.predict(_rows_of(first_commands, np.zeros(first_commands.speed.size)))
        noise = _DEVICE_NOISE * float(np.sqrt(np.mean(bare**2)))  # the sensor's, in both logs
        first = _logged(first_commands, truth, noise, rng)
        outcome = fit_structure(first, structure)
        law = LawOfRun(outcome.model.name, outcome.model, outcome.estimates, first)
        commands, expected = designed_for(
            law, _DEVICE, _DEVICE_RATE, _DEVICE_SECONDS, seed, criterion="D"
        )
        both = fit_structure(joined([first, _logged(commands, truth, noise, rng)]), structure)
        foretold = expected.half_widths(law.estimates)
        for estimate, (_, half) in zip(both.estimates, foretold, strict=True):
            got = 0.5 * (estimate.high - estimate.low)
            if math.isfinite(half) and math.isfinite(got) and got > 0.0:
                ratios.setdefault(estimate.name, []).append(half / got)
    seconds = f"{_DEVICE_SECONDS:g} s, and {_DEVICE_SECONDS:g} s by model (D)"
    print(f"SYNTHETIC, {count} devices, seeds from {first_seed} on; bingham+lag; {seconds}")
    print("| number | devices | foretold / got: median | 10 % - 90 % | within 0.8 - 1.25 |")
    print("|---|---:|---:|---|---:|")
    every = [ratio for of_name in ratios.values() for ratio in of_name]
    for name, of_name in {**ratios, "all": every}.items():
        low, middle, high = np.quantile(of_name, (0.1, 0.5, 0.9))
        within = np.mean([0.8 <= ratio <= 1.25 for ratio in of_name])
        print(f"| {name} | {len(of_name)} | {middle:.2f} | {low:.2f} - {high:.2f} | {within:.0%} |")


def _made_up(commands: Commands, structure: Structure, rng: np.random.Generator) -> TorqueModel:
    """A law with numbers that are drawn."""
    bare = _rows_of(commands, np.sign(commands.speed) * commands.field + 0.01 * commands.speed)
    law = fit_structure(bare, structure, intervals=False).model
    drawn = {"w_s": 0.02, "n": 1.5, "delay": 0.004, "tau": 0.010}  # of a reference; s
    shape = {name: drawn[name] * math.exp(rng.uniform(-0.4, 0.4)) for name in law.shape}
    gains = {"T_y": 1.0, "eta": 0.02, "T_f": 0.1, "T_0": 0.05}
    return replace(
        law,
        shape=shape,
        gains={name: gains[name] * math.exp(rng.uniform(-0.7, 0.7)) for name in law.gains},
    )


def _logged(
    commands: Commands, truth: TorqueModel, noise: float, rng: np.random.Generator
) -> Dataset:
    """What a device of a law gives, with white noise of a standard deviation."""
    rows = _rows_of(commands, np.zeros(commands.speed.size))
    effort = truth.predict(rows)
    return replace(rows, effort=effort + noise * rng.standard_normal(effort.size))


def _rows_of(commands: Commands, effort: Array) -> Dataset:
    columns = {"field": commands.field, "slip": commands.speed, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    return build_dataset(recording_from_arrays(columns, rate=_DEVICE_RATE, units=units))


def limits(draws: int) -> None:
    """Print how many sequences of random limits break one."""
    rng = np.random.default_rng(0)
    refused, kinds = 0, 0
    start = time.process_time()
    for _ in range(draws):
        drawn, rate = random_limits(rng), float(rng.choice([100.0, 333.3, 1000.0]))
        try:
            commands = chosen_sequence(drawn, rate, 3.0, rng, candidates=4)
        except SettingError:
            refused += 1
            continue
        kinds += bool(broken(commands, drawn, rate))
    took = time.process_time() - start
    print(
        f"{draws} random limits: {refused} refused, {kinds} sequences that break a limit; {took:.0f} s of CPU"
    )


def main() -> None:
    """Run one part."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("part", choices=("twin", "files", "devices", "limits"))
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument(
        "--lengths",
        type=float,
        nargs="+",
        default=[3.0, 6.0, 10.0],
        help="seconds of the short logs",
    )
    parser.add_argument("--long", type=float, default=30.0, help="seconds of the long log")
    parser.add_argument("--law", nargs="+", default=LAWS, help="among which each log chooses")
    parser.add_argument(
        "--out", type=Path, help="keeps each error of the TWIN, to go on where a run was ended"
    )
    parser.add_argument(
        "--draws", type=int, default=10, help="random choices of files, or random limits"
    )
    parser.add_argument("--devices", type=int, default=5, help="made-up devices")
    parser.add_argument(
        "--least", type=int, default=1, help="files, from which on random choices stand beside"
    )
    parser.add_argument("--most", type=int, default=4, help="files, at most")
    parser.add_argument(
        "--search", action="store_true", help="also the best choice that an exchange of files finds"
    )
    asked = parser.parse_args()
    with one_thread():
        if asked.part == "twin":
            seeds = range(asked.first, asked.first + asked.seeds)
            twin(seeds, asked.long, asked.lengths, tuple(asked.law), asked.out)
        elif asked.part == "files":
            if asked.folder is None:
                parser.error("files needs the FOLDER of the recordings")
            files(asked.folder, asked.draws, asked.least, asked.most, search=asked.search)
        elif asked.part == "devices":
            devices(asked.devices, asked.first)
        else:
            limits(asked.draws)


if __name__ == "__main__":
    main()
