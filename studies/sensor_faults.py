"""A fault in each sensor of the loop, under each control, beside the same loop in health. TWIN.

    python studies/sensor_faults.py [--seeds 5] [--first 0] [--model bingham] [--only WORD]
    python studies/sensor_faults.py --exported [--seeds 5] [--first 0]

The C core of the loop controls the TWIN step by step. From a random moment on one sensor is wrong for good. Until the
fault both loops are the same to the bit. Each session has one outcome (`held`, `safe`, `bounded`, `not held`). Beside
the outcomes stand the strict counts, which know no excuse: too high for more than 5 ms, and not zero within 20 ms.
The second table groups what misses the aim to the letter, with the cause that its rows tell. Printed are also the
longest time in which the field is more than a tenth above the healthy loop's, and the time until it is zero for good.

Of each session that misses, 20 healthy loops with other noise of the meter from the fault on make a band of what each
sensor reads, until an alarm would come too late. Sessions whose readings never leave it are counted apart: no check of
readings tells them. Of the others "off" is how far a reading leaves the band: encoders in counts, the meter in standard
deviations of its noise.

The last table asks of doubled meters whether their gain tells: measured torque over the model's, by the last 4, 8, 14
and 20 readings beside those before. It holds the largest change until an alarm would come too late, the largest in
health, and how often that is the fault's: the same loop with other noise, and each program that `erclutch live` offers.
Where it is more often than once, a limit that tells the fault raises an alarm there in health.

With --exported the exported controller (`erclutch export --to controller`) drives the TWIN in place of the loop. It
gets speeds and no readings; a meter that is silent (NaN) is none to it.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from erclutch.signals.device import DeviceName
from erclutch.wings.live.session import LiveModel
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.sensor_bound import GAIN_WINDOWS, HealthySessions, gain_changes
from tests.support.sensor_faults import (
    CAUSES,
    CONTROLS,
    FALLS,
    FAULTS,
    HEALTHY,
    OUTCOMES,
    SENSORS,
    ZERO_WITHIN,
    FaultRun,
    doubted,
    fault_run,
    frames_of,
    model_of,
    settings_of,
    under_field,
)

STRICT = ("too high for more than 5 ms", "not zero within 20 ms")


def main() -> int:
    """Print the tables; 1 if a fault was not held, or missed without a cause."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--model", default="bingham")
    parser.add_argument("--only", default="", help="control, sensor or fault")
    parser.add_argument("--exported", action="store_true", help="the exported controller")
    asked = parser.parse_args()
    rig, seeds = default_rig(), range(asked.first, asked.first + asked.seeds)
    if asked.exported:
        _print_exported(seeds)
        return 0
    devices: tuple[DeviceName, ...] = ("coaxial", "single")
    fitted = {device: model_of(rig, asked.model, device) for device in devices}
    outcomes, strict = Counter[str](), Counter[str]()
    missed: dict[tuple[str, ...], list[FaultRun]] = {}
    doubled: dict[str, list[tuple[int, int, FaultRun]]] = {}  # seed, row and outcome by control
    print(f"TWIN, {asked.model}, {asked.seeds} seeds; rows of 1 ms")
    columns = (
        "control",
        "sensor",
        "fault",
        *OUTCOMES,
        *STRICT,
        "above [rows]",
        "by",
        "zero after [rows]",
        "said",
    )
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for control in CONTROLS:
        if asked.only in CONTROLS and asked.only != control:
            continue
        model = fitted[CONTROLS[control][0]]
        settings = settings_of(control, model, rig)
        rng = np.random.default_rng(7 + asked.first)
        healthy = [frames_of(settings, model.library, rig, seed) for seed in seeds]
        begins = [int(rng.choice(under_field(frames))) for frames in healthy]
        outcomes["rows in doubt in health"] += sum(doubted(frames) for frames in healthy)
        for sensor, kind in itertools.product(SENSORS, FAULTS):
            if (
                kind == "silent"
                or asked.only not in (control, sensor, kind, "")
                or (sensor == "alpha" and control == "wall")
            ):
                continue
            runs = [
                fault_run(
                    settings, model.library, rig, seed, (sensor, kind, begin), well, banded=True
                )
                for seed, well, begin in zip(seeds, healthy, begins, strict=True)
            ]
            counts = Counter(run.outcome for run in runs)
            outcomes += counts
            strict += _strict(runs)
            if (sensor, kind) == ("torque", "doubled"):
                late = [
                    (seed, begin, run)
                    for seed, begin, run in zip(seeds, begins, runs, strict=True)
                    if not run.held
                ]
                doubled |= {control: late} if late else {}
            for run in runs:
                if not run.held:
                    missed.setdefault(
                        (control, sensor, _group(control, sensor, kind), run.cause), []
                    ).append(run)
            print(_row(control, sensor, kind, counts, runs), flush=True)
    columns = (
        "control",
        "sensor",
        "fault",
        "nothing tells",
        "sessions",
        *STRICT,
        "above [rows]",
        "by",
        "zero after",
        "within health",
        "off",
    )
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for (*names, cause), runs in missed.items():
        counts = " | ".join(map(str, _strict(runs).values()))
        above, most = max(run.above for run in runs), max(max(run.most for run in runs), 0.0)
        zeros = sorted({run.zero for run in runs})
        within = sum(run.outside == 0.0 for run in runs)
        off = max(run.outside for run in runs)
        said = CAUSES.get(cause, "NOBODY KNOWS WHY")
        print(
            f"| {' | '.join(names)} | {said} | {len(runs)} | {counts} | {above} | {most:.3f} | {zeros} "
            f"| {within} | {off:.2g} |"
        )
    unknown = sum(len(runs) for (*_, cause), runs in missed.items() if not cause)
    print(f"{unknown} sessions miss without a cause")
    print(
        f"{sum(outcomes[name] for name in OUTCOMES)} sessions: {dict(outcomes)}; strictly: {dict(strict)}"
    )
    asked_for = [
        run for (control, *_), runs in missed.items() if control != "equation 23" for run in runs
    ]
    print(
        f"Of these under controls that ask the meter, so all but equation 23: {dict(_strict(asked_for))}"
    )
    told = sum(run.outside == 0.0 for runs in missed.values() for run in runs)
    print(
        f"{told} of the sessions that miss read as healthy loops do, in each row and sensor while an alarm is in time"
    )
    _print_gains(rig, fitted, doubled)
    return 1 if outcomes["not held"] or unknown else 0


