"""Two logs on two clocks become one: offset, drift, what is refused, and what is written (SYNTHETIC)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import make_interp_spline

import erclutch
from erclutch.errors import ErclutchError
from erclutch.logs.synthetic import synthetic_log
from tests.support.command import refused

pytestmark = pytest.mark.slow

OFFSET, DRIFT = -7.3e-3, 40e-6
_COLUMNS = synthetic_log(30.0, 0)
_TIME, _SLIP = _COLUMNS["time"][1], _COLUMNS["slip"][1]


def _a(noise: float = 0.5) -> pd.DataFrame:
    """Log A at 1 kHz: field and slip, with noise of some 2 % of the slip."""
    rng = np.random.default_rng(1)
    slip = _SLIP + noise * rng.standard_normal(_TIME.size)
    return pd.DataFrame(
        {"time [s]": _TIME, "field [V]": _COLUMNS["field"][1], "slip [rad/s]": slip}
    )


def _b(rate: float = 1000.0, seed: int = 0, *, offset: float = OFFSET) -> pd.DataFrame:
    """Log B on its own clock: torque, and the speed by another sensor in rpm with a gain and an offset."""
    rng = np.random.default_rng(seed + 2)
    time = np.arange(int(29.0 * rate)) / rate
    true = np.clip((time - offset) / (1 + DRIFT), 0.0, _TIME[-1])
    slip = _SLIP if seed == 0 else synthetic_log(30.0, seed)["slip"][1]
    speed = 9.8 * make_interp_spline(_TIME, slip)(true) + 4.0 + 5.0 * rng.standard_normal(time.size)
    return pd.DataFrame(
        {
            "time [s]": time,
            "torque [N*m]": np.interp(true, _TIME, _COLUMNS["torque"][1]),
            "rpm": speed,
        }
    )


@pytest.mark.parametrize("rate", [1000.0, 200.0])
def test_a_made_up_offset_and_drift_are_found(rate: float) -> None:
    found = erclutch.align(_a(), _b(rate), on=("slip", "rpm"))
    match = found.matches[0]
    assert found.offset == pytest.approx(OFFSET + DRIFT * match.origin, abs=1e-4)
    assert found.drift_ppm == pytest.approx(40.0, abs=2.0)
    assert match.drift_interval[0] < DRIFT < match.drift_interval[1]
    torque, time = found.joined.columns["torque"], found.joined.columns["time"]
    assert np.std(torque - np.interp(time, _TIME, _COLUMNS["torque"][1])) < 0.1 * np.std(torque)
    assert found.joined.units["torque"] == "N*m"


def test_either_log_may_be_first() -> None:
    there, back = (
        erclutch.align(_a(), _b(200.0), on=("slip", "rpm")),
        erclutch.align(_b(200.0), _a(), on=("rpm", "slip")),
    )
    assert there.table()["drift_ppm"].tolist() == [pytest.approx(there.drift_ppm)]
    assert there._repr_html_().count("<tr") == 2
    assert there.to_frame().shape == (there.joined.rows, len(there.joined.columns) - 1)
    middle = there.matches[0].on_b(np.array([15.0]))
    assert back.matches[0].on_b(middle) == pytest.approx(15.0, abs=1e-6)


def test_a_gap_and_a_restart_of_the_clock() -> None:
    b = _b()
    b = b[(b["time [s]"] < 12.0) | (b["time [s]"] > 14.0)].reset_index(drop=True)
    gap = erclutch.align(_a(), b, on=("slip", "rpm"))
    assert gap.offset == pytest.approx(OFFSET, abs=1e-4)
    assert not np.any((gap.joined.columns["time"] > 12.2) & (gap.joined.columns["time"] < 13.8))
    b.loc[b["time [s]"] > 13.0, "time [s]"] -= 14.0
    first, second = erclutch.align(_a(), b, on=("slip", "rpm")).matches
    assert first.offset == pytest.approx(OFFSET, abs=2e-4)
    assert second.on_b(np.array([20.0])) == pytest.approx(
        20.0 * (1 + DRIFT) + OFFSET - 14.0, abs=2e-4
    )


def _sine(shift: float) -> pd.DataFrame:
    noise = 0.1 * np.random.default_rng(int(1e3 * shift)).standard_normal(_TIME.size)
    return pd.DataFrame({"time [s]": _TIME, "x [mm]": np.sin(4 * np.pi * (_TIME + shift)) + noise})


def test_what_cannot_be_matched_is_refused() -> None:
    a = _a()
    for other, on, said in (
        (_b(seed=5), ("slip", "rpm"), "nothing correlates"),
        (_b().iloc[:400], ("slip", "rpm"), "too short"),
        (_b(), (), "share no column"),
        (_b(), ("slip", "speed"), "no column 'speed'"),
        (_b(), ("slip", "time"), "the log's own time"),
        (_b().assign(rpm=1.0), ("slip", "rpm"), "never changes"),
        (a, "slip", "the same log"),
    ):
        with pytest.raises(ErclutchError, match=said):
            erclutch.align(a, other, on=on)


def test_a_periodic_signal_needs_to_be_told_about_where() -> None:
    with pytest.raises(ErclutchError, match=r"repeats itself.*--near"):
        erclutch.align(_sine(0.0), _sine(0.1))
    found = erclutch.align(_sine(0.0), _sine(0.1), near=-0.09)
    assert found.matches[0].on_b(np.array([15.0])) == pytest.approx(14.9, abs=1e-3)
    assert set(found.joined.columns) == {"time", "x", "x_B"}
    for every in (
        1,
        2,
    ):  # a slower B is searched the other way round, and its offsets are told as any other's
        slower = _sine(0.1)[::every].reset_index(drop=True)
        with pytest.raises(
            ErclutchError, match=r"--near 30 ms lies between .*, (-9\d|-10\d).* ms and 1[45]\d.* ms"
        ):
            erclutch.align(_sine(0.0), slower, near=0.03)


def test_a_slow_signal_is_matched_about_where_the_user_says() -> None:
    """A position that wanders: too few independent samples to find it anywhere, enough to find it near a place."""
    time = 1e-3 * np.arange(20_000)
    speed = (
        np.convolve(
            np.random.default_rng(1).standard_normal(20_799), np.hanning(800) / 19.0, "valid"
        )
        - 0.5
    )
    position = 100.0 * np.cumsum(1e-3 * speed)
    inner = slice(3000, 18_000, 2)
    a = pd.DataFrame({"time [s]": time, "x [rad]": position})
    b = pd.DataFrame({"time [s]": time[inner] * (1.0 + 100e-6) + 1.234, "x [rad]": position[inner]})
    found = erclutch.align(a, b, near=1.2)
    assert found.matches[0].on_b(np.array([10.0])) == pytest.approx(11.235, abs=1e-4)
    with pytest.raises(
        ErclutchError,
        match=r"about as well.* so slowly that the overlap holds \d+ independent samples",
    ):
        erclutch.align(a, b)
    with pytest.raises(ErclutchError, match=r"astray, to a drift of \d+ ppm, 5000 at most"):
        erclutch.align(a, b, near=6.0)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("ending", ["csv", "parquet", "mat"])
def test_what_is_written_is_read_again(ending: str, tmp_path: Path) -> None:
    a = _a()
    a["time [s]"] += 1.7e9  # since 1970: a text file would round it to seconds
    b = _b(200.0)
    found = erclutch.align(a, b, on=("slip", "rpm"))
    log = erclutch.read(
        found.write(tmp_path / f"joined.{ending}"),
        {"effort": "torque", "slip": "slip", "field": "field"},
    )
    assert log.rows == found.joined.rows
    assert log.period == pytest.approx(1e-3, rel=1e-6)
    assert log.units["effort"] == "N*m"


def test_what_was_done_is_said() -> None:
    found = erclutch.align(
        _a(), _b(200.0).rename(columns={"torque [N*m]": "field [N*m]"}), on=("slip", "rpm")
    )
    match = found.matches[0]
    half = 0.5e3 * (match.offset_interval[1] - match.offset_interval[0])
    wide = 0.5e6 * (match.drift_interval[1] - match.drift_interval[0])
    said = f"offset {1e3 * match.offset:.4f} ms (+- {half:.4f}) at {match.origin:.6g} s, "
    said += f"drift {1e6 * match.drift:.2f} ppm (+- {wide:.2f})"
    lost = _TIME.size - found.joined.rows
    assert lost > 900
    notes = "\n".join(found.joined.notes)
    assert f"by slip and rpm: {said}" in notes
    assert (
        f"{lost:,} rows of DataFrame A left out: DataFrame B has none there, or none around a filter's reach"
        in notes
    )
    assert "columns of DataFrame B renamed: field is field_B" in notes
    assert set(found.joined.columns) == {"time", "field", "slip", "field_B", "rpm"}


def test_names_that_cannot_be_taken() -> None:
    a, b = _a(), _b()
    for on, said in (
        ((), "share no column"),
        (("slip", "rpm", "x"), "--on has 3 names"),
        (("rpm", "slip"), "no column 'rpm'"),
    ):
        with pytest.raises(ErclutchError, match=said):
            erclutch.align(a, b, on=on)
    twice = pd.concat([a[:20_000], a[:10_000]], ignore_index=True)
    with pytest.raises(
        ErclutchError,
        match=r"the clock restarts 1 times.*Give the log whose clock runs through first",
    ):
        erclutch.align(twice, b, on=("slip", "rpm"))


def test_an_angle_that_starts_again_is_brought_over_along_the_shorter_way() -> None:
    """The jump from a full turn to 0 was joined as a motion backwards, smeared over the reach of a filter."""
    a = _a().iloc[::4].reset_index(drop=True)
    b = _b()
    speed = 9.0  # rad/s
    on_a = (b["time [s]"].to_numpy() - OFFSET) / (1 + DRIFT)
    joined = erclutch.align(
        a,
        b.assign(**{"theta [deg]": np.degrees(np.mod(speed * on_a, 2.0 * np.pi))}),
        ("slip", "rpm"),
    ).joined
    turned = np.radians(joined.columns["theta"])
    apart = np.exp(1j * (turned - speed * joined.columns["time"]))
    assert np.abs(np.angle(apart)).max() < 0.02
    assert turned.min() >= 0.0
    assert np.ptp(turned) <= 2.0 * np.pi


@pytest.mark.parametrize("options", [("--out", "a.csv"), ("--out", "ab.csv", "--picture", "a.png")])
def test_no_log_is_written_over(tmp_path: Path, options: tuple[str, ...]) -> None:
    """With --force the joined rows, or the numbers of a picture, took the place of a log of the user."""
    for name, log in (("a.csv", _a()), ("b.csv", _b())):
        log.iloc[:50].to_csv(tmp_path / name, index=False)
    before = (tmp_path / "a.csv").read_bytes()
    error = refused("align", "a.csv", "b.csv", *options, "--force", cwd=tmp_path)
    assert "a.csv: this is one of the logs" in error
    assert (tmp_path / "a.csv").read_bytes() == before
