"""The checks: pure functions from facts to one finding each."""

from __future__ import annotations

import re
from collections.abc import Callable

from launcher.doctor.facts import Facts, Finding, Level
from launcher.text import count

MB = 1024**2
NODE_SHM_BYTES = 700_000  # of an rclpy node: a segment and two ports
SMALL_SHM_BYTES = 64 * MB  # the default in docker
FULL_SHM_BYTES = 8 * MB  # a dozen nodes; with less the next fleet falls back to UDP
MIN_OPEN_FILES = 1024  # for 200 processes; the usual default
HIGHEST_DOMAIN = 232
EPHEMERAL_DOMAINS = range(102, 215)  # their ports are in the ephemeral range of Linux
FIX = "python -m launcher doctor --fix"
DISTRIBUTIONS = {  # of modules with another name
    "rclpy": '"ros-jazzy-rclpy[fastrtps]"',
    "std_msgs.msg": "ros-jazzy-common-interfaces",
    "yaml": "pyyaml",
}


def check_all(facts: Facts) -> list[Finding]:
    return [check(facts) for check in CHECKS]


def stale_shared_memory(facts: Facts) -> Finding:
    name = "stale shared memory"
    if not facts.stale:
        return Finding(name, Level.OK, "killed nodes have left nothing in /dev/shm")
    ports = sum(item.is_port for item in facts.stale)
    segments = len(facts.stale) - ports
    size = sum(item.size_bytes for item in facts.stale) / MB
    # Fast DDS reuses ports, but not segments.
    return Finding(
        name,
        Level.PROBLEM if segments else Level.NOTE,
        f"killed nodes have left {count(segments, 'segment')} and {count(ports, 'port')}: "
        f"{size:.1f} MiB",
        f"{FIX} frees them",
        fixable=True,
    )


def unreachable_nodes(facts: Facts) -> Finding:
    """Running nodes whose shared memory was removed: new nodes discover them, but get no data."""
    name = "unreachable nodes"
    if not facts.unreachable:
        return Finding(name, Level.OK, "no running node has lost its files in /dev/shm")
    listed = ", ".join(f"{process.command} [{process.pid}]" for process in facts.unreachable)
    return Finding(
        name,
        Level.PROBLEM,
        f"their files in /dev/shm were removed while they run: {listed}. New nodes discover "
        "them, but receive nothing from them",
        "restart them; never remove files from /dev/shm by hand",
    )


def leftover_processes(facts: Facts) -> Finding:
    name = "leftover processes"
    if not facts.leftovers:
        return Finding(name, Level.OK, "no process has outlived its launcher")
    runs = {leftover.run_id for leftover in facts.leftovers}
    listed = ", ".join(f"{leftover.command} [{leftover.pid}]" for leftover in facts.leftovers)
    return Finding(
        name,
        Level.PROBLEM,
        f"left over from {count(len(runs), 'dead run')}: {listed}",
        f"{FIX} stops them: SIGINT, then SIGTERM, then SIGKILL",
        fixable=True,
    )


def shared_memory_space(facts: Facts) -> Finding:
    name, space = "/dev/shm", facts.shared_memory
    if space is None:
        text = "there is no /dev/shm: nodes talk over UDP only, and slower"
        return Finding(name, Level.NOTE, text, "mount a tmpfs there")
    total, free = space.total_bytes / MB, space.free_bytes / MB
    if space.free_bytes < FULL_SHM_BYTES:
        return Finding(
            name,
            Level.PROBLEM,
            f"{free:.1f} of {total:.0f} MiB are free: new nodes print RTPS_TRANSPORT_SHM errors "
            "and fall back to UDP",
            f"{FIX} frees what is stale; in docker, give more with --shm-size=512m",
        )
    nodes = space.free_bytes // NODE_SHM_BYTES
    if space.total_bytes <= SMALL_SHM_BYTES:
        text = f"only {total:.0f} MiB: room for about {nodes} more nodes"
        return Finding(name, Level.NOTE, text, "in docker, give more with --shm-size=512m")
    return Finding(name, Level.OK, f"{free:.0f} of {total:.0f} MiB are free")


def wheels(facts: Facts) -> Finding:
    name, errors = "wheels", facts.import_errors
    if not errors:
        return Finding(
            name, Level.OK, "rclpy, its middleware and the common messages are installed"
        )
    text = "; ".join(f"{module}: {error}" for module, error in sorted(errors.items()))
    if library_path(facts).level is Level.PROBLEM:
        advice = "see 'library path' below"
    else:
        advice = " ".join(["pip install", *(DISTRIBUTIONS.get(m, m) for m in sorted(errors))])
    return Finding(name, Level.PROBLEM, f"cannot be imported: {text}", advice)


