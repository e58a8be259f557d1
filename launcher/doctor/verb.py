"""`doctor`: find what is wrong on this machine, and repair it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.model.level import Level
from launcher.base.option import DEBUG, JSON, option
from launcher.base.verb_table import VERBS
from launcher.doctor.checks import check_all
from launcher.doctor.collect import collect
from launcher.doctor.doctor_facts import Finding, WorkspaceFacts
from launcher.doctor.repairs import repair
from launcher.packages.activation import activate
from launcher.packages.workspace import Workspace, current
from launcher.posix.json_output import print_document

COMMAND = Command(
    "doctor",
    VERBS["doctor"],
    about="""\
Check the wheels and their environment, the limits of the system, and what killed runs have
left. Nothing is changed without --fix. `wtf` is the same verb.""",
    options=(
        option(
            "--fix",
            "stop processes whose launcher is gone, remove their shared memory, and check again",
        ),
        option(
            "--uninstall-list",
            "instead, list the files and folders that the launcher has left on this machine, with "
            "the size of each and the command that removes it",
        ),
        option(
            "--report",
            "instead, print what is on this machine and in the ROS graph: platform, variables, "
            "network, packages, nodes, QoS, topics, services, actions",
        ),
        JSON,
        DEBUG,
    ),
    exclusive=(("fix", "uninstall_list", "report"),),
    epilog="exit codes: 0 no problem (notes do not count), 1 a problem, 2 bad command line",
)


def main(words: Sequence[str]) -> int:
    """Check; with --fix, repair and check again. The exit code is that of the last check."""
    options = COMMAND.parse(words)
    if options.uninstall_list:
        from launcher.doctor import remains

        left = remains.remains(os.environ)
        if options.json:
            print_document(remains.as_document(left))
        else:
            print(remains.as_text(left))
        return ExitCode.OK
    workspace = _workspace()
    if options.report:
        return _report(as_json=options.json)
    facts = collect(os.environ, workspace)
    done: list[str] = []
    if options.fix:
        done = repair(facts)
        facts = collect(os.environ, workspace)
    findings = check_all(facts)
    if options.json:
        print_document(as_document(findings, done))
    else:
        print(as_text(findings, done))
    is_well = all(finding.level is not Level.PROBLEM for finding in findings)
    return ExitCode.OK if is_well else ExitCode.PROCESS_FAILED


def _report(*, as_json: bool) -> int:
    from launcher.doctor import report
    from launcher.posix.domains import environment_domain, usual_spin_time_s
    from launcher.ros.verb import GraphAccess, snapshot_at

    graph = snapshot_at(GraphAccess(environment_domain(), usual_spin_time_s(), "doctor"))
    sections = report.report(os.environ, graph)
    if as_json:
        print_document({"sections": [section.document() for section in sections]})
    else:
        print(report.as_text(sections))
    return ExitCode.OK


def _workspace() -> WorkspaceFacts | None:
    """Inspect the workspace, and use it as a launch does, if its environment can be read."""
    from launcher.doctor.stale_workspace import inspect
    from launcher.workspace.building.build_place import unbuilt

    found = current()
    if found is None:
        place = unbuilt()
        if place is None:
            return None
        return inspect(Workspace(place.root, place.install), dict(os.environ))
    facts = inspect(found, dict(os.environ))
    if facts.error is None:
        activate(found)
    return facts


def as_text(findings: Sequence[Finding], done: Sequence[str]) -> str:
    """What was done, then one line per finding, with the advice below it."""
    width = max(len(finding.name) for finding in findings)
    lines = [f"fixed: {sentence}" for sentence in done]
    for finding in findings:
        lines.append(f"{finding.level.value:<8} {finding.name:<{width}}  {finding.text}")
        if finding.advice is not None:
            lines.append(f"{'':<{9 + width}}  -> {finding.advice}")
    return "\n".join(lines)


def as_document(findings: Sequence[Finding], done: Sequence[str]) -> dict[str, Any]:
    """`well` is whether there is no problem; `fixed` is what --fix did."""
    entries = [
        {
            "check": finding.name,
            "level": finding.level.value,
            "text": finding.text,
            "advice": finding.advice,
            "fixable": finding.fixable,
        }
        for finding in findings
    ]
    well = all(finding.level is not Level.PROBLEM for finding in findings)
    return {"well": well, "fixed": list(done), "findings": entries}
