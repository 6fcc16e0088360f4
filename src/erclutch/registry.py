"""Plug-ins are found by name: commands, kinds of model, laws, readers, stages, targets, rigs, advice, points.

Our own and others' are found by the same functions and keep the same contract. One of ours is a file in its group's
folder, or in a folder of that name in a wing, that assigns the group's `mark` at its top level (``LAW = ...`` in
``models/laws/casson.py`` is the law ``casson``). One of another package is an entry point that names such a value::

    [project.entry-points."erclutch.laws"]
    robertson-stiff = "erclutch_law_robertson_stiff:LAW"

Nothing of a plug-in is imported before its value is asked for. Where a name stands twice, ours is taken.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout, suppress
from dataclasses import dataclass
from functools import cache, cached_property, wraps
from importlib import import_module
from importlib.resources import files
from pathlib import PurePath
from threading import local
from traceback import extract_tb
from typing import Any, Literal, NamedTuple, cast

from erclutch._version import __version__
from erclutch.errors import (
    ErclutchError,
    PluginError,
    SettingError,
    SpoiltError,
    did_you_mean,
    placed,
)
from erclutch.foreign_code import (
    asked_for_from_outside,
    kept_process,
    missing_wing,
    said_by,
)


class _Group(NamedTuple):
    kind: str  # what a plug-in of the group is called
    room: str  # of the core, with a folder of the group; "": wings alone have such folders
    mark: str  # what the file assigns at its top level
    #: A plug-in's value: what the mark is, the file itself, or the function that is named as the file.
    value: Literal["mark", "module", "function"] = "mark"


#: Kinds of model: `fit` asks for what they fit, and `models` for what they read.
KINDS = "erclutch.kinds"
#: The last word of a group is the name of its folders.
_GROUPS: Mapping[str, _Group] = {
    "erclutch.commands": _Group("command", "cli", "COMMAND", value="function"),
    KINDS: _Group("kind of model", "fit", "KIND"),
    "erclutch.laws": _Group("law", "models", "LAW"),
    "erclutch.readers": _Group("reader", "logs", "READER"),
    "erclutch.stages": _Group("stage", "models", "STAGE"),
    "erclutch.targets": _Group("target", "export", "TITLE", value="module"),
    "erclutch.rigs": _Group("rig", "", "RIG"),
    "erclutch.advice": _Group("advice", "", "ADVICE", value="function"),
    "erclutch.points": _Group("reading of points", "", "POINTS", value="function"),
}
GROUPS = tuple(_GROUPS)
#: In each thread how many calls of plug-ins of other packages are under way.
_AT_WORK = local()
_LONGEST = 200  # letters of a text that another package brings
#: Of a plug-in or its package. Whatever else a package calls so may command a shell, a terminal or a page.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")


@dataclass(frozen=True)
class Plugin:
    """One plug-in. Its value is imported when it is first asked for.

    Attributes:
        group: one of `GROUPS`.
        name: by which users choose it.
        source: where its value is, ``module:attribute`` or ``module``.
        package: that brings it, as pip calls it; ``erclutch`` for our own.
        version: of that package.
        part: of the group that its package names, such as ``live`` of ``erclutch.commands.live``; mostly empty.
    """

    group: str
    name: str
    source: str
    package: str = "erclutch"
    version: str = __version__
    part: str = ""

    @property
    def own(self) -> bool:
        """Whether it is one of ours."""
        return self.package == "erclutch"

    @property
    def label(self) -> str:
        """Package and version, for people."""
        return f"{self.package} {self.version}"

    @property
    def why_unused(self) -> str:
        """Why it is not used, though it is installed; empty where it is."""
        if not all(map(_NAME.fullmatch, (self.name, self.package, self.part or "none"))):
            return "not used: names of plug-ins have up to 100 letters, digits and - . _"
        hides = not self.own and self.name in _own(self.group)
        return f"not used: {self.name} is erclutch's own" if hides else ""

    @cached_property
    def value(self) -> Any:
        """What the group's contract asks for.

        Raises:
            PluginError: a plug-in of another package cannot be imported, or one of ours needs a wing that is not there.
        """
        if self.own:
            return self._imported()
        try:
            return self._imported()
        except PluginError:
            raise
        except ErclutchError as error:
            raise self.fault(f"cannot be loaded: {error.problem}") from error

    def _imported(self) -> Any:
        module, _, attribute = self.source.partition(":")
        # What a package prints while it is imported is no part of a table or of JSON.
        aside = nullcontext() if self.own else redirect_stdout(sys.stderr)
        try:
            with self.working("cannot be loaded", imports=True), aside:
                value: Any = import_module(module)
                for part in attribute.split(".") if attribute else ():
                    value = getattr(value, part)
        except SpoiltError:
            sys.modules.pop(module, None)  # refused whenever it is asked for
            raise
        return value

    @contextmanager
    def working(
        self, doing: str = "failed", *, alone: bool = True, imports: bool = False
    ) -> Generator[None]:
        """What it raises while it works is told with its name and package. Our own raise as they are.

        Args:
            doing: what is said of it then, for example "failed on run1.csv".
            alone: whether nothing of ours prints meanwhile, as it may between the items of a generator.
            imports: whether it is imported meanwhile, see `kept_process`.

        Raises:
            SpoiltError: it replaced what all others compute with.
        """
        # What a command prints is its answer.
        aside = alone and not self.own and self.group != "erclutch.commands"
        if aside:
            _AT_WORK.depth = _depth() + 1
        replaced: list[str] = []
        try:
            with kept_process(imports=imports) if aside else nullcontext(replaced) as replaced:
                yield
        except ErclutchError:
            raise
        except BaseException as error:
            # Of somebody else: told, and no crash of ours. What we interrupt by is told where it was begun.
            is_interrupt_of_ours = type(error).__module__.startswith("erclutch.")
            said = said_by(error)
            if is_interrupt_of_ours or asked_for_from_outside(error):
                if not self.own:  # perhaps it would never have come to an end
                    error.add_note(f"the plug-in {self.name} of {self.label} was at work")
                raise
            if self.own and isinstance(error, ModuleNotFoundError):
                told = missing_wing(error, f"the {_GROUPS[self.group].kind} {self.name!r}")
                raise (PluginError(told[0], remedy=told[1]) if told else error) from None
            if self.own:
                raise
            frame = extract_tb(error.__traceback__)[-1]
            place = f"{PurePath(frame.filename).name}, line {frame.lineno}"
            raise self.fault(f"{doing}: {type(error).__name__}: {said} ({place})") from error
        finally:
            if aside:
                _AT_WORK.depth = _depth() - 1
            if replaced:
                changes = "changes what all others compute with, which was put back"
                raise self.fault(f"{changes}: {', '.join(replaced[:5])}", SpoiltError)

    def guarded(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A function of it: `working` tells what it raises; an error of ours that names no place gets the plug-in."""

        @wraps(function)
        def call(*arguments: Any, **named: Any) -> Any:
            with self.working(), placed(f"{self.name} of {self.label}"):
                return function(*arguments, **named)

        return call

    def of_type(self, kind: type[Any]) -> Any:
        """The value, if it is of a type. A type whose values need a look says so by a method ``of_others(plugin)``.

        Raises:
            PluginError: it is of another, or cannot be imported, or is not what its type asks for.
        """
        value = self.value
        if not isinstance(value, kind):
            given = type(value).__name__
            raise self.fault(
                f"is of type {given}, it must be {kind.__name__} (of {kind.__module__})"
            )
        if self.own or not hasattr(kind, "of_others"):
            return value
        with self.working("does not say what it is"):
            return value.of_others(self)

    def fault(self, what: str, kind: type[PluginError] = PluginError) -> PluginError:
        """What is wrong with it, with its name, package and version, to be raised as an error of a kind."""
        remedy = (
            f"Tell its author, install another version of {self.package}, or remove it: pip "
            f"uninstall {self.package}"
        )
        problem = f"the {_GROUPS[self.group].kind} {self.name!r} of {self.label} {what}"
        error = kind(problem, remedy=remedy)
        error.plugin = self.group, self.name
        return error

    def to_dict(self) -> dict[str, str]:
        """What a file says of a plug-in that it needs."""
        return {
            "group": self.group,
            "name": self.name,
            "package": self.package,
            "version": self.version,
        }


