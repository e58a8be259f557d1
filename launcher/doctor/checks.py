"""The checks of `doctor`: each is a function from facts to one finding."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from launcher.base.model.level import Level
from launcher.base.program import program
from launcher.base.text import count
from launcher.doctor.doctor_facts import DoctorFacts, Finding, Leftover, Unreachable
from launcher.doctor.network_checks import check_network
from launcher.doctor.settings_checks import check_settings
from launcher.doctor.workspace_checks import check_workspace
from launcher.packages.byte_code import VARIABLE

MB = 1024**2
NODE_SHM_BYTES = 700_000  # of an rclpy node: a segment and two ports
SMALL_SHM_BYTES = 64 * MB  # the default in docker
LARGE_LOGS_BYTES = 1024 * MB
FULL_SHM_BYTES = 8 * MB  # a dozen nodes; with less the next fleet falls back to UDP
MIN_OPEN_FILES = 1024  # for 200 processes; the usual default
HIGHEST_DOMAIN = 232
EPHEMERAL_DOMAINS = range(102, 215)  # their ports are in the ephemeral range of Linux
FIX = f"{program()} doctor --fix"
OF_ROS = ("rclpy", "std_msgs.msg")  # modules of the wheels of ROS
DISTRIBUTIONS = {"yaml": "pyyaml"}  # of modules with another name

Verdict = tuple[Level, str, str | None, bool]  # as in Finding, without its name
Check = Callable[[DoctorFacts], Verdict]
CHECKS: dict[str, Check] = {}  # by name, in the order in which they are shown


def check_all(facts: DoctorFacts) -> list[Finding]:
    findings = [Finding(name, *check(facts)) for name, check in CHECKS.items()]
    if facts.settings is not None:
        findings += check_settings(facts.settings)
    if facts.network is not None:
        findings += check_network(facts.network)
    return findings if facts.workspace is None else [*findings, *check_workspace(facts.workspace)]


def _check(name: str) -> Callable[[Check], Check]:
    return lambda check: CHECKS.setdefault(name, check)


def _ok(text: str) -> Verdict:
    return Level.OK, text, None, False


def _note(text: str, advice: str, *, is_fixable: bool = False) -> Verdict:
    return Level.NOTE, text, advice, is_fixable


def _problem(text: str, advice: str, *, is_fixable: bool = False) -> Verdict:
    return Level.PROBLEM, text, advice, is_fixable


@_check("ROS 2")
def ros_in_use(facts: DoctorFacts) -> Verdict:
    """Which one it is; its packages and Python's modules may be of different ones."""
    if facts.ros is None:
        return _problem("none is found", facts.ros_remedy)
    if facts.ros_misfit is not None:
        return _problem(facts.ros_misfit, facts.ros_remedy)
    if facts.ros_conflict is None:
        return _ok(facts.ros)
    return _problem(facts.ros_conflict, "start from a shell where only one ROS 2 was sourced")


@_check("wheels")
def wheels(facts: DoctorFacts) -> Verdict:
    errors = facts.import_errors
    if not errors:
        return _ok("rclpy, its middleware and the common messages are installed")
    text = "; ".join(f"{module}: {error}" for module, error in sorted(errors.items()))
    if library_path(facts)[0] is Level.PROBLEM:
        advice = "see 'library path' below"
    elif facts.settings is not None and facts.settings.refusal is not None:
        advice = "see 'environment' below"
    else:
        others = [DISTRIBUTIONS.get(m, m) for m in sorted(errors) if m not in OF_ROS]
        steps = [" ".join(["pip install", *others])] if others else []
        if any(module in errors for module in OF_ROS):
            is_above = facts.ros is None or facts.ros_misfit is not None
            steps.append("see 'ROS 2' above" if is_above else facts.ros_remedy)
        advice = "; ".join(steps)
    return _problem(f"cannot be imported: {text}", advice)


