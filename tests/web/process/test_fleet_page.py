"""The page in a real Chromium: each panel against the running fleet."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import page_at
from tests.support.controlled_run import ControlledRun
from tests.support.drawing import CAN_DRAW, HOW_TO_DRAW
from tests.support.waiting import wait_until
from tests.web.process.conftest import starting

pytestmark = pytest.mark.browser

ROBOT = "robot_1-3"
HAS_MORE_LINES = """(() => {
  const list = document.querySelector('[data-shown="log"] .window');
  return list.scrollHeight > list.clientHeight;
})()"""


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ControlledRun, str]]:
    """The fleet with a subscription that does not match."""
    with starting(tmp_path_factory.mktemp("fleet")) as start:
        yield start("system", "enable_debug:=true", "enable_qos_probe:=true")


@pytest.fixture
def page(started: Browser, fleet: tuple[ControlledRun, str]) -> Iterator[Page]:
    with page_at(started, fleet[1], viewport={"width": 1280, "height": 800}) as open_page:
        expect(open_page.locator(".app-link")).to_have_text("open")
        yield open_page


def show(page: Page, panel: str) -> None:
    """Go to a panel as a person does."""
    page.locator(f'[data-panel="{panel}"]').click()
    page.wait_for_selector(f'[data-shown="{panel}"]')


def row(page: Page, name: str = ROBOT):
    return page.locator(f'tr[data-process="{name}"]')


def test_processes_are_shown_with_what_they_use(page: Page):
    expect(row(page)).to_have_attribute("data-state", "RUNNING")
    expect(row(page)).to_contain_text(re.compile(r"\d+(\.\d)? [kM]B"))
    expect(row(page)).to_contain_text(re.compile(r"\d+\.\d %"))
    expect(row(page).locator("svg").first).to_be_visible()


def test_a_robot_is_killed_and_started_from_the_page(page: Page, fleet):
    run, _ = fleet
    before = run.row("robot_1")["pid"]

    row(page).locator('[data-action="kill"]').click()
    page.locator('[data-action="confirm-kill"]').click()

    expect(row(page)).not_to_have_attribute("data-state", "RUNNING")
    expect(page.locator("[data-answers]")).to_contain_text(ROBOT)
    assert run.row("robot_1")["state"] != "RUNNING"
    row(page).locator('[data-action="start"]').click()
    expect(row(page)).to_have_attribute("data-state", "RUNNING")
    assert run.row("robot_1")["pid"] not in (None, before)


def test_several_are_muted_at_once(page: Page, fleet):
    run, _ = fleet
    for name in (ROBOT, "monitor-2"):
        row(page, name).locator('input[type="checkbox"]').check()
    selection = page.locator("[data-selection]")
    selection.locator('[data-action="mute"]').click()
    wait_until(lambda: run.row("monitor")["muted"] and run.row("robot_1")["muted"], "both muted")
    expect(row(page).locator('[data-mark*="mute"]')).to_be_visible()
    selection.locator('[data-action="unmute"]').click()
    wait_until(lambda: not run.row("monitor")["muted"], "unmuted")


def test_what_the_launcher_refuses_is_shown(page: Page, fleet):
    run, _ = fleet
    run.ask("stop", "debug_logger")
    expect(row(page, "debug_logger-5")).to_have_attribute("data-state", "STOPPED")
    stop = row(page, "debug_logger-5").locator('[data-action="stop"]')
    expect(stop).to_be_disabled()
    row(page, "debug_logger-5").locator('[data-action="start"]').click()
    expect(row(page, "debug_logger-5")).to_have_attribute("data-state", "RUNNING")


def test_the_details_of_a_process_are_shown(page: Page):
    row(page).dblclick()
    details = page.locator(f'[data-details="{ROBOT}"]')
    expect(details.locator('[data-field="command"]')).to_contain_text("__node:=robot_1")
    expect(details.locator('[data-field="lines"]')).to_contain_text(re.compile("[Tt]ask"))
    page.keyboard.press("Escape")
    expect(details).to_be_hidden()


def test_the_keyboard_alone_will_do(page: Page):
    page.keyboard.press("2")
    page.wait_for_selector('[data-shown="log"]')
    page.keyboard.press("1")
    page.wait_for_selector('[data-shown="processes"]')
    page.keyboard.press("/")
    page.keyboard.type("robot_2")
    expect(page.locator("tr[data-process]")).to_have_count(1)
    page.keyboard.press("Escape")  # empties the field
    page.keyboard.press("Escape")  # leaves it
    expect(page.locator("tr[data-process]")).to_have_count(7)
    dark = page.locator("body.body--dark")
    expect(dark).to_have_count(0)
    page.keyboard.press("t")
    expect(dark).to_have_count(1)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_contain_text("light or dark")


def test_lines_leave_out_what_columns_say_until_the_reader_wants_it(page: Page):
    show(page, "log")
    page.locator("[data-search] input").fill("Fleet report")
    line = page.locator('[data-line][data-of="monitor-2"] .line-text').first
    expect(line).to_have_text(re.compile("^Fleet report"))
    page.locator('[data-action="short"]').click()
    expect(line).to_have_text(re.compile(r"^\[INFO\] \[\d+\.\d+\] \[monitor\]: Fleet report"))


def test_the_log_is_filtered_and_tells_its_neighbours(page: Page, tmp_path: Path):
    show(page, "log")
    expect(page.locator("[data-line]").first).to_be_visible()
    page.locator("[data-search] input").fill("Fleet report")
    expect(page.locator("[data-line]").first).to_contain_text("Fleet report")
    expect(page.locator('[data-line][data-of="robot_1-3"]')).to_have_count(0)
    page.locator("[data-line]").last.click()
    expect(page.locator("[data-context]")).to_be_visible()
    expect(page.locator('[data-context] [data-of="dispatcher-1"]').first).to_be_visible()

    with page.expect_download() as download:
        page.locator('[data-action="download"]').click()
    text = Path(download.value.path()).read_text()
    assert text and all("Fleet report" in line for line in text.splitlines())
    assert "\x1b" not in text


def test_an_expression_that_is_wrong_or_slow_is_told(page: Page):
    show(page, "log")
    page.locator('[data-action="regex"]').click()
    page.locator("[data-search] input").fill("(fleet")
    expect(page.locator("[data-problem]")).to_be_visible()
    page.locator("[data-search] input").fill(r"(\w+\s?)+\$$")
    # The page answers while it searches, however long that takes.
    show(page, "processes")
    expect(row(page)).to_be_visible()


def test_the_log_pauses_when_one_scrolls_up(page: Page):
    show(page, "log")
    expect(page.locator("[data-follow-state]")).to_have_text("follows the end")
    page.wait_for_function(HAS_MORE_LINES)
    page.locator("[data-line]").first.hover()
    page.mouse.wheel(0, -400)
    expect(page.locator("[data-follow-state]")).to_have_text("paused")
    page.locator('[data-action="follow"]').click()
    expect(page.locator("[data-follow-state]")).to_have_text("follows the end")


def test_the_graph_says_what_does_not_match(page: Page):
    show(page, "graph")
    mismatch = page.locator('[data-mismatch="/fleet/status"]')
    expect(mismatch).to_contain_text("RELIABILITY")
    expect(page.locator('.graph-item[data-topic="/fleet/tasks"]')).to_contain_text("latched")
    expect(page.locator('.graph-item[data-topic="/fleet/tasks"]')).to_contain_text("Hz")
    expect(page.locator(".graph-canvas svg text").filter(has_text="/dispatcher")).to_be_visible()
    assert page.locator('.graph-item[data-topic="/rosout"]').count() == 0
    page.locator('.graph-item[data-topic="/fleet/tasks"]').click()
    details = page.locator('[data-details="/fleet/tasks"]')
    expect(details).to_contain_text("TRANSIENT_LOCAL")
    expect(details).to_contain_text("std_msgs/msg/String")
    expect(details.locator('[data-field="last"]')).to_contain_text("robot_")


@pytest.mark.skipif(not CAN_DRAW, reason=HOW_TO_DRAW)
def test_the_graph_is_turned_where_it_is_narrow(started: Browser, fleet):
    def is_below(width: int) -> bool:
        """Whether the picture goes from top to bottom."""
        viewport = {"width": width, "height": 800}
        with page_at(started, fleet[1] + "#/graph", viewport=viewport) as page:
            label = page.locator(".graph-canvas svg text")
            first, last = (label.filter(has_text=one).first for one in ("/dispatcher", "/monitor"))
            expect(last).to_be_visible()
            above, below = first.bounding_box(), last.bounding_box()
            assert above and below
            return abs(below["y"] - above["y"]) > abs(below["x"] - above["x"])

    assert is_below(400)
    assert not is_below(2560)


def test_a_node_that_died_stays_grey_where_it_was(page: Page, fleet):
    run, _ = fleet
    show(page, "graph")
    node = page.locator('.graph-item[data-node="/robot_3"]')
    expect(node).to_have_attribute("data-state", "running")
    label = page.locator(".graph-canvas svg text").filter(has_text="/dispatcher").first
    expect(label).to_be_visible()
    place = label.bounding_box()

    run.ask("kill", "robot_3", signal="SIGKILL")

    expect(node).to_have_attribute("data-state", re.compile("gone|ghost"))
    assert label.bounding_box() == place
    run.ask("start", "robot_3")
    expect(node).to_have_attribute("data-state", "running")
    assert label.bounding_box() == place


def test_topics_have_rates_and_their_messages_can_be_read(page: Page):
    show(page, "topics")
    topic = page.locator('tr[data-topic="/fleet/report"]')
    expect(topic.locator('[data-column="rate_hz"]')).to_have_text(re.compile(r"\d\.\d"))
    expect(topic.locator('[data-column="publishers"]')).to_have_text("1")
    page.locator('tr[data-topic="/fleet/tasks"]').click()
    expect(page.locator('[data-field="message"]')).to_contain_text("robot_id")


def test_the_timeline_leads_to_the_log(page: Page, fleet):
    run, _ = fleet
    run.ask("restart", "robot_2")
    show(page, "timeline")
    lane = page.locator('[data-lane="robot_2-4"]')
    expect(lane.locator("[data-bar]").first).to_be_visible()
    event = page.locator('[data-event="ended"][data-of="robot_2-4"]').last
    event.click()
    page.locator('[data-action="to-log"]').click()
    page.wait_for_selector('[data-shown="log"]')
    expect(page.locator("[data-follow-state]")).to_have_text("paused")


def test_the_plan_has_the_tree_and_what_became_of_it(page: Page):
    show(page, "plan")
    expect(page.locator('[data-process="robot_3-7"], [data-process="robot_3-5"]')).to_be_visible()
    expect(page.locator('[data-kind="scope"], [data-kind="event"]').first).to_be_visible()
    expect(page.locator('[data-argument="start_robot_2"]')).to_be_visible()


@pytest.mark.parametrize(("width", "height"), [(400, 800), (1280, 800), (3840, 2160)])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_nothing_is_wider_than_the_window(
    started: Browser, fleet, width: int, height: int, theme: str
):
    viewport = {"width": width, "height": height}
    with page_at(started, fleet[1], viewport=viewport, color_scheme=theme) as page:
        for number in range(1, 9):
            page.wait_for_selector(".app-page")
            page.locator("body").press(str(number))
            page.wait_for_function("document.querySelector('.app-page').children.length > 0")
            over = page.evaluate(
                "document.documentElement.scrollWidth - document.documentElement.clientWidth"
            )
            assert over <= 0, f"panel {number} at {width} pixels"
