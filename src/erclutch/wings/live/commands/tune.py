"""``erclutch tune`` finds gains of torque and motion control for a run's model, and says what the device allows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import HERTZ, TORQUE, quantity
from erclutch.errors import CheckError, SettingError, require
from erclutch.files import may_write_file

if TYPE_CHECKING:
    from erclutch.models.model import Model
    from erclutch.report.plots.plot_description import Plot
    from erclutch.runs.run_folder import Run
    from erclutch.signals.array import Array
    from erclutch.wings.live.loop_margins import LinearLoop, LoopMargins, TorquePath
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
_WINDOW = 5  # rows over which a speed changes
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


@dataclass(frozen=True)
class TunedLoop:
    """One loop as it was tuned.

    Attributes:
        name: for people.
        bandwidth, largest: in Hz, asked for and allowed. limit: what does not allow more.
        loop, margins: see `erclutch.wings.live.loop_margins`.
    """

    name: str
    bandwidth: float
    largest: float
    limit: str
    loop: LinearLoop
    margins: LoopMargins


def tune(
    run: Annotated[Path, Parameter(name="RUN")],
    /,
    *,
    model: str | None = None,
    bandwidth: Annotated[float, HERTZ] = 10.0,
    torque_bandwidth: Annotated[float, HERTZ] = 20.0,
    output_inertia: Annotated[float | None, quantity("kg*m^2")] = None,
    output_friction: Annotated[float | None, TORQUE] = None,
    rig_file: Path | None = None,
    out: Path = Path("tuning"),
    as_: Annotated[
        tuple[Literal["pdf", "png", "svg"], ...], Parameter(name="--as", consume_multiple=True, negative=())
    ] = ("pdf", "svg"),
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Find gains of torque and motion control from the model of a run, with margins, pictures, and a file for live.

    Args:
        run: Folder that erclutch fit --out wrote.
        model: Which model; it must have a lag. Default: the recommended one, or the best with a lag.
        bandwidth: Bandwidth that motion control shall reach in Hz: computed torque, impedance, and equation 23.
        torque_bandwidth: Bandwidth that the observer of torque control shall reach in Hz.
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
    from erclutch.wings.rig.twin.parameters import load_rig

    require(0.1, unit=" Hz", bandwidth=bandwidth, torque_bandwidth=torque_bandwidth)
    may_write_file(out / "control.toml", force)
    rig, found = load_rig(rig_file), read_run(run)
    chosen = _model(found, model)
    path, slope = torque_path(chosen)
    mass = _moved_side(found, chosen, rig, output_inertia, output_friction)
    loops = tuned_loops(path, rig, bandwidth, torque_bandwidth)
    gains = settings_of(path, slope, mass, bandwidth, torque_bandwidth)
    if json:
        terminal.say_json(_as_json(chosen, path, mass, loops, gains))
    else:
        _show(chosen, path, mass, loops, gains)
    with placed(out / "control.toml") as partial:
        partial.write_text(_toml(chosen, loops, gains), encoding="utf-8")
    pictures = save_plot(describe_loops(loops), *(out / f"loops.{kind}" for kind in as_))
    if not json:
        terminal.say(out / "control.toml", *pictures)


# --- what the run says ------------------------------------------------------------------------------------------------


def _model(run: Run, name: str | None) -> Model:
    """A model with a lag: without a lag the margins would be those of the samples alone."""
    lagging = [str(entry["name"]) for entry in run.body["ranking"] if entry["dynamics"]]
    if name is None and not lagging:
        problem = "no model of the run has a lag, so its margins cannot be told"
        raise SettingError(problem, where=str(run.folder), remedy="Fit the log with --lag rise-fall")
    if name is None:
        name = run.recommended if run.recommended in lagging else lagging[0]
    model = run.model(name)
    if not model.times:
        remedy = f"Choose one of {', '.join(lagging)}" if lagging else "Fit the log with --lag rise-fall"
        raise SettingError(f"{model.name} has no lag", where=str(run.folder), remedy=remedy)
    if model.units.effort not in ("N*m", "?") or model.extras:
        problem = f"{model.name} gives {model.units.effort}" if not model.extras else f"{model.name} has further inputs"
        raise SettingError(problem, where=str(run.folder), remedy="Give a model of a torque in N m over field and slip")
    return model


def torque_path(model: Model) -> tuple[TorquePath, float]:
    """What a step of the field does to the model's torque, and the torque per field of such a step.

    The slower of a rising and a falling step counts. The loop computes its command from the newest sample, so a command
    cannot show in that sample.
    """
    import numpy as np

    from erclutch.signals.clock import Clock, Span
    from erclutch.signals.device import Element
    from erclutch.wings.live.loop_margins import TorquePath

    low, high = (share * model.trained_on.field[1] for share in _STEP)
    slip = 0.5 * max(abs(end) for end in model.trained_on.slip)
    rows = _SETTLED + _ROWS
    time: Array = _PERIOD * np.arange(rows, dtype=np.float64)
    clock = Clock(time, (Span(0, rows, _PERIOD),))

    def stepped(before: float, after: float) -> Array:
        first = Element(np.where(np.arange(rows) < _SETTLED, before, after), np.full(rows, slip))
        other = (Element(np.zeros(rows), np.full(rows, -slip)),) if model.structure.device == "coaxial" else ()
        return model.effort((first, *other), clock)[_SETTLED - 1 :]

    ways = [stepped(low, high), stepped(high, low)]
    shares = [(way[1:] - way[0]) / (way[-1] - way[0]) for way in ways]
    if not np.isfinite(shares).all():
        raise CheckError(f"{model.name} gives no torque for a field", remedy="Choose another model of the run")
    slower = min(shares, key=lambda share: float(share.sum()))
    # The pulse ends where the torque stays within 0.1 % of its end.
    last_off = int(np.flatnonzero(np.abs(1.0 - slower) > 1e-3)[-1:].sum())
    pulse = np.diff(np.append(0.0, slower))[: last_off + 2]
    estimated = np.append(0.0, pulse / pulse.sum())
    given = estimated if slower[0] > _AT_ONCE else np.append([0.0, estimated[1] + estimated[2]], estimated[3:])
    return TorquePath(_PERIOD, given, estimated), float((ways[0][-1] - ways[0][0]) / (high - low))


def _moved_side(
    run: Run, model: Model, rig: RigParameters, inertia: float | None, friction: float | None
) -> tuple[float, float, str]:
    """Inertia and friction of what is moved, and where they come from.

    A pair moves its output, a single device its drive, which no log of a run shows.
    """
    single = run.body["device"] == "single"
    seen = None if single else output_numbers(run, model.name)
    where = "rig file" if seen is None else "run"
    if single:
        values = rig.value("drive.inertia"), rig.value("drive.coulomb")
    else:
        whole = rig.value("screw.rotor_inertia") + rig.value("screw.load_inertia")
        values = seen or (whole, rig.value("screw.coulomb"))
    if inertia is not None or friction is not None:
        where = "options" if None not in (inertia, friction) else f"options; {where}"
    moved_inertia, moved_friction = values
    if inertia is not None:
        moved_inertia = inertia
    if friction is not None:
        moved_friction = friction
    require(1e-9, unit=" kg m2", output_inertia=moved_inertia)
    require(0.0, unit=" N m", output_friction=moved_friction)
    return moved_inertia, moved_friction, where


def output_numbers(run: Run, model: str) -> tuple[float, float] | None:
    """Inertia and dry friction of an output that moves, by least squares; None if it rests.

    They are those that the model's torque moves. On a log whose output was free a model knows the torque behind the
    sensor alone, and that moves less inertia than the whole output has.
    """
    import numpy as np

    from erclutch.runs.run_rows import read_rows

    rows = read_rows(run)
    data = rows.data
    speed = -0.5 * (data.elements[0].slip + data.elements[1].slip)
    at = np.concatenate([np.arange(span.start, span.stop - _WINDOW, _WINDOW) for span in data.clock.spans])
    moving = np.abs(speed[at]) > 0.2 * np.std(speed)
    if np.std(speed) < 1.0 or np.count_nonzero(moving) < 100:
        return None
    sums = np.concatenate([[0.0], np.cumsum(rows.predicted[model])])
    torque = (sums[at + _WINDOW] - sums[at]) / _WINDOW  # mean of each window
    time = data.clock.time[at + _WINDOW] - data.clock.time[at]
    acceleration = (speed[at + _WINDOW] - speed[at]) / time
    known = np.column_stack([acceleration, np.sign(speed[at])])
    inertia, friction = np.linalg.lstsq(known[moving], torque[moving], rcond=None)[0].tolist()
    return (inertia, max(0.0, friction)) if inertia > 0.0 else None


# --- loops and gains --------------------------------------------------------------------------------------------------


def tuned_loops(path: TorquePath, rig: RigParameters, bandwidth: float, torque_bandwidth: float) -> list[TunedLoop]:
    """Both loops at their bandwidths.

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

    def motion(f: float) -> LinearLoop:
        return lm.motion_loop(path, f, _INTEGRAL * 2.0 * math.pi * f, speed)

    def torque(f: float) -> LinearLoop:
        return lm.torque_loop(path, f, f, _torque_lag(path))

    shapes = {"torque": torque, "motion": motion}
    found: list[TunedLoop] = []
    for name, wanted in (("torque", torque_bandwidth), ("motion", bandwidth)):
        most = min(limits.values())
        lag = lm.largest_bandwidth(shapes[name], most)
        own = {**limits, "the lag of the torque": lag if lag < 0.99 * most else math.inf}
        limit = min(own, key=lambda key: own[key])
        if wanted > own[limit]:
            option = "--bandwidth" if name == "motion" else "--torque-bandwidth"
            raise SettingError(
                f"{option} {wanted:g} Hz: {limit} allows {own[limit]:.3g} Hz", remedy="Give at most that"
            )
        loop = shapes[name](wanted)
        found.append(TunedLoop(name, wanted, own[limit], limit, loop, lm.margins_of(loop)))
    return found


