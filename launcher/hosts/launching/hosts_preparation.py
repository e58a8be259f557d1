"""Which hosts a run needs, and how nodes find each other.

The hosts file is read before the launch file is evaluated, since variables for discovery have to be
set. The places of processes are judged on what the evaluation has found, before the first of them
is started.
"""

from __future__ import annotations

import functools
import os
import sys
from collections import Counter
from collections.abc import Iterable

from launcher.base.document.document_reader import together
from launcher.base.errors import UsageError
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import ProcessSpec, RestartMode, RestartPolicy
from launcher.hosts import discovery, discovery_server
from launcher.hosts.engine.fleet import FleetPlan
from launcher.hosts.file.hosts_model import LOCAL, Discovery, DiscoveryMode, Host, HostsFile
from launcher.hosts.file.hosts_reader import read
from launcher.hosts.file.option_changes import changed
from launcher.hosts.file.placement import Placement
from launcher.hosts.launching.placing import place_first
from launcher.launch.target import LaunchRequest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.launch.launch_core import LaunchCore


class HostsPreparation:
    """What a run does about discovery and other hosts.

    `services` are processes of ours that it starts first.
    """

    def __init__(self, options: RunOptions) -> None:
        """Read the hosts file, and set the variables for discovery; LauncherError."""
        self._options = options
        self._file: HostsFile | None = None
        self._wanted = Discovery().by(options.discovery)
        self._without: dict[str, UsageError] = {}  # the hosts that have no address
        if options.hosts is not None:
            self._file = changed(read(options.hosts), options.discovery, options.skip_hosts)
            self._wanted = self._file.discovery
        self._wiring = self._wire()
        self.services = _services(self._wiring)

    def _wire(self) -> discovery.Wiring:
        """The variables for discovery; those of this machine are set."""
        hosts = () if self._file is None else _named(self._file, self._wanted)
        domain = os.environ.get("ROS_DOMAIN_ID", "")
        wiring = discovery.wire(self._wanted, hosts, domain=domain, without=self._without)
        os.environ.update({**wiring.environment_of(), **wiring.profile(os.environ)})
        return wiring

    def fleet(self, core: LaunchCore, request: LaunchRequest) -> FleetPlan | None:
        """The hosts of a launch file that was evaluated, before anything is started.

        None without a hosts file. LauncherError for what is wrong about the places of processes.
        """
        if self._file is None:
            return None
        file, placement, later = self._file, Placement(self._file), core.later()
        findings = place_first(core, later, file).findings
        for warning in findings.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        if findings.errors:
            raise together(findings.errors)
        specs = [*core.starts, *(one.spec for one in later.processes if one.is_likely)]
        self._check_required(placement, specs)
        self._warn_of_many(placement, specs)
        needed = self._needed(file, placement, specs)
        for host in needed:
            self._expect_address(host)
        return FleetPlan(
            host_of=functools.partial(self._host_of, placement),
            needed=needed,
            environments={
                host.name: self._wiring.environment_of(host.name)
                for host in _named(file, self._wanted)
                if host.name not in self._without
            },
            title=" ".join([os.path.basename(request.path), *map(":=".join, request.arguments)]),
        )

    def _host_of(self, placement: Placement, spec: ProcessSpec) -> Host | None:
        for server in self._wiring.servers:
            if server.name == spec.name:
                return placement.file.hosts.get(server.host)
        host = placement.host_of(spec)
        if host is not None:
            self._expect_address(host)
        return host

    def _expect_address(self, host: Host) -> None:
        """UsageError if nodes of other hosts could not find this one."""
        if host.name in self._without:
            raise self._without[host.name]

    def _check_required(self, placement: Placement, specs: Iterable[ProcessSpec]) -> None:
        """UsageError if one is required whose host is skipped."""
        for spec in specs:
            host = placement.host_of(spec)
            if host is not None and host.is_skipped and self._options.is_required(spec):
                message = f"{spec.name} is required, and its host, '{host.name}', is skipped"
                hint = f"leave out --required, or --skip-host, or place {spec.name} elsewhere"
                raise UsageError(message, hint=hint)

    def _warn_of_many(self, placement: Placement, specs: Iterable[ProcessSpec]) -> None:
        """Each process of a node is at least one participant."""
        if self._wanted.mode is not DiscoveryMode.PEERS:
            return
        hosts = (placement.host_of(spec) for spec in specs if spec.ros is not None)
        counts = Counter(LOCAL if host is None else host.name for host in hosts)
        for name, number in counts.items():
            if number > discovery.MAX_WITH_PEERS:
                print(
                    f"warning: {number} nodes on {name}: with peers, only "
                    f"{discovery.MAX_WITH_PEERS} of a host are found by other hosts; "
                    "--discovery server has no such limit",
                    file=sys.stderr,
                )

    def _needed(
        self, file: HostsFile, placement: Placement, specs: Iterable[ProcessSpec]
    ) -> tuple[Host, ...]:
        """Those that are connected to before anything is started."""
        found = [placement.host_of(spec) for spec in specs]
        found += _of_servers(file, self._wanted)
        used = [host for host in found if host is not None and not host.is_skipped]
        return tuple({host.name: host for host in used}.values())


def _named(file: HostsFile, wanted: Discovery) -> list[Host]:
    """The hosts on which processes may run: a function may place one there at any time."""
    found = [file.hosts.get(rule.host) for rule in file.rules] + _of_servers(file, wanted)
    used = [host for host in found if host is not None and not host.is_skipped]
    return list({host.name: host for host in used}.values())


def _of_servers(file: HostsFile, wanted: Discovery) -> list[Host | None]:
    if wanted.mode is not DiscoveryMode.SERVER:
        return []
    return [file.hosts.get(name) for name in (wanted.server, wanted.backup or "")]


def _services(wiring: discovery.Wiring) -> tuple[ProcessSpec, ...]:
    """The discovery servers; UsageError if there is no program for one that runs here."""
    for server in wiring.servers:
        if server.host == LOCAL and discovery_server.find(os.environ, sys.prefix) is None:
            raise UsageError(
                f"the discovery server is not installed: there is no {discovery_server.PROGRAM}",
                hint=f"pip install {discovery_server.wheel()}; or source a ROS 2 installation",
            )
    return tuple(map(_service, wiring.servers))


def _service(server: discovery.DiscoveryServer) -> ProcessSpec:
    words = (sys.executable, "-m", "launcher.hosts.discovery_server", *server.arguments)
    restart = RestartPolicy(mode=RestartMode.ALWAYS, delay_s=discovery.RESTART_DELAY_S)
    return ProcessSpec(
        name=server.name,
        label=server.name,
        argv=words,
        env=dict(os.environ),
        restart=restart,
        place="--discovery",
    )
