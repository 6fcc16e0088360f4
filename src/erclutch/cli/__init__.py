"""The command line imports what a command needs when it runs, so that ``erclutch --help`` answers at once."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

from cyclopts import App, CycloptsError, Group, Parameter

from erclutch._version import __version__
from erclutch.cli.command_list import Command, commands
from erclutch.cli.folded_help import HELP_ALL, whole_help
from erclutch.cli.standard_output import standard_output
from erclutch.errors import ErclutchError, PluginError, for_a_shell, of_missing_wing
from erclutch.files.places import release_all

#: The software and the paper whose models it implements, as in CITATION.cff.
_CITATION = (
    f"The erclutch authors. erclutch, version {__version__}. Software, Apache-2.0.\n"
    "Huang and Ishikawa. "
    "Torque Transmission Modeling of Two Coaxial Electrorheological Clutches for Reciprocating Actuation."
)


def _versions() -> str:
    """The version alone on the first line; below it what a report of a bug needs, and how to cite."""
    import os
    import platform
    import shutil
    from importlib.metadata import version
    from importlib.util import find_spec

    zig = "zig" if find_spec("ziglang") else "none"
    compiler = os.environ.get("CC") or next(filter(None, map(shutil.which, ("gcc", "clang", "cc"))), zig)
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba", "pandas", "matplotlib"))
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return (
        f"{__version__}\n{python} on {platform.platform()}\n{packages}\nC compiler: {compiler}\nTo cite:\n{_CITATION}"
    )


def _misused(error: CycloptsError) -> object:
    """What is wrong with the words of a command, framed; some may be names of files that the shell put there."""
    from cyclopts import CycloptsPanel, MissingArgumentError

    from erclutch.cli.terminal import shown

    hint = _taken_by_a_list(error.root_input_tokens or ()) if isinstance(error, MissingArgumentError) else ""
    return CycloptsPanel(shown(f"{error}{hint}"))


def _taken_by_a_list(words: Sequence[str]) -> str:
    """Where an option that takes several values stands before a file, it takes the file too: which, and the way out."""
    from pathlib import Path

    options = [(at, word) for at, word in enumerate(words) if word.startswith("--")]
    for (at, option), (end, _) in itertools.pairwise([*options, (len(words), "")]):
        taken = next((word for word in words[at + 2 : end] if Path(word).exists()), None)
        if taken is not None:
            return f"\n{option} takes all words up to the next option, {taken} too. Write {taken} before {option}."
    return ""


app = App(
    name="erclutch",
    help="Turn a test-bench log of a clutch, brake or damper with an ER or MR fluid into a checked torque model.",
    version=_versions,
    help_format="plaintext",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
    error_formatter=_misused,
)
_COMMANDS = {command.name: command for command in commands()}
_HEADINGS = {
    panel: Group(panel, sort_key=order)
    for order, panel in enumerate(dict.fromkeys(command.panel for command in _COMMANDS.values()))
}


def _offer(command: Command, function: str | Callable[..., Any]) -> None:
    """Put a function, or the name by which Cyclopts imports it when it is called for, under the command's heading."""
    heading, place = _HEADINGS[command.panel], command.place
    app.command(function, name=command.name, help=command.help, group=heading, sort_key=place)


for _command in _COMMANDS.values():
    _offer(_command, _command.plugin.source)
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

