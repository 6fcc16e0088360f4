"""Recordings: whole after every end, short of 0.1 s at most after a kill, and read like any log."""

from __future__ import annotations

import errno
import json
import os
import resource
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader

from erclutch.errors import ErclutchError
from erclutch.logs import read, read_table
from erclutch.signals.channels import channels_of
from erclutch.signals.device import Units
from erclutch.wings.live.layout import EVENT_BITS, FRAME, HEADER
from erclutch.wings.live.recording.mcap_file import (
    FrameFile,
    RecordingError,
    finish_torn,
    partial_of,
)
from erclutch.wings.live.recording.recorder import FrameRecorder
from erclutch.wings.live.recording.recordings import Recordings
from erclutch.wings.live.ring import RingError, RingInfo, RingReader, State, make_ring
from tests.support.command import run
from tests.support.examples import examples

pytestmark = pytest.mark.timed

INFO = RingInfo(
    model="fnn-16", digest="ab" * 32, start_ns=10**12, start_unix_ns=1_700_000_000 * 10**9
)


def write(path: Path, frames: Any, info: RingInfo = INFO, each: int = 40) -> Path:
    file = FrameFile(path, info)
    for at in range(0, len(frames), each):
        file.write(frames[at : at + each])
    file.close()
    return path


def write_all(file: FrameFile, frames: Any, chunks: Iterable[int]) -> None:
    for at in chunks:
        file.write(frames[at : at + 40])


def sequence(path: Path) -> Any:
    return read_table(path).columns["seq"].astype(int)


@pytest.mark.slow
def test_a_recording_says_units_model_and_origin(tmp_path: Path, frames: Any) -> None:
    table = read_table(write(tmp_path / "a.mcap", frames))
    assert table.units["theta_dot"] == "rad/s"
    assert table.units["torque"] == "N*m"
    assert '"model_digest": "' + "ab" * 32 in table.metadata["erclutch"]
    assert table.origin == "TWIN"
    for name in FRAME.names or ():
        assert np.array_equal(table.columns[name], frames[name].astype(float), equal_nan=True)


@pytest.mark.slow
def test_a_recording_of_one_device_is_a_log_of_one_device(tmp_path: Path, ring_writer: Any) -> None:
    """One field, one slip, one effort, in the device's units: read without a word about columns."""
    channels = channels_of("single", Units("N", "V", "m/s"), motor=False)
    ring = make_ring(tmp_path / "ring", RingInfo(origin="HARDWARE", capacity=64, channels=channels))
    writer, frames = ring_writer(ring), np.zeros(60, FRAME)
    frames["theta_dot"], frames["field1"], frames["torque"] = (
        0.1 * np.sin(np.arange(60)),
        2.0,
        -900.0,
    )
    frames["time_ns"] = 10**12 + np.arange(60) * 1_000_000
    for frame in frames:
        writer.write(frame)
    recorder = FrameRecorder(ring, tmp_path / "a.mcap", -1)
    recorder.close()
    table = read_table(tmp_path / "a.mcap")
    assert list(table.columns) == [
        *("seq", "time_ns", "position", "slip", "field", "effort", "estimate", "reference"),
        *("flags", "events", "lateness_ns", "step_ns"),
    ]
    log = read(tmp_path / "a.mcap", device="single")
    assert {name: log.units[name] for name in ("slip", "field", "effort")} == {
        "slip": "m/s",
        "field": "V",
        "effort": "N",
    }
    assert np.array_equal(log.signals["slip"], frames["theta_dot"])


assert HEADER.fields is not None
_TABLE = HEADER.fields["channel"][1]


