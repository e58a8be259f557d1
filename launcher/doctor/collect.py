"""Collects the facts about this machine, without changing anything."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import subprocess
import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

import launcher
from launcher.base import strict_json
from launcher.base.text import escape
from launcher.doctor.doctor_facts import (
    DoctorFacts,
    Leftover,
    Prefix,
    Space,
    Unreachable,
    WorkspaceFacts,
)
from launcher.doctor.network_facts import collect_network, details
from launcher.doctor.settings import collect_settings
from launcher.output.logs.old_runs import kept_beyond
from launcher.output.logs.run_directory import log_root
from launcher.packages import distribution
from launcher.packages.absent_ros import misfit, remedy
from launcher.packages.byte_code import uncached
from launcher.packages.extras import DISTRIBUTION
from launcher.posix import log_folder, proc
from launcher.posix.cleanup.run_id import abandoned_groups, abandoned_runs
from launcher.run.monitor import shared_memory

MARKERS = Path("share/ament_index/resource_index/packages")
# A prefix with one of these is another ROS, not a workspace on top of the wheels.
CORE_PACKAGES = ("rcl", "rcl_interfaces", "rclpy", "rmw_implementation", "std_msgs")
LOST_LOCK = re.compile(rf"{shared_memory.FOLDER}/fast(rtps|dds)_\w+_[es]l \(deleted\)")
COMMAND_CHARACTERS = 60
PROBE_TIMEOUT_S = 60.0

# In a separate process: rclpy brings threads and signal handlers, and may crash. The name of the
# middleware is requested because that loads it.
PROBE = """
import importlib, json, sys
errors = {}
for module in sys.argv[1:]:
    try:
        found = importlib.import_module(module)
        if module == "rclpy":
            found.get_rmw_implementation_identifier()
    except Exception as error:
        errors[module] = str(error).splitlines()[0] if str(error) else type(error).__name__
print(json.dumps(errors))
"""
MODULES = ("rclpy", "std_msgs.msg", "yaml", "rich", "psutil")


def collect(env: Mapping[str, str], workspace: WorkspaceFacts | None = None) -> DoctorFacts:
    """Collect all facts, with `env` as the environment of a run; takes about a second."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    logs = Path(log_root(env))
    kept = kept_runs(logs)
    found = distribution.find(env)
    return DoctorFacts(
        stale=tuple(shared_memory.settled()),
        leftovers=leftovers(),
        stale_groups=tuple(group.path for _, group in abandoned_groups()),
        unreachable=unreachable(),
        shared_memory=space(Path(shared_memory.FOLDER)),
        ros=distribution.title(env) if found else None,
        ros_misfit=misfit(env),
        ros_conflict=distribution.conflict(env),
        ros_remedy=remedy(environ=env),
        has_wheels=found is not None and found.is_wheels,
        import_errors=import_errors(env),
        prefixes=prefixes(env.get("AMENT_PREFIX_PATH", ""), sys.prefix, workspace),
        python_prefix=sys.prefix,
        is_bootstrapped="_ROS_WHEELS_BOOTSTRAP_COMPLETE" in env,
        library_path=_split(env.get("LD_LIBRARY_PATH", "")),
        version=launcher.__version__,
        folder=str(Path(launcher.__file__).parent),
        installed_version=installed_version(),
        domain_id=env.get("ROS_DOMAIN_ID"),
        log_folder=str(logs),
        log_obstacle=obstacle(logs),
        open_files=_limit(soft),
        open_files_hard=_limit(hard),
        workspace=workspace,
        network=collect_network(env),
        settings=collect_settings(env),
        kept_runs=len(kept),
        kept_bytes=sum(map(size_of, kept)),
        uncached=uncached(env),
    )


def leftovers() -> tuple[Leftover, ...]:
    """Processes of runs whose launcher has exited."""
    runs = abandoned_runs()
    return tuple(
        Leftover(run_id, pid, _command(pid)) for run_id in sorted(runs) for pid in runs[run_id]
    )


