"""The server answers with whole pages; each button of a page starts a command (`jobs`) in the workspace."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections.abc import Awaitable, Callable
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import quote

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route

from erclutch.errors import ErclutchError, listed
from erclutch.models.model_titles import title_of
from erclutch.report.numbers.number_text import percent_text
from erclutch.runs.run_about import kept_about
from erclutch.wings.app import actions, workspace
from erclutch.wings.app.desk import ALONE, Answer, Form, address, last_line
from erclutch.wings.app.log_answers import LogAnswers
from erclutch.wings.app.run_answers import RunAnswers, run_row
from erclutch.wings.app.workspace import SHOWN, Entry, NotThereError
from erclutch.wings.live.page.access import HEADERS, Access
from erclutch.wings.live.page.page_server import Guard

_SCRIPTS = (
    "app",
    "comparison",
    "framed_reports",
    "page",
    "reading_form",
    "running_job",
    "signal_plots",
    "upload",
)
#: Files that pages load, with the folder of the package that holds them.
_STATIC = {
    "app.css": ("wings/app/templates", "text/css"),
    **{f"{name}.js": ("wings/app/scripts", "text/javascript") for name in _SCRIPTS},
    "uPlot.iife.min.js": ("report/assets/uplot", "text/javascript"),
    "uPlot.min.css": ("report/assets/uplot", "text/css"),
}
_OWN = {
    **HEADERS,
    "referrer-policy": "same-origin",  # without a referrer a browser gives no Origin with a form
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
        "frame-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'self'"
    ),
}


class Workbench(LogAnswers, RunAnswers):
    """The application.

    Args:
        folder: the workspace.
        access: who gets an answer.
        scratch: a folder for what is made to be shown, which the caller removes.
    """

    def __init__(self, folder: Path, access: Access, scratch: Path) -> None:
        super().__init__(folder, access, scratch)
        get: dict[str, Answer] = {
            "/": self._home,
            "/log/{name}": self._log,
            "/words/{name}": self._words,
            "/course/{name}": self._course,
            "/together/{name}": self._together,
            "/job/{number:int}": self._job,
            "/job/{number:int}.json": self._job_state,
            "/run/{name}": self._run,
            "/run/{name}/report": self._report,
            "/file/{name}": self._file,
            "/shown/{name}": self._shown,
            "/alone/{name}": self._alone,
            "/static/{name}": self._static,
        }
        post: dict[str, Callable[[Request, Form], Awaitable[Response]]] = {
            "/log/{name}/mapping": self._keep_mapping,
            "/log/{name}/about": self._say_of_log,
            "/fit/{name}": self._fit,
            "/score/{name}": self._score_here,
            "/verify/{name}": self._verify,
            "/run/{name}/about": self._say_of_run,
            "/job/{number:int}/cancel": self._cancel,
            "/run/{name}/rename": self._rename,
            "/run/{name}/export": self._export,
            "/run/{name}/predict": self._predict,
            "/run/{name}/live": self._live,
            "/compare": self._compare,
            "/twin": self._twin,
        }
        routes: list[Route] = []
        for path, answer in get.items():
            routes.append(Route(path, self._told(answer), methods=["GET"]))
        for path, answer_form in post.items():
            answer = self._with_form(answer_form)
            routes.append(Route(path, self._told(answer), methods=["POST"]))
        routes.append(Route("/upload/{name}", self._told(self._upload), methods=["PUT"]))
        served = Starlette(
            routes=routes, exception_handlers={OSError: self._gone, RuntimeError: self._gone}
        )
        self.app = Guard(served, access, headers=_OWN, command="erclutch app")

    async def _home(self, request: Request) -> Response:
        # Off the loop: a folder on a slow disk must not hold up the other answers.
        return await run_in_threadpool(self._overview)

    def _overview(self) -> Response:
        space = self._space
        contents = space.look()
        logs = contents.logs
        runs = contents.runs
        results = contents.results
        left_out = ""
        most = max(len(logs), len(runs), len(results))
        if most > SHOWN:
            left_out = f"Of {most:,} entries of a kind the newest {SHOWN} are shown."
        unnamed = listed(sorted(contents.unnamed), most=5)
        results = results[:SHOWN]
        exports = {
            each.name for each in results if (space.folder / each.name / "export.json").is_file()
        }
        return self._page(
            "home",
            title="Overview",
            logs=logs[:SHOWN],
            runs=[self._row(run) for run in runs[:SHOWN]],
            results=results,
            left_out=left_out,
            unnamed=unnamed if contents.unnamed else "",
            exports=exports,
            jobs=[job for job in self.jobs if not job.whole],
        )

    def _row(self, run: Entry) -> dict[str, Any]:
        row = run_row(run, self._space.body(run.name))
        with contextlib.suppress(ErclutchError):
            row["tags"] = kept_about(self._space.folder / run.name).tags
        return row

    async def _job(self, request: Request) -> Response:
        job = self._found(request)
        if job.whole and job.state == "done":
            return RedirectResponse(job.back, 303)
        made = job.result if job.state == "done" and job.result else None
        kind = None if made is None else await run_in_threadpool(self._kind, made)
        if "lines" not in request.query_params:  # the verdict, not the terminal
            if kind == "run" and job.words[0] == "fit":
                return RedirectResponse(f"/run/{quote(str(made))}?job={job.number}", 303)
            if kind == "page" and job.words[0] == "compare":
                return RedirectResponse(f"/shown/{quote(str(made))}?job={job.number}", 303)
        # What `erclutch score` found, best first; None for another command, or where it printed no figures.
        scored: dict[str, Any] | None = None
        if job.words[0] == "score" and job.state == "done":
            printed = "\n".join(job.lines)
            with contextlib.suppress(ValueError):
                scored = json.loads(printed[printed.index("{") :])
        return self._page(
            "job",
            title=job.title,
            job=job,
            address=address(job),
            back=job.back,
            line=actions.shown(job.words),
            problem=actions.on_page(last_line(job)) if job.state == "failed" else "",
            made=made,
            kind=kind,
            device="?device=coaxial" if job.words[0] == "simulate" else "",
            scored=scored,
            verified=job.words[0] == "verify" and job.state == "done",
        )

    async def _job_state(self, request: Request) -> Response:
        job = self._found(request)
        doing = job.doing
        if job.fitted:
            newest = next(reversed(job.fitted))
            doing = doing.replace(newest, title_of(newest))
        # Models by how far each is off on the training rows, the nearest first; where that is not known, last.
        shares: dict[str, float] = {}
        for name, share in job.fitted.items():
            shares[name] = math.inf if share is None else share
        fitted: list[tuple[str, str]] = []
        for name in sorted(shares, key=shares.__getitem__):
            share = job.fitted[name]
            fitted.append((title_of(name), "" if share is None else percent_text(share, 2)))
        return JSONResponse(
            {
                "state": job.state,
                "share": job.share,
                "doing": doing,
                "seconds": round(job.seconds, 1),
                "fitted": fitted,
                "address": address(job),
                "lines": "\n".join(job.lines),
            }
        )

    async def _file(self, request: Request) -> Response:
        path = self._space.path(request.path_params["name"])
        if path.is_dir():
            packed = await run_in_threadpool(workspace.zipped, path)
            headers = {
                "content-disposition": f"attachment; filename*=utf-8''{quote(path.name)}.zip"
            }
            return Response(packed, media_type="application/zip", headers=headers)
        return FileResponse(path, filename=path.name, media_type="application/octet-stream")

    async def _shown(self, request: Request) -> Response:
        name = self._space.path(request.path_params["name"]).name
        return self._page("shown", title=name, name=name, job=request.query_params.get("job", ""))

    async def _alone(self, request: Request) -> Response:
        path = self._space.path(request.path_params["name"])
        if path.suffix != ".html" or not path.is_file():
            raise NotThereError("this is no page", where=path.name, remedy="Download it")
        return FileResponse(
            path, media_type="text/html", headers={"content-security-policy": ALONE}
        )

    async def _static(self, request: Request) -> Response:
        name = request.path_params["name"]
        if name not in _STATIC:
            raise NotThereError(
                "there is no such file", where=name[:80], remedy="Go back to the overview"
            )
        folder, kind = _STATIC[name]
        content = (files("erclutch") / folder / name).read_bytes()
        return Response(content, media_type=kind)

    async def _cancel(self, request: Request, form: Form) -> Response:
        job = self._found(request)
        job.cancel()
        await asyncio.to_thread(job.join, 2.0)
        return RedirectResponse(f"/job/{job.number}", 303)

    async def _twin(self, request: Request, form: Form) -> Response:
        if form.get("what") == "live":
            return self._begin(request, "The digital TWIN live", ["live"])
        out = self._space.free("twin-log.parquet")
        words = ["simulate", "training", "--seconds=60", "--out", out]
        return self._begin(request, "A log of the digital TWIN", words, out)
