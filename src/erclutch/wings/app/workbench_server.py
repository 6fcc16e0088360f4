"""The server answers with whole pages; each button of a page starts a command (`jobs`) in the workspace."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import re
from collections.abc import Awaitable, Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, quote, unquote, urlencode

import jinja2
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route

from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.wings.app import actions, jobs, workspace
from erclutch.wings.app.jobs import Job, Jobs
from erclutch.wings.app.log_page import polyline, signals_of
from erclutch.wings.app.workspace import Entry, NotThereError, Workspace, WorkspaceError, plain_name
from erclutch.wings.live.page.access import HEADERS, Access
from erclutch.wings.live.page.page_server import Guard

_LONGEST_FORM = 100_000
_PATIENCE = 120.0  # s for a report
_MOST_ASKED = 2  # reports that are written at a time
_SHORT = 3.0  # s: a look at a log that takes longer shows its progress
_STATIC = {"app.css": "text/css", "app.js": "text/javascript"}
_OWN = {
    **HEADERS,
    "referrer-policy": "same-origin",  # without a referrer a browser gives no Origin with a form
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
        "frame-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'self'"
    ),
}
#: A file that a command wrote may come from anywhere: it runs without this page's origin, and reaches nothing.
_ALONE = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; frame-ancestors 'self'"
)

_Form = Mapping[str, str]
_Answer = Callable[[Request], Awaitable[Response]]


class Workbench:
    """The application.

    Args:
        folder: the workspace.
        access: who gets an answer.
        scratch: a folder for what is made to be shown, which the caller removes.
    """

    def __init__(self, folder: Path, access: Access, scratch: Path) -> None:
        self._space, self._scratch, self._access = Workspace(folder), scratch, access
        self.jobs, self._turns = Jobs(self._space.folder), asyncio.Semaphore(_MOST_ASKED)
        templates = files("erclutch") / "wings/app/templates"
        self._pages: Any = jinja2.Environment(
            loader=jinja2.FileSystemLoader(str(templates)),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        self._pages.filters["quoted"] = _quoted
        self._pages.filters["alone"] = self._alone_address
        self._pages.globals.update(
            base=access.base, version=__version__, size=workspace.said_size, folder=str(self._space.folder)
        )
        get: dict[str, _Answer] = {
            "/": self._home,
            "/log/{name}": self._log,
            "/words/{name}": self._words,
            "/job/{number:int}": self._job,
            "/job/{number:int}.json": self._job_state,
            "/run/{name}": self._run,
            "/run/{name}/report": self._report,
            "/file/{name}": self._file,
            "/shown/{name}": self._shown,
            "/alone/{name}": self._alone,
            "/static/{name}": self._static,
        }
        post: dict[str, Callable[[Request, _Form], Awaitable[Response]]] = {
            "/log/{name}/mapping": self._keep_mapping,
            "/fit/{name}": self._fit,
            "/job/{number:int}/cancel": self._cancel,
            "/run/{name}/rename": self._rename,
            "/run/{name}/export": self._export,
            "/run/{name}/predict": self._predict,
            "/run/{name}/live": self._live,
            "/compare": self._compare,
            "/twin": self._twin,
        }
        routes = [Route(path, self._told(answer), methods=["GET"]) for path, answer in get.items()]
        routes += [Route(path, self._told(self._with_form(a)), methods=["POST"]) for path, a in post.items()]
        routes.append(Route("/upload/{name}", self._told(self._upload), methods=["PUT"]))
        self.app = Guard(Starlette(routes=routes), access, headers=_OWN, command="erclutch app")

    def _alone_address(self, address: str) -> str:
        """The address of a page that gets by without this page's cookie."""
        return self._access.alone_place(unquote(address)) + address

    # --- what all answers share ---------------------------------------------------------------------------------------

    def _told(self, answer: _Answer) -> _Answer:
        async def told(request: Request) -> Response:
            try:
                return await answer(request)
            except ErclutchError as error:
                if request.method == "PUT":
                    return JSONResponse({"problem": str(error)}, 400)
                back, problem = _origin(request), actions.on_page(str(error))
                status = 404 if isinstance(error, NotThereError) else 400
                return self._page("problem", status=status, title="This did not work", problem=problem, back=back)

        return told

    @staticmethod
    def _with_form(answer: Callable[[Request, _Form], Awaitable[Response]]) -> _Answer:
        async def read(request: Request) -> Response:
            body = b""
            async for piece in request.stream():
                body += piece
                if len(body) > _LONGEST_FORM:
                    raise WorkspaceError("the form is too long", remedy="Go back and send less")
            request.state.form = _fields(body.decode("utf-8", "replace"))
            return await answer(request, request.state.form)

        return read

    def _page(self, template: str, *, status: int = 200, **shown: Any) -> Response:
        text: str = self._pages.get_template(f"{template}.html.j2").render({"back": "/", **shown})
        return Response(text, status, media_type="text/html; charset=utf-8")

    def _begin(self, request: Request, title: str, words: list[str], result: str | None = None) -> Response:
        if self.jobs.full:
            raise WorkspaceError("four commands run already", remedy="Wait for one of them, or cancel one")
        job = self.jobs.begin(title, words, result=result, back=_origin(request))
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

    # --- pages --------------------------------------------------------------------------------------------------------

    async def _home(self, request: Request) -> Response:
        space = self._space
        logs, runs, results = await run_in_threadpool(lambda: (space.logs(), space.runs(), space.results()))
        told = await run_in_threadpool(lambda: [_run_row(run, space.body(run.name)) for run in runs])
        jobs = [job for job in self.jobs if not job.whole]
        shown: dict[str, Any] = {"logs": logs, "runs": told, "results": results, "jobs": jobs}
        return self._page("home", title="Overview", **shown)

    async def _log(self, request: Request) -> Response:
        name = self._space.path(request.path_params["name"]).name
        form = _fields(request.url.query)
        if not form and (known := await run_in_threadpool(self._last_reading, name)):
            return RedirectResponse(f"{request.url.path}?{known}", 303)  # as its newest run read it
        chosen = actions.chosen_of(form)
        words = ["inspect", name, *chosen.words(), "--json"]
        state = await run_in_threadpool(self._space.state, name)
        here = f"{request.url.path}?{request.url.query}".rstrip("?")
        job = self.jobs.look(f"Look at {name}", words, state, here)
        await asyncio.to_thread(job.join, _SHORT)
        if job.state == "running":
            return RedirectResponse(f"/job/{job.number}", 303)
        try:
            found: dict[str, Any] = json.loads(job.output)
        except ValueError:
            problem = _last_line(job) or f"erclutch inspect ended with code {job.code}"
            return self._page("problem", status=400, title=name, problem=actions.on_page(problem))
        shown = await run_in_threadpool(self._about_log, name, form)
        signals = signals_of(found, chosen)
        shown |= {"checks": any(signal["check"] for signal in signals)}
        shown |= {"warned": any(text.startswith("warning") for text in found["findings"])}
        shown |= {"sketches": {column: polyline(about["sketch"]) for column, about in found["columns"].items()}}
        shown |= {"findings": [actions.on_page(text) for text in found["findings"]], "signals": signals}
        shown |= {"problem": found["problem"] and actions.on_page(found["problem"]), "found": found, "chosen": chosen}
        shown |= {"reading": actions.READING, "fitting": actions.FITTING, "form": form}
        return self._page("log", title=name, name=name, **shown, **_lines({**form, "run": shown["run"]}, name))

    def _about_log(self, name: str, form: _Form) -> dict[str, Any]:
        """What the page of a log offers besides: other logs, models, mapping files, how an older log was read."""
        from erclutch.models.laws import shown_laws
        from erclutch.models.networks import PAPER_NETWORKS

        run = form.get("run", "")
        run = run if run and not self._taken(run) else self._free_run(f"{actions.safe_stem(Path(name).stem)}-run")
        older = re.sub(r"-\d+(?=\.\w+$)", "", name)
        alike = None
        if older != name and set(form) <= {"known"}:
            beside = f"{older}.toml"
            alike = f"map={quote(beside)}" if beside in self._space.mappings() else self._last_reading(older)
        others = [entry.name for entry in self._space.logs() if entry.name != name]
        known: dict[str, Any] = {"models": (*shown_laws(), *PAPER_NETWORKS), "mappings": self._space.mappings()}
        return {**known, "run": run, "others": others, "older": older, "alike": alike}

    def _last_reading(self, log: str) -> str | None:
        """How the newest run of a log read it, as the query of a page."""
        bodies = (self._space.body(entry.name) for entry in self._space.runs())
        found = (body for body in bodies if body and any(each["name"] == log for each in body["logs"]))
        return next((actions.query_of(body) for body in found if body.get("reading")), None)

    async def _words(self, request: Request) -> Response:
        """The commands of a form while it is filled in."""
        name = self._space.path(request.path_params["name"]).name
        try:
            return JSONResponse(_lines(_fields(request.url.query), name))
        except WorkspaceError as error:
            return JSONResponse({"problem": str(error)})

    async def _job(self, request: Request) -> Response:
        job = self._found(request)
        if job.whole and job.state == "done":
            return RedirectResponse(job.back, 303)
        made = job.result if job.state == "done" and job.result else None
        kind = None if made is None else self._kind(made)
        if kind == "run" and job.words[0] == "fit" and "lines" not in request.query_params:
            return RedirectResponse(f"/run/{quote(str(made))}?job={job.number}", 303)  # the verdict, not the terminal
        line = actions.shown(job.words)
        device = "?device=coaxial" if job.words[0] == "simulate" else ""
        problem = actions.on_page(_last_line(job)) if job.state == "failed" else ""
        shown: dict[str, Any] = {"line": line, "made": made, "kind": kind, "device": device, "problem": problem}
        return self._page("job", title=job.title, job=job, address=_address(job), back=job.back, **shown)

    async def _job_state(self, request: Request) -> Response:
        job = self._found(request)
        told = {"state": job.state, "share": job.share, "doing": job.doing, "seconds": round(job.seconds, 1)}
        return JSONResponse({**told, "lines": "\n".join(job.lines), "address": _address(job)})

    async def _run(self, request: Request) -> Response:
        from erclutch.fit.standing import standing_of_run
        from erclutch.registry import names
        from erclutch.runs.run_folder import read_run

        name = request.path_params["name"]
        run = await run_in_threadpool(read_run, self._space.run(name))
        targets, logs = names("erclutch.targets"), [entry.name for entry in self._space.logs()]
        sources = [log["name"] for log in run.body["logs"] if log["name"] in logs]
        query, row = actions.query_of(run.body), _run_row(Entry(name, 0, 0.0), run.body)
        shown: dict[str, Any] = {"targets": targets, "logs": logs, "sources": sources, "query": query, "row": row}
        shown |= {"run": run, "standing": standing_of_run(run.body).word, "singles": actions.SINGLE_TARGETS}
        shown |= {"job": request.query_params.get("job", ""), "not_live": _not_live(run.body["units"])}
        return self._page("run", title=name, name=name, **shown)

    async def _report(self, request: Request) -> Response:
        """The report, written anew where the run is newer; never a file out of the run's folder."""
        name = request.path_params["name"]
        state = (self._space.run(name) / "run.json").stat()
        made = self._scratch / f"{state.st_ino}-{state.st_mtime_ns}.html"
        if not made.exists():
            code, _, said = await self._asked("report", name, "--out", str(made))
            if code:
                raise WorkspaceError(said or "no report could be written", where=name, remedy="Fit the log again")
        whole = f"{name}-report.html" if "download" in request.query_params else None
        headers = {"content-security-policy": _ALONE}
        return FileResponse(made, media_type="text/html", headers=headers, filename=whole)

    async def _file(self, request: Request) -> Response:
        path = self._space.path(request.path_params["name"])
        if path.is_dir():
            packed = await run_in_threadpool(workspace.zipped, path)
            headers = {"content-disposition": f"attachment; filename*=utf-8''{quote(path.name)}.zip"}
            return Response(packed, media_type="application/zip", headers=headers)
        return FileResponse(path, filename=path.name, media_type="application/octet-stream")

    async def _shown(self, request: Request) -> Response:
        name = self._space.path(request.path_params["name"]).name
        return self._page("shown", title=name, name=name)

    async def _alone(self, request: Request) -> Response:
        path = self._space.path(request.path_params["name"])
        if path.suffix != ".html" or not path.is_file():
            raise NotThereError("this is no page", where=path.name, remedy="Download it")
        return FileResponse(path, media_type="text/html", headers={"content-security-policy": _ALONE})

    async def _static(self, request: Request) -> Response:
        name = request.path_params["name"]
        if name not in _STATIC:
            raise NotThereError("there is no such file", where=name[:80], remedy="Go back to the overview")
        data = (files("erclutch") / "wings/app/templates" / name).read_bytes()
        return Response(data, media_type=_STATIC[name])

    # --- buttons ------------------------------------------------------------------------------------------------------

    async def _upload(self, request: Request) -> Response:
        try:
            name, known = await self._space.take(request.path_params["name"], request.stream())
        except ClientDisconnect:
            return Response(status_code=400)
        return JSONResponse({"log": f"/log/{_quoted(name)}" + ("?known=1" if known else "")})

    async def _keep_mapping(self, request: Request, form: _Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        words = ["inspect", name, *actions.chosen_of(form).words(), "--write-mapping", f"{name}.toml"]
        return self._begin(request, f"Keep how {name} is read", words)

    async def _fit(self, request: Request, form: _Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        known = [entry.name for entry in self._space.logs()]
        others = [other for other in known if f"log.{other}" in form and other != name]
        logs = [name, *(self._space.path(other).name for other in others)]
        run = plain_name(form.get("run", "").strip())
        if self._taken(run) and run == form.get("suggested"):
            run = self._free_run(run)  # nobody chose that name: the page was open since the fit before
        if self._taken(run):
            raise WorkspaceError("there is such a run already", where=run, remedy="Go back and give another name")
        return self._begin(request, f"Fit models to {', '.join(logs)}", actions.fit_words(form, logs, run), run)

    def _taken(self, run: str) -> bool:
        """Whether a run of that name is there, or is being made."""
        return (self._space.folder / run).exists() or any(job.result == run and job.code is None for job in self.jobs)

    def _free_run(self, stem: str) -> str:
        """A name that no run has, and none that is being made."""
        names = itertools.chain([self._space.free(stem)], (f"{stem}-{number}" for number in itertools.count(2)))
        return next(name for name in names if not self._taken(name))

    async def _cancel(self, request: Request, form: _Form) -> Response:
        job = self._found(request)
        job.cancel()
        await asyncio.to_thread(job.join, 2.0)
        return RedirectResponse(f"/job/{job.number}", 303)

    async def _rename(self, request: Request, form: _Form) -> Response:
        name = form.get("to", "").strip()
        self._space.rename(request.path_params["name"], name)
        return RedirectResponse(f"/run/{quote(name)}", 303)

    async def _export(self, request: Request, form: _Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        model, target = form.get("model", ""), form.get("target", "")
        out = self._space.free(actions.safe_stem(f"{name}-{model}-{target}"))
        words = ["export", name, f"--model={model}", f"--to={target}", "--out", out]
        single = target in actions.SINGLE_TARGETS if not form.get("precision") else form["precision"] == "float32"
        words += ["--precision=float32"] if single else []
        words += ["--alarms"] if "alarms" in form else []
        return self._begin(request, f"Export {model} of {name} to {target}", words, out)

    async def _predict(self, request: Request, form: _Form) -> Response:
        name, log = (self._space.path(text).name for text in (request.path_params["name"], form.get("log", "")))
        if form.get("what") == "look":
            from erclutch.runs.run_folder import read_run

            run = await run_in_threadpool(read_run, self._space.folder / name)
            return RedirectResponse(f"/log/{_quoted(log)}?{actions.query_of(run.body)}", 303)
        if form.get("what") == "score":
            return self._begin(request, f"Score the models of {name} on {log}", ["score", log, "--run", name])
        model = form.get("model", "")
        out = self._space.free(f"{actions.safe_stem(f'{Path(log).stem}-{name}')}-estimate.csv")
        words = ["predict", log, "--run", name, f"--model={model}", "--band", "--out", out]
        return self._begin(request, f"Estimate {log} by {model} of {name}", words, out)

    async def _live(self, request: Request, form: _Form) -> Response:
        from erclutch.runs.run_folder import read_run

        name, model = self._space.path(request.path_params["name"]).name, form.get("model", "")
        run = await run_in_threadpool(read_run, self._space.folder / name)
        run.entry(model)  # refuses a name that the run does not have
        if reason := _not_live(run.body["units"]):
            raise WorkspaceError(reason, where=name, remedy="Fit a log of the TWIN, or run erclutch live on your rig")
        rig = "twin-brake" if run.body["device"] == "single" else "twin"
        words = ["live", "--run", name, f"--model={model}", f"--rig={rig}"]
        return self._begin(request, f"{model} live on the digital TWIN", words)

    async def _compare(self, request: Request, form: _Form) -> Response:
        chosen = [entry.name for entry in self._space.runs() if f"run.{entry.name}" in form]
        chosen = [self._space.path(run).name for run in chosen]
        if len(chosen) < 2:
            raise WorkspaceError("fewer than two runs are chosen", remedy="Tick two runs or more, then compare")
        out = self._space.free("comparison.html")
        return self._begin(request, f"Compare {', '.join(chosen)}", ["compare", *chosen, "--out", out], out)

    async def _twin(self, request: Request, form: _Form) -> Response:
        if form.get("what") == "live":
            return self._begin(request, "The digital TWIN live", ["live"])
        out = self._space.free("twin-log.parquet")
        return self._begin(
            request, "A log of the digital TWIN", ["simulate", "training", "--seconds=60", "--out", out], out
        )

    # --- parts --------------------------------------------------------------------------------------------------------

    def _found(self, request: Request) -> Job:
        job = self.jobs.get(request.path_params["number"])
        if job is None:
            problem = "there is no such job: the server was started anew, or it was long ago"
            raise NotThereError(problem, remedy="Look into the overview: what a command wrote is there")
        return job

    def _kind(self, name: str) -> str:
        if (self._space.folder / name / "run.json").is_file():
            return "run"
        if any(entry.name == name for entry in self._space.logs()):
            return "log"
        return "page" if name.endswith(".html") else "file"


def _not_live(units: Mapping[str, str]) -> str:
    """Why a run's models cannot run live on the TWIN: its units, where they are known and others; empty if they can."""
    usual = {"effort": "N*m", "field": "", "slip": "rad/s"}
    other = [f"{name} in {units[name]}" for name, unit in usual.items() if units.get(name, "?") not in (unit, "?")]
    return f"the TWIN has N m, a field without a unit and rad/s; this run has {', '.join(other)}" if other else ""


def _quoted(text: str) -> str:
    return quote(text, safe="")


def _fields(text: str) -> dict[str, str]:
    try:
        return dict(parse_qsl(text, keep_blank_values=True, max_num_fields=500))
    except ValueError as error:
        raise WorkspaceError("the form has too many fields", remedy="Go back and send fewer") from error


def _origin(request: Request) -> str:
    """The page that a button stands on: the log with what was filled in, the run, or the overview."""
    kind, name = request.url.path.split("/")[1], _quoted(request.path_params.get("name", ""))
    if kind in ("fit", "log") and request.method == "POST":
        return f"/log/{name}?{urlencode(request.state.form)}"
    return f"/run/{name}" if kind == "run" and request.url.path.count("/") > 2 else "/"


def _last_line(job: Job) -> str:
    """What a command said last."""
    return job.lines[-1].removeprefix("error: ") if job.lines else ""


def _lines(form: _Form, log: str) -> dict[str, Any]:
    """What a form asks for as commands, and the fit in Python."""
    run = form.get("run", "").strip() or "RUN"
    logs = [log, *(name.removeprefix("log.") for name in form if name.startswith("log."))]
    read = actions.shown(["inspect", log, *actions.chosen_of(form).words()])
    fit = actions.shown(actions.fit_words(form, logs, run))
    return {"read": read, "fit": fit, "script": actions.fit_in_python(form, logs, run)}


def _run_row(entry: Entry, body: Mapping[str, Any] | None) -> dict[str, Any]:
    """A run in the overview: its logs, when it was written, what it recommends, and the error of that."""
    from datetime import datetime

    from erclutch.fit.standing import standing_of_run

    row = {"name": entry.name, "logs": "", "model": "not readable", "error": ""}
    row["date"] = f"{datetime.fromtimestamp(entry.changed):%Y-%m-%d %H:%M}"
    if body is not None:
        chosen = next(each for each in body["ranking"] if each["name"] == body["recommended"])
        error, share = chosen["test"]["rmse"][0], chosen["test"]["share"][0]
        row["logs"] = ", ".join(log["name"] for log in body["logs"])
        row["model"] = f"none; nearest {chosen['name']}" if standing_of_run(body).why_none else chosen["name"]
        if error is not None and share is not None:
            row["error"] = f"{error:.3g} {body['units']['effort']} ({share:.1%})"
    return row


def _communicate(process: Any) -> tuple[bytes, bytes]:
    """Output and errors of a command, with its standard input left open until it ends."""
    import subprocess
    import threading

    timer = threading.Timer(_PATIENCE, process.kill)
    timer.start()
    kept, process.stdin = process.stdin, None  # `communicate` would close it, and so end the command
    try:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.communicate()
    finally:
        process.stdin = kept
        timer.cancel()
    return b"", b""


def _address(job: Job) -> str | None:
    """The address of the live page of a job that runs, on this machine alone."""
    if job.code is not None:
        return None
    for line in reversed(job.lines):
        found = re.search(r"http://127\.0\.0\.1:\d{2,5}/#token=[A-Za-z0-9_-]+", line)
        if found:
            return found[0]
    return None
