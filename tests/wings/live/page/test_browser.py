"""The page in a real browser: it draws, its buttons and keys work, and it comes back after its server."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Callable, Generator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from erclutch.signals.channels import channels_of, named
from erclutch.wings.live.companions import Observers
from erclutch.wings.live.page_commands import PageCommand
from erclutch.wings.live.ring import State

CHROMIUM = Path("/usr/bin/chromium")
# Nothing but the page: no GPU, and none of the browser's own traffic.
_FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
]
_FLAGS += ["--disable-component-update", "--disable-sync"]
PROGRAMS = [
    ("tracking", "a sine", "position"),
    ("step", "a step of the field", "effort"),
    ("<b>rest</b>", "zero field", ""),
]

#: How many pixels of each chart have a colour.
_INK = """() => [...document.querySelectorAll(".chart canvas")].map(canvas => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let coloured = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b, alpha] = data.subarray(i, i + 4);
    coloured += alpha > 80 && Math.max(r, g, b) - Math.min(r, g, b) > 40;
  }
  return coloured;
})"""
#: Texts with less contrast than 4.5 to 1 against their ground (WCAG 2, level AA).
_CONTRAST = """() => {
  const parse = colour => colour.match(/[\\d.]+/g).map(Number);
  const linear = v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const luminance = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255);
  const ground = element => {
    for (; element; element = element.parentElement) {
      const colour = parse(getComputedStyle(element).backgroundColor);
      if (colour.length < 4 || colour[3] > 0.99) return colour;
    }
    return [255, 255, 255];
  };
  const kinds = "h1, h2, h3, button:not(:disabled), dt, dd, label, .fact, .figures, .badge, .state, .key, .rates, " +
    "#events span, #events time";
  return [...document.querySelectorAll(kinds)].filter(e => e.offsetParent && e.textContent.trim()).map(e => {
    const a = luminance(parse(getComputedStyle(e).color)), b = luminance(ground(e));
    return [e.id || e.className || e.tagName, (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)];
  }).filter(([, ratio]) => ratio < 4.5);
}"""

pytestmark = [pytest.mark.slow, pytest.mark.timed]


class Seen:
    """A page in a browser, its session, and all that went wrong or left the machine."""

    def __init__(
        self, page: Any, observers: Observers, commands: list[PageCommand], loop: Any
    ) -> None:
        self.page, self.observers, self.commands, self.loop = page, observers, commands, loop
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on(
            "console",
            lambda message: self.errors.append(message.text) if message.type == "error" else None,
        )
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))
        page.goto(observers.url)
        page.wait_for_url(re.compile(r"/\d+-[\w-]+/$"))
        self.until("erclutch.samples > 100")

    def until(self, condition: str, seconds: float = 20.0) -> None:
        """Wait for an expression to be true. Playwright's own waiting needs eval, which the page forbids."""
        limit = time.monotonic() + seconds
        while not self.page.evaluate(condition):
            assert time.monotonic() < limit, condition
            self.page.wait_for_timeout(30)

    def command(self, seconds: float = 10.0) -> PageCommand:
        """The next command that the session gets."""
        limit = time.monotonic() + seconds
        while not self.commands and time.monotonic() < limit:
            self.page.wait_for_timeout(20)
        return self.commands.pop(0)

    def text(self, selector: str) -> str:
        return self.page.text_content(selector)