def unreachable() -> tuple[Unreachable, ...]:
    """Processes that hold a lock file of Fast DDS that was removed.

    A participant of Fast DDS keeps the lock files of its segment and ports open, and those of
    other participants only for a moment.
    """
    return tuple(Unreachable(pid, _command(pid)) for pid in sorted(proc.pids()) if _lost_lock(pid))


def _lost_lock(pid: int) -> bool:
    return any(LOST_LOCK.fullmatch(link) for _, link in proc.descriptors(pid))


def space(folder: Path) -> Space | None:
    """Space in the file system of `folder`; None if it does not exist."""
    try:
        status = os.statvfs(folder)
    except OSError:
        return None
    return Space(
        total_bytes=status.f_blocks * status.f_frsize, free_bytes=status.f_bavail * status.f_frsize
    )


def import_errors(env: Mapping[str, str]) -> dict[str, str]:
    """Module -> first line of its import error."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", PROBE, *MODULES],
            env=dict(env),
            capture_output=True,
            text=True,
            timeout=PROBE_TIMEOUT_S,
            check=True,
        )
        errors: dict[str, str] = strict_json.unpacked(probe.stdout)
    except subprocess.TimeoutExpired:
        return {"rclpy": f"not imported within {PROBE_TIMEOUT_S:.0f} s"}
    except subprocess.CalledProcessError as error:
        last = (error.stderr.strip().splitlines() or ["no message"])[-1]
        return {"rclpy": f"the interpreter exited with code {error.returncode}: {last}"}
    return errors


def prefixes(
    text: str, wheels_prefix: str, workspace: WorkspaceFacts | None = None
) -> tuple[Prefix, ...]:
    """Entries of AMENT_PREFIX_PATH; only those before the wheels' prefix can hide packages.

    What the workspace replaces is a separate finding.
    """
    ours = _packages(Path(wheels_prefix))
    found = []
    may_hide = True
    for path in _split(text):
        may_hide = may_hide and path != wheels_prefix
        is_own = workspace is not None and path.startswith(f"{workspace.root}/")
        hides = ours & _packages(Path(path)) if may_hide and not is_own else set()
        found.append(Prefix(path, Path(path).is_dir(), tuple(sorted(hides))))
    return tuple(found)


def installed_version() -> str | None:
    """The version installed by pip."""
    try:
        return metadata.version(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        return None


def obstacle(folder: Path) -> str | None:
    """Why `folder`, which need not exist, cannot be written to; None if it can.

    An empty folder is made there, and removed at once.
    """
    existing = folder
    while not os.path.lexists(existing) and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        return f"{existing} is not a folder"
    why = log_folder.obstacle(str(folder))  # a permission is not enough: /proc, a full disk
    return f"{existing}: {why}" if why else None


def kept_runs(logs: Path) -> list[Path]:
    """Older runs that are not deleted: they hold evidence."""
    try:
        return [Path(run) for run in kept_beyond(str(logs))]
    except OSError:
        return []


def size_of(folder: Path) -> int:
    """The bytes of all files in it, as far as they can be read."""
    found = 0
    for path, _, files in os.walk(folder):
        for name in files:
            with contextlib.suppress(OSError):
                found += os.lstat(os.path.join(path, name)).st_size
    return found


def _packages(prefix: Path) -> set[str]:
    return {name for name in CORE_PACKAGES if (prefix / MARKERS / name).is_file()}


def _split(text: str) -> tuple[str, ...]:
    return tuple(part for part in text.split(os.pathsep) if part)


def _limit(value: int) -> int:
    return sys.maxsize if value == resource.RLIM_INFINITY else value


def _command(pid: int) -> str:
    words = details(pid, "cmdline").get("cmdline") or ()
    text = escape(" ".join(" ".join(words).split()), keep="") or "?"
    return text if len(text) <= COMMAND_CHARACTERS else f"{text[:COMMAND_CHARACTERS]}..."