@_check("library path")
def library_path(facts: DoctorFacts) -> Verdict:
    """The libraries of the wheels, for which the interpreter re-executes itself once."""
    if not facts.is_bootstrapped or f"{facts.python_prefix}/lib" in facts.library_path:
        found = "the libraries of the wheels can be found"
        return _ok(found if facts.has_wheels else "no wheels are in use, which would need it")
    state = "names another environment" if facts.library_path else "is gone"
    return _problem(
        f"_ROS_WHEELS_BOOTSTRAP_COMPLETE is set, but LD_LIBRARY_PATH {state} (sudo, su and some "
        "IDEs drop it): imports fail with 'cannot open shared object file'",
        "start with: env -u _ROS_WHEELS_BOOTSTRAP_COMPLETE -u LD_LIBRARY_PATH python ...",
    )


@_check("AMENT_PREFIX_PATH")
def ament_prefix_path(facts: DoctorFacts) -> Verdict:
    """Entries that do not exist, or that come before the wheels and have the same packages."""
    missing = [prefix.path for prefix in facts.prefixes if not prefix.exists]
    hiding = [prefix for prefix in facts.prefixes if prefix.hides]
    texts = [f"{path} does not exist" for path in missing]
    texts += [f"{p.path} hides the wheels' {', '.join(p.hides)}" for p in hiding]
    if hiding:
        advice = "start from a shell where no other ROS was sourced"
        return _problem("; ".join(texts), advice)
    if missing:
        advice = "remove it from AMENT_PREFIX_PATH, or build that workspace"
        return _problem("; ".join(texts), advice)
    if not facts.prefixes:
        return _ok("not set")
    return _ok("every entry exists" + ", and none hides the wheels" * facts.has_wheels)


@_check("launcher")
def launcher_version(facts: DoctorFacts) -> Verdict:
    installed = facts.installed_version
    running = f"{facts.version} from {facts.folder}"
    if installed is None or installed == facts.version:
        return _ok(running)
    text = f"{running} runs, but {installed} is installed"
    if _numbers(facts.version) < _numbers(installed):
        return _problem(text, "start the launcher from another folder, or update this one")
    return _note(text, "install again: pip install --no-deps --editable .")


@_check("byte code")
def byte_code(facts: DoctorFacts) -> Verdict:
    found = facts.uncached
    if found is None:
        return _ok("that of the launcher, of rclpy and of the standard library is kept")
    unset = f"unset {VARIABLE}, or: " if found.is_by_variable else ""
    return _note(f"{found}, which takes twice as long", f"{unset}{found.command}")


@_check("ROS_DOMAIN_ID")
def domain_id(facts: DoctorFacts) -> Verdict:
    """ROS_DOMAIN_ID, which ROS rejects only when a node starts."""
    text = facts.domain_id or "0"
    if not re.fullmatch(r"[0-9]+", text) or int(text) > HIGHEST_DOMAIN:
        return _problem(
            f"'{text}' is not a domain id: no node can start",
            f"use a number from 0 to {HIGHEST_DOMAIN}, preferably to {EPHEMERAL_DOMAINS.start - 1}",
        )
    if int(text) in EPHEMERAL_DOMAINS:
        return _note(
            f"the UDP ports of domain {text} are in the range that Linux gives to any program",
            f"use an id up to {EPHEMERAL_DOMAINS.start - 1}",
        )
    return _ok(text if facts.domain_id else "not set: domain 0")


@_check("log folder")
def log_folder(facts: DoctorFacts) -> Verdict:
    if facts.log_obstacle is None:
        if not facts.kept_runs:
            return _ok(facts.log_folder)
        have = "has" if facts.kept_runs == 1 else "have"
        runs = f"{count(facts.kept_runs, 'older run')} that failed or {have} a snapshot"
        text = f"{facts.log_folder} has {runs}, {facts.kept_bytes / MB:.0f} MiB"
        if facts.kept_bytes < LARGE_LOGS_BYTES:
            return _ok(text)
        return _note(text, "delete those that are not needed")
    return _problem(
        f"{facts.log_folder} cannot be written to: {facts.log_obstacle}",
        "set ROS_LOG_DIR to a writable folder",
    )


