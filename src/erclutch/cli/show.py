"""Tables and sentences of the terminal."""

from __future__ import annotations

import itertools
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from erclutch.dataset import constant_stretches
from erclutch.evaluate import MANY_AT_REST, NEXT_TO_NOTHING, TOLERATED
from erclutch.signals import Array

if TYPE_CHECKING:
    from erclutch.comparison import AnyOutcome, Comparison, Entry
    from erclutch.evaluate import Figure
    from erclutch.fit import Estimate
    from erclutch.signals import Recording


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str | Text]], left: int = 1) -> Table:
    """A plain table: the first ``left`` columns to the left, numbers to the right."""
    made = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for i, name in enumerate(columns):
        made.add_column(name, justify="left" if i < left else "right", no_wrap=i >= left)
    for row in rows:
        made.add_row(*row)
    return made


def number(value: float, digits: int = 4, *, zeros: bool = False) -> str:
    """A number to a few digits, infinities and gaps as words; an exponent only where it cannot be read without.

    Args:
        value: the number.
        digits: significant ones.
        zeros: whether zeros at the end stay, so that a column's points stand under one another.
    """
    if np.isnan(value):
        return "-"
    if np.isinf(value):
        return "inf" if value > 0 else "-inf"
    text = f"{value:#.{digits}g}" if zeros else f"{value:.{digits}g}"
    if 1.0 <= abs(float(text)) < 1e6:
        # What has more digits before the point than asked for is not 1.81e+03 but 1810.
        return f"{float(text):.0f}" if "e" in text else text.removesuffix(".")
    return text


def with_unit(name: str, unit: str) -> str:
    """A heading with its unit in brackets; unknown units say so."""
    return name if unit == "" else f"{name} [{'as logged' if unit == '?' else unit}]"


def recording_lines(recordings: Sequence[Recording], most: int = 6) -> list[str]:
    """What was read, and what was decided on the way."""
    first = recordings[0]
    rows = sum(r.rows for r in recordings)
    seconds = sum(r.duration for r in recordings)
    cuts = sum(len(r.segments) - 1 for r in recordings)
    what = first.name if len(recordings) == 1 else f"{len(recordings)} logs, {first.name} ... {recordings[-1].name}"
    periods = sorted({round(r.period, 9) for r in recordings})
    rate = " and ".join(f"{1 / p:.6g} Hz" for p in periods[:3])
    gaps = f", {cuts} gap{'s' if cuts > 1 else ''}" if cuts else ""
    lines = [f"{what}: {rows:,} rows, {seconds:.4g} s at {rate}{gaps}"]
    made = sorted({r.origin for r in recordings if r.origin})
    if made:
        some = "" if all(r.origin for r in recordings) else " (some of the logs)"
        lines.append(f"{' and '.join(made)} data{some}: made by a computer, not a measurement")
    notes = notes_of(recordings)
    lines += [f"  {note}" for note in notes[: most * 2]]
    if len(notes) > most * 2:
        lines.append(f"  ... {len(notes) - most * 2} notes more; erclutch inspect shows all of one log")
    return lines


def notes_of(recordings: Sequence[Recording]) -> list[str]:
    """What was said while reading, each once; what is true of one log of several bears its name."""
    said = Counter(note for r in recordings for note in r.notes)
    names = {note: r.name for r in recordings for note in r.notes}
    own = {note for note, times in said.items() if times == 1 and len(recordings) > 1}
    return [f"{names[note]}: {note}" if note in own else note for note in sorted(said, key=lambda n: n in own)]


def _band(figure: Figure) -> str:
    return f"{number(figure.low, 3)} - {number(figure.high, 3)}"


def _percent(figure: Figure) -> str:
    value, low, high = (100.0 * v for v in figure.to_list())
    return f"{value:+.1f} % ({low:+.1f} .. {high:+.1f})" if abs(value) < 1e3 else "far worse"


