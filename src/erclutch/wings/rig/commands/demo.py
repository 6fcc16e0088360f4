"""``erclutch demo`` goes the whole road, with the digital twin as the rig."""

from __future__ import annotations

import io
import time
from collections.abc import Generator
from contextlib import contextmanager, nullcontext, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import SECONDS
from erclutch.errors import RunError, require
from erclutch.files import takes_files
from erclutch.files.places import is_there, release, reserve

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, FitStep
    from erclutch.report.numbers.run_material import Material

COMMAND = {
    "help": "See it work: the digital TWIN collects a log, all models of the paper are fitted to it.",
    "panel": "The road of a log",
    "place": 1,
}

_WHAT = (
    "A clutch with an electrorheological fluid passes a torque on that a voltage sets. To control it without a torque "
    "sensor one needs a model of that torque. This demo makes one from a log, as you would from yours."
)
_TWIN = (
    "The log comes from a digital twin of the rig of Huang and Ishikawa: two such clutches on a ball screw. It is a "
    "computer's, no measurement, and none of the models below is what it is made of."
)
_MEANINGS = {
    "bingham/forward": "a yield torque and a viscous one, the textbook law",
    "seo-seo/forward": "a yield torque that dips with speed",
    "hem/forward": "viscosity that follows the field",
    "rbfm-5/forward": "viscosity as five bumps over the field",
    "rbfm-10/forward": "viscosity as ten bumps over the field",
    "rbfn-10": "a network of ten radial neurons, no physics inside",
    "rbfn-50": "the same with fifty",
    "fnn-6": "a network of six neurons",
    "fnn-16": "the same with sixteen",
    "fnn-10-6": "a network of two layers",
}


