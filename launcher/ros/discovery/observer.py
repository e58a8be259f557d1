"""An rclpy node that reads the graph of a domain.

Verbs that publish, subscribe or call services need one; those that only read the graph use it
where discovery is not plain RTPS (`domains.is_plain`).
"""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import rclpy
from rclpy.context import Context
from rclpy.logging import get_logging_directory
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.parameter import Parameter

from launcher.packages.distribution import profiles_variable
from launcher.posix import log_folder
from launcher.posix.domains import (
    environment_domain,
    has_profiles,
    see_whole_graph,
)
from launcher.posix.stdio import stdout_to_stderr
from launcher.ros.discovery.endpoints import NODES_TOPIC
from launcher.ros.discovery.gids import (
    PARTICIPANT_BYTES,
    all_live,
    ghosts,
    participant_of,
    scheme_holds,
)
from launcher.ros.discovery.returned_nodes import ReturnedNodes
from launcher.ros.discovery.stale_nodes import StaleNodes
from launcher.ros.helpers.clean_up import limited_clean_up
from launcher.ros.snapshot.ros_graph import (
    TOPIC,
    UNKNOWN_NODE,
    Direction,
    Endpoint,
    EndpointInfo,
    GraphSnapshot,
    TopicGraph,
    shown_history,
)

if TYPE_CHECKING:
    from launcher.ros.discovery.prefetch import Prefetch

_PERIOD_S = 0.1
_ROOM = 64  # for entities of our node


