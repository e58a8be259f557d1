"""What the launch file started: the commands, without secrets."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.text import count
from launcher.faults.incident.document import IncidentDocument, label_of
from launcher.faults.incident.limits import PageLimits, clipped
from launcher.faults.incident.markup import EMPTY, Markup, details, join, section, tag
from launcher.faults.incident.parts.fault_tree import block

MAX_PROCESSES = 300
MAX_COMMAND = 4000  # characters
MAX_PARAMETERS = 100_000


def plan(
    incident: IncidentDocument, document: Mapping[str, Any] | None, limits: PageLimits
) -> Markup:
    """`document` is the plan of the run without secrets; None if there is none."""
    found = (document or {}).get("processes")
    rows = [one for one in found if isinstance(one, Mapping)] if isinstance(found, list) else []
    labels = {label_of(name) for name in incident.processes_in_question}
    ours = [one for one in rows if one.get("label") in labels]
    others = [one for one in rows if one.get("label") not in labels][: limits.of(MAX_PROCESSES)]
    declared = (document or {}).get("declared")
    shown = join(map(_process, ours))
    if others and not ours:
        shown = join(map(_process, others))
    elif others:
        more = f"{count(len(others), 'other process')}"
        shown = join([shown, details(more, *map(_process, others))])
    return section(
        "plan",
        "What was started",
        shown,
        _arguments(declared),
        _parameters(incident.parameters, limits),
    )


def _process(process: Mapping[str, Any]) -> Markup:
    command = process.get("cmd")
    words = [str(one) for one in command] if isinstance(command, list) else []
    line = clipped(shlex.join(words), MAX_COMMAND)
    rows = [tag("h3", str(process.get("label") or "?")), block(line)]
    rows.append(tag("p", *_extras(process), class_="muted small"))
    return tag("article", *rows, class_="card")


def _extras(process: Mapping[str, Any]) -> list[str]:
    words = []
    package, executable = process.get("package"), process.get("executable")
    if isinstance(package, str) and isinstance(executable, str):
        words.append(f"package {package}, executable {executable}")
    if isinstance(process.get("cwd"), str):
        words.append(f"in {process['cwd']}")
    if process.get("respawn") is True:
        words.append("is started again when it ends")
    variables = process.get("env_set")
    if isinstance(variables, Mapping) and variables:
        words.append(" ".join(f"{name}={value}" for name, value in sorted(variables.items())))
    return ["; ".join(words)]


def _arguments(declared: object) -> Markup:
    if not isinstance(declared, Mapping) or not declared:
        return EMPTY
    rows = [
        tag("tr", tag("th", str(name), scope="row"), tag("td", str(value)))
        for name, value in declared.items()
    ]
    return details("Arguments of the launch file", tag("table", tag("tbody", *rows)))


def _parameters(value: Any, limits: PageLimits) -> Markup:
    if not isinstance(value, (Mapping, Sequence)) or not value:
        return EMPTY
    text = strict_json.dumps(value, indent=1, ensure_ascii=False)
    return details("Parameters", block(clipped(text, limits.of(MAX_PARAMETERS))))