def names(group: str) -> tuple[str, ...]:
    """Names of a group's plug-ins: ours, then those of other packages."""
    return tuple(dict.fromkeys(plugin.name for plugin in plugins(group)))


def plugins(group: str) -> tuple[Plugin, ...]:
    """A group's plug-ins: ours, then those of other packages that are used."""
    used = (plugin for plugin in _others(group) if not plugin.why_unused)
    return (*_own(group).values(), *used)


def sound(group: str, kind: type[Any]) -> tuple[list[tuple[Plugin, Any]], list[PluginError]]:
    """A group's plug-ins whose value is of a type, each with its value, and what is wrong with each of the others.

    Work that asked for no plug-in by name goes on without those that fail.
    """
    values: list[tuple[Plugin, Any]] = []
    wrong: list[PluginError] = []
    for plugin in plugins(group):
        try:
            values.append((plugin, plugin.of_type(kind)))
        except PluginError as error:
            wrong.append(error)
    return values, wrong


def fault_behind(error: Exception) -> PluginError | None:
    """What to tell of an error where a plug-in of another package is behind it: its code raised, or called what did.

    Returns:
        None: it is no error of another package, or one that tells itself.
    """
    if isinstance(error, PluginError):
        return error
    if isinstance(error, ErclutchError):
        return None
    modules: set[str] = set()
    place = error.__traceback__
    while place is not None:
        modules.add(str(place.tb_frame.f_globals.get("__name__")))
        place = place.tb_next
    for plugin in (other for group in _GROUPS for other in _others(group)):
        package = plugin.source.partition(":")[0].partition(".")[0]
        if any(module.partition(".")[0] == package for module in modules):
            return plugin.fault(f"failed: {type(error).__name__}: {said_by(error)}")
    return None


