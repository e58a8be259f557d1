"""A private ROS domain with real nodes as processes and one listening node in the test."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from launcher.posix.domain_lease import leased_domain
from tests.support.node_process import NodeProcess, free_shared_memory, shared_memory_of

LISTENER = "listener"


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """One message; `sent_s` is the wall-clock time at which its publisher sent it."""

    text: str
    sent_s: float


class Domain:
    """Starts nodes, subscribes and publishes in a ROS domain; only `wait_until` takes messages."""

    def __init__(self, domain_id: int, log_dir: Path) -> None:
        self.nodes: list[NodeProcess] = []
        self._ports = range(7400 + 250 * domain_id, 7400 + 250 * (domain_id + 1))
        self.env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(log_dir),
        }
        self._shared_memory: set[Path] = set()
        before = shared_memory_of(os.getpid())
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self.listener = Node(LISTENER, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.listener)
        self._listener_files = shared_memory_of(os.getpid()) - before

    def start(self, name: str, **settings: Any) -> NodeProcess:
        node = NodeProcess(name, env=self.env, settings=settings)
        self.nodes.append(node)
        return node

    def record(self, topic: str, profile: QoSProfile) -> list[Heard]:
        """The list that grows with every message on the topic from now on."""
        heard: list[Heard] = []

        def keep(message: String, info: dict[str, int]) -> None:
            heard.append(Heard(text=message.data, sent_s=info["source_timestamp"] / 1e9))

        self.listener.create_subscription(String, topic, keep, profile)
        return heard

    def publisher(self, topic: str, profile: QoSProfile) -> Callable[[str], None]:
        """A function that publishes a text on the topic."""
        publisher = self.listener.create_publisher(String, topic, profile)
        return lambda text: publisher.publish(String(data=text))

    def wait_until(self, fact: Callable[[], object], what: str, timeout_s: float = 60.0) -> None:
        """Take messages until the fact holds; fails the test after the timeout."""
        deadline_s = time.monotonic() + timeout_s
        while not fact():
            if time.monotonic() > deadline_s:
                outputs = "\n".join(f"--- {node.name}\n{node.output}" for node in self.nodes)
                raise AssertionError(f"not within {timeout_s} s: {what}\n{outputs}")
            self._executor.spin_once(timeout_sec=0.02)

    def wait_for_line(self, node: NodeProcess, text: str, timeout_s: float = 60.0) -> None:
        self.wait_until(lambda: node.matching(text), f"{node.name} says {text!r}", timeout_s)

    def listen_for(self, duration_s: float) -> None:
        """Take messages for a while: for the cases where the fact is that nothing comes."""
        end_s = time.monotonic() + duration_s
        self.wait_until(lambda: time.monotonic() >= end_s, "time goes on", duration_s + 1.0)

    def wait_for_nodes(self, *names: str) -> None:
        """Wait until the graph shows the nodes."""
        self.wait_until(
            lambda: set(names) <= set(self.listener.get_node_names()), f"graph shows {names}"
        )

    def ask(self, client: Any, request: Any) -> Any:
        """The answer of a service.

        Asked again each second: it drops its answer to a client that it has not discovered yet.
        """
        begun_s = time.monotonic()
        futures: list[Any] = []

        def is_answered() -> bool:
            if len(futures) <= time.monotonic() - begun_s:
                futures.append(client.call_async(request))
            return any(future.done() for future in futures)

        self.wait_until(is_answered, f"{client.srv_name} answers")
        return next(future for future in futures if future.done()).result()

    def shared_memory(self) -> set[Path]:
        """Files in /dev/shm that the nodes have brought with them; call it while they run."""
        for node in self.nodes:
            used = {path for path in shared_memory_of(node.pid) if self._is_private(path)}
            self._shared_memory |= used - self._listener_files
        return self._shared_memory

    def _is_private(self, path: Path) -> bool:
        """Segments, and ports of this domain; ports below 7400 are shared by all domains."""
        port = re.search(r"_port(\d+)", path.name)
        return port is None or int(port[1]) in self._ports

    def close(self) -> None:
        """End every process; what killed ones left in shared memory is removed here."""
        self.shared_memory()
        for node in self.nodes:
            if node.running:
                node.signal(signal.SIGINT)  # a killed node would hold on to the listener's files
        for node in self.nodes:
            with contextlib.suppress(subprocess.TimeoutExpired):
                node.wait(5.0)
            node.kill()
        self._executor.shutdown()
        self.listener.destroy_node()
        self._context.try_shutdown()
        free_shared_memory(
            self._shared_memory | set(filter(self._is_private, self._listener_files))
        )


@contextlib.contextmanager
def private_domain(log_dir: Path) -> Iterator[Domain]:
    """A Domain that ends with every process that it started."""
    with leased_domain() as domain_id:
        domain = Domain(domain_id, log_dir)
        try:
            yield domain
        finally:
            domain.close()