def _print_exported(seeds: range) -> None:
    """The table of the exported controller."""
    from tests.support.exported_controller import sessions

    print(f"TWIN, exported controller, bingham, torque by the meter, {len(seeds)} seeds")
    columns = ("sensor", "fault", *STRICT, "above [rows]", "by", "zero after [rows]", "said")
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for sensor, kind, runs in sessions(seeds):
        said = " ".join(sorted({name for run in runs for name in run.said}))
        counts = " | ".join(map(str, _strict(runs).values()))
        above, most = max(run.above for run in runs), max(max(run.most for run in runs), 0.0)
        zeros = sorted({run.zero for run in runs})
        print(
            f"| {sensor} | {kind} | {counts} | {above} | {most:.3f} | {zeros} | {said} |",
            flush=True,
        )


def _print_gains(
    rig: RigParameters,
    fitted: Mapping[str, LiveModel],
    doubled: Mapping[str, Sequence[tuple[int, int, FaultRun]]],
) -> None:
    """The table of gains of doubled meters that were told late: seed, row and outcome by control."""
    if not doubled:
        return
    columns = (
        "control",
        "zero after",
        "model [N m]",
        "readings",
        "gain changes [sd]",
        "same loop in health",
        "of the fault's",
        "other programs in health",
        "of the fault's",
    )
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    told = 0
    for control, late in doubled.items():
        model = fitted[CONTROLS[control][0]]
        settings = settings_of(control, model, rig)
        own = np.max(
            [
                gain_changes(frames_of(settings, model.library, rig, seed), settings).max(axis=0)
                for seed in HEALTHY
            ],
            axis=0,
        )
        offered = HealthySessions(settings, model, rig, 1, gain_changes)
        others = np.max([changes.max(axis=0) for _, changes in offered], axis=0)
        for seed, begin, run in late:
            faulty = frames_of(settings, model.library, rig, seed, ("torque", "doubled", begin))
            rows = slice(begin, begin + ZERO_WITHIN - FALLS)
            changes = gain_changes(faulty, settings)[rows].max(axis=0)
            best = int(np.argmax(changes / np.maximum(own, others)))
            told += bool(changes[best] > max(own[best], others[best]))
            gives = float(np.mean(np.abs(faulty["estimate"][rows])))
            print(
                f"| {control} | {run.zero} | {gives:.4f} | {GAIN_WINDOWS[best]} | {changes[best]:.1f} "
                f"| {own[best]:.1f} | {own[best] / changes[best]:.2f} "
                f"| {others[best]:.1f} | {others[best] / changes[best]:.2f} |",
                flush=True,
            )
    print(f"{told} of these change the gain by more than health does over any window")


def _strict(runs: Sequence[FaultRun]) -> Counter[str]:
    """Sessions that miss the aim to the letter; one may miss both."""
    missed = (sum(not run.never_above for run in runs), sum(not run.zero_in_time for run in runs))
    return Counter(dict(zip(STRICT, missed, strict=True)))


def _group(control: str, sensor: str, kind: str) -> str:
    """In which group a fault that misses the aim stands."""
    if (control, sensor) == ("equation 23", "torque"):
        return "any"
    if sensor == "torque":
        return kind if kind in ("doubled", "reversed") else "otherwise"
    return "stuck or late" if kind in ("stuck", "late") else kind


def _row(
    control: str, sensor: str, kind: str, counts: Mapping[str, int], runs: Sequence[FaultRun]
) -> str:
    zeros = sorted({run.zero for run in runs})
    said = " ".join(sorted({name for run in runs for name in run.said}))
    above, most = max(run.above for run in runs), max(run.most for run in runs)
    outcomes = " | ".join(
        [*(str(counts.get(name, 0)) for name in OUTCOMES), *map(str, _strict(runs).values())]
    )
    return (
        f"| {control} | {sensor} | {kind} | {outcomes} | {above} | {most:.3f} | {zeros} | {said} |"
    )


if __name__ == "__main__":
    raise SystemExit(main())
