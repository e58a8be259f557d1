"""Starts processes, each the leader of its own session, and holds their descriptors.

By `posix_spawn`, since importing `subprocess` takes a tenth of the time to the first process;
`subprocess` (see `popen`) is used only for a working directory, which `posix_spawn` cannot set.
"""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence

from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec
from launcher.posix import dispositions

# Reserved descriptors: without them a run with too many processes could neither import a module nor
# read /proc any more, instead of failing to start one process.
FOR_PROCESSES = 16  # not used by the streams of processes
FOR_FILES = 8  # not used by log files either


_for_child: Callable[[tuple[int, int, int]], contextlib.AbstractContextManager[Sequence[int]]] = (
    contextlib.nullcontext
)


def most_open_files(used: int) -> int:
    """How many descriptors this process may have; more from now on if half of them are used."""
    global _for_child
    soft = os.sysconf("SC_OPEN_MAX")
    if soft < 0:
        return sys.maxsize
    if 2 * used <= soft:
        return soft
    from launcher.posix import open_files

    _for_child = open_files.for_child
    return open_files.raise_limit()


def keep_free(fd: int, reserve: int) -> int:
    """Return `fd`, which was just opened; OSError (EMFILE) if it is one of the last `reserve`.

    The kernel uses the lowest free number, so a high one means that few are left. The descriptor
    stays open in either case.
    """
    if most_open_files(fd) <= fd + reserve:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    return fd


# Pids of children that somebody here reaps; every other child of ours is an adopted orphan.
started: set[int] = set()

SHELL = "/bin/sh"


def execute(
    words: Sequence[str],
    *,
    env: Mapping[str, str],
    streams: tuple[int, int, int],
    cwd: str | None = None,
    inherited: Sequence[int] = (),
) -> int:
    """The pid of a new process that runs `words`, for the caller to reap; OSError.

    A program without a slash is searched in the PATH of `env`, which is the whole environment. The
    process gets `streams`, all above 2, as its standard streams, and the descriptors `inherited`
    under their numbers; no others. It ignores and blocks no signal, and has the limit of open files
    that we were started with. EINVAL: a word or variable has a NUL.
    """
    for fd in inherited:
        os.set_inheritable(fd, True)
    pid = None
    try:
        if cwd is None:
            with contextlib.suppress(NotImplementedError):  # Python was built for an old C library
                pid = _by_posix_spawn(words, env, streams)
        if pid is None:
            from launcher.posix.popen import by_subprocess  # few need it

            pid = by_subprocess(words, env, streams, cwd, inherited)
    except ValueError as error:  # a NUL in a word, a `=` in the name of a variable
        raise OSError(errno.EINVAL, str(error)) from error
    started.add(pid)
    return pid


def _by_posix_spawn(
    words: Sequence[str], env: Mapping[str, str], streams: tuple[int, int, int]
) -> int:
    refusal: OSError | None = None
    with _for_child(streams) as numbers:
        actions = [(os.POSIX_SPAWN_DUP2, fd, number) for number, fd in enumerate(numbers)]
        for program in _candidates(words[0], env):
            try:
                return os.posix_spawn(
                    program,
                    tuple(words),
                    env,
                    file_actions=actions,
                    setsid=True,
                    setsigmask=(),
                    setsigdef=dispositions.EVERY,
                )
            except OSError as error:
                # As execvp: a later folder of the PATH may have an executable program.
                is_new = refusal is None or (_is_absence(refusal) and not _is_absence(error))
                refusal = error if is_new else refusal
    raise refusal or FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), words[0])


def _candidates(program: str, env: Mapping[str, str]) -> Iterator[str]:
    """Paths of the program in the folders of the PATH where it exists."""
    if "/" in program:
        yield program
        return
    for folder in os.get_exec_path(env):
        path = os.path.join(folder, program)
        if os.path.lexists(path):
            yield path


def is_plain(spec: ProcessSpec) -> bool:
    """Whether the program can certainly be executed; false where that is still to be found out."""
    program = spec.argv[0]
    if spec.cwd is not None or spec.shell:
        return spec.cwd is None
    if spec.ros is not None and spec.ros.package and program.endswith(f"/{spec.ros.executable}"):
        return True  # it was looked for in its package
    path = next(_candidates(program, spec.env), program)
    if not (os.path.isfile(path) and os.access(path, os.X_OK)):
        return False
    try:
        with open(path, "rb", buffering=0) as file:
            return file.read(4) == b"\x7fELF"
    except OSError:
        return False