def _torque_lag(path: TorquePath) -> float:
    return max(0.0, path.lag - path.estimate_lag)


def settings_of(
    path: TorquePath, slope: float, mass: tuple[float, float, str], bandwidth: float, torque_bandwidth: float
) -> Mapping[str, float]:
    """Settings of `TUNED` for both bandwidths."""
    import math

    stiff = 2.0 * math.pi * bandwidth
    inertia, friction, _ = mass
    spring = inertia * stiff * stiff
    damper = 2.0 * inertia * stiff
    return {
        "observer_bandwidth": torque_bandwidth,
        "integral_rate": torque_bandwidth,  # 1/s; the same number is about a sixth of the bandwidth in rad/s
        "torque_lead": path.lag,
        "torque_lag": _torque_lag(path),
        "track_bandwidth": bandwidth,
        "track_integral": _INTEGRAL * stiff,
        "output_inertia": inertia,
        "output_friction": friction,
        "k_p": spring / abs(slope),
        "k_d": damper / abs(slope),
        "stiffness": spring,
        "damping": damper,
    }


# --- what is told -----------------------------------------------------------------------------------------------------


def _as_json(
    model: Model, path: TorquePath, mass: tuple[float, float, str], loops: list[TunedLoop], gains: Mapping[str, float]
) -> dict[str, Any]:
    margins = [
        {
            "loop": one.name,
            "bandwidth": one.bandwidth,
            "largest": one.largest,
            "by": one.limit,
            "phase_deg": one.margins.phase,
            "delay_s": one.margins.delay,
            "sensitivity": one.margins.sensitivity,
        }
        for one in loops
    ]
    moved = {"inertia": mass[0], "friction": mass[1], "from": mass[2]}
    settings = {name: gains[name] for name in TUNED}
    return {"model": model.name, "lag_s": path.lag, "moved_side": moved, "margins": margins, "settings": settings}


