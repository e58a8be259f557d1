"""System: a launched system, started and observed from outside, in a ROS domain of its own."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from launcher.control.folder import ControlError
from launcher.domain_lease import leased_domain
from launcher.engine.cleanup.run_id import run_id_of
from launcher.smoke import guesses, written
from launcher.smoke.facts import STOP, Ending, Facts, Message
from launcher.smoke.fields import near
from launcher.smoke.followers import Followers
from launcher.smoke.launched import Launched
from launcher.smoke.observed import Observed
from launcher.smoke.probe_client import Probe, ProbeError
from launcher.smoke.recorder import Recorder
from launcher.smoke.remains import SharedMemory, end_processes

LISTEN_S = 10.0  # until the launcher has started its first process, on a busy machine
STOP_S = 30.0  # SIGINT, SIGTERM and SIGKILL of every process, and what they left behind
SET_S = 5.0  # until a node has answered
REST_S = 3.0  # for what is on its way through the sockets
LONGEST_S = 3600.0  # the launcher ends itself after this, whatever happens to us
# These would lead out of the domain or the machine, or into another run's folder.
_NOT_INHERITED = ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS", "LAUNCHER_RUN_ID")


class System(Observed):
    """`words` are a target, its arguments and options, as on the command line.

    `folder` gets the logs and all evidence. Without a `probe` nothing of ROS is seen. Use `with`,
    or `start()` and `stop()`. `longest_s`: after this time the launcher stops by itself.
    """

    def __init__(
        self,
        words: Sequence[str],
        *,
        folder: Path,
        environment: Mapping[str, str] | None = None,
        probe: bool = True,
        longest_s: float = LONGEST_S,
    ) -> None:
        self.words = list(words)
        self.folder = folder
        self.log_root = folder / "log"
        super().__init__(Recorder())
        self._base = dict(os.environ if environment is None else environment)
        self._wants_probe = probe
        self._longest_s = longest_s
        self._stack = contextlib.ExitStack()
        self._subs = itertools.count(1)
        self._ending: Ending | None = None
        self.domain_id = 0
        self.probe: Probe | None = None

    def __enter__(self) -> System:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    # ---- the lifetime

    def start(self) -> None:
        """Lease a domain, start the probe, then the launcher."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as stack:
            self.domain_id = stack.enter_context(leased_domain())
            self.environment = self._environment()
            self._memory = SharedMemory(self.domain_id)
            stack.callback(self._memory.free_ports)  # before the lease goes to somebody else
            if self._wants_probe:
                self._start_probe(stack)
            self.recorder.begin()
            words = [*self.words, f"--timeout={self._longest_s:g}"]
            self._launched = Launched(words, self.environment, self.folder / "launcher.out")
            self._followers = Followers(self._launched, self.recorder, self._memory)
            self._stack = stack.pop_all()

    def _environment(self) -> dict[str, str]:
        kept = {k: v for k, v in self._base.items() if k not in _NOT_INHERITED}
        return {
            **kept,
            "ROS_DOMAIN_ID": str(self.domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(self.log_root.absolute()),
        }

    def _start_probe(self, stack: contextlib.ExitStack) -> None:
        probe = Probe(self.environment, self.recorder, self.folder / "probe.log")
        stack.callback(probe.close)
        try:
            probe.wait_until_ready()
            self.probe = probe
        except ProbeError as error:
            self.recorder.add_trouble(f"{error.message}: {error.hint or 'it said nothing'}")

    def stop(self, patience_s: float = STOP_S) -> Ending:
        """Take everything down; how it went. Again: the same answer."""
        if self._ending is not None:
            return self._ending
        asked_s = None
        if self._launched.is_alive:
            self._memory.note(self._launched.pid)
            self.recorder.step(STOP)
            asked_s = self.recorder.now_s
        self._launched.stop(patience_s)
        down_s = self.recorder.now_s
        self._followers.join(REST_S)
        left = end_processes(self._launched.pid)
        self._read_files()
        self._stack.close()  # the probe, which has memory mapped, and the lease
        self._ending = Ending(
            asked_s=asked_s,
            down_s=down_s,
            returncode=self._launched.returncode,
            left_processes=left,
            left_memory=self._memory.left(),
        )
        self.recorder.end(self._ending)
        return self._ending

    def _read_files(self) -> None:
        """Complete what was heard: the last words of a run may come too late for its socket."""
        folder = self.log_dir
        if folder is None:
            return
        events = written.events(folder, self.recorder)
        if len(events) > len(self.facts().events):
            self.recorder.replace_events(events)
        self._read_log(folder)

    def _read_log(self, folder: Path) -> None:
        lines = written.lines(folder, self.recorder)
        if len(lines) > len(self.facts().lines):
            self.recorder.replace_lines(lines)
        elif self._followers.dropped_lines:
            self.recorder.add_trouble("so much was printed that some of it is not known")
        if not written.is_whole(folder):
            self.recorder.add_trouble("so much was printed that the first of it may not be known")

    @property
    def is_alive(self) -> bool:
        """Whether the launcher runs."""
        return self._ending is None and self._launched.is_alive

    @property
    def returncode(self) -> int | None:
        """The launcher's exit code; None while it runs, or if it had to be killed."""
        return self._launched.returncode

    @property
    def log_dir(self) -> Path | None:
        """The folder of the run; None as long as there is none."""
        return written.folder_of(self.log_root, self._launched.pid)

    def last_words(self, count: int = 15) -> list[str]:
        """The last lines that the launcher printed."""
        return self._launched.last_words(count)

    # ---- watching

    def watch(
        self, topic: str, type: str | None = None, qos: Mapping[str, Any] | None = None
    ) -> str:
        """Record the messages of a topic from now on; the key that they carry as `watch`."""
        sub = f"{topic} {next(self._subs)}"
        self._probed().ask("subscribe", sub=sub, topic=topic, type=type, qos=_qos_words(qos))
        return sub

    def wait_for_message(
        self,
        topic: str,
        where: Callable[[Any], object] | None = None,
        *,
        within_s: float = 10.0,
        since_s: float = 0.0,
    ) -> Message:
        """The first message after `since_s` whose content is as wanted; watches the topic."""
        if not any(m.topic == topic for m in self.facts().messages):
            self.watch(topic)

        def found(facts: Facts) -> Message | None:
            later = (m for m in facts.heard(topic) if m.at_s >= since_s)
            return next((m for m in later if where is None or where(m.content)), None)

        return self.wait_for(
            found,
            f"a message on {topic}",
            within_s,
            lambda facts: guesses.message(topic, since_s, facts),
        )

    # ---- steering

    def ps(self) -> list[dict[str, Any]]:
        """What the run says of its processes now."""
        found: list[dict[str, Any]] = self._control("ps")["processes"]
        return found

    def kill(self, process: str, signum: str = "SIGKILL") -> None:
        """Send a signal to a process's group from outside; the launcher sees an unasked death.

        After a SIGKILL it has seen it when this returns.
        """
        rows = self._rows(process)
        ends = {row["name"]: _ends(self.facts(), row["name"]) for row in rows}
        for row in rows:
            self.recorder.ask(row["name"])
            self._memory.note(self._launched.pid)
            _signal_group(row["pid"], self._launched.pid, signal.Signals[signum])
        if signum == "SIGKILL":
            # Bounded, since nobody can end what sleeps uninterruptibly.
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
            raise ControlError(f"no process '{process}' runs", hint=f"there are: {known}")
        return alive

    def stop_process(self, process: str) -> None:
        """Let the launcher stop it, in order; it stays stopped."""
        self._steer("stop", process, ends=True)

    def start_process(self, process: str) -> None:
        """Let the launcher start it again."""
        self._steer("start", process)

    def restart_process(self, process: str) -> None:
        """Let the launcher stop it and start it again."""
        self._steer("restart", process, ends=True)

    def pause(self, process: str) -> None:
        """Let it stand still."""
        self._steer("pause", process)

    def resume(self, process: str) -> None:
        """Let it go on."""
        self._steer("resume", process)

    def send(self, process: str, text: str) -> None:
        """A line for its standard input."""
        self._control("send", process, text=text)

    def _steer(self, verb: str, process: str, *, ends: bool = False) -> None:
        if ends:
            for name in self.facts().named(process):
                self.recorder.ask(name)
        self._control(verb, process)

    def _control(self, verb: str, *names: str, **options: Any) -> dict[str, Any]:
        run = self._followers.wait_for_run(LISTEN_S)
        with run.connect() as connection:
            return connection.ask(verb, names, patience_s=STOP_S, **options).result

    def publish(self, topic: str, type: str | None, value: Any) -> None:
        """Publish one message, when a subscription is there."""
        self._probed().ask("publish", topic=topic, type=type, values=value)

    def call(
        self, service: str, type: str | None = None, request: Any = None, timeout_s: float = 5.0
    ) -> Any:
        """The response of a service."""
        values = {} if request is None else request
        answer = self._probed().ask(
            "call", timeout_s=timeout_s, service=service, type=type, values=values
        )
        return answer["values"]

    def parameter(self, node: str, name: str, timeout_s: float = 5.0) -> Any:
        """The value of a parameter; ProbeError if the node does not have it."""
        answer = self._ask_node(node, "get_parameters", timeout_s, names=[name])
        if name in answer["missing"]:
            raise self._no_parameter(node, name, timeout_s)
        return answer["values"][name]

    def _ask_node(self, node: str, do: str, timeout_s: float, **fields: Any) -> dict[str, Any]:
        try:
            return self._probed().ask(do, timeout_s=timeout_s, node=node, **fields)
        except ProbeError:
            nodes = self.facts().graph().nodes
            if nodes and node not in nodes:
                hint = near(node, list(nodes))
                raise ProbeError(f"there is no node {node}", hint=hint) from None
            raise

    def _no_parameter(self, node: str, name: str, timeout_s: float) -> ProbeError:
        known = self._parameters(node, timeout_s)
        return ProbeError(f"{node} has no parameter '{name}'", hint=near(name, known))

    def _parameters(self, node: str, timeout_s: float) -> list[str]:
        """The names of a node's parameters; none if it does not say."""
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
            raise self._no_parameter(node, name, SET_S)
        raise ProbeError(f"{node} refuses {name}: {result['reason'] or 'it gives no reason'}")

    def _probed(self) -> Probe:
        if self.probe is None:
            raise ProbeError("there is no ROS probe in this run")
        return self.probe


def _qos_words(qos: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Policies in the words of `topic info -v`."""
    if qos is None:
        return None
    return {name: v.upper() if isinstance(v, str) else v for name, v in qos.items()}


def _ends(facts: Facts, process: str) -> int:
    """How often it has ended so far."""
    return sum(1 for _ in facts.of("ended", process))


def _signal_group(pid: int, launcher_pid: int, signum: signal.Signals) -> None:
    """Only if the process still is one of the run."""
    run_id = run_id_of(pid)
    if run_id is not None and run_id.partition("-")[0] == str(launcher_pid):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(pid, signum)
