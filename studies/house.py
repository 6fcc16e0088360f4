"""What the code costs whoever takes it over: rooms and wings, arrows, circles, density, a log's way, a change's files.

    python studies/house.py [FOLDER ...]

A log's way is counted from `read` to the recording, along the calls, each function once: a stay is a run of functions
of one file, a return a stay in a file in which one was before. It is counted twice, for the rules of reading stand in
tables (`STEPS` of a plan, `TIDYINGS` of a table, `CHOICES` of a recording, `FAULTS` of a sensor) that a loop goes
through. "A log's way" leads past the rules, as a reader goes who takes from the table what each of them settles. "With
all rules followed" enters each rule where its table is named, as somebody has to go who wants to know all of reading.

Each FOLDER is a checkout, by default this one; several stand side by side, so that before and after come from one
count. Nothing is imported and no place is fixed: packages, classes and functions are found by search.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cached_property
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import Any

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE))

from studies.house_calls import Calls  # noqa: E402
from studies.house_code import (  # noqa: E402
    PACKAGE,
    Density,
    Module,
    called,
    circles_in,
    imports,
    imports_by_text,
)

LANGUAGES = {
    "Python": (".py",),
    "C": (".c", ".h"),
    "JavaScript": (".js",),
    "CSS": (".css",),
    "templates": (".html", ".j2", ".ld"),
}
#: Folders whose files are not ours.
FOREIGN = {"vendor", "uplot", "__pycache__"}
MODELS = re.compile(r"(Torque|Network|Law)Model")

#: An example of each kind that can be added: the files of its own, and how code names it elsewhere.
CHANGES = {
    "law (casson)": (r"casson", r"casson"),
    "log format (text)": (
        r"^(text|text_\w+|dialect)$",
        r"\.asc\b|\btext \. read_text\b|import read_text\b",
    ),
    "export target (mujoco)": (r"mujoco", r"mujoco"),
    "rig (replay)": (r"playback|^replay$", r"[\"']replay[\"']|playback"),
    "stage of dynamics (two lags)": (r"^two_lags$", r"two[-_]lags"),
}

#: Knowledge that should stand once, as code shows it.
REPEATED = {
    "slips of the pair": (
        r"^(?!.*w1 = ).*-\s*(?:theta_dot|rows\[2\]|\(-in\[2\]|in\[2\])\)?\s*-\s*(?:alpha_dot|rows\[3\]|in\[3\])"
    ),
    "base inputs of a network": r"fields\[0\] - fields\[1\]|fluids\[0\] - fluids\[1\]|x\[0\] - x\[1\]",
    "1 % outside of what was trained on": r"0\.01 \* \(+(?:high - low|b - a)\)",
}

#: Files whose functions a reader knows by their name and does not open: a log's way is counted with and without them.
VOCABULARY = {"errors.py", "registry.py", "signals/units.py"}

#: Where a log's way begins: the module and its function.
LOG = ("erclutch.logs.read_logs", "read")


@dataclass(frozen=True)
class House:
    """One checkout."""

    folder: Path

    @property
    def source(self) -> Path:
        """The package."""
        return self.folder / "src" / PACKAGE

    @cached_property
    def files(self) -> list[Path]:
        """All files of the package that are ours."""
        inside = (p for p in sorted(self.source.rglob("*")) if p.is_file())
        return [p for p in inside if not FOREIGN & set(p.relative_to(self.source).parts)]

    @cached_property
    def modules(self) -> list[Module]:
        """Its Python files."""
        found = [p for p in self.files if p.suffix == ".py"]
        return [
            Module(PurePosixPath(p.relative_to(self.source)), p.read_text(encoding="utf-8"))
            for p in found
        ]

    @cached_property
    def rooms(self) -> list[str]:
        """Packages on the ground floor; what stands in `wings` is counted there."""
        return sorted(
            p.parent.name for p in self.source.glob("*/__init__.py") if p.parent.name != "wings"
        )

    @cached_property
    def wings(self) -> list[str]:
        """Packages that stand on the core."""
        return sorted(p.parent.name for p in self.source.glob("wings/*/__init__.py"))

    @cached_property
    def ground_floor(self) -> list[str]:
        """Modules beside the rooms."""
        return sorted(p.stem for p in self.source.glob("*.py") if not p.stem.startswith("_"))

    @cached_property
    def contracts(self) -> list[dict[str, Any]]:
        """The layer contracts in pyproject.toml."""
        tools = tomllib.loads((self.folder / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
        return tools["importlinter"]["contracts"]

    @property
    def contract_lines(self) -> int:
        """Lines of the layer contracts."""
        return sum(len(contract.get("layers", ())) for contract in self.contracts)

    @cached_property
    def arrows_up(self) -> list[str]:
        """Imports, those inside of functions and those by a name in a string too, of what stands above or beside.

        An arrow that a contract names as its exception is none of them.
        """
        floor: dict[str, int] = {}
        for contract in self.contracts:
            for container in contract.get("containers", [PACKAGE]):
                for height, layer in enumerate(reversed(contract["layers"])):
                    floor |= dict.fromkeys(
                        (f"{container}.{room.strip()}" for room in layer.split("|")), height
                    )
        allowed = [
            arrow for contract in self.contracts for arrow in contract.get("ignore_imports", ())
        ]
        names = {module.name for module in self.modules}
        climbs: list[str] = []
        for module in self.modules:
            for target in [*imports(module, names, lazy=True), *imports_by_text(module)]:
                if any(fnmatch(f"{module.name} -> {target}", arrow) for arrow in allowed):
                    continue
                for here, there in zip(_parents(module.name), _parents(target), strict=False):
                    if here != there:
                        if here in floor and floor[here] <= floor.get(there, -1):
                            climbs.append(f"{module.path} -> {target}")
                        break
        return sorted(set(climbs))

    @cached_property
    def density(self) -> Density:
        """How dense the Python code is."""
        return Density.of(self.modules)

    @cached_property
    def way_of_a_log(self) -> list[str]:
        """Files in which one stays on the way of `read`, in the order in which its functions are first called."""
        return Calls(self.modules).way(*LOG)

    @cached_property
    def way_through_all_rules(self) -> list[str]:
        """The same way with each rule followed that stands in a table on it."""
        return Calls(self.modules).way(*LOG, rules=True)

    @property
    def longest_file(self) -> tuple[int, str]:
        """Lines and path of the longest file that we wrote, in any language."""
        endings = {ending for kind in LANGUAGES.values() for ending in kind}
        sources = [path for path in self.files if path.suffix in endings]
        return max((_line_breaks(path), str(path.relative_to(self.source))) for path in sources)

    def lines(self, endings: Sequence[str]) -> int:
        """Lines of all files with such an ending."""
        return sum(_line_breaks(path) for path in self.files if path.suffix in endings)

    @cached_property
    def functions(self) -> list[tuple[int, str]]:
        """Length and name of each function, the shortest first."""
        found: list[tuple[int, str]] = []
        for module in self.modules:
            for node in module.nodes:
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                    found.append(
                        (
                            1 + (node.end_lineno or node.lineno) - node.lineno,
                            f"{module.path}:{node.name}",
                        )
                    )
        return sorted(found)

    @cached_property
    def any_lines(self) -> int:
        """Lines of code with the type `Any`."""
        return sum(
            bool(re.search(r"\bAny\b", line)) for m in self.modules for line in m.code.split("\n")
        )

    @cached_property
    def import_tricks(self) -> list[str]:
        """Places that import by a name in a string."""
        tricks = {"import_module", "__import__", "spec_from_file_location"}
        return [f"{m.path}:{node.lineno}" for m, node in self._calls() if called(node) in tricks]

    @cached_property
    def model_kinds(self) -> list[str]:
        """Places that ask of which kind a model is."""
        found: list[str] = []
        for module, node in self._calls():
            if called(node) == "isinstance" and MODELS.search(ast.unparse(node.args[1])):
                found.append(f"{module.path}:{node.lineno}")
        for module in self.modules:
            for node in module.nodes:
                if isinstance(node, ast.MatchClass) and MODELS.search(ast.unparse(node.cls)):
                    found.append(f"{module.path}:{node.lineno}")
        return found

    def _calls(self) -> Iterator[tuple[Module, ast.Call]]:
        for module in self.modules:
            for node in module.nodes:
                if isinstance(node, ast.Call):
                    yield module, node

    @cached_property
    def shared_classes(self) -> dict[str, list[str]]:
        """Names of classes that stand in more than one module."""
        at: dict[str, list[str]] = defaultdict(list)
        for module in self.modules:
            for node in module.tree.body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    at[node.name].append(str(module.path))
        return {name: places for name, places in sorted(at.items()) if len(places) > 1}

    @cached_property
    def shared_stems(self) -> dict[str, list[str]]:
        """Names of modules that stand more than once; files of commands and rigs are named as users call them."""
        at: dict[str, list[str]] = defaultdict(list)
        for module in self.modules:
            if not module.path.stem.startswith("_") and module.path.parent.name not in (
                "commands",
                "rigs",
            ):
                at[module.path.stem].append(str(module.path))
        return {name: places for name, places in sorted(at.items()) if len(places) > 1}

    def change(self, own: str, named: str) -> tuple[list[str], list[str]]:
        """Files of an example's own, and files of the package that name it besides."""
        mine, others = list[str](), list[str]()
        for path in self.files:
            short = path.relative_to(self.source)
            if path.suffix not in {".py", ".json", ".toml", ".j2", ".c", ".h"}:
                continue
            if re.search(own, path.stem):
                mine.append(str(short))
            elif re.search(named, self._code_of(short, path), re.IGNORECASE):
                others.append(str(short))
        return mine, others

    def _code_of(self, short: Path, path: Path) -> str:
        module = self._by_path.get(str(PurePosixPath(short)))
        text = path.read_text(encoding="utf-8", errors="replace")
        return module.code if module else re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)

    @cached_property
    def _by_path(self) -> dict[str, Module]:
        return {str(module.path): module for module in self.modules}

    @cached_property
    def by_room(self) -> dict[str, list[Module]]:
        """Modules of each room, of each wing, and of the ground floor."""
        rooms: dict[str, list[Module]] = defaultdict(list)
        for module in self.modules:
            folders = module.path.parent.parts
            depth = 2 if folders[:1] == ("wings",) else 1
            rooms["/".join(folders[:depth]) or "ground floor"].append(module)
        return rooms

    def places(self, pattern: str) -> list[str]:
        """Lines that match outside of comments and docstrings, as FILE:LINE."""
        return [
            f"{module.path}:{number}"
            for module in self.modules
            for number, line in enumerate(module.text.splitlines(), start=1)
            if re.search(pattern, line)
            and number not in module.said
            and not line.lstrip().startswith("#")
        ]

    def circles(self, *, lazy: bool) -> list[list[str]]:
        """Groups of modules that import each other at their heads, or (lazy) wherever they import at run time."""
        names = {module.name for module in self.modules}
        return circles_in(
            {m.name: set(imports(m, names, lazy=lazy)) - {m.name} for m in self.modules}
        )

    def c_circles(self) -> list[list[str]]:
        """Groups of C files that need each other; a source and its header are one.

        A file needs what it includes, and the file that defines a function that it calls.
        """
        texts: dict[str, str] = defaultdict(str)
        for path in self.files:
            if path.suffix in (".c", ".h"):
                texts[path.stem] += path.read_text(encoding="utf-8", errors="replace")
        home: dict[str, str] = {}
        for unit, text in texts.items():
            home |= dict.fromkeys(
                re.findall(
                    r"^(?!static|typedef)\w[\w *]*?(\w+)\([^;{]*\)\s*\{", text, re.MULTILINE
                ),
                unit,
            )
        needs: dict[str, set[str]] = {}
        for unit, text in texts.items():
            called = {
                home[word] for word in set(re.findall(r"\b(\w+)\(", _bodies(text))) if word in home
            }
            included = {Path(name).stem for name in re.findall(r'#include "([^"]+)"', text)}
            needs[unit] = ((included & set(texts)) | called) - {unit}
        return circles_in(needs)


