"""The report for print: what a browser makes of it, and what is said where no browser can."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path

import pytest

from erclutch.errors import RunError
from erclutch.report.html import printed_page
from erclutch.report.html.printed_page import print_report
from erclutch.report.html.report_file import may_write_report
from erclutch.report.html.report_page import report_html
from erclutch.report.numbers.run_material import Material
from tests.support.page_fill import page_fills

needs_browser = pytest.mark.skipif(
    printed_page.browser() is None, reason="needs chromium: apt install chromium"
)


def fake_browser(folder: Path, script: str) -> Path:
    """A program in a browser's place; ``$pages`` is the file that it was asked to write."""
    program = folder / "chromium"
    find = 'for word in "$@"; do case "$word" in --print-to-pdf=*) pages="${word#--print-to-pdf=}";; esac; done'
    program.write_text(f"#!/bin/sh\n{find}\n{script}\n")
    program.chmod(0o755)
    return program


@pytest.mark.slow
@needs_browser
def test_a_browser_prints_a_tagged_pdf(material: Material, tmp_path: Path) -> None:
    path = print_report(material, tmp_path / "report.pdf")
    printed = path.read_bytes()
    assert printed.startswith(b"%PDF-")
    assert b"/Marked true" in printed
    assert b"/Lang (en)" in printed
    assert 3 <= len(re.findall(rb"/Type /Page\b", printed)) <= 8
    assert [made.name for made in tmp_path.iterdir()] == ["report.pdf"]
    may_write_report(path)  # it is known as ours


@pytest.mark.slow
@needs_browser
def test_no_page_is_half_empty(material: Material, tmp_path: Path) -> None:
    """Of each page, the last one too, the lowest ink lies below the middle."""
    fills = page_fills(print_report(material, tmp_path / "report.pdf"))
    if not fills:
        pytest.skip("needs pdftoppm: apt install poppler-utils")
    assert min(fills) > 0.5, fills


def says_where_it_ends(folder: Path, reads: str, shown: int, otherwise: int) -> Path:
    """A browser's stand-in, whose PDF says how far from below the page ends: it depends on what the page has."""
    script = f'''echo once >> "{folder}/printed"
end={otherwise}
{reads} "${{pages%report.pdf}}report.html" && end={shown}
printf '%%PDF-1.4\\n/MediaBox [0 0 594.9 840.0]\\n/end [9 0 R /XYZ 0 %s 0]\\n' $end > "$pages"'''
    return fake_browser(folder, script)


@pytest.mark.slow
def test_a_last_page_that_would_be_half_empty_is_filled_by_a_chapter(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first way that fills it is taken, and no further one is tried."""
    program = says_where_it_ends(
        tmp_path, 'grep -q \'id="residual" class="chapter onpaper"\'', 300, 600
    )
    monkeypatch.setattr(printed_page, "browser", lambda: str(program))
    printed = print_report(material, tmp_path / "report.pdf").read_bytes()
    assert printed_page.last_page_fill(printed) == pytest.approx(1 - 300 / 840)
    assert (tmp_path / "printed").read_text().split() == ["once", "once"]


@pytest.mark.slow
def test_where_nothing_fills_the_last_page_the_fullest_is_kept(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = says_where_it_ends(tmp_path, "grep -q '<details class=\"onpaper\">'", 600, 500)
    monkeypatch.setattr(printed_page, "browser", lambda: str(program))
    printed = print_report(material, tmp_path / "report.pdf").read_bytes()
    assert printed_page.last_page_fill(printed) == pytest.approx(1 - 500 / 840)


@pytest.mark.slow
def test_the_page_for_print_has_traces_and_the_constants_of_the_recommended_model(
    material: Material,
) -> None:
    page = report_html(material)
    traces = page.partition('<section id="traces"')[2].partition("</section>")[0]
    assert traces.partition('class="print figures"')[2].count('<svg class="plot') == 3
    model = page.partition('<section id="model"')[2].partition("</section>")[0]
    assert material.title in model
    assert "<details" not in model, "a folded part is not printed"
    assert model.count('<th scope="row">') == len(
        material.run.entry(material.recommended)["fit"]["parameters"]
    )


def test_without_a_browser_it_says_how_to_print(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(printed_page, "browser", lambda: None)
    with pytest.raises(RunError) as caught:
        print_report(material, tmp_path / "report.pdf")
    assert str(caught.value).endswith(
        "no Chromium, Chrome or Edge is here to print with. "
        "Write the report without --pdf, open it in a browser and print it (Ctrl-P)."
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("exit 1", "did not print it (exit code 1)"),
        ("exit 0", "did not print it (exit code 0)"),
        ('echo no PDF > "$pages"', "did not print it (exit code 0)"),
        ("exec sleep 60", "has not printed it in 0.2 s"),
    ],
)
def test_a_browser_that_fails_is_one_line_and_leaves_nothing(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, said: str
) -> None:
    program = fake_browser(tmp_path, script)
    monkeypatch.setattr(printed_page, "browser", lambda: str(program))
    monkeypatch.setattr(printed_page, "_SECONDS", 0.2 if "sleep" in script else 60.0)
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(RunError) as caught:
        print_report(material, out / "report.pdf")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert list(out.iterdir()) == []


@pytest.mark.parametrize(
    "made",
    [
        b"%PDF-1.4\n1 0 obj\n<</Creator (Mozilla/5.0 \\(X11\\) Chrome)\n/Producer (Skia)>>\n",
        b"%PDF-1.4\n1 0 obj\n<</Producer (a browser that names itself nowhere)>>\n",
    ],
)
def test_places_in_the_pdf_stay(made: bytes) -> None:
    signed = printed_page.signed(made)
    assert len(signed) == len(made)
    assert (b"/Creator (erclutch)" in signed) == (b"/Creator" in made)
    assert signed.endswith(made[made.index(b"/Producer") :])


@pytest.mark.skipif(os.name != "posix", reason="a browser that is a script of the shell")
def test_a_browser_that_is_ended_leaves_no_process_and_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After Control-C its own folder stayed, and its helpers wrote on into ours while that was taken away."""
    script = 'mkdir "$TMPDIR/own"\nsleep 60 &\necho $! > helper\nsleep 60'
    browser = fake_browser(tmp_path, script)
    profile = tmp_path / "profile"
    profile.mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(printed_page, "_SECONDS", 1.0)
    with pytest.raises(RunError, match="has not printed it in 1 s"):
        printed_page._print(str(browser), browser, tmp_path / "r.pdf", str(profile), tmp_path)
    assert [path.name for path in profile.iterdir()] == ["own"]
    helper = int((tmp_path / "helper").read_text())
    # A process that was killed runs on until a processor is free to end it.
    given_up = time.monotonic() + 30.0
    while _runs(helper):
        assert time.monotonic() < given_up
        time.sleep(0.01)


def _runs(process: int) -> bool:
    """Whether a process is neither gone nor a zombie."""
    try:
        said = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return said.rpartition(")")[2].split()[0] != "Z"
