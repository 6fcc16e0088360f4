"""`studies/formats.py` calls each reader as its child does, by a name in the reader's file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from studies.formats import finder
from tests.support.log_formats import FORMATS

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("reader", sorted({reader for reader, *_ in FORMATS.values()}))
def test_each_reader_has_a_function_to_call(reader: str) -> None:
    assert callable(finder(reader))


@pytest.mark.slow
def test_a_fork_of_the_study_keeps_its_address_space_as_a_readers_child_does() -> None:
    """Arrow's own pool takes a GiB at once: what came after it had no memory, and waited for a thread."""
    asked = "import studies.formats, pyarrow; print(pyarrow.default_memory_pool().backend_name)"
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("ARROW")
    }
    done = subprocess.run(
        [sys.executable, "-c", asked],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "system"
