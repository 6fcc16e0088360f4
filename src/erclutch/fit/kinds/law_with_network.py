"""Laws with a network on their residual as candidates of a comparison: those asked for, and on the law with memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.fit.candidate import Candidate, Fitted, Grown, Kind, asked
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import LawCandidate, structures_of
from erclutch.fit.kinds.network_alone import fnns_with, network_for, remembering_law
from erclutch.fit.laws.fit_law import refit_near
from erclutch.fit.networks.fit_residual import fit_residual
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.model import full_name
from erclutch.models.residual_model import ResidualStructure, parts_of
from erclutch.registry import Plugin
from erclutch.signals.array import Mask


@dataclass(frozen=True)
class LawWithNetworkCandidate(Candidate):
    """A law with a network on its residual.

    Attributes:
        structure: what is fitted.
        seed: of the network's starts.
    """

    structure: ResidualStructure
    seed: int

    @property
    def name(self) -> str:
        """Identifier of the model."""
        return full_name(self.structure.specification, self.structure.dynamics)

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """The law and the stages of other packages."""
        return self.structure.law.plugins

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        """A law that is fitted already is not fitted again; see `Candidate.fit`."""
        laws = {
            f.candidate.structure: f.outcome
            for f in fitted
            if isinstance(f.candidate, LawCandidate)
        }
        law = laws.get(self.structure.law)
        return fit_residual(
            train,
            self.structure,
            seed=self.seed,
            workers=workers,
            law=law,
        )

    def refit(
        self,
        train: Dataset,
        kept: Mask,
        outcome: AnyOutcome,
        fitted: Sequence[Fitted],
    ) -> AnyOutcome:
        """The share of the network that was kept stays; see `Candidate.refit`."""
        structure: ResidualStructure = outcome.model.structure
        laws = [f.outcome for f in fitted if f.outcome.model.structure == structure.law]
        if laws:
            law = laws[0]
        else:
            law = refit_near(train, outcome.model.law, kept, without=outcome.without)
        return fit_residual(
            train,
            structure,
            seed=self.seed,
            law=law,
            share=_share_of(outcome),
            kept=kept,
        )

    def fit_again(self, data: Dataset, outcome: AnyOutcome) -> AnyOutcome:
        """The law is that of all rows, with intervals, which `refit` leaves out; see `Candidate.fit_again`."""
        law = LawCandidate(self.structure.law).fit_again(data, outcome)
        return fit_residual(
            data, outcome.model.structure, seed=self.seed, law=law, share=_share_of(outcome)
        )


def _share_of(outcome: AnyOutcome) -> float:
    """The share of the network that a fit kept, from 0 to 1."""
    return float(outcome.model.correction.network.about["share"])


class LawsWithNetwork(Kind):
    """A law, and a bounded network on what it misses."""

    place = 1
    side_by_side = False
    work = (0.3, 1.5)  # few ask for a pair, the law with memory gets one
    words = 2

    def means(self, model: str) -> bool:
        """See `Kind.means`."""
        return parts_of(model) is not None

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[LawWithNetworkCandidate]:
        """The pairs that are asked for, memoryless ones first."""
        return [
            LawWithNetworkCandidate(pair, settings.seed) for pair in residuals_for(train, settings)
        ]

    def grown(self, settings: Settings, train: Dataset, fitted: Sequence[Fitted]) -> Grown:
        """Each FNN that is asked for, on what the law with memory misses."""
        law = remembering_law(settings, fitted)
        if law is None:
            return Grown()
        pairs = [
            ResidualStructure(law, network) for network in fnns_with(law.dynamics, settings, train)
        ]
        known = {
            f.candidate.structure
            for f in fitted
            if isinstance(f.candidate, LawWithNetworkCandidate)
        }
        return Grown(
            [LawWithNetworkCandidate(pair, settings.seed) for pair in pairs if pair not in known]
        )


KIND = LawsWithNetwork()


def residuals_for(data: Dataset, settings: Settings) -> list[ResidualStructure]:
    """The laws with a network that are asked for, memoryless ones first.

    Raises:
        SettingError: a law or a network that cannot be.
    """
    pairs: dict[ResidualStructure, None] = {}
    for name, stages in asked(settings, data, KIND):
        law_name, network_name = name.split("+")
        for law in structures_of(data, settings, [(law_name, stages)]):
            network = network_for(data, settings, network_name, law.dynamics)
            pairs[ResidualStructure(law, network)] = None
    return list(pairs)
