"""The report for print can be read aloud: each page's content belongs to an element, or is an artifact."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import pytest

from erclutch.report.html.report_file import may_write_report
from erclutch.report.numbers.run_material import Material
from erclutch.report.report_pdf import write_pdf


def pages_of(data: bytes) -> list[bytes]:
    """The drawing of each page."""
    found = [zlib.decompress(part) for part in re.findall(rb"FlateDecode.*?stream\n(.*?)\nendstream", data, re.DOTALL)]
    return [text for text in found if b"BDC" in text]


@pytest.mark.slow
def test_the_report_for_print_has_a_structure(material: Material, tmp_path: Path) -> None:
    data = write_pdf(material, tmp_path / "report.pdf").read_bytes()
    assert re.search(rb"/MarkInfo << /Marked true >>", data)
    assert b"/Lang (en)" in data
    pages = pages_of(data)
    assert len(pages) == data.count(b"/Type /Page\n") + data.count(b"/Type /Page ") > 4
    marks = 0
    for text in pages:
        words = re.findall(rb"^(?:/\w+ <</MCID (\d+)>> )?(BDC|/Artifact BMC|EMC)$", text, re.MULTILINE)
        assert [kind != b"EMC" for _, kind in words] == [True, False] * (len(words) // 2)  # none inside another one
        numbers = [int(number) for number, _ in words if number]
        assert numbers == list(range(len(numbers)))
        marks += len(numbers)
    elements = re.findall(rb"/S /(\w+)", data)
    assert data.count(b"/Type /MCR") == marks
    assert elements.count(b"H1") == elements.count(b"Document") == 1
    assert elements.count(b"TR") > len(material.run.names)  # the ranking whole, with its header
    assert elements.count(b"Figure") == data.count(b"/Alt (") + data.count(b"/Alt <") > 4
    may_write_report(tmp_path / "report.pdf")