def _show(
    model: Model, path: TorquePath, mass: tuple[float, float, str], loops: list[TunedLoop], gains: Mapping[str, float]
) -> None:
    terminal.tell(
        f"{model.name}: the torque is {1e3 * path.lag:.2f} ms late. The moved side has {mass[0]:.3g} kg m2 and "
        f"{mass[1]:.2g} N m of friction ({mass[2]})."
    )
    rows: list[list[str]] = []
    for one in loops:
        bandwidths = [f"{one.bandwidth:g}", f"{one.largest:.3g}", one.limit]
        phase = f"{one.margins.phase:.0f}"
        delay = f"{1e3 * one.margins.delay:.1f}"
        sensitivity = f"{one.margins.sensitivity:.2f}"
        rows.append([one.name, *bandwidths, one.margins.gains, phase, delay, sensitivity])
    heads = ["loop", "Hz", "at most", "by", "gain margin", "phase [deg]", "delay [ms]", "sensitivity"]
    terminal.tell(terminal.table("Margins", heads, rows))
    values = [[name, f"{gains[name]:.4g}", unit] for name, unit in TUNED.items()]
    terminal.tell(terminal.table("Settings", ["name", "value", "unit"], values))


def _toml(model: Model, loops: list[TunedLoop], gains: Mapping[str, float]) -> str:
    digest = model.to_dict()["digest"]
    lines = [f"# Control of {model.name} ({digest[:12]}), by erclutch tune. erclutch live --tuned takes this file."]
    for one in loops:
        m = one.margins
        lines.append(
            f"# {one.name}: {one.bandwidth:g} Hz of at most {one.largest:.3g}; gain margin {m.gains}, phase "
            f"{m.phase:.0f} deg, delay {1e3 * m.delay:.1f} ms, sensitivity {m.sensitivity:.2f}"
        )
    return "\n".join([*lines, *(f"{name} = {gains[name]:.6g}  # {unit}" for name, unit in TUNED.items())]) + "\n"


