"""Another folder for logs, where nothing can be written to the one that ROS names.

A node ends at once if it cannot make the file of its logs.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from pathlib import Path

from launcher.posix import socket_directory

VARIABLE = "ROS_LOG_DIR"
# The last resort: it is small, but some containers have nothing else.
_SHARED_MEMORY = "/dev/shm"


def _print(text: str) -> None:
    print(f"warning: {text}", file=sys.stderr)


def provide(
    env: MutableMapping[str, str], named: str, warn: Callable[[str], object] = _print
) -> None:
    """If nothing can be written to the folder `named`, have ROS_LOG_DIR name another.

    That is for us and all that we start. `named` begins with `~` if there is no home folder.
    """
    folder, why = usable(env, named)
    if why:
        then = f"logs go to {folder}; {VARIABLE} chooses another"
        none = f"no ROS node can start; set {VARIABLE} to another"
        warn(f"cannot write to the log folder {named} ({why}): {then if folder else none}")
    if folder and (why or not env.get("HOME")):  # which rcl needs for `~`; Python has other sources
        env[VARIABLE] = folder


def usable(env: Mapping[str, str], named: str) -> tuple[str, str]:
    """(a folder that can be written, or nothing; why that is not `named`)."""
    is_homeless = named.startswith("~")
    why = "there is no home folder" if is_homeless else obstacle(os.path.abspath(named))
    if not why:
        return os.path.abspath(named), ""
    return next((one for one in _others(env) if not obstacle(one)), ""), why


def obstacle(folder: str) -> str:
    """Why nothing can be made in it, or it itself cannot be; nothing is left."""
    there = folder
    while not os.path.lexists(there):
        there = os.path.dirname(there)
    probe = os.path.join(there, f".probe-{os.getpid()}")
    try:
        os.mkdir(probe, 0o700)
        os.rmdir(probe)
    except OSError as error:
        return str(error.strerror)
    return ""


def places(env: Mapping[str, str]) -> list[Path]:
    """The private folders of this user in which others may be, in order."""
    parents = [env.get(name, "") for name in ("XDG_STATE_HOME", "TMPDIR", "XDG_RUNTIME_DIR")]
    parents[2:2] = ["/tmp"]
    name = f"{socket_directory.NAME}-{os.getuid()}"
    return [Path(one, name) for one in filter(os.path.isabs, [*parents, _SHARED_MEMORY])]


def _others(env: Mapping[str, str]) -> Iterator[str]:
    """Folders in private ones of this user: in /tmp, another one could have made them."""
    for place in places(env):
        try:
            os.makedirs(place, 0o700, exist_ok=True)
            if socket_directory.problem_of(place, os.getuid()) is None:
                yield str(place / "log")
        except OSError:
            continue
