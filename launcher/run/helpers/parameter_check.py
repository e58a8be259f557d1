"""Starts `launcher.ros.helpers.parameter_check`, which compares parameters with declared ones.

Some time after the start of nodes that have parameters, so that it delays none of them. It ends by
itself, and is killed with the run, before leftovers are looked for; shared memory that it may have
is freed as that of nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, full_node_name, ros_options
from launcher.posix.reactor import Reactor
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end, without_shared_memory
from launcher.run.helpers.programs import PARAMETER_CHECK
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

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
        self._helpers: list[JsonLinesProcess] = []

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
        try:
            helper = JsonLinesProcess(
                self._reactor,
                PARAMETER_CHECK,
                without_shared_memory(own_end(env)),
                on_message=self._warn,
                on_end=lambda code, line: self._helpers.remove(helper),
            )
        except OSError:
            return  # there is no warning, and nothing else is missing
        self._helpers.append(helper)
        helper.send({"nodes": nodes})

    def leave(self) -> None:
        """Let the helpers end; call it when the run begins to stop."""
        for helper in self._helpers:
            helper.close_input()

    def close(self) -> None:
        for helper in self._helpers:
            helper.close()
        self._helpers.clear()


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
