"""Text logs are CSV of any dialect, white-space tables, or DAQ exports with a header block, plain or gzipped.

A text may hold several tables (`text_tables`), each of which is read by the steps of `text_table`. A text that is
larger than memory is read in blocks (`text_blocks`).
"""

from __future__ import annotations

from erclutch.logs.log_reader import LogReader, claims_nothing
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.text_blocks import text_extent, text_windows
from erclutch.logs.readers.text_bytes import DAMAGE
from erclutch.logs.readers.text_tables import read_tables

#: Endings of texts.
ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".log")

READER = LogReader(
    # Testing machines write a text cut at tabs as .xls, which Excel opens; a workbook has a mark of its own.
    suffixes=(*ENDINGS, ".xls"),
    claims=claims_nothing,
    read=read_tables,
    windows=text_windows,
    extent=text_extent,
    recordings=found_recordings.names_by(read_tables),
    tells_damage=DAMAGE,
)
