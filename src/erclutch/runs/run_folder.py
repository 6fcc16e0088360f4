"""A run is a folder: what was asked, what was read, what came out. The same log and settings give the same bytes.

::

    run.json             settings, versions, logs with digests, findings, the ranked figures, the recommendation,
                         the gapless stretches of rows and the digests of the other files
    table.csv            the ranking, a row a model
    models/NAME.json     each model with its numbers, parameters with intervals, and a digest
    models/final.json    the recommended model fitted to all rows, if asked for: no row judges it
    predictions.parquet  time, fields, slips, further inputs, measured effort, the test mask, each model's effort

A folder is written beside its final name and moved there when it is whole, so there is never half a run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from erclutch.errors import RunError
from erclutch.export.c_names import named_after
from erclutch.files.given_files import (
    MOST_BYTES,
    MOST_OF_ROWS,
    file_digest,
    plain_words,
    small_json,
)
from erclutch.fit.choice.standing import Standing, standing_of_run
from erclutch.models.load import load_model
from erclutch.models.model import Model
from erclutch.models.model_file import keeps_digest, require_schema
from erclutch.models.model_titles import id_of, titles_of
from erclutch.runs.run_shape import (
    FINAL,
    FINAL_FILE,
    RUN_SCHEMA,
    file_name,
    reading_of,
    require_shape,
)
from erclutch.signals.percent import percent
from erclutch.signals.shown import Shown, one_line, presenter

if TYPE_CHECKING:
    from erclutch.fit.solver.outcome import FitOutcome

_SHORTEST_NAME = 3  # letters of a name that says something
_NAMED = 5  # runs in a folder that an error names
#: What a guarded file may have; the digest of a longer one would have no end.
_MOST_BYTES = {"table.csv": MOST_BYTES, "predictions.parquet": MOST_OF_ROWS}


@dataclass(frozen=True, repr=False)
class Run(Shown):
    """A run read back.

    Attributes:
        folder: where it lies.
        body: run.json.
    """

    folder: Path
    body: Mapping[str, Any]

    def __repr__(self) -> str:
        chosen = self.entry(self.body["recommended"])
        rmse = chosen["test"]["rmse"][0]
        share = chosen["test"]["share"][0]
        error = f"RMSE {rmse:.4g} {self.body['units']['effort']} on {self.body['test_rows']} rows held out"
        return one_line(
            self,
            self.folder.name,
            f"{len(self.body['ranking'])} models",
            f"{self.standing.word} {chosen['title']}",
            error,
            f"{percent(share, 1)} of the standard deviation",
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Models, best test error first."""
        return tuple(entry["name"] for entry in self.body["ranking"])

    @cached_property
    def titles(self) -> Mapping[str, str]:
        """What each model is called in plain words, by its name."""
        return titles_of(self.names)

    def id_of(self, name: str) -> str:
        """The id of a model in this run: ``m1`` for the first of the ranking."""
        return id_of(self.names.index(name))

    @property
    def reading(self) -> Mapping[str, Any]:
        """How the logs were read, as options of `erclutch fit`; the next logs are read in the same way."""
        return reading_of(self.body)

    @property
    def c_name(self) -> str:
        """Prefix of the C names of an export where none is given: after the log, such as ``damper_model``.

        Several logs have what their names begin with in common: the field of the first is that of none of the others.
        """
        stems = [Path(str(log["name"])).stem for log in self.body["logs"]]
        common = stems[0]
        if len(stems) > 1:
            alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*stems, strict=False))
            # A number may be cut in the middle.
            common = "".join(letters[0] for letters in alike).rstrip("0123456789")
        return named_after(common if len(common) >= _SHORTEST_NAME else stems[0])

    def entry(self, name: str) -> Mapping[str, Any]:
        """What run.json says of a model, which is named by its specification or its id.

        Raises:
            RunError: no such model.
        """
        for place, entry in enumerate(self.body["ranking"]):
            if name in (entry["name"], id_of(place)):
                return entry
        known = ", ".join(f"{id_of(place)} ({name})" for place, name in enumerate(self.names))
        raise RunError(
            f"no model {name!r}", where=str(self.folder), remedy=f"Choose one of {known}"
        )

    def file(self, name: str) -> Path:
        """Path of a file whose digest run.json holds, once it has been checked.

        Raises:
            RunError: the file is missing, cannot be read, or was changed.
        """
        path = self.folder / name
        try:
            digest = file_digest(path, _MOST_BYTES[name])
        except OSError as error:
            raise RunError(
                f"cannot be read: {error.strerror or error}",
                where=str(path),
                remedy="Restore the file, or fit the log again",
            ) from error
        if digest != self.body["files"][name]:
            raise RunError(
                "changed after the run",
                where=str(path),
                remedy="Restore the file, or fit the log again",
            )
        return path

    def report(self) -> Any:
        """The report, to be shown in a notebook; `erclutch report` writes it as a file.

        Raises:
            RunError: a file of the run is missing or was changed.
        """
        return presenter().report(self)

    def model(self, name: str | None = None) -> Model:
        """A model of the run; None gives the recommended one, "final" that one fitted to all rows.

        Raises:
            RunError: no such model, or its file was changed.
        """
        if name == FINAL:
            return self._final()
        entry = self.entry(name or self.recommended)
        path = self.model_file(entry["name"])
        model = load_model(path)
        written = entry["model_digest"], entry.get("model", entry["name"]), entry["dynamics"]
        if (model.to_dict()["digest"], model.name, dict(model.times)) != written:
            raise RunError(
                "this is not the model that the run wrote",
                where=str(path),
                remedy="Fit the log again",
            )
        return model

    def _final(self) -> Model:
        """The recommended model fitted to all rows."""
        if "final" not in self.body:
            problem = "the run keeps no model of all rows"
            raise RunError(problem, where=str(self.folder), remedy="Fit the log again with --final")
        path = self.folder / FINAL_FILE
        kept = self.body["final"]
        model = load_model(path)
        digest = model.to_dict()["digest"]
        if digest != kept["model_digest"] or model.name != kept["name"]:
            raise RunError(
                "this is not the model that the run wrote",
                where=str(path),
                remedy="Fit the log again",
            )
        return model

    def model_file(self, name: str | None = None) -> Path:
        """The file of a model, see `model`; RunError for a model that is not there."""
        entry = self.entry(name or self.recommended)
        return self.folder / "models" / f"{file_name(str(entry['name']))}.json"

    @property
    def recommended(self) -> str:
        """The model that stands for the run where none is named.

        Raises:
            RunError: the run recommends none.
        """
        name = str(self.body["recommended"])
        standing = self.standing
        if standing.why_none:
            remedy = (
                "Turn a sign and fit again"
                if standing.sign_open
                else "Log more of what it has to explain"
            )
            raise RunError(
                f"this run recommends no model: the nearest, {name}, {standing.why_none}",
                where=str(self.folder),
                remedy=f"{remedy}, or name a model all the same: --model {self.id_of(name)}",
            )
        return name

    def recommends(self, name: str) -> bool:
        """Whether this is the model that the run recommends; none is, where it recommends no model."""
        return name == self.body["recommended"] and not self.standing.why_none

    @property
    def standing(self) -> Standing:
        """Whether the model that the training rows chose is recommended, and why not."""
        return standing_of_run(self.body)


