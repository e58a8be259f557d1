"""The page of an incident in a browser: it loads nothing, and fits on every screen."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from launcher.faults.incident import document, page
from launcher.faults.incident.bag_place import BagPlace
from tests.faults.unit.test_incident_page import PIECES, poisoned
from tests.support.browser import page_at
from tests.support.incidents import incident_document

pytestmark = pytest.mark.browser

SIZES = (
    {"width": 390, "height": 844},
    {"width": 1280, "height": 800},
    {"width": 1920, "height": 1080},
)
BAG = b"PK of the bag"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """An incident as it should be, and one full of hostile texts."""
    folder = tmp_path_factory.mktemp("incidents")
    bag = BagPlace(path="/x/bag", total=9, archive=BAG).markup("incident-3")
    found = []
    for name, given in (
        ("plain", incident_document()),
        ("hostile", poisoned(incident_document(title="x" * 300), seed=len(PIECES) // 2)),
    ):
        incident = document.from_value(given)
        found.append(folder / f"{name}.html")
        found[-1].write_text(page.document(incident, page.render(incident), bag), encoding="utf-8")
    return found


@pytest.mark.parametrize(("size", "scheme"), [*itertools.product(SIZES, ("light", "dark"))])
def test_it_fits_and_loads_nothing(
    started: Browser, files: list[Path], size: dict[str, int], scheme: str
):
    for file in files:
        with page_at(started, "about:blank", viewport=size, color_scheme=scheme) as tab:
            requests: list[str] = []
            tab.on("request", lambda request, to=requests: to.append(request.url))
            tab.goto(file.as_uri())
            tab.evaluate("document.querySelectorAll('details').forEach((one) => one.open = true)")

            assert requests == [file.as_uri()]
            width = tab.evaluate("document.documentElement.scrollWidth")
            assert width == size["width"], file
            expect(tab.locator("h1")).to_be_in_viewport()
            assert tab.locator(".drawing svg").count() == 2
            assert tab.evaluate(OUTSIDE) == [], file


# Elements of the text that stick out of their section; drawings have a scroll bar.
OUTSIDE = """() => [...document.querySelectorAll("section *")].filter((one) => {
  if (one.closest("svg") || one.closest(".drawing") || !one.getClientRects().length) return false;
  const box = one.getBoundingClientRect(), around = one.closest("section").getBoundingClientRect();
  return box.width && (box.right > around.right + 1 || box.left < around.left - 1);
}).map((one) => one.outerHTML.slice(0, 200))"""


def test_the_log_can_be_reduced_to_problems_without_a_script(started: Browser, files: list[Path]):
    with page_at(started, files[0].as_uri(), java_script_enabled=False) as tab:
        lines = tab.locator(".log li")
        assert lines.filter(visible=True).count() > 60

        tab.get_by_label("Only warnings, errors and evidence").check()

        assert 5 < lines.filter(visible=True).count() < 15
        expect(lines.filter(has=tab.locator("mark"))).to_be_visible()


def test_the_bag_is_saved_by_a_click(started: Browser, files: list[Path]):
    with page_at(started, files[0].as_uri()) as tab:
        with tab.expect_download() as waiting:
            tab.get_by_role("link", name="incident-3-bag.zip").click()

        assert waiting.value.suggested_filename == "incident-3-bag.zip"
        assert Path(waiting.value.path()).read_bytes() == BAG


def test_texts_have_contrast(started: Browser, files: list[Path]):
    for scheme in ("light", "dark"):
        with page_at(started, files[0].as_uri(), color_scheme=scheme) as tab:
            assert tab.evaluate(FAINT) == [], scheme


# Texts whose contrast with what is behind them is below 4.5, as WCAG wants.
FAINT = """() => {
  const parse = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255)
    .map((v) => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (one) => {
    for (let at = one; at; at = at.parentElement) {
      const colour = parse(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  return [...document.querySelectorAll("body *")].filter((one) => {
    if (one.closest("svg") || ![...one.childNodes].some((n) => n.nodeType === 3 && n.data.trim()))
      return false;
    const [a, b] = [light(parse(getComputedStyle(one).color)), light(behind(one))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5;
  }).map((one) => one.outerHTML.slice(0, 120));
}"""
