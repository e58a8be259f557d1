"""What a verb that is interrupted before its end exits with."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.posix.ports import participants_by_domain
from tests.support.ros_domain import ros_domain
from tests.support.verbs import TIMEOUT_S
from tests.support.waiting import wait_until

STRING = "std_msgs/msg/String"
WAITING = [
    f"topic pub /a {STRING} --once",
    f"topic pub /a {STRING} --times 3",
    f"topic pub /a {STRING} -w 1",
    f"topic echo /a {STRING} --once",
    f"topic echo /a {STRING} --timeout 600",
    "topic hz /a --for 600",
    "topic bw /a --for 600",
    "service call /a std_srvs/srv/Trigger",
    "service echo /a std_srvs/srv/Trigger --timeout 600",
    "param set /a b 1 --timeout 600",
]
ENDLESS = [
    f"topic pub /a {STRING}",
    f"topic echo /a {STRING}",
    "topic hz /a",
    "service echo /a std_srvs/srv/Trigger",
]
READY = ("Waiting for at least 1 matching", "publisher: beginning loop")
# Those with an end of their own are not done; for the others, this is the end.
CASES = [(line, 130) for line in WAITING] + [(line, 0) for line in ENDLESS]


@pytest.mark.parametrize(
    ("line", "code"),
    [
        pytest.param(
            line,
            code,
            id=line,
            marks=() if line in (WAITING[0], ENDLESS[0]) else pytest.mark.thorough,
        )
        for line, code in CASES
    ],
)
def test_a_verb_that_is_interrupted_before_its_end(tmp_path: Path, line: str, code: int):
    command = [sys.executable, "-m", "launcher", *line.split()]
    with ros_domain(tmp_path) as env:
        domain_id = int(env["ROS_DOMAIN_ID"])
        with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True) as verb:
            try:
                if line.startswith("topic pub"):  # before, it is not ready to publish
                    assert verb.stdout is not None
                    assert any(one.startswith(READY) for one in iter(verb.stdout.readline, ""))
                else:
                    wait_until(lambda: participants_by_domain()[domain_id], "it is in the domain")
                verb.send_signal(signal.SIGINT)
                verb.communicate(timeout=TIMEOUT_S)
            finally:
                verb.kill()
    assert verb.returncode == code