def hidden(group: str) -> tuple[Plugin, ...]:
    """Plug-ins of other packages that are not used: their name is one of ours, or none."""
    return tuple(plugin for plugin in _others(group) if plugin.why_unused)


def find(group: str, name: str) -> Plugin:
    """The plug-in of a name. Other packages are looked at only where it is none of ours.

    Raises:
        SettingError: there is none (PluginError: two packages have one of this name).
    """
    own = _own(group).get(name)
    if own is not None:
        return own
    of_others = [plugin for plugin in plugins(group) if plugin.name == name]
    if not of_others:
        raise unknown(group, name)
    if len(of_others) > 1:
        packages = [plugin.package for plugin in of_others]
        problem = f"the {_GROUPS[group].kind} {name!r} is in {len(packages)} packages: {', '.join(packages)}"
        raise PluginError(
            problem, remedy=f"Remove all but one of them: pip uninstall {packages[-1]}"
        )
    return of_others[0]


def unknown(
    group: str,
    name: str,
    known: Iterable[str] = (),
    where: str = "",
    error: type[ErclutchError] = SettingError,
) -> ErclutchError:
    """That there is no plug-in of a name, to be raised.

    Args:
        group: one of `GROUPS`.
        name: what was asked for.
        known: what may be asked for; the plug-ins' names by default.
        where: the option or file at fault.
        error: its class.
    """
    offered = tuple(known) or names(group)
    hint = did_you_mean(name, offered)
    return error(
        f"unknown {_GROUPS[group].kind} {name!r}",
        where=where,
        remedy=f"{hint}Known are {', '.join(offered)}",
    )


