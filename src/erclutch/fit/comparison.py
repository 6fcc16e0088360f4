"""The main job: every model on one data set, fitted, scored on rows held out, ranked, with a plain recommendation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.check import ONE_FIELD, Finding, check, steady_command
from erclutch.dataset import Dataset, blocks, hold_out
from erclutch.dynamics import DynamicsForm
from erclutch.errors import SettingError
from erclutch.evaluate import (
    TOLERATED,
    Figure,
    Score,
    block_rows,
    excess,
    independent_rows,
    information_criteria,
    recommend,
    score,
)
from erclutch.fit import FitOutcome, fit_structure
from erclutch.fit.networks import fit_network
from erclutch.laws import LADDER, law_from_name
from erclutch.model import TIMES, Structure, TorqueModel
from erclutch.networks import NetworkStructure, is_network, network_from_name
from erclutch.networks.model import NetworkModel
from erclutch.paper import APPROACHES

Array = NDArray[np.float64]
AnyOutcome = FitOutcome[TorqueModel] | FitOutcome[NetworkModel]
Lag = Literal["auto", "none", "lag", "rise-fall"]
LAGS: tuple[Lag, ...] = ("auto", "none", "lag", "rise-fall")

#: Separate time constants are asked for by the data when they lower the criterion by this much: "very strong" evidence.
_EVIDENCE = 10.0
#: Condition of the Jacobian beyond which single parameters are lost in each other's intervals.
_MEANINGLESS = 1e8


@dataclass(frozen=True)
class Settings:
    """What a comparison does; together with the log it determines every figure.

    Attributes:
        models: specifications of laws; "all" is the ladder, "paper" the laws of the paper's tables.
        lag: "none"; "lag" (one time constant); "rise-fall" (two); "auto": without and with one, and two for the best
            law if the data ask for it.
        test: share of each log, its end, that is held out (of each stretch, where a log was taken at one field after
            another); or patterns of the names of logs that are.
        blocks: blocks in time for cross-validation on the training rows, 2 to 50; 0 for none.
        friction: a column of friction at zero field; None: yes for a single device, no for the pair (the paper's form).
        offset: a constant effort; None: as for friction.
        seed: of the bootstrap and of the networks' starts.
        past: rows back that are inputs of networks too.
        polish: whether networks get a last round over all rows.
        workers: models fitted side by side; changes no figure.
    """

    models: tuple[str, ...] = ("all",)
    lag: Lag = "auto"
    test: float | tuple[str, ...] = 0.3
    blocks: int = 0
    friction: bool | None = None
    offset: bool | None = None
    seed: int = 0
    workers: int = 2
    past: tuple[int, ...] = ()
    polish: bool = False

    def to_dict(self) -> dict[str, Any]:
        """As JSON values, without what changes no figure."""
        values = asdict(self)
        del values["workers"]
        return values


@dataclass(frozen=True)
class Entry:
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
    """

    outcome: AnyOutcome
    train: Score
    test: Score
    criteria: dict[str, float]
    folds: tuple[float, ...]
    predicted: Array
    excess: Figure
    sound: bool
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """The model's name."""
        return self.outcome.model.name


@dataclass(frozen=True)
class Comparison:
    """Ranked models of one data set.

    Attributes:
        data: all rows.
        test: mask of the rows held out.
        settings: what was asked for.
        findings: what the checks saw.
        entries: best test error first.
        best, recommended: names.
    """

    data: Dataset
    test: NDArray[np.bool_]
    settings: Settings
    findings: tuple[Finding, ...]
    entries: tuple[Entry, ...]
    best: str
    recommended: str

    def entry(self, name: str) -> Entry:
        """The entry of a model by name.

        Raises:
            SettingError: no such model.
        """
        for entry in self.entries:
            if entry.name == name:
                return entry
        raise SettingError(f"no model {name!r} here", remedy=f"There are {', '.join(e.name for e in self.entries)}")


_SETS = {"all": (*LADDER, "rbfn-10", "fnn-16"), "paper": tuple(APPROACHES)}
_NO_LAG = Finding(
    "note",
    "dynamics",
    "the field never changes within a stretch of the training rows, so no lag between command and field can be told",
    "Log with a switching field to identify a lag; models are fitted without one here",
)

#: Called with the number of fits done, the number there are, and what was just done.
Progress = Callable[[int, int, str], None]


def compare(data: Dataset, settings: Settings | None = None, progress: Progress | None = None) -> Comparison:
    """Fit, score and rank models.

    Args:
        data: the rows.
        settings: what to do; None: all models with the defaults.
        progress: called after each fit.

    Raises:
        CheckError: the data cannot support a fit.
        SettingError: an unknown model, lag or split.
    """
    settings = settings or Settings()
    report = progress or _silent
    test = hold_out(data, settings.test)
    findings = check(data, test)
    train = data.take(~test)
    lag: Lag = "none" if settings.lag == "auto" and steady_command(train) else settings.lag
    chosen = replace(settings, lag=lag)
    structures = structures_for(data, chosen)
    networks = networks_for(data, chosen)
    if not structures and not networks:
        raise SettingError("no model was given", remedy="Give --models all, or names from erclutch laws")
    if lag != settings.lag:
        findings += (_NO_LAG,)
    outcomes = _fit_all(train, structures, settings.workers, report)
    if lag == "auto":
        outcomes += _second_time_constant(train, outcomes, settings, report)
    outcomes += fit_networks(train, networks, outcomes, chosen, report)
    entries = _score_all(data, train, test, outcomes, settings)
    if any(finding.subject == ONE_FIELD for finding in findings):
        entries = _judged_by_training(entries)
    best, recommended = recommend(
        {e.name: e.test for e in entries},
        {e.name: e.excess for e in entries},
        {e.name: e.outcome.parameters for e in entries},
        {e.name for e in entries if e.sound},
    )
    return Comparison(data, test, settings, findings, tuple(entries), best, recommended)


def _silent(done: int, total: int, what: str) -> None:
    """No progress is shown."""


def structures_for(data: Dataset, settings: Settings) -> list[Structure]:
    """What a comparison fits, in the order of the ladder.

    Raises:
        SettingError: an unknown model or lag, or none at all.
    """
    if settings.lag not in LAGS:
        raise SettingError(f"unknown lag {settings.lag!r}", remedy=f"Choose one of {', '.join(LAGS)}")
    forms: dict[Lag, tuple[DynamicsForm, ...]] = {
        "auto": ("none", "lag"),
        "none": ("none",),
        "lag": ("lag",),
        "rise-fall": ("rise-fall",),
    }
    alone = data.device == "single"
    friction = alone if settings.friction is None else settings.friction
    offset = alone if settings.offset is None else settings.offset
    return [
        Structure(data.device, name, law_from_name(name, data.device), form, friction, offset)
        for form in forms[settings.lag]
        for name in dict.fromkeys(_full_name(n, data.device) for n in _names(settings) if not is_network(n))
    ]


def _names(settings: Settings) -> list[str]:
    return [name for model in settings.models for name in _SETS.get(model, (model,))]


def networks_for(data: Dataset, settings: Settings) -> list[NetworkStructure]:
    """The networks that a comparison fits, memoryless ones first.

    Raises:
        SettingError: a network that cannot be.
    """
    forms: dict[Lag, tuple[DynamicsForm, ...]] = {"auto": ("none", "lag"), "rise-fall": ("rise-fall",)}
    return list(
        dict.fromkeys(
            network_from_name(name, data.device, dynamics=form, past=settings.past, extras=tuple(data.extras))
            for form in forms.get(settings.lag, ("lag",) if settings.lag == "lag" else ("none",))
            for name in _names(settings)
            if is_network(name)
        )
    )


def _full_name(name: str, device: str) -> str:
    """The canonical specification, so that ``ss`` and ``seo-seo`` are one and files carry one name."""
    law = law_from_name(name, device)
    forms = sorted(name.strip().lower().split("/")[1:], key=lambda form: form == "forward")
    return "/".join([law.name, *dict.fromkeys(forms)])


def _fit_all(train: Dataset, structures: Sequence[Structure], workers: int, report: Progress) -> list[AnyOutcome]:
    """Fits side by side, one BLAS thread each; results in the order of the structures whatever finishes first."""
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1), ThreadPoolExecutor(max_workers=max(1, workers)) as pool:
        futures = [pool.submit(fit_structure, train, structure) for structure in structures]
        try:
            for done, name in enumerate(_as_completed(futures), start=1):
                report(done, len(futures), name)
        except BaseException:
            pool.shutdown(cancel_futures=True, wait=False)
            raise
        return [future.result() for future in futures]


