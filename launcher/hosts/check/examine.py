"""The whole check: who is asked what, and what is wrong."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.level import Level
from launcher.base.model.record import Record
from launcher.hosts import discovery
from launcher.hosts.check.host_findings import CheckedHost, HostFinding, Needs, Survey
from launcher.hosts.check.host_judges import SHM, check_member, problem
from launcher.hosts.check.needs import environment_of, log_folder
from launcher.hosts.check.pair_judges import check_pairs
from launcher.hosts.check.probe import SETTINGS
from launcher.hosts.check.probe_session import ProbeSession
from launcher.hosts.check.survey import TIMEOUT_S, ProbeQuestion, survey
from launcher.hosts.discovery import Wiring
from launcher.hosts.file.hosts_model import (
    LOCAL,
    Discovery,
    DiscoveryMode,
    Host,
    HostsFile,
    Secret,
)

_ORDER = (Level.PROBLEM, Level.NOTE)
_WITH_ADDRESSES = (DiscoveryMode.PEERS, DiscoveryMode.SERVER)


class Examination(Record):
    survey: Survey
    findings: tuple[HostFinding, ...]
    mode: DiscoveryMode | None

    @property
    def is_well(self) -> bool:
        return all(finding.level is not Level.PROBLEM for finding in self.findings)


def examine(
    file: HostsFile,
    found_discovery: Discovery,
    needs: Mapping[str, Needs],
    *,
    domain: int,
    timeout_s: float = TIMEOUT_S,
) -> Examination:
    """Ask all hosts of the file; UsageError for a discovery server on none of them."""
    begin_s = time.monotonic()
    found, mistakes = _addresses(file.hosts.values(), timeout_s / 2)
    sessions = [ProbeSession(LOCAL, None, "127.0.0.1", Needs())]
    for host in file.hosts.values():
        address, _ = found.get(host.name, (host.address, ""))
        sessions.append(ProbeSession(host.name, host, address, needs.get(host.name, Needs())))
    resolved = [host for host in file.hosts.values() if host.name in found]
    wiring = discovery.wire(found_discovery, resolved, known=file.hosts, domain=str(domain))
    question = _question(file, wiring, domain)
    own = {name: own for name, (_, own) in found.items()}
    result = survey(sessions, question, own, timeout_s, time.monotonic() - begin_s)
    mode = found_discovery.mode
    findings = [one for member in result.members.values() for one in check_member(member)]
    findings += check_pairs(result, mode)
    findings += _unresolved(result, mistakes, mode)
    findings += missing_secrets(result.members.values(), os.environ)
    findings.sort(key=lambda finding: _ORDER.index(finding.level))
    return Examination(survey=result, findings=tuple(findings), mode=mode)


def _addresses(
    hosts: Collection[Host], timeout_s: float
) -> tuple[dict[str, tuple[str, str]], dict[str, LauncherError]]:
    """(address, that of this machine as the host sees it) by host; why others have none."""
    found: dict[str, tuple[str, str]] = {}
    mistakes: dict[str, LauncherError] = {}

    def resolve(host: Host) -> None:
        try:
            address = discovery.address_of(host)
            found[host.name] = (address, discovery.own_address(address))
        except LauncherError as error:
            mistakes[host.name] = error

    threads = [threading.Thread(target=resolve, args=(host,), daemon=True) for host in hosts]
    for thread in threads:
        thread.start()
    deadline_s = time.monotonic() + timeout_s
    for thread in threads:
        thread.join(max(0.0, deadline_s - time.monotonic()))
    resolved = dict(found)  # threads may still add to it
    late = {host.name: _late(host, timeout_s) for host in hosts if host.name not in resolved}
    return resolved, {**late, **dict(mistakes)}


def _late(host: Host, timeout_s: float) -> LauncherError:
    return UsageError(
        f"the address '{host.address}' of {host.name} was not resolved within {timeout_s:g} s",
        hint="discovery needs it: write a number as `address:`, or repair the name server",
    )


def _unresolved(
    result: Survey, mistakes: Mapping[str, LauncherError], mode: DiscoveryMode | None
) -> list[HostFinding]:
    """Hosts that ssh reaches, but of which nodes would not know the address."""
    if mode not in _WITH_ADDRESSES:
        return []
    return [
        problem("discovery", member, error.message, error.hint or "correct `address:`")
        for name, error in mistakes.items()
        if (member := result.members[name]).error is None
    ]


def _question(file: HostsFile, wiring: Wiring, domain: int) -> ProbeQuestion:
    passed_on = environment_of(SETTINGS, os.environ)
    environments = {LOCAL: _wired(wiring, LOCAL)}
    folders: dict[str, Sequence[str]] = {LOCAL: [log_folder(os.environ)]}
    for host in file.hosts.values():
        environments[host.name] = {**passed_on, **_wired(wiring, host.name), **_plain(host)}
        folders[host.name] = [host.workspace, log_folder({}), SHM]
    return ProbeQuestion(
        domain=domain,
        environments=environments,
        folders=folders,
        server_ports={server.host: server.port for server in wiring.servers},
    )


def _wired(wiring: Wiring, name: str) -> Mapping[str, str]:
    """Nothing where the addresses are not known, which is reported."""
    is_known = name in wiring.addresses or (name == LOCAL and bool(wiring.addresses))
    return wiring.environment_of(name) if is_known or wiring.mode not in _WITH_ADDRESSES else {}


def _plain(host: Host) -> dict[str, str]:
    """Without what is secret, which no check needs."""
    return {k: v for k, v in host.environment.items() if k not in host.secrets}


def missing_secrets(
    members: Iterable[CheckedHost], environ: Mapping[str, str]
) -> Iterator[HostFinding]:
    """Secrets that a run would not find on this machine, each with the hosts that need it.

    No value is read.
    """
    needed: dict[tuple[str, Secret], list[str]] = {}
    for member in members:
        for name, secret in (member.host.secrets if member.host else {}).items():
            needed.setdefault((name, secret), []).append(member.name)
    for (name, secret), hosts in needed.items():
        if not _is_there(secret, environ):
            text = f"{secret}, for {name}, is missing here, so that no run can start"
            repair = "create it" if secret.file else f"{secret.variable}=... launcher ..."
            yield HostFinding(
                check="secrets",
                hosts=(LOCAL, *hosts),
                level=Level.PROBLEM,
                text=text,
                advice=f"{repair}, or remove it from `environment` in the hosts file",
            )


def _is_there(secret: Secret, environ: Mapping[str, str]) -> bool:
    if secret.variable is not None:
        return secret.variable in environ
    return os.access(secret.file or "", os.R_OK)