def outcome_of(run: Run, name: str | None) -> FitOutcome[Any]:
    """A model of a run as the outcome of its fit; None: the recommended one.

    Raises:
        RunError: as `Run.model`.
    """
    from erclutch.fit.solver.outcome import Estimate, FitOutcome

    model = run.model(name)
    entry = run.entry(name or run.recommended)
    fit: dict[str, Any] = entry["fit"]
    estimates: list[Estimate] = []
    for number in fit["parameters"]:
        # JSON has no infinity: null stands for an end that the data do not give.
        low = -np.inf if number["low"] is None else number["low"]
        high = np.inf if number["high"] is None else number["high"]
        entries: dict[str, Any] = {**number, "low": low, "high": high}
        estimates.append(Estimate(**entries))
    return FitOutcome[Any](
        model=model,
        stop=fit["stop"],
        iterations=fit["iterations"],
        estimates=tuple(estimates),
        paper_form=fit["paper_form"],
        rank=fit["rank"],
        unknowns=fit["unknowns"],
        condition=np.inf if fit["condition"] is None else fit["condition"],
        bandwidth=fit["bandwidth_rows"],
        train_cost=(entry["train"]["mse"][0] or 0.0) * fit["train_rows"],
        train_rows=fit["train_rows"],
        weights=fit["weights"],
    )


def read_run(folder: str | Path) -> Run:
    """Read a run folder.

    Raises:
        RunError: not a run, of another schema, or changed since it was written.
    """
    path = Path(folder) / "run.json"
    if Path(folder).is_file():
        problem = "not a run: run.json lies in the folder of a run, and this is a file"
        raise RunError(problem, where=str(folder), remedy="Give the --out folder of erclutch fit")
    try:
        body = small_json(path)
        # Fails on half a character, which no report can hold.
        json.dumps(body, ensure_ascii=False).encode()
    except (OSError, ValueError, RecursionError) as error:
        what = f"not a run: run.json: {plain_words(error)}"
        remedy = "Give the --out folder of erclutch fit"
        if isinstance(error, FileNotFoundError):
            what = (
                "not a run: it holds no run.json"
                if Path(folder).is_dir()
                else "not a run: there is no such folder"
            )
            within = sorted(str(place.parent) for place in Path(folder).glob("*/run.json"))
            if within:
                more = " ..." if len(within) > _NAMED else ""
                remedy = f"Give one of the runs in it: {', '.join(within[:_NAMED])}{more}"
        raise RunError(what, where=str(folder), remedy=remedy) from error
    if not isinstance(body, dict) or cast(dict[str, Any], body).get("kind") != "erclutch run":
        raise RunError(
            "run.json does not describe a run",
            where=str(folder),
            remedy="Give the folder of erclutch fit",
        )
    body = cast(dict[str, Any], body)
    require_schema(body.get("schema"), RUN_SCHEMA, str(folder))
    if not keeps_digest(body):
        raise RunError(
            "run.json was changed after the run", where=str(folder), remedy="Fit the log again"
        )
    try:
        require_shape(body)
    except ValueError as error:
        raise RunError(
            f"unfit entry: {error}", where=str(path), remedy="Fit the log again"
        ) from error
    return Run(Path(folder), body)
