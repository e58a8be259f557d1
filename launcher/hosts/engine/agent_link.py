"""The link to a host whose engine is our agent, reached by ssh or by another command."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence

import launcher
from launcher.base.text import typed_error
from launcher.hosts.engine.compression import METHOD
from launcher.hosts.engine.frame_channel import FrameChannel
from launcher.hosts.engine.frames import (
    CLOCK_SAMPLES,
    ECHO,
    OUTPUT_HEADER,
    PROTOCOL,
    STREAMS,
    Frame,
    FrameError,
    FrameKind,
    pack,
)
from launcher.hosts.engine.link import LinkContext, LinkState, beat_s
from launcher.hosts.engine.reports import decode_event
from launcher.hosts.engine.session_process import SessionProcess
from launcher.hosts.engine.timers import Timers
from launcher.hosts.failures import HostError, failure, no_ssh
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import SshConnection, python_script, ssh_environment
from launcher.run.processes.machine_events import MachineCommand

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.hosts.file.order import Order


UNREACHABLE_S = 3.0
RENEW_S = 6.0  # of silence, after which another connection is tried
CONNECT_S = 30.0
LEAVE_S = 2.0  # for ssh to end after its connection
RETRIES_S = (0.5, 1.0, 2.0, 4.0, 5.0)
DEFAULT_STOP_AFTER_S = 10.0


def key_of(run_id: str, host: str) -> str:
    """Names an agent on its host, among those of other runs."""
    return f"{run_id}-{zlib.crc32(host.encode()):08x}"


class AgentLink:
    """A Link. The policy is sent to the host with each connection."""

    def __init__(self, context: LinkContext, transport: SshTransport) -> None:
        self._host = context.host
        self._listener = context.listener
        self._reactor = context.reactor
        self._transport = transport
        self._key = key_of(context.run_id, context.host.name)
        self._channel = FrameChannel(context.reactor, self)
        self._process: SessionProcess | None = None
        self._state = LinkState.CONNECTING
        self._reported = LinkState.CONNECTING
        self._timers = Timers(context.reactor)
        self._attempts = 0
        self._has_greeted = False
        self._catch_up: int | None = None
        self._offset_s = 0.0  # clock of the host minus ours
        self._round_trips: list[tuple[float, float]] = []  # (seconds, offset)
        self._said: set[str] = set()
        self._is_closing = False

    # ---- what the run asks

    @property
    def state(self) -> LinkState:
        return self._state

    @property
    def silent_s(self) -> float:
        return self._reactor.now() - self._channel.heard_s

    @property
    def stop_after_s(self) -> float | None:
        policy = self._host.on_link_loss
        return DEFAULT_STOP_AFTER_S if policy is None else policy.stop_after_s

    def unit(self, process_id: int) -> str:
        return ""

    def open(self) -> None:
        self._timers.after("connect", CONNECT_S, self._connect_too_late)
        self._timers.after("start", 0, self._start)

    def prepare(self, process_id: int, order: Order) -> None:
        from launcher.hosts.file import order_json

        content = {"id": process_id, "order": order_json.encode(order)}
        self._channel.send(FrameKind.PREPARE, pack(content))

    def command(self, process_id: int, command: MachineCommand) -> None:
        self._channel.send(FrameKind.COMMAND, pack({"id": process_id, "command": command.name}))

    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None:
        content = {"id": process_id, "signal": int(signum), "by_user": by_user}
        self._channel.send(FrameKind.SIGNAL, pack(content))

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self._channel.send(FrameKind.STDIN, OUTPUT_HEADER.pack(process_id, 0) + data)

    def pause(self, paused: bool) -> None:
        """What is held here is not acknowledged, so that the host stops reading, too."""
        if paused:
            self._channel.holds_output = True
        else:
            self._timers.after("release", 0, self._channel.release)

    def finish(self, *, at_once: bool) -> None:
        self._channel.send(FrameKind.FINISH, pack({"at_once": at_once}))

    def detach(self) -> None:
        raise OSError(
            "processes of `engine: ssh` cannot be left running on purpose; use `engine: systemd`"
        )

    def close(self) -> None:
        self._is_closing = True
        self._timers.close()
        self._channel.detach()
        if self._process is not None:
            if self._state is LinkState.UNREACHABLE:
                self._process.kill()  # it would not end by itself, and other hosts wait
            self._process.close()
            self._process = None

    # ---- connecting

    def _start(self) -> None:
        is_again = self._state is LinkState.UNREACHABLE
        arguments = ["--resume", self._key] if is_again else []
        self._has_greeted = False
        try:
            self._process = process = SessionProcess(
                self._reactor,
                self._transport.words(arguments, is_again=is_again),
                self._transport.environment,
                ended=self._ended,
                line=self._error_line,
            )
        except OSError as error:
            self._failed(self._transport.absence(error).cause, may_pass=False)
            return
        self._channel.attach(process.stdout, process.stdin, skips_noise=True)
        self._channel.send_now(FrameKind.OPEN, pack(self._opening()))

    def _opening(self) -> dict[str, Any]:
        return {
            "protocol": PROTOCOL,
            "version": launcher.__version__,
            "key": self._key,
            "stop_after_s": self.stop_after_s,
            "received": self._channel.received,
            "accepts": [METHOD],
        }

    def _connect_too_late(self) -> None:
        self._failed(f"no answer within {CONNECT_S:g} s", may_pass=True)
        if self._process is not None:
            self._process.kill()

    def _error_line(self, text: str) -> None:
        if self._has_greeted:
            self._listener.warn(self._host.name, text)

    def _ended(self, returncode: int) -> None:
        """The process that led to the agent has exited; what it had sent is still to be read."""
        process, self._process = self._process, None
        self._timers.cancel("leave")
        if self._state is LinkState.GONE:
            self._channel.detach()
        elif self._channel.is_attached:
            self._channel.read_rest()
        if self._is_closing or self._state is LinkState.GONE or process is None:
            return
        if not self._has_greeted:
            error = self._transport.failure(process.errors, returncode)
            self._failed(error.cause, may_pass=error.problem.may_pass)
        else:
            self._lost("the connection has ended")

    def _failed(self, reason: str, *, may_pass: bool) -> None:
        """There is no connection."""
        self._channel.detach()
        self._timers.cancel("connect")
        if self._state is not LinkState.CONNECTING:
            if not may_pass and reason not in self._said:
                self._said.add(reason)
                self._listener.warn(self._host.name, f"cannot connect again: {reason}")
            self._retry()
        elif self._reported is LinkState.CONNECTING:
            state = LinkState.UNREACHABLE if may_pass else LinkState.GONE
            self._is_closing = True  # only a host that was ready is tried again
            self._change(state, reason)

    def _lost(self, reason: str) -> None:
        """There was a connection."""
        if self._state is LinkState.READY:
            self._change(LinkState.UNREACHABLE, reason)
        if self._state is LinkState.UNREACHABLE:
            self._retry()

    def _retry(self) -> None:
        if self._process is None and "start" not in self._timers:
            delay_s = RETRIES_S[min(self._attempts, len(RETRIES_S) - 1)]
            self._attempts += 1
            self._timers.after("start", delay_s, self._start)

    def _change(self, state: LinkState, reason: str) -> None:
        self._state = state
        if state is not self._reported:
            self._reported = state
            self._listener.link_changed(self._host.name, state, reason)

    # ---- the heartbeat

    def _beat(self) -> None:
        self._channel.send_now(FrameKind.BEAT)
        silent_s = self.silent_s
        if silent_s > UNREACHABLE_S and self._state is LinkState.READY:
            self._change(LinkState.UNREACHABLE, f"silent for {silent_s:.0f} s")
        if silent_s > RENEW_S and self._process is not None and self._has_greeted:
            self._channel.detach()
            self._process.kill()
        self._timers.after("beat", beat_s(self.stop_after_s), self._beat)

    def _echo(self, frame: Frame) -> None:
        try:
            sent_s, last = ECHO.unpack(frame.payload)
        except ValueError as error:
            raise FrameError(str(error)) from None
        now = self._reactor.now()
        if self._state is LinkState.CONNECTING:
            self._round_trips.append((now - sent_s, frame.time_s - (now + sent_s) / 2))
            if len(self._round_trips) < CLOCK_SAMPLES:
                self._channel.send_now(FrameKind.BEAT)
                return
            self._offset_s = min(self._round_trips)[1]
            self._timers.cancel("connect")
            self._timers.after("beat", beat_s(self.stop_after_s), self._beat)
            self._change(LinkState.READY, "")
        elif self._state is LinkState.UNREACHABLE:
            self._catch_up = last
            self._check_caught_up()

    def _check_caught_up(self) -> None:
        if self._catch_up is not None and self._channel.received >= self._catch_up:
            self._catch_up = None
            self._attempts = 0
            self._change(LinkState.READY, "")

    # ---- what the agent says

    def received(self, frame: Frame) -> None:
        try:
            self._handle(frame)
        except (KeyError, ValueError, TypeError) as error:
            text = f"a report of kind {frame.kind} is malformed: {typed_error(error)}"
            raise FrameError(text) from None
        if self._catch_up is not None:
            self._check_caught_up()

    def _handle(self, frame: Frame) -> None:
        match frame.kind:
            case FrameKind.OUTPUT:
                process_id, stream, data = frame.data()
                self._listener.output(process_id, STREAMS[stream], data, self._local(frame))
            case FrameKind.EVENT:
                self._event(frame)
            case FrameKind.ECHO:
                self._echo(frame)
            case FrameKind.HELLO:
                self._greeted(frame.content())
            case FrameKind.SAMPLES:
                content: Mapping[str, Any] = frame.content()
                samples = {int(process_id): one for process_id, one in content.items()}
                self._listener.samples(self._host.name, samples)
            case FrameKind.WARNING:
                self._listener.warn(self._host.name, str(frame.content()["text"]))
            case FrameKind.DROPPED:
                self._listener.dropped(self._host.name, int(frame.content()["lines"]))
            case FrameKind.REFUSAL:
                self._refused(str(frame.content()["reason"]))
            case FrameKind.FINISHED:
                self._finished(frame.content())

    def _local(self, frame: Frame) -> float:
        """The time of a frame on our clock; not in the future."""
        return min(frame.time_s - self._offset_s, self._reactor.now())

    def _event(self, frame: Frame) -> None:
        content = frame.content()
        left_s = content["left_s"]
        self._listener.event(
            int(content["id"]),
            decode_event(content["event"]),
            frame.time_s - self._offset_s,
            int(content["pid"]),
            None if left_s is None else float(left_s),
        )

    def _greeted(self, content: Mapping[str, Any]) -> None:
        if content["protocol"] != PROTOCOL:
            there = f"launcher {content.get('version')} with protocol {content['protocol']}"
            here = f"launcher {launcher.__version__} with protocol {PROTOCOL}"
            self._refused(
                f"it has {there}, and this machine {here}; bring the same version there:"
                " python -m launcher hosts sync"
            )
            return
        self._has_greeted = True
        self._channel.resume(int(content["received"]))
        self._channel.send_now(FrameKind.BEAT)

    def _refused(self, reason: str) -> None:
        """The agent has ended, or cannot serve."""
        self._has_greeted = True
        self._is_closing = True
        self._timers.cancel("connect")
        self._timers.cancel("beat")
        self._change(LinkState.GONE, reason)
        self._timers.after("farewell", 0, self._leave)

    def _finished(self, content: Mapping[str, Any]) -> None:
        leftovers = [str(text) for text in content["leftovers"]]
        self._is_closing = True  # the end of the connection is expected
        self._timers.cancel("beat")
        self._listener.finished(self._host.name, leftovers, killed=bool(content["killed"]))
        self._timers.after("farewell", 0, self._leave)

    def _leave(self) -> None:
        """Nothing more will come: acknowledge everything, and end the connection."""
        self._channel.send_now(FrameKind.ACK)
        self._channel.detach()

    # ---- the channel

    def lost(self, reason: str) -> None:
        """The stream from the agent has ended: soon the process has, too."""
        if self._is_closing:
            return
        if self._process is not None:
            self._timers.after("leave", LEAVE_S, self._process.kill)
        if self._has_greeted and self._state is LinkState.READY:
            self._change(LinkState.UNREACHABLE, reason or "the connection has ended")

    def malformed(self, reason: str) -> None:
        if not self._has_greeted:
            self._channel.detach()  # the process will say more, or has just ended
            if self._process is not None:
                self._timers.after("leave", LEAVE_S, self._process.kill)
            return
        # What it reports is not known any more, so what it runs has to end.
        self._channel.send(FrameKind.FINISH, pack({"at_once": False}))
        is_sent = self._channel.is_flushed
        stops = "a stop of its processes was requested"
        fate = stops if is_sent else "its processes may live on there"
        self._refused(f"its agent was not understood: {reason}; {fate}")
        self._timers.after("farewell", LEAVE_S, self._leave)

    def relieved(self) -> None:
        pass


class SshTransport:
    """Makes processes whose standard streams are those of the agent; `environment` is for them.

    By OpenSSH; a master connection of the user's own is used if there is one.
    """

    def __init__(self, host: Host, environment: Mapping[str, str]) -> None:
        self._host = host
        self._connection = SshConnection(host, None)
        self.environment = ssh_environment(environment)

    def words(self, arguments: Sequence[str], *, is_again: bool) -> Sequence[str]:
        """`arguments` of `launcher agent`; `is_again`: what was used before may be broken."""
        script = python_script(self._host, ["-m", "launcher", "agent", *arguments])
        return self._connection.alone(script) if is_again else self._connection.session(script)

    def failure(self, stderr: str, returncode: int | None) -> HostError:
        """Why the process has ended before the first frame of the agent."""
        return failure(self._host, stderr, returncode)

    def absence(self, error: OSError) -> HostError:
        """The process cannot be started here."""
        return no_ssh(self._host)