@_check("open files")
def open_files(facts: DoctorFacts) -> Verdict:
    """The limit on open files, and so on the processes of one launcher."""
    soft, hard = facts.open_files, facts.open_files_hard
    if soft >= MIN_OPEN_FILES:
        return _ok(f"{soft} are allowed")
    if hard >= MIN_OPEN_FILES:
        advice = f"ulimit -n {hard}"
    else:
        advice = "raise the hard limit: nofile in /etc/security/limits.conf, or docker --ulimit"
    return _problem(f"only {soft} are allowed per process", advice)


@_check("/dev/shm")
def shared_memory_space(facts: DoctorFacts) -> Verdict:
    space = facts.shared_memory
    if space is None:
        text = "there is no /dev/shm: nodes talk over UDP only, and slower"
        return _note(text, "mount a tmpfs there")
    total, free = space.total_bytes / MB, space.free_bytes / MB
    if space.free_bytes < FULL_SHM_BYTES:
        return _problem(
            f"{free:.1f} of {total:.0f} MiB are free: new nodes print RTPS_TRANSPORT_SHM errors "
            "and fall back to UDP",
            f"{FIX} frees what is stale; in docker, give more with --shm-size=512m",
        )
    nodes = space.free_bytes // NODE_SHM_BYTES
    if space.total_bytes <= SMALL_SHM_BYTES:
        text = f"only {total:.0f} MiB: room for about {nodes} more nodes"
        return _note(text, "in docker, give more with --shm-size=512m")
    return _ok(f"{free:.0f} of {total:.0f} MiB are free")


@_check("stale shared memory")
def stale_shared_memory(facts: DoctorFacts) -> Verdict:
    if not facts.stale:
        return _ok("killed nodes have left nothing in /dev/shm")
    ports = sum(item.is_port for item in facts.stale)
    segments = len(facts.stale) - ports
    size = sum(item.size_bytes for item in facts.stale) / MB
    found = f"{count(segments, 'segment')} and {count(ports, 'port')}: {size:.1f} MiB"
    judge = _problem if segments else _note  # Fast DDS reuses ports, but not segments
    return judge(f"killed nodes have left {found}", f"{FIX} frees them", is_fixable=True)


@_check("unreachable nodes")
def unreachable_nodes(facts: DoctorFacts) -> Verdict:
    """Running nodes whose shared memory was removed: new nodes discover them, but get no data."""
    if not facts.unreachable:
        return _ok("no running node has lost its files in /dev/shm")
    return _problem(
        f"their files in /dev/shm were removed while they run: {_listed(facts.unreachable)}. "
        "New nodes discover them, but receive nothing from them",
        "restart them; never remove files from /dev/shm by hand",
    )


@_check("leftover processes")
def leftover_processes(facts: DoctorFacts) -> Verdict:
    if not facts.leftovers:
        return _ok("no process has outlived its launcher")
    runs = {leftover.run_id for leftover in facts.leftovers}
    return _problem(
        f"left over from {count(len(runs), 'killed run')}: {_listed(facts.leftovers)}",
        f"{FIX} stops them: SIGINT, then SIGTERM, then SIGKILL",
        is_fixable=True,
    )


@_check("stale control groups")
def stale_control_groups(facts: DoctorFacts) -> Verdict:
    if not facts.stale_groups:
        return _ok("no killed run has left its control group")
    text = f"killed runs have left {', '.join(facts.stale_groups)}"
    return _note(text, f"{FIX} removes them", is_fixable=True)


def _listed(processes: Iterable[Leftover | Unreachable]) -> str:
    return ", ".join(f"{process.command} [{process.pid}]" for process in processes)


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", version))
