"""Figure 3: a section of a log, inputs above, torque below."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.figures.style import BLACK, BLUE, ORANGE, RED, new_figure, save, save_numbers, style
from erclutch.signals import Recording

Array = NDArray[np.float64]

_TITLES = {
    "field": "Field",
    "slip": "Slip",
    "position": "Position",
    "effort": "Effort",
    "theta_dot": "Speed",
    "motor_torque": "Motor torque",
    "T": "Torque",
}


def draw_section(recording: Recording, path: Path, *, start: float | None = None, seconds: float = 1.0) -> list[Path]:
    """Draw a section of inputs and effort, and write its numbers beside it.

    Args:
        recording: the log.
        path: .png, .pdf or .svg; the numbers go to the same name with .csv.
        start: first second shown; None: where the effort varies most evenly (the median section).
        seconds: length.

    Returns:
        The files written.
    """
    rows = _rows(recording, start, seconds)
    time = recording.time[rows] - recording.time[rows.start]
    panels = _panels(recording)
    with style():
        figure: Any = new_figure(0.45 + 0.95 * len(panels))
        axes: Any = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (title, unit, lines) in zip(axes, panels, strict=True):
            for name, values, colour in lines:
                axis.plot(time, values[rows], color=colour, label=name, drawstyle="steps-post")
            axis.set_ylabel(f"{title}\n[{unit}]" if unit else title)
            if len(lines) > 1:
                axis.legend(ncols=len(lines), loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0)
        axes[-1].set_xlabel(f"Time from {recording.time[rows.start]:.2f} s [s]")
        axes[-1].set_xlim(0.0, float(time[-1]))
        axes[0].set_title(titled(recording), loc="left")
        figure.align_ylabels()
        save(figure, path)
    lines = [(name, values) for _, _, group in panels for name, values, _ in group]
    table = zip(time.tolist(), *(values[rows].tolist() for _, values in lines), strict=True)
    return [path, save_numbers(path.with_suffix(".csv"), ["time", *(name for name, _ in lines)], table)]


def titled(recording: Recording) -> str:
    """Name of a log with the label that a computer-made one carries."""
    return f"{recording.name} ({recording.origin})" if recording.origin else recording.name


def _rows(recording: Recording, start: float | None, seconds: float) -> slice:
    width = min(max(2, round(seconds / recording.period)), recording.rows)
    if start is not None:
        first = int(np.count_nonzero(recording.time < recording.time[0] + start))
        return slice(min(first, recording.rows - width), min(first, recording.rows - width) + width)
    effort = recording.signals["effort" if "effort" in recording.signals else "T"]
    starts = range(0, recording.rows - width + 1, max(1, width // 2))
    spread = [float(effort[s : s + width].std()) for s in starts]
    first = starts[sorted(range(len(spread)), key=spread.__getitem__)[len(spread) // 2]]
    return slice(first, first + width)


def _unit(recording: Recording, signal: str) -> str:
    unit = recording.units[signal]
    return "as logged" if unit == "?" else unit.replace("*", " ")


def _panels(recording: Recording) -> list[tuple[str, str, list[tuple[str, Array, str]]]]:
    """Title, unit and lines of each panel: fields, motor torque or speeds, effort."""
    signals = recording.signals
    fields = [name for name in ("field", "E1", "E2", "E") if name in signals]
    panels = [("Field", _unit(recording, fields[0]), _lines(recording, fields))]
    for names in (("motor_torque",), ("theta_dot", "alpha_dot"), ("slip",), ("position",)):
        present = [name for name in names if name in signals]
        if present:
            panels.append((_TITLES[present[0]], _unit(recording, present[0]), _lines(recording, present)))
    effort = "effort" if "effort" in signals else "T"
    title = {"N": "Force", "N*m": "Torque"}.get(recording.units[effort], _TITLES[effort])
    panels.append((title, _unit(recording, effort), [(effort, signals[effort], BLACK)]))
    return panels


def _lines(recording: Recording, names: list[str]) -> list[tuple[str, Array, str]]:
    return [(name, recording.signals[name], colour) for name, colour in zip(names, (BLUE, RED, ORANGE), strict=False)]