def _is_absence(error: OSError) -> bool:
    return error.errno in (errno.ENOENT, errno.ENOTDIR)


def set_close_on_exec(first: int = 3) -> None:
    """Set close-on-exec for descriptors that we inherited; Python sets it for those it opens."""
    for name in os.listdir("/proc/self/fd"):
        fd = int(name)
        try:
            if fd >= first and os.get_inheritable(fd):
                os.set_inheritable(fd, False)
        except OSError:
            continue  # the descriptor of listdir


def reap(pidfd: int) -> tuple[int, bool]:
    """(return code, whether it left a core dump) of a process; waits for its exit.

    The return code is negative for a signal.
    """
    end = os.waitid(os.P_PIDFD, pidfd, os.WEXITED)
    assert end is not None
    started.discard(end.si_pid)
    code = end.si_status if end.si_code == os.CLD_EXITED else -end.si_status
    return code, end.si_code == os.CLD_DUMPED


READ_BYTES = 64 * 1024  # the capacity of a pipe: one read empties it
_buffers: list[bytearray] = []  # for reads, one for each thread that reads
_LARGE_BYTES = 1024 * 1024  # a flood takes and frees less than that for each read
_has_flooded = False


def read_stream(fd: int) -> bytes | None:
    """Read once: b"" at EOF, None if there is nothing yet, or (-1) if it is on another host.

    What was read is copied to memory of exactly its size. A line that is cut from a block of
    READ_BYTES would stay where that was: the next block does not fit in what is free behind a line
    that is kept, so that the heap grows with all that is written.
    """
    if fd < 0:
        return None
    global _has_flooded
    buffer = _buffers.pop() if _buffers else bytearray(READ_BYTES)
    try:
        size = os.readv(fd, (buffer,))
        if size == READ_BYTES and not _has_flooded:
            _has_flooded = True
            bytes(_LARGE_BYTES)  # as `allocator`, whose import may fail here
        return bytes(memoryview(buffer)[:size])
    except BlockingIOError:
        return None
    except OSError:
        return b""  # a pseudo-terminal ends with EIO
    finally:
        _buffers.append(buffer)


STDOUT, STDERR, BOTH = "stdout", "stderr", "both"


class Child:
    """A process that is running or has just exited; owns its descriptors.

    `streams` maps the descriptors of its output to `stdout`, `stderr`, or `both` if one descriptor
    carries both in the order of writing. The child leads its own session and process group, so
    that signals reach its children too and the terminal's Ctrl-C reaches only us. `status` is -1,
    or for a process with limits readable after exec, or after a failure (see `refusal`).
    """

    def __init__(
        self, pid: int, streams: dict[int, str], pidfd: int, stdin: int, status: int
    ) -> None:
        self.pid = pid  # also the id of its process group and session
        self.streams = streams
        self.pidfd = pidfd
        self.status = status
        self.refusal = b""
        self.stdin = stdin  # our end of its standard input; -1 if that is closed

    def signal_group(self, signum: int) -> None:
        """Signal the process group.

        No error if the group is gone or belongs to another user (sudo): a process that does not
        exit is reported by its pid.
        """
        try:
            os.killpg(self.pid, signum)
        except (ProcessLookupError, PermissionError):
            return

    def reap(self) -> tuple[int, bool]:
        """As `reap`; call it when the pidfd is readable."""
        return reap(self.pidfd)

    def resize(self, terminal_size: tuple[int, int]) -> None:
        """Resize its pseudo-terminals, if it has any."""
        terminals = [fd for fd in self.streams if os.isatty(fd)]
        if terminals:
            from launcher.posix.pseudo_terminals import set_size

            for fd in terminals:
                set_size(fd, terminal_size)
            # Its session has no controlling terminal, so the kernel sends no signal.
            self.signal_group(signal.SIGWINCH)

    def write_stdin(self, data: bytes) -> int:
        """Write to its standard input; the number of bytes. OSError if it does not read."""
        return os.write(self.stdin, data)

    def read_refusal(self) -> None:
        """Read why exec or a limit failed, empty if not; call it when `status` is readable."""
        with contextlib.suppress(ConnectionResetError):  # killed before it got the word to begin
            self.refusal = os.read(self.status, READ_BYTES)
        os.close(self.status)
        self.status = -1

    def give_streams(self) -> list[int]:
        """Its streams, which belong to the caller from now on."""
        fds = list(self.streams)
        self.streams.clear()
        return fds

    def close_stream(self, fd: int) -> None:
        if self.streams.pop(fd, None) is not None:
            os.close(fd)

    def close(self) -> None:
        for fd in list(self.streams):
            self.close_stream(fd)
        for name in ("pidfd", "stdin", "status"):
            fd = getattr(self, name)
            if fd >= 0:
                setattr(self, name, -1)
                os.close(fd)


