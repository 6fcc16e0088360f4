"""A ZIP archive of text logs: each text is a recording, by its name in the archive.

The first file in it tells such an archive from workbooks, arrays of NumPy and FMUs, which are ZIP archives too. In a
folder such an archive is no log, for the logs that it holds often lie beside it.
"""

from __future__ import annotations

import io
import zlib
from dataclasses import replace
from pathlib import PurePosixPath
from zipfile import BadZipFile, ZipFile, ZipInfo

from erclutch.errors import LogError, SeveralRecordingsError, listed, placed, printable
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import Budget, take_parts
from erclutch.logs.readers.text import ENDINGS
from erclutch.logs.readers.text_tables import read_tables
from erclutch.logs.table import Table

_MARK = b"PK\x03\x04"
_HEADER = 30  # bytes in front of a part's name
#: What macOS and other systems put beside the files of an archive.
_OF_SYSTEMS = ("__MACOSX", ".")
_ENCRYPTED = 1  # bit of a part's flags
_UNPACK = "Unpack it and give the log in it"


def _holds_texts(head: bytes) -> bool:
    """Whether the first file of an archive is a text by its name; folders may stand in front of it."""
    place = 0
    while head.startswith(_MARK, place) and len(head) >= place + _HEADER:
        name_length = int.from_bytes(head[place + 26 : place + 28], "little")
        extra_length = int.from_bytes(head[place + 28 : place + 30], "little")
        name = head[place + _HEADER : place + _HEADER + name_length].decode("utf-8", "replace")
        if not name.endswith("/"):
            return name.lower().endswith(ENDINGS)
        place += _HEADER + name_length + extra_length
    return False


def _read(source: LogSource) -> Table:
    """The only text of an archive, or the text that is wanted of several.

    Raises:
        LogError: the archive is damaged, encrypted or too large, or the text is no log.
        SeveralRecordingsError: it holds several texts, and none was chosen.
    """
    content = io.BytesIO(source.data)
    take_parts(content, Budget(source.size))
    try:
        with ZipFile(content) as archive:
            texts: dict[str, ZipInfo] = {}
            others: list[str] = []
            for part in archive.infolist():
                folders = PurePosixPath(part.filename).parts
                of_a_system = any(folder.startswith(_OF_SYSTEMS) for folder in folders)
                if part.is_dir() or of_a_system:
                    continue
                name = printable(part.filename)
                if not name.lower().endswith(ENDINGS):
                    others.append(name)
                elif name in texts:
                    # Which of the two a program unpacks, nobody knows.
                    raise LogError(f"the archive holds two files {name}", remedy=_UNPACK)
                else:
                    texts[name] = part
            name, part = found_recordings.choose(
                texts, source.variable, "text", "the archive holds no text"
            )
            if part.flag_bits & _ENCRYPTED:
                raise LogError(f"{name} is encrypted", remedy=_UNPACK)
            data = archive.read(part)
    except (BadZipFile, zlib.error, ValueError, EOFError) as error:
        raise LogError(f"the archive is damaged ({error})", remedy="Copy the file again") from error

    with placed(f"{source.name}, {name}"):
        try:
            table = read_tables(replace(source, data=data, variable=None))
        except SeveralRecordingsError as error:
            # The option that names a recording names a text of the archive here.
            raise LogError(error.problem, remedy=_UNPACK) from error
    among = f", 1 of {len(texts)} texts" if len(texts) > 1 else ""
    notes = [f"recording read from {name} in the archive{among}"]
    if others:
        notes.append(f"left out of the archive, no text: {listed(others)}")
    return replace(table, notes=(*notes, *table.notes))


READER = LogReader(
    suffixes=(),
    claims=_holds_texts,
    read=_read,
    recordings=found_recordings.names_by(_read),
    tells_damage="seen: each file of an archive has a checksum",
)