def _parents(name: str) -> list[str]:
    """A module's packages from the outermost, and itself."""
    parts = name.split(".")
    return [".".join(parts[:count]) for count in range(1, len(parts) + 1)]


def _bodies(text: str) -> str:
    """The inside of a C file's functions, without comments."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    return "\n".join(re.findall(r"\)\s*(\{.*?^\})", text, re.DOTALL | re.MULTILINE))


# --- the tables ------------------------------------------------------------------------------------------------------


def _line_breaks(path: Path) -> int:
    return path.read_bytes().count(b"\n")


def counts(house: House) -> dict[str, str]:
    """What is counted, each with its figure."""
    lengths = [length for length, _ in house.functions]
    longest, where = house.functions[-1]
    density = house.density
    lines = {name: house.lines(endings) for name, endings in LANGUAGES.items()}
    return {
        "rooms": f"{len(house.rooms)}",
        "wings": f"{len(house.wings)}",
        "modules on the ground floor": f"{len(house.ground_floor)}",
        "lines of the layer contract": f"{house.contract_lines}",
        "arrows up or aside": f"{len(house.arrows_up)}",
        "tokens a line of code": f"{density.tokens:.1f}",
        "comments a line of code": f"{density.comments:.1%}",
        "private functions named once in their file": f"{density.named_once:.0%}",
        "  with one caller there, and not handed on as a value": f"{density.called_once:.0%}",
        "longest file": f"{house.longest_file[0]} ({house.longest_file[1]})",
        **_length_of_way("a log's way", house.way_of_a_log),
        **_length_of_way("with all rules followed", house.way_through_all_rules),
        "source lines": f"{sum(lines.values()):,}",
        **{f"  {name}": f"{count:,}" for name, count in lines.items()},
        "functions": f"{len(lengths):,}",
        "  median length": f"{lengths[len(lengths) // 2]}",
        "  90 % length": f"{lengths[len(lengths) * 9 // 10]}",
        "  longest": f"{longest} ({where})",
        "lines with Any": f"{house.any_lines}",
        "import tricks": f"{len(house.import_tricks)}",
        "isinstance of a model's kind": f"{len(house.model_kinds)}",
        "class names that two classes share": f"{len(house.shared_classes)}",
        "module names that two modules share": f"{len(house.shared_stems)}",
        "definitions of the alias Array": f"{len(house.places(r'^Array(: TypeAlias)? = '))}",
        "circles at import": f"{len(house.circles(lazy=False))}",
        "circles with lazy imports": f"{len(house.circles(lazy=True))}",
        "circles in C": f"{len(house.c_circles())}",
        **{
            f"{name}, places": f"{len(house.places(pattern))}" for name, pattern in REPEATED.items()
        },
    }


def _length_of_way(title: str, stays: Sequence[str]) -> dict[str, str]:
    """Stays, files and returns of a way, and both counts without the files that one knows by name."""
    alone = [file for file, _ in groupby(file for file in stays if file not in VOCABULARY)]
    return {
        f"{title}: stays": f"{len(stays)}",
        f"{title}: files": f"{len(set(stays))}",
        f"{title}: returns": f"{len(stays) - len(set(stays))}",
        f"{title}: stays, errors and units apart": f"{len(alone)}",
        f"{title}: returns, errors and units apart": f"{len(alone) - len(set(alone))}",
    }


#: What is said of each room's density.
DENSITY = ("tokens a line", "comments a line", "private, named once", "longest file")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows as a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)


def main() -> None:
    """Print all tables of some checkouts."""
    parser = argparse.ArgumentParser(description="Measures of the house, a column a checkout.")
    parser.add_argument(
        "folders", nargs="*", type=Path, default=[HERE], help="checkouts; default: this one"
    )
    houses = [House(folder.resolve()) for folder in parser.parse_args().folders]
    for house in houses:
        if not house.modules:
            parser.error(f"{house.folder} holds no package in src: give the folder of a checkout")
    names = [house.folder.name for house in houses]
    columns = [counts(house) for house in houses]
    print(table(["", *names], [[key, *(column[key] for column in columns)] for key in columns[0]]))
    print("\nWhat a change touches: files of its own + files of the package that name it\n")
    rows: list[list[str]] = []
    for title, (own, named) in CHANGES.items():
        found = [house.change(own, named) for house in houses]
        rows.append(
            [
                title,
                *(
                    f"{len(mine)} + {len(others)}: {', '.join(others) or '-'}"
                    for mine, others in found
                ),
            ]
        )
    print(table(["to add", *names], rows))
    for house in houses:
        print(f"\n{house.folder.name}: how dense each room is, the densest first\n")
        print(table(["room", "files", "lines of code", *DENSITY], densities(house)))
    for house in houses:
        _details(house)


def densities(house: House) -> list[list[str]]:
    """Files and density of each room as a row, the densest room first."""
    rooms = [(name, modules, Density.of(modules)) for name, modules in house.by_room.items()]
    rooms.sort(key=lambda room: room[2].tokens, reverse=True)
    return [
        [
            name,
            f"{len(modules)}",
            f"{density.lines:,}",
            f"{density.tokens:.1f}",
            f"{density.comments:.1%}",
            f"{density.named_once:.0%} of {density.private}",
            f"{density.longest[0]} ({density.longest[1]})",
        ]
        for name, modules, density in rooms
    ]


def _details(house: House) -> None:
    print(f"\n{house.folder.name}: {', '.join(house.rooms)}; {', '.join(house.ground_floor)}")
    for name, places in house.shared_classes.items():
        print(f"  shared: {name} in {', '.join(places)}")
    for name, places in house.shared_stems.items():
        print(f"  shared: {name}.py in {', '.join(places)}")
    for climb in house.arrows_up:
        print(f"  up: {climb}")
    print(f"  a log's way: {' > '.join(house.way_of_a_log)}")
    print(f"  import tricks: {', '.join(house.import_tricks) or '-'}")
    kinds = Counter(place.rpartition(":")[0] for place in house.model_kinds)
    print(
        f"  a model's kind is asked for in: {', '.join(f'{n} x {path}' for path, n in kinds.items()) or '-'}"
    )
    for lazy, title in ((False, "at import"), (True, "with lazy imports")):
        for group in house.circles(lazy=lazy):
            print(f"  circle {title}: {', '.join(group)}")
    for group in house.c_circles():
        print(f"  circle in C: {', '.join(group)}")
    for name, pattern in REPEATED.items():
        print(f"  {name}: {', '.join(house.places(pattern)) or '-'}")


if __name__ == "__main__":
    main()
