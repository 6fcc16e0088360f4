"""An FNN is fitted from some starts, with spare neurons and exchanged neurons, coarse to fine on compressed rows.

Starts run on the coarsest grid with some neurons to spare, which go one by one (`pruning`); neurons that are hardly
missed then make room for others (`exchange`). The worse starts are dropped on the way, and the one that is best on the
finest grid goes on there, and on all rows if asked. Deterministic for a seed, whatever the number of threads: a start's
arithmetic does not depend on its neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from erclutch.fit.networks.backprop import WeightedRows
from erclutch.fit.networks.exchange import exchanged
from erclutch.fit.networks.first_weights import Slips, first_weights, with_best_output
from erclutch.fit.networks.geodesic import Trained, levenberg_marquardt
from erclutch.fit.networks.pruning import AFTER_LOSS, smaller, without_least
from erclutch.fit.solver.centroids import Centroids, Gridded, centroids_of

_HARDER = 3.0  # damping on the next level of compression over that on the last
_SMALL = 8  # hidden neurons, up to which a network is small
_FEW = 3  # inputs
#: Share of the cost that the square of a weight costs; docs/decisions/0025-weights-that-decay.md.
_DECAY = 7e-4
_MANY = 50_000  # rows above which the last steps on all of them are in single precision too


@dataclass(frozen=True)
class Training:
    """How a network is trained, as far as a user or a comparison decides.

    Attributes:
        seed: of the starts; the same seed gives the same weights, whatever the number of workers.
        polish: whether the last steps are on all rows instead of a fine grid's centroids.
        workers: starts side by side.
        judges: whether the network only says how well such networks estimate rows that they have not seen.
    """

    seed: int = 0
    polish: bool = False
    workers: int = 1
    judges: bool = False


@dataclass(frozen=True)
class Round:
    """One round of a schedule.

    Attributes:
        level: of compression.
        steps: most steps of each start.
        kept: starts that go on, the best on this round's rows.
        spare: neurons of the last hidden layer beyond the final number that are left after the round.
        tries: neurons, the least missed first, that an exchange tries to replace.
        exchanges: most exchanges of each start.
    """

    level: int
    steps: int
    kept: int
    spare: int = 0
    tries: int = 0
    exchanges: int = 0


@dataclass(frozen=True)
class Schedule:
    """How much work a fit does.

    Attributes:
        starts: number of random starts.
        rounds: what they go through.
        spare: neurons of the last hidden layer beyond the final number that the starts have.
        between: most steps after a neuron has gone.
        polish: most steps on all rows; 0 for none.
        decay: what the square of a weight costs, see `levenberg_marquardt`.
    """

    starts: int
    rounds: tuple[Round, ...]
    spare: int = 0
    between: int = 15
    polish: int = 0
    decay: float = 0.0

    @property
    def levels(self) -> set[int]:
        """Levels of compression that its rounds need."""
        return {round.level for round in self.rounds}


def schedule_for(
    hidden: Sequence[int],
    inputs: int,
    polish: bool = False,
    judges: bool = False,
) -> Schedule:
    """Small networks have more bad minima and cost less a start, so they get more starts and more exchanges.

    With many inputs the coarsest grid has too few cells along each to prune on, and exchanges bring nothing. The rows
    leave much of the space of many inputs empty, and there a start would decide: weights that the rows do not ask for
    decay. One start of such a network is then nearly as good as four, and enough where it only judges.

    Args:
        hidden: neurons of each hidden layer.
        inputs: number of inputs.
        polish: whether the last steps are on all rows.
        judges: whether the network only says how well such networks estimate rows that they have not seen.
    """
    small = sum(hidden) <= _SMALL
    spare = 3 if small else max(3, round(0.375 * hidden[-1]))
    few = min(spare, 2)
    if inputs > _FEW:
        starts = 16 if polish else 4
        kept = 6 if polish else 2
        if judges:
            # No neuron goes on the finest grid, where a step costs most.
            rounds = (
                Round(level=0, steps=30, kept=1, spare=spare),
                Round(level=1, steps=0, kept=1),
                Round(level=2, steps=10, kept=1),
            )
            return Schedule(1, rounds, spare, between=15, decay=_DECAY)
        rounds = (
            Round(level=0, steps=30, kept=starts, spare=spare),
            Round(level=1, steps=0, kept=kept, spare=few),
            Round(level=1, steps=10, kept=2),
            Round(level=2, steps=0, kept=1),
            Round(level=2, steps=60 if polish else 30, kept=1),
        )
        return Schedule(
            starts,
            rounds,
            spare,
            between=15,
            polish=10 if polish else 0,
            decay=_DECAY,
        )

    if small:
        starts = 16 if polish else 10
        rounds = (
            Round(level=0, steps=15, kept=starts, spare=spare),
            Round(level=0, steps=8, kept=4, tries=2, exchanges=6),
        )
        if polish:
            rounds += (
                Round(level=1, steps=20, kept=3),
                Round(level=2, steps=30, kept=1),
            )
            return Schedule(starts, rounds, spare, between=6, polish=10)
        rounds += (
            Round(level=1, steps=10, kept=2),
            Round(level=2, steps=0, kept=1),
            Round(level=2, steps=20, kept=1),
        )
        return Schedule(starts, rounds, spare, between=6)

    if polish:
        rounds = (
            Round(level=0, steps=30, kept=4, spare=spare),
            Round(level=0, steps=0, kept=4, spare=few),
            Round(level=1, steps=10, kept=4),
            Round(level=1, steps=0, kept=2, tries=4, exchanges=3),
            Round(level=1, steps=0, kept=1, tries=4, exchanges=6),
            Round(level=2, steps=60, kept=1),
        )
        return Schedule(
            starts=8,
            rounds=rounds,
            spare=spare,
            polish=6,
        )
    rounds = (
        Round(level=0, steps=30, kept=3, spare=spare),
        Round(level=0, steps=0, kept=2, spare=few),
        Round(level=1, steps=10, kept=1),
        Round(level=1, steps=0, kept=1, tries=2, exchanges=2),
        Round(level=2, steps=12, kept=1),
    )
    return Schedule(starts=8, rounds=rounds, spare=spare)


def train(
    rows: Gridded,
    hidden: Sequence[int],
    seed: int,
    schedule: Schedule,
    workers: int = 1,
    slips: Slips | None = None,
) -> Trained:
    """Train a network on normalised rows.

    Args:
        rows: inputs within -1 and 1, effort of order one, and what the grids are over.
        hidden: neurons of each hidden layer.
        seed: of the starts.
        schedule: how much work to do.
        workers: starts side by side; changes no figure.
        slips: along which starts have transitions; None for starts that know nothing.
    """
    cells = centroids_of(rows, schedule.levels)
    level = schedule.rounds[0].level
    inputs = cells[level].x.shape[0]

    # The starts, on the cells of the first round.
    sizes = (inputs, *hidden[:-1], hidden[-1] + schedule.spare, 1)
    coarse = _rows(cells[level], sizes)
    networks: list[Trained] = []
    for number in range(schedule.starts):
        rng = np.random.default_rng([seed, number])
        theta = with_best_output(coarse, first_weights(rng, sizes, slips))
        networks.append(Trained(theta, np.inf, 0, "iterations"))

    steps = 0
    for number, part in enumerate(schedule.rounds):
        neurons = hidden[-1] + part.spare
        harder = 1.0 if part.level == level else _HARDER
        shared = _SharedRound(
            part=part,
            cells=cells[part.level],
            sizes=sizes,
            neurons=neurons,
            between=schedule.between,
            harder=harder,
            slips=slips,
            decay=schedule.decay,
        )
        ranks = range(len(networks))
        random = [np.random.default_rng([seed, number, rank]) for rank in ranks]
        side_by_side = max(1, min(workers, len(networks)))
        with ThreadPoolExecutor(max_workers=side_by_side) as pool:
            trained = list(pool.map(shared.through, networks, random))
        trained.sort(key=lambda network: network.cost)
        steps += sum(network.steps for network in trained)
        networks = trained[: part.kept]
        sizes = (*sizes[:-2], neurons, 1)
        level = part.level
    best = replace(networks[0], steps=steps)
    if not schedule.polish:
        return best

    # The last steps, on all rows at once.
    x, y, _ = rows
    every_row = WeightedRows(x, y, None, sizes, single=y.size > _MANY)
    damping = _HARDER * best.damping
    polished = levenberg_marquardt(every_row, best.theta, schedule.polish, damping, schedule.decay)
    return replace(polished, steps=best.steps + polished.steps)


@dataclass(frozen=True)
class _SharedRound:
    """What all starts of a round have in common.

    Attributes:
        part: the round.
        cells: its rows.
        sizes: layers at its beginning.
        neurons: of the last hidden layer at its end.
        between: most steps after a neuron has gone.
        harder: damping over that of the last round.
        slips: see `train`.
        decay: of the schedule.
    """

    part: Round
    cells: Centroids
    sizes: tuple[int, ...]
    neurons: int
    between: int
    harder: float
    slips: Slips | None
    decay: float

    def through(self, start: Trained, rng: np.random.Generator) -> Trained:
        """A start after the round: neurons go one by one, steps follow, then exchanges."""
        rows = _rows(self.cells, self.sizes)
        network = start
        steps = 0
        while rows.sizes[-2] > self.neurons:
            theta = without_least(rows, network.theta)
            rows = _rows(self.cells, smaller(rows.sizes))
            best = with_best_output(rows, theta)
            network = levenberg_marquardt(rows, best, self.between, AFTER_LOSS, self.decay)
            steps += network.steps
        damping = network.damping * self.harder
        network = levenberg_marquardt(rows, network.theta, self.part.steps, damping, self.decay)
        steps += network.steps
        if self.part.exchanges:
            network = exchanged(
                partial(_rows, self.cells),
                rows.sizes,
                network,
                rng,
                self.slips,
                tries=self.part.tries,
                most=self.part.exchanges,
            )
            steps += network.steps
        return replace(network, steps=steps)


def _rows(cells: Centroids, sizes: Sequence[int]) -> WeightedRows:
    """Centroids as rows of a network with these layers, in single precision."""
    return WeightedRows(cells.x, cells.y, cells.count, sizes, single=True)