def library_path(facts: Facts) -> Finding:
    """The libraries of the wheels, for which the interpreter executes itself again once."""
    name = "library path"
    if not facts.is_bootstrapped or f"{facts.python_prefix}/lib" in facts.library_path:
        return Finding(name, Level.OK, "the libraries of the wheels can be found")
    state = "names another environment" if facts.library_path else "is gone"
    return Finding(
        name,
        Level.PROBLEM,
        f"_ROS_WHEELS_BOOTSTRAP_COMPLETE is set, but LD_LIBRARY_PATH {state} (sudo, su and some "
        "IDEs drop it): imports fail with 'cannot open shared object file'",
        "start with: env -u _ROS_WHEELS_BOOTSTRAP_COMPLETE -u LD_LIBRARY_PATH python ...",
    )


def ament_prefix_path(facts: Facts) -> Finding:
    """Entries that do not exist, or that come before the wheels and have the same packages."""
    name = "AMENT_PREFIX_PATH"
    missing = [prefix.path for prefix in facts.prefixes if not prefix.exists]
    hiding = [prefix for prefix in facts.prefixes if prefix.hides]
    texts = [f"{path} does not exist" for path in missing]
    texts += [f"{p.path} hides the wheels' {', '.join(p.hides)}" for p in hiding]
    if hiding:
        advice = "start from a shell where no other ROS was sourced"
        return Finding(name, Level.PROBLEM, "; ".join(texts), advice)
    if missing:
        advice = "remove it from AMENT_PREFIX_PATH, or build that workspace"
        return Finding(name, Level.PROBLEM, "; ".join(texts), advice)
    return Finding(name, Level.OK, "every entry exists, and none hides the wheels")


def launcher_version(facts: Facts) -> Finding:
    name, installed = "launcher", facts.installed_version
    running = f"{facts.version} from {facts.folder}"
    if installed is None or installed == facts.version:
        return Finding(name, Level.OK, running)
    is_older = _numbers(facts.version) < _numbers(installed)
    return Finding(
        name,
        Level.PROBLEM if is_older else Level.NOTE,
        f"{running} runs, but {installed} is installed",
        "start it from another folder, or update this one"
        if is_older
        else "install again: pip install --no-deps --editable .",
    )


def domain_id(facts: Facts) -> Finding:
    """ROS_DOMAIN_ID, which ROS rejects only when a node starts."""
    name, text = "ROS_DOMAIN_ID", facts.domain_id or "0"
    if not re.fullmatch(r"[0-9]+", text) or int(text) > HIGHEST_DOMAIN:
        return Finding(
            name,
            Level.PROBLEM,
            f"'{text}' is not a domain id: no node can start",
            f"a number from 0 to {HIGHEST_DOMAIN}, best one up to {EPHEMERAL_DOMAINS.start - 1}",
        )
    if int(text) in EPHEMERAL_DOMAINS:
        return Finding(
            name,
            Level.NOTE,
            f"the UDP ports of domain {text} are in the range that Linux gives to any program",
            f"use an id up to {EPHEMERAL_DOMAINS.start - 1}",
        )
    return Finding(name, Level.OK, text if facts.domain_id else "not set: domain 0")


def log_folder(facts: Facts) -> Finding:
    name = "log folder"
    if facts.log_obstacle is None:
        return Finding(name, Level.OK, facts.log_folder)
    return Finding(
        name,
        Level.PROBLEM,
        f"{facts.log_folder} cannot be written to: {facts.log_obstacle}",
        "set ROS_LOG_DIR to a writable folder",
    )


def open_files(facts: Facts) -> Finding:
    """The limit on open files, and so on the processes of one launcher."""
    name, soft, hard = "open files", facts.open_files, facts.open_files_hard
    if soft >= MIN_OPEN_FILES:
        return Finding(name, Level.OK, f"{soft} are allowed")
    if hard >= MIN_OPEN_FILES:
        advice = f"ulimit -n {hard}"
    else:
        advice = "raise the hard limit: nofile in /etc/security/limits.conf, or docker --ulimit"
    return Finding(name, Level.PROBLEM, f"only {soft} are allowed per process", advice)


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", version))


CHECKS: tuple[Callable[[Facts], Finding], ...] = (
    wheels,
    library_path,
    ament_prefix_path,
    launcher_version,
    domain_id,
    log_folder,
    open_files,
    shared_memory_space,
    stale_shared_memory,
    unreachable_nodes,
    leftover_processes,
)
