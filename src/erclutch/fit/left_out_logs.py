"""Errors on a log as if no log with its motion had been there when the model was fitted (jackknife over logs).

Rows that are left out of a least-squares fit move its parameters, to first order, by (J'J - K'K)^-1 K'e, where K are
their rows of the Jacobian J and e their errors. No model is fitted again (MacKinnon, Nielsen and Webb 2022,
doi 10.48550/arXiv.2205.03288). A band for new logs needs such errors (Barber, Candes, Ramdas and Tibshirani 2021,
doi 10.1214/20-AOS1965).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from erclutch.fit.log_groups import ALIKE, groups_of, motion_of
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array

#: Logs from which on there is something to learn from leaving some of them out.
_FEWEST = 2
#: Share of the rows that is left at least where logs are left out; of two logs one always goes, so it is less there.
_LEFT = 0.5
_LEFT_OF_TWO = 0.2
#: Directions in which the other logs say less than this share stay where they are.
_UNSAID = 1e-4


def unseen_errors(
    data: Dataset,
    slopes: Callable[[slice], Array],
    error: Array,
) -> Array | None:
    """Measured less estimated effort of each log by a fit without the logs of its motion, shape (n,).

    Args:
        data: the rows of the fit.
        slopes: derivatives of the effort of some rows by the parameters, shape (rows, p).
        error: measured less estimated effort, shape (n,).

    Returns:
        None where there is a single log, or two logs at a field each: neither says what its motion does at the other
        field. A log keeps its errors where too few rows are left without it: less than half
        of all, or a fifth where there are two logs.
    """
    logs = [slice(start, stop) for start, stop in data.source_rows if stop > start]
    if len(logs) < _FEWEST:
        return None
    if len(logs) == 2 and len(set(groups_of(data).field)) == 2:
        return None
    products: list[Array] = []  # of each log, [J e]'[J e]
    for log in logs:
        beside = np.column_stack([slopes(log), error[log]])
        products.append(beside.T @ beside)
    grams = np.array(products)
    whole = grams.sum(axis=0)
    if not np.isfinite(whole).all():
        return None
    scale = np.sqrt(np.diag(whole)[:-1])
    scale[scale == 0.0] = 1.0
    unseen = error.copy()
    motions = np.array([motion_of(data, log) for log in logs])
    rows = np.array([log.stop - log.start for log in logs])
    least = (_LEFT_OF_TWO if len(logs) == 2 else _LEFT) * rows.sum()
    for number, log in enumerate(logs):
        # The logs of its motion are left out, else the log alone, else none.
        out = np.all(np.abs(motions - motions[number]) < np.log(ALIKE), axis=1)
        if rows[~out].sum() < least:
            out = np.arange(len(logs)) == number
        if rows[~out].sum() < least:
            continue
        gone = grams[out].sum(axis=0)
        kept = (whole - gone)[:-1, :-1]  # J'J - K'K
        left = kept / np.outer(scale, scale) + _UNSAID * np.eye(scale.size)
        pull = gone[:-1, -1] / scale  # K'e
        unseen[log] += slopes(log) @ (np.linalg.solve(left, pull) / scale)
    return unseen
