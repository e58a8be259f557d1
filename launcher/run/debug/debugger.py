"""A process under debugpy: the command, and what an editor needs to attach."""

from __future__ import annotations

import importlib.util
import socket
import sys

from launcher.base.model.record import Record, replace
from launcher.packages.extras import install_command
from launcher.packages.python_program import program_of
from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.spec import ProcessSpec

ADDRESS = "127.0.0.1"
_LISTEN = "0A"  # TCP_LISTEN in /proc/net/tcp


class NotDebuggableError(Exception):
    """It cannot run under debugpy; `hint` says what can be done instead."""

    def __init__(self, reason: str, hint: str) -> None:
        super().__init__(reason)
        self.hint = hint


class Debugger(Record):
    """Where it listens, and the process with it in front; `waits`: for an editor to attach."""

    spec: ProcessSpec
    port: int
    waits: bool

    @property
    def address(self) -> str:
        return f"{ADDRESS}:{self.port}"

    @property
    def configuration(self) -> dict[str, object]:
        """The entry in `configurations` of VS Code's launch.json."""
        return {
            "name": self.spec.label,
            "type": "debugpy",
            "request": "attach",
            "connect": {"host": ADDRESS, "port": self.port},
            "justMyCode": False,
        }

    @property
    def is_listening(self) -> bool:
        """Whether the kernel lists the port as open: to connect would be to attach."""
        wanted = f":{self.port:04X}"
        rows = (line.split() for line in proc.read("net", "tcp").decode().splitlines()[1:])
        return any(row[3] == _LISTEN and row[1].endswith(wanted) for row in rows)


def debugger_for(
    spec: ProcessSpec, port: int | None, *, waits: bool, before: Debugger | None = None
) -> Debugger:
    """The process under debugpy, at a free port if `port` is None; NotDebuggableError.

    It may take over the port of the one `before`, which is stopped first.
    """
    program = (
        "it is a command of a shell" if spec.shell else program_of(spec.argv, spec.env, spec.cwd)
    )
    if isinstance(program, str):
        gdb = f"gdb -p PID, or launch with --prefix '{spec.label}=gdb -ex run --args'"
        raise NotDebuggableError(f"debugpy runs Python programs only: {program}", gdb)
    if importlib.util.find_spec("debugpy") is None:
        problem = f"this needs the Python package 'debugpy', which {sys.executable} does not have"
        raise NotDebuggableError(problem, install_command("debug"))
    if before is None or port != before.port:
        port = _usable(port)
    what = ("-m", program.module) if program.module else (program.script,)
    words = (
        program.interpreter,
        *(("-X", "frozen_modules=off") if sys.version_info >= (3, 11) else ()),
        *("-m", "debugpy", "--listen", f"{ADDRESS}:{port}"),
        *(("--wait-for-client",) if waits else ()),
        *what,
        *program.words,
    )
    return Debugger(replace(spec, argv=words), port, waits)


def _usable(port: int | None) -> int:
    """This port, or one that the kernel chooses; NotDebuggableError if it cannot be used."""
    with socket.socket() as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            one.bind((ADDRESS, port or 0))
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or "a port is a number from 1 to 65535"
            hint = "without --port a free one is chosen"
            raise NotDebuggableError(f"port {port} cannot be used: {reason}", hint) from None
        return int(one.getsockname()[1])
