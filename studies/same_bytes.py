"""Do two source trees give the same bytes? `python studies/same_bytes.py OLD NEW --data FOLDER [--out FOLDER]`.

OLD and NEW are checkouts. FOLDER holds `mr_damper_nees` and `mr_damper_utfsm` (REAL). Both trees run the same commands,
one after the other, and each file that differs is printed with its first line that differs. The exit code is 1 then.
What a tree has made stays in --out and is not made again, so that one run of OLD serves many of NEW.

Left out of the comparison: dates, versions of the program, and times that a machine takes.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path

NEES = ("--field", "Y [V]", "--slip", "V [cm/s]", "--effort", "F [N]")
UTFSM = (
    *("--time", "c1 [s]", "--slip", "c3 [mm/s]", "--effort", "c4 [N]"),
    *("--name-pattern", "{amplitude}mm{frequency}Hz{field}A"),
)
#: Five currents at one motion, and another motion to hold out.
UTFSM_LOGS = ("5mm3Hz0A", "5mm3Hz0x25A", "5mm3Hz0x5A", "5mm3Hz0x75A", "5mm3Hz1A", "10mm1Hz1A")
UTFSM_MODELS = (
    "bingham",
    "casson",
    "hem",
    "cho-choi-jhon",
    "bingham+dahl-2/field",
    "casson+effort-lag+inertia",
)

MEMORY = "rise-fall+lugre/field+inertia+dahl/field"
#: Models of the run on NEES that are exported as C: laws, networks, and a network on a law, with memory and without.
EXPORTED = (
    "casson+lag",
    f"casson+{MEMORY}",
    "rbfn-10",
    f"fnn-16+{MEMORY}",
    f"casson+fnn-16+{MEMORY}",
)


def commands(data: Path, out: Path) -> dict[str, tuple[str, ...]]:
    """What a tree runs, by the folder of its results in OUT; a later command may build on an earlier one."""
    nees = data / "mr_damper_nees" / "ranran_50_converted.csv"
    utfsm = [str(data / "mr_damper_utfsm" / "preprocessed" / f"{name}.txt") for name in UTFSM_LOGS]
    return {
        "nees": ("fit", str(nees), *NEES, "--out", "run"),
        "utfsm": (
            "fit",
            *utfsm,
            *UTFSM,
            "--test",
            "10mm*",
            "--models",
            *UTFSM_MODELS,
            "--out",
            "run",
        ),
        **{
            f"c-{number}": ("export", str(out / "nees" / "run"), "--model", model, "--out", "c")
            for number, model in enumerate(EXPORTED)
        },
        "table2": ("reproduce", "table2", "--seconds", "60", "--out", "run"),
    }


def made(tree: Path, job: str, words: Sequence[str], out: Path) -> Path:
    """The folder with what one tree makes of one command, and what it prints."""
    folder = out / job
    if folder.exists():
        return folder
    with tempfile.TemporaryDirectory(dir=out) as name:
        work = Path(name) / job
        work.mkdir()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [sys.executable, "-m", "erclutch", *words],
            cwd=work,
            env=os.environ
            | {"PYTHONPATH": str(tree / "src"), "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "120"},
            capture_output=True,
            text=True,
            check=False,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            raise SystemExit(f"{tree}: erclutch {job} failed\n{done.stderr}")
        (work / "printed.txt").write_text(done.stdout, encoding="utf-8")
        work.rename(folder)
    print(
        f"{tree.name} {job}: {after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime:.1f} CPU s"
    )
    return folder


def differences(old: Path, new: Path) -> Iterator[str]:
    """Each file that differs, with the first line that does."""
    names = {
        path.relative_to(folder)
        for folder in (old, new)
        for path in folder.rglob("*")
        if path.is_file()
    }
    for name in sorted(names):
        if not (old / name).exists() or not (new / name).exists():
            yield f"{name}: only in {'new' if (new / name).exists() else 'old'}"
            continue
        before, after = (kept(folder / name) for folder in (old, new))
        pairs = enumerate(zip_longest(before, after), start=1)
        line = next((number for number, (a, b) in pairs if a != b), None)
        if line is not None:
            yield f"{name}, line {line}: {_short(before, line)} -> {_short(after, line)}"


def kept(path: Path) -> list[bytes]:
    """The lines of a file that must be the same, without what moves from run to run."""
    lines = [line for line in path.read_bytes().splitlines() if not MOVES.search(line)]
    if path.suffix == ".csv" and b"cpu_s" in lines[0]:
        place = lines[0].split(b",").index(b"cpu_s")
        cells = [line.split(b",") for line in lines]
        return [b",".join(row[:place] + row[place + 1 :]) for row in cells]
    if any(b"CPU s" in line for line in lines):
        return [CPU_SECONDS.sub(b"", line) for line in lines]
    return lines


def _short(lines: Sequence[bytes], number: int) -> str:
    return (
        lines[number - 1][:80].decode(errors="replace").strip()
        if number <= len(lines)
        else "(no line)"
    )


#: Lines that hold a date, a version, or the time that a machine took.
MOVES = re.compile(rb'"(date|made|version|seconds)"|models in [\d.]+ (CPU )?s')
#: The last column of a table of models: the CPU time of a fit.
CPU_SECONDS = re.compile(rb"\s[\d.]+\s*$")


def main() -> None:
    """Run both trees and print each file that differs."""
    parser = argparse.ArgumentParser(description="Files that two source trees make differently.")
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--data", type=Path, required=True, help="folder with the recordings")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("same_bytes"),
        help="what the trees make; default: %(default)s",
    )
    asked = parser.parse_args()
    shutil.rmtree(asked.out / "new", ignore_errors=True)
    differing = 0
    places = {name: (asked.out / name).resolve() for name in ("old", "new")}
    for place in places.values():
        place.mkdir(parents=True, exist_ok=True)
    data = asked.data.resolve()
    for job in commands(data, places["old"]):
        folders: list[Path] = []
        for tree, out in zip((asked.old, asked.new), places.values(), strict=True):
            folders.append(made(tree.resolve(), job, commands(data, out)[job], out))
        found = list(differences(*folders))
        files = sum(path.is_file() for path in folders[0].rglob("*"))
        print(f"{job}: {files} files, {len(found)} differ")
        for line in found:
            print(f"  {line}")
        differing += len(found)
    sys.exit(differing > 0)


if __name__ == "__main__":
    main()
