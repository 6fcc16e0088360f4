"""The main job fits every model to one data set, scores it on held-out rows, ranks all, and recommends one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch import registry
from erclutch.errors import CheckError, PluginError, SettingError, SpoiltError, require_known
from erclutch.fit.candidate import Candidate, Fitted, Kind, kinds
from erclutch.fit.checks.data_check import ONE_FIELD, check, steady_command
from erclutch.fit.checks.effort_and_slip import SIGN
from erclutch.fit.checks.finding import Finding
from erclutch.fit.checks.no_time import NO_MEMORY
from erclutch.fit.checks.usual_hold_out import usual_hold_out
from erclutch.fit.choice.ranking import (
    RankedModel,
    judged_by_training,
    scored,
    with_bands,
    with_reasons,
    with_sensor,
)
from erclutch.fit.choice.recommending import recommend
from erclutch.fit.choice.standing import Standing, standing
from erclutch.fit.choice.validation import chosen, cross_validated
from erclutch.fit.fit_progress import Course, FitProgress, FitStep
from erclutch.fit.fit_settings import AUTO, Settings
from erclutch.fit.history import history_finding
from erclutch.fit.log_zeros import log_differences
from erclutch.fit.pace import motion_held_out, two_motions
from erclutch.fit.past_samples import past_finding, without_network
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import AnyOutcome, FitOutcome
from erclutch.fit.turned_sign import with_turned_fit
from erclutch.logs.covering_stretches import USUAL_SHARE
from erclutch.logs.dataset import Dataset, require_dataset
from erclutch.logs.held_out import hold_out
from erclutch.models.model_titles import id_of, title_of, titles_of
from erclutch.registry import Plugin
from erclutch.signals.percent import percent
from erclutch.signals.shown import Shown, one_line

__all__ = ["Comparison", "FitProgress", "FitStep", "RankedModel", "Settings", "compare"]


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
        chosen_by: the parts of the training rows that were left out in turn and chose the model that is recommended;
            "": the rows held out did.
        recalibration: of a kept model to these data: what was done, as JSON values; None: all models are new.
        candidates: how each model is fitted, by name, so that the chosen one can be fitted to all rows.
        final: the recommended model fitted to all rows, which nothing judges (`fit.final_fit`); None: not asked for.
    """

    data: Dataset
    test: NDArray[np.bool_]
    settings: Settings
    findings: tuple[Finding, ...]
    entries: tuple[RankedModel, ...]
    best: str
    recommended: str
    chosen_by: str = ""
    recalibration: Mapping[str, Any] | None = None
    candidates: Mapping[str, Candidate] = field(default_factory=dict[str, Candidate], compare=False)
    final: AnyOutcome | None = None

    @cached_property
    def titles(self) -> Mapping[str, str]:
        """What each model is called in plain words, by its name."""
        return titles_of([entry.name for entry in self.entries])

    def called(self, name: str) -> str:
        """A model's id and title, for example ``m1, Casson law with a lag``."""
        return f"{self.id_of(name)}, {self.titles[name]}"

    def id_of(self, name: str) -> str:
        """A model's id here: ``m1`` for the first of the ranking."""
        names = [entry.name for entry in self.entries]
        return id_of(names.index(name))

    def __repr__(self) -> str:
        chosen = self.entry(self.recommended)
        test = chosen.test
        word = f"{self.standing.word} {self.called(chosen.name)}"
        error = f"RMSE {test.rmse.value:.4g} {self.data.units.effort} on {test.rows} rows held out"
        share = f"{percent(test.share.value, 1)} of the standard deviation"
        return one_line(self, self.data.where, f"{len(self.entries)} models", word, error, share)

    @property
    def standing(self) -> Standing:
        """Whether the chosen model is recommended, and why not."""
        chosen = self.entry(self.recommended)
        figures = {"sound": chosen.sound, "test": chosen.test.to_dict()}
        return standing(figures, {finding.subject for finding in self.findings})

    def entry(self, name: str) -> RankedModel:
        """The entry of a model by its name or its id.

        Raises:
            SettingError: no such model.
        """
        for place, entry in enumerate(self.entries):
            if name in (entry.name, id_of(place)):
                return entry
        raise SettingError(
            f"no model {name!r} here",
            remedy=f"Choose one of {', '.join(e.name for e in self.entries)}",
        )


