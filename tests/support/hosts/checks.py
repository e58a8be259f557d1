"""What several tests with hosts ask."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil

from tests.support.hosts import leftovers
from tests.support.hosts.cgroups import groups
from tests.support.hosts.computer import Computer
from tests.support.hosts.lab import Lab
from tests.support.hosts.remote import Remote
from tests.support.repository import REPOSITORY

_RUN_MODULE = f"""
import runpy, sys
sys.path.insert(0, {str(REPOSITORY)!r})
del sys.argv[0]
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""


def module(name: str, *words: str) -> list[str]:
    """A module of the launcher or of the tests, which no environment has installed."""
    return [sys.executable, "-c", _RUN_MODULE, name, *words]


def login(
    lab: Lab, host: Remote, *words: str, user: str = "root", patience_s: int = 50
) -> subprocess.CompletedProcess[str]:
    """An ssh session of the operator, whatever comes of it."""
    command = lab.ssh(host, *words, user=user)
    patience = ("-o", f"ConnectTimeout={patience_s}")
    return lab.operator.run([*command[:1], *patience, *command[1:]], check=False)


def is_reached(lab: Lab, host: Remote) -> bool:
    """Whether it answers within two seconds; to be repeated, or for hosts that cannot."""
    return login(lab, host, "true", patience_s=2).returncode == 0


def answers(lab: Lab, host: Remote) -> bool:
    """The same, however long it takes."""
    return login(lab, host, "true").returncode == 0


def heard(speaker: Computer, hearer: Computer, **env: str) -> int:
    """The first number that a node on one host receives from a node on another."""
    speak = module("tests.support.number_publisher", "numbers", "1000000", "100")
    hear = module("tests.support.hosts.first_number", "numbers")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL}
    with speaker.popen(speak, cwd=REPOSITORY, env=env, **pipes) as node:
        try:
            return int(hearer.run(hear, cwd=REPOSITORY, env=env).stdout)
        finally:
            node.kill()


def traces(lab: str) -> list[str]:
    """What there is of a lab on the machine: mounts, names, folders, groups, processes."""
    found = Path("/proc/mounts").read_text(encoding="utf-8").split()
    found += [path.name for path in Path("/run/netns").iterdir()]
    found += [path.name for path in (*leftovers.STATE.iterdir(), *groups("lab-*"))]
    found += [" ".join(one.info["cmdline"] or ()) for one in psutil.process_iter(["cmdline"])]
    return [text for text in found if lab in text]


# Its argument is the method of Lab that makes a host.
_RUN = """
import sys, time
from tests.support.hosts import Lab
with Lab() as lab:
    getattr(lab, sys.argv[1])("one").popen(["sleep", "infinity"], start_new_session=True)
    lab.operator.popen(["sleep", "infinity"], start_new_session=True)
    print(lab.name, flush=True)
    time.sleep(600)
"""


@contextlib.contextmanager
def killed_run(kind: str) -> Iterator[tuple[str, list[str]]]:
    """A lab with a host (`host` or `robot`), whose process was killed: its name, its traces."""
    command = [sys.executable, "-c", _RUN, kind]
    with subprocess.Popen(command, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        name = run.stdout.readline().strip()
        with leftovers.undisturbed():
            run.kill()
            run.wait()
            left = traces(name)
    try:
        yield name, left
    finally:
        leftovers.remove(name)
