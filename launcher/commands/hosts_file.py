"""`--hosts FILE` of the verbs about hosts."""

from __future__ import annotations

import os

from launcher.command_line import Parsed, option
from launcher.errors import UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.hosts.model import HostsFile

_DEFAULT = "hosts.yaml"
HOSTS = option("--hosts FILE", f"the hosts file (default: {_DEFAULT})")


def hosts_file(parsed: Parsed) -> HostsFile:
    """The file that --hosts names, or hosts.yaml; LauncherError."""
    from launcher.hosts.file import read

    if parsed.hosts is None and not os.path.exists(_DEFAULT):
        raise UsageError(f"there is no {_DEFAULT} here", hint="name the hosts file: --hosts FILE")
    return read(parsed.hosts or _DEFAULT, with_secrets=False)
