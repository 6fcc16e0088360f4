"""This module prints tables and sentences on the terminal."""

from __future__ import annotations

import itertools
import json
import math
import os
import shlex
import sys
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, cast

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from erclutch.errors import printable
from erclutch.signals.origins import MEASURED

if TYPE_CHECKING:
    from pathlib import Path

    from erclutch.fit.laws.fit_law import Estimate
    from erclutch.signals.array import Array
    from erclutch.signals.recording import LogFacts

_BROAD = 100  # columns of a screen that has room for an interval and its bound in one line
#: Begins a line that tells how far a command is; see `progress`.
PROGRESS = "erclutch progress: "


def table(
    title: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[str | Text]],
    left: int = 1,
) -> Table:
    """A plain table: the first ``left`` columns to the left, numbers to the right.

    It is as wide as its title, where the screen allows: a title that breaks above two narrow columns reads badly.
    """
    room = console().width
    made = Table(
        title=title,
        title_justify="left",
        min_width=min(len(title), room) if title else None,
        title_style="bold",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    for i, name in enumerate(columns):
        # A name that is cut cannot be told from another, so it goes on in the next line.
        made.add_column(
            name,
            justify="left" if i < left else "right",
            no_wrap=i >= left,
            overflow="fold",
        )
    for row in rows:
        made.add_row(*row)
    return made


def narrowed(
    title: str,
    columns: Mapping[str, Sequence[str]],
    less_needed: Iterable[str],
    width: int,
    left: int = 1,
) -> Table:
    """A table of columns by heading, without those that are less needed, in their order, until it fits the screen."""
    kept = dict(columns)
    for name in less_needed:
        across = 0
        for heading, cells in kept.items():
            texts = [*heading.split("\n"), *cells]
            widest = max(len(text) for text in texts)
            across += widest + 3  # what stands between two columns
        if across <= width:
            break
        kept.pop(name, None)
    rows = list(zip(*kept.values(), strict=True))
    made = table(title, list(kept), rows, left)
    for column in made.columns:
        column.no_wrap = True
    return made


def number(value: float, digits: int = 4, *, zeros: bool = False) -> str:
    """A number to a few digits, infinities and gaps as words; an exponent only where it cannot be read without.

    Args:
        value: the number.
        digits: significant ones.
        zeros: whether zeros at the end stay, so that a column's points stand under one another.
    """
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    text = f"{value:#.{digits}g}" if zeros else f"{value:.{digits}g}"
    if 1.0 <= abs(float(text)) < 1e6:
        # What has more digits before the point than asked for is not 1.81e+03 but 1810.
        return f"{float(text):.0f}" if "e" in text else text.removesuffix(".")
    return text


def with_unit(name: str, unit: str) -> str:
    """A heading with its unit in brackets; unknown units say so."""
    return f"{name} [{told_unit(unit)}]" if unit else name


def told_unit(unit: str) -> str:
    """A unit, "as logged" where any part of it is unknown."""
    from erclutch.signals.units import AS_LOGGED, UNKNOWN

    return AS_LOGGED if UNKNOWN in unit else unit


def recording_lines(
    recordings: Sequence[LogFacts], most: int = 6, made: Sequence[str] = ()
) -> list[str]:
    """What was read, and what was decided on the way.

    Args:
        recordings: logs that were read.
        most: half of the notes that are shown.
        made: notes on the rows that were made of the logs; those of the logs are among them, and are shown once.
    """
    from erclutch.logs.clock.timing import in_no_time

    name = recordings[0].name
    if len(recordings) > 1:
        name = f"{len(recordings)} logs, {name} ... {recordings[-1].name}"
    rows = sum(recording.rows for recording in recordings)
    seconds = sum(recording.duration for recording in recordings)
    periods = sorted({round(recording.period, 9) for recording in recordings})
    rate = " and ".join(f"{1 / period:.6g} Hz" for period in periods[:3])
    cuts = sum(len(recording.segments) - 1 for recording in recordings)
    gaps = f", {cuts} gap{'s' if cuts > 1 else ''}" if cuts else ""
    extent = f"{rows:,} rows, {seconds:.4g} s at {rate}{gaps}"
    if in_no_time(note for recording in recordings for note in recording.notes):
        extent = f"{rows:,} points of a table"
    lines = [f"{name}: {extent}"]

    origins = {recording.origin for recording in recordings}
    by_computer = sorted(origins - MEASURED)
    if by_computer:
        some = " (some of the logs)" if origins & MEASURED else ""
        lines.append(
            f"{' and '.join(by_computer)} data{some}: made by a computer, not a measurement"
        )

    notes = notes_of(recordings)
    of_logs = {note for recording in recordings for note in recording.notes}
    notes += [note for note in dict.fromkeys(made) if note not in of_logs]
    most_notes = 2 * most
    lines += [f"  {note}" for note in notes[:most_notes]]
    if len(notes) > most_notes:
        lines.append(
            f"  ... {len(notes) - most_notes} notes more; erclutch inspect shows all of one log"
        )
    return lines


def notes_of(recordings: Sequence[LogFacts]) -> list[str]:
    """What was said while reading, each once; what is true of one log of several bears its name."""
    logs_of: dict[str, list[str]] = {}  # names of the logs, by note
    for recording in recordings:
        for note in recording.notes:
            logs_of.setdefault(note, []).append(recording.name)
    shared: list[str] = []
    of_one: list[str] = []
    for note, logs in logs_of.items():
        if len(logs) == 1 and len(recordings) > 1:
            of_one.append(f"{logs[0]}: {note}")
        else:
            shared.append(note)
    return [*shared, *of_one]


def rows_left_out(recording: LogFacts) -> list[str]:
    """What was said while reading of rows that a log lost: it is cut where they stood."""
    from erclutch.signals.recording import CUT_THERE

    return [note for note in recording.notes if CUT_THERE in note]


def estimates(title: str, values: Sequence[Estimate]) -> Table:
    """Values with 95 % intervals and units."""
    # A bound goes to the next line on a narrow screen, so that a meaning has room there and no unit is cut.
    between = ", " if console().width >= _BROAD else ",\n"
    rows: list[list[str]] = []
    for estimate in values:
        parts: list[str] = []
        a_range = math.isfinite(estimate.high - estimate.low)
        at_one_number = estimate.low == estimate.high and estimate.at_bound
        if a_range and not at_one_number:
            parts.append(f"{number(estimate.low)} - {number(estimate.high)}")
        if estimate.at_bound:
            parts.append(f"at its {estimate.at_bound} bound")
        interval = between.join(parts) or "not identified"
        rows.append(
            [
                estimate.name,
                estimate.meaning,
                number(estimate.value),
                interval,
                told_unit(estimate.unit),
            ]
        )
    made = table(title, ["", "meaning", "value", "95 % interval", "unit"], rows, left=2)
    made.columns[4].justify = "left"
    return made


def coverage(
    field: Array,
    slip: Array,
    name: str,
    units: tuple[str, str] = ("", ""),
) -> str:
    """Rows over field and slip as a picture of characters; empty where one of them is constant."""
    import numpy as np

    if np.ptp(field) == 0 or np.ptp(slip) == 0:
        return ""
    weakest = float(np.min(field))
    strongest = float(np.max(field))
    rows = np.linspace(weakest, strongest, 9)
    slowest = float(np.min(slip))
    fastest = float(np.max(slip))
    columns = np.linspace(slowest, fastest, 61)
    counts: Array = np.histogram2d(field, slip, bins=[rows, columns])[0]
    darkness = np.log1p(counts) / np.log1p(counts.max())
    shades = np.ceil(darkness * (len(_SHADES) - 1)).astype(int)
    up = with_unit("field", units[0])
    across = with_unit("slip", units[1])
    lines = [
        f"Coverage{name}: rows over {up} (up) and {across} (across); a dot is a cell without a row"
    ]
    for row in reversed(range(8)):
        cells = ""
        for count, shade in zip(counts[row], shades[row], strict=True):
            cells += "·" if count == 0 else _SHADES[shade]
        middle = (rows[row] + rows[row + 1]) / 2
        lines.append(f"{middle:>10.3g} {cells}")
    leftmost = f"{columns[0]:.3g}"
    rightmost = f"{columns[-1]:.3g}"
    lines.append(f"{'':>10} {leftmost}{rightmost:>{60 - len(leftmost)}}")
    return "\n".join(lines)


def bands(values: Array, rate: float) -> list[tuple[float, float, float]]:
    """Share of a signal's power in bands of frequency up to 200 Hz: (from, to, share)."""
    import numpy as np

    off_mean = values - np.mean(values)
    amplitudes = np.abs(np.fft.rfft(off_mean))
    power = amplitudes**2
    frequency = np.fft.rfftfreq(values.size, 1.0 / rate)
    edges = [edge for edge in (0.0, 2.0, 10.0, 50.0, 100.0, 200.0) if edge <= rate / 2]
    total = float(power.sum()) or 1.0
    shares: list[tuple[float, float, float]] = []
    for low, high in itertools.pairwise(edges):
        inside = (frequency >= low) & (frequency < high)
        of_band = float(power[inside].sum())
        shares.append((low, high, of_band / total))
    return shares


_SHADES = " ░▒▓█"


def say(*lines: object) -> None:
    """Lines on standard output as they are: no markup, not wrapped."""
    for line in lines:
        console().print(str(line), markup=False, soft_wrap=True)


def kept_lines(run: Path | None) -> tuple[str, ...]:
    """Where a run was kept, and the command that shows it; or how to keep it."""
    if run is None:
        return ("Nothing was kept; --out RUN keeps it.",)
    return f"Kept in {run}", f"Read it: {shlex.join(['erclutch', 'report', str(run)])}"


def tell(*parts: str | Table, style: str = "") -> None:
    """Sentences and tables on standard output, wrapped at its width: no markup."""
    for part in parts:
        console().print(part, markup=False, style=style)


def say_json(body: object) -> None:
    """A value as JSON on standard output; a number that is none (not finite) is null."""
    text = json.dumps(_finite(body), indent=1, allow_nan=False)
    sys.stdout.write(text + "\n")


def _finite(value: Any) -> Any:
    """A value of JSON with null in place of each number that is not finite, however deep it stands."""
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in cast("Mapping[str, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in cast("Sequence[Any]", value)]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


class Bar(Protocol):
    """Called with how much is done, of how much (None: nobody knows), and what is done now."""

    def __call__(
        self,
        done: float,
        total: float | None,
        doing: str,
        /,
        **more: str | float | None,
    ) -> None:
        """Further values are for a program that follows; a terminal does not show them."""


@contextmanager
def progress(title: str) -> Generator[Bar]:
    """A bar on a terminal's standard error.

    With ``ERCLUTCH_PROGRESS=lines`` each call is a line of JSON behind `PROGRESS`, for a program that shows them.
    """

    def print_line(
        done: float,
        total: float | None,
        doing: str,
        /,
        **more: str | float | None,
    ) -> None:
        line = {"done": done, "total": total, "doing": doing, **more}
        print(PROGRESS + json.dumps(line), file=sys.stderr, flush=True)

    if os.environ.get("ERCLUTCH_PROGRESS") == "lines":
        print_line(0.0, None, title)  # at once: the first step may take seconds
        yield print_line
        return
    from rich.progress import Progress

    screen = Console(stderr=True)
    with Progress(
        console=screen,
        transient=True,
        disable=not screen.is_terminal,
    ) as bar:
        task = bar.add_task(title, total=None)

        def move(
            done: float,
            total: float | None,
            doing: str,
            /,
            **more: str | float | None,
        ) -> None:
            bar.update(task, completed=done, total=total, description=doing)

        yield move


def shown(text: str) -> str:
    """A text that a terminal only shows, see `printable`; here line ends stay."""
    return "\n".join(map(printable, text.split("\n")))


class _Screen(Console):
    """All texts pass here, also titles and cells: what files and their names bring may hold commands to a terminal."""

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(shown(text), **options)


def console(*, stderr: bool = False) -> Console:
    """Standard output, or the errors'; wide enough for the tables where it is not a terminal and nobody set COLUMNS."""
    made = _Screen(
        highlight=False,
        markup=False,
        emoji=False,
        stderr=stderr,
    )
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = 150
    return made
