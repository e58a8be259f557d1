"""The kinds of faults: how each is made, and the rule that should explain it."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.harness import NotHereError
from benchmarks.hosts.bench import KEEP, bench
from benchmarks.watched.system import NODES, SOURCES, Surroundings, WatchedSystem
from tests.support.hosts import Host
from tests.support.own_clock import OwnClock

CLOCK_REST_S = 7.0  # a step is a fault for five seconds
DISK_BYTES = 96 * 1024**2
PERIOD_S = 0.02  # of a process that is slowed down
MORE_DOWN_S = 10.0  # of a link
# What the launcher gets of the environment; the rest is that of a login.
_OF_LAUNCHER = (
    "ROS_DOMAIN_ID",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOG_DIR",
    "XDG_RUNTIME_DIR",
)
_BURN = "while True: pass"


class Injection(NamedTuple):
    """`make(system, random)` injects a fault while it is entered, and returns with it in force.

    `rule` should explain it; `within` prepares what the system needs from its start.
    """

    rule: str
    make: Callable[[WatchedSystem, random.Random], AbstractContextManager[None]]
    within: Callable[[Path], AbstractContextManager[Surroundings]] | None = None


@contextlib.contextmanager
def kill(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    os.kill(system.pid(chance.choice(SOURCES)), signal.SIGKILL)
    yield


@contextlib.contextmanager
def hang(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    pid = system.pid(chance.choice(SOURCES))
    os.kill(pid, signal.SIGSTOP)
    yield
    os.kill(pid, signal.SIGCONT)


@contextlib.contextmanager
def slow(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    """The process has a part of the time only."""
    pid, factor = system.pid(chance.choice(SOURCES)), chance.uniform(3.0, 8.0)
    is_over = threading.Event()

    def stutter() -> None:
        while not is_over.is_set():
            os.kill(pid, signal.SIGSTOP)
            time.sleep(PERIOD_S * (1 - 1 / factor))
            os.kill(pid, signal.SIGCONT)
            time.sleep(PERIOD_S / factor)

    thread = threading.Thread(target=stutter)
    thread.start()
    yield
    is_over.set()
    thread.join()


@contextlib.contextmanager
def parameter(
    system: WatchedSystem, node: str, name: str, value: object, before: object
) -> Iterator[None]:
    system.set_parameter(node, name, value)
    yield
    system.set_parameter(node, name, before)


def half_rate(system: WatchedSystem, chance: random.Random) -> AbstractContextManager[None]:
    return parameter(system, chance.choice(SOURCES), "skip", 2, 1)


def wrong_value(system: WatchedSystem, chance: random.Random) -> AbstractContextManager[None]:
    return parameter(system, chance.choice(SOURCES), "value", chance.uniform(6.0, 99.0), 1.0)


@contextlib.contextmanager
def leak(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    node = chance.choice(SOURCES)
    system.await_settled()  # what has just been started grows
    system.set_parameter(node, "leak", chance.choice((2, 3, 4)))
    yield
    os.kill(system.pid(node), signal.SIGKILL)  # it would keep what it has


@contextlib.contextmanager
def other_qos(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    """It offers less than is requested when it is started again."""
    node = chance.choice(SOURCES)
    system.marker.touch()
    with system.run.connect() as connection:
        connection.ask("restart", [f"/{node}"])
    yield
    system.marker.unlink()
    with system.run.connect() as connection:
        connection.ask("restart", [f"/{node}"])


@contextlib.contextmanager
def full_cpu(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    count = chance.randint(8, 12) * (os.cpu_count() or 1)
    # Each in a session: the kernel may share processors among sessions first (`sched_autogroup`).
    burners = [
        subprocess.Popen([sys.executable, "-c", _BURN], start_new_session=True)
        for _ in range(count)
    ]
    try:
        yield
    finally:
        for one in burners:
            one.kill()
        for one in burners:
            one.wait()


@contextlib.contextmanager
def double_node(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    node = chance.choice(SOURCES)
    words = ["-r", f"__node:={node}", "-p", f"topic:=/{node[-1]}"]
    with system.program(sys.executable, NODES, "source", "--ros-args", *words):
        time.sleep(1.0)  # until it is a node
        yield


_clocks: dict[Path, OwnClock] = {}  # of systems, by their folders


@contextlib.contextmanager
def clock_step(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    seconds = chance.choice((-1, 1)) * chance.uniform(0.5, 30.0)
    clock = _clocks[system.folder]
    clock.set(seconds)
    yield
    time.sleep(CLOCK_REST_S)
    clock.set(0.0)
    time.sleep(CLOCK_REST_S)


@contextlib.contextmanager
def own_clock(folder: Path) -> Iterator[Surroundings]:
    """A clock of the system alone, which can be set."""
    try:
        clock = _clocks[folder] = OwnClock(folder)
    except RuntimeError as error:
        raise NotHereError(str(error)) from None
    yield Surroundings(clock.variables)
    del _clocks[folder]


@contextlib.contextmanager
def full_disk(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    filler = system.log_root / "filler"
    with filler.open("wb") as file, contextlib.suppress(OSError):
        while file.write(bytes(1024 * 1024)):
            file.flush()
    yield
    filler.unlink()


@contextlib.contextmanager
def own_disk(folder: Path) -> Iterator[Surroundings]:
    """A small file system for the log files."""
    if os.geteuid():
        raise NotHereError("only root can mount a file system")
    log = folder / "log"
    log.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES}", "tmpfs", str(log)]
    subprocess.run(words, check=True)
    try:
        yield Surroundings()
    finally:
        subprocess.run(["umount", "-l", str(log)], check=True)


_hosts: dict[Path, Host] = {}  # of systems, by their folders


@contextlib.contextmanager
def link_down(system: WatchedSystem, chance: random.Random) -> Iterator[None]:
    """No packet passes, for a while longer than it takes to find it."""
    host = _hosts[system.folder]
    host.link_down()
    yield
    time.sleep(chance.uniform(0.0, MORE_DOWN_S))
    host.link_up()


@contextlib.contextmanager
def own_host(folder: Path) -> Iterator[Surroundings]:
    """One of the publishers runs on another host, and goes on when the link to it is down."""
    with bench() as one:
        host = one.lab.host("bot")
        hosts = one.hosts_file({host: {"engine": "ssh", **KEEP}}, {SOURCES[-1]: host.name})

        def popen(words: list[str], env: dict[str, str], output: Any) -> subprocess.Popen[Any]:
            own = {name: env[name] for name in _OF_LAUNCHER if name in env}
            return one.operator(words, env=own, stdout=output, stderr=output)

        _hosts[folder] = host
        variables = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "XDG_RUNTIME_DIR": ""}
        yield Surroundings(variables, ("--hosts", str(hosts)), popen)
        del _hosts[folder]


INJECTIONS = {
    "kill": Injection("death", kill),
    "hang": Injection("suspension", hang),
    "slow": Injection("slow process", slow),
    "half rate": Injection("publisher", half_rate),
    "other QoS after a restart": Injection("QoS", other_qos),
    "full CPU": Injection("starvation", full_cpu),
    "memory leak": Injection("growth", leak),
    "wrong value": Injection("wrong value", wrong_value),
    "double node": Injection("double node", double_node),
    "clock step": Injection("clock step", clock_step, own_clock),
    "link down": Injection("lost link", link_down, own_host),
    "full disk": Injection("full disk", full_disk, own_disk),
}
