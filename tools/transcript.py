"""`python -m tools.transcript FILE`: replace the transcript of the ROS verbs in a Markdown file.

It starts the fleet, lifecycle nodes of the tests, and the example workspace with its action, each
in a separate domain, and runs verbs beside them.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from launcher.posix.domain_lease import leased_domain
from tests.support.workspaces import EXAMPLE, copy_sources

BEGIN, END = "<!-- transcript: made by tools/transcript.py -->\n", "<!-- end of transcript -->\n"
REPOSITORY = Path(__file__).resolve().parents[1]
LAUNCHER = (sys.executable, "-m", "launcher")
MAX_LINES = 14
WAIT_S = 60.0

FLEET = """\
topic list -t
topic info /fleet/status
topic echo /fleet/report --once
topic hz /fleet/status --for 2"""
LIFECYCLE = """\
lifecycle nodes
lifecycle list /pump
lifecycle set /pump configure
lifecycle set /pump activate
lifecycle set /pump configure"""
ACTION = """\
action send_goal -f /robot_1/execute_task fleet_interfaces/action/ExecuteTask \
'{assignment: {robot_id: robot_1, task: pick_shelf, task_id: 99}}'"""


@contextlib.contextmanager
def domain(folder: Path) -> Iterator[dict[str, str]]:
    with leased_domain() as domain_id:
        yield {
            **os.environ,
            "PYTHONPATH": str(REPOSITORY),
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder / "log"),
            "COLUMNS": "98",
        }


@contextlib.contextmanager
def beside(words: Sequence[str], env: Mapping[str, str], folder: Path, sign: str) -> Iterator[None]:
    """A program, once a topic or node is there that contains `sign`."""
    program = subprocess.Popen(
        words,
        env=dict(env),
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        deadline = time.monotonic() + WAIT_S
        while sign not in answer("topic list --include-hidden-topics", env, folder):
            if time.monotonic() > deadline:
                raise SystemExit(f"no topic {sign}")
        time.sleep(4.0)  # something to see
        yield
    finally:
        program.send_signal(signal.SIGINT)
        assert program.stdin is not None
        program.stdin.close()
        program.wait()


def answer(line: str, env: Mapping[str, str], folder: Path) -> str:
    done = subprocess.run(
        [*LAUNCHER, *shlex.split(line)],
        env=dict(env),
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=WAIT_S,
    )
    return done.stdout


def accepted(line: str, env: Mapping[str, str], folder: Path) -> str:
    """The answer when the robot, which executes one goal at a time, has room for this one."""
    deadline = time.monotonic() + WAIT_S
    while "rejected" in (found := answer(line, env, folder)) and time.monotonic() < deadline:
        pass
    return found


def session(lines: str, env: Mapping[str, str], folder: Path) -> str:
    """The commands with the beginning of what they print."""
    text = ""
    for line in lines.splitlines():
        out = accepted(line, env, folder).replace(str(folder), "~").rstrip("\n").splitlines()
        most = len(out) if "send_goal" in line else MAX_LINES
        more = [f"... ({len(out) - most} more lines)"] if len(out) > most + 1 else []
        shown = out[:most] if more else out
        text += "\n".join([f"$ launcher {line}", *shown, *more, ""]).rstrip(" ")
        text += "\n"
    return f"```\n{text.rstrip()}\n```\n"


def transcript() -> str:
    with tempfile.TemporaryDirectory(prefix="transcript-") as name:
        folder = Path(name)
        with domain(folder) as env:
            words = (*LAUNCHER, "group_gp1", "system.launch.py", "--no-console")
            with beside(words, env, folder, "/fleet/report"):
                fleet = session(FLEET, env, folder)
        with domain(folder) as env:
            words = (sys.executable, "-m", "tests.support.lifecycle_nodes")
            with beside(words, env, folder, "/pump/transition_event"):
                lifecycle = session(LIFECYCLE, env, folder)
        workspace = folder / "fleet_workspace"
        copy_sources(EXAMPLE / "src", workspace)
        subprocess.run([*LAUNCHER, "build"], cwd=workspace, check=True)
        with domain(folder) as env:
            words = (*LAUNCHER, "fleet_nodes", "fleet.launch.py", "--no-console")
            with beside(words, env, workspace, "execute_task/_action"):
                action = session(ACTION, env, workspace)
    return (
        f"Beside the fleet:\n\n{fleet}\nBeside a lifecycle node:\n\n{lifecycle}\n"
        f"In the example workspace, beside its fleet:\n\n{action}"
    )


def main() -> None:
    path = Path(sys.argv[1])
    before, _, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    path.write_text(f"{before}{BEGIN}\n{transcript()}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
