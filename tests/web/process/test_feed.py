"""What the server tells a page, and how it lives and ends with the run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from launcher.posix import proc
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, get, server_of
from tests.web.process.conftest import Start

pytestmark = pytest.mark.thorough


def test_lines_have_numbers_and_none_is_told_twice(start: Start, sleeper: Path):
    run, link = start(sleeper)
    for number in range(20):
        run.ask("send", "cat", text=f"line {number}")
    with PageClient(link) as page:
        page.open()
        wait_until(lambda: [row[4] for row in page.lines()][-1:] == ["line 19"], "20 lines")
        first = page.of("lines")[0]["first"]
        last = first + len(page.lines()) - 1
        server = page.of("hello")[0]["server"]

    run.ask("send", "cat", text="while nobody looks")
    with PageClient(link) as page:
        assert page.ask("open", key=page.key, after=last, server=server)["ok"]
        wait_until(lambda: page.lines(), "the line")
        assert [row[4] for row in page.lines()] == ["while nobody looks"]
        older = page.ask("older", before=last + 1, count=3)["result"]
        assert older["first"] == last - 2
        assert [row[4] for row in older["lines"]][-1] == "line 19"
    with PageClient(link) as page:  # of another server: everything again
        assert page.ask("open", key=page.key, after=last, server="other")["ok"]
        wait_until(lambda: len(page.lines()) > last, "all lines")


def test_processes_come_with_their_history_and_last_error(start: Start, sleeper: Path):
    run, link = start(sleeper)
    run.ask("send", "cat", text="[ERROR] [1.0] [cat]: <b>no</b>")
    with PageClient(link) as page:
        page.open()
        wait_until(lambda: len(page.of("processes")) > 3, "processes")
        (row,) = page.of("processes")[-1]["processes"]
        assert row["name"] == "cat-1" and row["state"] == "RUNNING"
        assert row["last_error"]["text"] == "[ERROR] [1.0] [cat]: <b>no</b>"
        assert page.of("history")[0]["processes"].keys() <= {"cat-1"}
        names = [entry["event"] for message in page.of("run_events") for entry in message["items"]]
        assert "started" in names
        wait_until(lambda: page.of("plan"), "the plan")
        assert page.of("plan")[-1]["processes"][0]["name"] == "cat-1"


def test_a_process_is_stopped_and_started(start: Start, sleeper: Path):
    run, link = start(sleeper)
    with PageClient(link) as page:
        page.open()
        answer = page.ask("run", verb="stop", names=["cat-1"])
        assert answer["ok"] and "stopped" in answer["text"][0]
        assert run.row("cat")["state"] == "STOPPED"
        again = page.ask("run", verb="stop", names=["cat-1"])
        assert again["error"]["code"] == "wrong-state"
        assert page.ask("run", verb="start", names=["cat-1"])["ok"]
        unknown = page.ask("run", verb="stop", names=["dog"])
        assert unknown["error"]["code"] == "unknown-name" and unknown["error"]["hint"]


@pytest.fixture
def slow(tmp_path: Path) -> Path:
    """A launch file with a process that ends when it was stopped and the file `go` is there."""
    path = tmp_path / "slow.launch.py"
    wait = f"until test -e {tmp_path}/go; do sleep 0.02; done"
    script = f"trap '{wait}; exit 0' INT; echo ready; while :; do sleep 0.1; done"
    path.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n\n\n"
        "def generate_launch_description():\n"
        f"    cmd = ['sh', '-c', {script!r}]\n"
        "    return LaunchDescription([ExecuteProcess(\n"
        "        cmd=cmd, name='slow', output='screen', sigterm_timeout='600')])\n"
    )
    return path


def asked(run: ControlledRun, verb: str) -> int:
    return sum(one.get("verb") == verb for one in run.ask("events")["events"])


def connections(run: ControlledRun) -> int:
    """How many sockets the launcher holds."""
    files = proc.descriptors(run.process.pid)
    return sum(target.startswith("socket:") for _, target in files)


def test_two_pages_share_a_restart(start: Start, slow: Path):
    run, link = start(slow)
    run.wait_for("ready")
    with PageClient(link) as one, PageClient(link) as other:
        one.open()
        other.open()
        numbers = [page.send("run", verb="restart", names=["slow"]) for page in (one, other)]
        wait_until(lambda: asked(run, "restart") == 2, "both restarts wait")
        (slow.parent / "go").touch()
        answers = [page.answer(number) for page, number in zip((one, other), numbers, strict=True)]
        pids = {answer["text"][0].partition("with pid ")[2].split()[0] for answer in answers}
        assert len(pids) == 1, answers


def test_what_a_closed_page_has_asked_for_is_not_begun(start: Start, slow: Path):
    run, link = start(slow)
    run.wait_for("ready")
    with run.connect() as connection:
        before = connections(run)
        connection.send("stop", ["slow"])
        with PageClient(link) as page:
            page.open()
            page.send("run", verb="start", names=["slow"])
            wait_until(lambda: asked(run, "start"), "the start waits")
        wait_until(lambda: connections(run) <= before, "the end of the page's connection")
        (slow.parent / "go").touch()
        assert "stopped in" in connection.read(60)["text"][0]
    assert run.row("slow")["state"] == "STOPPED"


def test_the_end_is_told_and_nothing_is_left(start: Start, sleeper: Path):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    assert server is not None
    with PageClient(link) as page:
        page.open()
        run.process.send_signal(signal.SIGINT)
        wait_until(lambda: page.of("ended"), "the end")
        assert page.of("ended")[0]["how"] == "ended"
        assert [row["state"] for row in page.of("processes")[-1]["processes"]] == ["STOPPED"]
        assert run.exit_code() == 0
    assert not psutil.pid_exists(server)


def test_a_killed_launcher_is_told_and_the_server_ends(start: Start, sleeper: Path):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    with PageClient(link) as page:
        page.open()
        run.process.send_signal(signal.SIGKILL)
        wait_until(lambda: page.of("ended"), "the end")
        assert page.of("ended")[0]["how"] == "lost"
    wait_until(lambda: not psutil.pid_exists(server), "the end of the server")


def test_a_killed_server_comes_back_with_the_same_link(start: Start, sleeper: Path):
    run, link = start(sleeper)
    first = server_of(run.process.pid)
    assert first is not None
    os.kill(first, signal.SIGKILL)

    run.wait_for("the server of the page died (signal 9)")
    wait_until(lambda: server_of(run.process.pid) not in (None, first), "another server")

    def answers() -> bool:
        try:
            return get(link)[0] == 200
        except OSError:
            return False

    wait_until(answers, "a page")
    assert run.screen.count("page: http") == 1
    assert run.row("cat")["state"] == "RUNNING"


def test_a_port_that_is_taken_is_told_once(start: Start, sleeper: Path):
    _, link = start(sleeper)
    port = link.partition("?")[0].rstrip("/").rpartition(":")[2]
    run, _ = start(sleeper)
    command = [sys.executable, "-m", "launcher", "web", "--port", port]

    answer = subprocess.run(
        command, env=run.env, capture_output=True, text=True, timeout=60, check=False
    )

    assert answer.returncode == 1
    assert f"cannot listen on 127.0.0.1 port {port}" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_the_verb_serves_a_run_until_it_ends(start: Start, sleeper: Path):
    run, _ = start(sleeper)
    command = [sys.executable, "-m", "launcher", "web", "--port", "0"]
    web = subprocess.Popen(
        command, env=run.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert web.stdout is not None
    link = web.stdout.readline().strip()
    with PageClient(link) as page:
        page.open()
        run.process.send_signal(signal.SIGINT)
        wait_until(lambda: page.of("ended"), "the end")
        assert page.of("ended")[0]["how"] == "ended"
    _, errors = web.communicate(timeout=60)
    assert web.returncode == 0
    assert "the run has ended" in errors


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_the_verb_ends_with_a_signal(start: Start, sleeper: Path, signum: signal.Signals):
    run, _ = start(sleeper)
    command = [sys.executable, "-m", "launcher", "web", "--port", "0"]
    web = subprocess.Popen(
        command, env=run.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert web.stdout is not None
    assert web.stdout.readline().startswith("http")
    web.send_signal(signum)
    _, errors = web.communicate(timeout=60)
    assert (web.returncode, errors) == (0, "")
    assert run.row("cat")["state"] == "RUNNING"


def told(page: PageClient) -> int:
    """How many lines of the flood the page knows of."""
    rows = {}  # what has come while the page was opening is told again
    for message in page.of("lines"):
        rows.update(enumerate(message["lines"], message["first"]))
    return sum(
        int(row[4].split()[0].replace(",", "")) if row[1] == "skipped" else row[0] == "flood-1"
        for row in rows.values()
    )


def test_a_flood_is_counted_and_the_last_lines_are_told(start: Start, tmp_path: Path):
    program, file = tmp_path / "flood.py", tmp_path / "flood.launch.py"
    program.write_text(
        "input()\nprint('\\n'.join(map(str, range(300000))))\ninput()\nprint('after')\n"
    )
    file.write_text(
        "import sys\n"
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n\n\n"
        "def generate_launch_description():\n"
        f"    flood = ExecuteProcess(cmd=[sys.executable, '-u', {str(program)!r}], name='flood')\n"
        "    return LaunchDescription([flood])\n"
    )
    run, link = start(file)
    with PageClient(link) as page:
        page.open()
        run.ask("send", "flood", text="go")
        wait_until(lambda: any(row[1] == "skipped" for row in page.lines()), "skipped lines")
        run.ask("send", "flood", text="go")
        wait_until(lambda: told(page) == 300_001, "all lines, read or counted")
        assert len(page.lines()) < 30_000
