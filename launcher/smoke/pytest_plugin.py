"""The pytest plugin: the fixture `launched_system`, and its part in the report of a failed test.

```python
def test_the_monitor_misses_a_dead_robot(launched_system):
    fleet = launched_system("launch/system.launch.py", enable_debug="true")
    fleet.wait_for_log("monitor", "robot_2 is reporting")
    fleet.kill("robot_2")
    fleet.wait_for_log("monitor", "robot_2 has not reported")
```

pytest loads this module in every run, so it imports the rest only when a system is launched.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Mapping

    from launcher.base.model.run_events import Ended
    from launcher.smoke.expect.expectation import Verdict
    from launcher.smoke.observe.facts import Ending, Facts, LogLine, ObservedMessage, ProcessEvent
    from launcher.smoke.run.system import System

TIMEOUT_S = 60.0
REFUSAL_S = 2.0  # longest wait for the launch file to be read, which may fail
_LAST_LINES = 15  # of each process, in the report of a failed test
ANY, LAUNCHER = "*", "launch"


class LaunchedSystem:
    """A system that runs in a separate ROS domain until the end of the test.

    A process is named as for the launcher's verbs: `robot_2-4`, `robot_2`, `robot_*`, `*`;
    `launch` is the launcher itself. A wait that times out raises an AssertionError with what was
    observed instead.
    """

    def __init__(self, system: System, timeout_s: float) -> None:
        self.system = system
        self._timeout_s = timeout_s

    # ---- waiting

    def wait_for_log(
        self,
        process: str,
        pattern: str,
        timeout_s: float | None = None,
        *,
        level: str | None = None,
        count: int = 1,
        since_s: float = 0.0,
    ) -> LogLine:
        """The `count`-th line that matches, of those after `since_s` (time of the run)."""
        return self.system.wait_for_log(
            pattern,
            process=process,
            level=level,
            count=count,
            since_s=since_s,
            within_s=self._limit(timeout_s),
        )

    def wait_for_node(self, name: str, timeout_s: float | None = None) -> Verdict:
        """Until the node, by its full name, is in the graph."""
        return self.system.wait_for_node(name, self._limit(timeout_s))

    def wait_for_topic(
        self,
        topic: str,
        type: str | None = None,
        timeout_s: float | None = None,
        *,
        publishers: int = 1,
        subscriptions: int = 0,
    ) -> Verdict:
        """Until the topic has at least so many publishers and subscriptions."""
        return self.system.wait_for_topic(
            topic,
            type,
            publishers=publishers,
            subscriptions=subscriptions,
            within_s=self._limit(timeout_s),
        )

    def wait_for_message(
        self,
        topic: str,
        where: Callable[[Any], object] | None = None,
        timeout_s: float | None = None,
        *,
        since_s: float = 0.0,
    ) -> ObservedMessage:
        """The first message, as plain values, for which `where` is true."""
        return self.system.wait_for_message(
            topic, where, within_s=self._limit(timeout_s), since_s=since_s
        )

    def wait_for_exit(self, process: str, timeout_s: float | None = None) -> ProcessEvent[Ended]:
        """The end of a process; its `event` has `returncode` and `asked`."""
        return self.system.wait_for_exit(process, self._limit(timeout_s))

    def wait_for_end(self, timeout_s: float | None = None) -> int | None:
        """The exit code of a run that ends by itself."""
        self.wait_until(lambda: not self.system.is_alive, "the run ends", timeout_s)
        return self.shutdown().returncode

    def wait_until(
        self, fact: Callable[[], object], what: str, timeout_s: float | None = None
    ) -> None:
        """Until `fact()` is true; it is called whenever something is observed."""
        self.system.wait_for(lambda _: fact(), what, self._limit(timeout_s))

    def _limit(self, timeout_s: float | None) -> float:
        return self._timeout_s if timeout_s is None else timeout_s

    # ---- control

    def kill(self, process: str, signal: str = "SIGKILL") -> None:
        """Send a signal to its process group from outside, to simulate a crash."""
        self.system.kill(process, signal)

    def stop(self, process: str) -> None:
        """Have the launcher stop it; it stays stopped."""
        self.system.control("stop", process)

    def start(self, process: str) -> None:
        """Have the launcher start it again."""
        self.system.control("start", process)

    def restart(self, process: str) -> None:
        """Have the launcher restart it."""
        self.system.control("restart", process)

    def pause(self, process: str) -> None:
        """Suspend it (SIGSTOP)."""
        self.system.control("pause", process)

    def resume(self, process: str) -> None:
        """Resume it (SIGCONT)."""
        self.system.control("resume", process)

    def send(self, process: str, text: str) -> None:
        """Write a line to its standard input."""
        self.system.send(process, text)

    def publish(self, topic: str, type: str | None, value: object) -> None:
        """Publish one message, once there is a subscription."""
        self.system.publish(topic, type, value)

    def watch(self, topic: str, type: str | None = None) -> None:
        """Record the messages of a topic from now on."""
        self.system.watch(topic, type)

    def call(self, service: str, type: str | None = None, request: object = None) -> Any:
        """The response of a service, as plain values."""
        return self.system.call(service, type, request, self._timeout_s)

    def parameter(self, node: str, name: str) -> Any:
        """The value of a parameter."""
        return self.system.parameter(node, name, self._timeout_s)

    def set_parameter(self, node: str, name: str, value: object) -> None:
        """Set a parameter of a node."""
        self.system.set_parameter(node, name, value)

    def shutdown(self) -> Ending:
        """Stop the system as Ctrl-C does; the result lists leftovers. May be repeated."""
        return self.system.stop()

    # ---- observations

    @property
    def facts(self) -> Facts:
        """Everything observed so far; times are seconds since the launcher started."""
        return self.system.facts()

    @property
    def exit_code(self) -> int | None:
        """The launcher's; None while it runs, or if it was killed."""
        return self.system.returncode

    def logs(self, process: str = ANY) -> list[str]:
        """The lines of a process so far, without colours; `launch` is the launcher itself."""
        facts = self.facts
        if process == LAUNCHER:
            return [line.plain for line in facts.lines if line.process is None]
        return [
            line.plain
            for line in facts.lines
            if line.process is not None and facts.is_named(line.process, process)
        ]

    def messages(self, topic: str) -> list[Any]:
        """The contents of the messages received so far on a watched topic."""
        return [message.content for message in self.facts.received(topic)]

    def processes(self) -> dict[str, dict[str, Any]]:
        """The launcher's table of processes: `state`, `pid`, `restarts` and more."""
        return {row["name"]: row for row in self.system.ps()}

    @property
    def environment(self) -> Mapping[str, str]:
        """The environment of the run, for other programs in its domain."""
        return self.system.environment

    def report(self) -> str:
        """The state and the last lines of each process, for the report of a failed test."""
        facts = self.facts
        parts = [
            f"python -m launcher {' '.join(self.system.words)}",
            f"files: {self.system.folder}",
        ]
        if self.exit_code is not None:
            parts.append(f"the launcher ended with {self.exit_code}")
        for process in facts.processes():
            end = facts.last_end(process)
            state = "" if end is None else f" (ended with {end.event.returncode})"
            parts.append(f"--- {process}{state}")
            parts += [line.plain for line in facts.last_lines(process, _LAST_LINES)]
        if not facts.processes():
            parts += self.system.last_lines()
        parts += [f"--- {trouble}" for trouble in facts.troubles]
        return "\n".join(parts)


