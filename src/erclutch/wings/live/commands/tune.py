"""``erclutch tune`` finds gains of torque and motion control for a run's model, and says what the device allows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import HERTZ, TORQUE, quantity
from erclutch.errors import CheckError, SettingError, require
from erclutch.files import may_fill, may_write_file
from erclutch.files.groups import together

if TYPE_CHECKING:
    from erclutch.models.model import Model
    from erclutch.runs.run_folder import Run
    from erclutch.signals.array import Array
    from erclutch.wings.live.loop_margins import LinearLoop, TorquePath, TunedLoop
    from erclutch.wings.live.moved_side import MovedSide
    from erclutch.wings.rig.twin.parameters import RigParameters

COMMAND = {
    "help": "Find gains of torque and motion control from the model of a run, with margins and pictures.",
    "panel": "Live",
    "place": 2,
}

_PERIOD = 1e-3  # s, of the loop
#: A model that answers in the very row by more than this share is of a log whose torque is that of the row's end.
_AT_ONCE = 0.2
_SETTLED = 400  # rows before the step
_ROWS = 400  # rows from the step on
#: Shares of the largest field of the training data between which the field steps.
_STEP = 0.25, 0.30
#: In Hz, where nobody asks for another: of motion control, and of the observer of torque control.
_BANDWIDTH = 10.0
_TORQUE_BANDWIDTH = 20.0
#: Such a bandwidth stays so far below the largest that the device allows.
_OF_THE_LARGEST = 0.7
_INTEGRAL = 1.0 / 6.0  # of the bandwidth in 1/s
#: Names of the settings that a file may hold, with their units.
TUNED = {
    "observer_bandwidth": "Hz",
    "integral_rate": "1/s",
    "torque_lead": "s",
    "torque_lag": "s",
    "track_bandwidth": "Hz",
    "track_integral": "1/s",
    "output_inertia": "kg m2",
    "output_friction": "N m",
    "k_p": "field per rad",
    "k_d": "field per rad/s",
    "stiffness": "N m/rad",
    "damping": "N m s/rad",
}


def tune(
    run: Annotated[Path, Parameter(name="RUN")],
    /,
    *,
    model: str | None = None,
    bandwidth: Annotated[float | None, HERTZ] = None,
    torque_bandwidth: Annotated[float | None, HERTZ] = None,
    output_inertia: Annotated[float | None, quantity("kg*m^2")] = None,
    output_friction: Annotated[float | None, TORQUE] = None,
    rig_file: Path | None = None,
    out: Path = Path("tuning"),
    as_: Annotated[
        tuple[Literal["pdf", "png", "svg"], ...],
        Parameter(name="--as", consume_multiple=True, negative=()),
    ] = ("pdf", "svg"),
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Find gains of torque and motion control from the model of a run, with margins, pictures, and a file for live.

    Args:
        run: Folder that erclutch fit --out wrote.
        model: Which model; it must have a lag. Default: the recommended one, or the best with a lag and without
            further inputs.
        bandwidth: Bandwidth that motion control shall reach in Hz: computed torque, impedance, and equation 23.
            Default: 10 Hz, at most 0.7 of what the device allows.
        torque_bandwidth: Bandwidth that the observer of torque control shall reach in Hz. Default: 20 Hz, as far.
        output_inertia: Inertia of the moved side in kg m². Default: from the run where its output moves, else from the
            rig file.
        output_friction: Dry friction of the moved side in N m. Default: as for the inertia.
        rig_file: A rig file (TOML) with the supply's limits, and inertias that no log shows.
        out: Folder for control.toml (erclutch live --tuned takes it) and the pictures.
        as_: Formats of the pictures: pdf, png or svg.
        force: Replace the files of an earlier tuning.
        json: Print margins and settings as JSON instead of tables.
    """
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.report.plots.paper_style import placed
    from erclutch.runs.run_folder import read_run
    from erclutch.wings.live.moved_side import moved_side
    from erclutch.wings.live.tuning_plot import describe_loops
    from erclutch.wings.rig.twin.parameters import load_rig

    for name, hertz in (("bandwidth", bandwidth), ("torque_bandwidth", torque_bandwidth)):
        if hertz is not None:
            require(0.1, unit=" Hz", **{name: hertz})
    may_fill(out)
    may_write_file(out / "control.toml", force)
    rig = load_rig(rig_file)
    kept = read_run(run)
    chosen = _model(kept, model)
    path, slope = torque_path(chosen)
    rig_source = "default rig, not yours" if rig_file is None else "rig file"
    moved = moved_side(kept, chosen, rig, rig_source, output_inertia, output_friction)
    loops = tuned_loops(path, rig, bandwidth, torque_bandwidth)
    of_torque, of_motion = (tuned.bandwidth for tuned in loops)
    gains = settings_of(path, slope, moved, of_motion, of_torque)
    if json:
        margins_of_loops = [
            {
                "loop": tuned.name,
                "bandwidth": tuned.bandwidth,
                "largest": tuned.largest,
                "by": tuned.limit,
                "phase_deg": tuned.margins.phase,
                "delay_s": tuned.margins.delay,
                "sensitivity": tuned.margins.sensitivity,
            }
            for tuned in loops
        ]
        body = {
            "model": chosen.name,
            "lag_s": path.lag,
            "moved_side": dict(zip(("inertia", "friction", "from"), moved, strict=True)),
            "margins": margins_of_loops,
            "settings": {name: gains[name] for name in TUNED},
        }
        terminal.say_json(body)
    else:
        if model is None and chosen.name != kept.recommended:
            problem, _ = _unfit(kept.model(kept.recommended))
            terminal.tell(
                f"The run recommends {kept.recommended}, which {problem}; {chosen.name} is its best that will do"
            )
        _show(chosen, path, moved, loops, gains)
    with together():
        with placed(out / "control.toml") as partial:
            partial.write_text(_control_file(chosen, loops, gains), encoding="utf-8")
        pictures = save_plot(describe_loops(loops), *(out / f"loops.{kind}" for kind in as_))
    if not json:
        terminal.say(out / "control.toml", *pictures)


