"""Waits until rclpy has discovered the complete graph, and no longer.

Complete: every participant that holds ports of this domain on this machine has been discovered and
has published its nodes, and rclpy has all endpoints that a prefetch has read: it may be quiet while
a lost message is repeated. Participants on other hosts hold no ports here, so where they may exist
(discovery range SUBNET) there is a shortest time as well.

The limit is above 3 s because answers to the announcement of a new participant may be lost, and
come again only with the next regular announcement (see `reannounce`, which avoids most of that).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.posix.domains import SPIN_TIME_S, least_wait_s
from launcher.posix.ports import participants_by_domain
from launcher.ros.discovery.gids import PARTICIPANT_BYTES, ghosts, participant_of, same_host
from launcher.ros.discovery.reannounce import reannounce_to_silent
from launcher.ros.snapshot.ros_graph import UNKNOWN_NODE, Direction, EndpointInfo, GraphSnapshot

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

QUIET_S = 0.1  # the samples of one participant arrive within a few milliseconds
QUIET_UNREAD_S = 0.2  # without a prefetch to compare with: a lost message comes 0.11 s later
# A discovery server passes them on in rounds: with 40 nodes, participants were known after 0.7 s,
# their names after 1.1 s, and their endpoints after 1.8 s.
QUIET_OF_SERVER_S = 0.3
# Fast DDS repeats a lost message 0.11 s after the next heartbeat, perhaps more than once. What only
# the prefetch has seen after this time has been destroyed meanwhile.
_OUTDATED_S = 1.0
_EVENTS = "/parameter_events"  # every node publishes it
_PERIOD_S = 0.02  # reading the graph delays the threads that discover
_REANNOUNCE_S = 0.05  # answers that are on their way have arrived by then


@dataclass(frozen=True, slots=True, kw_only=True)
class Settled:
    """How the wait ended; `missing` participants of this machine have not been discovered."""

    missing: int
    waited_s: float


def settle(
    observer: Observer,
    spin_time_s: float = SPIN_TIME_S,
    *,
    enough: Callable[[], object] = lambda: False,
) -> Settled:
    """Return when the graph is complete and quiet, or `enough`, or after `spin_time_s`."""
    start = changed = time.monotonic()
    shortest_s = min(spin_time_s, least_wait_s())
    quiet_s = QUIET_S if observer.is_introduced else QUIET_UNREAD_S
    quiet_s = QUIET_OF_SERVER_S if _has_server() else quiet_s
    last: object = None
    has_reannounced = observer.is_introduced  # then the silent ones are about to answer
    while True:
        now = time.monotonic()
        if now - start >= _REANNOUNCE_S and not has_reannounced:
            has_reannounced = True
            reannounce_to_silent(observer)
        state = (observer.participants(), observer.dds_topics(), observer.node_names())
        if state != last:
            last, changed = state, now
        waited_s = now - start
        if enough():
            return Settled(missing=0, waited_s=waited_s)
        quiet = now - changed >= quiet_s and waited_s >= shortest_s
        if quiet or waited_s >= spin_time_s:
            missing = _missing(observer)
            complete = missing == 0 and not _nameless(observer)
            outdated = now - changed >= _OUTDATED_S
            if waited_s >= spin_time_s or (complete and (outdated or not _lags(observer))):
                return Settled(missing=missing, waited_s=waited_s)
        time.sleep(_PERIOD_S)


def settled_graph(
    observer: Observer, spin_time_s: float, enough: Callable[[GraphSnapshot], object]
) -> GraphSnapshot:
    """The graph as it was prefetched, or as it is when it has settled."""
    if (graph := observer.prefetched_graph()) is None:
        settle(observer, spin_time_s, enough=lambda: enough(observer.graph_snapshot()))
        graph = observer.graph_snapshot()
    return graph


def _lags(observer: Observer) -> bool:
    """Whether a participant has endpoints, or names of their nodes, that rclpy has yet to discover.

    These are what the prefetch has of the participants that rclpy has: others may have ended.
    """
    if observer.is_prefetching or observer.is_half_known():
        return True
    if (graph := observer.prefetched_graph()) is None:
        return False
    known = {gid.hex(".") for gid in observer.participants()}
    read: dict[tuple[str, str], list[EndpointInfo]] = {}
    for info in graph.infos:
        if participant_of(info.gid) in known:
            read.setdefault((info.topic, info.direction), []).append(info)
    for (topic, direction), infos in read.items():
        nodes = {info.gid: info.node for info in observer.dds_infos(topic, Direction(direction))}
        if any(info.gid not in nodes or (info.node and not nodes[info.gid]) for info in infos):
            return True
    return False


def has_discovered_all(observer: Observer) -> bool:
    """Whether every participant of this machine is known, with its nodes."""
    return _missing(observer) == 0 and not _nameless(observer)


def _missing(observer: Observer) -> int:
    own_gid = observer.own_gid()
    known = _with_endpoints(observer) if _has_server() else observer.participants()
    living = known - ghosts(known, own_gid, os.getpid())
    local = {gid for gid in living if not own_gid or same_host(gid, own_gid)}
    return max(0, participants_by_domain()[observer.domain_id] - len(local))


def _has_server() -> bool:
    return bool(os.environ.get("ROS_DISCOVERY_SERVER"))


def _with_endpoints(observer: Observer) -> set[bytes]:
    """The GIDs of participants with a node whose endpoints are known, this one's as well."""
    infos = observer.node.get_publishers_info_by_topic(_EVENTS)
    return {bytes(info.endpoint_gid[:PARTICIPANT_BYTES]) for info in infos}


def _nameless(observer: Observer) -> bool:
    infos = observer.node.get_publishers_info_by_topic(_EVENTS)
    return any(info.node_name == UNKNOWN_NODE for info in infos)
