"""The page of an incident: one HTML file without scripts, which loads nothing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from launcher import __version__
from launcher.faults.incident.document import IncidentDocument
from launcher.faults.incident.limits import PageLimits
from launcher.faults.incident.markup import Markup, join, plain, section, tag
from launcher.faults.incident.parts import (
    fault_tree,
    graph_section,
    log_excerpt,
    plan_table,
    plots,
    summary,
    timeline,
)
from launcher.faults.incident.parts.span import span_of

MAX_BYTES = 3_000_000  # of the file, a bag in it included
_MAX_PAGE = 2_400_000  # without the bag
_FACTORS = (1.0, 0.5, 0.25, 0.1, 0.04, 0.01)
_STYLE = Path(__file__).with_name("page.css")
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def render(incident: IncidentDocument, plan: Mapping[str, Any] | None = None) -> Markup:
    """The body of the page, at most 2.4 MB; `plan` is the plan of the run without secrets.

    Of an incident that is too large, each part shows less.
    """
    body = Markup("")
    for factor in _FACTORS:
        body = _body(incident, plan, PageLimits(factor))
        if len(body.encode()) <= _MAX_PAGE:
            break
    return body


def document(incident: IncidentDocument, body: Markup, bag: Markup) -> str:
    """The file: a body of `render`, and the section about the bag."""
    title = plain(incident.title)
    head = [
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=_POLICY),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("meta", name="generator", content=f"launcher {__version__}"),
        tag("title", title),
        Markup(f"<style>{_STYLE.read_text(encoding='utf-8')}</style>"),
    ]
    main = tag("main", body, bag, _problems(incident), _footer())
    page = tag("html", tag("head", *head), tag("body", main), lang="en")
    return f"<!doctype html>\n{page}\n"


def _body(incident: IncidentDocument, plan: Mapping[str, Any] | None, limits: PageLimits) -> Markup:
    span = span_of(incident)
    sections = [
        summary.facts(incident),
        summary.causes(incident, limits),
        fault_tree.faults(incident, limits),
        timeline.timeline(incident, span, limits),
        graph_section.graphs(incident, limits),
        plots.topics(incident, span, limits),
        plots.processes(incident, span, limits),
        plots.machine(incident, span),
        log_excerpt.log(incident, limits),
        plan_table.plan(incident, plan, limits),
    ]
    return join([summary.heading(incident), *sections])


def _problems(incident: IncidentDocument) -> Markup:
    rows = tag("ul", *(tag("li", one) for one in incident.problems))
    return section("problems", "What could not be read", rows) if incident.problems else Markup("")


def _footer() -> Markup:
    about = (
        f"Written by launcher {__version__}. Values of environment variables, and what looks like "
        "a password or a token, are left out. Times are those of the machine that wrote this file; "
        "offsets count from the opening of the incident."
    )
    return tag("footer", about)
