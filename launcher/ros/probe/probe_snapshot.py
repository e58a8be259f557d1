"""The graph of a domain at one moment, with the processes behind it."""

from __future__ import annotations

import os
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Set
from dataclasses import asdict, dataclass, field
from typing import Any

from launcher.posix import proc
from launcher.posix.ports import participants_by_domain
from launcher.ros.discovery import gids
from launcher.ros.discovery.gids import participant_of
from launcher.ros.discovery.graph_changes import GraphChanges
from launcher.ros.discovery.observer import Observer
from launcher.ros.discovery.reannounce import reannounce_to_silent
from launcher.ros.snapshot.qos_matching import mismatches
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph, is_hidden, is_node_service
from launcher.ros.topics.listing import mismatch_documents

OURS = "_launcher_"  # the nodes of our tools begin with it
_COUNT_PERIOD_S = 0.5
_REANNOUNCE_S = 0.1
_UNSETTLED_S = 1.0  # after a change: the process of a participant may not be found at once
_CHECK_PERIOD_S = 5.0  # in case that a change went unnoticed
_CHECK_COST = 0.0005  # of a core at most: it is rarer for large graphs


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeSnapshot:
    """`pids` has the processes of full node names, as far as their GIDs contain them.

    `gone` are the GIDs of endpoints whose process has ended, which DDS notices later.
    `complete`: every participant of this machine has been discovered.
    """

    snapshot: TopicGraph
    gone: frozenset[str] = frozenset()
    services: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    pids: Mapping[str, int] = field(default_factory=dict)
    complete: bool = False
    _living: Mapping[str, list[Endpoint]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        living: dict[str, list[Endpoint]] = defaultdict(list)
        for endpoint in self.snapshot.endpoints:
            if endpoint.gid not in self.gone:
                living[endpoint.topic].append(endpoint)
        object.__setattr__(self, "_living", dict(living))

    def on(self, topic: str) -> list[Endpoint]:
        """The living endpoints of a topic."""
        return list(self._living.get(topic, ()))

    def types_of(self, topic: str) -> list[str]:
        return sorted({e.type for e in self.on(topic)})

    def document(self) -> dict[str, Any]:
        """The fields of the event `graph`."""
        topics = self.snapshot.topics()
        return {
            "complete": self.complete,
            "nodes": self._nodes(),
            "topics": [self._topic(name) for name in topics],
            "services": [
                {"name": name, "types": list(types)}
                for name, types in self.services.items()
                if not is_node_service(name, types)
            ],
            "endpoints": [
                {**asdict(e), "ghost": e.gid in self.gone} for e in self.snapshot.endpoints
            ],
            "mismatches": [
                {"topic": topic, **document}
                for topic in topics
                for document in mismatch_documents(mismatches(self.on(topic)))
            ],
        }

    def _nodes(self) -> list[dict[str, Any]]:
        return [
            {
                "name": name,
                "hidden": is_hidden(name),
                "ghost": name in self.snapshot.ghosts,
                "pid": self.pids.get(name),
                "count": count,
            }
            for name, count in Counter(self.snapshot.nodes).items()
        ]

    def _topic(self, name: str) -> dict[str, Any]:
        endpoints = self.on(name)
        publishers = sum(e.is_publisher for e in endpoints)
        return {
            "name": name,
            "types": self.types_of(name),
            "publishers": publishers,
            "subscriptions": len(endpoints) - publishers,
        }


class GraphWatcher:
    """Takes snapshots; remembers which participant belongs to which process."""

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._changes = GraphChanges(observer.node)
        self._pids: dict[str, int] = {}
        self._participants: set[str] = set()
        self._exited: set[str] = set()
        self._complete = False
        self._taken_complete = False
        self.count_s = _COUNT_PERIOD_S  # between two counts of participants
        self._next_count_s = time.monotonic() + _REANNOUNCE_S
        self._has_asked = False
        self._until_s = 0.0  # snapshots are taken up to then
        self._check_s = 0.0  # and at this time at the latest

    def close(self) -> None:
        self._changes.close()

    def has_changed(self) -> bool:
        """Whether another snapshot may differ from the last one."""
        now_s = time.monotonic()
        self._count_participants()
        if self._changes.happened() or self._exited != self._now_exited():
            self._until_s = now_s + _UNSETTLED_S
        is_due = now_s < self._until_s or now_s >= self._check_s
        return is_due or self._complete != self._taken_complete

    def take(self) -> ProbeSnapshot:
        """The graph now, without the nodes of our own tools."""
        begin_s = time.thread_time()
        listed = self._observer.node_names()
        every = self._observer.all_endpoints()
        listed = sorted([*listed, *self._observer.returned_nodes().difference(listed)])
        names = [name for name in listed if not name.rpartition("/")[2].startswith(OURS)]
        known = set(names)
        found = [e for e in every if e.node in known]
        nodes = tuple(self._observer.living(names, found))
        self._participants = {participant_of(e.gid) for e in found}
        owners = self._owners(self._participants)
        self._pids = {p: pid for p, pid in self._pids.items() if p in self._participants}
        self._exited = self._now_exited()
        gone = frozenset(e.gid for e in found if participant_of(e.gid) in self._exited)
        running = {e.node for e in found if e.gid not in gone}
        nodes = without_exited(nodes, (e for e in found if e.gid in gone))
        self._count_participants()
        self._taken_complete = self._complete
        snapshot = ProbeSnapshot(
            snapshot=TopicGraph(
                nodes=nodes,
                endpoints=tuple(found),
                ghosts=tuple(sorted({e.node for e in found} - running)),
            ),
            gone=gone,
            services=self._services(nodes),
            pids=_pids(found, owners, self._exited),
            complete=self._complete,
        )
        took_s = time.thread_time() - begin_s
        self._check_s = time.monotonic() + max(_CHECK_PERIOD_S, took_s / _CHECK_COST)
        return snapshot

    def _now_exited(self) -> set[str]:
        """The participants of the last snapshot whose process has ended."""
        owners = {key: self._pids[key] for key in self._participants & self._pids.keys()}
        living = {pid for pid in set(owners.values()) if proc.is_alive(pid)}
        return {key for key, pid in owners.items() if pid not in living}

    def _owners(self, participants: set[str]) -> dict[str, int | None]:
        """The process of each participant; None if it is unknown."""
        new = participants - self._pids.keys()
        own = self._observer.own_gid() if new else b""
        if own and gids.scheme_holds(own, os.getpid()):
            for participant in new:
                self._find(participant, own)
        return {participant: self._pids.get(participant) for participant in participants}

    def _find(self, participant: str, own: bytes) -> None:
        gid = bytes.fromhex(participant.replace(".", ""))
        low16 = gids.pid_low16(gid) if gids.same_host(gid, own) else None
        pid = None if low16 is None else gids.find_pid(low16, self._observer.domain_id)
        if pid is not None:
            self._pids[participant] = pid

    def _services(self, nodes: Iterable[str]) -> dict[str, tuple[str, ...]]:
        return {
            name: tuple(types)
            for node in sorted(set(nodes))
            for name, types in self._observer.services_of(node)
        }

    def _count_participants(self) -> None:
        """Compare the participants of this machine with those known; early on, ask the others."""
        if time.monotonic() < self._next_count_s:
            return
        self._next_count_s = time.monotonic() + self.count_s
        if not self._has_asked:
            self._has_asked = True
            reannounce_to_silent(self._observer)
        here = participants_by_domain()[self._observer.domain_id]
        self._complete = here <= len(self._observer.participants())


def without_exited(nodes: Iterable[str], gone: Iterable[Endpoint]) -> tuple[str, ...]:
    """The nodes, of which one that was started again is listed once; `gone` are of exited ones.

    DDS lists a node whose process was killed for 20 s more; alone, it stays, as a ghost.
    """
    exited: dict[str, set[str]] = defaultdict(set)
    for endpoint in gone:
        exited[endpoint.node].add(participant_of(endpoint.gid))
    counts = Counter(nodes)
    return tuple(
        name
        for name, count in sorted(counts.items())
        for _ in range(max(1, count - len(exited[name])))
    )


def _pids(
    endpoints: Iterable[Endpoint], owners: Mapping[str, int | None], exited: Set[str]
) -> dict[str, int]:
    """Node -> process; the living one if a ghost has the same name."""
    found: dict[str, int] = {}
    # those of ghosts first, so that others replace them
    for endpoint in sorted(endpoints, key=lambda e: participant_of(e.gid) not in exited):
        pid = owners[participant_of(endpoint.gid)]
        if pid is not None:
            found[endpoint.node] = pid
    return found