erclutch COMMAND --help explains a command and its usual options, --help-all each option.
"""


@app.default
def first(*words: Annotated[str, Parameter(show=False)]) -> int:
    """Say what to do first."""
    if words:
        import difflib

        near = difflib.get_close_matches(words[0], _COMMANDS, n=1)
        hint = f"Did you mean {near[0]}?" if near else f"Commands are {', '.join(_COMMANDS)}."
        return _failed(f"there is no command {words[0]!r}. {hint}", 1)
    for line in _FIRST.splitlines():
        if not line.startswith("  erclutch ") or line.split()[1] in _COMMANDS:
            sys.stdout.write(f"{line}\n")
    return 0


_INTERRUPTED = "interrupted; nothing was left half-written"
_LEAST_MEMORY = 512 << 20  # bytes of address space
_MORE_MEMORY = "Give the command more memory, fewer --workers or --models, or a shorter log"


def main(words: Sequence[str] | None = None) -> int:
    """Run a command, that of this process where no words are given.

    Returns:
        The exit code: 0 done, 1 usage, 2 bad input, 130 interrupted.
    """
    words = sys.argv[1:] if words is None else words
    allowed = _address_space()
    if allowed < _LEAST_MEMORY:  # libraries crash or hang there, each in its own way
        problem = f"this process may have {allowed >> 20} MiB of address space, and needs {_LEAST_MEMORY >> 20}"
        return _failed(f"{problem}. Raise it: ulimit -v", 2)
    _end_by_signals()
    with standard_output() as output, for_a_shell():
        code = _code_of(words)
        output.flush()
    if output.failure is None or output.unheard:
        return code
    return _failed(f"the output cannot be written ({output.failure.strerror})", code or 2)


def _code_of(words: Sequence[str]) -> int:
    whole = HELP_ALL in words
    words = ["--help" if word == HELP_ALL else word for word in words]
    try:
        _load(words)
        with whole_help(whole=whole):
            result = app(words, exit_on_error=False, print_error=True)
    except CycloptsError:
        return 1
    except ErclutchError as error:
        if not isinstance(error, PluginError) and _made_of_an_interrupt(error):
            return _failed(_INTERRUPTED, 130)
        return _failed(str(error), error.exit_code)
    except ModuleNotFoundError as error:
        missing = of_missing_wing(error, f"the command {words[0]!r}")
        if missing is None:
            raise
        return _failed(str(missing), missing.exit_code)
    except KeyboardInterrupt:
        return _failed(_INTERRUPTED, 130)
    except MemoryError:
        return _failed(f"memory ran out. {_MORE_MEMORY}", 2)
    except (OSError, ImportError) as error:
        if "shared object" in str(error):  # what a library says that cannot be mapped
            return _failed(f"a library cannot be loaded ({str(error)[:200]}). {_MORE_MEMORY}", 2)
        if isinstance(error, ImportError):
            raise
        place = f"{error.filename}: " if error.filename else ""
        return _failed(f"{place}{error.strerror or error}", 2)
    finally:
        release_all()
    return result if isinstance(result, int) else 0


def _made_of_an_interrupt(error: BaseException | None) -> bool:
    """Whether Control-C is behind an error: a library in which it came may make an error of its own of it."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _address_space() -> int:
    """Bytes that this process may have, where the system limits them."""
    try:
        import resource
    except ImportError:
        return sys.maxsize
    allowed = resource.getrlimit(resource.RLIMIT_AS)[0]
    return sys.maxsize if allowed == resource.RLIM_INFINITY else allowed


def _end_by_signals() -> None:
    """A closed terminal and `kill` end a command as an exception does, so that half-written files are taken away.

    What the caller has set already, such as nohup, stays. Commands that go on until they are told have their own way.
    """
    import signal

    def end(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        try:
            if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                signal.signal(number, end)
        except ValueError:
            return  # not in the main thread: whoever started this one decides


def _load(words: Sequence[str]) -> None:
    """Import the function of the command that is asked for.

    The function of another package is put in its place with a guard: whatever it raises is told with its package.

    Raises:
        PluginError: it cannot be imported, is no function, or needs a wing whose folder is not there.
    """
    command = _COMMANDS.get(words[0]) if words else None
    if command is None:
        return
    function = command.plugin.of_type(Callable)  # pyright: ignore[reportArgumentType]
    if command.plugin.own:
        return
    del app[command.name]
    _offer(command, command.plugin.guarded(function))


def _failed(message: str, code: int) -> int:
    from rich.console import Console

    Console(stderr=True, soft_wrap=True).print(f"error: {message}", style="red", markup=False, highlight=False)
    return code