def require(needed: Any, where: str) -> None:
    """Look whether the plug-ins that a file names (a list of `Plugin.to_dict`) are there.

    Raises:
        PluginError: one is not, and the remedy says which package to install; or the entry is none.
    """
    entries = cast("list[object]", needed) if isinstance(needed, list) else [needed]
    for entry in entries:
        named = cast("dict[str, object]", entry) if isinstance(entry, dict) else {}
        group, name, package = (str(named.get(key, "")) for key in ("group", "name", "package"))
        if group not in _GROUPS or not _NAME.fullmatch(package):
            remedy = "Restore the file, or make it again"
            raise PluginError(f"{entry!r:.100} names no plug-in", where=where, remedy=remedy)
        if name not in names(group):
            what = f"the {_GROUPS[group].kind} {name!r} of {package} {named.get('version', '')}"
            remedy = f"Install the package {package} that the model was made with"
            raise PluginError(f"{what} is needed and not installed", where=where, remedy=remedy)


def others_at_work() -> bool:
    """Whether a plug-in of another package works in this thread, so that what is printed is no answer of a command."""
    return _depth() > 0


def _depth() -> int:
    """How many calls of plug-ins of other packages are under way in this thread."""
    depth: int = getattr(_AT_WORK, "depth", 0)
    return depth


@cache
def _own(group: str) -> Mapping[str, Plugin]:
    """Ours, by the files in the group's folders that hold its mark."""
    rule = _GROUPS[group]
    mark = re.compile(rf"^{rule.mark}\b.*=", re.MULTILINE)
    marked: list[tuple[str, str]] = []  # name of the module, and its package
    last = group.rpartition(".")[2]
    package = files("erclutch")
    # Folders that may hold the group's plug-ins, each with the name by which it is imported.
    folders = [(f"erclutch.{rule.room}.{last}", package / rule.room / last)] if rule.room else []
    wings = package / "wings"
    if wings.is_dir():
        folders += [
            (f"erclutch.wings.{wing.name}.{last}", wing / last)
            for wing in wings.iterdir()
            if wing.is_dir()
        ]
    for name, folder in folders:
        if not folder.is_dir():
            continue
        for file in folder.iterdir():
            if file.name.endswith(".py") and mark.search(file.read_text(encoding="utf-8")):
                marked.append((file.name.removesuffix(".py"), name))

    own: dict[str, Plugin] = {}
    for module, folder_name in sorted(marked):
        attributes = {"mark": f":{rule.mark}", "function": f":{module}", "module": ""}
        name = module.replace("_", "-")
        source = f"{folder_name}.{module}{attributes[rule.value]}"
        own[name] = Plugin(group, name, source)
    return own


def own_text(plugin: Plugin) -> str:
    """The source of one of ours; nothing of it is imported."""
    *folders, module = plugin.source.partition(":")[0].removeprefix("erclutch.").split(".")
    return files("erclutch").joinpath(*folders, f"{module}.py").read_text(encoding="utf-8")


@cache
def _others(group: str) -> tuple[Plugin, ...]:
    """Those of other packages, by name: of the group, and of its parts (``erclutch.commands.live``)."""
    others: list[Plugin] = []
    of_group = (point for point in _installed() if f"{point.group}.".startswith(f"{group}."))
    for point in of_group:
        part = point.group.removeprefix(group).removeprefix(".")
        package, version = "unknown", ""
        with suppress(Exception):  # what a package says of itself may be unreadable, or missing
            package, version = point.dist.name or package, point.dist.version or version
        source = point.value.partition("[")[0].strip()  # without the extras that it may name
        said = (point.name, source, package, version, part)
        # A name may hold what commands a terminal.
        shown = (text if text.isprintable() else ascii(text)[1:-1] for text in said)
        others.append(Plugin(group, *(text[:_LONGEST] for text in shown)))
    return tuple(sorted(others, key=lambda plugin: (plugin.name, plugin.package)))


def _installed() -> Iterable[Any]:
    """The entry points of all packages; a package whose list of them cannot be read has none."""
    from importlib.metadata import distributions, entry_points

    with suppress(Exception):
        points = entry_points()
        return [point for group in points.groups for point in points.select(group=group)]
    readable: list[Any] = []
    for package in distributions():
        with suppress(Exception):
            readable += package.entry_points
    return dict.fromkeys(readable)
