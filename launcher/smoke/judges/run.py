"""Judges of the whole run: start-up, shutdown, and leftovers."""

from __future__ import annotations

import signal
from typing import Any

from launcher.base.document.quantities import INFINITY, seconds_text
from launcher.base.model.run_event import exit_text
from launcher.base.model.run_events import Ended, Signalled
from launcher.base.text import several
from launcher.smoke.expect.expectation import STOP, Decision, Expectation, Verdict
from launcher.smoke.judges.common import listed, met, violated
from launcher.smoke.observe.facts import Facts, ProcessEvent

_HARD = {int(signal.SIGTERM): "SIGTERM", int(signal.SIGKILL): "SIGKILL"}
# Exit codes after a stop: success, or by one of the launcher's signals.
_ORDERLY = {0, -int(signal.SIGINT), 128 + int(signal.SIGINT), *(-signum for signum in _HARD)}


def start_up(expectation: Expectation, facts: Facts) -> Verdict:
    expected = f"the system is ready within {expectation.subject:g} s"
    ready_s = facts.ready_s
    if ready_s is None:
        is_late = facts.is_over or facts.now_s > expectation.subject
        outcome = Decision.VIOLATED if is_late else Decision.OPEN
        return Verdict(outcome=outcome, expected=expected, seen="it was not ready")
    make = met if ready_s <= expectation.subject else violated
    seen = f"after {seconds_text(ready_s)}"
    return make(expected, seen=seen, at_s=ready_s, value=ready_s, unit="s")


def clean_shutdown(expectation: Expectation, facts: Facts) -> Verdict:
    """All processes exit in time, on the first signal, and leave nothing."""
    expected = f"all processes exit within {expectation.subject:g} s of the stop"
    ending = facts.ending
    if ending is None:
        return Verdict(outcome=Decision.OPEN, expected=expected)
    took_s = ending.down_s - facts.stop_s
    harder = {e.process: e for e in facts.of(Signalled) if _is_harder(e, facts)}
    faults = [f"{name} needed {_HARD[e.event.signal]}" for name, e in harder.items()]
    ends = _ends_at_stop(facts)
    bad = {e.process: e.event for e in ends if e.event.returncode not in _ORDERLY or _is_crash(e)}
    faults += [f"{name} ended with {exit_text(end.returncode)}" for name, end in bad.items()]
    if ending.returncode is None:
        faults.append("the launcher had to be killed")
    if took_s > expectation.subject:
        faults.append(f"it took {seconds_text(took_s)}")
    if ending.left_processes:
        faults.append(f"left behind: {listed(ending.left_processes)}")
    about = tuple(name for name in (*harder, *bad) if name)
    details: dict[str, Any] = {"value": took_s, "unit": "s", "about": about}
    if faults:
        return violated(expected, seen="; ".join(faults), at_s=facts.stop_s, **details)
    return met(expected, seen=f"after {seconds_text(took_s)}", **details)


def forced_stop(facts: Facts) -> Verdict | None:
    """The verdict on processes that were killed or crashed at the stop; None if there are none."""
    signals = (e for e in facts.of(Signalled) if _is_harder(e, facts))
    killed = {e.process: e for e in signals if e.event.signal == signal.SIGKILL}
    names = sorted(name for name in killed if name)
    crashes = [e for e in _ends_at_stop(facts) if _is_crash(e)]
    if not names and not crashes:
        return None
    seen = [f"{e.process} ended with {exit_text(e.event.returncode)}" for e in crashes]
    if names:
        waited_s = max(event.at_s for event in killed.values()) - facts.stop_s
        seen.append(f"killed after {seconds_text(waited_s)}: {several(names)}")
    return violated(
        "all processes exit on SIGINT or SIGTERM",
        seen="; ".join(seen),
        at_s=facts.stop_s,
        about=(*names, *(e.process for e in crashes if e.process)),
    )


def _ends_at_stop(facts: Facts) -> list[ProcessEvent[Ended]]:
    return [event for event in facts.of(Ended) if event.at_s >= facts.stop_s]


def _is_crash(end: ProcessEvent[Ended]) -> bool:
    """Whether a signal has ended the process that was not sent to stop it."""
    return end.event.returncode < 0 and not end.event.asked


def _is_harder(sent: ProcessEvent[Signalled], facts: Facts) -> bool:
    return sent.at_s >= facts.steps.get(STOP, INFINITY) and sent.event.signal in _HARD


def shared_memory(expectation: Expectation, facts: Facts) -> Verdict:
    expected = "nothing is left in /dev/shm"
    if facts.ending is None:
        return Verdict(outcome=Decision.OPEN, expected=expected)
    left = facts.ending.left_memory
    if left:
        guess = "a killed process cannot free its shared memory"
        return violated(expected, seen=f"{len(left)}: {several(left)}", guess=guess)
    return met(expected, seen="nothing")