def _control_file(model: Model, loops: list[TunedLoop], gains: Mapping[str, float]) -> str:
    """What `erclutch live --tuned` takes: the gains with their units, below what the loops can do."""
    digest = model.to_dict()["digest"][:12]
    by = "by erclutch tune. erclutch live --tuned takes this file."
    lines = [f"# Control of {model.name} ({digest}), {by}"]
    for tuned in loops:
        margins = tuned.margins
        lines.append(
            f"# {tuned.name}: {tuned.bandwidth:.3g} Hz of at most {tuned.largest:.3g}; "
            f"gain margin {margins.gains}, phase {margins.phase:.0f} deg, delay {1e3 * margins.delay:.1f} ms, "
            f"sensitivity {margins.sensitivity:.2f}"
        )
    lines += [f"{name} = {gains[name]:.6g}  # {unit}" for name, unit in TUNED.items()]
    return "\n".join(lines) + "\n"


# --- what the run says ------------------------------------------------------------------------------------------------


def _model(run: Run, name: str | None) -> Model:
    """The model that is named, else the recommended one, else the best that torque control can be tuned for.

    Raises:
        SettingError: what is named, or all of the run, has no lag, further inputs or another effort than a torque.
    """
    if name is not None:
        model = run.model(name)
        problem, remedy = _unfit(model)
        if problem:
            raise SettingError(f"{model.name} {problem}", where=str(run.folder), remedy=remedy)
        return model

    unfit: list[tuple[str, str]] = []
    for each in dict.fromkeys((run.recommended, *run.names)):
        model = run.model(each)
        problem, remedy = _unfit(model)
        if not problem:
            return model
        unfit.append((f"{model.name} {problem}", remedy))
    problem, remedy = unfit[0]
    raise SettingError(
        f"no model of the run will do: {problem}", where=str(run.folder), remedy=remedy
    )


