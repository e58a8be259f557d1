"""`python -m launcher.hosts.discovery_server INDEX LISTEN PORT`: become Fast DDS's server.

A separate program that starts it, since it runs on other hosts, too: the server is in the
environment of the interpreter or in that of a ROS installation, and it does not find its libraries
by itself.
"""

from __future__ import annotations

import glob
import os
import shutil
import sys
from collections.abc import Iterator, Mapping

from launcher.packages.distribution import has_fast_dds_3
from launcher.posix.dispositions import for_exec

PROGRAM = "fast-discovery-server"
# Room for what many nodes send at once. The program does not read the default profiles of users.
PROFILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "discovery_server.xml")
_MISSING = 127  # as a shell says


def wheel() -> str:
    """The wheel that has the program."""
    return "ros-fastdds" if has_fast_dds_3() else "ros-fastrtps"


def main(words: list[str]) -> None:
    index, listen, port = words
    binary = find(os.environ, sys.prefix)
    if binary is None:
        print(
            f"{PROGRAM} is neither in {sys.prefix}/bin nor in PATH; it comes with "
            f"`pip install {wheel()}`, and with ROS 2 (`setup` of a host sources it)",
            file=sys.stderr,
        )
        raise SystemExit(_MISSING)
    words = ["-i", index, "-l", listen, "-p", port]
    with for_exec():
        command = [binary, *_front(binary), "-x", PROFILE, *words]
        os.execve(binary, command, environment(os.environ, binary))


def _front(binary: str) -> list[str]:
    """Fast DDS 3, whose library has another name, wants the number of a command: this is a server.

    It prints `Invalid command index` otherwise; `fastdds discovery` is a script that gives it.
    """
    libraries = (path for folder in _libraries(binary) for path in glob.glob(f"{folder}/*.so*"))
    is_3 = any(os.path.basename(path).startswith("libfastdds.so") for path in libraries)
    return ["42"] if is_3 else []


def _libraries(binary: str) -> list[str]:
    prefix = os.path.dirname(os.path.dirname(os.path.realpath(binary)))
    return [f"{prefix}/lib", *sorted(glob.glob(f"{prefix}/lib/*-linux-gnu"))]


def find(env: Mapping[str, str], prefix: str) -> str | None:
    """The server of the interpreter's environment, of a sourced ROS, or of an installed one."""
    for folder in _folders(env, prefix):
        found = shutil.which(PROGRAM, path=folder)
        if found is not None:
            return found
    return None


def _folders(env: Mapping[str, str], prefix: str) -> Iterator[str]:
    yield f"{prefix}/bin"
    yield from filter(None, env.get("PATH", "").split(os.pathsep))
    yield from (f"{path}/bin" for path in env.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    yield from sorted(glob.glob("/opt/ros/*/bin"), reverse=True)


def environment(env: Mapping[str, str], binary: str) -> dict[str, str]:
    """With the libraries beside the binary: those of ROS, and those that the wheels bring."""
    folders = _libraries(binary)
    folders += sorted(glob.glob(f"{folders[0]}/python3*/site-packages/ros_*.libs"))
    known = [one for one in env.get("LD_LIBRARY_PATH", "").split(os.pathsep) if one]
    path = os.pathsep.join(dict.fromkeys([*folders, *known]))
    # It would take the other servers for its own.
    own = {name: value for name, value in env.items() if name != "ROS_DISCOVERY_SERVER"}
    # A killed server leaves no shared memory, on whose locks later nodes might wait.
    return {**own, "LD_LIBRARY_PATH": path, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}


if __name__ == "__main__":
    main(sys.argv[1:])
