"""Files in which a robot differs from the tree that all robots share."""

from __future__ import annotations

import os
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

from tests.support.hosts.computer import python_path
from tests.support.hosts.keys import allow_login, make_key
from tests.support.hosts.tree import USER, USER_ID
from tests.support.repository import REPOSITORY

_SSHD = "PermitRootLogin prohibit-password\nPasswordAuthentication no\nUseDNS no\nPrintMotd no\n"


def write_files(root: Path, name: str, public_key: str) -> str:
    """Write them into a layer above the tree; returns the public key of the host."""
    etc = root / "etc"
    for folder in ("ssh/sshd_config.d", "systemd/system.conf.d", "systemd/user.conf.d"):
        (etc / folder).mkdir(parents=True)
    (etc / "hostname").write_text(f"{name}\n")
    (etc / "hosts").write_text(f"127.0.0.1 localhost\n127.0.1.1 {name}\n")
    (etc / "machine-id").write_text(f"{uuid.uuid4().hex}\n")
    _set_variables(etc)
    _write_homes(root, public_key)
    return make_key(etc / "ssh/ssh_host_ed25519_key")


def shared_folders() -> list[Path]:
    """What a robot has of the machine: the environment of the tests with its Python, the checkout.

    The Python of the distribution is in the tree.
    """
    wanted = {Path(path).resolve() for path in (sys.prefix, sys.base_prefix, REPOSITORY)}
    wanted.discard(Path("/usr"))
    return sorted(path for path in wanted if not wanted & set(path.parents))


def _set_variables(etc: Path) -> None:
    """For the sessions of sshd, and for services of the system and of the user."""
    pairs = [f'{name}="{value}"' for name, value in python_path().items()]
    sshd = f"SetEnv {' '.join(pairs)}\n" if pairs else ""
    (etc / "ssh/sshd_config.d/lab.conf").write_text(f"{_SSHD}{sshd}")
    manager = f"[Manager]\nDefaultEnvironment={' '.join(pairs)}\n"
    for kind in ("system", "user"):
        (etc / f"systemd/{kind}.conf.d/lab.conf").write_text(manager)


def _write_homes(root: Path, public_key: str) -> None:
    """The user may pass through root's home: Python and checkout may lie there on the machine."""
    allow_login(root / "root", public_key)
    home = root / "home" / USER
    allow_login(home, public_key)
    for path in _all_in(home):
        os.chown(path, USER_ID, USER_ID)


def _all_in(folder: Path) -> Iterator[Path]:
    yield folder
    yield from folder.rglob("*")
