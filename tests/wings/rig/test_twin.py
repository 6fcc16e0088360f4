"""The twin as a user meets it: parameters, steps, scenarios, log files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.errors import ErclutchError, RunError, SettingError
from erclutch.logs import log_writer
from erclutch.logs.log_writer import write_log
from erclutch.wings.rig.interface import RigCommand
from erclutch.wings.rig.twin.kernel import advance
from erclutch.wings.rig.twin.parameters import SECTIONS, default_rig, load_rig
from erclutch.wings.rig.twin.sampled_rows import sense
from erclutch.wings.rig.twin.scenarios import COLUMNS, SCENARIOS, SINGLE_COLUMNS, prepare
from erclutch.wings.rig.twin.twin import PERIOD, Twin, substeps
from tests.support.command import good, run

ROOT = Path(__file__).resolve().parents[3]

# --- parameters -------------------------------------------------------------------------------------------------------


def test_every_parameter_has_a_source_and_lies_in_its_range() -> None:
    rig = default_rig()
    assert set(rig.entries) == set(SECTIONS)
    for section, entries in rig.entries.items():
        for name, entry in entries.items():
            assert entry.source in {"paper", "catalogue", "assumed", "calibrated"}, (section, name)
            assert (
                (entry.source == "calibrated")
                == (entry.interval is not None)
                == (entry.start is not None)
            )
            assert entry.low <= entry.value <= entry.high or name == "backlash", (section, name)
            assert entry.meaning


def test_every_range_names_its_source_or_is_told_to_be_assumed() -> None:
    page = ROOT / "docs" / "decisions" / "measurements" / "0006-calibration.md"
    table = page.read_text(encoding="utf-8").partition("## Where the ranges come from")[2]
    rows = [line.split("|")[1:3] for line in table.splitlines() if line.startswith("| `")]
    told = {(section, name) for section, name in _named(parameters for parameters, _ in rows)}
    ranged = {
        (section, name) for section, entries in default_rig().entries.items() for name in entries
    }
    assert told == ranged
    for parameters, source in rows:
        assert re.search("assumed|doi|test", source, re.IGNORECASE), parameters


def _named(cells: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Section and name of each parameter of some cells: "`a` and `b`: `name`, `name`; `c`: `name`"."""
    for cell in cells:
        for part in cell.split(";"):
            sections, _, names = part.partition(":")
            for section in re.findall(r"`(\w+)`", sections):
                yield from ((section, name) for name in re.findall(r"`(\w+)`", names))


@pytest.mark.slow
def test_what_only_the_twin_knows_is_no_signal_of_a_log(tmp_path: Path) -> None:
    """The speed of a brake is that of its encoder; `true_theta_dot` says slip too, but no sensor gives it."""
    brake = prepare("brake", seconds=0.5)
    path = write_log(
        tmp_path / "a.csv", brake.names, brake.chunks(), brake.about(), rows=brake.rows
    )
    signals = erclutch.read(path).signals
    assert {"field", "position", "effort"} <= {*signals}
    assert "slip" not in signals