_NO_LAG = (
    "the field never changes within a stretch of the training rows, so no lag between command and "
    "field can be told"
)


# The time that the choice takes, beside the `work` of a kind: a third of the whole on 74,068 rows of a real damper.
_CHOICE = 3.0


@one_thread()
def compare(
    data: Dataset,
    settings: Settings | None = None,
    progress: FitProgress | None = None,
    known: Mapping[str, AnyOutcome] = MappingProxyType({}),
    **more: Any,
) -> Comparison:
    """Fit, score and rank models.

    Args:
        data: the rows.
        settings: what to do; None: all models with the defaults.
        progress: called after each step with what was done, a `FitStep`.
        known: fits to the same training rows, by the names of their models, which are not made again.
        more: single settings, such as ``models=("bingham",)``; they go before those of `settings`.

    Raises:
        CheckError: the data cannot support a fit.
        SettingError: an unknown model, lag, split or keyword.
    """
    require_known(
        more, [*(each.name for each in fields(Settings)), "settings", "progress"], "compare"
    )
    require_dataset(data)
    settings = replace(settings or Settings(), **more)
    failed: dict[tuple[str, ...], PluginError] = {}
    while True:
        try:
            return _compared(data, settings, progress, known, failed)
        except Exception as error:
            # A package may fail on rows that no check of it has seen: all is done once more without it.
            fault = registry.fault_behind(error)
            if fault is None:
                raise
            if not fault.plugin or fault.plugin in failed:
                raise fault from error
            failed[fault.plugin] = fault


