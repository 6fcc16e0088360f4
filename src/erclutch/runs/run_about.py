"""What people say of a run lies beside its figures, in about.json: title, device, author, date, note, tags.

No figure depends on it, so it may be changed after the run, and no digest guards it.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from datetime import date, datetime
from pathlib import Path
from typing import Any, cast

from erclutch.errors import RunError, SettingError
from erclutch.files import unwritable, whole_file
from erclutch.files.given_files import plain_words, small_json

FILE = "about.json"
_LONGEST = 2000  # letters of a text


@dataclass(frozen=True)
class RunAbout:
    """What people say of a run; "" where nothing was said.

    Attributes:
        title: of the report.
        device: which device was measured.
        author: who measured or fitted.
        date: YYYY-MM-DD.
        note: anything.
        tags: words with commas between them.
    """

    title: str = ""
    device: str = ""
    author: str = ""
    date: str = ""
    note: str = ""
    tags: str = ""


def about_with(about: RunAbout, **said: str | None) -> RunAbout:
    """The same with other texts; None leaves a text as it is.

    Raises:
        SettingError: a text is too long or holds signs that no one can see, or the date is none.
    """
    given: dict[str, str] = {}
    for name, words in said.items():
        if words is None:
            continue
        text = " ".join(words.split())
        remedy = f"Give plain text of at most {_LONGEST:,} letters"
        if not text.isprintable():
            raise SettingError(f"{name} holds unprintable signs", remedy=remedy)
        if len(text) > _LONGEST:
            raise SettingError(f"{name} has {len(text):,} letters", remedy=remedy)
        given[name] = text
    if day := given.get("date"):
        try:
            date.fromisoformat(day)
        except ValueError as error:
            raise SettingError(
                f"{day!r:.40} is no date", remedy="Write it as 2026-07-31"
            ) from error
    return replace(about, **given)


def kept_about(run_folder: Path) -> RunAbout:
    """What was said of a run.

    Raises:
        RunError: about.json cannot be understood.
    """
    path = run_folder / FILE
    if not path.is_file():
        return RunAbout()
    try:
        body: Any = small_json(path)
        texts = cast("dict[str, Any]", body)
        if not isinstance(body, dict) or not all(isinstance(text, str) for text in texts.values()):
            raise ValueError("it is no object of texts")
        return about_with(RunAbout(), **texts)
    except (OSError, ValueError, TypeError, SettingError) as error:
        problem = f"cannot be understood: {plain_words(error)}"
        raise RunError(
            problem, where=str(path), remedy="Remove this file and say it again"
        ) from error


def read_about(run_folder: Path) -> RunAbout:
    """What was said of a run; without a date the day on which the run was written.

    Raises:
        RunError: about.json cannot be understood.
    """
    about = kept_about(run_folder)
    written = run_folder / "run.json"
    if about.date or not written.is_file():
        return about
    changed = moment_of(written.stat().st_mtime)
    return about if changed is None else replace(about, date=changed.date().isoformat())


def moment_of(changed: float) -> datetime | None:
    """When a file was changed, where clocks show our time; None where no calendar has that year.

    Args:
        changed: as the file system says, in s.
    """
    try:
        return datetime.fromtimestamp(changed).astimezone()
    except (ValueError, OverflowError, OSError):
        return None


def write_about(run_folder: Path, about: RunAbout) -> None:
    """Keep what was said of a run; nothing said removes the file.

    Raises:
        RunError: the folder cannot be written.
    """
    path = run_folder / FILE
    words = {name: text for name, text in asdict(about).items() if text}
    try:
        if not words:
            path.unlink(missing_ok=True)
            return
        with whole_file(path) as partial:
            partial.write_text(
                json.dumps(words, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
            )
    except OSError as error:
        raise unwritable(path, error) from error