def test_a_rig_file_changes_what_it_names(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('[drive]\ninertia = 1e-3\n[screw]\nlead = { value = 0.005, unit = "m" }\n')
    rig = load_rig(path)
    assert rig.value("drive.inertia") == 1e-3
    assert rig.value("screw.lead") == 0.005
    assert rig.value("screw.stiffness") == default_rig().value("screw.stiffness")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[drive]\ninertia = -1e-3\n", "drive.inertia is -0.001 kg*m^2, it must be above 0"),
        ("[drive]\ninertia = 0\n", "must be above 0"),
        ("[drive]\ninertia = nan\n", "drive.inertia is nan"),
        ("[drive]\ninertia = true\n", "drive.inertia is True"),
        ('[drive]\ninertia = "heavy"\n', "drive.inertia is 'heavy'"),
        ("[drive]\ninertai = 1e-3\n", "Did you mean drive.inertia"),
        ("[wheels]\nradius = 1\n", "there is no section [wheels]"),
        ('[screw]\nlead = { value = 5, unit = "mm" }\n', "screw.lead is given in 'mm'"),
        ('[screw]\nlead = { value = 0.005, Unit = "mm" }\n', "key 'Unit'. Did you mean unit?"),
        ("[clutch]\nouter_radius = 0.005\n", "is not above the inner radius"),
        ("[screw]\nbreakaway = 0.9\n", "is 0.9 times Coulomb friction"),
        ("[excitation]\nsines = 1.5\n", "A share is at most 1"),
        ("[excitation]\nlowest = 200.0\n", "is not below excitation.highest"),
        ("[fluid]\nviscosity = { value = 0.1, range = 3 }\n", "unreadable range"),
        ("[fluid]\nviscosity = { value = 0.1, range = [0.2, 0.1] }\n", "Give the lower end first"),
        ("[drive\n", "cannot be read"),
        (f"[clutch]\ninner_radius = 1{'0' * 400}\n", "a whole number in it has more than 64 bits"),
        (
            f"[clutch]\ninner_radius = 0x{'f' * 4000}\n",
            "a whole number in it has more than 64 bits",
        ),
        (f"[clutch]\ninner_radius = {'1' * 5000}\n", "a whole number in it has too many digits"),
        (
            f"[clutch]\ngap = {{ value = 1e-3, range = [1, 1{'0' * 400}] }}\n",
            "a whole number in it has more than 64",
        ),
        (f"a{'.a' * 5000} = 1\n", "a name in it has more than 100 parts"),
        (
            "[clutch]\nouter_radius = 1e300\ninner_radius = 1e299\n",
            "beyond its range 0.012 to 0.05",
        ),
        ("[clutch]\ngap = { value = 1e-9 }\n", "beyond its range 0.0002 to 0.002"),
    ],
)
def test_a_rig_that_cannot_be(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(SettingError) as caught:
        load_rig(path)
    assert said in str(caught.value)
    assert "bad.toml" in str(caught.value) or "must be" in said


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_a_rig_whose_numbers_grow_without_end(tmp_path: Path) -> None:
    path = tmp_path / "wild.toml"
    path.write_text("[screw]\nrotor_inertia = 6e-9\n")
    for name in ("sine", "tracking-fast", "brake"):
        with pytest.raises(
            SettingError, match=r"wild\.toml: the TWIN's numbers grow beyond 1e\+15 within 0\.2 s"
        ):
            prepare(name, rig=load_rig(path), seconds=0.2).recording()


# --- steps ------------------------------------------------------------------------------------------------------------


def drive(twin: Twin, rows: int) -> list[tuple[float, ...]]:
    out = []
    for i in range(rows):
        m = twin.sense()
        out.append((m.time, m.theta, m.alpha_raw, m.alpha_rotary, m.torque))
        twin.command(
            RigCommand(
                E1=0.3 if i % 60 < 30 else 0.0, E2=0.2 if i % 60 >= 30 else 0.0, motor_torque=0.1
            )
        )
        twin.step()
    return out


@pytest.mark.slow
def test_the_same_seed_gives_the_same_run() -> None:
    assert drive(Twin(seed=3, speed=20.0), 300) == drive(Twin(seed=3, speed=20.0), 300)
    assert drive(Twin(seed=3, speed=20.0), 300) != drive(Twin(seed=4, speed=20.0), 300)


def test_a_step_by_hand_has_the_bits_of_the_compiled_functions() -> None:
    """The twin keeps their machine code for its own parameters."""
    for single in (False, True):
        twin = Twin(seed=1, single=single, locked=single, speed=3.0)
        state, row = twin._state.copy(), np.zeros(7)
        noise = np.random.default_rng(1).standard_normal(2)
        twin.command(RigCommand(0.3, 0.0, 0.05))
        twin.step()
        steps = substeps(twin.rig)
        advance(state, twin._parts, 0.3, 0.0, 0.05, single, PERIOD / steps, steps)
        sense(state, twin._parts, noise[1], row)
        assert state.tobytes() == twin._state.tobytes()
        read = twin.sense()
        assert [read.theta, read.alpha_raw, read.alpha_rotary, read.torque] == row[3:7].tolist()


def test_ch1_drives_the_table_forward_and_ch2_back() -> None:
    for command, sign in (
        (RigCommand(E1=0.5, motor_torque=0.15), 1),
        (RigCommand(E2=0.5, motor_torque=0.15), -1),
    ):
        twin = Twin(speed=30.0)
        for _ in range(200):
            twin.command(command)
            twin.step()
        assert sign * twin.sense().alpha_raw > 1e-3


def test_what_the_supply_would_not_do_is_not_done_and_counted() -> None:
    twin = Twin()
    twin.command(RigCommand(E1=0.2, E2=0.3))
    assert twin.events == {"both fields": 1}
    twin.command(RigCommand(E1=float("nan"), motor_torque=float("inf")))
    assert twin.events["not finite"] == 2
    twin.command(RigCommand(E1=7.0, E2=-1.0, motor_torque=100.0))
    assert twin.events["beyond limit"] == 3
    twin.step()
    assert all(np.isfinite(v) for v in vars(twin.sense()).values())


def test_sensing_does_not_disturb_and_closing_takes_the_fields_away() -> None:
    with Twin(seed=1) as twin:
        assert twin.sense() == twin.sense()
        twin.command(RigCommand(E1=0.5, motor_torque=0.1))
    assert twin._command == RigCommand()


# --- scenarios --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_every_scenario_runs_and_repeats(name: str) -> None:
    first, again, other = (prepare(name, seconds=2.0, seed=s).columns() for s in (1, 1, 2))
    assert list(first) == [c for c, _ in (SINGLE_COLUMNS if SCENARIOS[name].single else COLUMNS)]
    for column, (_, values) in first.items():
        assert values.shape == (2000,)
        assert np.isfinite(values).all(), column
        np.testing.assert_array_equal(values, again[column][1])
    effort = "effort" if SCENARIOS[name].single else "T"
    assert not np.array_equal(first[effort][1], other[effort][1])
    if not SCENARIOS[name].single:
        assert not np.any((first["E1"][1] > 0) & (first["E2"][1] > 0))


@pytest.mark.slow
def test_scenarios_are_what_the_paper_says() -> None:
    zero = prepare("zero-field", seconds=5.0).columns()
    assert not zero["E1"][1].any()
    assert not zero["E2"][1].any()
    assert zero["motor_torque"][1].min() >= 0.0
    held = prepare("zero-motion", seconds=3.0).columns()
    assert np.ptp(held["alpha"][1]) == 0.0
    trained = prepare("training", seconds=20.0).columns()
    assert 0.04 <= trained["motor_torque"][1].min() < trained["motor_torque"][1].max() <= 0.15
    assert np.abs(trained["table"][1]).max() < default_rig().value("screw.half_stroke")
    assert prepare("training").rows == 290_000


@pytest.mark.slow
def test_a_rig_file_sets_what_the_paper_leaves_open_of_a_run() -> None:
    rig = default_rig().changed(
        {"excitation.half_sine_high": 0.1, "excitation.held_peakedness": 0.2}
    )
    usual = prepare("zero-field", seconds=2.0).columns()["motor_torque"][1].max()
    weaker = prepare("zero-field", rig=rig, seconds=2.0).columns()["motor_torque"][1].max()
    assert weaker <= 0.1 < usual
    held = prepare("zero-motion", rig=rig, seconds=2.0).columns()["E1"][1].mean()
    assert held > prepare("zero-motion", seconds=2.0).columns()["E1"][1].mean()
    trained, usual_training = (
        prepare("training", rig=r, seconds=1.0).columns()["E1"][1] for r in (rig, None)
    )
    np.testing.assert_array_equal(trained, usual_training)


@pytest.mark.slow
def test_backlash_parts_the_two_encoders_and_none_does_not() -> None:
    def apart(name: str) -> float:
        c = prepare(name, seconds=6.0).columns()
        lead = default_rig().value("screw.lead")
        return float(np.ptp(c["table"][1] - c["alpha_rotary"][1] * lead / (2 * np.pi)))

    assert apart("encoders") < 2e-5
    assert apart("encoders-backlash") > 8e-5


@pytest.mark.slow
def test_twenty_minutes_of_tracking_warm_the_clutches_as_in_the_paper() -> None:
    last = np.zeros((1, len(COLUMNS)))
    for last in prepare("temperature").chunks():  # noqa: B007
        pass
    assert last[-1, -1] == pytest.approx(0.391, abs=0.01)  # the paper: around 0.4 K


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("tarining", {}, "there is no scenario 'tarining'"),
        ("test", {"seconds": 0.0}, "0 s with seed 0"),
        ("test", {"seconds": 1e9}, "Give 0.1 to"),
        ("test", {"seed": -1}, "a seed of 0 or more"),
    ],
)
def test_a_run_that_cannot_be(name: str, options: dict[str, float], said: str) -> None:
    with pytest.raises(SettingError, match=said):
        prepare(name, **options)  # type: ignore[arg-type]


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("suffix", [".parquet", ".csv", ".mat"])
def test_a_log_of_the_twin_reads_back(tmp_path: Path, suffix: str) -> None:
    run = prepare("test", seconds=1.0, seed=5)
    path = write_log(tmp_path / f"log{suffix}", COLUMNS, run.chunks(), run.about(), rows=run.rows)
    log = erclutch.read(path, device="coaxial")
    expected = run.columns()
    for name in ("E1", "E2", "theta", "alpha", "T"):
        np.testing.assert_allclose(log.signals[name], expected[name][1], rtol=1e-8, atol=1e-9)
    assert log.period == pytest.approx(1e-3)
    assert b"TWIN" in path.read_bytes() or suffix == ".mat"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_too_little_space_is_said_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        log_writer.shutil, "disk_usage", lambda _: type("Usage", (), {"free": 1000})()
    )
    run = prepare("training")
    with pytest.raises(RunError, match="MB are needed"):
        write_log(tmp_path / "big.csv", COLUMNS, run.chunks(), run.about(), rows=run.rows)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_an_interrupted_log_leaves_nothing(tmp_path: Path) -> None:
    run = prepare("test", seconds=20.0)

    def interrupted(share: float) -> None:
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_log(
            tmp_path / "a.parquet",
            COLUMNS,
            run.chunks(),
            run.about(),
            rows=run.rows,
            progress=interrupted,
        )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["log.xyz", "none/log.csv"])