def fit_networks(
    train: Dataset,
    networks: Sequence[NetworkStructure],
    outcomes: Sequence[AnyOutcome],
    settings: Settings,
    report: Progress,
) -> list[AnyOutcome]:
    """Networks one after another, their starts side by side; behind a lag with the time constants of the best law."""
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    found: list[AnyOutcome] = []
    with threadpool_limits(1):
        for done, network in enumerate(networks, start=1):
            dynamics = _dynamics_for(train, network, outcomes)
            found.append(
                fit_network(
                    train,
                    network,
                    seed=settings.seed,
                    polish=settings.polish,
                    workers=settings.workers,
                    dynamics=dynamics,
                )
            )
            report(done, len(networks), found[-1].model.name)
    return found


def _dynamics_for(train: Dataset, network: NetworkStructure, outcomes: Sequence[AnyOutcome]) -> dict[str, float]:
    """Delay and time constants of the law with the lowest cost among those with the same dynamics."""
    if network.dynamics == "none":
        return {}
    laws = [o.model for o in sorted(outcomes, key=lambda o: o.train_cost) if isinstance(o.model, TorqueModel)]
    same = [law for law in laws if law.structure.dynamics == network.dynamics]
    if not same:
        law = law_from_name("bingham", train.device)
        single = train.device == "single"
        structure = Structure(train.device, "bingham", law, network.dynamics, single, single)
        same = [fit_structure(train, structure).model]
    return {name: same[0].shape[name] for name in TIMES[network.dynamics]}


