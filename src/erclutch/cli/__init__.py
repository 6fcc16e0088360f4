"""The command line imports what a command needs when it runs, so that ``erclutch --help`` answers at once."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from erclutch._version import __version__
from erclutch.errors import ErclutchError


def _versions() -> str:
    """The version alone on the first line; below it what a report of a bug needs."""
    import os
    import platform
    import shutil
    from importlib.metadata import version
    from importlib.util import find_spec

    zig = "zig" if find_spec("ziglang") else "none"
    compiler = os.environ.get("CC") or next(filter(None, map(shutil.which, ("gcc", "clang", "cc"))), zig)
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba", "pandas", "matplotlib"))
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return f"{__version__}\n{python} on {platform.platform()}\n{packages}\nC compiler: {compiler}"


def _misused(error: CycloptsError) -> object:
    """What is wrong with the words of a command, framed; some may be names of files that the shell put there."""
    from cyclopts import CycloptsPanel

    from erclutch.cli.terminal import shown

    return CycloptsPanel(shown(str(error)))


app = App(
    name="erclutch",
    help="Turn a test-bench log of a clutch, brake or damper with an ER or MR fluid into a checked torque model.",
    version=_versions,
    help_format="plaintext",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
    error_formatter=_misused,
)
_COMMANDS = {
    "demo": "See it work: the digital TWIN collects a log, all models of the paper are fitted to it.",
    "app": "Show a folder of logs and runs as a page: drop a log, fit, read the report, export.",
    "inspect": "Show what is in a log and what each column is taken for.",
    "align": "Join two logs of one experiment whose clocks differ, by a signal that both have.",
    "fit": "Fit all models to a log, rank them on rows held out, recommend one.",
    "recalibrate": "Adapt a kept model to a new log of the same or a sister device, from few rows.",
    "report": "Write the report of a run: one HTML file, or a PDF for print.",
    "predict": "Write the effort of a kept model for each row of a log, with its band.",
    "score": "Score the models of a run on another log.",
    "compare": "Compare runs on the rows that all of them held out.",
    "figure": "Draw a figure of a run for a paper: PDF, PNG and the numbers behind it.",
    "table": "Print a table of a run for a paper: LaTeX, Markdown, HTML or CSV.",
    "fit-large": "Fit models to logs larger than memory, block by block.",
    "fit-many": "Fit the same models to each of many logs or devices; one table, one report, outliers and trends.",
    "simulate": "Run one of the paper's scenarios on the digital TWIN and write the log.",
    "reproduce": "Print the paper's tables and draw its sweeps, on the digital TWIN or on your log.",
    "calibrate-twin": "Calibrate the digital TWIN to a log, or to the paper's summary figures.",
    "excite": "Write a command sequence that excites a pair of clutches well (section III-B).",
    "live": "Estimate, control, record and watch at 1 kHz, on the digital TWIN or on your rig.",
    "tune": "Find gains of torque and motion control from the model of a run, with margins and pictures.",
    "experiment": "Run the paper's online experiments with the live loop: figures 7 to 13.",
    "flowcurve": "Fit laws of shear stress to flow curves.",
    "export": "Write a model for a controller: C99, C++, Python, ONNX, FMU, Simulink, MuJoCo.",
    "verify": "Run an export on its test vectors against the model.",
    "laws": "List the laws.",
    "plugins": "List laws, readers, stages, targets and rigs, with the packages that bring them.",
    "cite": "Print how to cite erclutch and the paper: as text or BibTeX.",
    "recover": "Make a whole recording of one that a crash left open or that is damaged.",
}
#: Commands whose names are taken: `app` by what runs them all, `table` by the module of logs.
_MODULES = {"app": "app_page", "table": "table_for_paper"}
for _order, (_name, _help) in enumerate(_COMMANDS.items()):
    _module = _MODULES.get(_name, _name.replace("-", "_"))
    app.command(f"erclutch.cli.{_module}:{_module}", name=_name, help=_help, sort_key=_order)
app.register_install_completion_command(  # pyright: ignore[reportUnknownMemberType]
    help="Let bash, zsh, fish or PowerShell complete commands and options with Tab."
)

_FIRST = """erclutch turns a log of an ER or MR clutch, brake or damper into a checked torque model.

What to do first:
  erclutch demo                 see it work, on a log of the digital twin
  erclutch inspect LOG          see what is in your file and how it is read
  erclutch fit LOG              fit and rank all models; --out RUN keeps the result
  erclutch report RUN           write the result as one file to read and to forward
  erclutch app                  the same as a page in the browser
  erclutch laws                 list the models

erclutch COMMAND --help explains a command and all its options.
"""


@app.default
def first(*words: Annotated[str, Parameter(show=False)]) -> int:
    """Say what to do first."""
    if words:
        import difflib

        near = difflib.get_close_matches(words[0], _COMMANDS, n=1)
        hint = f"Did you mean {near[0]}?" if near else f"Commands are {', '.join(_COMMANDS)}."
        return _failed(f"there is no command {words[0]!r}. {hint}", 1)
    sys.stdout.write(_FIRST)
    return 0


def main() -> int:
    """Run the command line; returns the exit code: 0 done, 1 usage, 2 bad input, 130 interrupted."""
    try:
        result = app(exit_on_error=False, print_error=True)
    except CycloptsError:
        return 1
    except ErclutchError as error:
        return _failed(str(error), error.exit_code)
    except KeyboardInterrupt:
        return _failed("interrupted; nothing was left half-written", 130)
    except BrokenPipeError:
        # The reader of our output went away (``| head``): that is no error of ours.
        sys.stderr.close()
        return 0
    except OSError as error:
        return _failed(f"the output cannot be written ({error.strerror or error})", 2)
    return result if isinstance(result, int) else 0


def _failed(message: str, code: int) -> int:
    from rich.console import Console

    Console(stderr=True, soft_wrap=True).print(f"error: {message}", style="red", markup=False, highlight=False)
    return code
