"""A law and a bounded network on what the law misses: the law is fitted, then the network to its residual.

How much of the network is kept is decided on training rows that it has not seen: over blocks in time, each predicted by
a network fitted to the others, the share is the one that leaves the smallest residual. A network that has only learned
its rows by heart keeps nothing.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import CheckError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_fnn import Training
from erclutch.fit.networks.fit_network import fit_rows
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import time_folds
from erclutch.models.covered_cells import cells_of
from erclutch.models.law_model import TorqueModel
from erclutch.models.networks import NetworkStructure
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.residual_model import (
    BoundedResidual,
    ResidualModel,
    ResidualStructure,
    residual_inputs,
)
from erclutch.signals.array import Array, Mask

#: Share of the training rows whose residual the limit lets through.
_LET_THROUGH = 0.999
#: Blocks of the training rows on which the network's share is decided.
_BLOCKS = 4
_FEWEST_ROWS = 20  # of a block


def fit_residual(
    data: Dataset,
    structure: ResidualStructure,
    *,
    seed: int = 0,
    workers: int = 1,
    law: FitOutcome[TorqueModel] | None = None,
    share: float | None = None,
    kept: Mask | None = None,
) -> FitOutcome[ResidualModel]:
    """Fit a law, a network to its residual, and the network's limit, share and range.

    Args:
        data: training rows, over which states run.
        structure: law with stages, and network.
        seed: of the network's starts.
        workers: starts of the network side by side.
        law: the fit of the same law to the same rows, where there is one already.
        share: of the network that is kept, where that is decided; None: blocks of these rows decide.
        kept: rows whose effort is known, shape (n,), where the share is decided; None: all.

    Raises:
        CheckError: the law leaves no residual, or the rows do not support the network.
        MappingError: a further input is not in the data.
    """
    law = law or fit_structure(data, structure.law)
    rows: Mask = np.ones(data.rows, np.bool_) if kept is None else kept
    missed = data.effort - law.model.predict(data)
    off = np.abs(missed[rows])
    limit = float(np.quantile(off, _LET_THROUGH))
    if not limit > 0:
        raise CheckError(
            f"{law.model.name} leaves no residual on the training rows for {structure.network.specification}",
            remedy=f"Fit {law.model.name} alone",
            where=data.where,
        )
    inputs = residual_inputs(law.model, structure.network, data.elements, data.clock, data.extras)
    target = _Target(
        data=replace(data, effort=missed),
        structure=structure.network,
        times=law.model.times,
        inputs=inputs,
        limit=limit,
        training=Training(seed, workers=workers),
    )
    network = target.network(rows, judges=not rows.all())
    if share is None:
        # The share, 0 to 1, that leaves least of the residual of blocks that the network has not seen. A block without
        # which the other rows do not support a network counts as a block to which the network adds nothing: its field
        # may be the only other field.
        added = np.zeros(data.rows)  # by networks that have not seen the block of a row
        for block in time_folds(target.data, min(_BLOCKS, data.rows // _FEWEST_ROWS)):
            with contextlib.suppress(CheckError):
                without = target.network(~block, judges=True).model
                bounded = target.bounded(without, inputs[:, ~block])
                added[block] = bounded.of_inputs(inputs[:, block], exactly=False)
        square = float(added @ added)
        share = float(np.clip(missed @ added / square, 0.0, 1.0)) if square > 0 else 0.0
    about = {**network.model.about, "share": f"{share:.6g}"}
    shared = replace(network.model.scaled(share), about=about)
    whole = target.bounded(shared, inputs[:, rows])
    added = whole.of_inputs(inputs, exactly=False)
    left = (missed - added)[rows]
    return FitOutcome(
        model=ResidualModel(law.model, whole),
        stop=network.stop if law.converged else law.stop,
        iterations=law.iterations + network.iterations,
        estimates=law.estimates,
        paper_form=law.paper_form,
        rank=law.rank,
        unknowns=law.unknowns,
        condition=law.condition,
        bandwidth=law.bandwidth,
        train_cost=float(left @ left),
        train_rows=law.train_rows,
        weights=network.weights,
        idle=law.idle,
        without=law.without,
        unseen=None if law.unseen is None else law.unseen - added,
    )


@dataclass(frozen=True)
class _Target:
    """What a network is fitted to.

    Attributes:
        data: training rows, with the law's residual for the effort.
        structure: of the network.
        times: numbers of the law's stages.
        inputs: of the network, shape (inputs, n).
        limit: of what the network adds.
        training: of the network.
    """

    data: Dataset
    structure: NetworkStructure
    times: Mapping[str, float]
    inputs: Array
    limit: float
    training: Training

    def network(self, rows: NDArray[np.bool_], judges: bool) -> FitOutcome[NetworkModel]:
        """A network fitted to some of the rows."""
        pair = self.inputs[:, rows], self.data.effort[rows]
        data = self.data if np.all(rows) else self.data.take(rows)
        training = replace(self.training, judges=judges)
        return fit_rows(data, pair, self.structure, self.times, training)

    def bounded(self, network: NetworkModel, inputs: Array) -> BoundedResidual:
        """A network, limited, where rows with these inputs were."""
        return BoundedResidual(network, self.limit, cells_of(inputs))
