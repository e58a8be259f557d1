"""Requests of the launch file to ROS: load requests, transitions, timers on the ROS clock.

An agent carries them out, a process that is started with the first of them. A request whose node
cannot answer any more is answered here, so that the launch file does not wait for ever.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from launcher.base.model import events
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.ros_agent import AgentTimer, RosAgent
from launcher.run.logs.run_log import RunLog
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.helpers.ros_agent import Request

# For a container that is no process of this run, while nothing else runs.
LOADING_LIMIT_S = 60.0


class RosRequests:
    """The requests of a run; `on_event` gets the answers, outside of `settle`."""

    def __init__(
        self,
        reactor: Reactor,
        log: RunLog,
        env: Mapping[str, str],
        processes: Collection[Process],
        on_event: Callable[[events.Event], None],
    ) -> None:
        self._reactor = reactor
        self._log = log
        self._env = env
        self._processes = processes
        self._on_event = on_event
        self._agent: RosAgent | None = None
        self._sim_time = False
        self._limit: Timer | None = None
        self._given_up: set[str] = set()

    @property
    def is_loading(self) -> bool:
        return self._agent is not None and self._agent.is_loading

    @property
    def sim_time(self) -> bool:
        """Whether the ROS clock is that of a simulation."""
        return self._sim_time

    def send(self, request: Request) -> None:
        self._started().send(request)

    def use_sim_time(self, value: bool) -> None:
        self._sim_time = value
        if self._agent is not None:
            self._agent.use_sim_time(value)

    def call_later(self, timer_id: int, delay_s: float) -> AgentTimer:
        """TimerFired(timer_id) after a time on the ROS clock."""
        return self._started().call_later(timer_id, delay_s)

    def _started(self) -> RosAgent:
        if self._agent is None:
            self._agent = RosAgent(self._reactor, self._env, self._on_event, self._warn)
            if self._sim_time:
                self._agent.use_sim_time(True)
        return self._agent

    def _warn(self, text: str) -> None:
        self._log.log("WARNING", "launch", text)

    def close(self) -> None:
        if self._limit is not None:
            self._limit.cancel()
            self._limit = None
        if self._agent is not None:
            self._agent.close()
            self._agent = None

    # ---- requests that nobody can answer

    def settle(self, *, expects_more: bool) -> None:
        """Fail requests whose node has exited for good; call it when something has ended."""
        is_alone = not (expects_more or any(map(_may_run, self._processes)))
        while self._agent is not None and self._fail_one(self._agent, is_alone=is_alone):
            pass  # an answer may cause the next request
        waits = is_alone and self.is_loading
        if waits and self._limit is None:
            self._limit = self._reactor.call_later(LOADING_LIMIT_S, self._give_up)
        elif not waits and self._limit is not None:
            self._limit.cancel()
            self._limit = None

    def _fail_one(self, agent: RosAgent, *, is_alone: bool) -> bool:
        for request_id, node in agent.targets():
            owners = [process for process in self._processes if node in _nodes_of(process)]
            if owners and not any(map(_may_run, owners)):
                agent.fail(request_id, f"the process of {node} has exited")
                return True
            if is_alone and not owners and node in self._given_up:
                text = f"{node} has not been there for {LOADING_LIMIT_S:g} s"
                agent.fail(request_id, f"{text}, and nothing else runs")
                return True
        return False

    def _give_up(self) -> None:
        assert self._agent is not None
        self._limit = None
        self._given_up.update(node for _, node in self._agent.targets())
        self.settle(expects_more=False)


def _may_run(process: Process) -> bool:
    return process.machine.is_pending or process.machine.is_held


def _nodes_of(process: Process) -> list[str]:
    """The full names of its nodes, as the launch file gives them."""
    specs = process.spec.members or (process.spec,)
    named = [spec.ros for spec in specs if spec.ros is not None and spec.ros.node_name is not None]
    return [f"{(ros.namespace or '').rstrip('/')}/{ros.node_name}" for ros in named]
