"""How many small defects the tests of a room see: a seeded sample of mutants of the core.

    python studies/mutate.py [--seed 1] [--count 40] [--rooms arithmetic models ...] [--slow]
        [--results build/mutants.jsonl]

A mutant is the package with one operator, number, condition or statement changed, in a copy of the project. The tests
of its room that call the changed function run until the first one fails: the fast tests, with `--slow` then the slow
tests of the same files. Where no test of the room imports the module, tests of other rooms that do count too. Which
test calls what is seen once for each test file (`studies/mutate_calls.py`) and kept beside the results.

A mutant that no test kills is a survivor. Somebody reads the survivors: a survivor that changes nothing that the
package promises gets an entry, with the reason, in `studies/mutants_judged.toml`. An outcome is kept in the results
file as soon as it is known, so a run goes on where it was stopped. Remove the file after a change of the sources or the
tests.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]
PACKAGE = Path("src/erclutch")
JUDGED = Path(__file__).with_name("mutants_judged.toml")

#: What stands for the core of a room. The loop's judgement is C; its Python only starts and watches.
CORE = {
    "arithmetic": "arithmetic/*.py",
    "signals": "signals/*.py",
    "models": "models/**/*.py",
    "fit": "fit/**/*.py",
    "logs": "logs/**/*.py",
    "export": "export/**/*.py",
    "live": "wings/live/c/*.c",
}
#: By test file and function: its tests that call the function.
Calls = dict[str, dict[str, list[str]]]
#: A mutant that computes for longer is taken for an endless loop, and so for killed.
CPU_SECONDS = 240

SWAPS: dict[type[ast.AST], tuple[type[Any], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.Mult,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
    ast.USub: (ast.UAdd,),
}
C_SWAPS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "+": ("-",),
    "-": ("+",),
    "*": ("/",),
    "/": ("*",),
}
_C_OPERATOR = re.compile(r"(?<= )(?:<=|>=|==|!=|&&|\|\||[<>+*/-])(?= )")
#: What no test could run, or what only words a message: comments, lines of the preprocessor, what the compiler checks.
_C_ASIDE = re.compile(
    r"""/\*.*?\*/|//[^\n]*|^(?:#|_Static_assert)[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True)
class Change:
    """One place, and what makes the mutant of it."""

    line: int
    what: str
    apply: Callable[[], None]


def _setter(owner: Any, name: str, value: Any) -> Callable[[], None]:
    return lambda: setattr(owner, name, value)


def _replaced(items: list[Any], place: int, value: Any) -> Callable[[], None]:
    return lambda: items.__setitem__(place, value)


def _not_run(node: ast.AST) -> Iterator[ast.AST | None]:
    """Parts of a node that do nothing, or only word a message: types, decorators, docstrings, texts."""
    yield getattr(node, "annotation", None)
    yield getattr(node, "returns", None)
    yield from getattr(node, "decorator_list", ())
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        yield node.value
    if isinstance(node, ast.Raise):
        yield node.exc
    if isinstance(node, ast.keyword) and node.arg == "strict":
        yield node.value


def _running(node: ast.AST) -> Iterator[ast.AST]:
    yield node
    skipped = list(_not_run(node))
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.JoinedStr) and not any(child is other for other in skipped):
            yield from _running(child)


def _swaps(node: ast.AST) -> Iterator[tuple[str, Callable[[], None]]]:
    if isinstance(node, ast.Compare):
        for place, op in enumerate(node.ops):
            for other in SWAPS.get(type(op), ()):
                yield (
                    f"{type(op).__name__} -> {other.__name__}",
                    _replaced(node.ops, place, other()),
                )
    elif isinstance(node, ast.BinOp | ast.BoolOp | ast.UnaryOp | ast.AugAssign):
        for other in SWAPS.get(type(node.op), ()):
            yield f"{type(node.op).__name__} -> {other.__name__}", _setter(node, "op", other())


def _values(node: ast.AST) -> Iterator[tuple[str, Callable[[], None]]]:
    if isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float):
        value = node.value
        other = (
            (not value)
            if isinstance(value, bool)
            else value + 1
            if isinstance(value, int)
            else 2 * value or 1.0
        )
        yield f"{value} -> {other}", _setter(node, "value", other)
    if isinstance(node, ast.If | ast.IfExp):
        yield "condition negated", _setter(node, "test", ast.UnaryOp(ast.Not(), node.test))
    if isinstance(node, ast.Return) and not (
        node.value is None or ast.unparse(node.value) == "None"
    ):
        yield "None returned", _setter(node, "value", ast.Constant(None))


def _dropped(node: ast.AST) -> Iterator[tuple[ast.stmt, str, Callable[[], None]]]:
    for field in ("body", "orelse", "finalbody"):
        body: Any = getattr(node, field, None)
        for place, statement in enumerate(body if isinstance(body, list) else []):
            call = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call)
            if call or isinstance(statement, ast.AugAssign | ast.Raise):
                yield statement, "statement dropped", _replaced(body, place, ast.Pass())