_SYSTEMS = pytest.StashKey[list[LaunchedSystem]]()
_FAILED = pytest.StashKey[bool]()

Launch = Callable[..., LaunchedSystem]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("launcher").addoption(
        "--launch-artifacts",
        metavar="DIR",
        help="keep the logs, events and graph of launched systems of failed tests in this folder",
    )


@pytest.fixture
def launched_system(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Launch]:
    """`launched_system(target, *options, name=value, ...)` starts a system for this test.

    The target is a launch file (from pytest's root folder), or what the command line takes. At
    the end of the test it is stopped, and the test fails if it left anything behind.
    """
    systems: list[LaunchedSystem] = []
    left: list[str] = []
    request.node.stash[_SYSTEMS] = systems

    def launch(
        target: str | Path,
        *options: str,
        timeout_s: float = TIMEOUT_S,
        environment: Mapping[str, str] | None = None,
        probe: bool = True,
        **arguments: object,
    ) -> LaunchedSystem:
        from launcher.smoke.run.system import System

        words = [_located(target, request.config.rootpath), *options, *_assignments(arguments)]
        folder = tmp_path_factory.mktemp("launched_system")
        given = os.environ if environment is None else environment
        system = System(words, folder=folder, environment=_with_workspace(given), probe=probe)
        system.start()
        one = LaunchedSystem(system, timeout_s)
        systems.append(one)
        stack.callback(lambda: left.extend(_take_down(one, request)))
        _fail_if_refused(one)
        return one

    with contextlib.ExitStack() as stack:
        yield launch
    if left:
        pytest.fail(f"left behind: {', '.join(left)}", pytrace=False)


