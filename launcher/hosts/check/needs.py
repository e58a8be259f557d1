"""What the processes of a plan need on the hosts on which they run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from launcher.errors import LauncherError
from launcher.hosts.check.facts import Needs
from launcher.hosts.order import order_for
from launcher.hosts.placement import Placement
from launcher.model.spec import ProcessSpec
from launcher.packages import resource_prefix, share_directory

_DEPENDENCY = re.compile(r"<(?:exec_|run_)?depend(?:\s[^>]*)?>\s*([\w.-]+)\s*<")


def needs_of(
    specs: Iterable[ProcessSpec], placement: Placement, environ: Mapping[str, str]
) -> dict[str, Needs]:
    """By name of the host. UsageError if a process has two hosts; LaunchFileError if it cannot be
    sent to its host.
    """
    by_host: dict[str, list[ProcessSpec]] = {}
    for spec in specs:
        host = placement.host_of(spec)
        if host is not None:
            by_host.setdefault(host.name, []).append(spec)
    return {name: _needs(found, environ) for name, found in by_host.items()}


def _needs(specs: Sequence[ProcessSpec], environ: Mapping[str, str]) -> Needs:
    packages: dict[str, None] = {}
    executables: dict[tuple[str, str], None] = {}
    for spec in specs:
        order = order_for(spec, base=environ)
        executables.update({(one.package, one.name): None for one in order.executables})
        packages.update({package: None for package, _ in executables})
        packages.update({file.package: None for file in order.shared_files})
    interfaces = {name for package in packages for name in _interfaces(package, environ)}
    return Needs(
        packages=tuple(packages),
        executables=tuple(executables),
        interfaces=tuple(sorted(interfaces)),
        processes=len(specs),
    )


def _interfaces(package: str, environ: Mapping[str, str]) -> list[str]:
    """The message packages that a package depends on, by its manifest."""
    try:
        manifest = Path(share_directory(package, environ), "package.xml")
        text = manifest.read_text(encoding="utf-8", errors="replace")
    except (LauncherError, OSError):
        return []
    text = re.sub(r"(?s)<!--.*?-->", "", text)
    names = _DEPENDENCY.findall(text)
    return [one for one in names if resource_prefix("rosidl_interfaces", one, environ)]


def environment_of(settings: Sequence[str], environ: Mapping[str, str]) -> dict[str, str]:
    """The variables of this machine that its processes on hosts get, too."""
    return {name: environ[name] for name in settings if name in environ and name != "ROS_DISTRO"}


def log_folder(environ: Mapping[str, str]) -> str:
    """Where nodes write their logs, as a path of another host if it is not set here."""
    return environ.get("ROS_LOG_DIR") or os.path.join(environ.get("ROS_HOME") or ".ros", "log")
