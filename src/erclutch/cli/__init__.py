"""The command line imports what a command needs when it runs, so that ``erclutch --help`` answers at once."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from erclutch.cli.early_end import no_early_end
from erclutch.cli.ending_signal import EndingSignal
from erclutch.cli.failed import failed
from erclutch.cli.standard_output import standard_output
from erclutch.errors import ErclutchError, PluginError, for_a_shell
from erclutch.files.places import release_all

if TYPE_CHECKING:
    from cyclopts import App

    app: App


def __getattr__(name: str) -> Any:
    """The parser of all commands, imported when somebody asks for it.

    Raises:
        AttributeError: another name.
    """
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from erclutch.cli import parser

    return parser.app


#: Words that ask for the page of all commands.
_OF_ALL = ("--help", "-h", "--help-all")
_INTERRUPTED = "interrupted; nothing was left half-written"
_ENDING = EndingSignal()
_LEAST_MEMORY = 512 << 20  # bytes of address space
_MORE_MEMORY = "Give the command more memory, fewer --workers or --models, or a shorter log"


def main(words: Sequence[str] | None = None) -> int:
    """Run a command, that of this process where no words are given.

    Returns:
        The exit code: 0 done, 1 a question is open, 2 wrong usage or bad input, 130 interrupted.
    """
    words = sys.argv[1:] if words is None else words
    allowed = sys.maxsize  # bytes of address space
    with suppress(ImportError):  # Windows limits none
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        allowed = allowed if limit == resource.RLIM_INFINITY else limit
    if allowed < _LEAST_MEMORY:  # libraries crash or hang there, each in its own way
        problem = f"this process may have {allowed >> 20} MiB of address space, and needs {_LEAST_MEMORY >> 20}"
        return failed(f"{problem}. Raise it: ulimit -v", 2)
    _ENDING.begin()
    try:
        with standard_output() as output, for_a_shell(), no_early_end():
            code = _code_of(words)
            output.flush()
            if output.failure is not None and not output.unheard:
                reason = output.failure.strerror
                code = failed(f"the output cannot be written ({reason})", code or 2)
    finally:
        _ENDING.give_back()
    return code


def _code_of(words: Sequence[str]) -> int:
    try:
        return _run(words)
    except KeyboardInterrupt as interrupt:
        # A plug-in that may never have come to its end.
        at_work = getattr(interrupt, "__notes__", ())
        return failed("; ".join((_INTERRUPTED, *at_work[:1])), 130)
    except Exception as error:
        if _ENDING.number:  # a library in which a signal came may make an error of its own of it
            if _ENDING.interrupted:
                return failed(_INTERRUPTED, 130)
            raise SystemExit(128 + _ENDING.number) from None
        is_of_ours = isinstance(error, ErclutchError) and not isinstance(error, PluginError)
        if is_of_ours and _made_of_an_interrupt(error):
            return failed(_INTERRUPTED, 130)
        # What is told in a line; any other error is a fault of ours.
        if isinstance(error, ErclutchError):
            return failed(str(error), error.exit_code)
        if isinstance(error, ModuleNotFoundError):
            from erclutch.foreign_code import missing_wing

            told = missing_wing(error, f"the command {words[0]!r}")
            if told is None:
                raise
            missing = PluginError(told[0], remedy=told[1])
            return failed(str(missing), missing.exit_code)
        if isinstance(error, MemoryError):
            return failed(f"memory ran out. {_MORE_MEMORY}", 2)
        unmapped = isinstance(error, OSError | ImportError) and "shared object" in str(error)
        if unmapped:  # the library is there, and its memory is not
            return failed(f"a library cannot be loaded ({str(error)[:200]}). {_MORE_MEMORY}", 2)
        if isinstance(error, OSError):
            place = f"{error.filename}: " if error.filename else ""
            return failed(f"{place}{error.strerror or error}", 2)
        from erclutch.cli.unreadable_package import unreadable_package
        from erclutch.registry import fault_behind

        fault = fault_behind(error) or unreadable_package()
        if fault is None:
            raise
        return failed(str(fault), fault.exit_code)
    finally:
        _ENDING.end()
        release_all()


def _run(words: Sequence[str]) -> int:
    """Run the command; what needs no parser does without."""
    if not words or (len(words) == 1 and words[0] in _OF_ALL):
        from erclutch.cli.command_list import commands
        from erclutch.cli.overview import first_steps, overview

        listed = commands()
        names = {command.name for command in listed}
        sys.stdout.write(overview(listed) if words else first_steps(names))
        return 0

    from cyclopts import CycloptsError
    from rich.console import Console

    from erclutch.cli.folded_help import HELP_ALL, whole_help
    from erclutch.cli.logs_behind_runs import words_with_logs_first
    from erclutch.cli.lone_run import words_with_lone_run
    from erclutch.cli.parser import (
        app,
        empty_name_given,
        fraction_given,
        load_command,
        misused,
    )

    load_command(words)
    if wrong := fraction_given(words) or empty_name_given(words):
        return failed(wrong, 2)
    plain = ["--help" if word == HELP_ALL else word for word in words]
    try:
        with whole_help(whole=HELP_ALL in words):
            # Of its own, Cyclopts would print in the width that the terminal had at the first command of this process.
            result = app(plain, console=Console(), exit_on_error=False, print_error=False)
    except CycloptsError as error:
        completed = words_with_logs_first(plain, error) or words_with_lone_run(plain, error)
        if completed is None:
            return failed(misused(error), 2)
        return _run(completed)
    return result if isinstance(result, int) else 0


def _made_of_an_interrupt(error: BaseException | None) -> bool:
    """Whether Control-C is behind an error: a library in which it came may make an error of its own of it."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