@pytest.fixture(scope="module")
def chromium() -> Generator[Any]:
    if not CHROMIUM.exists():
        pytest.skip(f"needs {CHROMIUM}: apt install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=_FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def seen(chromium: Any, start_loop: Callable[..., Any], tmp_path: Path) -> Generator[Seen]:
    loop = start_loop()
    commands: list[PageCommand] = []
    with Observers(
        loop.path,
        commands.append,
        programs=PROGRAMS,
        motor_limit=0.95,
        folder=tmp_path / "recordings",
        lead=0.01,
    ) as observers:
        context = chromium.new_context(viewport={"width": 1440, "height": 900})
        yield Seen(context.new_page(), observers, commands, loop)
        context.close()


def test_one_device_has_nothing_of_a_second_clutch(
    chromium: Any, start_loop: Callable[..., Any], tmp_path: Path
) -> None:
    """A damper without a drive: its own units, one field under its own name, a piston."""
    words = named(
        "single", {"position": "stroke [m]", "effort": "force [N]", "field": "<b>coil</b> [A]"}
    )
    loop = start_loop(channels=words.of(channels_of("single", words.units, motor=words.motor)))
    with Observers(
        loop.path, lambda command: None, programs=PROGRAMS, folder=tmp_path
    ) as observers:
        context = chromium.new_context(viewport={"width": 1440, "height": 900})
        seen = Seen(context.new_page(), observers, [], loop)
        seen.until(f"Math.min(...({_INK})()) > 150")
        titles = "[...document.querySelectorAll('.chart h2')].map(title => title.firstChild.textContent).join()"
        assert seen.page.evaluate(titles) == "Force [N],Residual [N],Field [A],Slip [m/s]"
        shown = seen.page.evaluate("document.body.innerText")
        assert not any(
            word in shown
            for word in ("CH1", "CH2", "Clutches", "Motor", "N m", "Torque", "Zero fields")
        )
        assert "<b>coil</b>" in shown
        assert seen.page.evaluate("erclutch.picture.texts")[1].endswith(" m/s")
        assert not seen.errors
        context.close()


def test_it_draws_what_the_ring_holds(seen: Seen) -> None:
    page = seen.page
    seen.until("erclutch.samples > 1500 && erclutch.painted > 5")
    seen.until("document.getElementById('lateness').textContent.includes('p50 30 µs')")
    assert "token" not in page.url
    assert seen.text("#origin") == "TWIN"
    seen.until("document.getElementById('state').textContent === 'running tracking'")
    assert "fnn-16" in seen.text("#model")
    seen.until("document.getElementById('coverage').textContent === 'inside'")
    # Each chart has ink in the colours of its lines.
    assert len(page.evaluate(_INK)) == 5
    seen.until(f"Math.min(...({_INK})()) > 150")
    samples = page.evaluate("erclutch.samples")
    seen.until(f"erclutch.samples > {samples + 500}")
    # The picture: fields as they are, a table that moves, and pixels of both.
    picture = page.evaluate("erclutch.picture")
    assert [text[:4] for text in picture["texts"][:2]] == ["E 0.", "E 0."]
    assert picture["texts"][2].endswith(" mm")
    page.evaluate("window.before = document.querySelector('#picture canvas').toDataURL()")
    seen.until(f"erclutch.picture.table !== {picture['table']}")
    seen.until("document.querySelector('#picture canvas').toDataURL() !== window.before")
    assert seen.errors == []
    own = (f"http://127.0.0.1:{seen.observers.page.access.port}/", "ws://127.0.0.1:")  # type: ignore[union-attr]
    assert [url for url in seen.requests if not url.startswith(own)] == []


def test_the_reference_and_the_tracking_error_are_shown_while_something_is_tracked(
    seen: Seen,
) -> None:
    """What follows 5 sin(wt) 20 ms late errs by 10/sqrt(2) sin(0.02 pi) = 0.444 rad, with a lead of 10 mm 0.71 mm."""
    shown = "[...document.querySelectorAll('.chart:not([hidden]) .key:not([hidden])')].map(e => e.textContent).join()"
    seen.until("document.getElementById('error').textContent === '0.444 rad · 0.71 mm'")
    assert re.search("reference.*output.*error", seen.page.evaluate(shown))
    seen.loop.writer.put(program=1)  # of a torque
    seen.until("document.getElementById('error').textContent.endsWith(' mN m')")
    assert re.match("measured.*estimate.*reference", seen.page.evaluate(shown))
    assert "error" not in seen.page.evaluate(shown)
    seen.loop.writer.put(program=2)
    seen.until("document.getElementById('tracking').hidden")
    assert "reference" not in seen.page.evaluate(shown)


def test_ticks_have_the_digits_of_their_step(seen: Seen) -> None:
    module = "import(new URL('axis_ticks.js', location).href)"
    texts = f"{module}.then(made => made.tickTexts([-0.0025, 0, 0.0025, 0.005], 0.0025))"
    assert seen.page.evaluate(texts) == ["−0.0025", "0.0000", "0.0025", "0.0050"]
    ticks = f"{module}.then(made => [made.ticksOf(-0.7, 0.7, 1), made.ticksOf(-1.5, 1.5, 1)])"
    assert seen.page.evaluate(ticks) == [[-0.5, 0, 0.5], [-1, 0, 1]]  # no zero stands alone


def test_an_event_has_one_line(seen: Seen) -> None:
    seen.loop.events = 1 << 15
    seen.until("document.querySelector('#events .what') !== null")
    text = "document.querySelector('#events .what')"
    assert seen.page.evaluate(
        f"{text}.scrollWidth <= {text}.clientWidth && {text}.clientHeight < 24"
    )


def test_buttons_send_commands(seen: Seen) -> None:
    page = seen.page
    page.click("#zero")
    assert seen.command() == PageCommand("zero")
    page.click("#step")
    assert seen.command() == PageCommand("program", 1.0)
    page.select_option("#program", "<b>rest</b>")
    page.click("#program-form button")
    assert seen.command() == PageCommand("program", 2.0)
    page.fill("#motor", "-0.25")
    page.press("#motor", "Enter")
    assert seen.command() == PageCommand("motor", -0.25)
    page.fill("#motor", "5")
    page.click("#motor-form button")
    page.wait_for_timeout(500)
    assert seen.commands == []  # the browser refuses it; the server would too
    assert seen.errors == []


def test_keys(seen: Seen) -> None:
    page = seen.page
    page.keyboard.press("z")
    assert seen.command() == PageCommand("zero")
    page.keyboard.press("s")
    assert seen.command() == PageCommand("program", 1.0)
    page.focus("#motor")
    page.keyboard.type("z")
    page.keyboard.press("Escape")  # from inside a field, only Escape is a command
    assert seen.command() == PageCommand("zero")
    page.wait_for_timeout(200)
    assert seen.commands == []
    page.evaluate("document.activeElement.blur()")
    reached: list[str] = []
    for _ in range(16):
        page.keyboard.press("Tab")
        name = page.evaluate("document.activeElement.id || document.activeElement.tagName")
        reached.append(name)
        assert (
            name == "BODY"
            or page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"
        ), name
    assert {"freeze", "zero", "record", "step", "program", "motor", "events"} <= set(reached)


def test_recording_freezing_and_the_alarm(seen: Seen) -> None:
    page = seen.page
    page.keyboard.press("r")
    seen.until("!document.getElementById('recording').hidden")
    seen.until("/[1-9].* MB/.test(document.getElementById('recorded').textContent)")
    page.click("#freeze")
    assert page.get_attribute("#freeze", "aria-pressed") == "true"
    page.wait_for_timeout(200)
    before = page.evaluate("document.querySelector('.chart canvas').toDataURL()")
    page.wait_for_timeout(400)
    assert page.evaluate("document.querySelector('.chart canvas').toDataURL()") == before
    box = page.locator(".chart .u-over").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.4, box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.6, box["y"] + 20, steps=4)
    page.mouse.up()
    page.evaluate("url => window.before = url", before)
    seen.until("document.querySelector('.chart canvas').toDataURL() !== window.before")
    page.click("#freeze")
    seen.loop.flags = 1
    seen.until("document.getElementById('coverage').textContent.startsWith('outside')")
    seen.loop.flags = 96
    seen.until(
        "/^drift: the torque left the band.*; wide band: /.test(document.getElementById('coverage').textContent)"
    )
    assert page.evaluate(
        "(e => e.scrollWidth <= e.clientWidth)(document.getElementById('coverage').parentElement)"
    )
    assert page.evaluate("document.getElementById('coverage').offsetHeight") > 20, (
        "alarms are read whole, over lines"
    )
    page.click("#record")
    seen.until("document.getElementById('recording').hidden")
    seen.until(
        "[...document.querySelectorAll('#events .what')].some(e => e.textContent.includes('is complete'))"
    )
    assert len(seen.observers.recordings.files) == 1
    assert seen.errors == []