@pytest.mark.slow
@settings(
    max_examples=examples(60),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(at=st.integers(_TABLE - 8, _TABLE + 300), put=st.binary(min_size=1, max_size=24))
def test_a_damaged_table_of_channels_is_refused_or_sound(
    tmp_path: Path, at: int, put: bytes
) -> None:
    path = tmp_path / "ring"
    path.unlink(missing_ok=True)
    make_ring(path, RingInfo(capacity=4))
    with path.open("r+b") as file:
        file.seek(at)
        file.write(put)
    with suppress(RingError):
        reader = RingReader(path)
        names = reader.dtype.names or ()
        assert len(names) == len(set(names)) == len(reader.info.channels) + 6
        assert reader.latest(4).shape == (0,)
        reader.close()


@pytest.mark.slow
def test_a_measurement_has_no_label(tmp_path: Path, frames: Any) -> None:
    path = write(tmp_path / "a.mcap", frames, RingInfo(origin="HARDWARE"))
    assert read_table(path).origin == ""
    assert '"origin": "HARDWARE"' in read_table(path).metadata["erclutch"]


@pytest.mark.slow
def test_the_index_of_a_recording_is_that_of_the_format(tmp_path: Path, frames: Any) -> None:
    """The format's own reader finds all by index and checksum."""
    path = write(tmp_path / "a.mcap", frames)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert (summary.statistics.message_count, len(summary.chunk_indexes)) == (4000, 100)
        found = [message.data for _, _, message in reader.iter_messages()]
    assert b"".join(found) == frames.tobytes()
    data = path.read_bytes()
    for entry in summary.chunk_indexes:
        kind, length = struct.unpack_from("<BQ", data, entry.chunk_start_offset)
        assert (kind, length + 9) == (Opcode.CHUNK, entry.chunk_length)
        first = entry.chunk_start_offset + entry.chunk_length
        assert entry.message_index_offsets == {1: first}
        assert data[first + entry.message_index_length] in (Opcode.CHUNK, Opcode.DATA_END)
    (about,) = summary.metadata_indexes
    assert about.name == "erclutch"
    kind, length = struct.unpack_from("<BQ", data, about.offset)
    assert (kind, length + 9) == (Opcode.METADATA, about.length)


@pytest.mark.slow
def test_it_reads_as_the_same_data_from_parquet(tmp_path: Path, frames: Any) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = ("field1", "field2", "theta_dot", "alpha_dot", "torque")
    columns = {name: frames[name] for name in names} | {"time": np.arange(4000) * 1e-3}
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    labels = {
        "E1": "field1",
        "E2": "field2",
        "theta_dot": "theta_dot",
        "alpha_dot": "alpha_dot",
        "T": "torque",
    }
    one = read(write(tmp_path / "a.mcap", frames), device="coaxial")
    two = read(tmp_path / "a.parquet", labels, device="coaxial")
    assert (one.uniform, one.segments, one.origin) == (True, ((0, 4000),), "TWIN")
    for name in labels:
        assert np.array_equal(one.signals[name], two.signals[name])
    assert one.time == pytest.approx(two.time, abs=1e-9)


@pytest.mark.slow
def test_steps_without_a_sample_are_left_out_and_said(tmp_path: Path, frames: Any) -> None:
    frames = frames.copy()
    frames["torque"][1000:1003] = np.nan
    frames["events"][1000:1003] = EVENT_BITS["sample-lost"]
    recording = read(write(tmp_path / "a.mcap", frames), device="coaxial")
    assert recording.segments == ((0, 1000), (1000, 3997))
    assert "3 steps of the loop had no good sample: left out, the log cut there" in recording.notes
    frames["events"] = 0
    unexplained = read(write(tmp_path / "b.mcap", frames), device="coaxial")
    assert unexplained.segments == recording.segments
    assert any(note.startswith("column torque has 3 values missing") for note in unexplained.notes)


@pytest.mark.slow
def test_fit_and_inspect_take_a_recording(tmp_path: Path) -> None:
    """A run of the TWIN, recorded: fitted from MCAP it gives the model that it gives from Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from erclutch.cli import app
    from erclutch.runs.run_folder import read_run
    from erclutch.wings.rig.twin.scenarios import prepare

    columns = {name: values for name, (_, values) in prepare("test", seconds=8).columns().items()}
    frames = np.zeros(8000, FRAME)
    names = {
        "E1": "field1",
        "E2": "field2",
        "theta_dot": "theta_dot",
        "alpha_dot": "alpha_dot",
        "T": "torque",
    }
    for theirs, ours in zip(
        ("E1", "E2", "true_theta_dot", "true_alpha_dot", "T"), names.values(), strict=True
    ):
        frames[ours] = columns[theirs]
    frames["seq"] = np.arange(8000)
    frames["time_ns"] = 10**12 + frames["seq"] * 1_000_000
    write(tmp_path / "a.mcap", frames)
    table = pa.table(
        {"time": np.arange(8000) * 1e-3, **{theirs: frames[ours] for theirs, ours in names.items()}}
    )
    pq.write_table(table, tmp_path / "b.parquet")
    found: list[Any] = []
    for name in ("a.mcap", "b.parquet"):
        run = tmp_path / f"{name}.run"
        for words in (
            ["inspect"],
            ["fit", "--models", "bingham", "--lag", "lag", "--out", str(run)],
        ):
            app(
                [words[0], str(tmp_path / name), "--device", "coaxial", *words[1:]],
                exit_on_error=False,
            )
        found.append(read_run(run))
    assert found[0].body["logs"][0]["origin"] == "TWIN"
    one, two = (run.body["ranking"][0] for run in found)
    assert one["name"] == two["name"]
    assert one["test"]["rmse"] == pytest.approx(two["test"]["rmse"], rel=1e-6)


# --- torn files -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, frames: Any) -> bytes:
    return write(tmp_path_factory.mktemp("whole") / "a.mcap", frames[:2000]).read_bytes()


@pytest.mark.slow
@settings(
    max_examples=examples(25),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(share=st.floats(0.02, 0.95))
def test_a_torn_file_keeps_every_whole_chunk(tmp_path: Path, whole: bytes, share: float) -> None:
    """As it is read, and as the session finishes it after its recorder was killed."""
    torn, finished = tmp_path / "a.mcap.partial", tmp_path / "a.mcap"
    torn.write_bytes(whole[: int(share * len(whole))])
    finished.unlink(missing_ok=True)
    if share < 0.05:  # perhaps not one whole chunk
        with suppress(ErclutchError):
            read_table(torn)
        with suppress(RecordingError):
            finish_torn(torn, finished)
        return
    table = read_table(torn)
    assert any("not closed" in note for note in table.notes)
    assert not any("no checksum" in note for note in table.notes)
    assert table.origin == "TWIN"
    # A chunk is 40 frames and some 90 bytes a frame; nothing but the last one can be missing.
    assert np.array_equal(table.columns["seq"], np.arange(table.rows))
    assert table.rows >= min(2000, int(2000 * (share - 0.1)))
    path, last = finish_torn(torn, finished)
    assert path == finished
    assert not torn.exists()
    kept = sequence(path)
    assert np.array_equal(kept, np.arange(last + 1))
    assert table.rows - 40 <= kept.size <= table.rows
    assert not any("not closed" in note for note in read_table(path).notes)


def test_nothing_whole_is_said(tmp_path: Path, whole: bytes) -> None:
    torn = tmp_path / "a.mcap.partial"
    for data in (b"", whole[:400]):
        torn.write_bytes(data)
        with pytest.raises(RecordingError):
            finish_torn(torn, tmp_path / "a.mcap")
        assert [path.name for path in tmp_path.iterdir()] == [torn.name]


# --- the recorder -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_no_frame_is_lost_between_ring_and_file(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    loop = start_loop()
    recorder = FrameRecorder(loop.path, tmp_path / "a.mcap", loop.head - 1)
    limit = time.monotonic() + 1.0
    while time.monotonic() < limit:
        recorder.step()
        time.sleep(0.04)
    loop.stop()
    recorder.close()
    kept = sequence(tmp_path / "a.mcap")
    assert np.array_equal(kept, np.arange(kept[0], loop.head))
    assert kept.size > 800
    assert recorder.progress.lost == 0


@pytest.mark.slow
def test_a_recorder_that_came_too_late_says_what_it_lost(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    loop = start_loop(capacity=300)
    first = loop.head
    recorder = FrameRecorder(loop.path, tmp_path / "a.mcap", first - 1)
    time.sleep(0.1)
    recorder.step()
    time.sleep(0.8)
    recorder.close()
    kept = sequence(tmp_path / "a.mcap")
    missing = int(kept[0]) - first + int((np.diff(kept) - 1).sum())
    assert recorder.progress.lost == missing > 300


@pytest.mark.slow
def test_a_full_disk_ends_the_recording_with_a_whole_file(
    tmp_path: Path, frames: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk takes 60 kB in all, whatever was written before (blocks that are given back can be used again)."""
    path = tmp_path / "a.mcap"
    real = os.write
    room = 60_000

    def limited(file: int, data: Any) -> int:
        left = room - os.fstat(file).st_size
        if left <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(file, data[:left])

    file = FrameFile(path, INFO)
    monkeypatch.setattr(os, "write", limited)
    chunks = iter(range(0, 4000, 40))
    with pytest.raises(OSError, match="No space left"):
        write_all(file, frames, chunks)
    file.close()
    monkeypatch.undo()
    kept = sequence(path)
    assert path.stat().st_size <= room
    assert np.array_equal(kept, np.arange(kept.size))
    assert file.frames - 80 <= kept.size <= file.frames


@pytest.mark.slow
def test_the_recorder_says_that_the_disk_is_full_and_the_loop_goes_on(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """A file may grow to 40 kB (the system's own limit, set for the recorder's process)."""
    loop = start_loop()
    words = [
        sys.executable,
        "-m",
        "erclutch.wings.live.recording.recorder",
        str(loop.path),
        str(tmp_path / "a.mcap"),
    ]

    def small() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))

    done = subprocess.run(
        words, capture_output=True, text=True, timeout=30, preexec_fn=small, check=False
    )
    assert done.returncode == 3, done.stderr
    assert "it could not be written: File too large" in done.stdout.splitlines()[-1]
    assert sequence(tmp_path / "a.mcap").size > 100
    before, limit = loop.head, time.monotonic() + 10.0
    while loop.head <= before + 50:
        assert time.monotonic() < limit
        time.sleep(0.01)