def changes(tree: ast.Module) -> Iterator[Change]:
    """Every mutant of a module, always in the same order."""
    for node in _running(tree):
        for what, apply in (*_swaps(node), *_values(node)):
            yield Change(getattr(node, "lineno", 0), what, apply)
        for statement, what, apply in _dropped(node):
            yield Change(statement.lineno, what, apply)


def c_mutants(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, change and whole text of every mutant of a C file."""
    code = _C_ASIDE.sub(lambda found: re.sub(r"[^\n]", "_", found[0]), text)
    for found in _C_OPERATOR.finditer(code):
        for other in C_SWAPS[found[0]]:
            line = text.count("\n", 0, found.start()) + 1
            yield (
                line,
                f"{found[0]} -> {other}",
                text[: found.start()] + other + text[found.end() :],
            )


def sites(path: Path) -> list[tuple[int, str]]:
    """Line and change of every mutant of a file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".c":
        return [(line, what) for line, what, _ in c_mutants(text)]
    return [(change.line, change.what) for change in changes(ast.parse(text))]


def mutated(path: Path, number: int) -> str:
    """The file with its change of this number."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".c":
        return list(c_mutants(text))[number][2]
    tree = ast.parse(text)
    list(changes(tree))[number].apply()
    return ast.unparse(ast.fix_missing_locations(tree))


def sample(root: Path, rooms: list[str], seed: int, count: int) -> list[dict[str, Any]]:
    """Mutants drawn with equal chance among all of the rooms; the first ones of a longer sample are the shorter one."""
    drawn = []
    for room in rooms:
        for path in sorted((root / PACKAGE).glob(CORE[room])):
            lines = path.read_text(encoding="utf-8").splitlines()
            for number, (line, what) in enumerate(sites(path)):
                place = path.relative_to(root / PACKAGE).as_posix()
                code = lines[line - 1].strip()
                drawn.append(
                    {
                        "room": room,
                        "file": place,
                        "number": number,
                        "line": line,
                        "code": code,
                        "what": what,
                    }
                )
    random.Random(seed).shuffle(drawn)
    return drawn[:count]


def files_of(root: Path, room: str, module: Path) -> list[str]:
    """Test files of the room, those that import the module first.

    Where no test of the room imports the module, the tests of other rooms that do join them.
    """
    dotted = ".".join(module.relative_to(root / PACKAGE).with_suffix("").parts).removesuffix(
        ".__init__"
    )
    imported = re.compile(rf"erclutch\.{re.escape(dotted)} import ")
    tests = root / "tests"
    direct = [
        path
        for path in sorted(tests.rglob("test_*.py"))
        if imported.search(path.read_text(encoding="utf-8"))
    ]
    own = sorted((tests / room).rglob("test_*.py"))
    first = [path for path in direct if path in own] or direct
    return [
        str(path.relative_to(root))
        for path in (*first, *(path for path in own if path not in first))
    ]


def function_at(node: ast.AST, line: int, above: str = "") -> str:
    """Qualified name of the innermost function that holds a line; empty outside of functions."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.stmt) and child.lineno <= line <= (child.end_lineno or 0):
            if isinstance(child, ast.ClassDef):
                return function_at(child, line, f"{above}{child.name}.")
            if isinstance(child, ast.FunctionDef) and line > child.lineno:
                return (
                    function_at(child, line, f"{above}{child.name}.<locals>.") or above + child.name
                )
            return function_at(child, line, above)
    return ""


def tests_of(root: Path, mutant: dict[str, Any], calls: Calls) -> list[str]:
    """The tests that call the function of a mutant; where none is seen to, all tests of the room."""
    module = root / PACKAGE / mutant["file"]
    files = files_of(root, mutant["room"], module)
    if module.suffix == ".c":
        return files
    place = f"{mutant['file']}:{function_at(ast.parse(module.read_text(encoding='utf-8')), mutant['line'])}"
    found: list[str] = []
    for file in files:
        tests = calls[file].get(place, [])
        found += (
            [file] if file in tests else tests
        )  # a file by itself: while a test of it was set up
    return found or files


def outcome(
    copy: Path, tests: list[str], marks: str, seconds: int = CPU_SECONDS, *options: str
) -> str:
    """What these tests with these marks say: `survived`, or the first failure."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "--hypothesis-seed=0",
        "-m",
        marks,
    ]
    surroundings = {
        **os.environ,
        "PYTHONPATH": f"{copy / 'src'}:{copy}",
        "OPENBLAS_NUM_THREADS": "1",
    }
    surroundings |= {"MUTATE_SOURCE": str(copy / PACKAGE), "MUTATE_CALLS": str(copy / "calls.json")}
    done = subprocess.run(
        [*command, *options, *tests],
        cwd=copy, env=surroundings, capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds)),
    )  # fmt: skip
    if done.returncode in (0, 5):  # 5: none of them has these marks
        return "survived"
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    return f"killed: {failed[1] if failed else 'no test began, or out of time'}"


def copied(folder: Path) -> Path:
    """The files that git does not ignore, as they are now, beside the same public recordings."""
    if (shared := HERE.parent / "shared").is_dir():
        (folder / "shared").symlink_to(shared.resolve())
    folder /= "project"
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.run(
        listed, cwd=HERE, capture_output=True, text=True, check=True
    ).stdout.splitlines():
        if (HERE / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(HERE / name, folder / name)
    return folder


def called(copy: Path, kept: Path, rooms: list[str]) -> Calls:
    """By test file: which tests call which function. Files that are new or changed run once, without a mutant.

    The tests must pass. What is found is kept in a file for the next time.
    """
    modules = [
        (room, path)
        for room in rooms
        for path in (copy / PACKAGE).glob(CORE[room])
        if path.suffix == ".py"
    ]
    files = sorted({file for room, path in modules for file in files_of(copy, room, path)})
    digests = {file: hashlib.sha256((copy / file).read_bytes()).hexdigest() for file in files}
    known = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    for number, file in enumerate(files, 1):
        if file not in known or known[file][0] != digests[file]:
            print(f"{number} of {len(files)}: {file} without a mutant", flush=True)
            said = outcome(copy, [file], "not slow", 3600, "-p", "studies.mutate_calls")
            if said != "survived":
                raise SystemExit(f"a test fails without any mutant, {said}")
            known[file] = (
                digests[file],
                json.loads((copy / "calls.json").read_text("utf-8")).get(file, {}),
            )
            kept.write_text(json.dumps(known), encoding="utf-8")
    return {file: known[file][1] for file in files}


def run(
    wanted: list[dict[str, Any]], results: Path, rooms: list[str], stages: tuple[str, ...]
) -> list[dict[str, Any]]:
    """Outcomes of all wanted mutants, those that are known from before included."""
    known = (
        [json.loads(line) for line in results.read_text("utf-8").splitlines()]
        if results.exists()
        else []
    )
    have = {(entry["file"], entry["number"], entry["tests"]): entry for entry in known}
    results.parent.mkdir(parents=True, exist_ok=True)
    outcomes: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder, results.open("a", encoding="utf-8") as kept:
        copy = copied(Path(folder))
        calls = called(copy, results.with_name("mutants.calls.json"), rooms)
        for mutant in wanted:
            found: dict[str, Any] = {}
            for marks in stages:
                if found.get("outcome", "survived") == "survived":
                    key = mutant["file"], mutant["number"], marks
                    if key not in have:
                        have[key] = {
                            **mutant,
                            "tests": marks,
                            "outcome": judged_by_tests(copy, mutant, calls, marks),
                        }
                        print(
                            "{file}:{line}: {what}: {outcome} ({tests})".format(**have[key]),
                            flush=True,
                        )
                        kept.write(json.dumps(have[key]) + "\n")
                        kept.flush()
                    found = have[key]
            outcomes.append(found)
    return outcomes


def judged_by_tests(copy: Path, mutant: dict[str, Any], calls: Calls, marks: str) -> str:
    """The outcome of a mutant. The copy is as before afterwards."""
    path = copy / PACKAGE / mutant["file"]
    original, tests = path.read_text(encoding="utf-8"), tests_of(copy, mutant, calls)
    if marks == "slow":
        tests = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    path.write_text(mutated(path, mutant["number"]), encoding="utf-8")
    try:
        return outcome(copy, tests, marks)
    finally:
        path.write_text(original, encoding="utf-8")


def summary(outcomes: list[dict[str, Any]], judged: list[dict[str, str]]) -> str:
    """Survivors by name, and the share killed of those that change behaviour."""
    reasons = {(entry["file"], entry["code"], entry["what"]): entry["reason"] for entry in judged}
    survivors = [entry for entry in outcomes if entry["outcome"] == "survived"]
    lines, harmless = [], 0
    for entry in survivors:
        reason = reasons.get((entry["file"], entry["code"], entry["what"]))
        harmless += reason is not None
        lines.append(
            f"  {entry['file']}:{entry['line']}: {entry['what']} in `{entry['code']}`: {reason or 'SURVIVED'}"
        )
    killed, real = len(outcomes) - len(survivors), len(outcomes) - harmless
    lines.append(
        f"{len(outcomes)} mutants: {killed} killed, {harmless} without effect or promise, {real - killed} survived; "
        f"{killed} of {real} that change behaviour are killed ({killed / max(real, 1):.0%})"
    )
    return "\n".join(lines)


def main() -> None:
    """Draw, run, judge, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--rooms", nargs="+", choices=list(CORE), default=list(CORE))
    parser.add_argument("--slow", action="store_true", help="try the slow tests too")
    parser.add_argument("--results", type=Path, default=HERE / "build" / "mutants.jsonl")
    asked = parser.parse_args()
    wanted = sample(HERE, asked.rooms, asked.seed, asked.count)
    outcomes = run(wanted, asked.results, asked.rooms, ("not slow", "slow")[: 1 + asked.slow])
    judged = tomllib.loads(JUDGED.read_text(encoding="utf-8"))["mutant"] if JUDGED.exists() else []
    print(summary(outcomes, judged))


if __name__ == "__main__":
    main()