def describe_loops(loops: list[TunedLoop]) -> Plot:
    """Bode plot, sensitivity and step of both loops: of motion the reference steps, of torque what no model knows."""
    import numpy as np

    from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable, ReferenceLine

    titles = (
        "gain of the loop",
        "phase of the loop",
        "sensitivity |1 / (1 + L)|",
        "step of the reference, or of a torque beyond the model",
    )
    axes = (Axis("gain", "dB", -40.0, 40.0), Axis("phase", "deg", -360.0, 0.0), Axis("sensitivity", "", 0.0, 2.5))
    marks: list[list[Any]] = [[ReferenceLine(0.0)], [ReferenceLine(-180.0)], [ReferenceLine(1.0)], []]
    columns: list[Array] = []
    for style, one in zip(("series1", "series3"), loops, strict=True):
        f, response = one.loop.response()
        phase: Array = np.degrees(np.unwrap(np.angle(response)))
        phase -= 360.0 * round((float(phase[0]) + 180.0) / 360.0)
        gain: Array = 20.0 * np.log10(np.abs(response))
        sensitivity: Array = 1.0 / np.abs(1.0 + response)
        curves = gain, phase, sensitivity
        for panel, curve in zip(marks, curves, strict=False):
            panel.append(Line(f, curve, style, one.name))
        step = one.loop.step()[:400]
        time: Array = one.loop.period * np.arange(step.size, dtype=np.float64)
        marks[3].append(Line(time, step, style, one.name))
        columns += [f, *curves] if not columns else curves
    across = [Axis("frequency", "Hz", 0.1, 500.0, log=True)] * 3 + [Axis("time", "s", 0.0, 0.4)]
    up = (*axes, Axis("step", "", -0.2, 1.6))
    panels = [Panel(x, y, own, title=title) for x, y, own, title in zip(across, up, marks, titles, strict=True)]
    names = ["frequency [Hz]", *(f"{one.name}, {what}" for one in loops for what in ("dB", "deg", "sensitivity"))]
    return Plot(panels, PlotTable(names, np.column_stack(columns).tolist()), 4.6, PAGE, columns=2, legend="shared")
