"""What a host is: its Python, its C library, and what was brought before."""

from __future__ import annotations

import os
import platform
import sys

from launcher.hosts.sync.on_host import releases
from launcher.hosts.sync.on_host.store import HostStore

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def facts(workspace: HostStore) -> dict[str, Any]:
    current = workspace.current_release()
    return {
        "root": workspace.root,
        "python": sys.executable,
        "word": sys.argv[1],
        "version": list(sys.version_info[:3]),
        "is_environment": _is_environment(),
        "has_venv": _has_venv(),
        "machine": platform.machine(),
        "libc": _libc(),
        "markers": _markers(),
        "current": current,
        "id": releases.identity(workspace, current),
        "free": workspace.free_bytes(),
    }


def _is_environment() -> bool:
    above = os.path.dirname(os.path.dirname(sys.executable))
    return os.path.isfile(os.path.join(above, "pyvenv.cfg"))


def _has_venv() -> bool:
    import importlib.util

    return importlib.util.find_spec("venv") is not None


def _libc() -> list[Any]:
    """`["glibc", "2.36"]`; empty for another library."""
    try:
        text = os.confstr("CS_GNU_LIBC_VERSION") or ""
    except (ValueError, OSError):
        return []
    return text.split()[:2]


def _markers() -> dict[str, str]:
    """The variables of environment markers (PEP 508)."""
    return {
        "implementation_name": sys.implementation.name,
        "implementation_version": platform.python_version(),
        "os_name": os.name,
        "platform_machine": platform.machine(),
        "platform_python_implementation": platform.python_implementation(),
        "platform_release": platform.release(),
        "platform_system": platform.system(),
        "platform_version": platform.version(),
        "python_full_version": platform.python_version(),
        "python_version": ".".join(platform.python_version_tuple()[:2]),
        "sys_platform": sys.platform,
    }
