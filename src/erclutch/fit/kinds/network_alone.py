"""Networks as candidates of a comparison: those asked for, and each with the memory that the laws' fits found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from erclutch.fit.candidate import Candidate, Fitted, Grown, Kind, asked
from erclutch.fit.fit_settings import AUTO, Settings
from erclutch.fit.kinds.law_alone import laws_among, usual_terms
from erclutch.fit.laws.fit_law import fit_structure, refit_near
from erclutch.fit.laws.terms_told import with_terms_told
from erclutch.fit.networks.fit_network import fit_network, supports
from erclutch.fit.past_samples import past_rows
from erclutch.fit.solver.outcome import AnyOutcome, FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import at_one_field, law_from_name
from erclutch.models.laws.yield_stress import SATURATING, TANH
from erclutch.models.model import full_name
from erclutch.models.networks import PAPER_NETWORKS, NetworkStructure, is_network, network_from_name
from erclutch.models.networks.network_inputs import stage_numbers_in_user_units
from erclutch.models.stages import NONE, needs_time, outside_stages, slip_stages, stages_of
from erclutch.models.structure import Structure
from erclutch.registry import Plugin
from erclutch.signals.array import Mask


@dataclass(frozen=True)
class NetworkCandidate(Candidate):
    """A network.

    Attributes:
        structure: what is fitted.
        seed: of its starts.
        polish: whether it gets a last round over all rows.
    """

    structure: NetworkStructure
    seed: int
    polish: bool

    @property
    def name(self) -> str:
        """Identifier of the model."""
        return full_name(self.structure.specification, self.structure.dynamics)

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """The stages of other packages."""
        return outside_stages(self.structure.dynamics)

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        """Behind stages it has their constants from the best law; see `Candidate.fit`."""
        laws = laws_among(fitted)
        constants = constants_for(train, self.structure, laws)
        outcome = fit_network(
            train,
            self.structure,
            seed=self.seed,
            polish=self.polish,
            workers=workers,
            dynamics=constants,
        )
        model = replace(outcome.model, beyond=law_beyond(train, laws))
        return replace(outcome, model=model)

    def refit(
        self,
        train: Dataset,
        kept: Mask,
        outcome: AnyOutcome,
        fitted: Sequence[Fitted],
    ) -> AnyOutcome:
        """See `Candidate.refit`."""
        constants = outcome.model.dynamics
        again = fit_network(
            train,
            self.structure,
            seed=self.seed,
            polish=self.polish,
            dynamics=constants,
            kept=kept,
        )
        law = outcome.model.beyond
        if law is None:
            return again
        beyond = refit_near(train, law, kept).model
        return replace(again, model=replace(again.model, beyond=beyond))


class Networks(Kind):
    """Networks alone, with no law inside."""

    place = 2
    side_by_side = False
    work = (0.3, 0.3)

    def means(self, model: str) -> bool:
        """See `Kind.means`."""
        return is_network(model)

    def members(self, of: str) -> tuple[str, ...]:
        """One of each kind; those of table II."""
        return ("rbfn-10", "fnn-16") if of == "all" else PAPER_NETWORKS

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[NetworkCandidate]:
        """The networks that are asked for, memoryless ones first."""
        return [_candidate(network, settings) for network in networks_for(train, settings)]

    def grown(self, settings: Settings, train: Dataset, fitted: Sequence[Fitted]) -> Grown:
        """Each FNN that is asked for once more, with the memory of the richest law."""
        law = remembering_law(settings, fitted)
        if law is None:
            return Grown()
        stages = remembered(law.dynamics)
        known = networks_for(train, settings)  # a memory without a state leaves a network as it is
        further = [
            network for network in fnns_with(stages, settings, train) if network not in known
        ]
        return Grown([_candidate(network, settings) for network in further])


KIND = Networks()


def _candidate(network: NetworkStructure, settings: Settings) -> NetworkCandidate:
    return NetworkCandidate(network, settings.seed, settings.polish)


def networks_for(data: Dataset, settings: Settings) -> list[NetworkStructure]:
    """The networks that are asked for, memoryless ones first.

    Raises:
        SettingError: a network that cannot be.
    """
    networks: dict[NetworkStructure, None] = {}
    for name, stages in asked(settings, data, KIND):
        # Stages that a network has not leave the same network twice.
        networks[network_for(data, settings, name, remembered(stages))] = None
    return list(networks)


def network_for(
    data: Dataset,
    settings: Settings,
    name: str,
    stages: str,
) -> NetworkStructure:
    """A network by name, with the inputs that the rows and the settings give it."""
    return network_from_name(
        name,
        data.device,
        dynamics=stages,
        past=past_rows(settings.past, data),
        extras=tuple(data.extras),
        field=not data.one_field,  # a field that never changes is no input
    )


def remembering_law(settings: Settings, fitted: Sequence[Fitted]) -> Structure | None:
    """The law with memory that the search for memory ended with; None where it found none, or did not look."""
    laws = laws_among(fitted)
    if settings.lag != AUTO or not laws:
        return None
    richest = laws[-1].model.structure
    return richest if slip_stages(richest.dynamics) else None


def fnns_with(stages: str, settings: Settings, train: Dataset) -> list[NetworkStructure]:
    """Each FNN that is asked for, with these stages, as far as there are rows for its weights."""
    fnns = [network for network in networks_for(train, settings) if network.kind == "fnn"]
    staged = dict.fromkeys(replace(network, dynamics=stages) for network in fnns)
    return [network for network in staged if supports(train.rows, network)]


def remembered(stages: str) -> str:
    """The stages that a network has of a law's: those that remember, on the command and on the slip.

    A network is trained on the effort as it is, so no stage can stand behind it; a stage without a state would give it
    an input that the slip says already.
    """
    kept: list[str] = []
    for stage in stages_of(stages):
        on_slip = stage.place == "slip" and needs_time(stage)
        if stage.place == "command" or on_slip:
            kept.append(stage.name)
    return "+".join(kept) or NONE


def constants_for(
    train: Dataset,
    network: NetworkStructure,
    laws: Sequence[FitOutcome[TorqueModel]],
) -> dict[str, float]:
    """Numbers of the stages, of the law with the lowest cost among those with the same stages but for the effort's."""
    if network.dynamics == NONE:
        return {}
    same = [law for law in laws if remembered(law.model.structure.dynamics) == network.dynamics]
    if same:
        # A network's memory has a power of the field: a law with such a form knows its exponent.
        saturating = (TANH, SATURATING)
        powers = [law for law in same if law.model.structure.law.yield_form not in saturating]
        law = min(powers or same, key=lambda law: law.train_cost).model
    else:  # no law that was asked for has these stages
        law = _fitted(train, "bingham", network.dynamics).model
    return stage_numbers_in_user_units(law, network.dynamics)


def law_beyond(train: Dataset, laws: Sequence[FitOutcome[TorqueModel]]) -> TorqueModel:
    """The law by which a network changes far outside its training rows.

    Bingham's law where it was fitted, else the memoryless fitted law of a yield effort with the fewest numbers: few
    numbers are told by the rows that are there. Where no such law was fitted, Bingham's is.
    """
    bingham = "bingham"
    if train.one_field:
        bingham = at_one_field(bingham, train.device) or bingham
    known: list[FitOutcome[TorqueModel]] = []
    for law in laws:
        structure = law.model.structure
        if structure.law.yield_form is not None and not structure.remembers:
            known.append(law)
    if known:
        named = [law for law in known if law.model.structure.specification == bingham]
        taken = min(named or known, key=lambda law: (law.parameters, law.train_cost))
        return taken.model
    return with_terms_told(train, _fitted(train, bingham, NONE)).model


def _fitted(train: Dataset, specification: str, dynamics: str) -> FitOutcome[TorqueModel]:
    """A law with the usual terms, fitted to the training rows."""
    law = law_from_name(specification, train.device)
    structure = Structure(train.device, specification, law, dynamics, *usual_terms(train))
    return fit_structure(train, structure, intervals=False)
