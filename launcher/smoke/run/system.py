"""A launched system, started and observed from outside, in a separate ROS domain."""

from __future__ import annotations

import contextlib
import itertools
import os
import shutil
import signal
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from launcher.base.document.fields import near
from launcher.base.model.run_events import Ended
from launcher.hosts.file.hosts_model import LOCAL
from launcher.posix import socket_directory
from launcher.posix.domain_lease import leased_domain
from launcher.posix.socket_directory import ControlError
from launcher.smoke.expect.expectation import STOP
from launcher.smoke.inject.grammar import Injection
from launcher.smoke.judges import explain
from launcher.smoke.observe import log_files
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import Ending, Facts, LogLine, ObservedMessage, ProcessEvent
from launcher.smoke.observe.followers import Followers
from launcher.smoke.observe.last_state import LastState
from launcher.smoke.observe.left_behind import SharedMemory, end_processes, is_of_run
from launcher.smoke.observe.probe_client import ProbeClient, ProbeError
from launcher.smoke.observe.topic_recording import SNAPSHOT, Recording, RecordingError
from launcher.smoke.observe.topic_recording import STOP_S as RECORDING_STOP_S
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.run import system_network
from launcher.smoke.run.launcher_process import LauncherProcess
from launcher.smoke.run.waits import Waits

EVALUATION_S = 120.0  # longer than the launcher's own limit, which may be raised
LISTEN_S = 10.0  # until the control socket is open, on a busy machine
STOP_S = 30.0  # SIGINT, SIGTERM and SIGKILL of every process, and what they left behind
SET_S = 5.0  # until a node has set a parameter
REST_S = 3.0  # to read what is still in the sockets
MAX_RUN_S = 3600.0  # after this the launcher stops by itself
# These would connect the system to other machines, or to the log folder of another run.
_WITHOUT_CHECKS = ("--no-parameter-check", "--no-domain-check")
_NOT_INHERITED = ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS", "LAUNCHER_RUN_ID")


