"""What `node list`, `node info` and `node ps` print: nodes, and the processes behind them."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.base.text import aligned
from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.ports import announcement_ports
from launcher.ros.discovery import gids
from launcher.ros.service_caller import NoAnswerError, ServiceCaller
from launcher.ros.snapshot.ros_graph import GraphSnapshot, NamesAndTypes, is_hidden

SHARED_NAME = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects."
)


def visible_names(names: Iterable[str], *, hidden: bool) -> list[str]:
    return [name for name in names if hidden or not is_hidden(name)]


def sections(graph: GraphSnapshot, full: str, *, hidden: bool) -> dict[str, NamesAndTypes]:
    """Title -> what one node has of it, sorted; VerbError if there is no such node."""
    if full not in graph.nodes:
        hint = did_you_mean(full, visible_names(graph.nodes, hidden=False))
        raise VerbError(f"Unable to find node '{full}'", hint=hint)
    return {
        title: [(name, types) for name, types in entries if hidden or not is_hidden(name)]
        for title, entries in graph.of_node(full).items()
    }


def info_lines(full: str, found: dict[str, NamesAndTypes]) -> Iterator[str]:
    """The lines of `node info`; a section without entries has one empty line."""
    yield full
    for title, entries in found.items():
        yield f"  {title}:"
        yield "\n".join(f"    {name}: {', '.join(types)}" for name, types in entries)


OK, BUSY, STOPPED, GHOST, UNKNOWN = "ok", "busy", "stopped", "ghost", "unknown"
NOT_DISCOVERED = "(not discovered)"  # a suspended process cannot answer a new participant
_DETAILS = ("cmdline", "cpu_times", "create_time", "environ", "memory_full_info")
_SAMPLE_S = 0.3  # shorter than this, the ticks of the kernel are too coarse for CPU shares


@dataclass(frozen=True, slots=True, kw_only=True)
class Vitals:
    """What is known of a process at one moment; `status` is one of psutil's."""

    status: str
    program: str | None
    run: str | None
    cpu_s: float
    uss_bytes: int | None
    uptime_s: float


def vitals(pid: int) -> Vitals | None:
    """None if the process has ended."""
    found = proc.details(pid, *_DETAILS)
    if not found:
        return None
    return Vitals(
        status=found["status"],
        program=program_name(found["cmdline"] or ()),
        run=(found["environ"] or {}).get(RUN_ID_VARIABLE),
        cpu_s=_sum(found["cpu_times"]),
        uss_bytes=found["memory_full_info"] and found["memory_full_info"].uss,
        uptime_s=time.time() - found["create_time"],
    )


def _cpu_s(pid: int) -> float | None:
    found = proc.details(pid, "cpu_times")
    return _sum(found["cpu_times"]) if found else None


def _sum(times: Any) -> float:
    total: float = times.user + times.system
    return total


