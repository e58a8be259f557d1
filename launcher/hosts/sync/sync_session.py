"""The operator's side of a session with the program in `on_host/`."""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, BinaryIO

from launcher.base.errors import LauncherError
from launcher.hosts.failures import HostError, Problem, failure, last_line
from launcher.hosts.file.hosts_model import DEFAULT_PYTHON, Host
from launcher.hosts.ssh import host_python, in_home, quoted
from launcher.hosts.sync.on_host import MODULES, wire

OLDEST_PYTHON = (3, 10)
_NO_PYTHON = f"there is no Python '{DEFAULT_PYTHON}', nor one that the hosts file names"
_PACKAGE = "launcher.hosts.sync.on_host"
_TOO_OLD = "launcher-sync: Python is too old: "
_START = f"""\
import sys
if sys.version_info < {OLDEST_PYTHON}: sys.exit("{_TOO_OLD}%d.%d" % sys.version_info[:2])
read = sys.stdin.buffer
exec(compile(read.read(int(read.readline())), "sync", "exec"))"""
_LOADER = """
import sys, types
def load(name, source=None):
    module = sys.modules[name] = types.ModuleType(name)
    module.__path__ = []
    above, _, last = name.rpartition(".")
    if above: setattr(sys.modules[above], last, module)
    if source is not None: exec(compile(source, name, "exec"), module.__dict__)
    return module
parts = PACKAGE.split(".")
for number in range(len(parts)): load(".".join(parts[:number + 1]))
for name, source in SOURCES: module = load(PACKAGE + "." + name, source)
module.main()
"""


def script(host: Host) -> str:
    """What a POSIX shell there runs; it reads the program from its standard input.

    Without the Python of the hosts file, which may be one that is to be brought, it is the usual
    one.
    """
    own = quoted([host_python(host)])
    start = quoted(["-I", "-S", "-c", _START])
    needed = "".join(_required(path) for path in host.setup)
    return (
        f"cd || exit; {needed}python={own}; "
        f'command -v "$python" >/dev/null || python={DEFAULT_PYTHON}; '
        f'exec "$python" {start} "$python"'
    )


def _required(path: str) -> str:
    """Ends with the message of a shell if there is no such setup file, which a run would need."""
    place = in_home(path)
    missing = quoted([f"{place}: No such file"])
    return f"test -r {quoted([place])} || {{ echo {missing} >&2; exit 1; }}; "


class SyncSession:
    """Requests to one host. HostError from everything but `close`."""

    def __init__(self, host: Host, words: Sequence[str], env: dict[str, str]) -> None:
        """`words` run `script(host)` there, with `env` for what carries it."""
        self._host = host
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  (closed by `close`)
        self._process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=env,
            start_new_session=True,
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._requests: BinaryIO = self._process.stdin  # type: ignore[assignment]
        self._answers: BinaryIO = self._process.stdout  # type: ignore[assignment]

    def start(self) -> None:
        """Send the program, and wait until it runs."""
        program = _program()
        with contextlib.suppress(OSError):  # the reason is in its messages
            self._requests.write(b"%d\n" % len(program) + program)
            self._requests.flush()
        for line in self._answers:
            if line == wire.READY:
                return
        raise self._failed()

    def ask(
        self, request: dict[str, Any], say: Callable[[str], None] = lambda _: None
    ) -> dict[str, Any]:
        """The answer to a request; meanwhile `say` gets messages for the user."""
        with contextlib.suppress(OSError):
            wire.send(self._requests, request)
        return self._answer(say)

    def send_content(
        self,
        request: dict[str, Any],
        blocks: Iterable[bytes],
        count: Callable[[int], None],
    ) -> None:
        """Send the content of a file with a request that has no answer."""
        try:
            wire.send(self._requests, request)
            wire.send_content(self._requests, blocks, count)
        except BrokenPipeError:
            self._answer(lambda _: None)  # why it does not listen any more
            raise self._failed() from None

    def kill(self) -> None:
        """End it at once, from another thread; what waits for it gets a HostError."""
        self._process.kill()

    def close(self) -> None:
        """End the session; idempotent."""
        for file in (self._requests, self._answers):
            with contextlib.suppress(OSError):
                file.close()
        try:
            self._process.wait(2)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._errors.close()

    def _answer(self, say: Callable[[str], None]) -> dict[str, Any]:
        while True:
            try:
                answer = wire.receive(self._answers)
            except (wire.Closed, OSError):
                raise self._failed() from None
            if "say" in answer:
                say(answer["say"])
                continue
            if "error" in answer:
                hint = answer["hint"] or None
                raise HostError(self._host, Problem.OTHER, answer["error"], hint=hint)
            return answer

    def _failed(self) -> LauncherError:
        """The error for a session that has ended, from its messages."""
        with contextlib.suppress(OSError):
            self._requests.close()
        try:
            code = self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        self._errors.seek(0)
        text = self._errors.read().decode(errors="replace")
        line = last_line(text)
        if line.startswith(_TOO_OLD):
            version = line.removeprefix(_TOO_OLD)
            oldest = ".".join(map(str, OLDEST_PYTHON))
            message = f"its Python {version} is too old: the launcher needs {oldest}"
            hint = "name a newer one by `python:` in the hosts file"
            return HostError(self._host, Problem.NO_PYTHON, message, hint=hint)
        error = failure(self._host, text, code)
        if error.problem is Problem.NO_PYTHON:
            oldest = ".".join(map(str, OLDEST_PYTHON))
            hint = f"install Python {oldest} or newer there, or name one by `python:`"
            return HostError(self._host, error.problem, _NO_PYTHON, hint=hint)
        return error


def blocks_of(path: str) -> Iterator[bytes]:
    """The content of a file, in blocks."""
    with open(path, "rb") as file:
        while block := file.read(wire.BLOCK_BYTES):
            yield block


def _program() -> bytes:
    folder = os.path.dirname(wire.__file__)
    sources = []
    for name in MODULES:
        with open(os.path.join(folder, f"{name}.py"), encoding="utf-8") as file:
            sources.append((name, file.read()))
    return f"PACKAGE = {_PACKAGE!r}\nSOURCES = {sources!r}\n{_LOADER}".encode()
