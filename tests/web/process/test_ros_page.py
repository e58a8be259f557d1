"""Parameters, services, plots and hostile texts in a real Chromium, against a node for that."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import page_at
from tests.support.controlled_run import ControlledRun
from tests.support.counting_node import EVALUATED, HOSTILE, REFUSAL
from tests.support.repository import REPOSITORY
from tests.web.process.conftest import starting
from tests.web.process.test_fleet_page import show

pytestmark = pytest.mark.browser

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo

HOSTILE = {hostile!r}


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("text", default_value=HOSTILE, description=HOSTILE),
        LogInfo(msg=HOSTILE),
        ExecuteProcess(
            cmd=[sys.executable, "-m", "tests.support.counting_node"],
            name="counter", output="screen", cwd={cwd!r},
        ),
        ExecuteProcess(cmd=["sh", "-c", "echo \\"$0\\"; sleep 600", HOSTILE], name="<b>bold<b>"),
    ])
"""


@pytest.fixture(scope="module")
def counter(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ControlledRun, str]]:
    folder = tmp_path_factory.mktemp("counter")
    file = folder / "counter.launch.py"
    file.write_text(LAUNCH.format(hostile=HOSTILE, cwd=str(REPOSITORY)))
    with starting(folder) as start:
        yield start(file)


@pytest.fixture
def page(started: Browser, counter: tuple[ControlledRun, str]) -> Iterator[Page]:
    with page_at(started, counter[1], viewport={"width": 1280, "height": 800}) as open_page:
        expect(open_page.locator(".app-link")).to_have_text("open")
        yield open_page


def test_a_counter_is_plotted(page: Page):
    show(page, "topics")
    page.locator('tr[data-topic="/counts"]').click()
    page.locator('[data-plot="data"]').click()
    series = page.locator('[data-series="/counts data"]')
    expect(series.locator("[data-last]")).to_have_text(re.compile(r"\d+"))
    first = int(series.locator("[data-last]").inner_text())
    expect(series.locator("[data-last]")).not_to_have_text(str(first))
    assert int(series.locator("[data-last]").inner_text()) > first
    page.locator('[data-action="pause-plot"]').click()
    assert "plot=" in page.url


def test_nan_is_a_gap_of_the_plot(page: Page):
    show(page, "topics")
    page.locator('tr[data-topic="/gaps"]').click()
    page.locator('[data-plot="data"]').click()
    value = page.locator('[data-series="/gaps data"] [data-last]')
    for text in (re.compile(r"\d"), re.compile(r"^\D+$"), re.compile(r"\d")):
        expect(value).to_have_text(text)


def test_a_number_in_a_string_of_json_is_plotted(page: Page):
    show(page, "topics")
    page.locator('tr[data-topic="/texts"]').click()
    page.locator('[data-plot="data.count"]').click()
    expect(page.locator('[data-series="/texts data.count"] [data-last]')).to_have_text(
        re.compile(r"\d+")
    )


def test_a_parameter_is_changed_and_refused(page: Page):
    show(page, "parameters")
    page.locator('[data-node="/counter"]').click()
    speed = page.locator('[data-parameter="speed"]')
    expect(speed).to_contain_text("metres per second")
    expect(speed.locator('[data-field="range"]')).to_contain_text("2")
    speed.get_by_role("spinbutton").or_(speed.locator("input")).first.fill("1.5")
    speed.locator('[data-action="set"]').click()
    expect(speed.locator('[data-field="done"]')).to_be_visible()
    page.locator('[data-action="refresh"]').click()
    expect(speed.locator("input").first).to_have_value("1.5")

    mode = page.locator('[data-parameter="mode"]')
    mode.locator("input, textarea").first.fill("run")
    mode.locator('[data-action="set"]').click()
    expect(mode.locator('[data-field="refusal"]')).to_contain_text(REFUSAL)

    serial = page.locator('[data-parameter="serial"]')
    expect(serial).to_contain_text("read")
    expect(serial.locator('[data-action="set"]')).to_have_count(0)


def test_a_service_is_called_by_a_form(page: Page):
    show(page, "services")
    page.locator('[data-service="/reset"]').click()
    page.locator('[data-path="data"]').click()
    page.locator('[data-action="call"]').click()
    expect(page.locator('[data-field="response"]')).to_contain_text("was ")
    expect(page.locator('[data-call="/reset"]').first).to_be_visible()


def test_a_message_is_published_by_a_form(page: Page):
    show(page, "topics")
    page.locator('tr[data-topic="/texts"]').click()
    page.get_by_role("tab", name="Publish").click()
    page.locator('[data-path="data"]').locator("input, textarea").first.fill("from the page")
    page.locator('[data-action="publish"]').click()
    # Only the page's own echo subscribes to it: the answer tells how many got the message.
    expect(page.locator('[data-field="answer"], [data-problem]').first).to_be_visible()


@pytest.mark.parametrize(
    "panel", ["processes", "log", "graph", "topics", "parameters", "services", "timeline", "plan"]
)
def test_hostile_texts_stay_texts(page: Page, panel: str):
    show(page, panel)
    if panel == "topics":
        page.locator('tr[data-topic="/texts"]').click()
        expect(page.locator('[data-field="message"]')).to_contain_text("alert")
    elif panel == "parameters":
        page.locator('[data-node="/counter"]').click()
        expect(page.locator('[data-parameter="serial"]')).to_contain_text("serial")
    elif panel == "processes":
        page.locator('[data-process^="<b>bold"]').first.dblclick()
        expect(page.locator("[data-details]")).to_contain_text("alert")
    elif panel == "log":
        expect(page.locator("[data-line]").filter(has_text="alert(1)").first).to_be_visible()
    elif panel == "plan":
        expect(page.locator('[data-argument="text"]')).to_be_visible()
    # `page` fails with a dialog, or with a violation of the policy on the console.
    made = page.evaluate(
        "document.querySelectorAll('.app-page img, .app-page script, .q-dialog img').length"
    )
    assert made == 0
    assert EVALUATED not in page.locator("body").inner_text()