def _unfit(model: Model) -> tuple[str, str]:
    """Why torque control cannot be tuned for a model, and the remedy; both "" where it can."""
    from erclutch.export.monotone import releases

    if model.units.effort not in ("N*m", "?"):
        return f"gives {model.units.effort}", "Tune a device that turns, whose effort is in N m"
    if not model.trained_on.field[1] > 0.0:
        return "was fitted without a field", "Tune a device whose field changes its torque"
    if releases(model):
        return (
            "has a torque that falls as the field grows",
            "Tune a device that no field leaves free: the loop's way to safety is no field",
        )
    if model.extras:
        return (
            "has further inputs, and the loop has fields and speeds",
            "Name a model without them with --model",
        )
    if not model.times:  # the margins would be those of the samples alone
        return "has no lag", "Fit the log with --lag rise-fall"
    return "", ""


def torque_path(model: Model) -> tuple[TorquePath, float]:
    """What a step of the field does to the model's torque, and the torque per field of such a step.

    The slower of a rising and a falling step counts. The loop computes its command from the newest sample, so a command
    cannot show in that sample.
    """
    import numpy as np

    from erclutch.signals.array import largest_size
    from erclutch.signals.clock import Clock, Span
    from erclutch.signals.device import Element
    from erclutch.wings.live.loop_margins import TorquePath

    highest = model.trained_on.field[1]
    low = _STEP[0] * highest
    high = _STEP[1] * highest
    slip = 0.5 * largest_size(model.trained_on.slip)
    rows = _SETTLED + _ROWS
    time: Array = _PERIOD * np.arange(rows, dtype=np.float64)
    clock = Clock(time, (Span(0, rows, _PERIOD),))

    def stepped(before: float, after: float) -> Array:
        """Torque from the row before the step on; the other clutch of a pair has no field."""
        field: Array = np.full(rows, after)
        field[:_SETTLED] = before
        elements = [Element(field, np.full(rows, slip))]
        if model.structure.device == "coaxial":
            other_slip = np.full(rows, -slip)
            elements.append(Element(np.zeros(rows), other_slip))
        return model.effort(tuple(elements), clock)[_SETTLED - 1 :]

    rise = stepped(low, high)
    fall = stepped(high, low)
    shares: list[Array] = []  # of the way, by row
    for torque in (rise, fall):
        way = torque[-1] - torque[0]
        if not abs(way) > 0.0:
            raise CheckError(
                f"{model.name} gives no torque for a field",
                remedy="Choose another model of the run",
            )
        shares.append((torque[1:] - torque[0]) / way)
    slower = min(shares, key=lambda share: float(share.sum()))
    # The pulse ends where the torque stays within 0.1 % of its end.
    off = np.flatnonzero(np.abs(1.0 - slower) > 1e-3)
    last_off = int(off[-1]) if off.size else 0
    pulse = np.diff(np.append(0.0, slower))[: last_off + 2]
    estimated = np.append(0.0, pulse / pulse.sum())
    torque = estimated
    if slower[0] <= _AT_ONCE:
        # The log's torque is that of the row's begin: what the first row has comes with the second.
        torque = np.append([0.0, estimated[1] + estimated[2]], estimated[3:])
    slope = float((rise[-1] - rise[0]) / (high - low))
    return TorquePath(_PERIOD, torque, estimated), slope


# --- loops and gains --------------------------------------------------------------------------------------------------


def tuned_loops(
    path: TorquePath,
    rig: RigParameters,
    bandwidth: float | None,
    torque_bandwidth: float | None,
) -> list[TunedLoop]:
    """Both loops at their bandwidths; None takes the usual one, or less where the device allows no more.

    Raises:
        SettingError: a bandwidth that the samples, the supply or the lag do not allow.
    """
    import math

    from erclutch.signals.speed import Derivative, live
    from erclutch.wings.live import loop_margins as lm

    speed = live(Derivative("kalman"), path.period)
    volts = rig.value("supply.voltage_limit")
    rate = min(rig.value("supply.slew_up"), rig.value("supply.slew_down"))
    limits = {
        "the sample time": 1.0 / (lm.LEAST_SAMPLES * path.period),
        "the supply's rate": rate / volts / math.pi / 2,
    }

    def motion(hertz: float) -> LinearLoop:
        return lm.motion_loop(path, hertz, _INTEGRAL * 2.0 * math.pi * hertz, speed)

    def torque(hertz: float) -> LinearLoop:
        return lm.torque_loop(path, hertz, hertz, _torque_lag(path))

    loops: list[TunedLoop] = []
    for name, option, asked, usual, loop_at in (
        ("torque", "--torque-bandwidth", torque_bandwidth, _TORQUE_BANDWIDTH, torque),
        ("motion", "--bandwidth", bandwidth, _BANDWIDTH, motion),
    ):
        most = min(limits.values())
        by_lag = lm.largest_bandwidth(loop_at, most)
        # Where the search ends at the other limits, it is not the lag that limits.
        own_limits = {
            **limits,
            "the lag of the torque": by_lag if by_lag < 0.99 * most else math.inf,
        }
        limit = min(own_limits, key=own_limits.__getitem__)
        largest = own_limits[limit]
        wanted = min(usual, _OF_THE_LARGEST * largest) if asked is None else asked
        if wanted > largest or not largest:
            problem = f"{option} {wanted:g} Hz: {limit} allows {largest:.3g} Hz"
            raise SettingError(problem, remedy="Give at most that")
        loop = loop_at(wanted)
        margins = lm.margins_of(loop)
        loops.append(lm.TunedLoop(name, wanted, largest, limit, loop, margins))
    return loops


