"""Compares parameters that were set with those that nodes have, as a separate process.

ROS ignores a parameter that a node does not declare. A JSON object on standard input names the
nodes, see `NodeToCheck`; warnings go to standard output, a JSON text a line. It ends when all nodes
have been compared, after a time limit, or with its input.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import yaml

from launcher.base import strict_json, text_file, yaml_bounds
from launcher.base.model.parameter_sections import parameters, sections
from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, full_node_name, ros_options
from launcher.base.text import did_you_mean
from launcher.posix import dispositions
from launcher.posix.stdio import end_of_input, keep_for_messages

if TYPE_CHECKING:
    from launcher.ros.service_caller import ServiceCaller

PERIOD_S = 0.5
LATE_S = 4.0  # a missing parameter may be declared so much later
NO_SERVICES_S = 5.0  # a node that is there so long without parameter services has none
LIMIT_S = 60.0  # for nodes that do not appear, or do not answer
ANSWER_S = 2.0


class ParameterSetting(NamedTuple):
    """A parameter that was set. `source`: equal for nodes that share it; None: for one node."""

    name: str
    where: str
    source: str | None


class NodeToCheck:
    """A process of the run: its pid, words, and place in the launch file.

    `generated`: the parameter files among its words that the launch file's dictionaries became. A
    node in a container has a name and the names of its parameters instead of a pid and words.
    """

    def __init__(
        self,
        *,
        place: str,
        pid: int = 0,
        argv: Sequence[str] = (),
        generated: Sequence[str] = (),
        name: str | None = None,
        parameters: Sequence[str] = (),
    ) -> None:
        self._pid = pid
        self._argv = argv
        self._place = place
        self._generated = generated
        self._parameters = parameters
        self.name = name or full_node_name(argv)
        self.settings: list[ParameterSetting] = []
        self.declared: frozenset[str] | None = None  # None: not known, or any name is allowed
        self.is_done = False
        self.found_s: float | None = None
        self.seen_s: float | None = None
        self.missing_s: float | None = None
        if self.name is not None:
            self.read_settings(self.name)

    def owns(self, pid: int | None) -> bool:
        """Whether this is the process, or in its session."""
        with contextlib.suppress(OSError):
            return pid is not None and self._pid in (pid, os.getsid(pid))
        return False

    def read_settings(self, name: str) -> None:
        """Find what was set, now that the name of the node is known."""
        self.name = name
        self.settings = list(self._all_settings(name))

    def _all_settings(self, name: str) -> Iterator[ParameterSetting]:
        for parameter in self._parameters:
            # It may be for all: SetParameter and wildcards in files are not distinguished.
            yield ParameterSetting(parameter, self._place, f"component: {parameter}")
        for option, value in ros_options(self._argv):
            if option == PARAMETER:
                node, _, parameter = value.partition(":=")[0].rpartition(":")
                if not node or f"/{node}" == name:
                    yield ParameterSetting(parameter, self._place, value)
            elif option == PARAMETER_FILE:
                is_own = value in self._generated
                for parameter, line in file_parameters(value, name):
                    where = self._place if is_own else f"{value}:{line}"
                    yield ParameterSetting(
                        parameter, where, None if is_own else f"{value}: {parameter}"
                    )

    @property
    def missing(self) -> list[ParameterSetting]:
        """What was set and is not declared, each name once."""
        if self.declared is None:
            return []
        unique = {setting.name: setting for setting in self.settings}
        return [setting for name, setting in unique.items() if name not in self.declared]


def file_parameters(path: str, node: str) -> Iterator[tuple[str, int]]:
    """(parameter, line) of a parameter file for the node with this full name."""
    try:
        root = yaml_bounds.compose(text_file.read(path), yaml.SafeLoader)
    except (OSError, ValueError, yaml.YAMLError):
        return  # the node has reported it
    for section in sections(root):
        if section.is_for(node):
            for name, key, _ in parameters(section.parameters):
                yield name, key.start_mark.line + 1


class ParameterComparison:
    """Asks the nodes one after the other, repeatedly; `warn` is called with each result."""

    def __init__(self, nodes: list[NodeToCheck], warn: Callable[[str], None]) -> None:
        self._nodes = nodes
        self._warn = warn

    def run(self, caller: ServiceCaller, is_over: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        while not is_over() and time.monotonic() < deadline_s:
            waiting = [node for node in self._nodes if not node.is_done]
            if not waiting:
                break
            self._find_names(caller, waiting)
            services = dict(caller.observer.node.get_service_names_and_types())
            for node in waiting:
                if node.name is not None and not is_over():
                    self._look_at(caller, node, services)
            time.sleep(PERIOD_S)
        if not is_over():
            self._report_shared()

    def _find_names(self, caller: ServiceCaller, waiting: list[NodeToCheck]) -> None:
        if all(node.name for node in waiting):
            return
        from launcher.ros.node_tables import owners

        found, now_s = list(owners(caller, hidden=False)), time.monotonic()
        is_whole = not any(owner.undiscovered for owner in found)
        for node in (node for node in waiting if node.name is None):
            names = {owner.node for owner in found if node.owns(owner.pid)}
            if names and node.found_s is None:
                node.found_s = now_s
            is_late = node.found_s is not None and now_s - node.found_s > NO_SERVICES_S
            # The parameters of one node are not those of another.
            if len(names) == 1 and (is_whole or is_late):
                node.read_settings(names.pop())

    def _look_at(
        self, caller: ServiceCaller, node: NodeToCheck, services: dict[str, list[str]]
    ) -> None:
        from launcher.base.ros_errors import VerbError
        from launcher.ros import parameters

        assert node.name is not None
        now_s = time.monotonic()
        if f"{node.name}/list_parameters" not in services:
            if node.name in caller.observer.node_names():
                node.seen_s = node.seen_s or now_s
                node.is_done = now_s - node.seen_s > NO_SERVICES_S
            return
        try:
            if not self._is_configured(caller, node.name, services):
                return
            node.declared = frozenset(parameters.list_names(caller, node.name))
            node.missing_s = node.missing_s or now_s
            if node.missing and now_s - node.missing_s < LATE_S:
                return
            names = [setting.name for setting in node.missing]
            if names and parameters.get(caller, node.name, names):
                node.declared = None  # it allows names that it does not declare
        except VerbError:
            return  # no answer; asked again
        node.is_done = True
        self._report(node, [setting for setting in node.missing if not self._shared(setting)])

    def _is_configured(
        self, caller: ServiceCaller, name: str, services: dict[str, list[str]]
    ) -> bool:
        """A lifecycle node may declare its parameters when it is configured."""
        if services.get(f"{name}/get_state") != ["lifecycle_msgs/srv/GetState"]:
            return True
        from lifecycle_msgs.srv import GetState

        state = caller.ask(GetState, f"{name}/get_state", GetState.Request())
        return state.current_state.label in ("inactive", "active")

    # ---- results

    def _shared(self, setting: ParameterSetting) -> bool:
        uses = Counter(one.source for node in self._nodes for one in node.settings)
        return setting.source is not None and uses[setting.source] > 1

    def _report_shared(self) -> None:
        """What several nodes share is reported if all of them are known, and none declares it."""
        for node in self._nodes:
            self._report(node, [s for s in node.missing if self._shared(s) and self._is_unused(s)])

    def _is_unused(self, setting: ParameterSetting) -> bool:
        users = [node for node in self._nodes if any(_same(setting, s) for s in node.settings)]
        known = [node.declared for node in users if node.is_done and node.declared is not None]
        has_it = any(setting.name in declared for declared in known)
        return len(known) == len(users) and not has_it

    def _report(self, node: NodeToCheck, missing: list[ParameterSetting]) -> None:
        assert node.name is not None or not missing
        declared = sorted(node.declared or ())
        unset = [name for name in declared if name not in {one.name for one in node.settings}]
        for setting in missing:
            where = setting.where.removeprefix(f"{os.getcwd()}/")
            what = f"parameter '{setting.name}' was set in {where}"
            hint = did_you_mean(setting.name, unset) or did_you_mean(setting.name, declared)
            text = f"{str(node.name).lstrip('/')}: {what} but the node does not declare it"
            self._warn(f"{text}; {hint}" if hint else text)


def _same(one: ParameterSetting, other: ParameterSetting) -> bool:
    return one.source is not None and one.source == other.source


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    request = strict_json.unpacked(sys.stdin.readline())
    try:
        from launcher.ros.discovery.observer import Observer
        from launcher.ros.service_caller import ServiceCaller
    except ImportError:
        return  # without rclpy there is nothing to ask with
    over = end_of_input()
    nodes = [NodeToCheck(**node) for node in request["nodes"]]
    comparison = ParameterComparison(
        nodes, lambda text: print(strict_json.packed(text), flush=True)
    )
    with (
        Observer(purpose="parameter check") as observer,
        ServiceCaller(observer, answer_s=ANSWER_S) as caller,
    ):
        comparison.run(caller, over.is_set)


if __name__ == "__main__":
    main()
