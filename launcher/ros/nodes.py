"""Nodes: what the graph says about them, in the texts of `ros2 node`."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from launcher.ros.discovery.gids import (
    Vanished,
    Vitals,
    all_live,
    find_pid,
    holders,
    innermost_pid,
    living_pids,
    pid_low16,
    program_name,
    same_host,
    scheme_holds,
    variable,
    vitals,
)
from launcher.ros.discovery.ports import announcement_ports
from launcher.ros.errors import VerbError, did_you_mean
from launcher.ros.services import NoAnswerError, ServiceCaller
from launcher.ros.snapshot.graph import GraphSnapshot, NamesAndTypes, is_hidden

SHARED_NAME = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects."
)


def visible_names(names: Iterable[str], *, hidden: bool) -> list[str]:
    """The names that `node list` prints."""
    return [name for name in names if hidden or not is_hidden(name)]


def sections(look: GraphSnapshot, full: str, *, hidden: bool) -> dict[str, NamesAndTypes]:
    """Title -> what one node has of it, sorted; VerbError if there is no such node."""
    if full not in look.nodes:
        hint = did_you_mean(full, visible_names(look.nodes, hidden=False))
        raise VerbError(f"Unable to find node '{full}'", hint=hint)
    return {
        title: [(name, types) for name, types in entries if hidden or not is_hidden(name)]
        for title, entries in look.of_node(full).items()
    }


def info_lines(full: str, found: dict[str, NamesAndTypes]) -> Iterator[str]:
    """The lines of `node info`; a section without entries has one empty line."""
    yield full
    for title, entries in found.items():
        yield f"  {title}:"
        yield "\n".join(f"    {name}: {', '.join(types)}" for name, types in entries)


OK, BUSY, STOPPED, GHOST, UNKNOWN = "ok", "busy", "stopped", "ghost", "unknown"
NOT_DISCOVERED = "(not discovered)"  # a process that was stopped before we came cannot answer
RUN_ID = "LAUNCHER_RUN_ID"
_SAMPLE_S = 0.3  # shorter than this, the ticks of the kernel are too coarse for CPU shares
_MIB = 1024 * 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A node and its process; what cannot be told is None. CPU in percent of one core."""

    node: str
    liveness: str
    process: str | None = None
    pid: int | None = None
    run: str | None = None
    cpu_percent: float | None = None
    memory_bytes: int | None = None
    uptime_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Owner:
    """A node and where its endpoints live; `pid` None with `gone` False: cannot be told."""

    node: str
    pid: int | None = None
    gone: bool = False


def rows(caller: ServiceCaller, *, hidden: bool, patience_s: float) -> list[Row]:
    """One row per node and process, sorted by name. Takes as long as the slowest node, bounded."""
    owners = list(_owners(caller, hidden=hidden))
    start, first = time.monotonic(), _sample(owners)
    answers = _probe(caller, {o.node for o in owners if not o.gone}, patience_s)
    time.sleep(max(0.0, start + _SAMPLE_S - time.monotonic()))
    elapsed_s, second = time.monotonic() - start, _sample(owners)
    silent = [_silent_row(pid) for pid in _silent_pids(caller)]
    return silent + [
        _row(
            owner,
            first.get(owner.pid or 0),
            second.get(owner.pid or 0),
            elapsed_s,
            answers.get(owner.node, UNKNOWN),
        )
        for owner in owners
    ]


def with_ghosts(found: list[Row], ghosts: Iterable[str]) -> list[Row]:
    """The rows with those of ghosts that only somebody who was there before can know."""
    known = {row.node for row in found}
    more = [Row(node=node, liveness=GHOST) for node in ghosts if node not in known]
    return sorted([*found, *more], key=lambda row: row.node)


def _silent_pids(caller: ServiceCaller) -> list[int]:
    """Processes that hold ports of the domain and have not been discovered."""
    observer = caller.observer
    known = {pid_low16(gid) for gid in observer.participants()}
    silent = holders(set(announcement_ports(observer.domain_id)), known)
    return sorted(pid for pid in silent if innermost_pid(pid) & 0xFFFF not in known)


def _silent_row(pid: int) -> Row:
    try:
        found = vitals(pid)
        return Row(
            node=NOT_DISCOVERED,
            liveness=STOPPED if found.state in "Tt" else UNKNOWN,
            process=program_name(pid),
            pid=pid,
            run=variable(pid, RUN_ID),
            memory_bytes=found.rss_bytes,
            uptime_s=round(found.uptime_s, 1),
        )
    except Vanished:
        return Row(node=NOT_DISCOVERED, liveness=UNKNOWN, pid=pid)