def test_a_place_that_cannot_be(tmp_path: Path, name: str) -> None:
    run = prepare("test", seconds=0.2)
    with pytest.raises(ErclutchError):
        write_log(tmp_path / name, COLUMNS, run.chunks(), run.about(), rows=run.rows)


def test_commands_never_replace_a_file_unasked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from erclutch.cli.commands.table import table
    from erclutch.wings.live.commands.tune import tune
    from erclutch.wings.paper.commands.calibrate_twin import calibrate_twin
    from erclutch.wings.rig.commands.simulate import simulate

    monkeypatch.chdir(tmp_path)
    commands = {  # each with a name of the kind that it writes
        "control.csv": partial(simulate, "test"),
        "control.tex": partial(table, tmp_path),
        "control.toml": calibrate_twin,
    }
    for name, command in commands.items():
        mine = tmp_path / name
        mine.write_text("mine")
        with pytest.raises(RunError, match="there is a file already"):
            command(out=mine)
        assert mine.read_text() == "mine"
    with pytest.raises(RunError, match="there is a file already"):
        tune(tmp_path, out=tmp_path)
    assert (tmp_path / "control.toml").read_text() == "mine"


@pytest.mark.slow
def test_the_command(tmp_path: Path) -> None:
    assert "TWIN test: 2,000 rows" in good(
        "simulate", "test", "--seconds", "2", "--out", "t.csv", cwd=tmp_path
    )
    assert (tmp_path / "t.csv").read_text().startswith("# TWIN: ")
    for bad in (
        ["nope"],
        ["--out", "x.csv"],
        ["test", "--rig-file", "none.toml"],
        ["test", "--seconds", "-1"],
        ["test", "--out", "x.doc"],
    ):
        done = run("simulate", *bad, cwd=tmp_path)
        assert done.code == 2
        assert done.error.startswith("error: ")
