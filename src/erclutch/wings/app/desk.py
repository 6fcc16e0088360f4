"""What the answers of the app share: the folder, the commands that run, pages, forms, and how a problem is told."""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Awaitable, Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, quote, unquote, urlencode

import jinja2
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.report.numbers.number_text import number
from erclutch.wings.app import actions, jobs, workspace
from erclutch.wings.app.jobs import Job, Jobs
from erclutch.wings.app.workspace import NotThereError, Workspace, WorkspaceError
from erclutch.wings.live.page.access import Access

_LONGEST_FORM = 100_000  # bytes
_PATIENCE = 120.0  # s for a report
_MOST_ASKED = 2  # reports that are written at a time
#: A file that a command wrote may come from anywhere: it runs without this page's origin, and reaches nothing.
ALONE = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; frame-ancestors 'self'"
)

Form = Mapping[str, str]
Answer = Callable[[Request], Awaitable[Response]]


class Desk:
    """What all answers work on.

    Args:
        folder: the workspace.
        access: who gets an answer.
        scratch: a folder for what is made to be shown, which the caller removes.
    """

    def __init__(self, folder: Path, access: Access, scratch: Path) -> None:
        self._space = Workspace(folder)
        self._scratch = scratch
        self._access = access
        self.jobs = Jobs(self._space.folder)
        self._turns = asyncio.Semaphore(_MOST_ASKED)
        templates = files("erclutch") / "wings/app/templates"
        self._pages: Any = jinja2.Environment(
            loader=jinja2.FileSystemLoader(str(templates)),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        self._pages.filters["quoted"] = quoted
        self._pages.filters["number"] = number
        self._pages.filters["unit"] = in_short
        self._pages.filters["alone"] = self._alone_address
        self._pages.globals.update(
            base=access.base,
            version=__version__,
            size=workspace.said_size,
            folder=workspace.shown_folder(self._space.folder),
        )

    def _alone_address(self, address: str) -> str:
        """The address of a page that gets by without this page's cookie."""
        return self._access.alone_place(unquote(address)) + address

    def _told(self, answer: Answer) -> Answer:
        async def told(request: Request) -> Response:
            try:
                return await answer(request)
            except ErclutchError as error:
                status = 404 if isinstance(error, NotThereError) else 400
                if _is_asked_by_script(request):
                    return JSONResponse({"problem": str(error)}, status)
                return self._page(
                    "problem",
                    status=status,
                    title="This did not work",
                    problem=actions.on_page(str(error)),
                    back=origin(request),
                )

        return told

    async def _gone(self, request: Request, error: Exception) -> Response:
        """A file that was there as an answer began went away, or cannot be read: another program took it."""
        if isinstance(error, OSError):
            why = error.strerror or str(error)
        # What the server says as it begins to send a file.
        elif str(error).startswith("File at path"):
            why = "there is no such file any more"
        else:
            raise error
        problem = f"A file of the folder changed while this page was made ({why}). Go back to the overview."
        if _is_asked_by_script(request):
            return JSONResponse({"problem": problem}, 404)
        return self._page("problem", status=404, title="This did not work", problem=problem)

    @staticmethod
    def _with_form(answer: Callable[[Request, Form], Awaitable[Response]]) -> Answer:
        async def read(request: Request) -> Response:
            body = b""
            async for piece in request.stream():
                body += piece
                if len(body) > _LONGEST_FORM:
                    raise WorkspaceError("the form is too long", remedy="Go back and send less")
            request.state.form = fields(body.decode("utf-8", "replace"))
            return await answer(request, request.state.form)

        return read

    def _page(self, template: str, *, status: int = 200, **shown: Any) -> Response:
        text: str = self._pages.get_template(f"{template}.html.j2").render({"back": "/", **shown})
        return Response(text, status, media_type="text/html; charset=utf-8")

    def _begin(
        self,
        request: Request,
        title: str,
        words: list[str],
        result: str | None = None,
    ) -> Response:
        if self.jobs.full:
            raise WorkspaceError(
                "four commands run already", remedy="Wait for one of them, or cancel one"
            )
        job = self.jobs.begin(title, words, result=result, back=origin(request))
        return RedirectResponse(f"/job/{job.number}", 303)

    async def _asked(self, *words: str) -> tuple[int, bytes, str]:
        """Exit code, output and last error line of a short command; it ends with the request. Few run at a time."""
        async with self._turns:
            return await self._in_turn(words)

    async def _in_turn(self, words: tuple[str, ...]) -> tuple[int, bytes, str]:
        process = await asyncio.to_thread(jobs.start, words, self._space.folder)
        try:
            out, errors = await asyncio.to_thread(_communicate, process)
        finally:
            jobs.close_input(process)
            process.kill()
        said = errors.decode("utf-8", "replace").strip().splitlines()
        return process.returncode, out, said[-1].removeprefix("error: ") if said else ""

    def _found(self, request: Request) -> Job:
        job = self.jobs.get(request.path_params["number"])
        if job is None:
            problem = "there is no such job: the server was started anew, or it was long ago"
            raise NotThereError(
                problem, remedy="Look into the overview: what a command wrote is there"
            )
        return job

    def _kind(self, name: str) -> str:
        if (self._space.folder / name / "run.json").is_file():
            return "run"
        if any(entry.name == name for entry in self._space.logs()):
            return "log"
        return "page" if name.endswith(".html") else "file"


def _is_asked_by_script(request: Request) -> bool:
    """Whether a script of the page waits for the answer, which a page of its own does not reach."""
    return request.method == "PUT" or request.headers.get("accept") == "application/json"


def _communicate(process: Any) -> tuple[bytes, bytes]:
    """Output and errors of a command, with its standard input left open until it ends."""
    import subprocess
    import threading

    timer = threading.Timer(_PATIENCE, process.kill)
    timer.start()
    # `communicate` would close the input, and so end the command.
    kept_open = process.stdin
    process.stdin = None
    try:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.communicate()
    finally:
        process.stdin = kept_open
        timer.cancel()
    return b"", b""


def in_short(unit: str) -> str:
    """A unit as the report prints it."""
    from erclutch.report.numbers.number_text import brief, unit_text

    return brief(unit_text(unit))


def quoted(text: str) -> str:
    """A text as one part of an address."""
    return quote(text, safe="")


def fields(text: str) -> dict[str, str]:
    """The fields of a form or of an address."""
    try:
        return dict(parse_qsl(text, keep_blank_values=True, max_num_fields=500))
    except ValueError as error:
        raise WorkspaceError(
            "the form has too many fields", remedy="Go back and send fewer"
        ) from error


def origin(request: Request) -> str:
    """The page that a button stands on: the log with what was filled in, the run, or the overview.

    The form of a verification says of which run its export is (``?run=``).
    """
    kind = request.url.path.split("/")[1]
    name = quoted(request.path_params.get("name", ""))
    if kind in ("fit", "log", "score") and request.method == "POST":
        return f"/log/{name}?{urlencode(request.state.form)}"
    if kind == "verify" and (run := request.query_params.get("run")):
        return f"/run/{quoted(run)}"
    if kind == "run" and request.url.path.count("/") > 2:
        return f"/run/{name}"
    return "/"


def last_line(job: Job) -> str:
    """What a command said last."""
    return job.lines[-1].removeprefix("error: ") if job.lines else ""


def address(job: Job) -> str | None:
    """The address of the live page of a job that runs, on this machine alone."""
    if job.code is not None:
        return None
    for line in reversed(job.lines):
        printed = re.search(r"http://127\.0\.0\.1:\d{2,5}/#token=[A-Za-z0-9_-]+", line)
        if printed:
            return printed[0]
    return None
