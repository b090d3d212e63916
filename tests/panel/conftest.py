# SPDX-License-Identifier: Apache-2.0
"""One panel with one simulated bench for all browser tests, and an operator that clicks."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, closing
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from domains import loopback
from made_up import campaign
from panel_rig import (
    BUS_HZ,
    CHROMIUM,
    FLAGS,
    IDLE,
    PATIENT,
    WATCHDOG_CYCLES,
    Observer,
    lift_and_go_back,
    panel_process,
    wait_for,
)

from flatplank_panel.views.shell import STOP

pytest.register_assert_rewrite("requirement_checks")
HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if not Path(CHROMIUM).exists():
        skip = pytest.mark.skip(reason="no chromium: apt-get install chromium")
        for item in items:
            if item.get_closest_marker("browser") and HERE in Path(item.path).parents:
                item.add_marker(skip)
    # once a bench runs all pages draw it: those that need none come first
    here = [i for i, item in enumerate(items) if HERE in Path(item.path).parents]
    ours = sorted((items[i] for i in here), key=lambda item: "observer" in item.fixturenames)
    for i, item in zip(here, ours, strict=True):
        items[i] = item


@pytest.fixture(scope="session")
def domain():
    """Everything of this session in a domain of its own."""
    before = dict(os.environ)
    os.environ.update(loopback())
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture(scope="session")
def data(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("panel") / "data"
    folder.mkdir()
    return folder


@pytest.fixture
def made_up(data, request) -> Iterator[Path]:
    """A campaign that nobody has measured; an indirect parameter is the scatter of its repeats."""
    yield campaign(data / "made_up", scatter=getattr(request, "param", 0.0))
    shutil.rmtree(data / "made_up")


@pytest.fixture
def pictures(tmp_path) -> Path:
    folder = Path(os.environ.get("FLATPLANK_PICTURES", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def address(domain, data):
    # a computer that runs tests stalls now and then; tests/drive tests the limits of the lab
    plant, patient = data.parent / "plant.yaml", data.parent / "patient.yaml"
    plant.write_text(yaml.safe_dump({"watchdog_cycles": WATCHDOG_CYCLES}))
    nodes = {"wheel_drive": PATIENT, "simulated_plant": {"config": str(plant)}}
    patient.write_text(yaml.safe_dump({n: {"ros__parameters": p} for n, p in nodes.items()}))
    with panel_process(data, "--parameters", str(patient)) as url:
        yield url


@pytest.fixture(scope="session")
def observer(domain):
    seen = Observer()
    yield seen
    seen.close()


@pytest.fixture(scope="session")
def chromium():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # the libraries of the ROS wheels are not for the browser
        env = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS, env=env)
        yield browser
        browser.close()


class Clicker:
    """An operator in front of the page."""

    def __init__(self, page, address: str) -> None:
        self.page, self.address = page, address
        page.set_default_timeout(60_000)
        self.errors: list[str] = []
        page.on("pageerror", lambda e: self.errors.append(str(e)))
        page.goto(address)
        self.button("STOP").wait_for()

    def button(self, name: str):
        name = {"STOP": STOP}.get(name, name)
        return self.page.get_by_role("button", name=name, exact=True)

    def click(self, name: str) -> None:
        self.button(name).click()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).click()

    def field(self, label: str) -> Any:
        """The one that is in view: a tab that was left keeps its fields."""
        return self.page.get_by_label(label, exact=True).filter(visible=True)

    def fill(self, label: str, value: object) -> None:
        self.field(label).fill(str(value))
        self.page.keyboard.press("Tab")

    def choose(self, label: str, option: str) -> None:
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def said(self, text: str) -> None:
        """The log or a message says so."""
        wait_for(self.page.get_by_text(text).first.is_visible, 60.0, f"the page says {text}")

    def take(self) -> None:
        self.click("Take charge")
        self.button("Hand back").wait_for()

    def word(self, name: str) -> str:
        return self.page.locator(f"[data-word={name}]").first.text_content() or ""

    def number(self, key: str) -> float:
        """A number of the ribbon; NaN while there is none."""
        text = self.page.locator(f"[data-key={key}]").first.text_content() or ""
        return float(text.replace("−", "-")) if text.strip("–") else float("nan")

    def word_is(self, name: str, text: str, timeout: float = 15.0) -> None:
        wait_for(
            lambda: text in self.word(name), timeout, f"{name} says {text}: {self.word(name)}"
        )


VIEW = {"viewport": {"width": 1440, "height": 900}}


@pytest.fixture(scope="session")
def usual_context(chromium):
    """Keeps what the pages have in common, as a browser does: scripts are loaded once."""
    with chromium.new_context(**VIEW) as context:
        yield context


@pytest.fixture
def visitor(chromium, usual_context, address):
    """Makes pages; each is closed at the end. The second and further ones of a test are in
    browsers of their own."""
    contexts, pages = [usual_context], []

    def visit() -> Clicker:
        if pages:
            contexts.append(chromium.new_context(**VIEW))
        pages.append(contexts[-1].new_page())
        return Clicker(pages[-1], address)

    yield visit
    for context in contexts[1:]:
        context.close()
    for page in usual_context.pages:
        page.close()
    with closing(usual_context.new_page()) as page:
        page.goto(f"{address.partition('?')[0]}assets/beat.js")
        page.evaluate("localStorage.clear()")


@pytest.fixture(scope="session")
def idle(chromium, domain, data):
    """In charge of a panel that accepts everything and lacks its `hands` or its `eyes`."""
    with ExitStack() as stack:

        @cache
        def at(part: str) -> Clicker:
            address = stack.enter_context(panel_process(data, before=IDLE[part]))
            context = chromium.new_context(**VIEW)
            stack.callback(context.close)
            who = Clicker(context.new_page(), address)
            who.take()
            return who

        yield at


@pytest.fixture
def operator(visitor, observer):
    """In charge of a running bench, wheel lifted, drive disabled, plank at rest."""
    who = visitor()
    wait_for(lambda: "nobody" in who.page.locator("header").text_content(), 20.0, "charge is free")
    who.take()
    if not observer.running:
        who.fill("Bus rate [Hz]", BUS_HZ)
        who.click("Start bench")
        observer.client.wait_connected(["wheel_drive", "recorder", "simulated_plant"], 120.0)
    observer.fresh()
    who.word_is("bench", "running", 60.0)
    if not (observer.lifted and observer.at_beginning):
        lift_and_go_back(who, observer)
    yield who
    if who.button("Hand back").is_visible():
        who.click("Hand back")
    who.button("Take charge").wait_for()
    assert not who.errors


def enable(who: Clicker, observer) -> None:
    """Enabled and at rest: a drive goes on with the set-point of its mode when it is enabled."""

    def click() -> None:
        who.tab("Drive")
        who.click("Reset fault")
        who.click("Enable")

    who.tab("Drive")
    who.fill("Velocity [rad/s]", 0)
    who.click("Set velocity")
    who.click("Enable")
    observer.wait(observer.enabled, 60.0, "operation enabled at the drive", again=click)
    observer.wait(lambda: abs(observer.speed()) < 1e-3, 20.0, "the shaft rests")


def rest(who: Clicker, observer) -> None:
    """Disabled, and nothing is asked for that would begin with the next enable."""

    def click() -> None:
        who.tab("Drive")
        who.click("Disable")

    click()
    observer.wait(lambda: not observer.enabled(), 30.0, "drive disabled", again=click)
    observer.wait(lambda: abs(observer.speed()) < 1e-3, 20.0, "the shaft rests")
    who.fill("Velocity [rad/s]", 0)
    who.click("Set velocity")


@pytest.fixture
def enabled(operator, observer):
    """The same with the drive enabled; disabled again afterwards."""
    operator.tab("Drive")
    enable(operator, observer)
    yield operator
    rest(operator, observer)
