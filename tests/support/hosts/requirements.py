"""What the tests with several hosts need of the machine; without it they are skipped."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from functools import cache

import pytest

from tests.support.hosts import clock
from tests.support.hosts.cgroups import why_no_groups
from tests.support.hosts.tool import ToolError, run_tool
from tests.support.hosts.tree import NoTreeError, tree

_HOST_PROGRAMS = ("hostname", "ip", "mount", "nsenter", "ssh", "ssh-keygen", "sshd", "unshare")
_ROBOT_PROGRAMS = ("chroot", "mmdebstrap", "systemd-nspawn")
# Makes what a host needs of the kernel, in namespaces that end with the shell.
_TRIAL = """set -e
ip link add bridge0 type bridge
ip link add end1 type veth peer end2
mount -t tmpfs tmpfs /mnt
mkdir /mnt/upper /mnt/work
mount -t overlay -o lowerdir=/etc,upperdir=/mnt/upper,workdir=/mnt/work overlay /etc
"""
_SYSTEM_FOLDERS = ("/usr/local/sbin", "/usr/sbin", "/sbin")  # not in the PATH of every user


def needs_hosts() -> None:
    """Skip the test where hosts with sshd cannot be made."""
    reason = why_no_hosts()
    if reason:
        pytest.skip(reason)


def why_no_hosts() -> str:
    """Why hosts with sshd cannot be made here; empty if they can."""
    if os.geteuid() != 0:
        return "namespaces of hosts need root"
    return _missing(_HOST_PROGRAMS) or _why_no_namespaces()


def needs_clocks() -> None:
    """Skip the test where hosts cannot have separate clocks."""
    if clock.library() is None:
        pytest.skip("not installed: faketime")


def needs_robots() -> None:
    """Skip the test where robots with systemd cannot be made."""
    reason = why_no_robots()
    if reason:
        pytest.skip(reason)


@cache
def why_no_robots() -> str:
    """Why robots cannot be made here; empty if they can. The first call makes their files."""
    reason = why_no_hosts() or _missing(_ROBOT_PROGRAMS) or why_no_groups()
    if reason:
        return reason
    try:
        tree()
    except NoTreeError as error:
        return str(error)
    return ""


def program(name: str) -> str | None:
    """The path of a program, also of one for the administrator."""
    path = os.pathsep.join((os.environ.get("PATH", os.defpath), *_SYSTEM_FOLDERS))
    return shutil.which(name, path=path)


@cache
def _why_no_namespaces() -> str:
    """Root of a container may not be allowed to make them."""
    kinds = ("--net", "--mount", "--pid", "--fork", "--propagation", "private")
    try:
        run_tool("unshare", *kinds, "sh", "-c", _TRIAL)
    except ToolError as error:
        return f"namespaces of hosts cannot be made here: {error.complaint}"
    return ""


def _missing(programs: Iterable[str]) -> str:
    missing = [name for name in programs if program(name) is None]
    return f"not installed: {', '.join(missing)}" if missing else ""
