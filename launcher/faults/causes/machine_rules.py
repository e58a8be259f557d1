"""Rules about machines: their clocks, disks, links and processors."""

from __future__ import annotations

from launcher.base.document.quantities import seconds_text
from launcher.base.model.run_events import Asked, Ended, LinkChanged
from launcher.faults.causes.cause import BEFORE_S, LATER_S, MACHINE, OF_TIME, Cause
from launcher.faults.checks.implied import is_full
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.story import Story, is_here

CLOCK_S = 6.0
SILENT_S = 1.5  # of a host, which sends something each second; it is unreachable after 3 s
STARVED = 0.5  # of the time some task waited for a processor,
DELAYED = 0.1  # and the main thread of the process in question so much of it
PRESSURE_S = 1.0  # two samples: it begins as suddenly as what it explains


def clock_step(fault: Fault, story: Story) -> Cause | None:
    """The clock was set: times, timers and stamps are wrong before and behind it."""
    if fault.origin.kind not in (*OF_TIME, "clock"):
        return None
    step = story.clock_step(fault.life.first_s - CLOCK_S)
    if step is None or step[0] > fault.life.last_s + LATER_S:
        return None
    at_s, by_s = step
    text = f"the clock of this machine was set {'forward' if by_s > 0 else 'back'}"
    return Cause(
        rule="clock step",
        text=f"{text} by {abs(by_s):.3g} s",
        at_s=at_s,
        about=frozenset({MACHINE}),
    )


def full_disk(fault: Fault, story: Story) -> Cause | None:
    """The disk of the log files is full: programs fail to write, and may end."""
    if fault.origin.kind not in ("disk", "no deaths", "no_errors", "no_tracebacks", "log"):
        return None
    full = [
        sample
        for sample in story.machine
        if sample.at_s >= fault.life.first_s - BEFORE_S and is_full(sample)
    ]
    if not full:
        return None
    says_so = any("No space left" in line or "ENOSPC" in line for line in fault.lines)
    if fault.origin.kind != "disk" and not says_so:
        return None
    return Cause(
        rule="full disk",
        text="the disk of the log files is full",
        at_s=full[0].at_s,
        about=frozenset({MACHINE}),
    )


def lost_link(fault: Fault, story: Story) -> Cause | None:
    """The host of a process cannot be reached, or has been silent for longer than it ever is."""
    if fault.origin.kind == "no deaths":
        return None  # what is reported has come over the link
    hosts = story.hosts_of(fault.finding.processes)
    for host, event in story.lost_hosts().items():
        is_of_host = fault.id == f"reachable: {host}" or host in hosts
        if is_of_host and event.at_s <= fault.life.last_s + LATER_S:
            why = f" ({event.event.reason})" if event.event.reason else ""
            text = f"the link to host {host} is down{why}"
            return Cause(rule="lost link", text=text, at_s=event.at_s, about=frozenset({host}))
    for host, silent_s in hosts.items():
        if silent_s >= SILENT_S:
            return Cause(
                rule="lost link",
                text=f"nothing has come from host {host} for {silent_s:.0f} s",
                at_s=story.rows_s - silent_s,
                about=frozenset({host}),
            )
    return _stopped_without_link(fault, story)


def _stopped_without_link(fault: Fault, story: Story) -> Cause | None:
    """A host stops its processes if the link is down for long (`on_link_loss`)."""
    for name in fault.finding.processes:
        row, ended = story.row(name), story.last(Ended, name)
        if row is None or is_here(row) or row["pid"] is not None or ended is None:
            continue
        host = str(row["host"])
        changes = [one for one in story.of(LinkChanged) if one.event.host == host]
        before = [one for one in changes if one.at_s < ended.at_s]
        is_cut_off = bool(before) and before[-1].event.state == "unreachable"
        if ended.event.asked and is_cut_off and not story.of(Asked, name, before[-1].at_s):
            text = f"host {host} has stopped {name} while the link was down"
            about = frozenset({host})
            return Cause(rule="lost link", text=text, at_s=ended.at_s, about=about)
    return None


def other_clock(fault: Fault, story: Story) -> Cause | None:
    """The clock of another host differs: stamps are wrong by as much."""
    hosts = story.hosts_of(fault.finding.processes)
    if fault.origin.kind != "latency" or len(hosts) != 1:
        return None
    (host,) = hosts
    known = (story.arrivals.get(topic) for topic in fault.finding.topics)
    behind_s = max((one.behind_s for one in known if one is not None), default=0.0)
    if behind_s <= 0:
        return None
    text = f"the clock of host {host} is {seconds_text(behind_s)} behind that of this machine"
    return Cause(
        rule="other clock",
        text=f"{text}, by its quickest messages; `hosts check` measures it",
        at_s=fault.life.first_s,
        about=frozenset({host}),
    )


def starvation(fault: Fault, story: Story) -> Cause | None:
    """The process waits for a processor: what is late is late for that.

    Of a process elsewhere that is not known; what observes it here may wait.
    """
    if fault.origin.kind not in (*OF_TIME, "responds"):
        return None
    share = story.pressure("cpu", min(fault.life.first_s, story.now_s - PRESSURE_S))
    if share is None or share < STARVED:
        return None
    rows = [row for row in story.rows if row["name"] in fault.finding.processes]
    pids = {row["pid"] if is_here(row) else story.observer for row in rows}
    waits = [story.delays.share(pid) or 0.0 for pid in pids if pid is not None]
    if not any(wait >= max(DELAYED, fault.finding.lack / 2) for wait in waits):
        return None  # others do, or it would not make up for what is missing
    return Cause(
        rule="starvation",
        text=f"programs wait for a processor {share:.0%} of the time{_busiest(story)}",
        at_s=fault.life.first_s,
        about=frozenset({MACHINE}),
        is_weak=not any(map(is_here, rows)),
    )


def _busiest(story: Story) -> str:
    """The process of the run that uses most, if that is much."""
    loads = {str(row["name"]): row["cpu_percent"] or 0.0 for row in story.rows}
    name = max(loads, key=lambda name: loads[name], default="")
    return (
        f"; of this run {name} uses most, {loads[name]:.0f} % of a core"
        if loads.get(name, 0) > 50
        else ""
    )
