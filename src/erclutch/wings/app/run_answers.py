"""Answers about runs: the page of a run with its report, exports, estimates, comparisons."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, RedirectResponse, Response

from erclutch.report.numbers.number_text import percent_text
from erclutch.runs.run_about import RunAbout, about_with, kept_about, write_about
from erclutch.runs.run_shape import reading_of
from erclutch.wings.app import actions
from erclutch.wings.app.desk import ALONE, Desk, Form, in_short, quoted
from erclutch.wings.app.workspace import Entry, WorkspaceError

_NAMED = 3  # logs of a run that the overview names


class RunAnswers(Desk):
    """What is asked about runs."""

    async def _run(self, request: Request) -> Response:
        from erclutch.fit.choice.standing import chosen_name, standing_of_run
        from erclutch.registry import names
        from erclutch.runs.run_folder import read_run

        name = request.path_params["name"]
        run = await run_in_threadpool(read_run, self._space.run(name))
        logs = [entry.name for entry in await run_in_threadpool(self._space.logs)]
        sources = [log["name"] for log in run.body["logs"] if log["name"] in logs]
        about = await run_in_threadpool(self._about_run, name, sources)
        exports = await run_in_threadpool(self._exports, name)
        return self._page(
            "run",
            title=name,
            name=name,
            job=request.query_params.get("job", ""),
            # What the run says.
            run=run,
            row=run_row(Entry(name, 0, 0.0), run.body),
            titles=run.titles,
            standing=standing_of_run(run.body).word,
            chosen=chosen_name(run.body),
            sources=sources,
            # What can be done with it.
            targets=names("erclutch.targets"),
            singles=actions.SINGLE_TARGETS,
            exports=exports,
            logs=logs,
            query=actions.query_of(run.body),
            not_live=_not_live(run.body["units"]),
            # What was said of it.
            about=about,
            said=(("title", "Title of the report", ""), *actions.SAID),
        )

    def _about_run(self, name: str, logs: list[str]) -> RunAbout:
        """What was said of a run; of a run of which nobody said anything, what was said of its log."""
        folder = self._space.run(name)
        about = kept_about(folder)
        if about != RunAbout() or not logs:
            return about
        of_log = self._space.about(logs[0])
        if of_log != RunAbout():
            write_about(folder, of_log)
        return of_log

    def _exports(self, name: str) -> list[str]:
        """The exports of a run, the newest first."""
        exports: list[str] = []
        for result in self._space.results():
            is_export = (self._space.folder / result.name / "export.json").is_file()
            if is_export and result.name.startswith(f"{name}-"):
                exports.append(result.name)
        return exports

    async def _say_of_run(self, request: Request, form: Form) -> Response:
        folder = self._space.run(request.path_params["name"])
        keys = ("title", *(key for key, _, _ in actions.SAID))
        said = {key: form.get(f"about.{key}") for key in keys}
        about = about_with(kept_about(folder), **said)
        await run_in_threadpool(write_about, folder, about)
        return RedirectResponse(f"/run/{quoted(folder.name)}", 303)

    async def _verify(self, request: Request, form: Form) -> Response:
        """Run an export against its model."""
        name = self._space.path(request.path_params["name"]).name
        return self._begin(request, f"Verify {name}", ["verify", name])

    async def _report(self, request: Request) -> Response:
        """The report, written anew where the run is newer; never a file out of the run's folder."""
        name = request.path_params["name"]
        ending = "pdf" if request.query_params.get("download") == "pdf" else "html"
        folder = self._space.run(name)
        state = (folder / "run.json").stat()
        about = folder / "about.json"
        said_at = about.stat().st_mtime_ns if about.is_file() else 0
        made = self._scratch / f"{state.st_ino}-{state.st_mtime_ns}-{said_at}.{ending}"
        if not made.exists():
            code, _, said = await self._asked("report", name, "--out", str(made))
            if code:
                raise WorkspaceError(
                    said or "no report could be written", where=name, remedy="Fit the log again"
                )
        whole = f"{name}-report.{ending}" if "download" in request.query_params else None
        kind = "application/pdf" if ending == "pdf" else "text/html"
        return FileResponse(
            made,
            media_type=kind,
            headers={"content-security-policy": ALONE},
            filename=whole,
        )

    async def _rename(self, request: Request, form: Form) -> Response:
        name = form.get("to", "").strip()
        self._space.rename(request.path_params["name"], name)
        return RedirectResponse(f"/run/{quote(name)}", 303)

    async def _export(self, request: Request, form: Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        model = form.get("model", "")
        target = form.get("target", "")
        out = self._space.free(actions.safe_stem(f"{name}-{model}-{target}"))
        words = ["export", name, f"--model={model}", f"--to={target}", "--out", out]
        precision = form.get("precision") or (
            "float32" if target in actions.SINGLE_TARGETS else "float64"
        )
        if precision == "float32":
            words += ["--precision=float32"]
        if "alarms" in form:
            words += ["--alarms"]
        return self._begin(request, f"Export {model} of {name} to {target}", words, out)

    async def _predict(self, request: Request, form: Form) -> Response:
        name = self._space.path(request.path_params["name"]).name
        log = self._space.path(form.get("log", "")).name
        what = form.get("what")
        model = form.get("model", "")
        if what == "look":
            from erclutch.runs.run_folder import read_run

            run = await run_in_threadpool(read_run, self._space.folder / name)
            own = log in [each["name"] for each in run.body["logs"]]
            query = actions.query_of(run.body, of_another_log=not own)
            return RedirectResponse(f"/log/{quoted(log)}?{query}&score={quoted(name)}", 303)
        if what == "score":
            return self._begin(
                request,
                f"Score the models of {name} on {log}",
                ["score", log, "--run", name, "--json"],
            )
        out = self._space.free(f"{actions.safe_stem(f'{Path(log).stem}-{name}')}-estimate.csv")
        words = ["predict", log, "--run", name, f"--model={model}", "--band", "--out", out]
        return self._begin(request, f"Estimate {log} by {model} of {name}", words, out)

    async def _live(self, request: Request, form: Form) -> Response:
        from erclutch.runs.run_folder import read_run

        name = self._space.path(request.path_params["name"]).name
        model = form.get("model", "")
        run = await run_in_threadpool(read_run, self._space.folder / name)
        run.entry(model)  # refuses a name that the run does not have
        if reason := _not_live(run.body["units"]):
            raise WorkspaceError(
                reason, where=name, remedy="Fit a log of the TWIN, or run erclutch live on your rig"
            )
        rig = "twin-brake" if run.body["device"] == "single" else "twin"
        words = ["live", "--run", name, f"--model={model}", f"--rig={rig}"]
        return self._begin(request, f"{model} live on the digital TWIN", words)

    async def _compare(self, request: Request, form: Form) -> Response:
        runs = await run_in_threadpool(self._space.runs)
        ticked = [entry.name for entry in runs if f"run.{entry.name}" in form]
        chosen = [self._space.path(run).name for run in ticked]
        if len(chosen) < 2:
            raise WorkspaceError(
                "fewer than two runs are chosen", remedy="Tick two runs or more, then compare"
            )
        out = self._space.free("comparison.html")
        return self._begin(
            request, f"Compare {', '.join(chosen)}", ["compare", *chosen, "--out", out], out
        )


def _not_live(units: Mapping[str, str]) -> str:
    """Why a run's models cannot run live on the TWIN: its units, where they are known and others; empty if they can."""
    of_the_twin = {"effort": "N*m", "field": "", "slip": "rad/s"}
    others: list[str] = []
    for signal, unit in of_the_twin.items():
        own = units.get(signal, "?")  # "?": nobody said it
        if own not in (unit, "?"):
            others.append(f"{signal} in {own}")
    if not others:
        return ""
    return f"the TWIN has N m, a field without a unit and rad/s; this run has {', '.join(others)}"


def run_row(entry: Entry, body: Mapping[str, Any] | None) -> dict[str, Any]:
    """A run in the overview: its logs, when it was written, what it recommends, and the error of that."""
    from erclutch.fit.choice.standing import chosen_name, standing_of_run
    from erclutch.runs.run_about import moment_of

    changed = moment_of(entry.changed)
    row = {
        "name": entry.name,
        "date": "" if changed is None else f"{changed:%Y-%m-%d %H:%M}",
        "logs": "",
        "model": "not readable",
        "error": "",
        "rows": "",
        "held_out": "",
        "tags": "",
    }
    if body is None:
        return row
    chosen = next(each for each in body["ranking"] if each["name"] == chosen_name(body))
    names = [str(log["name"]) for log in body["logs"]]
    row["logs"] = (
        ", ".join(names)
        if len(names) <= _NAMED
        else f"{len(names)} logs, {names[0]} ... {names[-1]}"
    )
    # Runs of the same rows can be compared.
    row["rows"] = " ".join(sorted(log["sha256"] for log in body["logs"]))
    reading = reading_of(body)
    window = [str(reading.get(key, "")) for key in ("begin", "end", "skip")]
    test = str(body.get("settings", {}).get("test"))
    row["held_out"] = " ".join([*window, test])  # other rows where these differ
    row["model"] = chosen["title"]
    if standing_of_run(body).why_none:
        row["model"] = f"none; nearest: {chosen['title']}"
    error = chosen["test"]["rmse"][0]
    share = chosen["test"]["share"][0]
    if error is not None and share is not None:
        row["error"] = f"{error:.3g} {in_short(body['units']['effort'])} ({percent_text(share)})"
    return row
