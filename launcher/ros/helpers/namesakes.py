"""Looks for nodes of others that have the names of ours, as a separate process.

A JSON object on standard input says what the run is, see `NamesakeSearch`; if there are some, a
text for the user goes to standard output as JSON. It ends after some seconds, or with its input.

First it asks the other runs of this user, which are known for certain; then it reads the discovery
messages, without DDS. A process of this machine is ours if it has the id of the run or descends
from the launcher, and is foreign if it has another id or is older than the launcher. Of others, on
other machines, too, that is not known: they may be in a container or an ssh session of this run.
Their nodes are reported if there is one more of the name in a process that is ours. What is found
must be there a second time: a run that is being stopped while this one starts is no mistake.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.base.text import several
from launcher.posix import dispositions, domains, proc
from launcher.posix.cleanup import run_id
from launcher.posix.ports import announcement_ports
from launcher.posix.stdio import end_of_input, keep_for_messages
from launcher.ros.discovery import gids
from launcher.ros.discovery.discovery_reader import DiscoveryReader, UnsupportedDiscovery
from launcher.ros.discovery.free_domain import free_domain
from launcher.ros.discovery.participant import Participant
from launcher.ros.discovery.run_settings import connections
from launcher.ros.snapshot.ros_graph import is_hidden

NICENESS = 10  # processes of the run are starting
READ_S = 2.0
ROUND_S = 1.0  # between two looks
ROUNDS = 8
ASK_S = 1.0  # for the answer of another run
HOST_BYTES = 4  # of the prefix of a GUID: vendor and host
_SETTINGS = ("ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS", "RMW_IMPLEMENTATION")


class Namesake(NamedTuple):
    """A node that may not be ours. `owner` is a pid, or the prefix of a participant's GUID."""

    name: str
    owner: int | bytes
    where: str
    is_foreign: bool  # for certain


