"""The checks of a watched run: which kinds of expectations hold while it lives, and which do not.

What needs the end of a run, or a step of a scenario, is left to smoke; `Left` says why.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from launcher.faults.checks.arriving import LineCheck, MessageCheck
from launcher.faults.checks.check import Check, ExpectationCheck
from launcher.faults.checks.implied import (
    DeathCheck,
    DoubleCheck,
    HostCheck,
    MachineCheck,
    QosCheck,
    ResponseCheck,
    SidesCheck,
    SuspensionCheck,
)
from launcher.faults.checks.present import AnswerCheck, GraphCheck, ProcessCheck
from launcher.faults.checks.traffic import GapCheck, LatencyCheck, RateCheck
from launcher.faults.checks.usage import CpuCheck, MemoryCheck
from launcher.smoke.expect.expectation import READY, START, Expectation
from launcher.smoke.expect.script import Script

_WHOLE = "it is about the whole run"
_COUNTS = "it counts from the start to the end"


@dataclass(frozen=True, slots=True, kw_only=True)
class Left:
    """An expectation that a watched run does not check, and why."""

    expectation: str
    why: str


# A check, or why there is none.
Made = Check | str


def _log(one: Expectation) -> Made:
    count = one.get("count")
    if count is not None and count.high == 0:
        return LineCheck(one)
    return "that a line is printed is decided at the end" if count is None else _COUNTS


def _message(one: Expectation) -> Made:
    if one.get("all"):
        return MessageCheck(one)
    return "that a message comes is decided at the end" if one.get("count") is None else _COUNTS


def _process(one: Expectation) -> Made:
    if one.get("exits") is not None or one.get("alive") is False:
        return "an exit is the end of the process"
    return _COUNTS if one.get("restarts") is not None else ProcessCheck(one)


def _service(one: Expectation) -> Made:
    if one.get("call") is False:
        return GraphCheck(one)
    return "a watched run does not call services; `call: false`: that it is there"


def _left(why: str) -> Callable[[Expectation], Made]:
    return lambda one: why


KINDS: dict[str, Callable[[Expectation], Made]] = {
    "node": GraphCheck,
    "topic": GraphCheck,
    "qos": GraphCheck,
    "rate": RateCheck,
    "gap": GapCheck,
    "latency": LatencyCheck,
    "message": _message,
    "unique": _left(_WHOLE),
    "refers": _left(_WHOLE),
    "tally": _left(_WHOLE),
    "log": _log,
    "order": _left(_WHOLE),
    "no_errors": LineCheck,
    "no_tracebacks": LineCheck,
    "process": _process,
    "ready": _left("it is about the start; the launcher reports it"),
    "cpu": CpuCheck,
    "memory": MemoryCheck,
    "parameter": AnswerCheck,
    "service": _service,
    "like": _left("a bag is compared at the end"),
    "start_up": _left("it is about the start"),
    "clean_shutdown": _left("it is about the end"),
    "shared_memory": _left("it is about the end"),
}


def watched(script: Script) -> tuple[Script, list[Left]]:
    """The script with the expectations that have a check, and those that have none."""
    chosen: list[Expectation] = []
    left: list[Left] = []
    for one in script.expectations:
        if one.kind not in KINDS:
            continue  # `no_deaths` is implied
        made = KINDS[one.kind](one)
        if one.after not in (START, READY):
            left.append(Left(expectation=one.name, why=f"it counts from the step '{one.after}'"))
        elif isinstance(made, str):
            left.append(Left(expectation=one.name, why=made))
        else:
            chosen.append(one)
    return script.with_expectations(chosen), left


def checks_of(script: Script, arguments: Collection[str] = ()) -> list[Check]:
    """The checks of the expectations of a watched script; `arguments` are those of the run
    (`name:=value`).

    Where the file is for others, nodes may be missing: what has held once is expected from then on.
    """
    is_other = any(f"{name}:={value}" not in arguments for name, value in script.arguments.items())
    checks: list[Check] = []
    for one in script.expectations:
        made = KINDS[one.kind](one)
        if isinstance(made, ExpectationCheck):
            made.must_have_held = is_other
            checks.append(made)
    return checks


def implied_checks(script: Script) -> list[Check]:
    """Those of every watched run, but for what the whole script expects to be otherwise."""
    return [
        MachineCheck(),
        HostCheck(),
        DeathCheck(script.expected_exits()),
        SuspensionCheck(),
        ResponseCheck(),
        DoubleCheck(),
        QosCheck(_mismatched(script.expectations)),
        SidesCheck(),
    ]


def _mismatched(expectations: Iterable[Expectation]) -> set[str]:
    """The topics of which a pair is expected not to match."""
    return {
        str(one.subject)
        for one in expectations
        if one.kind == "qos" and one.get("compatible") is False
    }
