"""Programs that start warm: a process that has imported what erclutch needs forks for each, which saves it a second.

A page of the documentation runs dozens of commands, each a start of Python with NumPy, SciPy and pandas. The cold start
has tests of its own (`tests/cli/test_startup.py`).

    with WarmStart(folder) as warm:
        subprocess.run(["erclutch", "--help"], env=warm.environment(os.environ))

`erclutch` and `warm-python` in the folder are small programs: they hand their words, folder, environment and streams to
the warm process (`serve`), and end with the exit code of its child. What the environment has in PYTHONPATH comes first
among the child's places of modules, as at a start of Python.
"""

from __future__ import annotations

import array
import importlib
import json
import os
import runpy
import socket
import subprocess
import sys
import traceback
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

#: What nearly every command imports of others, for a second.
OF_OTHERS = (
    *("cyclopts", "pandas", "pyarrow.parquet", "scipy.linalg", "scipy.optimize", "scipy.signal"),
    *("numba", "sympy", "matplotlib.figure"),
)
#: And of erclutch.
_IMPORTED = (
    *OF_OTHERS,
    *(
        "erclutch.cli.parser",
        "erclutch.fit.comparison",
        "erclutch.logs",
        "erclutch.runs.run_folder",
    ),
    *("erclutch.report.html.report_page", "erclutch.export"),
)
_STREAMS = 3  # input, output, errors
#: The small program. Its own start takes 20 ms: it imports nothing of erclutch, and no site-packages.
_PROGRAM = """#!{python} -SE
import array, json, os, socket, sys
words = [{name!r}, *sys.argv[1:]]
asked = json.dumps([words, os.getcwd(), dict(os.environ)]).encode()
with socket.socket(socket.AF_UNIX) as warm:
    warm.connect({place!r})
    streams = array.array("i", (0, 1, 2))
    warm.sendmsg([len(asked).to_bytes(8, "big")], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams)])
    warm.sendall(asked)
    code = warm.recv(1)
sys.exit(code[0] if code else 70)
"""


class WarmStart:
    """The warm process and its small programs.

    Args:
        folder: for the programs and the socket; its path must be short, as those of sockets are.
        imported: names of the modules that are there from the start.
        python: that runs them.
    """

    def __init__(
        self,
        folder: Path,
        imported: Sequence[str] = _IMPORTED,
        python: str | Path = sys.executable,
    ) -> None:
        self.folder = folder
        self._imported = imported
        self._python = str(python)
        self._place = folder / "warm"
        for name in ("erclutch", "warm-python"):
            program = folder / name
            text = _PROGRAM.format(python=sys.executable, name=name, place=str(self._place))
            program.write_text(text, encoding="utf-8")
            program.chmod(0o755)

    def __enter__(self) -> Self:
        command = [self._python, "-m", __name__, str(self._place), *self._imported]
        root = str(Path(__file__).parents[2])
        path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
        environment = {
            **os.environ,
            "PYTHONPATH": path,
            "PYTHONUTF8": "1",
            "COLUMNS": "100",
            "NO_COLOR": "1",
        }
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.communicate()

    def environment(self, given: Mapping[str, str]) -> dict[str, str]:
        """An environment in which the small programs come first."""
        return {**given, "PATH": os.pathsep.join((str(self.folder), given["PATH"]))}


def serve(place: str, imported: Sequence[str]) -> None:
    """Fork for each program that asks, until this process is ended."""
    for name in imported:
        importlib.import_module(name)
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(place)
        door.listen()
        print("ready", flush=True)
        while True:
            program, _ = door.accept()
            if os.fork() == 0:
                door.close()
                _become(program)
            program.close()
            _bury()


def _bury() -> None:
    """Wait for the children that have ended."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _become(program: socket.socket) -> None:
    """Do what the small program was asked, and tell it the exit code."""
    length, streams = _asked_first(program)
    text = b""
    while len(text) < length:
        text += program.recv(length - len(text))
    words, folder, environment = json.loads(text)
    for place, stream in enumerate(streams):
        os.dup2(stream, place)
        os.close(stream)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    given = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    sys.path[1:1] = [place for place in given if place not in sys.path]  # behind that of a script
    code = 1
    try:
        code = _code_of(words)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        program.sendall(bytes([code]))
        os._exit(code)


def _asked_first(program: socket.socket) -> tuple[int, list[int]]:
    """How long the message will be, and the streams that come with its length."""
    streams = array.array("i")
    head, more, _, _ = program.recvmsg(8, socket.CMSG_SPACE(_STREAMS * streams.itemsize))
    for _, _, sent in more:
        streams.frombytes(sent[: len(sent) - len(sent) % streams.itemsize])
    return int.from_bytes(head, "big"), list(streams)


def _code_of(words: list[str]) -> int:
    """Exit code of a command, or of a script of Python whose warnings are errors."""
    name, *others = words
    try:
        if name == "erclutch":
            from erclutch.__main__ import main

            sys.argv = words
            return main()
        *_, script = others
        sys.argv, sys.path[0] = [script], str(Path(script).parent)
        warnings.simplefilter("error")
        runpy.run_path(script, run_name="__main__")
        return 0
    except SystemExit as end:
        return _as_code(end.code)
    except BaseException:
        traceback.print_exc()
        return 1


def _as_code(said: Any) -> int:
    """What Python makes of the argument of `sys.exit`."""
    if said is None or isinstance(said, int):
        return said or 0
    print(said, file=sys.stderr)
    return 1


if __name__ == "__main__":
    serve(sys.argv[1], sys.argv[2:])