def _as_completed(futures: Sequence[Future[FitOutcome[TorqueModel]]]) -> Iterable[str]:
    waiting = set(futures)
    while waiting:
        done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result().model.name


def _second_time_constant(
    train: Dataset, outcomes: list[AnyOutcome], settings: Settings, report: Progress
) -> list[AnyOutcome]:
    """The best lagged law with separate time constants, if the training data ask for them."""
    lagged = [
        (o, o.model.structure)
        for o in outcomes
        if isinstance(o.model, TorqueModel) and o.model.structure.dynamics == "lag"
    ]
    if not lagged:
        return []
    one, structure = min(lagged, key=lambda pair: pair[0].train_cost)
    structure = replace(structure, dynamics="rise-fall")
    two = _fit_all(train, [structure], 1, report)[0]
    independent = min(independent_rows(train.effort - o.model.predict(train)) for o in (one, two))
    criteria = [
        information_criteria(o.train_cost, o.train_rows, independent, o.parameters)["bic_independent"]
        for o in (one, two)
    ]
    return [two] if criteria[1] < criteria[0] - _EVIDENCE else []


def _score_all(
    data: Dataset, train: Dataset, test: NDArray[np.bool_], outcomes: Sequence[AnyOutcome], settings: Settings
) -> list[Entry]:
    predictions = [outcome.model.predict(data) for outcome in outcomes]
    errors = [data.effort - p for p in predictions]
    sound = [e for e in errors if np.all(np.isfinite(e))] or [data.effort]
    lengths = [block_rows([e[rows] for e in sound]) for rows in (test, ~test)]
    independent = min(independent_rows(e[~test]) for e in sound)
    best = min((e[test] for e in sound), key=lambda e: float(e @ e))
    entries: list[Entry] = []
    for outcome, predicted in zip(outcomes, predictions, strict=True):
        cost = float(np.sum((data.effort - predicted)[~test] ** 2))
        entries.append(
            Entry(
                outcome=outcome,
                train=score(data.effort[~test], predicted[~test], block=lengths[1], seed=settings.seed),
                test=score(data.effort[test], predicted[test], block=lengths[0], seed=settings.seed),
                criteria=information_criteria(cost, train.rows, independent, outcome.parameters),
                folds=_cross_validate(train, outcome, settings),
                predicted=predicted,
                excess=excess((data.effort - predicted)[test], best, block=lengths[0], seed=settings.seed),
                sound=_sound(outcome) and not _wild(data, predicted, test),
                notes=_notes(outcome, data, predicted, test),
            )
        )
    return sorted(entries, key=lambda e: e.test.rmse.value)


def _judged_by_training(entries: Sequence[Entry]) -> list[Entry]:
    """Laws that miss the fields of the training rows, where the rows held out have but one, are not recommended."""
    laws = [e for e in entries if e.sound and not e.outcome.weights]
    if not laws:
        return list(entries)
    best = min(laws, key=lambda e: e.train.rmse.value)

    def judged(entry: Entry) -> Entry:
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
    for block in blocks(train, settings.blocks):
        model = _refit(train.take(~block), outcome, settings).model
        errors.append(float(np.sqrt(np.mean((train.effort - model.predict(train))[block] ** 2))))
    return tuple(errors)


def _refit(train: Dataset, outcome: AnyOutcome, settings: Settings) -> AnyOutcome:
    """The same model fitted to other rows."""
    model = outcome.model
    if isinstance(model, TorqueModel):
        return fit_structure(train, model.structure)
    return fit_network(
        train, model.structure, seed=settings.seed, polish=settings.polish, workers=1, dynamics=model.dynamics
    )


def _unidentified(outcome: AnyOutcome) -> list[str]:
    return [e.name for e in outcome.estimates if not e.at_bound and np.isinf(e.high - e.low)]


def _sound(outcome: AnyOutcome) -> bool:
    if outcome.weights:
        return outcome.stop != "stalled"
    known = outcome.rank == outcome.unknowns and not _unidentified(outcome)
    return outcome.converged and known and outcome.condition <= _MEANINGLESS


def _wild(data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> int:
    """Test rows that are predicted far outside all efforts seen in training."""
    seen = data.effort[~test]
    return int(np.count_nonzero(~(np.abs(predicted[test] - seen.mean()) < 3.0 * float(np.ptp(seen)))))


def _notes(outcome: AnyOutcome, data: Dataset, predicted: Array, test: NDArray[np.bool_]) -> tuple[str, ...]:
    notes: list[str] = []
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
    wild = _wild(data, predicted, test)
    if wild:
        notes.append(f"{wild} test rows are predicted far outside all efforts seen: do not extrapolate this model")
    return tuple(notes)
