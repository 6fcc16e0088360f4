"""The reader of MCAP files imports its code with the first such file, because the import takes time."""

from __future__ import annotations

from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers.found_recordings import names_by
from erclutch.logs.table import Table


def _read(source: LogSource) -> Table:
    from erclutch.logs.readers.mcap_table import read_mcap

    return read_mcap(source)


_DAMAGE = "seen by checksums, where the writer added them"
READER = LogReader(
    (".mcap",),
    lambda head: head.startswith(b"\x89MCAP0\r\n"),
    _read,
    recordings=names_by(_read),
    tells_damage=_DAMAGE,
)
