"""A graph as JSON, read back, and compared with another one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from launcher.base import strict_json, text_file
from launcher.base.ros_errors import VerbError
from launcher.ros.snapshot.qos_matching import links
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph

VERSION = 1
_MAX_BYTES = 256 * 1024 * 1024  # a thousand nodes make 10 MiB


def to_document(snapshot: TopicGraph) -> dict[str, Any]:
    return {
        "version": VERSION,
        "nodes": list(snapshot.nodes),
        "topics": list(snapshot.topics()),
        "ghosts": list(snapshot.ghosts),
        "endpoints": [asdict(endpoint) for endpoint in snapshot.endpoints],
        "mismatches": [asdict(link) for link in links(snapshot.endpoints) if link.fault],
    }


def load(path: str) -> TopicGraph:
    """A graph from a file that `graph --json` wrote; VerbError if it is not one."""
    try:
        document = strict_json.loads(text_file.read(path, limit=_MAX_BYTES))
        return TopicGraph(
            nodes=tuple(document["nodes"]),
            endpoints=tuple(sorted(Endpoint(**entry) for entry in document["endpoints"])),
            ghosts=tuple(document["ghosts"]),
        )
    except OSError as error:
        raise VerbError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError) as error:
        hint = "create it with: graph --json > FILE"
        raise VerbError(f"{path} is not a saved graph: {error}", hint=hint) from None


def difference(before: TopicGraph, after: TopicGraph) -> list[str]:
    """`- fact` for what has gone and `+ fact` for what is new, sorted; empty if nothing changed.

    GIDs are left out, since they change with every start.
    """
    old, new = Counter(_facts(before)), Counter(_facts(after))
    gone = [f"- {fact}" for fact in (old - new).elements()]
    come = [f"+ {fact}" for fact in (new - old).elements()]
    return sorted([*gone, *come], key=lambda line: (line[2:], line[0] == "+"))


def _facts(snapshot: TopicGraph) -> Iterator[str]:
    yield from (f"node {node}" for node in snapshot.nodes)
    yield from (f"ghost {node}" for node in snapshot.ghosts)
    for e in snapshot.endpoints:
        verb = "publishes" if e.is_publisher else "subscribes to"
        qos = [e.reliability, e.durability, e.liveliness]
        qos += [f"deadline {e.deadline_ns} ns"] if e.deadline_ns < 2**63 - 1 else []
        qos += [f"lease {e.lease_ns} ns"] if e.lease_ns < 2**63 - 1 else []
        yield f"{e.node} {verb} {e.topic} [{e.type}] {' '.join(qos)}"
