"""The whole road in a browser: fit, fit again, trim, score, compare, export, verify, download."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from erclutch.report.html.printed_page import browser
from tests.wings.app.test_app import NEES, Served, follow, german, open_page, served

__all__ = ["open_page", "served"]

SHARED = pytest.mark.skipif(not NEES.is_file(), reason=f"needs the recording {NEES.name}")


def columns(page: Any) -> None:
    """Say which column of the NEES damper is which signal."""
    for signal, column, unit in (
        ("time", "t", "s"),
        ("field", "Y", "V"),
        ("slip", "V", "cm/s"),
        ("effort", "F", "N"),
    ):
        page.select_option(f"[name='column.{signal}']", column)
        page.fill(f"[name='unit.{signal}']", unit)
    follow(page, "text=Read it so")


def drag(page: Any, start: float, stop: float) -> None:
    """Drag over the first plot of the signals."""
    plot = page.locator("#plots .u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + start * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + stop * box["width"], y, steps=4)
    page.mouse.up()


def fit(page: Any, model: str) -> str:
    """Fit one law without stages; the name of the run."""
    for box in page.locator("[name^='model.']:checked").all():
        box.uncheck()
    page.check(f"[name='model.{model}']")
    page.fill("[name=lag]", "none")
    page.click("button:has-text('Fit')")
    page.wait_for_url("**/run/**", timeout=120_000)
    return re.search(r"/run/([^?#]+)", page.url)[1]  # pyright: ignore[reportOptionalSubscript]


def download_reports(page: Any) -> None:
    """The report with its note as HTML, and as PDF where a browser prints."""
    with page.expect_download(timeout=60_000) as download:
        page.get_by_text("Download the report").click()
    assert "trimmed by hand" in Path(download.value.path()).read_text(encoding="utf-8")
    if browser() is not None:
        with page.expect_download(timeout=120_000) as download:
            page.get_by_text("as PDF", exact=True).click()
        assert Path(download.value.path()).read_bytes().startswith(b"%PDF-")


@pytest.mark.slow
@pytest.mark.parametrize("log", ["german", pytest.param("NEES", marks=SHARED)])
def test_the_whole_road(
    log: str, served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page, place = open_page(), f"http://127.0.0.1:{served.port}{served.base}"
    path = german(tmp_path / "road.csv") if log == "german" else NEES
    page.set_input_files("#file", str(path))
    page.wait_for_url("**/log/**")
    if log == "NEES":
        columns(page)
    at = f"{place}/log/{path.name}"

    # Trim by mouse, look closer and back by keys.
    first, last = map(float, page.get_attribute("#courses", "data-view").split(","))
    drag(page, 0.1, 0.8)
    begin, end = map(float, page.get_attribute("#courses", "data-view").split(","))
    assert begin == pytest.approx(first + 0.1 * (last - first), abs=0.02 * (last - first))
    assert end == pytest.approx(first + 0.8 * (last - first), abs=0.02 * (last - first))
    page.focus("#courses")
    page.keyboard.press("+")
    assert page.get_attribute("#courses", "data-view") != f"{begin:g},{end:g}"
    page.locator("#plots .u-over").first.dblclick()
    assert page.get_attribute("#courses", "data-view") == f"{begin:g},{end:g}"
    page.focus("#courses")
    page.keyboard.press("Home")
    drag(page, 0.1, 0.8)
    follow(page, "text=Trim the log to what is seen", "**from=**")
    page.get_by_text("Take the whole log again").wait_for()
    assert "all that the trimming leaves" in page.locator("#seen").inner_text()
    page.fill("[name='about.device']", "Damper 3")
    page.fill("[name='about.note']", "trimmed by hand")
    follow(page, "text=Keep it with the log")

    # Fit, and again with another model: the page of the log remembers how it was read.
    one = fit(page, "bingham")
    assert "The only model: Bingham law, with an RMSE of" in page.locator("main").inner_text()
    assert page.locator("[name='about.device']").input_value() == "Damper 3"
    report = page.frame_locator("iframe")
    report.locator("h1").wait_for(timeout=60_000)
    assert "trimmed by hand" in report.locator("#verdict").inner_text()
    frame = page.locator("iframe")
    while (
        frame.evaluate("frame => frame.offsetHeight") < 2000
    ):  # as high as its report: one scroll bar
        page.wait_for_timeout(100)
    page.goto(at)
    page.wait_for_url("**from=**")
    two = fit(page, "quadratic")
    assert one != two
    settings = [
        json.loads((served.folder / run / "run.json").read_text())["reading"] for run in (one, two)
    ]
    assert settings[0] == settings[1]
    assert float(settings[0]["begin"].removesuffix("s")) == pytest.approx(
        begin, abs=0.02 * (last - first)
    )

    # Score another log as the run read its own, and with a changed mapping.
    other = served.folder / f"other-{path.name}"
    other.write_bytes(path.read_bytes())
    page.goto(f"{place}/run/{one}")
    page.select_option("form[action$='/predict'] [name=log]", other.name)
    follow(page, "text=Look at it first", f"**/log/{other.name}?**")
    page.check("[name='turn.effort']")
    page.click("button:has-text('Score')")
    page.wait_for_selector("text=of the std", timeout=60_000)
    assert "m1, Bingham law" in page.locator("table").inner_text()

    # Compare; runs of other logs are told before the click.
    page.goto(f"{place}/")
    page.check(f"[name='run.{one}']")
    page.check(f"[name='run.{two}']")
    assert page.locator("#few-rows").is_hidden(), "both were trimmed alike"
    page.eval_on_selector(f"[name='run.{two}']", "box => { box.dataset.heldOut += ' other'; }")
    page.uncheck(f"[name='run.{two}']")
    page.check(f"[name='run.{two}']")
    assert page.locator("#few-rows").is_visible()
    page.click("text=Compare the ticked runs")
    page.wait_for_url("**/shown/**", timeout=60_000)  # the comparison, not the terminal
    page.frame_locator("iframe").locator("h1").wait_for(timeout=60_000)
    assert page.get_by_text("What the command printed").count() == 1

    # Export, verify, download.
    page.goto(f"{place}/run/{one}")
    page.select_option("[name=target]", "python")
    page.click("button:has-text('Export')")
    page.wait_for_selector("text=Verify it", timeout=60_000)
    with page.expect_download(timeout=60_000) as download:
        page.get_by_text("Download").click()
    assert download.value.suggested_filename.endswith(".zip")
    page.click("text=Verify it")
    page.wait_for_selector("text=The export gives what the model gives", timeout=120_000)
    assert page.get_by_text("Download").count() == 1
    follow(page, "text=Back to the run", f"**/run/{one}")
    page.goto(f"{place}/run/{one}")
    download_reports(page)


@pytest.mark.slow
def test_logs_that_do_not_go_together_are_told_before_the_click(
    served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page, place = open_page(), f"http://127.0.0.1:{served.port}{served.base}"
    one, other = german(served.folder / "units.csv"), served.folder / "units-other.csv"
    other.write_text(
        one.read_text(encoding="latin-1").replace("Drehmoment [N m]", "Kraft [N]"),
        encoding="latin-1",
    )
    page.goto(f"{place}/log/{one.name}")
    page.click("text=Together with other logs")
    page.check(f"[name='log.{other.name}']")
    page.wait_for_selector(".main[formaction*='/fit/']:disabled", timeout=60_000)
    assert other.name in page.locator("#together").inner_text()
    page.uncheck(f"[name='log.{other.name}']")
    page.wait_for_selector(".main[formaction*='/fit/']:enabled")


@pytest.mark.slow
def test_a_page_tells_why_its_script_got_no_answer(
    served: Served, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    """The page said "Looking whether they go together …" for ever, and kept the commands of earlier settings."""
    page, place = open_page(), f"http://127.0.0.1:{served.port}{served.base}"
    one, other = german(served.folder / "silent.csv"), german(served.folder / "silent-other.csv")
    page.goto(f"{place}/log/{one.name}")
    page.click("text=Together with other logs")
    one.rename(one.with_suffix(".gone"))
    page.check(f"[name='log.{other.name}']")
    page.wait_for_selector("#together:has-text('the workspace has no such file')", timeout=60_000)
    page.route("**/together/**", lambda route: route.abort())
    page.uncheck(f"[name='log.{other.name}']")
    page.wait_for_selector("#together:has-text('The server does not answer')")
    page.route("**/words/**", lambda route: route.abort())
    page.fill("[name='unit.effort']", "N*mm")
    page.wait_for_selector("#read:has-text('The server does not answer')")