class System(Waits):
    """`words` are a target, its arguments and options, as on the command line.

    Logs and other evidence go to `folder`. Without a `probe`, ROS is not observed. Use `with`, or
    `start()` and `stop()`. After `longest_s` the launcher stops by itself. The topics `records` are
    recorded into a bag. `keeps_graphs`: `last_state` has them. `judge` is called with what will be
    started, if that is known, before anything is; what it raises ends the start.
    """

    def __init__(
        self,
        words: Sequence[str],
        *,
        folder: Path,
        environment: Mapping[str, str] | None = None,
        probe: bool = True,
        longest_s: float = MAX_RUN_S,
        records: Sequence[str] = (),
        keeps_graphs: bool = False,
        judge: Callable[[Forecast], None] | None = None,
    ) -> None:
        self.words = list(words)
        self.folder = folder
        self.log_root = folder / "log"
        super().__init__(FactRecorder())
        given = os.environ if environment is None else environment
        self._environment = {k: v for k, v in given.items() if k not in _NOT_INHERITED}
        self._needs_probe = probe
        self._records = tuple(records)
        self._recording: Recording | None = None
        self._longest_s = longest_s
        self._judge = judge
        self.forecast: Forecast | None = None
        self.last_state = LastState()
        self._on_graph = self.last_state.take_graph if keeps_graphs else None
        self._stack = contextlib.ExitStack()
        self._subs = itertools.count(1)
        self._ending: Ending | None = None
        self.domain_id = 0
        self.probe: ProbeClient | None = None

    def __enter__(self) -> System:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    # ---- start and stop

    def start(self) -> None:
        """Lease a domain, start the probe, then the launcher.

        ControlError if the launcher could not open its control socket.
        """
        _refuse_without_socket(self._environment)
        self.folder.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as stack:
            self.domain_id = stack.enter_context(leased_domain())
            self.environment = {
                **self._environment,
                "ROS_DOMAIN_ID": str(self.domain_id),
                **system_network.of_system(self.words),
                "ROS_LOG_DIR": str(self.log_root.absolute()),
            }
            self._memory = SharedMemory(self.domain_id)
            stack.callback(self._memory.free_ports)  # before the lease ends
            self._start_observers(stack)
            self.recorder.begin()
            # The system is not disturbed while it is judged.
            words = [*self.words, f"--timeout={self._longest_s:g}", *_WITHOUT_CHECKS]
            output, foresees = self.folder / "launcher.out", self._judge is not None
            self._launcher = LauncherProcess(words, self.environment, output, foresees=foresees)
            if self._judge is not None:
                self._have_judged(self._judge)
            self._followers = Followers(
                self._launcher, self.recorder, self._memory, self.last_state
            )
            self._stack = stack.pop_all()

    def _have_judged(self, judge: Callable[[Forecast], None]) -> None:
        """The launcher is stopped if the judge raises, or is interrupted."""
        try:
            document = self._launcher.forecast(EVALUATION_S)
            if document is not None:
                self.forecast = Forecast.of(document)
                judge(self.forecast)
            self._launcher.go_on()
        except BaseException:
            self._launcher.stop(STOP_S)
            raise

    def _start_observers(self, stack: contextlib.ExitStack) -> None:
        environment = {**self.environment, **system_network.of_probe(self.words, self.environment)}
        if self._needs_probe:
            log = self.folder / "probe.log"
            probe = ProbeClient(environment, self.recorder, log, self._on_graph)
            stack.callback(probe.close)
            try:
                probe.wait_until_ready()
                self.probe = probe
            except ProbeError as error:
                self.recorder.add_trouble(f"{error.message}: {error.hint or 'no output'}")
        if self._records:
            recording = Recording(self._records, environment, self.folder)
            stack.callback(recording.close)
            try:
                recording.wait_until_ready()
                self._recording = recording
            except RecordingError as error:
                self.recorder.add_trouble(str(error))

    def _finish_recording(self, grace_s: float) -> None:
        """Before the system is stopped: what is alike is how it runs."""
        if self._recording is None:
            return
        self._recording.close(min(grace_s, RECORDING_STOP_S))
        try:
            self.recorder.set_recorded(self._recording.traits())
        except RecordingError as error:
            self.recorder.add_trouble(str(error))

    def _take_snapshot(self) -> None:
        """Of what the flight recorder has; after a failure it is evidence."""
        if "--record" not in self.words:
            return
        try:
            found = Path(self._request("snapshot", reason="the end of the test")["path"])
            shutil.move(found, self.folder / SNAPSHOT)
        except (ControlError, OSError) as error:
            self.recorder.add_trouble(f"no snapshot: {error}")

    def stop(self, grace_s: float = STOP_S) -> Ending:
        """Stop the system, with SIGTERM after `grace_s`; may be called more than once."""
        if self._ending is not None:
            return self._ending
        self._finish_recording(grace_s)
        asked_s = None
        if self._launcher.is_alive:
            self._take_snapshot()
            self._memory.note(self._launcher.pid)
            self.recorder.step(STOP)
            self.last_state.stop()
            asked_s = self.recorder.now_s
        self._launcher.stop(grace_s)
        down_s = self.recorder.now_s
        self._followers.join(REST_S)
        left = end_processes(self._launcher.pid)
        self._read_files()
        self._stack.close()  # ends the probe, which has shared memory mapped, and the lease
        self._ending = Ending(
            asked_s=asked_s,
            down_s=down_s,
            returncode=self._launcher.returncode,
            left_processes=left,
            left_memory=self._memory.left(),
        )
        self.recorder.end(self._ending)
        return self._ending

    def _read_files(self) -> None:
        """Complete the observations: the end of the log may come too late for the socket."""
        folder = self.log_dir
        if folder is None:
            return
        facts = self.facts()
        events = log_files.events(folder, self.recorder)
        if len(events) > len(facts.events):
            self.recorder.replace(ProcessEvent, events)
        lines = log_files.lines(folder, self.recorder)
        if len(lines) > len(facts.lines):
            self.recorder.replace(LogLine, lines)
        elif self._followers.dropped_lines:
            self.recorder.add_trouble("lines were printed too fast; some are missing")
        if not log_files.is_complete(folder):
            self.recorder.add_trouble("the log has been rotated; its first lines may be missing")

    @property
    def is_alive(self) -> bool:
        return self._ending is None and self._launcher.is_alive

    @property
    def returncode(self) -> int | None:
        """Of the launcher; None while it runs, or if it had to be killed."""
        return self._launcher.returncode

    @property
    def log_dir(self) -> Path | None:
        """The log folder of the run, once there is one."""
        return log_files.folder_of(self.log_root, self._launcher.pid)

    def last_lines(self, count: int = 15) -> list[str]:
        return self._launcher.last_lines(count)

    # ---- messages

    def watch(self, topic: str, type: str | None = None) -> None:
        sub = f"{topic} {next(self._subs)}"
        self._probed().ask("subscribe", sub=sub, topic=topic, type=type, qos=None)

    def wait_for_message(
        self,
        topic: str,
        where: Callable[[Any], object] | None = None,
        *,
        within_s: float = 10.0,
        since_s: float = 0.0,
    ) -> ObservedMessage:
        """The first message after `since_s` for whose content `where` is true."""
        if not any(m.topic == topic for m in self.facts().messages):
            self.watch(topic)

        def found(facts: Facts) -> ObservedMessage | None:
            later = (m for m in facts.received(topic) if m.at_s >= since_s)
            return next((m for m in later if where is None or where(m.content)), None)

        def guess(facts: Facts) -> str | None:
            return explain.missing_message(topic, since_s, facts)

        return self.wait_for(found, f"a message on {topic}", within_s, guess)

    # ---- commands

    def ps(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._request("ps")["processes"]
        return found

    def kill(self, process: str, signum: str = "SIGKILL") -> None:
        """Signal a process group from outside: an unexpected exit for the launcher.

        Returns after SIGKILL when the launcher has noticed the exit.
        """
        rows = self._rows(process)
        ends = {row["name"]: _ends(self.facts(), row["name"]) for row in rows}
        for row in rows:
            self.recorder.expect_exit(row["name"])
            self._memory.note(self._launcher.pid)
            if row.get("host", LOCAL) != LOCAL:  # its pid is of another machine
                self._request("kill", row["name"], signal=signum, as_crash=True)
            elif is_of_run(row["pid"], self._launcher.pid):
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(row["pid"], signal.Signals[signum])
        if signum == "SIGKILL":
            # Bounded, since uninterruptible processes cannot be killed.
            self.recorder.wait_for(
                lambda facts: all(_ends(facts, name) > before for name, before in ends.items()),
                REST_S,
            )

    def _rows(self, process: str) -> list[dict[str, Any]]:
        facts = self.facts()
        rows = self.ps()
        alive = [
            row
            for row in rows
            if row["pid"] is not None
            and (facts.is_named(row["name"], process) or process in row["node_names"])
        ]
        if not alive:
            known = ", ".join(row["name"] for row in rows if row["pid"] is not None) or "none"
            raise ControlError(f"no process '{process}' is running", hint=f"running: {known}")
        return alive

    def send(self, process: str, text: str) -> None:
        self._request("send", process, text=text)

    def control(self, verb: str, process: str) -> None:
        """`stop`, `start`, `restart`, `pause` or `resume` through the launcher."""
        self._request(verb, process)

    def inject(self, process: str, injection: Injection) -> None:
        """A fault for a while, through the launcher; a kill of it is an expected exit."""
        for row in self._rows(process) if injection.kind == "kill" else ():
            self.recorder.expect_exit(row["name"])
            self._memory.note(self._launcher.pid)
        self._request("inject", process, what=injection.text, for_s=injection.for_s)

    def has_injection(self, process: str, injection: Injection) -> bool:
        """Whether it is active in one of these processes."""
        active = self._request("inject", process)["injections"]
        return any(one["injection"] == injection.text for one in active)

    def _request(self, verb: str, *names: str, **options: object) -> dict[str, Any]:
        run = self._followers.wait_for_run(LISTEN_S)
        with run.connect() as connection:
            return connection.ask(verb, names, timeout_s=STOP_S, **options).result

    def publish(self, topic: str, type: str | None, value: Any) -> None:
        self._probed().ask("publish", topic=topic, type=type, values=value)

    def call(
        self, service: str, type: str | None = None, request: Any = None, timeout_s: float = 5.0
    ) -> Any:
        values = {} if request is None else request
        fields = {"service": service, "type": type, "values": values}
        return self._probed().ask("call", timeout_s=timeout_s, **fields)["values"]

    def parameter(self, node: str, name: str, timeout_s: float = 5.0) -> Any:
        """The value of a parameter; ProbeError if the node does not have it."""
        answer = self._ask_node(node, "get_parameters", timeout_s, names=[name])
        if name in answer["missing"]:
            known = self._parameters(node, timeout_s)
            raise ProbeError(f"{node} has no parameter '{name}'", hint=near(name, known))
        return answer["values"][name]

    def _ask_node(self, node: str, do: str, timeout_s: float, **fields: object) -> dict[str, Any]:
        try:
            return self._probed().ask(do, timeout_s=timeout_s, node=node, **fields)
        except ProbeError:
            nodes = self.facts().graph().nodes
            if nodes and node not in nodes:
                raise ProbeError(f"no node {node}", hint=near(node, nodes)) from None
            raise

    def _parameters(self, node: str, timeout_s: float) -> list[str]:
        """The names of a node's parameters; none if it does not answer."""
        kind = "rcl_interfaces/srv/ListParameters"
        try:
            answer = self.call(f"{node}/list_parameters", kind, None, timeout_s)
        except ProbeError:
            return []
        names: list[str] = answer["result"]["names"]
        return names

    def set_parameter(self, node: str, name: str, value: Any) -> None:
        """Set a parameter; ProbeError if the node refuses."""
        answer = self._ask_node(node, "set_parameters", SET_S, values={name: value})
        result = answer["results"][name]
        if result["successful"]:
            return
        known = self._parameters(node, SET_S)
        if known and name not in known:
            raise ProbeError(f"{node} has no parameter '{name}'", hint=near(name, known))
        raise ProbeError(f"{node} rejected {name}: {result['reason'] or 'no reason given'}")

    def _probed(self) -> ProbeClient:
        if self.probe is None:
            raise ProbeError("this run has no ROS probe")
        return self.probe


def _ends(facts: Facts, process: str) -> int:
    return sum(1 for _ in facts.of(Ended, process))


def _refuse_without_socket(environment: Mapping[str, str]) -> None:
    """ControlError if the launcher will find no place for its socket: nothing could be observed."""
    try:
        socket_directory.prepare("1-00000000", environment, os.getuid())  # as short as any run's
    except ControlError as error:
        raise ControlError(f"cannot open the control socket: {error.message}") from None
