"""Runs the probes of all hosts and of this machine at the same time, and has them find each other.

Nobody waits for a host that does not answer: those that have answered are introduced to each
other at once.
"""

from __future__ import annotations

import secrets
import selectors
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from launcher.base.model.record import Record
from launcher.hosts.check.host_findings import Arrival, Survey
from launcher.hosts.check.probe_session import ProbeSession
from launcher.hosts.file.hosts_model import LOCAL

TIMEOUT_S = 5.0
SETTLE_S = 1.0  # after which a datagram that was sent ten times is lost


class ProbeQuestion(Record):
    """What every probe is given; `environments` are by name, as is `server_ports`."""

    domain: int
    environments: Mapping[str, Mapping[str, str]]
    folders: Mapping[str, Sequence[str]]
    server_ports: Mapping[str, int] = {}


def survey(
    sessions: Sequence[ProbeSession],
    question: ProbeQuestion,
    own_addresses: Mapping[str, str],
    timeout_s: float = TIMEOUT_S,
    spent_s: float = 0.0,
) -> Survey:
    """Ask all hosts, this machine among them.

    `own_addresses` are those of this machine as each host sees it. Of the time `spent_s` is over.
    """
    surveyor = _Surveyor(sessions, question, own_addresses, timeout_s, spent_s)
    try:
        surveyor.start()
        surveyor.run()
    finally:
        surveyor.close()
    members = {session.name: session.member() for session in sessions}
    return Survey(members=members, arrived=frozenset(surveyor.arrived))


class _Surveyor:
    def __init__(
        self,
        sessions: Sequence[ProbeSession],
        question: ProbeQuestion,
        own_addresses: Mapping[str, str],
        timeout_s: float,
        spent_s: float,
    ) -> None:
        self._sessions = sessions
        self._question = question
        self._own_addresses = own_addresses
        self._timeout_s = timeout_s
        self._spent_s = spent_s
        self._nonce = secrets.token_hex(8)
        self._selector = selectors.DefaultSelector()
        self._started: list[ProbeSession] = []
        self._ready: list[ProbeSession] = []
        self._settled_s = 0.0  # when datagrams are no longer waited for
        self.arrived: set[Arrival] = set()

    def start(self) -> None:
        self._deadline_s = time.monotonic() + self._timeout_s - self._spent_s
        for session in self._sessions:
            session.start(self._request(session))
            self._started.append(session)
            self._selector.register(session.fd, selectors.EVENT_READ, session)

    def _request(self, session: ProbeSession) -> dict[str, Any]:
        question, needs, name = self._question, session.needs, session.name
        return {
            "name": name,
            "nonce": self._nonce,
            "domain": question.domain,
            "environment": dict(question.environments.get(name, {})),
            "folders": list(question.folders.get(name, ())),
            "server_port": question.server_ports.get(name),
            "packages": needs.packages,
            "executables": needs.executables,
            "interfaces": needs.interfaces,
        }

    def run(self) -> None:
        """Until all have answered, or are given up."""
        while not self._is_over():
            for key, _ in self._selector.select(self._wait_s()):
                self._take(key.data)
            if time.monotonic() >= self._deadline_s:
                self._give_up(session for session in self._sessions if not session.facts)

    def _wait_s(self) -> float:
        now_s = time.monotonic()
        ends = [end_s for end_s in (self._deadline_s, self._settled_s) if end_s > now_s]
        return min(ends, default=now_s) - now_s

    def _is_over(self) -> bool:
        now_s = time.monotonic()
        if now_s >= self._deadline_s + SETTLE_S:
            return True
        if not all(session.is_done for session in self._sessions):
            return False
        return now_s >= self._settled_s or not self._missing()

    def _give_up(self, sessions: Iterable[ProbeSession]) -> None:
        for session in sessions:
            if session.error is None:
                self._selector.unregister(session.fd)
                session.give_up(self._timeout_s)

    def _take(self, session: ProbeSession) -> None:
        for answer in session.take():
            if "facts" in answer:
                self._introduce(session)
            elif "heard" in answer:
                self._arrived(answer["kind"], answer["heard"], session)
        if session.error is not None:
            self._selector.unregister(session.fd)

    # ---- who receives from whom

    def _introduce(self, new: ProbeSession) -> None:
        for other in self._ready:
            for sender, receiver in ((new, other), (other, new)):
                sender.ask(
                    peer=receiver.name,
                    address=self._address(receiver, sender),
                    ports=receiver.facts["ports"],
                )
        self._ready.append(new)
        self._settled_s = time.monotonic() + SETTLE_S

    def _address(self, receiver: ProbeSession, sender: ProbeSession) -> str:
        """Of the receiver, as the sender sees it."""
        if receiver.name == LOCAL:
            return self._own_addresses.get(sender.name, receiver.address)
        return receiver.address

    def _arrived(self, kind: str, sender: str, receiver: ProbeSession) -> None:
        self.arrived.add(Arrival(kind=kind, sender=sender, receiver=receiver.name))
        if not self._missing_between(sender, receiver):
            session = next(one for one in self._sessions if one.name == sender)
            session.ask(enough=receiver.name)

    def _missing(self) -> bool:
        return any(
            self._missing_between(sender.name, receiver)
            for sender in self._ready
            for receiver in self._ready
            if sender is not receiver
        )

    def _missing_between(self, sender: str, receiver: ProbeSession) -> bool:
        return any(
            Arrival(kind=kind, sender=sender, receiver=receiver.name) not in self.arrived
            for kind in receiver.facts["ports"]
        )

    def close(self) -> None:
        self._selector.close()
        for session in self._started:
            session.close()
