"""Starts `launcher.ros.helpers.parameter_check`, which compares parameters with declared ones.

Some time after the start of nodes that have parameters, so that it delays none of them. It ends by
itself, and is killed with the run, before leftovers are looked for; shared memory that it may have
is freed as that of nodes.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterable, Mapping

from launcher.base import strict_json
from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, full_node_name, ros_options
from launcher.posix import spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.reactor import Reactor
from launcher.run.helpers.popen import start_module
from launcher.run.helpers.programs import PARAMETER_CHECK
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import IO, Any

    from launcher.base.model.events import LoadComponent
    from launcher.base.model.spec import ProcessSpec


class ParameterCheck:
    """Call `check` with all processes now and then; `warn` is called with each warning.

    `env` is for components in containers that are no processes of this run.
    """

    def __init__(
        self, reactor: Reactor, env: Mapping[str, str], warn: Callable[[str], None]
    ) -> None:
        self._reactor = reactor
        self._env = env
        self._warn = warn
        self._components: list[tuple[LoadComponent, str]] = []
        self._seen: set[int] = set()
        self._helpers: list[subprocess.Popen[bytes]] = []

    def check(self, processes: Iterable[Process]) -> None:
        """Compare the nodes that have not been yet; one helper for each domain."""
        processes = list(processes)
        environments: dict[str, Mapping[str, str]] = {}
        nodes: dict[str, list[dict[str, Any]]] = {}

        def add(env: Mapping[str, str], node: dict[str, Any]) -> None:
            domain = env.get("ROS_DOMAIN_ID") or "0"
            environments.setdefault(domain, env)
            nodes.setdefault(domain, []).append(node)

        for process in processes:
            if process.child is None or process.host is not None:
                continue
            if process.process_id in self._seen:
                continue
            self._seen.add(process.process_id)
            for spec in process.spec.members or (process.spec,):
                options = {option for option, _ in ros_options(spec.argv)}
                if options & {PARAMETER, PARAMETER_FILE}:
                    add(spec.env, _node(process.child.pid, spec))
        for effect, name in self._components:
            container = f"/{effect.request.container.lstrip('/')}"
            owners = (one for one in processes if full_node_name(one.spec.argv) == container)
            owner = next(owners, None)
            add(self._env if owner is None else owner.spec.env, _component(effect, name))
        self._components.clear()
        for domain, found in nodes.items():
            self._start(environments[domain], found)

    def add_component(self, effect: LoadComponent, full_name: str) -> None:
        """A node with parameters has been loaded, which the next `check` compares."""
        self._components.append((effect, full_name))

    def _start(self, env: Mapping[str, str], nodes: list[dict[str, Any]]) -> None:
        env = dict(env)
        env.pop(RUN_ID_VARIABLE, None)
        env.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
        try:
            helper = start_module(
                [PARAMETER_CHECK],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=env,
                bufsize=0,
            )
        except OSError:
            return  # there is no warning, and nothing else is missing
        spawn.started.add(helper.pid)
        assert helper.stdin is not None and helper.stdout is not None
        self._helpers.append(helper)
        request = strict_json.packed({"nodes": nodes})
        os.set_blocking(helper.stdout.fileno(), False)
        self._reactor.add_reader(helper.stdout.fileno(), _Lines(self, helper).read)
        os.set_blocking(helper.stdin.fileno(), False)
        _RequestWriter(self._reactor, helper.stdin.fileno(), request.encode() + b"\n").write()

    def line(self, line: bytes) -> None:
        self._warn(str(strict_json.unpacked(line)))

    def ended(self, helper: subprocess.Popen[bytes]) -> None:
        """Its output has ended, or the run."""
        assert helper.stdin is not None and helper.stdout is not None
        self._helpers.remove(helper)
        self._close(helper.stdin)
        self._close(helper.stdout)
        helper.kill()  # if it hangs in its clean-up
        helper.wait()
        spawn.started.discard(helper.pid)

    def _close(self, pipe: IO[bytes]) -> None:
        if not pipe.closed:
            self._reactor.remove(pipe.fileno())
            pipe.close()

    def leave(self) -> None:
        """Let the helpers end; call it when the run begins to stop."""
        for helper in self._helpers:
            assert helper.stdin is not None
            self._close(helper.stdin)

    def close(self) -> None:
        for helper in tuple(self._helpers):
            self.ended(helper)


class _Lines:
    """Splits the output of a helper into lines."""

    def __init__(self, check: ParameterCheck, helper: subprocess.Popen[bytes]) -> None:
        self._check = check
        self._helper = helper
        self._partial = b""

    def read(self) -> None:
        assert self._helper.stdout is not None
        chunk = os.read(self._helper.stdout.fileno(), 65536)
        if not chunk:
            self._check.ended(self._helper)
            return
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            self._check.line(line)


class _RequestWriter:
    """Writes a request that may be larger than a pipe."""

    def __init__(self, reactor: Reactor, fd: int, data: bytes) -> None:
        self._reactor = reactor
        self._fd = fd
        self._data = data
        self._is_waiting = False

    def write(self) -> None:
        try:
            self._data = self._data[os.write(self._fd, self._data) :]
        except BlockingIOError:
            pass
        except BrokenPipeError:
            self._data = b""  # its output has ended, too
        if self._data and not self._is_waiting:
            self._is_waiting = True
            self._reactor.add_writer(self._fd, self.write)
        elif not self._data and self._is_waiting:
            self._reactor.remove(self._fd)


def _node(pid: int, spec: ProcessSpec) -> dict[str, Any]:
    sources = () if spec.ros is None else spec.ros.parameters
    return {
        "pid": pid,
        "argv": spec.argv,
        "place": spec.place,
        "generated": [source.file for source in sources if source.generated is not None],
    }


def _component(effect: LoadComponent, full_name: str) -> dict[str, Any]:
    parameters = [name for name, _ in effect.request.parameters]
    return {"name": full_name, "parameters": parameters, "place": effect.place}