@pytest.fixture
def small_recordings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Recorders whose file may grow to 150 kB, as on a disk that fills up."""
    started = Recordings._start

    def limited(self: Recordings, *words: Any) -> None:
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, before[1]))
        try:
            started(self, *words)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    monkeypatch.setattr(Recordings, "_start", limited)


@pytest.mark.slow
@pytest.mark.usefixtures("small_recordings")
def test_a_session_whose_recording_was_cut_does_not_end_as_if_all_were_well(tmp_path: Path) -> None:
    done = run(
        "live",
        "--no-model",
        "--headless",
        "--seconds",
        "4",
        "--record",
        "--json",
        "--folder",
        "logs",
        cwd=tmp_path,
    )
    assert done.code == 3
    assert json.loads(done.out)["exit"] == 3
    assert (
        "was ended by the disk: it could not be written: File too large"
        in done.error.splitlines()[-1]
    )
    (kept,) = (tmp_path / "logs").iterdir()
    assert sequence(kept).size > 100


@pytest.mark.slow
@pytest.mark.usefixtures("small_recordings")
def test_rounds_whose_log_was_cut_do_not_go_on(tmp_path: Path) -> None:
    words = (
        "--program",
        "learn",
        "--round",
        "4",
        "--seconds",
        "30",
        "--headless",
        "--json",
        "--folder",
        "logs",
    )
    done = run("live", *words, cwd=tmp_path)
    assert done.code == 3
    body = json.loads(done.out)
    assert (body["exit"], len(body["rounds"])) == (3, 1)
    assert "was ended by the disk" in body["ended"]


@pytest.mark.slow
def test_a_recording_that_lacks_frames_is_told(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    loop = start_loop(capacity=20)  # no recorder starts within 20 ms
    said: list[str] = []
    recordings = Recordings(loop.path, tmp_path, lambda text, level: said.append(text))
    recordings.start("late", whole=True)
    assert recordings.wait_for_frames(30.0)
    recordings.stop()
    assert len(recordings.faults) == 1
    assert "late.mcap lacks" in said[-1]


@pytest.mark.slow
def test_a_recorder_that_ends_by_itself_is_not_killed_by_a_late_request(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """The loop is over, the recorder goes, and the session still asks it to stop, until it is gone."""
    for number in range(3):
        loop = start_loop()
        path = tmp_path / f"{number}.mcap"
        words = [
            sys.executable,
            "-m",
            "erclutch.wings.live.recording.recorder",
            str(loop.path),
            str(path),
        ]
        process = subprocess.Popen(words, stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        loop.writer.put(state=State.STOPPED)
        limit = time.monotonic() + 30.0
        while process.poll() is None and time.monotonic() < limit:
            process.terminate()
            time.sleep(0.001)
        process.stdout.close()
        assert process.returncode == 0
        assert path.exists()


@pytest.mark.slow
@pytest.mark.parametrize("end", ["SIGTERM", "stopped", "dead"])
def test_a_recorder_ends_its_file(tmp_path: Path, start_loop: Callable[..., Any], end: str) -> None:
    loop = start_loop()
    words = [
        sys.executable,
        "-m",
        "erclutch.wings.live.recording.recorder",
        str(loop.path),
        str(tmp_path / "a.mcap"),
    ]
    process = subprocess.Popen(words, stdout=subprocess.PIPE)
    assert process.stdout is not None
    while json.loads(process.stdout.readline())["frames"] <= 50:
        pass  # it says how far it is every now and then
    if end == "SIGTERM":
        process.terminate()
    elif end == "stopped":
        loop.stop()
        loop.writer.put(state=State.STOPPED)
    else:
        gone = subprocess.Popen([sys.executable, "-c", ""])
        gone.wait()
        loop.writer.put(pid=gone.pid)
        loop.stop()
    assert process.wait(10) == 0
    process.stdout.close()
    assert sequence(tmp_path / "a.mcap").size > 50


def _lost_by_a_kill(path: Path, loop: Any, delay: float) -> int:
    """Frames that were in the ring and not in the file at the moment of the kill.

    Whatever the machine does meanwhile: what the recorder had said to have written is in the file, without a gap.
    """
    words = [
        sys.executable,
        "-m",
        "erclutch.wings.live.recording.recorder",
        str(loop.path),
        str(path),
    ]
    process = subprocess.Popen(words, stdout=subprocess.PIPE)
    assert process.stdout is not None
    # A recorder that has not begun has nothing to lose: the description of the messages alone is some 3 kB.
    while not partial_of(path).exists() or partial_of(path).stat().st_size < 6000:
        time.sleep(0.01)
    time.sleep(delay)
    process.kill()
    head = loop.head
    process.wait()
    said = json.loads(process.stdout.read().splitlines()[-1])
    process.stdout.close()
    path, last = finish_torn(partial_of(path), path)
    kept = sequence(path)
    assert np.array_equal(kept, np.arange(kept[0], last + 1))
    assert kept.size >= said["frames"]
    return head - 1 - last


@pytest.mark.slow
def test_kill_9_of_the_recorder_costs_less_than_a_tenth_of_a_second(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """At 100 random times, two recorders side by side: each takes a second to start and to be read again."""
    loop, delays = start_loop(), np.random.default_rng(2).uniform(0.0, 0.25, 100).tolist()
    paths = [tmp_path / f"{k}.mcap" for k in range(len(delays))]
    with ThreadPoolExecutor(2) as pool:
        lost = list(pool.map(_lost_by_a_kill, paths, repeat(loop), delays))
    print(
        f"kill -9 of the recorder, 100 times: frames lost, median {np.median(lost):g}, largest {max(lost)}"
    )
    # What the machine takes from the recorder is no loss of its own: the study counts each of 100.
    assert np.median(lost) <= 100, lost


@pytest.mark.slow
def test_another_recorder_goes_on_where_one_was_killed(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """All parts together hold every frame from the first to the last."""
    loop = start_loop()
    said: list[str] = []
    recordings = Recordings(loop.path, tmp_path, lambda text, level: said.append(text))
    first = loop.head
    recordings.start("run")
    at_most = loop.head
    for _ in range(2):
        assert recordings.wait_for_frames(30.0)
        killed = recordings.pid
        assert killed is not None
        os.kill(killed, signal.SIGKILL)
        limit = time.monotonic() + 30
        while recordings.pid in (killed, None) and time.monotonic() < limit:
            recordings.poll()
            time.sleep(0.02)
    assert recordings.wait_for_frames(30.0)
    recordings.stop()
    assert [path.name for path in recordings.files] == ["run.mcap", "run-2.mcap", "run-3.mcap"]
    kept = np.concatenate([sequence(path) for path in recordings.files])
    assert first <= kept[0] <= at_most
    assert np.array_equal(kept, np.arange(kept[0], kept[0] + kept.size))
    assert any("was killed; another goes on in run-2.mcap" in text for text in said)
    assert not list(tmp_path.glob("*.partial"))


@pytest.mark.slow
def test_a_recording_that_ends_at_once_is_whole(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """Its process may not even run yet: the ring keeps the frames for it."""
    loop = start_loop()
    recordings = Recordings(loop.path, tmp_path)
    first = loop.head
    recordings.start("short")
    loop.writer.put(state=State.STOPPED)
    recordings.stop()
    (path,) = recordings.files
    assert first <= sequence(path)[0] <= loop.head


@pytest.mark.slow
def test_two_sessions_that_start_together_in_one_folder_keep_both_recordings(
    tmp_path: Path, start_loop: Callable[..., Any]
) -> None:
    """The second asks for the name before the first one's recorder runs."""
    loops = [start_loop(), start_loop()]
    both = [Recordings(loop.path, tmp_path / "recordings") for loop in loops]
    paths = [recordings.start("run") for recordings in both]
    assert [path.name for path in paths] == ["run.mcap", "run-2.mcap"]
    for loop, recordings, path in zip(loops, both, paths, strict=True):
        loop.writer.put(state=State.STOPPED)
        recordings.stop()
        assert recordings.files == [path]
        assert sequence(path).size > 0


def test_a_folder_that_cannot_be_made(tmp_path: Path, start_loop: Callable[..., Any]) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(RecordingError, match="the folder of recordings cannot be made"):
        Recordings(start_loop().path, tmp_path / "file" / "inside").start()


def test_a_recording_never_takes_the_place_of_another(tmp_path: Path, frames: Any) -> None:
    path = write(tmp_path / "a.mcap", frames[:100])
    with pytest.raises(RecordingError, match="the file exists already"):
        FrameFile(path, INFO)
