"""A lab of hosts for benchmarks, and runs of the launcher on its operator."""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.contestant import REPOSITORY, end
from benchmarks.harness import NotHereError
from launcher.posix.domain_lease import leased_domain
from tests.support.hosts import Host, Lab, Robot
from tests.support.hosts.operator import launcher_words
from tests.support.hosts.requirements import why_no_hosts, why_no_robots

LOCAL, AGENT, JOURNAL = "local", "agent", "journal"
KEEP = {"on_link_loss": "keep"}
_HEAD = """from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
"""


class Job(NamedTuple):
    """A launch file, and the hosts file with which it runs; None: without one."""

    file: Path | str
    hosts: Path | None = None
    words: tuple[str, ...] = ()


class Bench:
    """Runs launch files on the operator of a lab, on its hosts or on the operator itself."""

    def __init__(self, lab: Lab, domain_id: int) -> None:
        self.lab = lab
        self._numbers = iter(range(1_000_000))
        self._env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}

    def path(self, suffix: str) -> Path:
        """A new name in a folder that all hosts see, but no robot."""
        return self.lab.folder / f"bench-{next(self._numbers)}{suffix}"

    def launch_file(self, actions: Iterable[str]) -> Path:
        path = self.path(".launch.py")
        lines = "".join(f"        {action},\n" for action in actions)
        path.write_text(f"{_HEAD}{lines}    ])\n", encoding="utf-8")
        return path

    def hosts_file(
        self, hosts: Mapping[Host | Robot, Mapping[str, Any]], place: Mapping[str, str]
    ) -> Path:
        return self.lab.hosts_file(self.path(".yaml"), hosts, place)

    def everything_on(self, host: Host | Robot, **settings: Any) -> Path:
        """A hosts file that places all processes on one host."""
        return self.hosts_file({host: settings}, {"**": host.name})

    def operator(self, words: Iterable[object], **options: Any) -> subprocess.Popen[bytes]:
        """A process on the operator's computer, with the ROS domain of the benchmark."""
        env = {**self._env, **options.pop("env", {})}
        options = {"text": False, "cwd": REPOSITORY, "env": env, **options}
        return self.lab.operator.popen(list(words), **options)

    @contextlib.contextmanager
    def running(self, job: Job, stdout: Any) -> Iterator[subprocess.Popen[bytes]]:
        """A run of the launcher; it and its processes have ended when the block ends."""
        hosts = () if job.hosts is None else ("--hosts", str(job.hosts))
        words = launcher_words([job.file, *job.words, *hosts])
        process = self.operator(words, stdout=stdout, stderr=subprocess.STDOUT)
        try:
            yield process
        finally:
            end(process)

    @contextlib.contextmanager
    def scratch(self) -> Iterator[Path]:
        """An empty folder that hosts see."""
        with tempfile.TemporaryDirectory(dir=self.lab.folder) as name:
            yield Path(name)

    @contextlib.contextmanager
    def programs(self, name: str, count: int) -> Iterator[Path]:
        """As `harness.programs`, in a folder that hosts see."""
        found = shutil.which(name)
        assert found is not None, name
        with self.scratch() as folder, self.scratch() as store:
            copy = shutil.copy(os.path.realpath(found), store / name)
            for number in range(count):
                os.link(copy, folder / f"{name}-{number}")
            yield folder


@contextlib.contextmanager
def bench(*, robots: bool = False) -> Iterator[Bench]:
    """NotHereError if the machine cannot have hosts, or robots if they are needed."""
    reason = why_no_robots() if robots else why_no_hosts()
    if reason:
        raise NotHereError(reason)
    with leased_domain() as domain_id, Lab() as lab:
        yield Bench(lab, domain_id)


def process(*words: object, **options: object) -> str:
    """The action of a launch file that runs a command."""
    texts = [str(word) for word in words]
    settings = "".join(f", {name}={value!r}" for name, value in options.items())
    return f"ExecuteProcess(cmd={texts!r}, output='screen'{settings})"


@functools.cache
def has_systemd_engine() -> bool:
    """Robots can be made on this machine."""
    return not why_no_robots()