def program_name(words: Sequence[str]) -> str | None:
    """The module or script of a Python command line, otherwise its program; None without words."""
    program = os.path.basename(words[0]) if words else None
    if program is None or not program.startswith("python"):
        return program
    for index, word in enumerate(words[1:], start=1):
        if word == "-m":
            return " ".join(words[index + 1 : index + 2]) or program
        if word == "-c":
            return f"{program} -c"
        if not word.startswith("-"):
            return os.path.basename(word)
    return program


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A node and its process; None is unknown. CPU in percent of one core, memory is the USS."""

    node: str
    liveness: str
    process: str | None = None
    pid: int | None = None
    run: str | None = None
    cpu_percent: float | None = None
    uss_bytes: int | None = None
    uptime_s: float | None = None

    def document(self) -> dict[str, object]:
        """For JSON, with the names of `ps`."""
        found = asdict(self)
        head = {"name": found.pop("node"), "program": found.pop("process")}
        return {**head, "run_id": found.pop("run"), **found}


@dataclass(frozen=True, slots=True, kw_only=True)
class Owner:
    """A node and the process of its endpoints; `pid` None and not `gone`: unknown.

    `undiscovered`: its name has arrived, and none of its endpoints, which come one by one.
    """

    node: str
    pid: int | None = None
    gone: bool = False
    undiscovered: bool = False


def rows(caller: ServiceCaller, *, hidden: bool, timeout_s: float) -> list[Row]:
    """One row per node and process, sorted by name. Takes as long as the slowest node, bounded."""
    found = list(owners(caller, hidden=hidden))
    pids = {owner.pid for owner in found if owner.pid is not None}
    start, before = time.monotonic(), {pid: _cpu_s(pid) for pid in pids}
    answers = _probe(caller, {o.node for o in found if not o.gone}, timeout_s)
    time.sleep(max(0.0, start + _SAMPLE_S - time.monotonic()))
    elapsed_s, after = time.monotonic() - start, {pid: vitals(pid) for pid in pids}
    return [_silent_row(pid) for pid in _silent_pids(caller)] + [
        _row(
            owner,
            before.get(owner.pid or 0),
            after.get(owner.pid or 0),
            elapsed_s,
            answers.get(owner.node, UNKNOWN),
        )
        for owner in found
    ]


def with_ghosts(found: list[Row], ghosts: Iterable[str]) -> list[Row]:
    """The rows, and those of ghosts, which only an older participant can know."""
    known = {row.node for row in found}
    more = [Row(node=node, liveness=GHOST) for node in ghosts if node not in known]
    return sorted([*found, *more], key=lambda row: row.node)


def _silent_pids(caller: ServiceCaller) -> list[int]:
    """Processes that hold ports of the domain and have not been discovered."""
    observer = caller.observer
    known = {gids.pid_low16(gid) for gid in observer.participants()}
    silent = gids.holders(set(announcement_ports(observer.domain_id)), known)
    return sorted(pid for pid in silent if gids.innermost_pid(pid) & 0xFFFF not in known)


def _silent_row(pid: int) -> Row:
    found = vitals(pid)
    if found is None:
        return Row(node=NOT_DISCOVERED, liveness=UNKNOWN, pid=pid)
    return _process_row(NOT_DISCOVERED, UNKNOWN, pid, found)


def _process_row(
    node: str, liveness: str, pid: int, found: Vitals, cpu_percent: float | None = None
) -> Row:
    return Row(
        node=node,
        liveness=STOPPED if found.status in ("stopped", "tracing-stop") else liveness,
        process=found.program,
        pid=pid,
        run=found.run,
        cpu_percent=cpu_percent,
        uss_bytes=found.uss_bytes,
        uptime_s=round(found.uptime_s, 1),
    )


def owners(caller: ServiceCaller, *, hidden: bool) -> Iterator[Owner]:
    """The nodes and their processes; a node of several processes comes several times."""
    observer = caller.observer
    own_gid = observer.own_gid()
    trusted = gids.scheme_holds(own_gid, os.getpid())
    live = gids.all_live(observer.participants(), own_gid, observer.domain_id)
    owned: dict[str, set[bytes]] = {}
    for topic in observer.topic_types():
        for endpoint in observer.endpoints(topic):
            owned.setdefault(endpoint.node, set()).add(bytes.fromhex(endpoint.gid.replace(".", "")))
    for node in sorted(set(visible_names(observer.node_names(), hidden=hidden))):
        local = {gid for gid in owned.get(node, ()) if trusted and gids.same_host(gid, own_gid)}
        lows = {gids.pid_low16(gid) for gid in local}
        if not lows:
            yield Owner(node=node, undiscovered=node not in owned)
        for low in sorted(low for low in lows if low is not None):
            pid = gids.find_pid(low, observer.domain_id)
            is_there = live or any(living & 0xFFFF == low for living in gids.living_pids())
            yield Owner(node=node, pid=pid, gone=pid is None and not is_there)


def _probe(caller: ServiceCaller, nodes: set[str], timeout_s: float) -> dict[str, str]:
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
        caller.wait_until_done([future for _, future in asked], timeout_s / 2)
        found |= {node: OK for node, future in asked if future.done()}
        silent = [node for node in silent if found[node] == BUSY]
    return found


def _row(
    owner: Owner, before_s: float | None, after: Vitals | None, elapsed_s: float, answer: str
) -> Row:
    if owner.gone or (owner.pid is not None and after is None):
        return Row(node=owner.node, liveness=GHOST)
    if after is None or before_s is None or owner.pid is None:
        return Row(node=owner.node, liveness=answer)
    cpu_percent = round(100 * (after.cpu_s - before_s) / elapsed_s, 1)
    return _process_row(owner.node, answer, owner.pid, after, cpu_percent)


def to_table(found: list[Row]) -> str:
    head = ("NODE", "PROCESS", "PID", "RUN", "CPU", "USS", "UPTIME", "LIVENESS")
    return "\n".join(aligned([head, *map(_cells, found)], right={2, 4, 5, 6}))


def _cells(row: Row) -> tuple[str, ...]:
    return (
        row.node,
        row.process or "",
        "" if row.pid is None else str(row.pid),
        row.run or "",
        "" if row.cpu_percent is None else f"{row.cpu_percent:.1f}%",
        "" if row.uss_bytes is None else f"{row.uss_bytes / 1e6:.1f} MB",
        "" if row.uptime_s is None else _duration(row.uptime_s),
        row.liveness,
    )


def _duration(seconds: float) -> str:
    whole = int(seconds)
    if whole < 60:
        return f"{seconds:.1f} s"
    hours, rest = divmod(whole, 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}"
