"""`--hosts FILE` and `--discovery MODE` of the verbs about hosts."""

from __future__ import annotations

import os

from launcher.base.command_line import Parsed
from launcher.base.errors import UsageError
from launcher.base.option import option

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.hosts.file.hosts_model import HostsFile

DEFAULT = "hosts.yaml"  # in the working directory
HOSTS = option("--hosts FILE", f"the hosts file (default: {DEFAULT})")


def hosts_file(parsed: Parsed) -> HostsFile:
    """The file that --hosts names, or hosts.yaml; LauncherError."""
    from launcher.hosts.file.hosts_reader import read

    return read(hosts_path(parsed.hosts), with_secrets=False)


def hosts_path(given: str | None) -> str:
    """The path that --hosts names, or hosts.yaml; UsageError without either."""
    if given is None and not os.path.exists(DEFAULT):
        raise UsageError(f"there is no {DEFAULT} here", hint="name the hosts file: --hosts FILE")
    return given or DEFAULT
