"""Logs as ARFF, in which Weka and collections of data sets keep tables: a numeric attribute is a column.

The name of an attribute may hold a unit in brackets: ``@attribute 'F [N]' numeric``.
"""

from __future__ import annotations

import io

import numpy as np
from scipy.io import arff

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.table import Table

_REMEDY = "Write @relation, @attribute and @data, and the same number of values in each row"


def _claims(head: bytes) -> bool:
    # A file begins with comments, or with the name of its relation.
    lines = (line.strip().lower() for line in head.splitlines())
    return next((line for line in lines if line and not line.startswith(b"%")), b"").startswith(
        b"@relation"
    )


def _read(source: LogSource) -> Table:
    try:
        rows, attributes = arff.loadarff(io.StringIO(source.data.decode("utf-8")))
    except (ValueError, IndexError, StopIteration, NotImplementedError, arff.ArffError) as error:
        raise LogError(
            f"the file is no table of ARFF ({error})", remedy=_REMEDY, where=source.name
        ) from error

    labels: list[str] = []
    values: list[
        np.ndarray
    ] = []  # of each label, shape (rows,); NaN where the file has a question mark
    left: list[str] = []
    for label in attributes.names():
        kind, _ = attributes[label]
        if kind == "numeric":
            labels.append(label)
            values.append(np.asarray(rows[label], np.float64))
        else:
            left.append(f"attribute {label} is {kind}: left out")

    names, units, renamed = name_columns(labels)
    return Table(
        source.name,
        columns=dict(zip(names, values, strict=True)),
        units=dict(zip(names, units, strict=True)),
        digest=source.digest,
        notes=(*left, *renamed),
    )


READER = LogReader((".arff",), _claims, _read, tells_damage="not seen: the format has no checksums")
