"""When the processes of a plan are ready, and what they wait for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launcher.base.model.run_options import matches
from launcher.base.model.supervision import restarts_with, rule_for, waits_for

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from launcher.base.model.supervision import Fact
    from launcher.launch.plan.plan import Plan, PlannedProcess


def start_lines(
    plan: Plan, process: PlannedProcess, shown: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """The lines below a process in the tree; `shown` are the names of all processes there."""
    if not plan.start_rules:
        return
    spec, specs = process.spec, [one.spec for one in plan.processes]
    names_of = dict(zip((one.name for one in specs), shown, strict=True))
    rule = rule_for(plan.start_rules, spec)
    if rule.after is not None and rule.after.names:
        absent = [f"{name} ({_absence(plan, name)})" for name in _absent(plan, rule.after.names)]
        awaited = [names_of[name] for name in waits_for(rule, spec.name, specs)]
        names = ", ".join([*awaited, *absent])
        then = f"at most {rule.after.timeout_s:g} s, then {rule.after.on_timeout}"
        yield "aside", f"starts when ready: {names}; {then}"
    if rule.ready_when:
        yield "aside", f"ready with: {', '.join(fact.text for fact in rule.ready_when)}"
    if rule.restart_with:
        others = [names_of[name] for name in restarts_with(rule, spec.name, specs)]
        names = ", ".join(others) or "no process"
        yield "aside", f"restarted with: {names}"


def _absent(plan: Plan, names: tuple[str, ...]) -> list[str]:
    return [name for name in names if not any(matches(name, one.spec) for one in plan.processes)]


def _absence(plan: Plan, name: str) -> str:
    is_off = any(matches(name, spec) for spec in plan.switched_off)
    return "switched off, not waited for" if is_off else "no process"


def start_document(plan: Plan, process: PlannedProcess) -> dict[str, Any]:
    """The entries of a process in the document of a plan with a supervision file."""
    spec, specs = process.spec, [one.spec for one in plan.processes]
    numbers = {one.name: number for number, one in enumerate(specs)}
    rule = rule_for(plan.start_rules, spec)
    after = None
    if rule.after is not None and rule.after.names:
        after = {
            "names": list(rule.after.names),
            "processes": [numbers[name] for name in waits_for(rule, spec.name, specs)],
            "timeout": rule.after.timeout_s,
            "on_timeout": rule.after.on_timeout,
        }
    return {
        "ready_when": [_fact(fact) for fact in rule.ready_when or ()],
        "after": after,
        "restart_with": [numbers[name] for name in restarts_with(rule, spec.name, specs)],
    }


def _fact(fact: Fact) -> dict[str, Any]:
    return {"kind": fact.kind, "subject": fact.subject, "node": fact.node or None}
