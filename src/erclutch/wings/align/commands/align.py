"""``erclutch align`` joins two logs of one experiment whose clocks differ."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.errors import SettingError
from erclutch.files import LOG_ENDINGS, may_write_file, spare_logs
from erclutch.files.groups import together

if TYPE_CHECKING:
    from erclutch.wings.align.aligned_logs import AlignedLogs

COMMAND = {
    "help": "Join two logs of one experiment whose clocks differ, by a signal that both have.",
    "panel": "More logs",
    "place": 1,
}

_Names = Annotated[tuple[str, ...], Parameter(consume_multiple=True, negative=())]


def align(
    a: Annotated[Path, Parameter(name="A")],
    b: Annotated[Path, Parameter(name="B")],
    /,
    *,
    out: Path,
    on: _Names = (),
    near: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    picture: Path | None = None,
    time: _Names = (),
    rate: _Names = (),
    variable: _Names = (),
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Find offset and drift between the clocks of two logs of one experiment, and write both as one log.

    The log that is written has the columns of A at A's times, and B's columns beside them, filtered where B is faster.
    A picture shows the signal before and after, and the offset that is left.

    Args:
        a: The log whose clock and rows are kept.
        b: The log that is brought to A's clock and rows. Where its own clock restarts, each part gets an offset.
        out: File to write: .csv, .parquet or .mat.
        on: Column of the signal that both logs have, or its column in A and its column in B. Default: the only name in
            both.
        near: How far B's clock is ahead of A's, roughly, such as 2.5s: for logs in which several offsets fit equally.
        picture: File for the picture: .png, .svg or .pdf, with its numbers beside it as CSV. Default: OUT-clocks.png.
        time: Time column of both logs, or that of A and that of B.
        rate: Sampling rate in Hz in place of a time column, of both logs or of A and of B.
        variable: Which recording of a file that holds several, of both logs or of A and of B; none: that file has one.
        force: Replace files that are there.
    """
    image = picture or out.with_name(f"{out.stem}-clocks.png")
    numbers = image.with_suffix(".csv")
    spare_logs([a, b], [out, image, numbers], "--out or --picture")
    may_write_file(out, force, endings=LOG_ENDINGS)
    if numbers == out:
        raise SettingError(
            f"the numbers of the picture go to {numbers.name}, and --out is that file",
            where=str(image),
            remedy="Give --picture another name",
        )
    if image.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise SettingError(
            "the picture cannot have this name",
            where=str(image),
            remedy="Give --picture a name that ends in .png, .svg or .pdf",
        )
    for option, values in (("--time", time), ("--rate", rate), ("--variable", variable)):
        if len(values) > 2:
            remedy = "Give one for both logs, or two"
            raise SettingError("more than two values", where=option, remedy=remedy)
    may_write_file(image, force, "picture")
    may_write_file(numbers, force, "picture")

    logs = aligned(a, b, on, near, time, rate, variable)
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.align.clocks_plot import describe_clocks

    terminal.tell(*logs.notes)
    match = logs.matches[0]
    terminal.tell(
        f"correlation {match.correlation:.3f}; the overlap is worth {match.independent:.0f} independent samples"
    )
    plot = describe_clocks(logs.matches, logs.traces, logs.signal[0], logs.joined.origin)
    with together():
        logs.write(out)
        save_plot(plot, image)
    terminal.say(f"Written to {out}: {logs.joined.rows:,} rows; picture {image}")


def aligned(
    a: Path,
    b: Path,
    on: tuple[str, ...],
    near: str | None,
    time: tuple[str, ...] = (),
    rate: tuple[str, ...] = (),
    variable: tuple[str, ...] = (),
) -> AlignedLogs:
    """Two log files as one log.

    Raises:
        LogError, MappingError: a log cannot be read, or their clocks cannot be matched.
    """
    from erclutch.logs.keywords import SECONDS, number_of
    from erclutch.logs.mapping import NONE
    from erclutch.wings.align.aligned_logs import align as aligned_logs

    def own(option: tuple[str, ...], log: int) -> str:
        """A log's value of an option; a single value is for both."""
        return option[min(log, len(option) - 1)]

    times: list[dict[str, str]] = [{}, {}]  # what is said of A, and of B
    for log, known in enumerate(times):
        if time:
            known["time"] = own(time, log)
        if rate:
            known["rate"] = own(rate, log)
        if variable and own(variable, log) != NONE:
            known["variable"] = own(variable, log)
    about = None if near is None else number_of("near", near, SECONDS, "2.5s or --near=-7ms")
    with terminal.progress("matching clocks"):
        return aligned_logs(a, b, on, near=about, times=times)