class StartSettings(Record):
    """How a process is started, beside its spec.

    `env` is complete. `merge` gives stdout and stderr one descriptor, which keeps their order.
    `terminal_size` is (columns, rows) of the pseudo-terminal that `emulate_tty` asks for.
    """

    env: Mapping[str, str]
    merge: bool
    terminal_size: tuple[int, int] | None = None


class Streams:
    """The streams of a process: `ours` as `Child.streams`, and `stdin`; `standard` are its own."""

    __slots__ = ("ours", "standard", "stdin", "theirs")

    def __init__(self) -> None:
        self.ours: dict[int, str] = {}
        self.theirs: list[int] = []
        self.stdin = -1
        self.standard = (-1, -1, -1)

    def close_ours(self) -> None:
        for fd in self.ours:
            os.close(fd)
        if self.stdin >= 0:
            os.close(self.stdin)

    def close_theirs(self) -> None:
        for fd in self.theirs:
            os.close(fd)
        self.theirs = []


def open_streams(spec: ProcessSpec, settings: StartSettings) -> Streams:
    """Open pipes or pseudo-terminals, for the caller to close; OSError."""
    streams = Streams()
    if spec.emulate_tty:
        from launcher.posix import pseudo_terminals  # most processes write to pipes
    open_pair = pseudo_terminals.open_pair if spec.emulate_tty else os.pipe
    try:
        for name in (BOTH,) if settings.merge else (STDOUT, STDERR):
            read_end, write_end = open_pair()
            streams.ours[read_end] = name
            streams.theirs.append(write_end)
            os.set_blocking(read_end, False)
            if spec.emulate_tty and settings.terminal_size is not None:
                pseudo_terminals.set_size(write_end, settings.terminal_size)
        stdin, streams.stdin = _socket_pair() if spec.members else os.pipe()
        streams.standard = (stdin, streams.theirs[0], streams.theirs[-1])
        streams.theirs.append(stdin)
        os.set_blocking(streams.stdin, False)
    except BaseException:
        streams.close_ours()
        streams.close_theirs()
        raise
    return streams


def start(spec: ProcessSpec, settings: StartSettings) -> Child:
    """Start a process; OSError if the system refuses."""
    streams, status = open_streams(spec, settings), -1
    try:
        command, inherited = _command(spec), tuple[int, ...]()
        if spec.limits is not None:
            from launcher.posix.limits import command_prefix

            status, write_end = os.pipe()
            streams.theirs.append(write_end)
            inherited = (write_end,)
            command = (*command_prefix(spec.limits, write_end, settings.env), *command)
        keep_free(max(*streams.theirs, *streams.ours, streams.stdin, status), FOR_PROCESSES)
        pid = execute(
            command,
            env=settings.env,
            streams=streams.standard,
            cwd=spec.cwd,
            inherited=inherited,
        )
        return Child(pid, streams.ours, _pidfd_of(pid), streams.stdin, status)
    except BaseException:
        streams.close_ours()
        if status >= 0:
            os.close(status)
        raise
    finally:
        streams.close_theirs()


def _pidfd_of(pid: int) -> int:
    """The pidfd of a new child; kills the child and raises OSError if there is none."""
    try:
        return os.pidfd_open(pid)
    except OSError:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        raise


def _command(spec: ProcessSpec) -> tuple[str, ...]:
    return (SHELL, "-c", " ".join(spec.argv)) if spec.shell else spec.argv


def _socket_pair() -> tuple[int, int]:
    """(theirs, ours): of a process with members, which carries messages in both directions."""
    import _socket  # nearly all processes have a pipe

    kind = _socket.SOCK_SEQPACKET | _socket.SOCK_CLOEXEC
    theirs, ours = _socket.socketpair(_socket.AF_UNIX, kind)
    return theirs.detach(), ours.detach()