class Observer:
    """A node in a separate context; use it in a `with` statement.

    `domain_id` None is the environment's. With a name it is a node like others and sees itself;
    without, it is hidden from other observers, and its name says its `purpose`, such as the verb.
    A `prefetch` introduces it to the others. `profile`
    is a file of Fast DDS, for users who have none.
    """

    def __init__(
        self,
        domain_id: int | None = None,
        *,
        name: str | None = None,
        purpose: str = "verb",
        prefetch: Prefetch | None = None,
        profile: str | None = None,
    ) -> None:
        self._prefetch = prefetch
        self._profile = profile
        self.domain_id = environment_domain() if domain_id is None else domain_id
        self._is_hidden = name is None
        self._stale = StaleNodes()
        self._returned = ReturnedNodes()
        # names that begin with an underscore are hidden; two observers may run at the same time
        label = re.sub(r"\W", "_", purpose, flags=re.ASCII)
        self.name = name or f"_launcher_{label}_{os.getpid()}_{id(self):x}"

    def __enter__(self) -> Observer:
        see_whole_graph()
        _provide_log_folder()
        self.context = Context()
        rclpy.init(
            args=[],  # ours are none of ROS's: --remap /a:=/b of `bag play`
            context=self.context,
            domain_id=self.domain_id,
            signal_handler_options=rclpy.signals.SignalHandlerOptions.NO,
        )
        self.created_s = time.monotonic()
        # Fast DDS prints warnings about a new participant to stdout
        with stdout_to_stderr(), _profile_of_fast_dds(self._profile):
            self.node = _node(self.name, self.context, is_hidden=self._is_hidden)
        if self._prefetch is not None:
            self._prefetch.introduce()
        return self

    def __exit__(self, *exit_info: object) -> None:
        with limited_clean_up():
            self.node.destroy_node()
            self.context.try_shutdown()

    @property
    def is_introduced(self) -> bool:
        """Whether a prefetch introduces us to the others; they must not be made to forget us."""
        return self._prefetch is not None

    @property
    def is_prefetching(self) -> bool:
        """Whether `prefetched_graph` would wait for the prefetch."""
        return self._prefetch is not None and self._prefetch.is_reading

    def prefetched_graph(self) -> GraphSnapshot | None:
        """The graph of the prefetch, when it is complete or enough; None without a prefetch."""
        if self._prefetch is None:
            return None
        return self._prefetch.snapshot(self.own_gid()[:PARTICIPANT_BYTES])

    def helper(self, suffix: str) -> Any:
        """One more hidden node of the same participant, to spin or to publish with."""
        return _node(f"{self.name}_{suffix}", self.context, is_hidden=True)

    def companion(self, name: str) -> Any:
        """One more node of the same participant, which others see; InvalidNodeNameException."""
        return _node(name, self.context, is_hidden=True)

    def _hides(self, name: str) -> bool:
        return self._is_hidden and (name == self.name or name.startswith(f"{self.name}_"))

    def node_names(self) -> list[str]:
        """Full names of all nodes but ours, sorted; a name that two nodes share comes twice."""
        found = self.node.get_node_names_and_namespaces()
        return sorted(full_name(name, space) for name, space in found if not self._hides(name))

    def topic_types(self) -> dict[str, list[str]]:
        """Every topic and its types, our own `/parameter_events` among them."""
        return dict(self.node.get_topic_names_and_types())

    def dds_topics(self) -> set[str]:
        """The names in DDS of every topic, and of the two of every service."""
        return {name for name, _ in self.node.get_topic_names_and_types(no_demangle=True)}

    def services_of(self, node: str) -> list[tuple[str, list[str]]]:
        """The services that a node offers, with their types; none if the node is not known."""
        namespace, _, name = node.rpartition("/")
        try:
            found = self.node.get_service_names_and_types_by_node(name, namespace or "/")
        except NodeNameNonExistentError:
            return []
        return list(found)

    def participants(self) -> set[bytes]:
        """The GIDs of all participants known, this one's as well."""
        return self._participants_on_nodes(self.node.get_publishers_info_by_topic)

    def is_half_known(self) -> bool:
        """Whether subscriptions of a known participant have yet to arrive.

        Its first is that of `NODES_TOPIC`, on which each publishes as well.
        """
        reading = self._participants_on_nodes(self.node.get_subscriptions_info_by_topic)
        return not self.participants() <= reading

    def _participants_on_nodes(self, ask: Callable[..., Any]) -> set[bytes]:
        infos = ask(NODES_TOPIC, no_mangle=True)
        return {bytes(info.endpoint_gid[:PARTICIPANT_BYTES]) for info in infos}

    def own_gid(self) -> bytes:
        """The GID of this node's own publisher; empty if it is not known yet."""
        own = self.node.get_publishers_info_by_topic("/parameter_events")
        gids = [bytes(i.endpoint_gid) for i in own if i.node_name == self.name]
        # a visible node may have a namesake
        gids.sort(key=lambda gid: not scheme_holds(gid, os.getpid()))
        return gids[0] if gids else b""

    def infos(
        self, topic: str, direction: Direction, *, with_own: bool = False
    ) -> list[EndpointInfo]:
        """The publishers or subscriptions of a topic, our own if they are wanted."""
        return self.dds_infos(f"{TOPIC}{topic}", direction, with_own=with_own)

    def dds_infos(
        self, name: str, direction: Direction, *, with_own: bool = False
    ) -> list[EndpointInfo]:
        """The same by the topic's name in DDS."""
        ask = (
            self.node.get_publishers_info_by_topic
            if direction is Direction.PUBLISHER
            else self.node.get_subscriptions_info_by_topic
        )
        return [
            _info(name, direction, info)
            for info in ask(name, no_mangle=True)
            if with_own or not self._hides(info.node_name)
        ]

    def endpoints(self, topic: str) -> list[Endpoint]:
        """The publishers and subscriptions of a topic but our own."""
        return [info.endpoint() for direction in Direction for info in self.infos(topic, direction)]

    def all_endpoints(self) -> list[Endpoint]:
        """The endpoints of all topics whose node is known, sorted."""
        found = [e for topic in self.topic_types() for e in self.endpoints(topic)]
        return sorted(self._returned.named(found))

    def returned_nodes(self) -> frozenset[str]:
        """Those that `all_endpoints` has found last, and that `node_names` does not list any more.

        They were out of reach for a while.
        """
        return self._returned.names

    def topic_graph(self) -> TopicGraph:
        """What is known now; discovery may still be on its way."""
        # Names first: a node that is discovered meanwhile would be shown without its endpoints.
        nodes = self.node_names()
        found = self.all_endpoints()
        nodes = sorted([*nodes, *self.returned_nodes().difference(nodes)])
        endpoints = tuple(e for e in found if e.node in nodes)
        nodes = self.living(nodes, endpoints)
        ghosts = self._ghosts(endpoints)
        return TopicGraph(nodes=tuple(nodes), endpoints=endpoints, ghosts=ghosts)

    def graph_snapshot(self) -> GraphSnapshot:
        """The same with services and what is not ROS's."""
        nodes = self.node_names()
        names = self.dds_topics()
        own = self.own_gid()[:PARTICIPANT_BYTES].hex(".") if self._is_hidden else ""
        found = [info for name in names for d in Direction for info in self.dds_infos(name, d)]
        infos = [info for info in found if not own or not info.gid.startswith(own)]
        infos.sort(key=lambda i: (i.topic, i.node, i.direction, i.gid))
        nodes = self.living(nodes, infos)
        graph = GraphSnapshot(domain_id=self.domain_id, nodes=tuple(nodes), infos=tuple(infos))
        return replace(graph, ghosts=self._ghosts(graph.topic_graph().endpoints))

    def living(self, nodes: Iterable[str], endpoints: Iterable[Endpoint]) -> list[str]:
        """The nodes without those whose participant has gone; `endpoints` are all that there are.

        Nodes first, then their endpoints: of a node that is discovered meanwhile, none are known.
        """
        owners: dict[str, set[str]] = {}
        for endpoint in endpoints:
            owners.setdefault(endpoint.node, set()).add(participant_of(endpoint.gid))
        return self._stale.without(
            nodes, owners, lambda: {gid.hex(".") for gid in self.participants()}
        )

    def ghosts(self) -> tuple[str, ...]:
        """Nodes whose processes have ended, and that DDS still lists; sorted."""
        if all_live(self.participants(), self.own_gid(), self.domain_id):
            return ()
        return self._ghosts(self.all_endpoints())

    def _ghosts(self, endpoints: Iterable[Endpoint]) -> tuple[str, ...]:
        """Nodes all of whose endpoints belong to processes that have ended, sorted."""
        if all_live(self.participants(), self.own_gid(), self.domain_id):
            return ()
        owners = {e.gid: e.node for e in endpoints}
        gids = {bytes.fromhex(gid.replace(".", "")) for gid in owners}
        gone = {gid.hex(".") for gid in ghosts(gids, self.own_gid(), os.getpid())}
        alive = {node for gid, node in owners.items() if gid not in gone}
        return tuple(sorted({node for gid, node in owners.items() if gid in gone} - alive))

    def wait_for(self, fact: Callable[[TopicGraph], bool], deadline_s: float) -> TopicGraph:
        """The first snapshot for which `fact` holds; the last one at the deadline."""
        end = time.monotonic() + deadline_s
        while not fact(snapshot := self.topic_graph()) and time.monotonic() < end:
            time.sleep(_PERIOD_S)
        return snapshot


