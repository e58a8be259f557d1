"""The hosts of a plan, without the values of secrets."""

from __future__ import annotations

from launcher.base.errors import UsageError
from launcher.hosts.discovery import wire
from launcher.hosts.file.hosts_model import DiscoveryMode, HostsFile
from launcher.hosts.file.hosts_reader import read
from launcher.hosts.file.option_changes import changed
from launcher.hosts.launching import shown
from launcher.hosts.launching.placing import Placing, place
from launcher.posix.stdio import stdout_to_stderr

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from launcher.base.errors import LauncherError
    from launcher.base.model.run_options import RunOptions
    from launcher.hosts.launching.shown import PlacedThere
    from launcher.launch.plan.plan import Plan


class PlannedHosts:
    """What `options` say about hosts and discovery; LauncherError."""

    def __init__(self, options: RunOptions) -> None:
        if options.hosts is None and options.skip_hosts:
            raise UsageError("--skip-host needs --hosts FILE")
        path = options.hosts
        file = HostsFile(path="", hosts={}) if path is None else read(path, with_secrets=False)
        self._file = changed(file, options.discovery, options.skip_hosts)
        self._placing: Placing | None = None

    def place(self, plan: Plan) -> None:
        """Find the places of its processes, which was made with scopes."""
        with stdout_to_stderr():
            self._placing = place(plan, self._file)

    @property
    def placed(self) -> Sequence[PlacedThere]:
        return () if self._placing is None else self._placing.placed

    @property
    def errors(self) -> Sequence[LauncherError]:
        return () if self._placing is None else self._placing.findings.errors

    @property
    def warnings(self) -> Sequence[str]:
        """Lines about the hosts."""
        if self._placing is None:
            return ()
        findings = self._placing.findings
        found = (*findings.warnings, *self._placing.warnings)
        return [
            *(f"warning: {one}" for one in found),
            *(f"note: {one}" for one in findings.remarks),
        ]

    def discovery_document(self) -> dict[str, Any] | None:
        return shown.discovery_document(self._file.discovery)

    def discovery_line(self) -> str:
        return shown.discovery_line(self._file.discovery)

    def crowd_environment(self) -> Mapping[str, str] | None:
        """None with several hosts, which have other warnings, and with a server."""
        if self._file.hosts or self._file.discovery.mode is DiscoveryMode.SERVER:
            return None
        return wire(self._file.discovery).environment_of()
