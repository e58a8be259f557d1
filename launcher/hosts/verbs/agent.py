"""`agent`: serves a launcher on another machine, which starts it by ssh."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode, UsageError
from launcher.base.option import DEBUG, option
from launcher.base.verb_table import VERBS

_LOW = 10  # descriptors of the protocol are above, out of the way of standard streams

COMMAND = Command(
    "agent",
    VERBS["agent"],
    about="""\
Start, stop and watch processes for a launcher on another machine, which runs this command by ssh
for each host with `engine: ssh` of its hosts file. Requests are binary messages on standard input;
when that ends, the processes run on or are stopped, as the hosts file says. SIGTERM stops them.""",
    options=(
        option("--resume KEY", "pass this connection to the agent that has lost its own"),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    options = COMMAND.parse(words)
    if os.isatty(0) or os.isatty(1):
        raise UsageError(
            "the agent talks to a launcher, not to a terminal",
            hint="a launcher starts it on hosts with `engine: ssh` (docs/reference/hosts.md)",
        )
    return _resume(options.resume) if options.resume is not None else _serve()


def _serve() -> int:
    from launcher.hosts.agent.host_agent import Agent
    from launcher.posix.reactor import Reactor

    agent, session = _fork()
    if agent:
        return _stay(agent, session)
    read_fd, write_fd = _take_streams()
    with Reactor() as reactor:
        try:
            return Agent(reactor).serve(read_fd, write_fd, session)
        except PermissionError:  # of epoll
            message = "standard input and output of the agent must be pipes or sockets"
            raise UsageError(message) from None


def _fork() -> tuple[int, int]:
    """(pid of the agent or 0, our end of a pipe from the agent to the process that stays).

    sshd ends a session only when the process that it has started exits. So that is another one
    than the agent, which may outlive the session.
    """
    read_end, write_end = os.pipe()
    pid = os.fork()
    ours, theirs = (read_end, write_end) if pid else (write_end, read_end)
    os.close(theirs)
    if not pid:
        os.setsid()
    return pid, ours


def _stay(agent: int, session: int) -> int:
    """Hold the session until the agent exits, which determines the exit code, or releases it."""
    null = os.open(os.devnull, os.O_RDWR)
    for number in range(3):
        os.dup2(null, number)
    if os.read(session, 1):
        return ExitCode.OK
    return os.waitstatus_to_exitcode(os.waitpid(agent, 0)[1])


def _take_streams() -> tuple[int, int]:
    """What anything here prints goes to standard error, not between the messages."""
    import fcntl

    taken = [fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, _LOW) for fd in (0, 1)]
    null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
    os.dup2(null, 0)
    os.dup2(2, 1)
    os.close(null)
    return taken[0], taken[1]


def _resume(key: str) -> int:
    from launcher.hosts.agent.takeover import hand_over

    if hand_over(key):
        return ExitCode.OK
    from launcher.hosts.engine.frames import PREAMBLE, FrameKind, encode, pack

    refusal = pack({"reason": "there is no agent of this run any more"})
    sys.stdout.buffer.write(PREAMBLE + encode(FrameKind.REFUSAL, 0, 0.0, refusal))
    sys.stdout.flush()
    return ExitCode.PROCESS_FAILED
