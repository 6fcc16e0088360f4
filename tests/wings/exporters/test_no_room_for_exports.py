"""An export onto a full disk is one line and leaves nothing: `studies/attack.py` asks all targets, this file two."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import good
from tests.support.no_room import Ended, full_disk, full_disks
from tests.support.races import FIT


def _mounts_no_disk() -> bool:
    """Whether this machine lets no process have a file system of its own."""
    words = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    if shutil.which(words[0]) is None:
        return True
    return subprocess.run(words, capture_output=True, check=False).returncode != 0


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(_mounts_no_disk(), reason="no file system of its own can be mounted here"),
]


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run."""
    folder = tmp_path_factory.mktemp("fitted")
    write_synthetic_log(folder / "log.csv", seconds=4.0)
    good(*FIT, "run", cwd=folder)
    return folder


@pytest.mark.parametrize("how", [full_disk, full_disks])
@pytest.mark.parametrize("target", ["cpp", "python"])
def test_an_export_that_finds_no_room_is_one_line(
    target: str, how: Callable[[str, Path], Ended], fitted: Path
) -> None:
    ended = how(f"export to {target}", fitted)
    assert ended.wrong == ""
    assert ended.code == 2
    assert [name for name in ended.left if "made" in name] == []