def ranking(comparison: Comparison, width: int) -> Table:
    """Models, best test error first; on a narrow screen the less needed columns are left out."""
    unit = comparison.data.units.effort
    cells: dict[str, list[str]] = {
        "": ["*" if e.name == comparison.recommended else "" for e in comparison.entries],
        "model": [e.name for e in comparison.entries],
        "par.": [str(e.outcome.parameters) for e in comparison.entries],
        with_unit("test RMSE", unit): [number(e.test.rmse.value, zeros=True) for e in comparison.entries],
        "95 % band": [_band(e.test.rmse) for e in comparison.entries],
        "over the best": ["" if e.name == comparison.best else _percent(e.excess) for e in comparison.entries],
        "of std": [f"{100 * e.test.share.value:.1f} %" for e in comparison.entries],
        "R2": [f"{e.test.r2.value:.3f}" for e in comparison.entries],
        "max error": [number(e.test.largest.value, 3) for e in comparison.entries],
        "train RMSE": [number(e.train.rmse.value, zeros=True) for e in comparison.entries],
        "condition": ["" if e.outcome.weights else f"{e.outcome.condition:.0e}" for e in comparison.entries],
    }
    if any(e.folds for e in comparison.entries):
        folds = f"{len(comparison.entries[0].folds)}-block RMSE"
        cells[folds] = [number(float(np.sqrt(np.mean(np.square(e.folds))))) for e in comparison.entries]
    for name in ("condition", "max error", "R2", "train RMSE", "over the best", "par.", "95 % band"):
        if sum(max(map(len, [head, *column])) + 2 for head, column in cells.items()) + len(cells) <= width:
            break
        cells.pop(name)
    rows = [list(row) for row in zip(*cells.values(), strict=True)]
    made = table("Models on the rows held out (* recommended)", list(cells), rows, left=2)
    made.columns[1].no_wrap = True
    return made


def verdict(comparison: Comparison) -> str:
    """The recommendation in a sentence or two."""
    share = comparison.entry(comparison.recommended).test.share.value
    if not share > NEXT_TO_NOTHING:
        return _recommended(comparison)
    return (
        f"{_recommended(comparison)} But it explains next to nothing: a constant would err by {1 / share:.0%} of that."
    )


def _recommended(comparison: Comparison) -> str:
    best, chosen = comparison.entry(comparison.best), comparison.entry(comparison.recommended)
    unit = comparison.data.units.effort.replace("?", "")
    if len(comparison.entries) == 1:
        return f"Only {chosen.name} was fitted, so there is nothing to recommend it over."
    if not chosen.sound:
        return f"Nothing to recommend: these data identify no model's parameters. The nearest is {chosen.name}."
    if best.name == chosen.name:
        return f"Recommended: {chosen.name}. It is the best, and no simpler model is as good."
    if chosen.excess.value > TOLERATED and chosen.excess.low > 0.0:
        return (
            f"Recommended: {chosen.name}, the best model that can be trusted. {best.name} errs by less, but see its "
            f"note above; {chosen.name} errs by {_percent(chosen.excess)} more."
        )
    doubt = "" if best.sound else ", not to be trusted: see its note above"
    return (
        f"Recommended: {chosen.name} ({chosen.outcome.parameters} parameters), the simplest model that is as good as "
        f"the best one, {best.name} ({best.outcome.parameters} parameters{doubt}): inside its 95 % band, "
        f"{_band(best.test.rmse)} {unit}, with an error {_percent(chosen.excess)} over its own."
    )


def held_out(comparison: Comparison) -> str:
    """Which rows were held out, where that is not the end of each log."""
    test, data = comparison.settings.test, comparison.data
    if not isinstance(test, float | int):
        logs = [name for name, (a, b) in zip(data.sources, data.source_rows, strict=True) if comparison.test[a:b].all()]
        more = f" and {len(logs) - 6} more" if len(logs) > 6 else ""
        return f"held out: {', '.join(logs[:6])}{more}"
    cut = [rows for rows in data.source_rows if constant_stretches(data, *rows)]
    if not cut:
        return ""
    return f"held out: the last {test:.0%} of each stretch between gaps, since each has a field of its own"


