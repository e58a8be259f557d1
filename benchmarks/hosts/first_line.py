"""One robot on a second host: from the command to its first line."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Iterator
from functools import partial

from benchmarks.harness import Row, interleaved, median, milliseconds
from benchmarks.hosts.bench import AGENT, LOCAL, Bench, Job, bench
from benchmarks.hosts.screen import Screen
from tests.support.hosts import Host

# Messages of the middleware begin right after the start of the node.
_ROBOT = (
    "Node(package='group_gp1', executable='robot_1', name='robot_1', output='screen', "
    "arguments=['--ros-args', '--log-level', 'debug'])"
)
_LIMITS_S = {"warm": 0.5, "cold": 1.5}


def first_line(runs: int) -> list[Row]:
    """The difference to the same robot here, with a connection that exists and without one."""
    with bench() as one:
        host = one.lab.host("bot1")
        file = one.launch_file([_ROBOT])
        hosts = one.everything_on(host, engine="ssh")
        local, remote = Job(file), Job(file, hosts)
        measures = {
            LOCAL: partial(_first_line_s, one, local),
            "cold": partial(_first_line_s, one, remote),
            "warm": partial(_warm_s, one, host, remote),
        }
        found = interleaved(runs, measures)
    return [_row(found, name) for name in ("warm", "cold")]


def _row(found: dict[str, list[float]], name: str) -> Row:
    differences = [ours - local for ours, local in zip(found[name], found[LOCAL], strict=True)]
    detail = f"{AGENT} {milliseconds(found[name])}, local {milliseconds(found[LOCAL])}"
    what = f"a robot on a host, {name} ssh: first line, against local"
    return Row(what, median(differences), "s", _LIMITS_S[name], detail)


def _first_line_s(one: Bench, job: Job) -> float:
    begun = time.monotonic()
    with one.running(job, subprocess.PIPE) as run:
        return Screen(run).await_lines(r"^\[robot_1-1\] ")[0].when_s - begun


def _warm_s(one: Bench, host: Host, job: Job) -> float:
    with _user_master(one, host):
        return _first_line_s(one, job)


@contextlib.contextmanager
def _user_master(one: Bench, host: Host) -> Iterator[None]:
    """A connection of the user's own, as by ControlMaster in ~/.ssh/config."""
    folder = one.lab.operator.home / ".ssh"
    folder.mkdir(mode=0o700, exist_ok=True)
    config = folder / "config"
    config.write_text(f"Host *\n  ControlPath {one.path('.ssh')}\n")
    words = one.lab.ssh(host, "echo ready; exec cat")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with one.operator([words[0], "-o", "ControlMaster=yes", *words[1:]], **pipes) as master:
        try:
            assert master.stdout is not None
            assert master.stdout.readline() == b"ready\n"
            yield
        finally:
            config.unlink()
            master.kill()