def test_trips_and_silence_are_shown(seen: Seen) -> None:
    seen.loop.writer.put(state=State.TRIPPED, trip_reason=1)
    seen.until("document.getElementById('banner').textContent.includes('Tripped by sample-lost')")
    seen.page.click("#reset")
    assert seen.command() == PageCommand("reset")
    seen.page.click(
        "#program-form button"
    )  # not while it is tripped: no command goes out, and the page says why
    seen.until(
        "document.getElementById('said').textContent.includes('tripped by sample-lost. Reset it first')"
    )
    seen.loop.writer.put(state=State.READY)
    seen.until(
        "document.getElementById('banner').textContent.includes('nothing moves until a program is run')"
    )
    assert seen.page.locator("#reset").is_hidden()
    assert seen.page.get_attribute("#banner", "data-calm") == "true", "a reset loop is no alarm"
    seen.page.click("#program-form button")
    assert seen.command().kind == "program"
    seen.loop.writer.put(state=State.RUNNING)
    seen.until("document.getElementById('banner').hidden")
    seen.loop.stop()
    seen.until("document.getElementById('banner').textContent.includes('No frame from the loop')")
    painted = seen.page.evaluate(
        "erclutch.painted"
    )  # what is shown goes on by the page's clock, but never beyond data
    seen.page.wait_for_timeout(500)
    assert seen.page.evaluate("erclutch.painted") == painted