class NamesakeSearch:
    """Of a run: its id, the pid of its launcher, and names of its nodes.

    None stands for a node whose name is that of its program, which is known when it has started.
    """

    def __init__(self, run: str, launcher: int, names: Iterable[str | None]) -> None:
        every = list(names)
        self._run, self._launcher = run, launcher
        self._names = {name for name in every if name is not None}
        self._unnamed = every.count(None)
        self._seen: set[str] = set()  # in processes that are ours
        self._own: set[bytes] = set()  # participants, by the prefixes of their GUIDs
        self._runs: dict[str, str] = {}  # id -> how a user finds it
        self._domain_id = domains.environment_domain()

    def run(self, over: threading.Event) -> list[Namesake]:
        """Those that were there twice."""
        before: set[tuple[str, int | bytes]] = set()
        for _ in range(ROUNDS):
            found = list(self._look())
            names = self._names | self._seen
            alike = [one for one in found if one.name in names]
            suspects = [one for one in alike if one.is_foreign or one.name in self._seen]
            again = [one for one in suspects if (one.name, one.owner) in before]
            has_more = len(self._seen - self._names) < self._unnamed
            if again or not (alike or (found and has_more)):
                return again
            before = {(one.name, one.owner) for one in suspects}
            if over.wait(ROUND_S):
                break
        return []

    def _look(self) -> Iterator[Namesake]:
        """Nodes that may not be ours; one may be found twice."""
        yield from self._in_runs()
        yield from self._in_domain()

    # ---- other runs

    def _in_runs(self) -> Iterator[Namesake]:
        for connection in connections():
            run = connection.hello["run"]
            if run["id"] == self._run:
                continue
            where = f"run {run['id']}, {os.path.basename(run['target'])}"
            self._runs[run["id"]] = where
            with contextlib.suppress(LauncherError):
                rows = connection.ask("ps", timeout_s=ASK_S).result["processes"]
                yield from self._of_rows(rows, where)

    def _of_rows(self, rows: Sequence[Mapping[str, object]], where: str) -> Iterator[Namesake]:
        for row in rows:
            pid, names = row["pid"], row["node_names"]
            if not isinstance(pid, int) or not isinstance(names, list):
                continue
            if row.get("host", "local") == "local" and self._meets(pid) and not self._is_ours(pid):
                yield from (Namesake(name, pid, where, is_foreign=True) for name in names)

    def _meets(self, pid: int) -> bool:
        """Whether the nodes of a process and ours find each other, by its environment."""
        entries = (os.fsdecode(one).partition("=") for one in proc.environment(pid))
        theirs = {name: value for name, _, value in entries}
        return (
            (theirs.get("ROS_DOMAIN_ID") or "0") == str(self._domain_id)
            and not domains.is_off(theirs)
            and all(theirs.get(one, "") == os.environ.get(one, "") for one in _SETTINGS)
        )

    # ---- the domain

    def _in_domain(self) -> Iterator[Namesake]:
        peers = self._participants()
        owners = self._owners()  # of those that started meanwhile, too
        # Participants of this machine may answer from any of its addresses.
        hosts = {peer.prefix[:HOST_BYTES] for peer in peers if peer.is_local}
        for peer in peers:
            names = [node.name for node in peer.nodes() if not is_hidden(node.name)]
            is_near = peer.is_local or peer.prefix[:HOST_BYTES] in hosts
            pids = owners.get(peer.port, []) if is_near else []
            if peer.prefix in self._own or any(map(self._is_ours, pids)):
                self._own.add(peer.prefix)
                self._seen.update(names)
            elif pids:
                yield from self._of_process(pids[0], names)
            else:
                where = "a process of another user" if is_near else f"at {peer.address[0]}"
                yield from (Namesake(name, peer.prefix, where, is_foreign=False) for name in names)

    def _of_process(self, pid: int, names: Sequence[str]) -> Iterator[Namesake]:
        run = run_id.run_id_of(pid)
        where = f"pid {pid}" if run is None else self._runs.get(run, f"run {run}")
        is_foreign = run is not None or self._is_older(pid)
        yield from (Namesake(name, pid, where, is_foreign=is_foreign) for name in names)

    def _is_older(self, pid: int) -> bool:
        started, launcher_started = proc.start_ticks(pid), proc.start_ticks(self._launcher)
        return started is not None and launcher_started is not None and started < launcher_started

    def _participants(self) -> Sequence[Participant]:
        if not domains.is_plain():
            return ()
        remote = not domains.localhost_only()
        try:
            with DiscoveryReader(self._domain_id, remote=remote) as reader:
                reader.read(READ_S)
                return reader.participants
        except (OSError, UnsupportedDiscovery):
            return ()

    def _owners(self) -> dict[int, list[int]]:
        """Port -> processes that hold it, as far as they can be looked at."""
        found: dict[int, list[int]] = {}
        ports = announcement_ports(self._domain_id)
        for pid, inodes in gids.holders(set(ports), set()).items():
            for inode in inodes:
                found.setdefault(ports[inode], []).append(pid)
        return found

    def _is_ours(self, pid: int) -> bool:
        return run_id.run_id_of(pid) == self._run or self._launcher in run_id.ancestors(pid)


def warning(domain_id: int, found: Sequence[Namesake]) -> str:
    """What to say about them."""
    names: dict[str, list[str]] = {}
    for one in sorted(found, key=lambda one: (one.name, one.where)):
        if one.name not in names.setdefault(one.where, []):
            names[one.where].append(one.name)
    places = [f"{several(nodes)} ({where})" for where, nodes in names.items()]
    text = f"ROS domain {domain_id} already has nodes with names of this run: {several(places)}"
    way_out = "--private"
    with contextlib.suppress(LauncherError), free_domain() as other:
        way_out = f"ROS_DOMAIN_ID={other}, which is free, or --private"
    return f"{text}; to keep the two apart, start one with {way_out}"


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    os.nice(NICENESS)
    request = strict_json.unpacked(sys.stdin.readline())
    if domains.is_off():
        return
    over = end_of_input()
    search = NamesakeSearch(request["run"], request["launcher"], request["names"])
    if found := search.run(over):
        print(strict_json.packed(warning(domains.environment_domain(), found)), flush=True)


if __name__ == "__main__":
    main()