@contextlib.contextmanager
def _profile_of_fast_dds(path: str | None) -> Iterator[None]:
    """Have a participant that is made meanwhile read this file, unless the user has one."""
    if path is None or has_profiles():
        yield
        return
    variable = profiles_variable()
    os.environ[variable] = path
    try:
        yield
    finally:
        del os.environ[variable]


def _provide_log_folder() -> None:
    try:
        named = str(get_logging_directory())
    except RuntimeError:  # HOME is not set
        named = os.path.expanduser("~/.ros/log")
    log_folder.provide(os.environ, named)


def _node(name: str, context: Context, *, is_hidden: bool) -> Any:
    """A hidden node offers no services, and does not write to /rosout."""
    node = Node(
        name,
        context=context,
        use_global_arguments=False,
        enable_rosout=not is_hidden,
        start_parameter_services=not is_hidden,
        parameter_overrides=[Parameter("start_type_description_service", value=not is_hidden)],
    )
    _forget_destroyed(node)
    return node


def full_name(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"


def _info(topic: str, direction: Direction, info: Any) -> EndpointInfo:
    profile = info.qos_profile
    known = info.node_name != UNKNOWN_NODE
    return EndpointInfo(
        topic=topic,
        type=info.topic_type,
        node=full_name(info.node_name, info.node_namespace) if known else "",
        direction=direction.value,
        reliability=profile.reliability.name,
        durability=profile.durability.name,
        liveliness=profile.liveliness.name,
        deadline_ns=profile.deadline.nanoseconds,
        lease_ns=profile.liveliness_lease_duration.nanoseconds,
        lifespan_ns=profile.lifespan.nanoseconds,
        type_hash=str(info.topic_type_hash),
        history=shown_history(profile.history.name, profile.depth),
        gid=".".join(f"{byte:02x}" for byte in info.endpoint_gid),
    )


class _LivingReferences(set[Any]):
    """Weak references; dead ones are dropped when there are twice as many as before."""

    def __init__(self) -> None:
        super().__init__()
        self._most = _ROOM

    def add(self, reference: object) -> None:
        if len(self) >= self._most:
            self.difference_update([one for one in list(self) if one() is None])
            self._most = 2 * len(self) + _ROOM
        super().add(reference)


def _forget_destroyed(node: Node) -> None:
    """Let its callback group forget entities that were destroyed, which rclpy does not.

    For a node that makes entities again and again; before it makes the first.
    """
    group = node.default_callback_group
    entities, group.entities = group.entities, _LivingReferences()
    group.entities.update(entities)
