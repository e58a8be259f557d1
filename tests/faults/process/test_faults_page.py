"""The panel of faults: what the watcher reports, what users decide, and a page that only shows."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from tests.support.benches import HEAD
from tests.support.browser import page_at
from tests.support.waiting import wait_until
from tests.support.watcher_stand_in import IN_PLACE, Reports
from tests.web.process.conftest import Start

pytestmark = pytest.mark.browser

MUTE = """
() => import("page/feed.js").then((feed) => feed.run("faults", [], { mute: "robot_1 reports" }))
  .catch((error) => error.code)
"""
HOSTILE = "<b>bold</b> \u202ereversed"


def launch_file(folder: Path) -> Path:
    file = folder / "watched.launch.py"
    file.write_text(f'{HEAD}{IN_PLACE} sh("exec cat", name="cat")\n    ])\n')
    return file


def test_faults_come_are_decided_and_heal(started: Browser, start: Start, tmp_path: Path):
    reports, file = Reports(tmp_path), launch_file(tmp_path)
    _, link = start(file, "--watchful", **reports.env)
    with page_at(started, f"{link}#/faults") as page:
        expect(page.locator(".faults-panel")).to_contain_text("All expectations hold.")
        badge = page.locator("[data-active-faults]")
        expect(badge).to_have_count(0)
        reports.fault("suspected", name="a guess", state="suspected", count=0, confirmed_s=None)
        reports.fault("confirmed", lines=["\x1b[31mred\x1b[0m"], message={"robot": HOSTILE})
        reports.fault("confirmed", name=HOSTILE, follows="robot_1 reports", cause=None)
        expect(badge).to_have_text("2")
        rows = page.locator("tr[data-fault]")
        names = rows.evaluate_all("all => all.map((one) => one.dataset.fault)")
        assert names == ["robot_1 reports", HOSTILE, "a guess"]
        reports.fault("dismissed", name="a guess", state="healed", count=0, confirmed_s=None)
        expect(rows).to_have_count(2)

        page.locator('[data-fault="robot_1 reports"]').click()
        details = page.locator('[data-details="robot_1 reports"]')
        expect(details.locator('[data-field="cause"]')).to_have_text("cat-1 was killed (SIGKILL)")
        expect(details.locator('[data-field="lines"]')).to_have_text("red")
        expect(details).to_contain_text(HOSTILE)
        details.get_by_label("Reason").fill("the battery is changed")
        details.locator('[data-action="acknowledge"]').click()
        facts = details.locator('[data-field="acknowledged"]')
        expect(facts).to_have_text("the battery is changed")
        expect(badge).to_have_text("2")
        details.locator('[data-action="mute"]').click()
        expect(badge).to_have_text("1")
        details.locator('[data-action="unmute"]').click()
        expect(badge).to_have_text("2")

        reports.fault("healed", state="healed", healed_s=reports.now())
        reports.fault("healed", name=HOSTILE, state="healed", healed_s=reports.now())
        expect(badge).to_have_count(0)
        expect(details.locator('[data-action="acknowledge"]')).to_have_count(0)
        details.locator('[data-action="to-timeline"]').click()
        expect(page.locator('.event[data-event="fault healed"]')).to_have_count(2)


def test_a_page_that_only_shows_has_no_buttons(started: Browser, start: Start, tmp_path: Path):
    reports, file = Reports(tmp_path), launch_file(tmp_path)
    reports.fault("confirmed")
    run, link = start(file, "--watchful", "--web-read-only", **reports.env)
    wait_until(lambda: run.ask("faults")["faults"], "the fault")
    with page_at(started, f"{link}#/faults?fault=robot_1+reports") as page:
        details = page.locator("[data-details]")
        expect(details).to_contain_text("at least 4 Hz")
        expect(page.locator("[data-action=acknowledge], [data-action=mute]")).to_have_count(0)
        assert page.evaluate(MUTE) == "read-only"
