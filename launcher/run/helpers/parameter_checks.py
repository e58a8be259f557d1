"""Starts `launcher.ros.helpers.parameter_check`, which compares parameters with declared ones.

Some time after the start of nodes that have parameters, so that it delays none of them.
"""

from __future__ import annotations

from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, full_node_name, ros_options
from launcher.run.helpers.helper_programs import PARAMETER_CHECK
from launcher.run.helpers.warning_helpers import WarningHelpers

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from launcher.base.model.events import LoadComponent
    from launcher.base.model.spec import ProcessSpec
    from launcher.posix.reactor import Timer
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

# After the start of nodes: comparing their parameters takes CPU time that they need to start.
DELAY_S = 5.0


class ParameterChecks(WarningHelpers):
    """One helper for each domain, now and then."""

    program = PARAMETER_CHECK

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._processes = run.all_processes.values()
        self._components: list[tuple[LoadComponent, str]] = []
        self._seen: set[int] = set()
        self._timer: Timer | None = None

    def begin(self) -> None:
        for process in self._processes:
            self.added(process)

    def added(self, process: Process) -> None:
        if process.spec.ros or process.spec.members:
            self._later()

    def _later(self) -> None:
        if self._timer is None and not self._has_left:
            self._timer = self.run.reactor.call_later(DELAY_S, self._check)

    def loaded(self, effect: LoadComponent, full_name: str) -> None:
        if effect.request.parameters:
            self._components.append((effect, full_name))
            self._later()

    def _check(self) -> None:
        self._timer = None
        if self._has_left:
            return
        self._compare()
        if any(one.machine.is_pending and one.child is None for one in self._processes):
            self._later()  # those were queued to start

    def _compare(self) -> None:
        """Compare the nodes that have not been yet."""
        environments: dict[str, Mapping[str, str]] = {}
        nodes: dict[str, list[dict[str, Any]]] = {}

        def add(env: Mapping[str, str], node: dict[str, Any]) -> None:
            domain = env.get("ROS_DOMAIN_ID") or "0"
            environments.setdefault(domain, env)
            nodes.setdefault(domain, []).append(node)

        for process in self._processes:
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
            owners = (one for one in self._processes if full_node_name(one.spec.argv) == container)
            owner = next(owners, None)  # None: it is no process of this run
            add(self.run.env if owner is None else owner.spec.env, _component(effect, name))
        self._components.clear()
        for domain, found in nodes.items():
            self.start_helper(environments[domain], {"nodes": found})


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
