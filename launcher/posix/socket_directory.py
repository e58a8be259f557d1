"""The directory of sockets, to which only one user has access."""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.base.errors import LauncherError

PATH_LIMIT = 107  # bytes of the path of a socket on Linux
NAME = "ros-launcher"
SUFFIX = ".sock"


class ControlError(LauncherError):
    """No run to connect to, or it does not answer correctly."""


def candidates(env: Mapping[str, str], uid: int) -> list[Path]:
    """Directories for sockets of this user, in the order in which a new run tries them."""
    found = []
    runtime = env.get("XDG_RUNTIME_DIR", "")
    if runtime.startswith("/") and _is_ours(Path(runtime), uid):
        found.append(Path(runtime) / NAME)
    tmpdir = env.get("TMPDIR", "")
    root = Path(tmpdir if tmpdir.startswith("/") else "/tmp")
    return [*found, root / f"{NAME}-{uid}"]


def preferred(env: Mapping[str, str], uid: int) -> Path:
    """The directory that a run started from this shell would use."""
    found = candidates(env, uid)
    longest = f".{2**22}-{'0' * 12}{SUFFIX}"
    fitting = (one for one in found if len(os.fsencode(one / longest)) <= PATH_LIMIT)
    return next(fitting, found[-1])


def _is_ours(path: Path, uid: int) -> bool:
    try:
        return path.stat().st_uid == uid and os.access(path, os.W_OK | os.X_OK)
    except OSError:
        return False


def problem_of(path: Path, uid: int) -> str | None:
    """Why this directory cannot be trusted; None if other users have no access. Raises OSError.

    A symbolic link is not followed: in /tmp another user may have made it.
    """
    found = os.lstat(path)
    if not stat.S_ISDIR(found.st_mode):
        return f"{path} is not a directory"
    if found.st_uid != uid:
        return f"{path} belongs to another user"
    if stat.S_IMODE(found.st_mode) & 0o077:
        return f"{path} is accessible to other users; fix: chmod 700"
    return None


def prepare(run_id: str, env: Mapping[str, str], uid: int, *, reserve: int = 0) -> Path:
    """Path for the socket of a run, whose directory is created; ControlError.

    It may become so many bytes longer (`reserve`).
    """
    problems = []
    for directory in candidates(env, uid):
        path = directory / f"{run_id}{SUFFIX}"
        if len(os.fsencode(temporary(path))) + reserve > PATH_LIMIT:
            problems.append(f"{directory} is too long for the path of a socket")
            continue
        try:
            if not os.path.lexists(directory):
                directory.mkdir(mode=0o700, exist_ok=True)
            problem = problem_of(directory, uid)
        except OSError as error:
            problem = f"{directory}: {error.strerror}"
        if problem is None:
            return path
        problems.append(problem)
    raise ControlError("; ".join(problems) or "no directory for a socket")


def temporary(path: Path) -> Path:
    """Where a socket is until it listens; clients remove sockets that do not listen."""
    return path.with_name(f".{path.name}")


def abandoned(directory: Path, suffix: str) -> Iterator[Path]:
    """Sockets in it to which nobody listens, since their process was killed."""
    for path in directory.glob(f"*{suffix}"):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK) as connection:
            try:
                connection.connect(str(path))
            except ConnectionRefusedError:
                yield path
            except OSError:
                continue  # removed just now, or too busy to answer


def sockets(env: Mapping[str, str], uid: int) -> list[Path]:
    """Sockets in trusted directories, the oldest run first."""
    found = []
    for directory in candidates(env, uid):
        try:
            if problem_of(directory, uid) is None:
                paths = (path for path in directory.iterdir() if path.suffix == SUFFIX)
                found += [path for path in paths if not path.name.startswith(".")]
        except OSError:
            continue  # it does not exist, or was removed just now
    return sorted(found, key=_when)


def _when(path: Path) -> tuple[float, str]:
    try:
        return path.stat().st_mtime, path.name
    except OSError:
        return 0.0, path.name
