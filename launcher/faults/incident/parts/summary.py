"""The head of the page: the cause in one sentence, and what was run when."""

from __future__ import annotations

import os
from collections.abc import Iterator

from launcher.base.text import count
from launcher.faults.incident.document import IncidentDocument, ReportedCause
from launcher.faults.incident.limits import PageLimits
from launcher.faults.incident.markup import EMPTY, Markup, join, section, tag
from launcher.faults.incident.markup import facts as fact_list
from launcher.faults.incident.parts.span import date, length, offset

MAX_CAUSES = 50


def heading(incident: IncidentDocument) -> Markup:
    target = os.path.basename(_text(incident, "target"))
    what = f"Incident {incident.number}" if incident.number else "Snapshot"
    over = join(filter(None, [what, target]), " · ")
    state = _state(incident)
    return tag(
        "header",
        tag("p", over, class_="over"),
        tag("h1", incident.title),
        tag(
            "p",
            tag("span", state, class_=f"badge {_style(incident)}"),
            " ",
            tag("span", f"opened {date(incident.opened_s)}"),
            class_="when",
        ),
    )


def _style(incident: IncidentDocument) -> str:
    if incident.number == 0:
        return "plain"
    return "bad" if incident.closed_s is None else "good"


def _state(incident: IncidentDocument) -> str:
    if incident.closed_s is not None:
        return f"closed after {length(incident.closed_s - incident.opened_s)}"
    return "still open when this was written" if incident.number else "a snapshot of one moment"


def facts(incident: IncidentDocument) -> Markup:
    """Run, launch file, arguments, versions."""
    return section("run", "Run", fact_list(_rows(incident), "facts small"))


def _rows(incident: IncidentDocument) -> Iterator[tuple[str, object]]:
    run, versions = incident.run, incident.versions
    yield "Launch file", _shown(versions.get("launch_file")) or _shown(run.get("target"))
    arguments = run.get("arguments")
    if isinstance(arguments, list) and arguments:
        yield "Arguments", join((tag("code", str(one)) for one in arguments), " ")
    started = run.get("started_wall_s")
    if isinstance(started, (int, float)):
        before = length(incident.opened_s - started)
        yield "Started", f"{date(started)}, {before} before the incident"
    pid = _shown(run.get("pid"))
    yield "Run", join(filter(None, [_shown(run.get("id")), pid and f"pid {pid}"]), ", ")
    yield "ROS domain", _shown(run.get("domain_id"))
    yield "Launcher", incident.launcher or _shown(versions.get("launcher"))
    yield "ROS", incident.ros
    yield "Version of the files", _shown(versions.get("git")) or _shown(versions.get("version"))
    digest = _shown(versions.get("hash"))
    yield "Hash of the files", tag("code", digest) if digest else None
    folder = _shown(run.get("log_dir"))
    yield "Log folder", tag("code", folder) if folder else None


def _shown(value: object) -> str:
    return str(value) if isinstance(value, (str, int)) and not isinstance(value, bool) else ""


def _text(incident: IncidentDocument, key: str) -> str:
    return _shown(incident.run.get(key)) or _shown(incident.versions.get("launch_file"))


def causes(incident: IncidentDocument, limits: PageLimits) -> Markup:
    """What the rules have found, in the order of time."""
    found = sorted(incident.causes, key=lambda one: one.at_s or 0.0)[: limits.of(MAX_CAUSES)]
    if not found:
        return EMPTY
    rows = tag("ol", *(_cause(one, incident.opened_s) for one in found), class_="causes")
    title = "Cause" if len(found) == 1 else count(len(found), "cause").capitalize()
    return section("causes", title, rows)


def _cause(cause: ReportedCause, zero_s: float) -> Markup:
    at = EMPTY if cause.at_s is None else tag("span", offset(cause.at_s, zero_s), class_="offset")
    rule = tag("span", f"rule: {cause.rule}", class_="muted small") if cause.rule else EMPTY
    return tag("li", at, tag("span", cause.text), rule)
