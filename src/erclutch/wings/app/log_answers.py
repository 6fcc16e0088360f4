"""Answers about logs: the page of a log, its course over time, fits of it."""

from __future__ import annotations

import asyncio
import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlencode

from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from erclutch.runs.run_about import about_with
from erclutch.runs.run_shape import reading_of
from erclutch.wings.app import actions
from erclutch.wings.app.desk import Desk, Form, fields, last_line, quoted
from erclutch.wings.app.jobs import Job
from erclutch.wings.app.log_page import polyline, signals_of
from erclutch.wings.app.workspace import SHOWN, WorkspaceError, plain_name

_STRETCHES = 800  # of a log whose signals are drawn
_PATIENCE = 60.0  # s for what a page asks in the background
_SHORT = 3.0  # s: a look at a log that takes longer shows its progress


class LogAnswers(Desk):
    """What is asked about logs."""

    async def _log(self, request: Request) -> Response:
        name = self._space.path(request.path_params["name"]).name
        form = fields(request.url.query)
        if not form:
            known = await run_in_threadpool(self._last_reading, name)
            if known:  # as its newest run read it
                return RedirectResponse(f"{request.url.path}?{known}", 303)
        chosen = actions.chosen_of(form)
        here = f"{request.url.path}?{request.url.query}".rstrip("?")
        job = await self._look(name, chosen, here)
        if job.state == "running":
            return RedirectResponse(f"/job/{job.number}", 303)
        try:
            found: dict[str, Any] = json.loads(job.output)
        except ValueError:
            problem = last_line(job) or f"erclutch inspect ended with code {job.code}"
            return self._page(
                "problem",
                status=400,
                title=name,
                problem=actions.on_page(problem),
            )
        offered = await run_in_threadpool(self._offered_beside, name, form)
        about = await run_in_threadpool(self._space.about, name)
        signals = signals_of(found, chosen)
        score = form.get("score", "")
        return self._page(
            "log",
            title=name,
            name=name,
            form=form,
            chosen=chosen,
            # What the look at the log found.
            found=found,
            problem=found["problem"] and actions.on_page(found["problem"]),
            findings=[actions.on_page(text) for text in found["findings"]],
            warned=any(text.startswith("warning") for text in found["findings"]),
            signals=signals,
            checks=any(signal["check"] for signal in signals),
            sketches={
                column: polyline(values["sketch"]) for column, values in found["columns"].items()
            },
            # What can be filled in, and what was.
            said=actions.SAID,
            about=about,
            reading=actions.READING,
            switches=actions.SWITCHES,
            fitting=actions.FITTING,
            score=score if score and await run_in_threadpool(self._is_run, score) else "",
            **offered,
            **_lines({**form, "run": offered["run"]}, name),
        )

    async def _look(self, name: str, chosen: actions.Chosen, here: str, *more: str) -> Job:
        """The job that looks at a log so; it runs still if the look takes longer than a moment."""
        words = ["inspect", name, *more, *chosen.words(), "--json", "--courses", str(_STRETCHES)]
        state = await run_in_threadpool(self._space.state, name)
        job = self.jobs.look(f"Look at {name}", words, state, here)
        await asyncio.to_thread(job.join, _SHORT)
        return job

    async def _course(self, request: Request) -> Response:
        """The signals of a log over time, of a part of it in more detail."""
        name = self._space.path(request.path_params["name"]).name
        chosen = actions.chosen_of(fields(request.url.query))
        job = await self._look(name, chosen, f"/log/{quoted(name)}")
        await asyncio.to_thread(job.join, _PATIENCE)
        try:
            return JSONResponse(json.loads(job.output)["over_time"])
        except (ValueError, KeyError):
            return _no_result_of(job)

    async def _together(self, request: Request) -> Response:
        """Whether logs can be fitted together, in a sentence where they cannot."""
        name = self._space.path(request.path_params["name"]).name
        form = fields(request.url.query)
        known = await run_in_threadpool(self._known)
        others = [log for log in known if f"log.{log}" in form and log != name]
        if not others:
            return JSONResponse({"problem": ""})
        job = await self._look(name, actions.chosen_of(form), f"/log/{quoted(name)}", *others)
        await asyncio.to_thread(job.join, _PATIENCE)
        try:
            found: dict[str, Any] = json.loads(job.output)
        except ValueError:
            return _no_result_of(job)
        refused = [found["problem"] or "", *found["refused"].values()]
        first_problem = next(filter(None, refused), "")
        return JSONResponse({"problem": actions.on_page(first_problem)})

    def _known(self) -> list[str]:
        return [entry.name for entry in self._space.logs()]

    def _is_run(self, name: str) -> bool:
        return name in [entry.name for entry in self._space.runs()]

    async def _say_of_log(self, request: Request, form: Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        about = {key: form.get(f"about.{key}") for key, _, _ in actions.SAID}
        await run_in_threadpool(
            self._space.keep_about, name, about_with(self._space.about(name), **about)
        )
        return RedirectResponse(f"/log/{quoted(name)}?{urlencode(form)}", 303)

    async def _score_here(self, request: Request, form: Form) -> Response:
        """Score the models of a run on a log that is read as the form says."""
        name = self._space.path(request.path_params["name"]).name
        run = self._space.run(form.get("score", "")).name
        words = ["score", name, "--run", run, *actions.chosen_of(form).words(), "--json"]
        return self._begin(request, f"Score the models of {run} on {name}", words)

    def _offered_beside(self, name: str, form: Form) -> dict[str, Any]:
        """What the page of a log offers besides: other logs, models, mapping files, how an older log was read."""
        from erclutch.models.laws import shown_laws
        from erclutch.models.model_titles import title_of
        from erclutch.models.networks import PAPER_NETWORKS

        run = form.get("run", "")
        if not run or self._taken(run):
            run = self._free_run(f"{actions.safe_stem(Path(name).stem)}-run")
        mappings = self._space.mappings()

        # An upload whose name is taken gets a number: `day-2.csv` may be meant to be read as `day.csv` was.
        older = re.sub(r"-\d+(?=\.\w+$)", "", name)
        alike = None
        if older != name and set(form) <= {"known"}:
            beside = f"{older}.toml"
            alike = (
                f"map={quote(beside)}"
                if beside in mappings
                else self._last_reading(older, of_another_log=True)
            )

        return {
            "models": {name: title_of(name) for name in (*shown_laws(), *PAPER_NETWORKS)},
            "mappings": mappings,
            "run": run,
            "others": [entry.name for entry in self._space.logs() if entry.name != name],
            "older": older,
            "alike": alike,
        }

    def _last_reading(self, log: str, *, of_another_log: bool = False) -> str | None:
        """How the newest run of a log read it, as the query of a page, which may be the page of another log."""
        for entry in self._space.runs()[:SHOWN]:  # the newest first
            run = self._space.body(entry.name)
            if not run or not reading_of(run):
                continue
            if any(each["name"] == log for each in run["logs"]):
                return actions.query_of(run, of_another_log=of_another_log)
        return None

    async def _words(self, request: Request) -> Response:
        """The commands of a form while it is filled in."""
        name = self._space.path(request.path_params["name"]).name
        try:
            return JSONResponse(_lines(fields(request.url.query), name))
        except WorkspaceError as error:
            return JSONResponse({"problem": str(error)})

    async def _upload(self, request: Request) -> Response:
        try:
            name, known = await self._space.take(request.path_params["name"], request.stream())
        except ClientDisconnect:
            return Response(status_code=400)
        return JSONResponse({"log": f"/log/{quoted(name)}" + ("?known=1" if known else "")})

    async def _keep_mapping(self, request: Request, form: Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        words = [
            "inspect",
            name,
            *actions.chosen_of(form).words(),
            "--write-mapping",
            f"{name}.toml",
        ]
        return self._begin(request, f"Keep how {name} is read", words)

    async def _fit(self, request: Request, form: Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        known = await run_in_threadpool(self._known)
        others = [other for other in known if f"log.{other}" in form and other != name]
        logs = [name, *(self._space.path(other).name for other in others)]
        run = plain_name(form.get("run", "").strip())
        if self._taken(run) and run == form.get("suggested"):
            # Nobody chose that name: the page was open since the fit before.
            run = self._free_run(run)
        if self._taken(run):
            raise WorkspaceError(
                "there is such a run already", where=run, remedy="Go back and give another name"
            )
        return self._begin(
            request, f"Fit models to {', '.join(logs)}", actions.fit_words(form, logs, run), run
        )

    def _taken(self, run: str) -> bool:
        """Whether a run of that name is there, or is being made."""
        if (self._space.folder / run).exists():
            return True
        return any(job.result == run and job.code is None for job in self.jobs)

    def _free_run(self, stem: str) -> str:
        """A name that no run has, and none that is being made."""
        name = self._space.free(stem)
        number = 2
        while self._taken(name):
            name = f"{stem}-{number}"
            number += 1
        return name


def _no_result_of(job: Job) -> Response:
    """Why a look has no result: what it said last, or that it runs still."""
    why = actions.on_page(last_line(job)) or "this takes a while: try again"
    return JSONResponse({"problem": why})


def _lines(form: Form, log: str) -> dict[str, Any]:
    """What a form asks for as commands, and the fit in Python."""
    run = form.get("run", "").strip() or "RUN"
    logs = [log, *(name.removeprefix("log.") for name in form if name.startswith("log."))]
    read = actions.shown(["inspect", log, *actions.chosen_of(form).words()])
    fit = actions.shown(actions.fit_words(form, logs, run))
    return {"read": read, "fit": fit, "script": actions.fit_in_python(form, logs, run)}