def _torque_lag(path: TorquePath) -> float:
    return max(0.0, path.lag - path.estimate_lag)


def settings_of(
    path: TorquePath,
    slope: float,
    moved: MovedSide,
    bandwidth: float,
    torque_bandwidth: float,
) -> Mapping[str, float]:
    """Settings of `TUNED` for both bandwidths."""
    import math

    stiff = 2.0 * math.pi * bandwidth
    spring = moved.inertia * stiff * stiff
    damper = 2.0 * moved.inertia * stiff
    return {
        "observer_bandwidth": torque_bandwidth,
        "integral_rate": torque_bandwidth,  # 1/s; the same number is about a sixth of the bandwidth in rad/s
        "torque_lead": path.lag,
        "torque_lag": _torque_lag(path),
        "track_bandwidth": bandwidth,
        "track_integral": _INTEGRAL * stiff,
        "output_inertia": moved.inertia,
        "output_friction": moved.friction,
        "k_p": spring / abs(slope),
        "k_d": damper / abs(slope),
        "stiffness": spring,
        "damping": damper,
    }


# --- what is told -----------------------------------------------------------------------------------------------------


def _show(
    model: Model,
    path: TorquePath,
    moved: MovedSide,
    loops: list[TunedLoop],
    gains: Mapping[str, float],
) -> None:
    terminal.tell(
        f"{model.name}: the torque is {1e3 * path.lag:.2f} ms late. The moved side has {moved.inertia:.3g} kg m2 and "
        f"{moved.friction:.2g} N m of friction ({moved.source})."
    )
    rows: list[list[str]] = []
    for tuned in loops:
        margins = tuned.margins
        rows.append(
            [
                tuned.name,
                f"{tuned.bandwidth:.3g}",
                f"{tuned.largest:.3g}",
                tuned.limit,
                margins.gains,
                f"{margins.phase:.0f}",
                f"{1e3 * margins.delay:.1f}",
                f"{margins.sensitivity:.2f}",
            ]
        )
    for tuned in loops:
        usual = _TORQUE_BANDWIDTH if tuned.name == "torque" else _BANDWIDTH
        as_far_as_allowed = _OF_THE_LARGEST * tuned.largest
        if tuned.bandwidth == as_far_as_allowed and as_far_as_allowed < usual:
            terminal.tell(
                f"The {tuned.name} loop is tuned for {tuned.bandwidth:.3g} Hz and not for {usual:g} Hz: "
                f"{tuned.limit} allows {tuned.largest:.3g} Hz."
            )
    headings = [
        "loop",
        "Hz",
        "at most",
        "by",
        "gain margin",
        "phase [deg]",
        "delay [ms]",
        "sensitivity",
    ]
    terminal.tell(terminal.table("Margins", headings, rows))
    field = model.units.field if model.units.field not in ("", "?") else "field"
    values = [
        [name, f"{gains[name]:.4g}", unit.replace("field", field)] for name, unit in TUNED.items()
    ]
    terminal.tell(terminal.table("Settings", ["name", "value", "unit"], values))