def _owners(caller: ServiceCaller, *, hidden: bool) -> Iterator[Owner]:
    observer = caller.observer
    own_gid = observer.own_gid()
    trusted = scheme_holds(own_gid, os.getpid())
    live = all_live(observer.participants(), own_gid, observer.domain_id)
    gids: dict[str, set[bytes]] = {}
    for topic in observer.topic_types():
        for endpoint in observer.endpoints(topic):
            gids.setdefault(endpoint.node, set()).add(bytes.fromhex(endpoint.gid.replace(".", "")))
    for node in sorted(set(visible_names(observer.node_names(), hidden=hidden))):
        local = {gid for gid in gids.get(node, ()) if trusted and same_host(gid, own_gid)}
        lows = {pid_low16(gid) for gid in local}
        if not lows:
            yield Owner(node=node)
        for low in sorted(low for low in lows if low is not None):
            yield _owner(node, low, observer.domain_id, live=live)


def _owner(node: str, low: int, domain_id: int, *, live: bool) -> Owner:
    pid = find_pid(low, domain_id)
    is_there = live or any(living & 0xFFFF == low for living in living_pids())
    return Owner(node=node, pid=pid, gone=pid is None and not is_there)


def _sample(owners: list[Owner]) -> dict[int, Vitals]:
    found: dict[int, Vitals] = {}
    for pid in {owner.pid for owner in owners if owner.pid is not None}:
        try:
            found[pid] = vitals(pid)
        except Vanished:
            continue  # its row says so
    return found


def _probe(caller: ServiceCaller, nodes: set[str], patience_s: float) -> dict[str, str]:
    """Node -> whether it answers a request that its own executor has to carry out."""
    from rcl_interfaces.srv import GetParameterTypes

    services = dict(caller.observer.node.get_service_names_and_types())
    # A node without parameter services cannot be asked.
    silent = sorted(node for node in nodes if f"{node}/get_parameter_types" in services)
    found: dict[str, str] = {}
    asked: list[tuple[str, Any]] = []
    for _ in range(2):  # an answer may be lost
        for node in silent:
            name, request = f"{node}/get_parameter_types", GetParameterTypes.Request()
            try:
                asked.append((node, caller.start(GetParameterTypes, name, request)))
                found[node] = BUSY
            except NoAnswerError:
                found.setdefault(node, UNKNOWN)
        caller.wait_until_done([future for _, future in asked], patience_s / 2)
        found |= {node: OK for node, future in asked if future.done()}
        silent = [node for node in silent if found[node] == BUSY]
    return found


def _row(
    owner: Owner, before: Vitals | None, after: Vitals | None, elapsed_s: float, answer: str
) -> Row:
    if owner.gone or (owner.pid is not None and after is None):
        return Row(node=owner.node, liveness=GHOST)
    if after is None or before is None or owner.pid is None:
        return Row(node=owner.node, liveness=answer)
    process: str | None = None
    run: str | None = None
    with contextlib.suppress(Vanished):  # or it belongs to somebody else
        process = program_name(owner.pid)
        run = variable(owner.pid, RUN_ID)
    return Row(
        node=owner.node,
        liveness=STOPPED if after.state in "Tt" else answer,
        process=process,
        pid=owner.pid,
        run=run,
        cpu_percent=round(100 * (after.cpu_s - before.cpu_s) / elapsed_s, 1),
        memory_bytes=after.rss_bytes,
        uptime_s=round(after.uptime_s, 1),
    )


def to_table(found: list[Row]) -> str:
    """The table that `node ps` prints."""
    head = ("NODE", "PROCESS", "PID", "RUN", "CPU", "MEMORY", "UPTIME", "LIVENESS")
    cells = [head, *(_cells(row) for row in found)]
    widths = [max(len(line[column]) for line in cells) for column in range(len(head))]
    right = {2, 4, 5, 6}
    return "\n".join(
        "  ".join(
            text.rjust(width) if column in right else text.ljust(width)
            for column, (text, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in cells
    )


def _cells(row: Row) -> tuple[str, ...]:
    return (
        row.node,
        row.process or "",
        "" if row.pid is None else str(row.pid),
        row.run or "",
        "" if row.cpu_percent is None else f"{row.cpu_percent:.1f}%",
        "" if row.memory_bytes is None else f"{row.memory_bytes / _MIB:.1f} MiB",
        "" if row.uptime_s is None else _duration(row.uptime_s),
        row.liveness,
    )


def _duration(seconds: float) -> str:
    whole = int(seconds)
    if whole < 60:
        return f"{seconds:.1f} s"
    hours, rest = divmod(whole, 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}"
