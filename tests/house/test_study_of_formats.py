"""`studies/formats.py` calls each reader as its child does, by a name in the reader's file."""

from __future__ import annotations

import pytest

from studies.formats import finder
from tests.support.log_formats import FORMATS


@pytest.mark.parametrize("reader", sorted({reader for reader, *_ in FORMATS.values()}))
def test_each_reader_has_a_function_to_call(reader: str) -> None:
    assert callable(finder(reader))
