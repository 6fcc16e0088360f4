"""What the scoring of every row found is kept in the folder of the run; an interrupted scoring goes on from there.

::

    every_row/plan.json      what is scored, in which tasks
    every_row/part-N.npz     sums of the tasks that are done
    every_row.json           the figures; the folder then goes
"""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import RunError
from erclutch.files import unwritable, whole_file
from erclutch.files.given_files import plain_words, small_json
from erclutch.logs.any_size import Cut
from erclutch.models.model_file import digest_of, keeps_digest
from erclutch.runs.every_row import KIND, SCHEMA, EveryRow, PartSums, require_same_bytes
from erclutch.runs.run_folder import Run
from erclutch.runs.scoring_plan import HeldOut, LogToScore, ScoringPlan
from erclutch.runs.written_run import write_json

FILE, FOLDER = "every_row.json", "every_row"
_ANEW = "Fit the logs again with --force"


class KeptParts:
    """The sums of parts in a run's folder.

    Raises:
        RunError: the folder cannot be written, or holds what belongs to another plan.
    """

    def __init__(self, run_folder: Path, plan: ScoringPlan) -> None:
        self._folder = folder = run_folder / FOLDER
        # Lists for tuples, as they come back from the file.
        of_plan = json.loads(json.dumps(asdict(plan)))
        body = {"kind": f"{KIND}: plan", "schema": SCHEMA, **of_plan}
        self._digest = digest_of(body)
        if (folder / "plan.json").is_file():
            if _plan_body(folder) != body:
                raise RunError(
                    "what was scored belongs to another plan", where=str(folder), remedy=_ANEW
                )
            return
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise self._unwritable(folder, error) from error
        with whole_file(folder / "plan.json", self._unwritable) as unfinished:
            write_json(unfinished, {**body, "digest": self._digest})

    def keep(self, number: int, sums: PartSums) -> None:
        """Keep the sums of a part."""
        arrays = {name: getattr(sums, name) for name in PartSums.__dataclass_fields__}
        part = self._folder / f"part-{number}.npz"
        with whole_file(part, self._unwritable) as unfinished, unfinished.open("wb") as file:
            np.savez(file, of=self._mark(number), **arrays)

    def sums(self, parts: int, models: int) -> dict[int, PartSums]:
        """The sums that are kept, by the part's number below ``parts``.

        Raises:
            RunError: a file of them is damaged, or of other models.
        """
        sums: dict[int, PartSums] = {}
        for number in range(parts):
            path = self._folder / f"part-{number}.npz"
            if not path.is_file():
                continue
            try:
                with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                    is_its_own = arrays["of"].tolist() == self._mark(number).tolist()
                    of_part = PartSums(
                        **{name: arrays[name] for name in PartSums.__dataclass_fields__}
                    )
            except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
                raise RunError(
                    f"cannot be read: {error}", where=str(path), remedy="Delete this file"
                ) from error
            if not is_its_own:
                raise RunError(
                    "has the sums of other rows", where=str(path), remedy="Delete this file"
                )
            if len(of_part.square) != models:
                raise RunError(
                    "has the sums of other models", where=str(path), remedy="Delete this file"
                )
            sums[number] = of_part
        return sums

    def _mark(self, number: int) -> Any:
        """What tells the file of a part from those of other parts and plans."""
        return np.array(f"{self._digest} {number}")

    def _unwritable(self, path: Path, error: OSError) -> RunError:
        problem = f"what is scored cannot be kept: {error.strerror or error}"
        return RunError(
            problem, where=str(self._folder), remedy="Make room there, then give --resume"
        )


def _plan_body(folder: Path) -> dict[str, Any]:
    body = _with_its_digest(folder / "plan.json", "was changed")
    return {key: value for key, value in body.items() if key != "digest"}


def _with_its_digest(path: Path, changed: str) -> dict[str, Any]:
    """What a file holds whose digest it keeps; ``changed`` says in an error that it does not.

    Raises:
        RunError: the file cannot be read, or was changed.
    """
    try:
        body = small_json(path)
    except (OSError, ValueError) as error:
        raise RunError(
            f"cannot be read: {plain_words(error)}", where=str(path), remedy=_ANEW
        ) from error
    if not isinstance(body, dict) or not keeps_digest(cast(dict[str, Any], body)):
        raise RunError(changed, where=str(path), remedy=_ANEW)
    return cast(dict[str, Any], body)


def unfinished_plan(run: Run) -> ScoringPlan:
    """The plan of a run whose scoring was interrupted.

    Raises:
        RunError: the run has none, or a log is not there or was changed.
    """
    if (run.folder / FILE).is_file():
        raise RunError(
            "every row is scored already", where=str(run.folder), remedy="Leave --resume out"
        )
    if not (run.folder / FOLDER / "plan.json").is_file():
        problem = "no scoring of every row was begun here"
        raise RunError(
            problem, where=str(run.folder), remedy="Leave --resume out; --force fits the logs again"
        )
    body = _plan_body(run.folder / FOLDER)
    if body["run"] != run.body["digest"]:
        raise RunError(
            "the plan belongs to another run", where=str(run.folder / FOLDER), remedy=_ANEW
        )
    logs: list[LogToScore] = []
    for kept in body["logs"]:
        turns = kept["held_out"]["turns"]
        held = kept["held_out"]["held"]
        log = LogToScore(
            path=kept["path"],
            number=kept["number"],
            name=kept["name"],
            digest=kept["digest"],
            rows=kept["rows"],
            period=kept["period"],
            cuts=tuple(Cut(**cut) for cut in kept["cuts"]),
            held_out=HeldOut(tuple(turns), tuple(held)),
        )
        logs.append(log)
        if log.number is not None:
            continue  # it is looked at when it is read
        require_same_bytes(log)
    numbers = {
        key: body[key] for key in ("run", "device", "kept_rows", "bin_rows", "middle", "seed")
    }
    return ScoringPlan(logs=tuple(logs), **numbers)


def write_every_row(folder: Path, figures: EveryRow) -> None:
    """Write the figures to a run's folder, and remove what was kept on the way.

    Raises:
        RunError: the folder cannot be written.
    """
    with whole_file(folder / FILE, partial(unwritable, remedy=_ANEW)) as unfinished:
        write_json(unfinished, figures.to_dict())
    shutil.rmtree(folder / FOLDER, ignore_errors=True)


def read_every_row(run: Run) -> Mapping[str, Any] | None:
    """The figures of every row of a run; None for a run whose rows were all fitted, or not all scored yet.

    Raises:
        RunError: the file was changed, or belongs to another run.
    """
    path = run.folder / FILE
    if not path.is_file():
        return None
    body = _with_its_digest(path, "was changed after the run")
    if body["run"] != run.body["digest"]:
        raise RunError("belongs to another run", where=str(path), remedy=_ANEW)
    return body
