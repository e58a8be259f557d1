"""Collector: looks at the machine for the doctor. It changes nothing."""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path

import launcher
from launcher.doctor.facts import Facts, Leftover, Prefix, Space, Unreachable
from launcher.engine import shared_memory
from launcher.engine.run_id import PROC, abandoned_runs
from launcher.engine.runfolder import log_root

MARKERS = Path("share/ament_index/resource_index/packages")
# If another prefix has one of these, it is another ROS, and not a workspace on top of ours.
CORE_PACKAGES = ("rcl", "rcl_interfaces", "rclpy", "rmw_implementation", "std_msgs")
LOST_LOCK = re.compile(rf"{shared_memory.FOLDER}/fast(rtps|dds)_\w+_[es]l \(deleted\)")
COMMAND_CHARACTERS = 60
PROBE_TIMEOUT_S = 60.0

# In a process of its own: rclpy brings threads and signal handlers, and may even crash. Asking
# for the name of the middleware loads it.
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
MODULES = ("rclpy", "std_msgs.msg", "psutil", "yaml", "rich")


def collect(env: Mapping[str, str]) -> Facts:
    """All facts, with `env` as the environment that a run would get; about a second."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    logs = log_root(env)
    return Facts(
        stale=tuple(shared_memory.stale()),
        leftovers=leftovers(),
        unreachable=unreachable(),
        shared_memory=space(shared_memory.FOLDER),
        import_errors=import_errors(env),
        prefixes=prefixes(env.get("AMENT_PREFIX_PATH", ""), sys.prefix),
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
    )


def leftovers(*, proc: Path = PROC) -> tuple[Leftover, ...]:
    """The processes of dead runs."""
    runs = abandoned_runs(proc=proc)
    return tuple(
        Leftover(run_id, pid, _command(pid, proc))
        for run_id in sorted(runs)
        for pid in runs[run_id]
    )


def unreachable(*, proc: Path = PROC) -> tuple[Unreachable, ...]:
    """The processes, as far as we may look at them, that hold a lock file which is removed.

    Fast DDS keeps the lock files of a participant's own segment and ports open as long as it
    lives, and those of others only for a moment.
    """
    pids = sorted(int(entry) for entry in os.listdir(proc) if entry.isdigit())
    return tuple(Unreachable(pid, _command(pid, proc)) for pid in pids if _lost_lock(pid, proc))


def _lost_lock(pid: int, proc: Path) -> bool:
    folder = proc / str(pid) / "fd"
    try:
        return any(LOST_LOCK.fullmatch(os.readlink(folder / fd)) for fd in os.listdir(folder))
    except OSError:
        return False  # it has just ended, or is somebody else's


def space(folder: Path) -> Space | None:
    """How large the file system of `folder` is; None without such a folder."""
    try:
        status = os.statvfs(folder)
    except OSError:
        return None
    return Space(
        total_bytes=status.f_blocks * status.f_frsize, free_bytes=status.f_bavail * status.f_frsize
    )


def import_errors(env: Mapping[str, str]) -> dict[str, str]:
    """Module -> first line of its error, for what an interpreter like ours cannot import."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", PROBE, *MODULES],
            env=dict(env),
            capture_output=True,
            text=True,
            timeout=PROBE_TIMEOUT_S,
            check=True,
        )
        errors: dict[str, str] = json.loads(probe.stdout)
    except subprocess.TimeoutExpired:
        return {"rclpy": f"not imported within {PROBE_TIMEOUT_S:.0f} s"}
    except subprocess.CalledProcessError as error:
        last = (error.stderr.strip().splitlines() or ["no message"])[-1]
        return {"rclpy": f"the interpreter died with {error.returncode}: {last}"}
    return errors


def prefixes(text: str, wheels_prefix: str) -> tuple[Prefix, ...]:
    """The entries of AMENT_PREFIX_PATH; those behind the wheels' prefix hide nothing."""
    ours = _packages(Path(wheels_prefix))
    found = []
    may_hide = True
    for path in _split(text):
        may_hide = may_hide and path != wheels_prefix
        hides = ours & _packages(Path(path)) if may_hide else set()
        found.append(Prefix(path, Path(path).is_dir(), tuple(sorted(hides))))
    return tuple(found)


def installed_version() -> str | None:
    """The version that pip or colcon installed; a source tree that lies around does not count."""
    for distribution in metadata.distributions():
        points = distribution.entry_points.select(group="pytest11", name="launcher")
        if points and distribution.read_text("RECORD") is not None:
            return distribution.version
    return None


def obstacle(folder: Path, *, may_write: Callable[[Path, int], bool] = os.access) -> str | None:
    """Why nothing could be written in `folder`, which need not exist yet; None if it could."""
    existing = folder
    while not os.path.lexists(existing) and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        return f"{existing} is no folder"
    if not may_write(existing, os.W_OK | os.X_OK):
        return f"no right to write in {existing}"
    return None


def _packages(prefix: Path) -> set[str]:
    return {name for name in CORE_PACKAGES if (prefix / MARKERS / name).is_file()}


def _split(text: str) -> tuple[str, ...]:
    return tuple(part for part in text.split(os.pathsep) if part)


def _limit(value: int) -> int:
    return sys.maxsize if value == resource.RLIM_INFINITY else value


def _command(pid: int, proc: Path) -> str:
    try:
        words = (proc / str(pid) / "cmdline").read_bytes().rstrip(b"\0").split(b"\0")
    except OSError:
        return "?"
    text = " ".join(b" ".join(words).decode(errors="replace").split())
    return text if len(text) <= COMMAND_CHARACTERS else f"{text[:COMMAND_CHARACTERS]}..."