def _compared(
    data: Dataset,
    settings: Settings,
    progress: FitProgress | None,
    known: Mapping[str, AnyOutcome],
    failed: Mapping[tuple[str, ...], PluginError],
) -> Comparison:
    """The comparison without the plug-ins of other packages that failed, by group and name; see `compare`."""
    why_stretches: tuple[Finding, ...] = ()
    if settings.test in (AUTO, (AUTO,)):
        held, why_stretches = usual_hold_out(data)
        settings = replace(settings, test=held)
    test = hold_out(data, settings.test)
    if not test.any():  # a share of next to nothing, or no pattern: no figure could be given
        remedy = f"Hold out some with --test, such as --test {USUAL_SHARE:g}"
        raise CheckError(f"none of {data.rows} rows is held out", where=data.where, remedy=remedy)
    train = data.take(~test)
    findings = why_stretches + check(data, test) + past_finding(settings.past, data)
    findings += motion_held_out(data, test) + two_motions(train)
    if settings.lag == AUTO and data.in_no_time:
        findings += (NO_MEMORY,)
    elif settings.lag == AUTO and steady_command(train) and not data.one_field:
        remedy = "Log with a switching field to identify a lag; models are fitted without one here"
        if not steady_command(data):  # all changes lie in rows that are held out
            remedy = "Hold out stretches all over the log (--test stretches): its field changes in the rows held out"
        findings += (Finding("note", "dynamics", _NO_LAG, remedy),)

    # From here to the ranking, no model sees a row that was held out.
    every = [
        (plugin, kind) for plugin, kind in kinds() if (plugin.group, plugin.name) not in failed
    ]
    work: list[float] = []  # of each phase
    for _, kind in every:
        work += kind.work
    course = Course((*work, _CHOICE), progress)
    fitted, seen = _fit_all(every, settings, train, course, known, failed)
    outcomes = [each.outcome for each in fitted]
    # Where a sign is in doubt, a fit with the sign turned says how much better it would be.
    findings = tuple(
        with_turned_fit(finding, data, test, settings, outcomes)
        if finding.subject == SIGN
        else finding
        for finding in findings
    )
    findings += seen + without_network(settings, [each.model for each in outcomes])

    # Rank by the rows held out.
    folds = [cross_validated(train, each, settings.blocks) for each in fitted]
    entries = scored(data, train, test, outcomes, settings, folds)
    if any(finding.subject == ONE_FIELD for finding in findings):
        entries = judged_by_training(entries)

    # Recommend by training rows that are left out in turn, so that the rows held out judge the choice too.
    course.begin()
    sound = [entry.name for entry in entries if entry.sound]
    choice = chosen(train, fitted, sound, settings.seed, course.told)
    if choice is None:
        entries = with_bands(data, test, entries)
    else:
        entries = with_bands(data, test, entries, choice.at_new_fields, choice.growth)
    best, recommended = recommend(
        scores={entry.name: entry.test for entry in entries},
        excesses={entry.name: entry.excess for entry in entries},
        burden={entry.name: entry.outcome.parameters for entry in entries},
        sound=set(sound),
        freedom={entry.name: entry.outcome.freedom for entry in entries},
    )
    if choice is not None:
        recommended = choice.recommended
        for place, entry in enumerate(entries):
            entries[place] = replace(entry, validation=choice.errors.get(entry.name))
        entries = with_reasons(entries, recommended, choice.against)

    # What the recommended model leaves open.
    names = [entry.name for entry in entries]
    place = names.index(recommended)
    taken = with_sensor(data, test, entries[place])
    entries[place] = taken
    left = data.effort - taken.predicted
    stages = taken.outcome.model.structure.dynamics
    memory = history_finding(data, left, title_of(taken.name), stages)
    if memory is not None:
        findings += (memory,)
    findings += log_differences(data, taken.predicted)
    return Comparison(
        data,
        test,
        settings,
        findings,
        tuple(entries),
        best,
        recommended,
        chosen_by="" if choice is None else choice.words,
        candidates={each.outcome.name: each.candidate for each in fitted},
    )


def _fit_all(
    every: Sequence[tuple[Plugin, Kind]],
    settings: Settings,
    train: Dataset,
    course: Course,
    made: Mapping[str, AnyOutcome],
    failed: Mapping[tuple[str, ...], PluginError],
) -> tuple[list[Fitted], tuple[Finding, ...]]:
    """All candidates of all kinds, fitted; and what was seen on the way.

    Raises:
        SettingError: no model is asked for, or one that cannot be; before anything is fitted.
        CheckError: these rows can make none of the models.
        PluginError: all models that were asked for need packages that fail.
    """

    def sound(candidates: Sequence[Candidate]) -> list[Candidate]:
        """Those that need no plug-in that failed."""
        return [
            each
            for each in candidates
            if not any((part.group, part.name) in failed for part in _parts_of(each))
        ]

    asked = [sound(_of(plugin, kind.candidates, settings, train)) for plugin, kind in every]
    if failed and not any(asked):
        raise next(iter(failed.values()))
    if not any(asked):
        raise SettingError(
            "no model was given", remedy="Give --models all, or names from erclutch laws"
        )
    fitted: list[Fitted] = []
    findings: tuple[Finding, ...] = ()
    refused: list[CheckError | PluginError] = []
    for (plugin, kind), candidates in zip(every, asked, strict=True):
        course.begin()
        fitted += _fit(
            plugin, kind, candidates, train, fitted, settings.workers, refused, course, made
        )
        course.begin()
        course.told(0.0, "looking for what these fits leave")
        further = _of(plugin, kind.grown, settings, train, fitted)
        fitted += _fit(
            plugin,
            kind,
            sound(further.candidates),
            train,
            fitted,
            settings.workers,
            refused,
            course,
            made,
        )
        findings += further.findings
    if not fitted:
        raise refused[0]
    left_out: list[Finding] = []
    for reason in refused:
        message = f"{reason.where} is left out: {reason.problem}"
        level = "warning" if isinstance(reason, PluginError) else "note"
        left_out.append(Finding(level, "left out", message, reason.remedy))
    for error in failed.values():
        message = f"what needs it is left out: {error.problem}"
        left_out.append(Finding("warning", "left out", message, error.remedy))

    # A name stands for one model of a run. A search may come to a law that was asked for, with other terms taken out:
    # the better of both stays, by soundness and training rows.
    best: dict[str, Fitted] = {}
    for each in fitted:
        of_one_name = [best.get(each.outcome.name, each), each]
        best[each.outcome.name] = min(
            of_one_name, key=lambda fit: (not fit.outcome.sound, fit.outcome.train_cost)
        )
    return list(best.values()), (*findings, *left_out)


