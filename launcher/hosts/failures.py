"""What the error messages of OpenSSH, and of the shell of a host, mean, and the repair."""

from __future__ import annotations

import enum
import re
import shlex
from collections.abc import Callable, Mapping

from launcher.base.errors import LauncherError
from launcher.hosts.file.hosts_model import DEFAULT_PYTHON, Host
from launcher.hosts.ssh import host_python, in_home, quoted

SSH_FAILED = 255  # the exit code of ssh for its errors
NOT_FOUND = 127  # that of a shell for a program that is not there


class Problem(enum.Enum):
    """Why a session with a host failed."""

    UNKNOWN_NAME = "unknown name"
    NO_ROUTE = "no route"
    REFUSED = "refused"
    TIMEOUT = "timeout"
    LOST = "lost"  # the connection broke, or was closed by the other side
    UNKNOWN_KEY = "unknown host key"
    CHANGED_KEY = "changed host key"
    DENIED = "permission denied"
    BAD_OPTION = "bad option"
    NO_SSH = "no ssh"  # on this machine
    NO_SETUP = "no setup file"
    NO_PYTHON = "no python"
    NO_LAUNCHER = "no launcher"
    OLD_LAUNCHER = "old launcher"
    NO_SPACE = "no space"
    OTHER = "other"

    @property
    def may_pass(self) -> bool:
        """Whether a later attempt may succeed without anybody's doing."""
        return self in _TEMPORARY


_TEMPORARY = frozenset(
    [
        Problem.UNKNOWN_NAME,
        Problem.NO_ROUTE,
        Problem.REFUSED,
        Problem.TIMEOUT,
        Problem.LOST,
        Problem.NO_SPACE,
        Problem.OTHER,
    ]
)


class HostError(LauncherError):
    """A host cannot be used; `problem` says why."""

    def __init__(
        self, host: Host, problem: Problem, message: str, *, hint: str | None = None
    ) -> None:
        super().__init__(f"host '{host.name}': {message}", hint=hint, where=host.where or None)
        self.cause = f"{message}; {hint}" if hint else message  # for one line
        self.host = host
        self.problem = problem


# The first that matches is it: what is certain comes before its consequences.
_PATTERNS: tuple[tuple[Problem, str], ...] = (
    (Problem.CHANGED_KEY, r"HOST IDENTIFICATION HAS CHANGED|Host key for .* has changed"),
    (Problem.UNKNOWN_KEY, r"Host key verification failed|No \S+ host key is known"),
    (
        Problem.BAD_OPTION,
        r"Bad configuration option|keyword .* extra arguments|command-line:? line",
    ),
    (Problem.DENIED, r"Permission denied \(|Too many authentication failures|bad permissions"),
    (Problem.UNKNOWN_NAME, r"Could not resolve hostname"),
    (Problem.NO_ROUTE, r"No route to host|Network is unreachable|Host is unreachable"),
    (Problem.REFUSED, r"Connection refused"),
    (Problem.TIMEOUT, r"Connection timed out|Operation timed out|timed out during banner"),
    (
        Problem.LOST,
        r"Timeout, server .* not responding|Broken pipe|Connection reset|Connection closed"
        r"|Connection to .* closed by remote host|kex_exchange_identification"
        r"|Session open refused|mux_client",
    ),
    (Problem.NO_LAUNCHER, r"No module named '?launcher(\.__main__)?'?( |;|$)"),
    (Problem.OLD_LAUNCHER, r"launch file 'agent' not found|unknown option '--resume'"),
    (Problem.NO_SPACE, r"No space left on device|Disk quota exceeded"),
)


# Of a program that takes other options than Python.
_FOREIGN_OPTION = re.compile(r"(invalid|unrecognized|illegal) option")


def problem_of(stderr: str, returncode: int | None, host: Host) -> Problem:
    """What the messages of ssh, or of the shell there, mean."""
    for problem, pattern in _PATTERNS:
        if re.search(pattern, stderr, re.MULTILINE):
            return problem
    if returncode in (126, NOT_FOUND) or f"{host_python(host)}: not found" in stderr:
        return Problem.NO_PYTHON
    if _missing_setup(stderr, host) is not None:
        return Problem.NO_SETUP
    return Problem.LOST if returncode == SSH_FAILED and not stderr.strip() else Problem.OTHER


def failure(host: Host, stderr: str, returncode: int | None) -> HostError:
    """The error for a session that has failed, with its repair."""
    problem = problem_of(stderr, returncode, host)
    writer = _TEXTS.get(problem)
    if writer is not None:
        message, hint = writer(host, stderr)
        return HostError(host, problem, message, hint=hint)
    if returncode != SSH_FAILED and (not stderr.strip() or _FOREIGN_OPTION.search(stderr)):
        return _no_answer(host, problem, stderr, returncode)
    return HostError(host, problem, last_line(stderr) or "ssh failed")


def _no_answer(host: Host, problem: Problem, stderr: str, returncode: int | None) -> HostError:
    """What runs there does not do what Python does."""
    how = last_line(stderr) or f"exit code {returncode}"
    is_named = host.python != DEFAULT_PYTHON
    if is_named and (returncode == 0 or stderr.strip()):
        message = f"'{host.python}' there is not a Python: {how}"
        return HostError(host, problem, message, hint="correct `python:` in the hosts file")
    hint = f"can the user run commands there? Try: {_try(host)} true"
    if is_named:
        hint = f"is '{host.python}' there a Python? If so: {hint}"
    return HostError(host, problem, f"Python does not answer there: {how}", hint=hint)


def no_ssh(host: Host) -> HostError:
    """There is no program `ssh` on this machine."""
    hint = "install OpenSSH's client (Debian: apt install openssh-client)"
    return HostError(host, Problem.NO_SSH, "there is no program 'ssh' on this machine", hint=hint)