def _with_workspace(environ: Mapping[str, str]) -> Mapping[str, str]:
    """The environment with the workspace that the tests are in, for the probe."""
    from launcher.packages.workspace import current

    workspace = current(environ)
    if workspace is None:
        return environ
    from launcher.packages.environment import environment

    return environment(workspace, environ)


def _fail_if_refused(one: LaunchedSystem) -> None:
    """Fail the test at once if the launcher rejects the launch file or its arguments."""
    system = one.system
    system.recorder.wait_for(
        lambda facts: facts.processes() or not system.is_alive, REFUSAL_S, poll_s=0.05
    )
    from launcher.base.errors import ExitCode

    if system.returncode == ExitCode.USAGE:
        words = "\n".join(system.last_lines())
        pytest.fail(f"nothing was launched:\n{words}", pytrace=False)


def _located(target: str | Path, root: Path) -> str:
    """A file by its full path; other words as they are."""
    path = root / target
    return str(path) if path.is_file() else str(target)


def _assignments(arguments: Mapping[str, object]) -> list[str]:
    return [
        f"{name}:={str(value).lower() if isinstance(value, bool) else value}"
        for name, value in arguments.items()
    ]


def _take_down(one: LaunchedSystem, request: pytest.FixtureRequest) -> list[str]:
    """Stop a system; what it left behind."""
    directory = request.config.getoption("--launch-artifacts")
    is_kept = directory is not None and request.node.stash.get(_FAILED, False)
    system = one.system
    if is_kept and system.probe is not None and system.probe.is_alive:
        _draw(system)
    ending = one.shutdown()
    if is_kept:
        place = Path(directory) / _file_name(request.node.nodeid) / system.folder.name
        shutil.copytree(system.folder, place, dirs_exist_ok=True)
    processes = [f"the process {name}" for name in ending.left_processes]
    return processes + [f"/dev/shm/{name}" for name in ending.left_memory]


def _draw(system: System) -> None:
    from launcher.smoke.observe.probe_client import ProbeError

    assert system.probe is not None
    files = {kind: str(system.folder / f"graph.{kind}") for kind in ("json", "svg")}
    with contextlib.suppress(ProbeError):  # the logs are worth more than the reason
        system.probe.ask("draw", timeout_s=TIMEOUT_S, **files)


def _file_name(node_id: str) -> str:
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in node_id)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the output of the systems of a failed test to its report."""
    report = yield
    if report.failed and _SYSTEMS in item.stash:
        item.stash[_FAILED] = True
        hint = getattr(call.excinfo and call.excinfo.value, "hint", None)
        if isinstance(hint, str):
            report.sections.append(("hint", hint))
        for one in item.stash[_SYSTEMS]:
            report.sections.append(("launched system", one.report()))
    return report
