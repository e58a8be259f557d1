"""Judges: pure functions (expectation, facts) -> verdict, one for each kind of expectation."""

from __future__ import annotations

from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.judges import (
    answers,
    graph,
    likeness,
    logs,
    processes,
    relations,
    run,
    timeliness,
    traffic,
)
from launcher.smoke.observe.facts import Facts

JUDGES = {
    "node": graph.node,
    "topic": graph.topic,
    "qos": graph.qos,
    "rate": traffic.rate,
    "gap": timeliness.gap,
    "latency": timeliness.latency,
    "message": traffic.message,
    "unique": relations.unique,
    "refers": relations.refers,
    "tally": relations.tally,
    "log": logs.log,
    "order": logs.order,
    "no_errors": logs.no_errors,
    "no_tracebacks": logs.no_tracebacks,
    "process": processes.process,
    "ready": processes.ready,
    "no_deaths": processes.no_deaths,
    "cpu": processes.cpu,
    "memory": processes.memory,
    "parameter": answers.parameter,
    "service": answers.service,
    "like": likeness.like,
    "start_up": run.start_up,
    "clean_shutdown": run.clean_shutdown,
    "shared_memory": run.shared_memory,
}


def judge(expectation: Expectation, facts: Facts) -> Verdict:
    return JUDGES[expectation.kind](expectation, facts)