def last_line(stderr: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in stderr.splitlines() if line.strip(" \t\r@")]
    return lines[-1] if lines else ""


def _port(host: Host) -> str:
    return next((str(v) for k, v in host.ssh.items() if k.lower() == "port"), "")


def _where(host: Host) -> str:
    port = _port(host)
    return f"'{host.address}'" + (f" port {port}" if port else "")


def _try(host: Host, *options: str) -> str:
    """A command for the user to try."""
    own = [word for name, value in host.ssh.items() for word in ("-o", f"{name}={value}")]
    target = f"{host.user}@{host.address}" if host.user else host.address
    return quoted(["ssh", *own, *options, target])


def _changed_key(host: Host, stderr: str) -> tuple[str, str]:
    match = re.search(r"Offending \S+ key in (.+?):(\d+)", stderr)
    place = f" (line {match[2]} of {match[1]})" if match else ""
    file = f"-f {shlex.quote(match[1])} " if match else ""
    port = _port(host)
    name = f"[{host.address}]:{port}" if port not in ("", "22") else host.address
    return (
        f"its host key has changed{place}: it is another machine or was installed anew, or"
        " somebody intercepts the connection",
        f"if you know why, remove the old key (ssh-keygen {file}-R {shlex.quote(name)}), then"
        f" connect once and compare the new one: {_try(host)}",
    )


def _denied(host: Host, stderr: str) -> tuple[str, str]:
    unusable = re.search(r'(?:Load key "([^"]+)": (.+?)\r?$)', stderr, re.MULTILINE)
    if unusable:
        return (
            f"the key '{unusable[1]}' cannot be used: {unusable[2]}",
            f"chmod 600 {shlex.quote(unusable[1])}"
            if "permissions" in unusable[2]
            else "name the file of the private key in `ssh: {IdentityFile: ...}`",
        )
    missing = re.search(r"no such identity: (.+): No such file", stderr)
    if missing:
        return (
            f"login was refused, and there is no key '{missing[1]}' on this machine",
            "correct `ssh: {IdentityFile: ...}` in the hosts file, or ~/.ssh/config",
        )
    methods = re.search(r"Permission denied \(([^)]*)\)", stderr)
    offered = f" (the host accepts: {methods[1]})" if methods else ""
    user = host.user or "your user name"
    return (
        f"login as {user} was refused{offered}",
        f"the user, or the key, is wrong: try {_try(host)}; copy a key there with ssh-copy-id, and"
        " name it in `ssh: {IdentityFile: ...}` of the hosts file; a key with a passphrase must be"
        " in ssh-agent, since nobody is asked",
    )


def _missing_setup(stderr: str, host: Host) -> str | None:
    for path in host.setup:
        place = re.escape(in_home(path))
        if re.search(rf"(cannot open|can't open) '?{place}|{place}: No such file", stderr):
            return path
    return None


def _no_setup(host: Host, stderr: str) -> tuple[str, str]:
    return (
        f"there is no setup file '{_missing_setup(stderr, host)}'",
        "correct `setup:` in the hosts file; paths are absolute, or relative to the user's home",
    )


def _no_python(host: Host, stderr: str) -> tuple[str, str]:
    return (
        f"there is no Python '{host.python}'",
        "python -m launcher hosts sync brings the launcher, with an environment; or set `python:`"
        " or `venv:` in the hosts file, absolute or relative to the user's home",
    )


def _no_launcher(host: Host, stderr: str) -> tuple[str, str]:
    return (
        f"its Python '{host.python}' does not have the launcher",
        "install it there (python -m launcher hosts sync), or set `python:` in the hosts file",
    )


def _simple(message: str, hint: str) -> Writer:
    def write(host: Host, stderr: str) -> tuple[str, str]:
        values = {"where": _where(host), "try": _try(host), "last": last_line(stderr)}
        return message.format(**values), hint.format(**values)

    return write


Writer = Callable[[Host, str], tuple[str, str]]


_TEXTS: Mapping[Problem, Writer] = {
    Problem.UNKNOWN_NAME: _simple(
        "the name of its address cannot be resolved",
        "correct `address:` in the hosts file, or use the IP address",
    ),
    Problem.NO_ROUTE: _simple(
        "there is no route to {where}",
        "is it switched on, and in this network? Try: {try}",
    ),
    Problem.REFUSED: _simple(
        "{where} refuses connections",
        "it is up, but no ssh server listens there: install and start openssh-server, or correct"
        " `ssh: {{Port: ...}}` in the hosts file",
    ),
    Problem.TIMEOUT: _simple(
        "{where} does not answer",
        "is it switched on, in this network, and open in its firewall? Try: {try}",
    ),
    Problem.LOST: _simple("the connection was lost: {last}", "try: {try}"),
    Problem.UNKNOWN_KEY: _simple(
        "its host key is not known",
        "connect once and compare the key: {try}",
    ),
    Problem.CHANGED_KEY: _changed_key,
    Problem.DENIED: _denied,
    Problem.BAD_OPTION: _simple(
        "ssh does not accept an option: {last}",
        "correct `ssh:` in the hosts file; ssh_config(5) lists the options",
    ),
    Problem.NO_SETUP: _no_setup,
    Problem.NO_PYTHON: _no_python,
    Problem.NO_LAUNCHER: _no_launcher,
    Problem.OLD_LAUNCHER: _simple(
        "its launcher is too old to serve as an agent",
        "bring the same version there: python -m launcher hosts sync",
    ),
    Problem.NO_SPACE: _simple("its disk is full: {last}", "remove files there: {try} df -h"),
}
