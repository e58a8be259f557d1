"""The agent: serves one launcher, through one connection at a time, and outlives it if asked to."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence

import launcher
from launcher.base.errors import ExitCode, LauncherError
from launcher.hosts.agent.workload import Workload
from launcher.hosts.engine.compression import METHOD
from launcher.hosts.engine.frame_channel import PIPE_BYTES, FrameChannel
from launcher.hosts.engine.frames import (
    CLOCK_SAMPLES,
    ECHO,
    OUTPUT_HEADER,
    PREAMBLE,
    PROTOCOL,
    Frame,
    FrameError,
    FrameKind,
    pack,
)
from launcher.hosts.engine.reports import encode_event
from launcher.packages.distribution import installed
from launcher.posix import pipes
from launcher.posix.reactor import Reactor
from launcher.run.processes.machine_events import MachineCommand, MachineEvent

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.hosts.agent.takeover import TakeoverServer

WINDOW = 4 * 1024 * 1024  # unacknowledged bytes, above which processes must wait
BACKLOG = 32 * 1024 * 1024  # kept while the operator cannot be reached
UNREACHABLE_S = 3.0
WATCH_S = 0.25
# Without processes and without an operator, who may come back to see how they have ended.
LINGER_S = 30.0
LINGER_KEEPING_S = 600.0  # if they were to be kept
GOODBYE_S = 5.0  # for the last frames
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT)
# What an operator may ask for.
_COMMANDS = frozenset(
    [
        MachineCommand.START,
        MachineCommand.USER_START,
        MachineCommand.STOP,
        MachineCommand.USER_STOP,
        MachineCommand.RESTART,
        MachineCommand.SKIP_GRACE,
        MachineCommand.SUSPEND,
        MachineCommand.RESUME,
    ]
)


class Agent:
    """Serves until a request to finish, or until the operator has been away for too long."""

    def __init__(self, reactor: Reactor) -> None:
        self._reactor = reactor
        self._channel = FrameChannel(reactor, self)
        self._workload: Workload | None = None
        self._takeover: TakeoverServer | None = None
        self._session = -1  # to the process that holds our session
        self._key = ""
        self._stop_after_s: float | None = None
        self._beats = 0
        self._is_lost = False
        self._has_stopped = False  # since the operator was lost
        self._idle_since_s = reactor.now()
        self._is_asked_to_finish = self._is_finished = False
        self._end_reason = ""
        self._exit_code = ExitCode.OK

    # ---- the connection

    def serve(self, read_fd: int, write_fd: int, session: int) -> int:
        """Serve the launcher at the other end; the exit code. OSError if that is no stream.

        `session` leads to a process that waits until we exit, or do not need its session.
        """
        self._session = session
        self._attach(read_fd, write_fd)
        self._greet()
        self._reactor.on_signals(_SIGNALS, self._signalled)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        self._watch()
        try:
            self._reactor.run()
        finally:
            self._close()
        return self._exit_code

    def _close(self) -> None:
        self._channel.detach()
        self._leave_session(b"")
        if self._takeover is not None:
            self._takeover.close()
        if self._workload is not None:
            self._workload.close()

    def _attach(self, read_fd: int, write_fd: int) -> None:
        """OSError if they are no streams."""
        pipes.widen(write_fd, PIPE_BYTES)
        self._channel.attach(read_fd, write_fd)

    def _greet(self) -> None:
        self._channel.raw(PREAMBLE)
        self._channel.send_now(
            FrameKind.HELLO, pack({**_about_us(), "received": self._channel.received})
        )

    def taken(self, streams: list[int], session: int) -> None:
        """Another process has passed us its standard streams, and waits as in `serve`."""
        read_fd, write_fd, errors = streams
        _say_to(errors)
        self._channel.detach()
        self._leave_session()
        self._session = session
        try:
            self._attach(read_fd, write_fd)
        except OSError:
            self._leave_session()
            return
        self._greet()

    def _leave_session(self, farewell: bytes = b".") -> None:
        """Let the process go that holds our session; b"": because we exit."""
        if self._session >= 0:
            with contextlib.suppress(OSError):
                os.write(self._session, farewell)
            os.close(self._session)
            self._session = -1

    def lost(self, reason: str) -> None:
        if reason:
            self._say(reason)
        _say_to(os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC))
        if self._is_finished or not self._may_return:
            if not self._is_finished:
                self._exit_code = ExitCode.PROCESS_FAILED
            self._reactor.stop()
            return
        self._leave_session()
        self._lose()

    @property
    def _may_return(self) -> bool:
        """Whether the launcher comes back: it has to have counted us as ready."""
        if self._workload is None:
            return False
        return self._beats >= CLOCK_SAMPLES or not self._workload.is_idle

    def _lose(self) -> None:
        self._is_lost = True
        self._idle_since_s = self._reactor.now()
        if self._workload is not None:
            self._workload.reader.pause(False)

    # ---- the leash

    def _watch(self) -> None:
        now = self._reactor.now()
        silent_s = now - self._channel.heard_s
        if silent_s > UNREACHABLE_S and not self._is_lost:
            self._lose()
        after_s = self._stop_after_s
        if after_s is not None and silent_s >= after_s and not self._has_stopped:
            self._has_stopped = True
            if self._workload is not None:
                self._workload.end()
        if self._is_lost:
            self._linger(now)
        self._reactor.call_later(WATCH_S, self._watch)

    def _linger(self, now: float) -> None:
        if self._workload is not None and not self._workload.is_idle:
            self._idle_since_s = now
            return
        linger_s = LINGER_KEEPING_S if self._stop_after_s is None else LINGER_S
        if now - self._idle_since_s > linger_s:
            self._end("no launcher has come back")

    def _signalled(self, signum: int) -> None:
        self._end(f"the agent was stopped by {signal.Signals(signum).name}")

    def _end(self, reason: str, code: ExitCode = ExitCode.OK) -> None:
        """Stop everything, send the reason, and exit."""
        is_again = bool(self._end_reason)
        self._end_reason = self._end_reason or reason
        self._exit_code = code
        if self._workload is None:
            self._leave()
        else:
            self._workload.end(at_once=is_again)

    def _leave(self) -> None:
        if self._end_reason:
            self._channel.send_now(FrameKind.REFUSAL, pack({"reason": self._end_reason}))
        self._is_finished = True
        self._reactor.call_later(GOODBYE_S, self._reactor.stop)
        self.relieved()

    def relieved(self) -> None:
        channel, workload = self._channel, self._workload
        is_done = self._is_finished and (channel.outbox.is_empty or not channel.is_attached)
        if is_done and (channel.is_flushed or not channel.is_attached):
            self._reactor.stop()
        elif workload is not None and (self._is_lost or channel.outbox.bytes < WINDOW // 2):
            workload.reader.pause(False)

    # ---- requests

    def received(self, frame: Frame) -> None:
        if self._is_lost:
            self._is_lost = self._has_stopped = False
        if frame.kind == FrameKind.BEAT:
            self._beats += 1
            self._channel.send_now(
                FrameKind.ECHO, ECHO.pack(frame.time_s, self._channel.outbox.sequence)
            )
            return
        handler = _HANDLERS.get(frame.kind)
        if handler is None or (self._workload is None and frame.kind != FrameKind.OPEN):
            self._refuse(f"a frame of kind {frame.kind} was not expected")
            return
        try:
            handler(self, frame)
        except FrameError as error:
            self._refuse(str(error))
        except (KeyError, ValueError, TypeError) as error:
            # Without the value, which may be secret.
            self._refuse(f"a request of kind {frame.kind} is malformed ({type(error).__name__})")

    def malformed(self, reason: str) -> None:
        """The other side does not use our protocol."""
        self._refuse(reason)

    def _refuse(self, reason: str) -> None:
        self._say(f"not understood: {reason}; the processes are stopped")
        self._end(reason, ExitCode.PROCESS_FAILED)

    def _open(self, frame: Frame) -> None:
        content = frame.content()
        if content["protocol"] != PROTOCOL:
            self._end(f"this agent uses protocol {PROTOCOL}", ExitCode.PROCESS_FAILED)
            return
        key, stop_after_s = str(content["key"]), content["stop_after_s"]
        self._stop_after_s = None if stop_after_s is None else float(stop_after_s)
        if self._workload is None:
            self._key = key
            self._workload = Workload(self._reactor, self, self._listen())
        elif key != self._key:
            raise FrameError("it is for another run")
        # An older launcher says nothing of that.
        self._channel.compression.is_possible = METHOD in content.get("accepts", ())
        self._channel.resume(int(content["received"]))

    def _listen(self) -> str:
        """Wait for those who resume the run; a folder for files."""
        from launcher.hosts.agent.takeover import TakeoverServer, files_folder, socket_path

        try:
            path = socket_path(self._key)
            self._takeover = TakeoverServer(self._reactor, path, self.taken)
        except (OSError, LauncherError) as error:
            self.warn(f"a lost connection cannot be replaced: {error}")
            import tempfile

            return f"{tempfile.gettempdir()}/launcher-agent-{os.getpid()}-{os.urandom(8).hex()}"
        return str(files_folder(path))

    def _prepare(self, frame: Frame) -> None:
        from launcher.hosts.file import order_json

        content = frame.content()
        self._work.prepare(int(content["id"]), order_json.decode(content["order"]))

    def _command(self, frame: Frame) -> None:
        content = frame.content()
        command = MachineCommand[content["command"]]
        if command not in _COMMANDS:
            raise FrameError(f"{command.name} is no request")
        self._work.command(int(content["id"]), command)

    def _signal(self, frame: Frame) -> None:
        content = frame.content()
        signum = signal.Signals(content["signal"])
        self._work.signal(int(content["id"]), int(signum), by_user=bool(content["by_user"]))

    def _stdin(self, frame: Frame) -> None:
        process_id, _, data = frame.data()
        self._work.write_stdin(process_id, data)

    def _finish(self, frame: Frame) -> None:
        self._is_asked_to_finish = True
        if not self._is_finished:
            self._work.end(at_once=bool(frame.content()["at_once"]))

    @property
    def _work(self) -> Workload:
        assert self._workload is not None
        return self._workload

    # ---- reports

    def event(
        self, process_id: int, event: MachineEvent, at_s: float, pid: int, left_s: float | None
    ) -> None:
        content = {"id": process_id, "event": encode_event(event), "pid": pid, "left_s": left_s}
        self._channel.send(FrameKind.EVENT, pack(content), at_s)

    def output(self, process_id: int, stream: int, data: bytes) -> None:
        self._channel.send_output(OUTPUT_HEADER.pack(process_id, stream), data)
        if self._is_lost:
            self._channel.outbox.limit(BACKLOG, time.monotonic())
        elif self._channel.outbox.bytes > WINDOW:
            self._work.reader.pause(True)

    def warn(self, text: str) -> None:
        self._channel.send(FrameKind.WARNING, pack({"text": text}))

    def samples(self, samples: Mapping[int, Mapping[str, Any]]) -> None:
        self._channel.send_now(
            FrameKind.SAMPLES, pack({str(key): dict(one) for key, one in samples.items()})
        )

    def ended(self, leftovers: Sequence[str], *, killed: bool) -> None:
        self._idle_since_s = self._reactor.now()
        if self._end_reason:
            self._leave()
        elif self._is_asked_to_finish:
            content = {"leftovers": list(leftovers), "killed": killed}
            self._channel.send(FrameKind.FINISHED, pack(content))
            self._leave()

    def _say(self, text: str) -> None:
        """On standard error, which the launcher logs."""
        try:
            print(f"agent: {text}", file=sys.stderr, flush=True)
        except OSError:
            return


_HANDLERS: Mapping[int, Callable[[Agent, Frame], None]] = {
    FrameKind.OPEN: Agent._open,
    FrameKind.ACK: lambda agent, frame: None,
    FrameKind.PREPARE: Agent._prepare,
    FrameKind.COMMAND: Agent._command,
    FrameKind.SIGNAL: Agent._signal,
    FrameKind.STDIN: Agent._stdin,
    FrameKind.FINISH: Agent._finish,
}


def _say_to(fd: int) -> None:
    """What is printed goes there; `fd` is closed. sshd waits until nobody has its streams open."""
    for number in (1, 2):
        os.dup2(fd, number, inheritable=False)
    os.close(fd)


def _about_us() -> dict[str, Any]:
    home = os.path.expanduser("~")
    try:
        found = os.statvfs(home)
        free_bytes: int | None = found.f_bavail * found.f_frsize
    except OSError:
        free_bytes = None
    return {
        "protocol": PROTOCOL,
        "version": launcher.__version__,
        "pid": os.getpid(),
        "host": os.uname().nodename,
        "python": sys.version.split()[0],
        "free_bytes": free_bytes,
        "wall_s": time.time(),
        "distro": installed() or "",
        "prefixes": os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep),
    }
