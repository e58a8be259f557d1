"""What messages of OpenSSH and of shells mean; the messages are recorded."""

from __future__ import annotations

import pytest

from launcher.hosts.failures import Problem, failure, no_ssh
from launcher.hosts.model import Host

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
CASES = [
    (255, CHANGED, Problem.CHANGED_KEY, "ssh-keygen -f /home/ann/.ssh/known_hosts -R"),
    (255, UNKNOWN, Problem.UNKNOWN_KEY, "connect once"),
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


def test_no_program_ssh_is_told():
    assert "openssh-client" in str(no_ssh(HOST).hint)


@pytest.mark.parametrize("problem", [Problem.CHANGED_KEY, Problem.DENIED, Problem.NO_LAUNCHER])
def test_what_needs_a_repair_is_not_tried_again(problem: Problem):
    assert not problem.may_pass