def _parts_of(candidate: Candidate) -> Sequence[Plugin]:
    """What a candidate needs of other packages; the candidate of another package may not say it."""
    return getattr(candidate, "plugins", ())


def _of(plugin: Plugin, answer: Any, *question: Any) -> Any:
    """What a kind of model answers; what fails in another package's is told with its name."""
    with plugin.working():
        return answer(*question)


def _fit(
    plugin: Plugin,
    kind: Kind,
    candidates: Sequence[Candidate],
    train: Dataset,
    known: Sequence[Fitted],
    workers: int,
    refused: list[CheckError | PluginError],
    course: Course,
    made: Mapping[str, AnyOutcome],
) -> list[Fitted]:
    """Candidates of one kind, fitted, one BLAS thread each, in their order whichever is done first.

    Why these rows cannot make a model is added to ``refused``; `CheckError.where` names the model.
    """
    known = list(known)
    at_once, starts_at_once = 1, workers
    if kind.side_by_side:
        at_once, starts_at_once = max(1, workers), 1

    def fit(candidate: Candidate) -> AnyOutcome | None:
        if candidate.name in made:
            return made[candidate.name]
        # Of a law of ours with a stage of another package the stage is at fault.
        at_fault = next(iter(_parts_of(candidate)), plugin) if plugin.own else plugin
        try:
            with at_fault.working(f"failed on {candidate.name}"):
                outcome = candidate.fit(train, known, starts_at_once)
                if not at_fault.own:
                    _require_rows(outcome, train, at_fault)
                return outcome
        except SpoiltError:  # of what is fitted meanwhile, too: all is done once more
            raise
        except (CheckError, PluginError) as error:
            refused.append(type(error)(error.problem, where=candidate.name, remedy=error.remedy))
            return None

    with one_thread(), ThreadPoolExecutor(max_workers=at_once) as pool:
        futures = {pool.submit(fit, candidate): candidate for candidate in candidates}
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                course.fitted(done / len(futures), futures[future].name, future.result(), train)
        except BaseException:  # Control-C too: what has not begun must not begin
            pool.shutdown(cancel_futures=True, wait=False)
            raise
        pairs = [(candidate, future.result()) for future, candidate in futures.items()]
    return [Fitted(candidate, outcome) for candidate, outcome in pairs if outcome is not None]


def _require_rows(outcome: Any, train: Dataset, plugin: Plugin) -> None:
    """Refuse what a model of another package, or with a part of one, answers to the training rows.

    Raises:
        PluginError: it is no outcome of a fit, or its effort is no finite array of the rows.
    """
    if not isinstance(outcome, FitOutcome):
        raise plugin.fault(f"fits a {type(outcome).__name__}, it must be a FitOutcome")
    given = cast("AnyOutcome", outcome).model.predict(train)
    effort = np.asarray(given)
    if effort.shape != (train.rows,) or effort.dtype.kind not in "fiu":
        raise plugin.fault(f"estimates no array of {train.rows} rows: {given!s:.60}")
    wrong = train.rows - np.count_nonzero(np.isfinite(effort))
    if wrong:
        raise plugin.fault(f"estimates no finite effort in {wrong} of {train.rows} rows")
