"""The hosts file as the options `--discovery` and `--skip-host` change it."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence

from launcher.base.document.fields import near
from launcher.base.errors import UsageError
from launcher.base.model.record import replace
from launcher.hosts.file.hosts_model import DiscoveryMode, HostsFile


def changed(file: HostsFile, mode: str | None, skip_hosts: Sequence[str]) -> HostsFile:
    """With this mode of discovery, if one is given, and with hosts that match marked as skipped.

    UsageError for a pattern without a match, or the host of the discovery server. That of its
    backup may be skipped; then there is no backup.
    """
    skipped: set[str] = set()
    for pattern in skip_hosts:
        found = fnmatch.filter(file.hosts, pattern)
        if not found:
            raise _no_host(pattern, file)
        skipped.update(found)
    wanted = file.discovery.by(mode)
    warnings = file.warnings
    if wanted.mode is DiscoveryMode.SERVER:
        if wanted.server in skipped:
            hint = "name another host in `discovery:`, or --discovery peers"
            message = f"--skip-host: the discovery server runs on '{wanted.server}'"
            raise UsageError(message, hint=hint, where=wanted.where or None)
        if wanted.backup in skipped:
            warnings += (f"no backup of the discovery server: '{wanted.backup}' is skipped",)
            wanted = replace(wanted, backup=None)
    hosts = {
        name: replace(host, is_skipped=True) if name in skipped else host
        for name, host in file.hosts.items()
    }
    return replace(file, hosts=hosts, discovery=wanted, warnings=warnings)


def _no_host(pattern: str, file: HostsFile) -> UsageError:
    message = f"--skip-host: no host '{pattern}' in {file.path}"
    return UsageError(message, hint=near(pattern, file.hosts))
