"""What the processes of a plan need on the hosts on which they run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from launcher.base import text_file
from launcher.base.errors import LauncherError
from launcher.hosts.check.host_findings import Needs
from launcher.hosts.file.order import Order
from launcher.packages.finder import resource_prefix, share_directory

_DEPENDENCY = re.compile(r"<(?:exec_|run_)?depend(?:\s[^>]*)?>\s*([\w.-]+)\s*<")


def needs_of(orders: Iterable[Order], environ: Mapping[str, str]) -> Needs:
    """What a host needs for these processes."""
    packages: dict[str, None] = {}
    executables: dict[tuple[str, str], None] = {}
    orders = tuple(orders)
    for order in orders:
        executables.update({(one.package, one.name): None for one in order.executables})
        names = [one.package for one in order.executables]
        names += [one.package for one in order.shared_files]
        packages.update(dict.fromkeys(names))
    interfaces = {name for package in packages for name in _interfaces(package, environ)}
    return Needs(
        packages=tuple(packages),
        executables=tuple(executables),
        interfaces=tuple(sorted(interfaces)),
        processes=len(orders),
    )


def _interfaces(package: str, environ: Mapping[str, str]) -> list[str]:
    """The message packages that a package depends on, by its manifest."""
    try:
        manifest = Path(share_directory(package, environ), "package.xml")
        text = text_file.read(manifest, errors="replace")
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
