"""The words of the command line are taken apart by Cyclopts, which takes longer to import than some commands run."""

from __future__ import annotations

import itertools
import re
import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

from cyclopts import App, CycloptsError, Group, MissingArgumentError, Parameter

from erclutch._version import __version__
from erclutch.cli.command_list import Command, commands
from erclutch.cli.failed import failed
from erclutch.cli.folded_help import HELP_ALL, Flowing
from erclutch.cli.lone_run import several_near
from erclutch.cli.overview import TITLE, first_steps
from erclutch.registry import names

if TYPE_CHECKING:
    from cyclopts import ArgumentCollection

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
    installed = [shutil.which(name) for name in ("gcc", "clang", "cc")]
    known = [*filter(None, installed), zig]
    compiler = os.environ.get("CC") or next(iter(known))
    packages = [
        f"{name} {version(name)}" for name in ("numpy", "scipy", "numba", "pandas", "matplotlib")
    ]
    lines = [
        __version__,
        f"{platform.python_implementation()} {platform.python_version()} on {platform.platform()}",
        ", ".join(packages),
        f"C compiler: {compiler}",
        "To cite:",
        _CITATION,
    ]
    return "\n".join(lines)


_FRACTION = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+)")
#: Options that take one value each time, and may be given more than once.
_REPEATED = ("--scale", "--zero", "--constant")
#: What people write to name a mapping file.
_OF_MAPPINGS = ("--mapping", "--map", "--mapping-file")


def misused(error: CycloptsError) -> str:
    """What is wrong with the words of a command; some may be names of files that the shell put there."""
    from cyclopts import CoercionError, UnknownOptionError, UnusedCliTokensError

    from erclutch.cli.terminal import shown

    command = " ".join(["erclutch", *(error.command_chain or ())])
    help_of_it = f"{command} --help shows what it takes."

    words = error.root_input_tokens or ()
    if isinstance(error, UnusedCliTokensError):
        unused = [*(error.unused_tokens or ())]
        # Before the first unused word stands a value, and before the value its option: --scale a=1 b=2.
        place = words.index(unused[0]) if unused and unused[0] in words else 0
        option = words[place - 2] if place >= 2 else ""
        remedy = _target_without_option(words, error) or help_of_it
        if option in _REPEATED:
            remedy = f"Write {option} in front of each value"
        listed = ", ".join(map(repr, unused))
        return shown(f"{listed}: more than the command takes. {remedy.rstrip('.')}.")
    if (
        isinstance(error, MissingArgumentError)
        and error.argument is not None
        and error.command_chain
    ):
        typed = error.command_chain[0]
        name = error.argument.name
        valueless = [word for word in words if word in error.argument.names]
        runs = [word for word in words if (Path(word) / "run.json").is_file()]
        given = ""
        if name == "--run" and runs:
            given = f" {runs[0]} is a run: give it as --run {shlex.quote(runs[0])}."
        missing = f"{name} is missing.{given}{several_near(words, error)} {_written(typed)}"
        if valueless:
            missing = f"{valueless[0]} needs a value: see erclutch {typed} --help."
        return shown(f"{missing}{_taken_by_a_list(words)}")
    if isinstance(error, UnknownOptionError) and error.command_chain:
        if "-" in words:
            # Elsewhere a dash stands for the standard input, which is read once: a log is read several times.
            return f"-: a log is read from a file, not from standard input. Save it, and give the file. {help_of_it}"
        options = {word.partition("=")[0] for word in words}
        if not options.isdisjoint(_OF_MAPPINGS):
            return "A mapping file has no option: it is read where it lies beside LOG as LOG.toml."
        files = {
            argument.name
            for argument in _arguments(error.command_chain[0])
            if argument.index is not None
        }
        option = (error.token.keyword or error.token.value).partition("=")[0]
        if option in {f"--{file.lower()}" for file in files}:
            written = _written(error.command_chain[0])
            return (
                f"{option} is no option here: {option[2:].upper()} stands without a name. {written}"
            )
    if (
        isinstance(error, CoercionError)
        and error.token is not None
        and error.target_type in (int, float)
    ):
        kind = "whole number" if error.target_type is int else "number"
        return shown(
            f"{error.token.keyword or error.token.value}: {error.token.value!r} is no {kind}. {help_of_it}"
        )
    return shown(f"{str(error).rstrip()} {help_of_it}")


def _target_without_option(words: Sequence[str], error: CycloptsError) -> str:
    """How export is written where the target stands without its option, as in export RUN c; "" where none does."""
    if error.command_chain is None or tuple(error.command_chain) != ("export",):
        return ""
    targets = [word for word in words if word in names("erclutch.targets")]
    models = [word for word in words[1:] if Path(word).exists()]
    if not targets or not models:
        return ""
    return f"Write: erclutch export {shlex.quote(models[0])} --to {targets[0]}"


