"""The main job fits every model to one data set, scores it on held-out rows, ranks all, and recommends one."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import CheckError, SettingError, require, shell_word
from erclutch.fit.data_check import ONE_FIELD, SIGN, Finding, check, steady_command
from erclutch.fit.history import history_finding
from erclutch.fit.ladder import grown, helpful
from erclutch.fit.laws.fit_law import FitOutcome, fit_structure
from erclutch.fit.log_zeros import log_differences
from erclutch.fit.networks.fit_network import fit_network, supports
from erclutch.fit.networks.fit_residual import fit_residual
from erclutch.fit.one_field import refuse_field_terms
from erclutch.fit.one_thread import one_thread
from erclutch.fit.past_samples import past_finding, past_rows
from erclutch.fit.prediction_bands import HeldBand, calibrated, judged
from erclutch.fit.scoring import (
    TOLERATED,
    BandedFigure,
    Score,
    excess,
    independent_rows,
    information_criteria,
    recommend,
    score,
)
from erclutch.logs.dataset import Dataset, hold_out, require_dataset, time_folds
from erclutch.models.band import Band
from erclutch.models.law_model import Structure, TorqueModel
from erclutch.models.laws import PAPER, at_one_field, ladder, law_from_name
from erclutch.models.laws.yield_stress import CONSTANT
from erclutch.models.model import full_name
from erclutch.models.networks import PAPER_NETWORKS, NetworkStructure, is_network, network_from_name
from erclutch.models.networks.network_inputs import stage_numbers_in_user_units
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.residual_model import ResidualModel, ResidualStructure, parts_of
from erclutch.models.stages import canonical, remembers, slip_stages, stages_of
from erclutch.signals.array import Array
from erclutch.signals.shown import Shown

AnyOutcome = FitOutcome[TorqueModel] | FitOutcome[NetworkModel] | FitOutcome[ResidualModel]
AUTO = "auto"
#: Names of `Settings.models` that stand for several.
SETS = ("all", "paper")

#: Separate time constants are asked for by the data when they lower the criterion by this much: "very strong" evidence.
_EVIDENCE = 10.0
#: Condition of the Jacobian beyond which single parameters are lost in each other's intervals.
_MEANINGLESS = 1e8
#: Share by which the cost may grow when a term that cannot be told is taken out.
_NO_WORSE = 0.01
#: Unknowns of a law whose lack of rank may come from a term that was added.
_SHORT_LAW = 8
#: Travels after which a state of memory has forgotten where it started, to 5 %.
_FORGOTTEN = 3.0


@dataclass(frozen=True)
class Settings:
    """What a comparison does; together with the log it determines every figure.

    Attributes:
        models: specifications of laws, or one of them; "all" is the ladder, "paper" the laws of the paper's tables.
        lag: "none"; names of stages, such as "lag" (one time constant), "rise-fall" (two) or "dahl" (memory of the
            slip), joined by "+"; "auto": without and with "lag", with "rise-fall" for the best law if the data ask for
            it, and with memory as far as `fit.ladder` finds that the data ask for it. A model may name its own stages:
            "bingham+lag+dahl".
        test: share of each log, its end, that is held out (of each stretch, where a log was taken at one field after
            another); or patterns of the names of logs that are.
        blocks: blocks in time for cross-validation on the training rows, 2 to 50; 0 for none.
        friction: a column of friction at zero field; None: yes for a single device whose slip turns, no for all others
            (the paper's form of the pair).
        offset: a constant effort; None: as for friction.
        seed: of the bootstrap and of the networks' starts.
        past: rows back, or times such as "2ms", whose samples are inputs of networks too.
        polish: whether networks get a last round over all rows.
        workers: models fitted side by side; changes no figure.
    """

    models: tuple[str, ...] = ("all",)
    lag: str = AUTO
    test: float | tuple[str, ...] = 0.3
    blocks: int = 0
    friction: bool | None = None
    offset: bool | None = None
    seed: int = 0
    workers: int = 1
    past: tuple[int | str, ...] = ()
    polish: bool = False

    def __post_init__(self) -> None:
        given: object = self.models
        object.__setattr__(self, "models", (given,) if isinstance(given, str) else tuple(self.models))
        require(0, seed=self.seed)

    def to_dict(self) -> dict[str, Any]:
        """As JSON values, without what changes no figure."""
        values = asdict(self)
        del values["workers"]
        return values


@dataclass(frozen=True, repr=False)
class RankedModel(Shown):
    """One model of a comparison.

    Attributes:
        outcome: the fit on the training rows.
        train, test: figures on the rows it was fitted to and on those held out.
        criteria: AIC and BIC on the training rows.
        folds: RMSE on each block of the cross-validation, each by a fit on the others; empty for none.
        predicted: effort on all rows, shape (n,).
        excess: how much larger the test RMSE is than the best model's, as a share, both on the same blocks.
        sound: whether it converged and the data identify all that it says; only such a model is recommended.
        notes: what to worry about with this model.
        band: how the model's band does on the rows held out; None where it has none.
        by_log: smallest and largest RMSE over the logs with rows held out, and their number; None for one log.
        label: its name here, where two entries are of one model.
    """

    outcome: AnyOutcome
    train: Score
    test: Score
    criteria: dict[str, float]
    folds: tuple[float, ...]
    predicted: Array
    excess: BandedFigure
    sound: bool
    notes: tuple[str, ...]
    band: HeldBand | None = None
    by_log: tuple[float, float, int] | None = None
    label: str = ""

    @property
    def name(self) -> str:
        """The model's name."""
        return self.label or self.outcome.model.name


@dataclass(frozen=True, repr=False)
class Comparison(Shown):
    """Ranked models of one data set.

    Attributes:
        data: all rows.
        test: mask of the rows held out.
        settings: what was asked for.
        findings: what the checks saw.
        entries: best test error first.
        best, recommended: names.
        recalibration: of a kept model to these data: what was done, as JSON values; None: all models are new.
    """

    data: Dataset
    test: NDArray[np.bool_]
    settings: Settings
    findings: tuple[Finding, ...]
    entries: tuple[RankedModel, ...]
    best: str
    recommended: str
    recalibration: Mapping[str, Any] | None = None

    def entry(self, name: str) -> RankedModel:
        """The entry of a model by name.

        Raises:
            SettingError: no such model.
        """
        for entry in self.entries:
            if entry.name == name:
                return entry
        raise SettingError(f"no model {name!r} here", remedy=f"Choose one of {', '.join(e.name for e in self.entries)}")


_NO_LAG = Finding(
    "note",
    "dynamics",
    "the field never changes within a stretch of the training rows, so no lag between command and field can be told",
    "Log with a switching field to identify a lag; models are fitted without one here",
)

#: Called with the number of fits done, the number there are, and what was just done.
FitProgress = Callable[[int, int, str], None]


def compare(data: Dataset, settings: Settings | None = None, progress: FitProgress | None = None) -> Comparison:
    """Fit, score and rank models.

    Args:
        data: the rows.
        settings: what to do; None: all models with the defaults.
        progress: called after each fit.

    Raises:
        CheckError: the data cannot support a fit.
        SettingError: an unknown model, lag or split.
    """
    require_dataset(data)
    settings = settings or Settings()
    report = progress or _silent
    test = hold_out(data, settings.test)
    findings = check(data, test) + past_finding(settings.past, data)
    train = data.take(~test)
    lag = "none" if settings.lag == AUTO and steady_command(train) else settings.lag
    chosen = replace(settings, lag=lag)
    structures = structures_for(data, chosen)
    networks = networks_for(data, chosen)
    residuals = residuals_for(data, chosen)
    if not structures and not networks and not residuals:
        raise SettingError("no model was given", remedy="Give --models all, or names from erclutch laws")
    if lag != settings.lag and not data.one_field:
        findings += (_NO_LAG,)
    laws = [_with_terms_told(train, law) for law in _fit_all(train, structures, settings.workers, report)]
    if lag == AUTO:
        laws += _second_time_constant(train, laws, report)
    if settings.lag == AUTO:
        more, more_findings = _with_memory(train, laws, report)
        laws, findings = laws + more, findings + more_findings
        remembering, corrections = _networks_with_memory(train, networks, laws)
        networks, residuals = networks + remembering, list(dict.fromkeys([*residuals, *corrections]))
    findings = tuple(_with_turned_fit(finding, data, test, chosen, laws) for finding in findings)
    corrected, without_network = _fit_residuals(train, residuals, laws, chosen, report)
    trained, untrained = _fit_networks(train, networks, laws, chosen, report)
    findings += tuple(_left_out(reason) for reason in without_network + untrained)
    outcomes = [*laws, *trained, *corrected]
    if not outcomes:
        raise (without_network + untrained)[0]
    entries = with_bands(data, test, scored(data, train, test, outcomes, settings))
    if any(finding.subject == ONE_FIELD for finding in findings):
        entries = _judged_by_training(entries)
    best, recommended = recommend(
        {e.name: e.test for e in entries},
        {e.name: e.excess for e in entries},
        {e.name: e.outcome.parameters for e in entries},
        {e.name for e in entries if e.sound},
        {e.name: _freedom(e.outcome) for e in entries},
    )
    at = next(i for i, e in enumerate(entries) if e.name == recommended)
    taken = entries[at] = _with_sensor(data, test, entries[at])
    findings += _memory_left(data, taken)
    findings += log_differences(data, taken.predicted)
    return Comparison(data, test, settings, findings, tuple(entries), best, recommended)


def _with_turned_fit(
    finding: Finding,
    data: Dataset,
    test: NDArray[np.bool_],
    settings: Settings,
    laws: Sequence[FitOutcome[TorqueModel]],
) -> Finding:
    """The finding that a sign is wrong, with what a law makes of the log once its effort is turned; others stay.

    No law can follow an effort that opposes the slip, so the ranking of such a log says nothing of what the turned log
    would give. One law is fitted to it, with memory as far as the rows ask for it.
    """
    if finding.subject != SIGN:
        return finding
    turned = replace(data, effort=-data.effort)
    train = turned.take(~test)
    stages = settings.lag if settings.lag != AUTO else "none"
    base = _fit_all(train, _structures(turned, settings, [("bingham", stages)]), 1, _silent)
    outcome = (base + _with_memory(train, base, _silent)[0])[-1] if settings.lag in (AUTO, "none") else base[-1]
    spread = float(np.std(data.effort[test])) or 1.0
    error = float(np.sqrt(np.mean((turned.effort - outcome.model.predict(turned))[test] ** 2)))
    as_it_is = min((law.train_cost / law.train_rows for law in laws), default=np.inf) ** 0.5
    message = (
        f"{finding.message}; with the effort turned, {outcome.model.name} errs by {error / spread:.1%} of the standard "
        f"deviation on the rows held out, while no law of the log as it is comes below "
        f"{as_it_is / float(np.std(data.effort[~test])):.0%} on the training rows"
    )
    return replace(finding, message=message)


def _left_out(reason: CheckError) -> Finding:
    """A model that these rows cannot make: the others are compared without it."""
    return Finding("note", "left out", f"{reason.where} is left out: {reason.problem}", reason.remedy)


def _freedom(outcome: AnyOutcome) -> int:
    """How free a model is of physics beyond its rows; see `recommend`."""
    if not outcome.weights:
        return 0
    return 1 if outcome.model.correction is not None else 2


def _memory_left(data: Dataset, entry: RankedModel) -> tuple[Finding, ...]:
    with one_thread():
        found = history_finding(data, data.effort - entry.predicted, entry.name, entry.outcome.model.structure.dynamics)
    return () if found is None else (found,)


def _silent(done: int, total: int, what: str) -> None:
    """No progress is shown."""


def structures_for(data: Dataset, settings: Settings) -> list[Structure]:
    """What a comparison fits, in the order of the ladder.

    Raises:
        SettingError: an unknown model or lag, or none at all.
    """
    asked = _asked(settings)
    return _structures(
        data, settings, [(name, form) for name, form in asked if not (is_network(name) or parts_of(name))]
    )


def _structures(data: Dataset, settings: Settings, named: Sequence[tuple[str, str]]) -> list[Structure]:
    friction, offset = _extra_terms(data, settings)
    if data.one_field:
        by_name = [name.partition("+")[0] for name in settings.models if name not in SETS]
        refuse_field_terms(data, by_name, settings.lag, settings.friction)
    asked = [(_law_of(name, data), form) for name, form in named]
    laws = {name: law_from_name(name, data.device) for name, _ in asked if name}
    return [
        Structure(data.device, name, laws[name], form, friction and laws[name].yield_form is not CONSTANT, offset)
        for name, form in dict.fromkeys(asked)
        if name
    ]


def _extra_terms(data: Dataset, settings: Settings) -> tuple[bool, bool]:
    """Whether laws get a column of friction at zero field, and a constant effort."""
    alone = data.device == "single"
    # Friction is told from a constant effort where the slip turns.
    friction = alone and not data.one_way if settings.friction is None else settings.friction
    offset = alone if settings.offset is None else settings.offset
    return friction, offset


def residuals_for(data: Dataset, settings: Settings) -> list[ResidualStructure]:
    """The laws with a network on their residual that a comparison fits, memoryless ones first.

    Raises:
        SettingError: a law or a network that cannot be.
    """
    asked = [(parts, form) for name, form in _asked(settings) if (parts := parts_of(name))]
    return list(
        dict.fromkeys(
            ResidualStructure(law, _network_for(data, settings, network, law.dynamics))
            for (name, network), form in asked
            for law in _structures(data, settings, [(name, form)])
        )
    )


def _network_for(data: Dataset, settings: Settings, name: str, form: str) -> NetworkStructure:
    past, extras = past_rows(settings.past, data), tuple(data.extras)
    return network_from_name(name, data.device, dynamics=form, past=past, extras=extras, field=not data.one_field)


def _law_of(name: str, data: Dataset) -> str | None:
    """The canonical specification of a law for these rows; None where it is nothing at one field."""
    full = _full_name(name, data.device)
    return at_one_field(full, data.device) if data.one_field else full


def _asked(settings: Settings) -> list[tuple[str, str]]:
    """Each model that is asked for with its stages: its own, or those of the settings, memoryless ones first."""
    forms = ("none", "lag") if settings.lag == AUTO else (settings.lag,)
    asked = [_name_and_stages(model) for model in _names(settings)]
    pairs = [(name, form) for form in forms for name, own in asked if own is None]
    pairs += [(name, own) for name, own in asked if own is not None]
    return [(name, canonical(form)) for name, form in pairs]


def _name_and_stages(model: str) -> tuple[str, str | None]:
    """The law, the network, or both, of a name such as ``bingham+fnn-16+lag``, and the stages that it names."""
    words = model.replace(" ", "").split("+")
    count = 2 if parts_of(model) else 1
    return "+".join(words[:count]), "+".join(words[count:]) if len(words) > count else None


def _names(settings: Settings) -> list[str]:
    sets: dict[str, tuple[str, ...]] = {"paper": (*PAPER, *PAPER_NETWORKS)}
    if "all" in settings.models:
        sets["all"] = (*ladder(), "rbfn-10", "fnn-16")
    return [name for model in settings.models for name in sets.get(model, (model,))]


def networks_for(data: Dataset, settings: Settings) -> list[NetworkStructure]:
    """The networks that a comparison fits, memoryless ones first.

    Raises:
        SettingError: a network that cannot be.
    """
    return list(
        dict.fromkeys(
            _network_for(data, settings, name, _remembered(form)) for name, form in _asked(settings) if is_network(name)
        )
    )


def _remembered(form: str) -> str:
    """The stages that a network has of a law's: those that remember, on the command and on the slip.

    A network is trained on the effort as it is, so no stage can stand behind it; a stage without a state would give it
    an input that the slip says already.
    """
    kept = [s.name for s in stages_of(form) if s.place == "command" or (s.place == "slip" and remembers(s))]
    return "+".join(kept) or "none"


def _full_name(name: str, device: str) -> str:
    """The canonical specification, so that ``ss`` and ``seo-seo`` are one and files carry one name."""
    law = law_from_name(name, device)
    forms = sorted(name.strip().lower().split("/")[1:], key=lambda form: form == "forward")
    return "/".join([law.name, *dict.fromkeys(forms)])


def _fit_all(
    train: Dataset, structures: Sequence[Structure], workers: int, report: FitProgress
) -> list[FitOutcome[TorqueModel]]:
    """Fits side by side, one BLAS thread each; results in the order of the structures whatever finishes first."""
    with one_thread(), ThreadPoolExecutor(max_workers=max(1, workers)) as pool:
        futures = [pool.submit(fit_structure, train, structure) for structure in structures]
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                report(done, len(futures), future.result().model.name)
        except BaseException:
            pool.shutdown(cancel_futures=True, wait=False)
            raise
        return [future.result() for future in futures]


def _with_terms_told(train: Dataset, law: FitOutcome[TorqueModel]) -> FitOutcome[TorqueModel]:
    """A law without the constant effort or the friction that these rows cannot tell from its other terms.

    Where the slip keeps its sign, say, a constant effort and a yield effort are one column: the sum is known, its parts
    are not. The term that was added to the law goes; a law with fewer terms that says the same stays eligible.
    """
    structure = law.model.structure
    added = {"T_0": replace(structure, offset=False), "T_f": replace(structure, friction=False)}
    for term, without in added.items():
        # A long series of kernels loses rank by itself: no term that was added can cure that.
        trade_off = law.rank < law.unknowns <= _SHORT_LAW
        lost = term in _unidentified(law) or trade_off
        if without == structure or not lost:
            continue
        fewer = fit_structure(train, without)
        cured = fewer.rank == fewer.unknowns
        if cured and fewer.train_cost <= (1.0 + _NO_WORSE) * law.train_cost:
            return fewer
    return law


def _fit_networks(
    train: Dataset,
    networks: Sequence[NetworkStructure],
    laws: Sequence[FitOutcome[TorqueModel]],
    settings: Settings,
    report: FitProgress,
) -> tuple[list[FitOutcome[NetworkModel]], list[CheckError]]:
    """Networks one after another, their starts side by side; behind a lag with the time constants of the best law.

    Returns:
        The networks, and why others cannot be trained on these rows; `CheckError.where` names the network.
    """
    trained: list[FitOutcome[NetworkModel]] = []
    refused: list[CheckError] = []
    with one_thread():
        for done, network in enumerate(networks, start=1):
            with _or_refused(full_name(network.specification, network.dynamics), refused):
                numbers = _dynamics_for(train, network, laws)
                trained.append(_network(train, network, settings, settings.workers, numbers))
            report(done, len(networks), network.specification)
    return trained, refused


@contextmanager
def _or_refused(name: str, refused: list[CheckError]) -> Generator[None]:
    """A model that the rows cannot make is kept for a note, and the next one is fitted."""
    try:
        yield
    except CheckError as error:
        refused.append(CheckError(error.problem, where=name, remedy=error.remedy))


def _fit_residuals(
    train: Dataset,
    residuals: Sequence[ResidualStructure],
    laws: Sequence[FitOutcome[TorqueModel]],
    settings: Settings,
    report: FitProgress,
) -> tuple[list[FitOutcome[ResidualModel]], list[CheckError]]:
    """Laws with a network on their residual, one after another; a law that is fitted already is not fitted again.

    Returns:
        The models, and why others cannot be made of these rows; `CheckError.where` names the model.
    """
    corrected: list[FitOutcome[ResidualModel]] = []
    refused: list[CheckError] = []
    known = {law.model.structure: law for law in laws}
    with one_thread():
        for done, pair in enumerate(residuals, start=1):
            with _or_refused(full_name(pair.specification, pair.dynamics), refused):
                law = known.get(pair.law)
                corrected.append(fit_residual(train, pair, seed=settings.seed, workers=settings.workers, law=law))
            report(done, len(residuals), pair.specification)
    return corrected, refused


def _network(
    train: Dataset, structure: NetworkStructure, settings: Settings, workers: int, dynamics: Mapping[str, float]
) -> FitOutcome[NetworkModel]:
    return fit_network(train, structure, seed=settings.seed, polish=settings.polish, workers=workers, dynamics=dynamics)


def _dynamics_for(
    train: Dataset, network: NetworkStructure, laws: Sequence[FitOutcome[TorqueModel]]
) -> dict[str, float]:
    """Numbers of the stages, of the law with the lowest cost among those with the same stages but for the effort's."""
    if network.dynamics == "none":
        return {}
    models = [law.model for law in sorted(laws, key=lambda law: law.train_cost)]
    same = [m for m in models if _remembered(m.structure.dynamics) == network.dynamics]
    if not same:
        law = law_from_name("bingham", train.device)
        single = train.device == "single"
        structure = Structure(train.device, "bingham", law, network.dynamics, single, single)
        same = [fit_structure(train, structure).model]
    return stage_numbers_in_user_units(same[0], network.dynamics)


def _with_memory(
    train: Dataset, laws: Sequence[FitOutcome[TorqueModel]], report: FitProgress
) -> tuple[list[FitOutcome[TorqueModel]], tuple[Finding, ...]]:
    """The best law with stages of memory, as far as blocked validation on the training rows asks for them.

    The findings name columns of the log that would take more of the error off.
    """
    known = [law for law in laws if not law.model.structure.law.forward and not law.model.structure.law.stimulus]
    if not known:
        return [], ()
    least = min(law.train_cost for law in known)
    near = [law for law in known if law.train_cost <= (1.0 + TOLERATED) * least]
    base = min(near, key=lambda law: (law.parameters, law.train_cost))
    quickest = min(known, key=lambda law: law.train_cost).model.structure.dynamics
    with one_thread():
        rungs = grown(train, replace(base.model.structure, dynamics=quickest), tuple(train.extras))
        spare = helpful(train, rungs[-1])
    findings = tuple(_spare_column(name, gain) for name, gain in spare.items())
    wanted = dict.fromkeys(rung.structure for rung in (rungs[1], rungs[-1])) if len(rungs) > 1 else {}
    return _fit_all(train, list(wanted), 2, report), findings


def _spare_column(name: str, gain: float) -> Finding:
    return Finding(
        "note",
        "spare column",
        f"the column {name!r}, which no model has as an input, would take {gain:.0%} off the error of the best law",
        f"Fit with --input {shell_word(name)}, unless it measures the effort once more",
    )


def _networks_with_memory(
    train: Dataset, networks: Sequence[NetworkStructure], laws: Sequence[FitOutcome[TorqueModel]]
) -> tuple[list[NetworkStructure], list[ResidualStructure]]:
    """Each FNN that is asked for twice more: with the memory of the richest law, and on what that law misses."""
    if not laws or not slip_stages(laws[-1].model.structure.dynamics):
        return [], []
    law = laws[-1].model.structure
    asked = [n for n in networks if n.kind == "fnn"]
    remembering, correcting = (
        [n for n in dict.fromkeys(replace(n, dynamics=form) for n in asked) if supports(train.rows, n)]
        for form in (_remembered(law.dynamics), law.dynamics)
    )
    return remembering, [ResidualStructure(law, n) for n in correcting]


def _second_time_constant(
    train: Dataset, laws: Sequence[FitOutcome[TorqueModel]], report: FitProgress
) -> list[FitOutcome[TorqueModel]]:
    """The best lagged law with separate time constants, if the training data ask for them."""
    lagged = [law for law in laws if law.model.structure.dynamics == "lag"]
    if not lagged:
        return []
    one = min(lagged, key=lambda law: law.train_cost)
    two = _fit_all(train, [replace(one.model.structure, dynamics="rise-fall")], 1, report)[0]
    independent = min(independent_rows(train.effort - o.model.predict(train)) for o in (one, two))
    criteria = [
        information_criteria(o.train_cost, o.train_rows, independent, o.parameters)["bic_independent"]
        for o in (one, two)
    ]
    return [two] if criteria[1] < criteria[0] - _EVIDENCE else []


def scored(
    data: Dataset, train: Dataset, test: NDArray[np.bool_], outcomes: Sequence[AnyOutcome], settings: Settings
) -> list[RankedModel]:
    """Outcomes with their figures, best test error first."""
    predictions = [outcome.model.predict(data) for outcome in outcomes]
    errors = [data.effort - p for p in predictions]
    sound = [e for e in errors if np.all(np.isfinite(e))] or [data.effort]
    independent = min(independent_rows(e[~test]) for e in sound)
    best = min((e[test] for e in sound), key=lambda e: float(e @ e))
    entries: list[RankedModel] = []
    for outcome, predicted in zip(outcomes, predictions, strict=True):
        cost = float(np.sum((data.effort - predicted)[~test] ** 2))
        entries.append(
            RankedModel(
                outcome=outcome,
                train=score(data.effort[~test], predicted[~test], seed=settings.seed),
                test=score(data.effort[test], predicted[test], seed=settings.seed),
                criteria=information_criteria(cost, train.rows, independent, outcome.parameters),
                folds=_cross_validate(train, outcome, settings),
                predicted=predicted,
                excess=excess((data.effort - predicted)[test], best, seed=settings.seed),
                sound=_sound(outcome) and not _wild(data, predicted, test),
                notes=(*_notes(outcome, data, predicted, test), *_untold(outcome, data, settings)),
            )
        )
    return sorted(entries, key=lambda e: e.test.rmse.value)


def with_bands(data: Dataset, test: NDArray[np.bool_], entries: Sequence[RankedModel]) -> list[RankedModel]:
    """The models with bands that are calibrated on the training rows and judged on those held out."""
    errors = [data.effort - entry.predicted for entry in entries]
    outcomes = [entry.outcome for entry in entries]
    found = calibrated(data, ~test, errors, [o.parameters for o in outcomes], [o.unseen for o in outcomes])
    return [
        entry if pair is None else _with_band(data, test, entry, pair[0], judged(data, test, entry.predicted, *pair))
        for entry, pair in zip(entries, found, strict=True)
    ]


def _with_band(
    data: Dataset, test: NDArray[np.bool_], entry: RankedModel, band: Band, figures: HeldBand
) -> RankedModel:
    outcome: Any = entry.outcome
    error = data.effort - entry.predicted
    logs = [rows[test[rows]] for rows in (np.arange(a, b) for a, b in data.source_rows)]
    errors = [float(np.sqrt(np.mean(error[rows] ** 2))) for rows in logs if rows.size]
    by_log = (min(errors), max(errors), len(errors)) if len(errors) > 1 else None
    banded = replace(outcome, model=replace(outcome.model, band=band))
    return replace(entry, outcome=banded, band=figures, by_log=by_log)


def _with_sensor(data: Dataset, test: NDArray[np.bool_], entry: RankedModel) -> RankedModel:
    """The model with what its band holds if a sensor teaches it."""
    band = entry.outcome.model.band
    if band is None or entry.band is None:
        return entry
    return replace(entry, band=judged(data, test, entry.predicted, band, entry.band.plain, sensor=True))


def _judged_by_training(entries: Sequence[RankedModel]) -> list[RankedModel]:
    """Laws that miss the fields of the training rows, where the rows held out have but one, are not recommended."""
    laws = [e for e in entries if e.sound and not e.outcome.weights]
    if not laws:
        return list(entries)
    best = min(laws, key=lambda e: e.train.rmse.value)

    def judged(entry: RankedModel) -> RankedModel:
        more = entry.train.rmse.value / best.train.rmse.value - 1.0
        if entry.outcome.weights or not more > TOLERATED:
            return entry
        note = f"errs on the training rows by {more:.0%} more than {best.name}, which rows held out at one field hide"
        return replace(entry, sound=False, notes=(*entry.notes, note))

    return [judged(entry) for entry in entries]


def _cross_validate(train: Dataset, outcome: AnyOutcome, settings: Settings) -> tuple[float, ...]:
    """RMSE on each block of the training rows, fitted on the others."""
    if not settings.blocks:
        return ()
    errors: list[float] = []
    for block in time_folds(train, settings.blocks):
        model = _refit(train.take(~block), outcome, settings).model
        errors.append(float(np.sqrt(np.mean((train.effort - model.predict(train))[block] ** 2))))
    return tuple(errors)


def _refit(train: Dataset, outcome: AnyOutcome, settings: Settings) -> AnyOutcome:
    """The same model fitted to other rows."""
    model = outcome.model
    if isinstance(model, TorqueModel):
        return fit_structure(train, model.structure)
    if model.correction is not None:
        return fit_residual(train, model.structure, seed=settings.seed)
    return _network(train, model.structure, settings, 1, model.dynamics)


def _unidentified(outcome: AnyOutcome) -> list[str]:
    return [e.name for e in outcome.estimates if not e.at_bound and np.isinf(e.high - e.low)]


def _untold(outcome: AnyOutcome, data: Dataset, settings: Settings) -> list[str]:
    """Terms that were asked for and are left out, because these rows cannot tell them from the law's own."""
    if outcome.weights:
        return []
    structure: Any = outcome.model.structure  # of a law: it has no weights
    friction, offset = _extra_terms(data, settings)
    left_out = [
        *(["a constant effort"] if offset and not structure.offset else []),
        *(["friction"] if friction and not structure.friction and structure.law.yield_form is not CONSTANT else []),
    ]
    if not left_out:
        return []
    return [f"left out, since these rows cannot tell them from the law's own terms: {' and '.join(left_out)}"]


def _sound(outcome: AnyOutcome) -> bool:
    if outcome.weights:
        return outcome.stop != "stalled"
    known = outcome.rank == outcome.unknowns and not _unidentified(outcome)
    return outcome.converged and known and outcome.condition <= _MEANINGLESS


def _wild(data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> int:
    """Test rows that are predicted far outside all efforts seen in training."""
    seen = data.effort[~test]
    return int(np.count_nonzero(~(np.abs(predicted[test] - seen.mean()) < 3.0 * float(np.ptp(seen)))))


def _too_short(outcome: AnyOutcome, data: Dataset) -> list[str]:
    """Which travels of the memory are so long that stretches of the log end before their start is forgotten."""
    lengths = {e.name: e.value for e in outcome.estimates if e.name in outcome.model.times and e.name.startswith("r_")}
    if not lengths:
        return []
    steps = np.diff(data.clock.time, prepend=data.clock.time[0])
    walked = [
        min(float(np.sum(np.abs(e.slip[s.start + 1 : s.stop]) * steps[s.start + 1 : s.stop])) for e in data.elements)
        for s in data.clock.spans
    ]
    return [
        f"{short} of {len(walked)} stretches are too short to forget the start of {name} = {length:.3g}"
        for name, length in lengths.items()
        if (short := sum(travel < _FORGOTTEN * length for travel in walked))
    ]


def _adds(model: ResidualModel, data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> str:
    """What the network of a law with one adds, on the rows held out."""
    alone, both = (
        float(np.sqrt(np.mean((data.effort - effort)[test] ** 2))) for effort in (model.law.predict(data), predicted)
    )
    change = f"{abs(1.0 - both / alone):.1%} {'less' if both <= alone else 'more'}" if alone > 0 else "no less"
    unit, limit = data.units.effort or "", model.correction.limit
    return (
        f"test RMSE {alone:.4g} {unit} of the law alone, {both:.4g} {unit} with the network ({change}); "
        f"the network moves the effort by at most {limit:.4g} {unit}"
    )


def _notes(outcome: AnyOutcome, data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> tuple[str, ...]:
    notes: list[str] = []
    if outcome.model.correction is not None:
        notes.append(_adds(outcome.model, data, predicted, test))
    if not outcome.converged and not outcome.weights:
        notes.append(f"solver stopped before its tolerance ({outcome.stop} after {outcome.iterations} steps)")
    if outcome.at_bounds:
        notes.append(f"at a bound: {', '.join(outcome.at_bounds)}")
    unknown = _unidentified(outcome)
    if unknown:
        notes.append(f"not identified by these data: {', '.join(unknown)}")
    elif outcome.rank < outcome.unknowns:
        notes.append(f"rank {outcome.rank} of {outcome.unknowns}: parameters trade off")
    elif outcome.condition > _MEANINGLESS:
        notes.append(f"condition {outcome.condition:.0e}: its parameters mean nothing one by one")
    notes += _too_short(outcome, data)
    wild = _wild(data, predicted, test)
    if wild:
        notes.append(f"{wild} test rows are predicted far outside all efforts seen: do not extrapolate this model")
    return tuple(notes)
