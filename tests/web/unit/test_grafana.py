"""The dashboard and docs/guides/metrics.md name the metrics that there are, and all of them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from launcher.web.metrics import DEFINITIONS, FAULT_STATES, NODE_STATES, STATES
from tests.support.repository import DOCS, docs_page

DASHBOARD: dict[str, Any] = json.loads(
    (DOCS / "assets" / "grafana.json").read_text(encoding="utf-8")
)
LABELS = {one.name: set(one.labels) for one in DEFINITIONS}
OF_PROMETHEUS = {"instance", "job"}
SELECTOR = re.compile(r"\b(launcher_\w+)(?:\{([^}]*)\})?")
MATCHER = re.compile(r'(\w+)(?:=~|!~|!=|=)"([^"]*)"')
GROUPING = re.compile(r"\b(?:by|without|on|ignoring)\s*\(([^)]*)\)")
LABEL_VALUES = re.compile(r"label_values\((.+), (\w+)\)")


def queries() -> Iterator[tuple[str, str, str]]:
    """(title, expression, legend) of every query, and of the variables."""
    for panel in DASHBOARD["panels"]:
        for target in panel.get("targets", ()):
            yield panel["title"], target["expr"], target["legendFormat"]
    for variable in DASHBOARD["templating"]["list"]:
        if variable["type"] == "query":
            found = LABEL_VALUES.fullmatch(variable["query"]["query"])
            assert found is not None, variable["name"]
            yield variable["name"], found[1], f"{{{{{found[2]}}}}}"


@pytest.mark.parametrize(("title", "expression", "legend"), [*queries()])
def test_a_query_names_what_there_is(title: str, expression: str, legend: str):
    selectors = SELECTOR.findall(expression)
    assert selectors, title
    known = set(OF_PROMETHEUS)
    for name, matchers in selectors:
        assert name in LABELS
        known |= LABELS[name]
        labels = {label for label, _ in MATCHER.findall(matchers)}
        assert labels <= LABELS[name] | OF_PROMETHEUS, name
    grouped = {word.strip() for words in GROUPING.findall(expression) for word in words.split(",")}
    used = {*re.findall(r"\{\{\s*(\w+)\s*\}\}", legend), *grouped}
    assert used <= known
    if "sum" in expression:
        assert set(re.findall(r"\{\{\s*(\w+)\s*\}\}", legend)) <= grouped


def test_the_dashboard_shows_every_metric():
    shown = {name for _, expression, _ in queries() for name, _ in SELECTOR.findall(expression)}
    assert shown == LABELS.keys()


def test_counters_are_read_as_counters_and_gauges_as_gauges():
    of_counters = re.compile(r"\b(?:rate|increase)\((launcher_\w+)")
    for title, expression, _ in queries():
        for name in of_counters.findall(expression):
            assert name.endswith("_total"), title


def test_variables_and_data_sources_are_declared():
    variables = {one["name"] for one in DASHBOARD["templating"]["list"]}
    text = json.dumps(DASHBOARD)
    used = set(re.findall(r"\$\{?([a-z]\w*)", text))
    assert used == variables
    assert "datasource" in variables
    for panel in DASHBOARD["panels"]:
        if panel["type"] != "row":
            assert panel["datasource"] == {"type": "prometheus", "uid": "${datasource}"}


def test_panels_do_not_overlap_and_have_ids():
    panels = DASHBOARD["panels"]
    assert len({panel["id"] for panel in panels}) == len(panels)
    taken: set[tuple[int, int]] = set()
    for panel in panels:
        at = panel["gridPos"]
        cells = {
            (x, y)
            for x in range(at["x"], at["x"] + at["w"])
            for y in range(at["y"], at["y"] + at["h"])
        }
        assert not cells & taken, panel["title"]
        assert at["x"] + at["w"] <= 24
        taken |= cells


def test_the_manual_has_every_metric_with_its_labels():
    text = docs_page("metrics")
    rows = dict(re.findall(r"^\| `(launcher_\w+)` \|([^|]*)\|", text, re.MULTILINE))
    found = {name: set(re.findall(r"`(\w+)`", labels)) for name, labels in rows.items()}
    assert found == LABELS


def test_the_manual_has_the_values_of_the_labels():
    text = docs_page("metrics")
    assert all(f"`{state}`" in text for state in (*STATES, *NODE_STATES, *FAULT_STATES))