def fraction_given(words: Sequence[str]) -> str:
    """What is wrong with a fraction where an option takes a whole number, which Cyclopts would round; "" for none."""
    parts = [
        part
        for word in words[1:]
        for part in (word.split("=", 1) if word.startswith("--") else [word])
    ]
    if words[0] not in _COMMANDS or not any(map(_FRACTION.fullmatch, parts)):
        return ""
    wholes: set[str] = set()
    for argument in _arguments(words[0]):
        kinds = {argument.hint, *get_args(argument.hint)}
        if int in kinds and float not in kinds:
            wholes |= {*argument.names}
    for option, value in itertools.pairwise(parts):
        if option in wholes and _FRACTION.fullmatch(value) and not float(value).is_integer():
            return f"{option}: {value!r} is no whole number. erclutch {words[0]} --help shows what it takes."
    return ""


def empty_name_given(words: Sequence[str]) -> str:
    """What is wrong with an empty word in the place of a file, which would stand for this folder; "" for nothing."""
    for before, word in itertools.pairwise(words):
        if not word and not before.startswith("-"):
            return (
                f"an empty word stands behind {before!r}, where a file or folder is meant. "
                "Perhaps a variable of the shell is not set; a point means this folder."
            )
    return ""


def _taken_by_a_list(words: Sequence[str]) -> str:
    """Where an option that takes several values stands before a file, it takes the file too: which, and the way out."""
    places = [place for place, word in enumerate(words) if word.startswith("--")]
    for place, next_place in itertools.pairwise([*places, len(words)]):
        option = words[place]
        for word in words[place + 2 : next_place]:  # the first value is its own
            if Path(word).exists():
                return f" {option} takes all words up to the next option, {word} too. Write {word} before {option}."
    return ""


app = App(
    name="erclutch",
    help=TITLE,
    group_parameters=Group("Options", sort_key=1),
    version=_versions,
    help_format="plaintext",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
    help_formatter=Flowing(),
)
_COMMANDS = {command.name: command for command in commands()}
_PANELS = dict.fromkeys(command.panel for command in _COMMANDS.values())  # in order, each once
_HEADINGS = {panel: Group(panel, sort_key=order) for order, panel in enumerate(_PANELS)}


def _offer(command: Command, function: str | Callable[..., Any]) -> None:
    """Put a function, or the name by which Cyclopts imports it when it is called for, under the command's heading."""
    heading = _HEADINGS[command.panel]
    app.command(
        function, name=command.name, help=command.help, group=heading, sort_key=command.place
    )


for _command in _COMMANDS.values():
    _offer(_command, _command.plugin.source)
app.register_install_completion_command(  # pyright: ignore[reportUnknownMemberType]
    help="Let bash, zsh, fish or PowerShell complete commands and options with Tab."
)


@app.default
def first(*words: Annotated[str, Parameter(show=False)]) -> int:
    """Say what to do first."""
    if words:
        import difflib

        near = difflib.get_close_matches(words[0], _COMMANDS, n=1)
        hint = (
            f"Did you mean {near[0]}? erclutch --help lists all"
            if near
            else f"Commands are {', '.join(_COMMANDS)}"
        )
        return failed(f"there is no command {words[0]!r}. {hint}.", 2)
    sys.stdout.write(first_steps(_COMMANDS))
    return 0


def load_command(words: Sequence[str]) -> None:
    """Import the function of the command that is asked for.

    The function of another package is put in its place with a guard: whatever it raises is told with its package.

    Raises:
        PluginError: it cannot be imported, is no function, or needs a wing whose folder is not there.
    """
    command = _COMMANDS.get(words[0]) if words else None
    if command is None:
        return
    function = command.plugin.of_type(Callable)  # pyright: ignore[reportArgumentType]
    if not command.plugin.own:
        del app[command.name]
        _offer(command, command.plugin.guarded(function))
    # It takes as long to make as the words to parse.
    if not {*app.help_flags, HELP_ALL}.isdisjoint(words):
        app[command.name].usage = _usage(command.name)


def _arguments(name: str) -> ArgumentCollection:
    """What a command takes."""
    return app[name].assemble_argument_collection()


def _written(name: str) -> str:
    """How a command is typed, as the remedy of an error."""
    return f"{_usage(name)}.".replace("Usage: ", "Write: ")


def _usage(name: str) -> str:
    """How a command is typed: its files first, as an option that takes several values would take them too."""
    files: list[str] = []
    needed: list[str] = []
    for argument in _arguments(name):
        if argument.index is not None:
            many = "..." if argument.token_count()[1] else ""
            file = f"{argument.name}{many}"
            files.append(file if argument.required else f"[{file}]")
        elif argument.required and argument.show:
            needed.append(f"{argument.name} {argument.name.lstrip('-').upper()}")
    return " ".join(["Usage: erclutch", name, *files, *needed, "[OPTIONS]"])
