"""Execution: a program becomes a process, which leads a session of its own.

By `posix_spawn`: importing `subprocess` takes a tenth of the time to the first process. What
`posix_spawn` cannot do is left to `subprocess` all the same.
"""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Iterator, Mapping, Sequence

SHELL = "/bin/sh"
# Python ignores these two, and an ignored signal stays ignored in a child.
_BACK_TO_DEFAULT = (signal.SIGPIPE, signal.SIGXFSZ)


def execute(
    words: Sequence[str],
    *,
    env: Mapping[str, str],
    stdin: int,
    stdout: int,
    stderr: int,
    cwd: str | None = None,
    inherited: Sequence[int] = (),
) -> int:
    """The pid of a new process that runs `words`; OSError if the system refuses.

    A program without a slash is looked for in the PATH of `env`, which is complete. The process
    gets the three descriptors, each of which is above 2, and those that are `inherited`, at their
    numbers; no other that this process has. Whoever calls has to reap it. EINVAL is for words
    that no program can get.
    """
    for fd in inherited:
        os.set_inheritable(fd, True)
    try:
        return _execute(words, env, (stdin, stdout, stderr), cwd, inherited)
    except ValueError as error:  # a NUL in a word, a `=` in the name of a variable
        raise OSError(errno.EINVAL, str(error)) from error


def _execute(
    words: Sequence[str],
    env: Mapping[str, str],
    streams: tuple[int, int, int],
    cwd: str | None,
    inherited: Sequence[int],
) -> int:
    if cwd is not None:
        return _by_subprocess(words, env, streams, cwd, inherited)
    refusal: OSError | None = None
    for program in _candidates(words[0], env):
        try:
            return _spawn(program, words, env, streams)
        except NotImplementedError:  # a Python that was built for an old C library
            return _by_subprocess(words, env, streams, None, inherited)
        except (FileNotFoundError, NotADirectoryError) as error:
            refusal = refusal or error
        except OSError as error:
            # As execvp does: another folder of the PATH may have a program that can be run.
            refusal = error if refusal is None or _is_absence(refusal) else refusal
    raise refusal or FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), words[0])


def _candidates(program: str, env: Mapping[str, str]) -> Iterator[str]:
    """Where the program may be; of the folders of the PATH those that have something there."""
    if "/" in program:
        yield program
        return
    for folder in os.get_exec_path(env):
        path = os.path.join(folder, program)
        if os.path.lexists(path):
            yield path


def _is_absence(error: OSError) -> bool:
    return error.errno in (errno.ENOENT, errno.ENOTDIR)


def _spawn(
    program: str, words: Sequence[str], env: Mapping[str, str], streams: tuple[int, int, int]
) -> int:
    return os.posix_spawn(
        program,
        tuple(words),
        env,
        file_actions=[(os.POSIX_SPAWN_DUP2, fd, number) for number, fd in enumerate(streams)],
        setsid=True,
        setsigdef=_BACK_TO_DEFAULT,
    )


def _by_subprocess(
    words: Sequence[str],
    env: Mapping[str, str],
    streams: tuple[int, int, int],
    cwd: str | None,
    inherited: Sequence[int],
) -> int:
    """The same in another working directory, or without the system's `posix_spawn`."""
    import subprocess

    stdin, stdout, stderr = streams
    popen = subprocess.Popen(
        words,
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        env=env,
        cwd=cwd,
        pass_fds=inherited,
        start_new_session=True,
    )
    popen.returncode = 0  # it is reaped by its pidfd: Popen must not wait for it
    return popen.pid


def keep_to_ourselves(first: int = 3) -> None:
    """Let no process inherit the descriptors that we inherited; what Python opens, none does."""
    for name in os.listdir("/proc/self/fd"):
        fd = int(name)
        try:
            if fd >= first and os.get_inheritable(fd):
                os.set_inheritable(fd, False)
        except OSError:
            continue  # the one that the list was read through


def reap(pidfd: int) -> tuple[int, bool]:
    """(return code, whether it left a core dump) of a process that has ended; waits if not.

    The return code is negative for a signal.
    """
    end = os.waitid(os.P_PIDFD, pidfd, os.WEXITED)
    assert end is not None
    code = end.si_status if end.si_code == os.CLD_EXITED else -end.si_status
    return code, end.si_code == os.CLD_DUMPED