def demo(
    *,
    seconds: Annotated[float, SECONDS] = 290.0,
    seed: int = 0,
    out: Path = Path("erclutch-demo"),
    open_: Annotated[bool, Parameter(name="--open", negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Let the digital TWIN collect a log, fit every model of the paper's table II, write a report.

    Args:
        seconds: Rig time of the log; the paper's log has 290.
        seed: Seed of the commands and the noise.
        out: Folder for the log, the run and the report; the folder of an earlier demo is replaced.
        open_: Open the report.
        json: Print what the run keeps as JSON instead of the story.
    """
    require(10, 3600, " s", seconds=seconds)
    require(0, seed=seed)
    # The folder of an earlier demo may be replaced, nothing else.
    if not out.parent.is_dir() or not takes_files(out.parent):
        problem = "its parent folder cannot be written"
        raise RunError(problem, where=str(out), remedy="Give another --out")
    reserve(out, _is_demo)
    if is_there(out) and not _is_demo(out):
        release(out)
        problem = "exists and is not the folder of a demo"
        raise RunError(problem, where=str(out), remedy="Give another --out")
    with redirect_stdout(io.StringIO()) if json else nullcontext():
        screen = terminal.console()
        began = time.perf_counter()
        screen.print(_WHAT, soft_wrap=not screen.is_terminal)
        screen.print(f"TWIN: {_TWIN}", style="magenta", soft_wrap=not screen.is_terminal)
        _run(out, seconds, seed)
        terminal.tell(f"{time.perf_counter() - began:.0f} s in all.")
    if json:
        from erclutch.runs.run_folder import read_run

        files = {"log": f"{out / 'twin.parquet'}", "report": f"{out / 'report.html'}"}
        terminal.say_json({"data": "TWIN", **files, "run": read_run(out / "run").body})
    if open_:
        from erclutch.cli.commands.report import open_file

        open_file(out / "report.html")


def _is_demo(folder: Path) -> bool:
    return folder.is_dir() and {path.name for path in folder.iterdir()} == {
        "report.html",
        "run",
        "twin.parquet",
    }


def _run(out: Path, seconds: float, seed: int) -> None:
    """Collect, fit, report: in a folder that gets its name once all is there."""
    from erclutch.files import whole_folder
    from erclutch.fit.comparison import Settings, compare
    from erclutch.logs import read
    from erclutch.logs.covering_stretches import USUAL_SHARE
    from erclutch.logs.dataset import build_dataset
    from erclutch.report.html.report_page import write_report
    from erclutch.report.numbers.run_material import material_of
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.written_run import unwritable, write_run
    from erclutch.signals.speed import Derivative
    from erclutch.wings.rig.commands.simulate import collect
    from erclutch.wings.rig.twin.scenarios import prepare

    with whole_folder(out, unwritable) as folder:
        with _step(
            "1 of 3  Collecting",
            "random fields on one clutch at a time, random motor torque (section III-B)",
        ):
            log = collect(prepare("training", seconds=seconds, seed=seed), folder / "twin.parquet")
            recording = read(log, device="coaxial")
        held = round(USUAL_SHARE * recording.rows)
        why = f"10 models on {recording.rows - held:,} rows; the last {held:,} are held out to judge them"
        with _step("2 of 3  Fitting", why):
            by_difference = Derivative("difference")
            data = build_dataset(recording, device="coaxial", derivative=by_difference)
            with terminal.progress("laws first, then networks") as bar:

                def show(step: FitStep) -> None:
                    """A line for each model as it is fitted, and a step of the bar."""
                    if step.fitted:
                        terminal.tell(f"  {step.fitted:<16} {_MEANINGS.get(step.fitted, '')}")
                    bar(step.done, 1.0, step.doing)

                comparison = compare(data, Settings(models=("paper",), lag="none"), show)
            reading = {"device": "coaxial", "derivative": "difference"}
            write_run(folder / "run", comparison, [recording], reading=reading)
        with _step("3 of 3  Writing the report", "one file to look at and to forward"):
            material = material_of(read_run(folder / "run"))
            write_report(material, folder / "report.html")
        _sum_up(material, comparison)
    terminal.say(f"Report: {(out / 'report.html').resolve()}")
    words = "Next, your own log: erclutch inspect LOG, then erclutch fit LOG --out RUN and erclutch report RUN."
    terminal.tell(words)


@contextmanager
def _step(name: str, why: str) -> Generator[None, None, None]:
    """A line that says what happens and why, and how long it took."""
    terminal.tell(f"\n{name}: {why}")
    began = time.perf_counter()
    yield
    terminal.tell(f"  done in {time.perf_counter() - began:.1f} s", style="dim")


def _sum_up(material: Material, comparison: Comparison) -> None:
    """The ranking, and what it means in plain words."""
    from erclutch.cli import ranking_table
    from erclutch.report.numbers.number_text import percent_text, plain
    from erclutch.signals.units import amount

    screen = terminal.console()
    screen.print()
    screen.print(ranking_table.ranking(comparison, screen.width))
    chosen = material.run.entry(material.recommended)
    textbook = material.recommended
    for name, role in material.shown.items():
        if role == "baseline":
            textbook = name
            break
    unit = material.body["units"]["effort"]

    def in_words(error: float) -> str:
        """An error in the unit of the table above."""
        return amount(terminal.number(error), unit)

    error = in_words(chosen["test"]["rmse"][0])
    words = (
        f"Recommended: {comparison.called(chosen['name'])}. On rows that it has not seen it errs by {error}, "
        f"{percent_text(chosen['test']['share'][0], 2)} of the torque's standard deviation"
    )
    if textbook != chosen["name"]:
        theirs = material.run.entry(textbook)["test"]["rmse"][0]
        words += f"; the textbook, {material.run.titles[textbook]}, by {in_words(theirs)}"
    screen.print(
        plain(f"{words}."),
        style="bold",
        markup=False,
        soft_wrap=not screen.is_terminal,
    )
    why = ranking_table.worth_its_freedom(comparison)
    if why:
        of_parts = f"{comparison.chosen_by} of the training rows, left out in turn"
        it_errs = f"it errs by {in_words(chosen['validation_rmse'][0])}"
        screen.print(
            plain(f"On {of_parts}, {it_errs}. {why}"),
            markup=False,
            soft_wrap=not screen.is_terminal,
        )