def test_it_comes_back_after_its_server(seen: Seen) -> None:
    page = seen.page
    assert seen.observers.page is not None
    os.kill(seen.observers.page.pid, signal.SIGKILL)
    seen.until(
        "document.getElementById('banner').textContent.includes('connection to the session is lost')"
    )
    seen.until("erclutch.connections === 2")
    before = page.evaluate("erclutch.samples")
    seen.until(f"erclutch.samples > {before + 300}")
    seen.until("document.getElementById('banner').hidden")
    page.keyboard.press("z")
    assert seen.command() == PageCommand("zero")


def test_an_ended_session_is_said_to_be(seen: Seen) -> None:
    assert seen.observers.page is not None
    seen.observers.page._process.stdin.close()  # type: ignore[union-attr]  # as the session does at its end
    seen.until("document.getElementById('banner').textContent.includes('The session has ended')")
    assert [
        seen.page.locator(f"#{name}").is_disabled()
        for name in ("zero", "record", "program", "freeze")
    ] == [
        *(True, True, True),
        False,
    ]


def test_a_page_that_made_room_says_so_and_stays_away(chromium: Any, seen: Seen) -> None:
    context = chromium.new_context()
    further = [context.new_page() for _ in range(8)]
    for page in further:
        page.goto(seen.observers.url)
        page.wait_for_url(re.compile(r"/\d+-[\w-]+/$"))
        page.wait_for_timeout(300)
    seen.until("document.getElementById('banner').textContent.includes('More pages are open')")
    seen.page.wait_for_timeout(1000)
    assert seen.page.evaluate("erclutch.connections") == 1
    assert all(page.evaluate("erclutch.connections") == 1 for page in further)
    context.close()


HOSTILE = [
    "<img src=x onerror=window.pwned=1>",
    "javascript:window.pwned=1",
    "W" * 100_000,
    "ab " * 30_000,
    "a\x00\x1b[31m\u2028\u202e\ud83d",
    "Z" + "\u0301" * 400,
]


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
@pytest.mark.parametrize("width", [390, 1440])
def test_no_name_runs_or_moves_the_button_that_zeroes_the_field(
    name: str, width: int, chromium: Any, start_loop: Callable[..., Any], tmp_path: Path
) -> None:
    told = name.encode(errors="replace").decode()
    loop = start_loop(rig=told, note=told)
    programs = [(name, name, "position"), (f"step {name}", name, "")]
    context = chromium.new_context(viewport={"width": width, "height": 900})
    with Observers(loop.path, print, programs=programs, folder=tmp_path) as observers:
        observers.say(name, "alarm")
        seen = Seen(context.new_page(), observers, [], loop)
        seen.until("document.getElementById('state').textContent.startsWith('running')")
        seen.until("document.querySelector('#events .what') !== null")
        seen.page.click("#step")
        zero = seen.page.locator("#zero").bounding_box()
        assert zero["y"] + zero["height"] < 500
        assert seen.page.evaluate("window.pwned === undefined")
        assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
        assert seen.page.evaluate("document.documentElement.scrollHeight") < 4000
        assert seen.errors == []
    context.close()


@pytest.mark.parametrize("width", [390, 1440])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_sticks_out(seen: Seen, width: int, scheme: Any) -> None:
    page = seen.page
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 900})
    page.wait_for_timeout(600)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(16, 20, 26)"
    assert dark == (scheme == "dark")
    low = page.evaluate(_CONTRAST)
    assert low == []
    axe: Any = import_module("axe_playwright_python.sync_playwright")
    only = {"resultTypes": ["violations"]}
    assert axe.Axe().run(page, options=only).response["violations"] == []
    assert seen.errors == []