def at_rest(comparison: Comparison) -> str:
    """The error over rows in motion, where many of those held out are at rest."""
    still = comparison.data.at_rest[comparison.test]
    share = float(still.mean())
    if share < MANY_AT_REST or share == 1.0:
        return ""
    chosen = comparison.entry(comparison.recommended)
    error = (comparison.data.effort - chosen.predicted)[comparison.test][~still]
    unit = comparison.data.units.effort.replace("?", "")
    moving, overall = (number(v, zeros=True) for v in (float(np.sqrt(np.mean(error**2))), chosen.test.rmse.value))
    return (
        f"{share:.0%} of the rows held out are at rest, where effort and errors are small: over those in motion "
        f"{chosen.name} errs by {moving} {unit}, not {overall}."
    )


def parameters(outcome: AnyOutcome) -> Table | str:
    """Parameters of a model with their intervals, and the published symbols where they differ; a network's count."""
    if outcome.weights:
        return f"{outcome.model.name}: {outcome.weights} weights, which mean nothing one by one."
    made = estimates(f"Parameters of {outcome.model.name}", outcome.estimates)
    for name, value in outcome.paper_form.items():
        made.add_row(name, "as published", number(value), "", "")
    return made


def estimates(title: str, values: Sequence[Estimate]) -> Table:
    """Values with 95 % intervals and units."""
    rows = [[e.name, e.meaning, number(e.value), _interval(e), e.unit] for e in values]
    made = table(title, ["", "meaning", "value", "95 % interval", "unit"], rows, left=2)
    made.columns[4].justify = "left"
    return made


def _interval(estimate: Estimate) -> str:
    if estimate.at_bound:
        return f"at its {estimate.at_bound} bound"
    if np.isinf(estimate.high - estimate.low):
        return "not identified"
    return f"{number(estimate.low)} - {number(estimate.high)}"


def model_notes(entries: Sequence[Entry]) -> list[str]:
    """What to worry about, a line a model."""
    return [f"  {entry.name}: {'; '.join(entry.notes)}" for entry in entries if entry.notes]


def coverage(field: Array, slip: Array, name: str, units: tuple[str, str] = ("", "")) -> str:
    """Rows over field and slip as a picture of characters; empty where one of them is constant."""
    if np.ptp(field) == 0 or np.ptp(slip) == 0:
        return ""
    rows = np.linspace(float(np.min(field)), float(np.max(field)), 9)
    columns = np.linspace(float(np.min(slip)), float(np.max(slip)), 61)
    counts: Array = np.histogram2d(field, slip, bins=[rows, columns])[0]
    steps = np.ceil(np.log1p(counts) / np.log1p(counts.max()) * (len(_SHADES) - 1)).astype(int)
    up, across = with_unit("field", units[0]), with_unit("slip", units[1])
    lines = [f"Coverage{name}: rows over {up} (up) and {across} (across); a dot is a cell without a row"]
    for row in reversed(range(8)):
        cells = "".join(
            "·" if count == 0 else _SHADES[step] for count, step in zip(counts[row], steps[row], strict=True)
        )
        lines.append(f"{(rows[row] + rows[row + 1]) / 2:>10.3g} {cells}")
    left, right = f"{columns[0]:.3g}", f"{columns[-1]:.3g}"
    return "\n".join([*lines, f"{'':>10} {left}{right:>{60 - len(left)}}"])


def bands(values: Array, rate: float) -> list[tuple[float, float, float]]:
    """Share of a signal's power in bands of frequency up to 200 Hz: (from, to, share)."""
    power = np.abs(np.fft.rfft(values - np.mean(values))) ** 2
    frequency = np.fft.rfftfreq(values.size, 1.0 / rate)
    edges = [edge for edge in (0.0, 2.0, 10.0, 50.0, 100.0, 200.0) if edge <= rate / 2]
    total = float(power.sum()) or 1.0
    return [
        (a, b, float(power[(frequency >= a) & (frequency < b)].sum()) / total) for a, b in itertools.pairwise(edges)
    ]


_SHADES = " ░▒▓█"


def console() -> Console:
    """Standard output; wide enough for the tables where it is not a terminal and nobody set COLUMNS."""
    made = Console(highlight=False)
    return made if made.is_terminal or "COLUMNS" in os.environ else Console(highlight=False, width=150)
