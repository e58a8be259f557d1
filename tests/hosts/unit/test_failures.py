"""What messages of OpenSSH and of shells mean; the messages are recorded."""

from __future__ import annotations

import pytest

from launcher.hosts.failures import Problem, failure, no_ssh
from launcher.hosts.file.hosts_model import Host

HOST = Host(
    name="bot1",
    address="10.0.0.2",
    user="robot",
    python=".venv/bin/python",
    setup=("/opt/ros/jazzy/setup.sh",),
    ssh={"Port": "2299"},
)
CHANGED = """\
@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@
@    WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED!     @
@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@@
IT IS POSSIBLE THAT SOMEONE IS DOING SOMETHING NASTY!
Offending ED25519 key in /home/ann/.ssh/known_hosts:7
Host key for [10.0.0.2]:2299 has changed and you have requested strict checking.
Host key verification failed.
"""
UNKNOWN = """\
No ED25519 host key is known for [10.0.0.2]:2299 and you have requested strict checking.
Host key verification failed.
"""
BAD_KEY = """\
Load key "/home/ann/.ssh/fleet": bad permissions
robot@10.0.0.2: Permission denied (publickey).
"""
MISSING_KEY = """\
no such identity: /home/ann/.ssh/fleet: No such file or directory
robot@10.0.0.2: Permission denied (publickey).
"""
CASES = [
    (255, CHANGED, Problem.CHANGED_KEY, "ssh-keygen -f /home/ann/.ssh/known_hosts -R"),
    (255, UNKNOWN, Problem.UNKNOWN_KEY, "connect once"),
    (255, MISSING_KEY, Problem.DENIED, "IdentityFile"),
    (255, BAD_KEY, Problem.DENIED, "chmod 600 /home/ann/.ssh/fleet"),
    (255, "robot@h: Permission denied (publickey,password).", Problem.DENIED, "ssh-copy-id"),
    (
        255,
        "ssh: connect to host h port 1: Connection refused",
        Problem.REFUSED,
        "openssh-server",
    ),
    (255, "ssh: connect to host h port 22: Connection timed out", Problem.TIMEOUT, "firewall"),
    (255, "Connection timed out during banner exchange", Problem.TIMEOUT, "firewall"),
    (255, "ssh: connect to host h port 22: No route to host", Problem.NO_ROUTE, "network"),
    (
        255,
        "ssh: Could not resolve hostname h: Name or service unknown",
        Problem.UNKNOWN_NAME,
        "IP",
    ),
    (255, "Timeout, server 10.0.0.2 not responding.", Problem.LOST, "ssh -o Port=2299"),
    (255, "client_loop: send disconnect: Broken pipe", Problem.LOST, "try"),
    (255, "", Problem.LOST, "try"),
    (255, "command-line: line 0: Bad configuration option: prt", Problem.BAD_OPTION, "ssh_config"),
    (255, "command-line line 0: invalid time value.", Problem.BAD_OPTION, "ssh_config"),
    (127, "sh: 1: exec: ./.venv/bin/python: not found", Problem.NO_PYTHON, "hosts sync"),
    (2, ".: cannot open /opt/ros/jazzy/setup.sh: No such file", Problem.NO_SETUP, "setup:"),
    (
        1,
        "sh: line 1: /opt/ros/jazzy/setup.sh: No such file or directory",
        Problem.NO_SETUP,
        "setup:",
    ),
    (1, "/usr/bin/python3: No module named launcher", Problem.NO_LAUNCHER, "hosts sync"),
    (1, "ModuleNotFoundError: No module named 'launcher'", Problem.NO_LAUNCHER, "hosts sync"),
    (2, "error: launch file 'agent' not found", Problem.OLD_LAUNCHER, "hosts sync"),
    (1, "OSError: [Errno 28] No space left on device", Problem.NO_SPACE, "df -h"),
]


@pytest.mark.parametrize(("returncode", "stderr", "problem", "repair"), CASES)
def test_a_message_is_told_with_its_repair(
    returncode: int, stderr: str, problem: Problem, repair: str
):
    error = failure(HOST, stderr, returncode)

    assert error.problem is problem
    assert error.message.startswith("host 'bot1': ")
    assert repair in str(error.hint)


def test_a_message_that_nobody_knows_is_shown():
    assert "something odd" in failure(HOST, "first\nsomething odd\n\n", 3).message
    assert "exit code 3" in failure(HOST, "", 3).message


def test_a_key_that_is_missing_here_is_named():
    message = failure(HOST, MISSING_KEY, 255).message

    assert "there is no key '/home/ann/.ssh/fleet' on this machine" in message


@pytest.mark.parametrize(
    ("returncode", "stderr"),
    [(0, ""), (2, "ls: invalid option -- 'c'\nTry 'ls --help' for more information.\n")],
)
def test_a_program_that_is_no_python_is_told(returncode: int, stderr: str):
    error = failure(HOST, stderr, returncode)

    assert "'.venv/bin/python' there is not a Python" in error.message
    assert "`python:`" in str(error.hint)
    assert error.problem.may_pass


def test_a_shell_that_ends_without_a_message_may_be_the_reason():
    plain = Host(name="bot1", address="10.0.0.2")
    errors = [failure(host, "", 1) for host in (plain, HOST)]

    message = "host 'bot1': Python does not answer there: exit code 1"
    assert [error.message for error in errors] == [message] * 2
    assert errors[0].hint == "can the user run commands there? Try: ssh 10.0.0.2 true"
    assert str(errors[1].hint).startswith("is '.venv/bin/python' there a Python? If so: can the")


def test_no_program_ssh_is_told():
    assert "openssh-client" in str(no_ssh(HOST).hint)


@pytest.mark.parametrize("problem", [Problem.CHANGED_KEY, Problem.DENIED, Problem.NO_LAUNCHER])
def test_what_needs_a_repair_is_not_tried_again(problem: Problem):
    assert not problem.may_pass
