"""Every model on one log: what is fitted, ranked, recommended; the same figures whatever the number of workers."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import CheckError, SettingError
from erclutch.fit.checks.data_check import ONE_FIELD
from erclutch.fit.comparison import Comparison, FitStep, Settings, compare
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.kinds.network_alone import networks_for
from erclutch.fit.laws.fit_law import fit_structure, refit_near
from erclutch.fit.networks.fit_network import fit_network
from erclutch.fit.recalibration import recalibrate
from erclutch.logs import read, recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import time_folds
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import ladder, without_yield
from erclutch.models.networks import network_from_name
from erclutch.models.networks.network_file import network_from_dict
from erclutch.models.networks.network_inputs import STRENGTH, stage_numbers_in_user_units
from erclutch.models.stages import stage_named
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    path: Path = tmp_path_factory.mktemp("log") / "log.csv"
    write_synthetic_log(path, 3.0)
    return build_dataset(read(path))


MODELS = ("quadratic", "bingham", "hem")


@pytest.fixture(scope="module")
def auto(data: Dataset) -> Comparison:
    return compare(data, Settings(models=MODELS))


@pytest.fixture(scope="module", params=["lag", pytest.param("auto", marks=pytest.mark.slow)])
def compared(request: pytest.FixtureRequest, data: Dataset) -> Comparison:
    """Fitted with a lag, which is quick, and with all that is tried by default."""
    return (
        request.getfixturevalue("auto")
        if request.param == "auto"
        else compare(data, Settings(MODELS, lag="lag"))
    )


def law_of(comparison: Comparison, name: str) -> TorqueModel:
    model = comparison.entry(name).outcome.model
    assert isinstance(model, TorqueModel)
    return model


@pytest.mark.slow
def test_entries_are_ranked_and_the_best_is_first(compared: Comparison) -> None:
    errors = [e.test.rmse.value for e in compared.entries]
    assert errors == sorted(errors)
    assert compared.best == compared.entries[0].name
    assert compared.entry(compared.best).excess.to_list() == [0.0, 0.0, 0.0]
    assert compared.recommended in {e.name for e in compared.entries}


@pytest.mark.slow
def test_the_recommended_model_has_no_more_parameters_than_the_best(auto: Comparison) -> None:
    assert auto.entry(auto.recommended).outcome.parameters <= auto.entries[0].outcome.parameters


@pytest.mark.slow
def test_auto_fits_each_model_with_and_without_a_lag(auto: Comparison) -> None:
    names = {e.name for e in auto.entries}
    assert {"quadratic", "bingham", "hem", "quadratic+lag", "bingham+lag", "hem+lag"} <= names
    more = names - {
        "quadratic",
        "bingham",
        "hem",
        "quadratic+lag",
        "bingham+lag",
        "hem+lag",
        "hem+rise-fall",
    }
    # Each law of a yield effort that was named gets the memory that the ladder found: none looks as if it had lost.
    assert {re.split("[+/]", name)[0] for name in more} == {"bingham", "hem"}
    assert all("+lag+" in name for name in more)


@pytest.mark.slow
def test_auto_finds_the_memory_of_the_log(auto: Comparison) -> None:
    # SYNTHETIC: a lag of 4 ms, Dahl's memory of 10 mrad that has a share without a field, a viscosity that grows with
    # the field and thins.
    assert {"lag", "dahl"} <= set(auto.best.split("+"))
    model = law_of(auto, auto.best)
    assert (
        0.002 < model.shape["r_1"] * model.reference.slip < 0.02
    )  # a sample moves further than that
    assert auto.entry(auto.best).test.rmse.value < 0.6 * auto.entry("hem+lag").test.rmse.value


@pytest.mark.slow
@pytest.mark.parametrize("dynamics", ["lag", "lag+dahl/field"])
def test_a_network_takes_the_numbers_of_its_own_stages_alone(
    auto: Comparison, dynamics: str
) -> None:
    """The law has further stages; a model file holds the numbers of its stages and nothing else."""
    law = auto.entry(auto.best).outcome
    assert isinstance(law.model, TorqueModel)
    network = network_from_name("fnn-2", "single", dynamics=dynamics)
    remembered = {"r_1", *STRENGTH} if "dahl" in dynamics else set()
    assert set(stage_numbers_in_user_units(law.model, dynamics)) == {"delay", "tau", *remembered}
    fitted = fit_network(
        auto.data, network, dynamics=stage_numbers_in_user_units(law.model, dynamics)
    ).model
    assert network_from_dict(fitted.to_dict()).to_dict() == fitted.to_dict()


@pytest.mark.slow
def test_the_lag_of_the_log_is_found(compared: Comparison) -> None:
    tau, delay = (law_of(compared, "hem+lag").shape[name] for name in ("tau", "delay"))
    assert np.isclose(tau, 4e-3, rtol=0.2)
    assert np.isclose(delay, 2e-3, atol=0.6e-3)


@pytest.mark.slow
def test_figures_are_those_of_the_predictions(compared: Comparison) -> None:
    measured = compared.data.effort
    for entry in compared.entries:
        error = measured - entry.predicted
        assert np.isclose(entry.test.rmse.value, np.sqrt(np.mean(error[compared.test] ** 2)))
        assert np.isclose(entry.train.mse.value, np.mean(error[~compared.test] ** 2))
        assert np.array_equal(entry.predicted, entry.outcome.model.predict(compared.data))
        assert entry.test.rows == int(compared.test.sum())


@pytest.mark.slow
def test_folds_are_fits_on_the_other_blocks(data: Dataset) -> None:
    """That laws with stages of the ladder have folds, too, is shown in `tests/runs/test_runs.py`."""
    compared = compare(data, Settings(models=("quadratic", "bingham"), lag="none", blocks=2))
    assert all(len(entry.folds) == 2 for entry in compared.entries)
    train = compared.data.take(~compared.test)
    entry = compared.entry("bingham")
    for block, rmse in zip(time_folds(train, 2), entry.folds, strict=True):
        others, on_all_rows = train.take(~block), law_of(compared, "bingham")
        nearest = refit_near(train, on_all_rows, ~block).model
        anew = fit_structure(others, on_all_rows.structure).model
        its_own, from_nothing, unrefitted = (
            float(np.sqrt(np.mean((train.effort - model.predict(train))[block] ** 2)))
            for model in (nearest, anew, on_all_rows)
        )
        assert np.isclose(rmse, its_own)
        # The quick refit ends at the minimum of a whole fit, as near as it solves; it is no fit to all rows.
        assert abs(rmse - from_nothing) < min(1e-4 * rmse, 0.05 * abs(rmse - unrefitted))


@pytest.fixture(scope="module")
def with_many_kernels(data: Dataset) -> Comparison:
    return compare(data, Settings(models=("quadratic", "rbfm-60"), lag="none"))


@pytest.mark.slow
def test_a_model_that_is_not_sound_is_not_recommended(with_many_kernels: Comparison) -> None:
    assert not with_many_kernels.entry("rbfm-60").sound
    assert with_many_kernels.recommended == "quadratic"


@pytest.mark.slow
def test_richer_models_never_fit_the_training_rows_worse(auto: Comparison) -> None:
    train = {e.name: e.train.rmse.value for e in auto.entries}
    for name in ("quadratic", "bingham", "hem"):
        assert train[f"{name}+lag"] <= train[name] * (1 + 1e-9)
    assert train["bingham"] <= train["quadratic"] * (1 + 1e-9)
    assert train["hem"] <= train["bingham"] * (1 + 1e-9)


@pytest.mark.slow
def test_progress_says_how_much_is_done_and_how_far_each_model_is_off(data: Dataset) -> None:
    steps: list[FitStep] = []
    result = compare(data, Settings(models=("quadratic", "bingham"), lag="none"), steps.append)
    done = [step.done for step in steps]
    assert done == sorted(done)
    assert 0.0 < done[0] < done[-1] < 1.0  # the last step says what is done next
    train = data.take(~result.test)
    for step in (step for step in steps if step.fitted):
        error = train.effort - result.entry(step.fitted).outcome.model.predict(train)
        assert step.train_share == pytest.approx(
            np.sqrt(np.mean(error**2)) / np.std(train.effort), rel=1e-6
        )
    assert {step.fitted for step in steps} == {"", "quadratic", "bingham"}
    # Blocks in time, and stretches: the field of this log is switched in an order that never comes again.
    assert steps[-1].doing == "choosing: part 8 of 8 is left out"


@pytest.mark.slow
def test_an_error_inside_a_fit_comes_out(data: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("provoked")

    monkeypatch.setattr("erclutch.fit.kinds.law_alone.fit_structure", broken)
    with pytest.raises(ZeroDivisionError, match="provoked"):
        compare(data, Settings(models=("quadratic", "bingham"), lag="none"))


@pytest.mark.slow
def test_a_steady_field_gets_no_lag_and_says_so(data: Dataset) -> None:
    """Two logs, each at one field."""
    n = data.rows // 2
    field = np.repeat([500.0, 1500.0], [n, data.rows - n])
    slip = data.elements[0].slip
    clock = Clock(data.clock.time, (Span(0, n, 1e-3), Span(n, data.rows, 1e-3)))
    effort = (
        1e-7 * field**2 * np.tanh(slip)
        + 0.003 * slip
        + 0.01 * np.random.default_rng(0).normal(size=data.rows)
    )
    steady = replace(
        data,
        elements=(Element(field, slip),),
        effort=effort,
        clock=clock,
        sources=("a", "b"),
        source_rows=((0, n), (n, data.rows)),
    )
    found = compare(steady, Settings(models=("bingham",)))
    assert [e.name for e in found.entries] == ["bingham"]
    assert "no lag between command and field can be told" in found.findings[-1].message
    asked = compare(steady, Settings(models=("bingham",), lag="lag"))
    assert [e.name for e in asked.entries] == ["bingham+lag"]


@pytest.mark.slow
def test_logs_that_are_held_out_by_name(data: Dataset) -> None:
    n = data.rows // 3
    spans = tuple(Span(i * n, (i + 1) * n, 1e-3) for i in range(3))
    cut = replace(
        data,
        sources=("a1", "a2", "b1"),
        source_rows=tuple((s.start, s.stop) for s in spans),
        clock=Clock(data.clock.time, spans),
    )
    found = compare(cut, Settings(models=("bingham",), lag="none", test=("b*",)))
    assert np.flatnonzero(found.test).tolist() == list(range(2 * n, 3 * n))


@pytest.mark.slow
def test_separate_time_constants_where_the_log_has_them() -> None:
    n = 12_000
    rng = np.random.default_rng(5)
    command = np.repeat(np.where(rng.random(n // 60) < 0.5, 0.0, 1000.0), 60)
    x, field = 0.0, np.empty(n)
    for k in range(n):
        x += (command[k] - x) * (0.3 if command[k] > x else 0.04)
        field[k] = x
    slip = 10 * np.sin(np.arange(n) * 0.02)
    effort = 4e-7 * field**2 * np.tanh(slip) + 0.01 * slip + 0.005 * rng.normal(size=n)
    clock = Clock(np.arange(n) / 1000, (Span(0, n, 1e-3),))
    log = Dataset("single", (Element(command, slip),), effort, clock, Units("N*m", "V", "rad/s"))
    found = compare(log, Settings(models=("quadratic", "bingham")))
    assert found.best == "bingham+rise-fall"
    shape = law_of(found, found.best).shape
    assert np.isclose(shape["tau_rise"], -1e-3 / np.log(0.7), rtol=0.1)
    assert np.isclose(shape["tau_fall"], -1e-3 / np.log(0.96), rtol=0.1)


# --- settings ---------------------------------------------------------------------------------------------------------


def test_all_is_the_ladder_and_names_are_canonical(data: Dataset) -> None:
    of_fluids = [name for name in ladder() if not without_yield(name)]
    made = structures_for(data, Settings(lag="none"))
    assert [s.specification for s in made] == of_fluids
    made = structures_for(data, Settings(models=("ss", "seo-seo", "HB/square", "all"), lag="lag"))
    assert [s.specification for s in made[:2]] == ["seo-seo", "herschel-bulkley/square"]
    assert len(made) == len(of_fluids) + 1
    assert {s.dynamics for s in made} == {"lag"}


def test_two_names_of_a_stage_are_one_model(data: Dataset) -> None:
    asked = (
        "bingham+dahl-1/field",
        "bingham+dahl/field",
        "bingham+stops-1",
        "fnn-6+dahl-01",
        "fnn-6+dahl",
    )
    made = [
        *structures_for(data, Settings(models=asked)),
        *networks_for(data, Settings(models=asked)),
    ]
    assert [s.dynamics for s in made] == ["dahl/field", "stops", "dahl"]


def test_friction_and_offset_by_device(data: Dataset) -> None:
    single = structures_for(data, Settings(lag="none"))
    pair = structures_for(
        replace(data, device="coaxial", elements=data.elements * 2), Settings(lag="none")
    )
    assert all(s.friction and s.offset for s in single)
    assert not any(s.friction or s.offset for s in pair)
    asked = structures_for(data, Settings(lag="none", friction=False, offset=False))
    assert not any(s.friction or s.offset for s in asked)


def test_settings_without_what_changes_no_figure() -> None:
    assert "workers" not in Settings().to_dict()
    assert Settings(workers=1).to_dict() == Settings(workers=7).to_dict()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (Settings(models=("binghm",)), "Did you mean bingham?"),
        (Settings(models=()), "no model was given"),
        (Settings(models=("bingham/cube",)), "unknown yield stress 'cube'"),
        (Settings(lag="late"), "unknown stage 'late'"),
        (Settings(test=0.0), "a test share of 0.0"),
        (Settings(test=0.95), "a test share of 0.95"),
        (Settings(test=float("nan")), "a test share of nan"),
        (Settings(test=("nothing*",)), "the test pattern 'nothing*' matches none of 1 logs"),
        (Settings(test=("*",)), "all logs are held out"),
        (Settings(models=("quadratic",), lag="none", blocks=1), "1 blocks"),
    ],
)
def test_what_cannot_be_done_is_said(data: Dataset, settings: Settings, words: str) -> None:
    with pytest.raises(SettingError) as caught:
        compare(data, settings)
    assert words in str(caught.value)


def test_data_that_cannot_be_fitted(data: Dataset) -> None:
    flat = replace(data, elements=(Element(data.elements[0].field, np.zeros(data.rows)),))
    with pytest.raises(CheckError):
        compare(flat)


def test_an_entry_that_is_not_there(compared: Comparison) -> None:
    with pytest.raises(SettingError, match="Choose one of"):
        compared.entry("rbfm-5")


@pytest.mark.slow
def test_notes_name_bounds_and_what_is_not_identified(with_many_kernels: Comparison) -> None:
    entry = with_many_kernels.entry("rbfm-60")
    assert entry.outcome.rank < entry.outcome.unknowns
    assert any("not identified" in note or "trade off" in note for note in entry.notes)


@pytest.mark.slow
def test_rows_held_out_at_one_field_recommend_no_switch() -> None:
    """A switch that is right at the one field held out is wrong at the others, which the training rows tell."""
    t = np.arange(6000) / 1000
    currents = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    parts = [(level, 0.5 * 1000 * level) for level in currents] + [(0.5, 500.0)]
    logs = [
        recording_from_arrays(
            {
                "field": np.full(t.size, level),
                "slip": 0.1 * np.sin(9 * t + k),
                "effort": size * np.tanh(50 * np.sin(9 * t + k))
                + 20 * np.sin(t * 70 + k) * (level != 0.5),
            },
            rate=1000.0,
            units={"field": "A", "slip": "m/s", "effort": "N"},
            name=f"log{k}",
        )
        for k, (level, size) in enumerate(parts)
    ]
    found = compare(build_dataset(logs), Settings(models=("on-off", "bingham"), test=("log5",)))
    switch = found.entry("on-off")
    assert any(finding.subject == ONE_FIELD for finding in found.findings)
    assert not switch.sound
    assert "errs on the training rows by" in switch.notes[-1]
    assert found.recommended == "bingham"


# --- memory that a log cannot tell ------------------------------------------------------------------------------------


def with_dahl(travel: float, rows: int, logs: int = 1) -> Dataset:
    """SYNTHETIC: one Dahl state in each of several stretches, settled at the start, and nothing else."""
    t = 1e-3 * np.arange(float(rows))
    clock_one = Clock(t, (Span(0, rows, 1e-3),))
    rng = np.random.default_rng(5)
    slips, fields, efforts = [], [], []
    for k in range(logs):
        slip = np.cos(2 * np.pi * 2.1 * t + 0.3 * k) + 0.5 * np.cos(2 * np.pi * 5.3 * t)
        state = stage_named("dahl").respond(
            SlipAndStrength(slip, np.ones(rows)), clock_one, [travel], slice(None)
        )[0]
        field = np.repeat(rng.uniform(0.0, 2.0, rows // 50 + 1), 50)[:rows]
        efforts.append((1.0 + field) * state + 0.2 * slip + 0.01 * rng.normal(size=rows))
        slips.append(slip)
        fields.append(field)
    spans = tuple(Span(k * rows, (k + 1) * rows, 1e-3) for k in range(logs))
    element = Element(np.concatenate(fields), np.concatenate(slips))
    clock = Clock(np.tile(t, logs), spans)
    return Dataset("single", (element,), np.concatenate(efforts), clock, Units("N", "A", "m/s"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("data", "note"),
    [
        (with_dahl(1e-6, 3000), "at a bound: r_1"),
        (with_dahl(0.5, 400, logs=6), "stretches are too short to forget the start of r_1"),
    ],
)
def test_a_memory_that_the_log_cannot_tell_is_one_clear_note(data: Dataset, note: str) -> None:
    asked = Settings(
        models=("bingham/forward+dahl",), lag="none", friction=False, offset=False, workers=1
    )
    (entry,) = compare(data, asked).entries
    assert [said for said in entry.notes if note in said], entry.notes


@pytest.mark.slow
def test_what_is_no_data_set_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    write_synthetic_log(path, 1.0)
    log = read(path)
    for value, kind in ((log, "Recording"), ([log], "list"), (path, type(path).__name__)):
        with pytest.raises(SettingError, match=f"a data set cannot be a {kind}"):
            compare(value)  # pyright: ignore[reportArgumentType]
    with pytest.raises(SettingError, match=r"a recording cannot be a .*Path. Give erclutch.read"):
        build_dataset([path])  # pyright: ignore[reportArgumentType]
    with pytest.raises(SettingError, match="a model cannot be a Comparison"):
        recalibrate(compare(build_dataset(log), Settings(("bingham",), "none")), build_dataset(log))  # pyright: ignore


def test_one_model_may_be_a_text_and_a_seed_is_not_below_zero() -> None:
    assert Settings("bingham") == Settings(("bingham",)) == Settings(["bingham"])  # pyright: ignore
    with pytest.raises(SettingError, match=r"--seed -1\. Give 0 or more"):
        Settings(seed=-1)
