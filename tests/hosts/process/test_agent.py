"""`launcher agent` and the link to it, through pipes instead of ssh."""

from __future__ import annotations

import os
import shlex
import signal
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from launcher.base.model.spec import Limits, RestartMode, RestartPolicy, StopPolicy
from launcher.hosts.engine.link import LinkState
from launcher.hosts.file.hosts_model import Host, LinkPolicy
from launcher.hosts.file.order import SentFile
from launcher.run.processes.machine_events import (
    Exited,
    MachineCommand,
    ProcessState,
    SignalSent,
    SpawnError,
)
from tests.support.children import is_alive
from tests.support.link_recorder import AGENT, RELAYED, Recorder, python
from tests.support.waiting import wait_until

pytestmark = pytest.mark.usefixtures("patient")

SLEEP = "print('up'); import time; time.sleep(600)"
KEEP = LinkPolicy(stop_after_s=None)


def host(stop_after_s: float | None = None) -> Host:
    return Host(name="bot1", address="here", on_link_loss=LinkPolicy(stop_after_s=stop_after_s))


@pytest.fixture
def recorder() -> Iterator[Recorder]:
    with Recorder() as recorder:
        yield recorder.ready()


def agent_pid(recorder: Recorder) -> int:
    """The parent of the first process."""
    recorder.until(lambda: recorder.pid(1), "it runs")
    return psutil.Process(recorder.pid(1)).ppid()


def is_gone(pid: int) -> bool:
    return not is_alive(pid)


# ---- processes


def test_a_process_runs_and_its_exit_is_reported(recorder: Recorder):
    recorder.start(1, python("print('hello'); raise SystemExit(3)"))

    recorder.until(lambda: recorder.exits(), "it exits")

    assert recorder.text() == b"hello\n"
    assert [type(event) for _, event, _, _ in recorder.events] == [
        MachineCommand,
        MachineCommand,
        Exited,
    ]
    assert recorder.exits() == [3]
    assert recorder.replicas[1].state is ProcessState.EXITED
    assert recorder.finish() == ([], False)


def test_streams_are_told_apart_or_keep_their_order(recorder: Recorder):
    code = "import os\nfor i in range(500): os.write(1 + i % 2, b'%d\\n' % i)"

    recorder.start(1, python(code))
    recorder.start(2, python(code, merge=True))
    recorder.until(lambda: recorder.exits(1) and recorder.exits(2), "both exit")

    assert {stream for number, stream, _, _ in recorder.blocks if number == 1} == {
        "stdout",
        "stderr",
    }
    assert recorder.text(2) == b"".join(b"%d\n" % i for i in range(500))


def test_all_output_comes_before_the_exit(recorder: Recorder):
    recorder.start(1, python("import os; os.write(1, b'x' * 60000)"))

    recorder.until(lambda: recorder.exits(), "it exits")

    assert len(recorder.text()) == 60000


def test_silence_is_told_after_what_is_not_finished(recorder: Recorder):
    code = """
import time
for text in ("a line\\n", "name? ", "Traceback (most recent call last):\\n  File\\n"):
    print(text, end="", flush=True)
    input()
"""
    recorder.start(1, python(code))
    recorder.until(lambda: recorder.text() == b"a line\n", "a line")
    recorder.link.write_stdin(1, b"\n")
    recorder.until(lambda: recorder.blocks[-1][2] == b"", "silence")
    recorder.link.write_stdin(1, b"\n")
    recorder.until(lambda: recorder.blocks[-1][2] == b"" and b"File" in recorder.text(), "silence")

    blocks = [data for _, _, data, _ in recorder.blocks]
    assert blocks[:3] == [b"a line\n", b"name? ", b""]
    assert b"" not in blocks[3:-1]


def test_standard_input_and_a_pseudo_terminal(recorder: Recorder):
    recorder.start(
        1, python("print(input()); import sys; print(sys.stdout.isatty())", emulate_tty=True)
    )
    recorder.until(lambda: recorder.pid(), "it runs")
    recorder.link.write_stdin(1, b"hello\n")

    recorder.until(lambda: recorder.exits(), "it exits")

    assert recorder.text() == b"hello\nTrue\n"


def test_a_process_is_stopped_step_by_step_on_the_host(recorder: Recorder):
    stubborn = "import signal; signal.signal(2, signal.SIG_IGN); " + SLEEP
    recorder.start(1, python(stubborn, stop=StopPolicy(sigterm_timeout_s=0.2)))
    recorder.until(lambda: recorder.text(), "it is up")

    recorder.link.command(1, MachineCommand.STOP)
    recorder.until(lambda: recorder.exits(), "it exits")

    assert recorder.exits() == [-signal.SIGTERM]
    assert MachineCommand.TICK in [event for _, event, _, _ in recorder.events]
    assert recorder.replicas[1].state is ProcessState.STOPPED


def test_a_restart_is_decided_by_the_host(recorder: Recorder):
    policy = RestartPolicy(mode=RestartMode.ALWAYS, delay_s=0.05, max_restarts=2, jitter=0.5)
    recorder.start(1, python("print('again')", restart=policy))

    recorder.until(lambda: len(recorder.exits()) == 3, "it exits for good")
    recorder.until(lambda: recorder.replicas[1].restarts == 2, "the replica follows")

    assert recorder.text() == b"again\n" * 3
    assert not recorder.replicas[1].is_pending


def test_signals_of_a_user_are_reported_even_without_effect(recorder: Recorder):
    recorder.start(1, python(SLEEP))
    recorder.until(lambda: recorder.text(), "it is up")
    recorder.link.signal(1, signal.SIGTERM, by_user=True)
    recorder.until(lambda: recorder.exits(), "it exits")
    recorder.link.signal(1, signal.SIGTERM, by_user=True)

    sent = SignalSent(signal.SIGTERM, by_user=True)
    recorder.until(lambda: [e for _, e, _, _ in recorder.events].count(sent) == 2, "both reported")


def test_a_program_that_is_not_there_is_reported(recorder: Recorder):
    recorder.start(1, python("", words=(("no-such-program",),)))

    recorder.until(lambda: len(recorder.events) == 2, "it is refused")

    assert isinstance(recorder.events[1][1], SpawnError)
    assert recorder.replicas[1].state is ProcessState.FATAL


def test_limits_are_set_there(recorder: Recorder):
    limits = Limits(rlimits=(("nofile", 77, 77),))
    recorder.start(
        1,
        python("import resource; print(resource.getrlimit(resource.RLIMIT_NOFILE))", limits=limits),
    )

    recorder.until(lambda: recorder.exits(), "it exits")

    assert recorder.text() == b"(77, 77)\n"


def test_resources_are_reported(recorder: Recorder):
    recorder.start(1, python(SLEEP))

    recorder.until(lambda: recorder.resources, "a sample arrives")

    assert recorder.resources[1]["pid"] == recorder.pid()


def test_leftovers_are_stopped_and_named(recorder: Recorder):
    code = "import subprocess; p = subprocess.Popen(['sleep', '600'], start_new_session=True)"
    recorder.start(1, python(f"{code}; print(p.pid)"))
    recorder.until(lambda: recorder.exits(), "it exits")

    leftovers, killed = recorder.finish()

    assert f"sleep [{int(recorder.text())}]" in leftovers[0]
    assert not killed
    assert is_gone(int(recorder.text()))


def test_sent_files_are_private_and_removed_at_the_end(recorder: Recorder):
    name = SentFile("parameters.yaml")
    code = "import sys, time; print(sys.argv[1], open(sys.argv[1]).read()); time.sleep(600)"
    words = ((sys.executable,), ("-u",), ("-c",), (code,), (name,))
    recorder.start(1, python("", words=words, files={"parameters.yaml": b"secret"}))
    recorder.until(lambda: recorder.text().endswith(b"\n"), "it has read the file")

    path, content = recorder.text().decode().split()
    folder = Path(path).parents[1]
    assert content == "secret"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700

    recorder.finish()
    wait_until(lambda: not folder.exists(), "the folder is removed")


def test_values_of_variables_show_up_nowhere(recorder: Recorder, capfd: pytest.CaptureFixture[str]):
    secret = "s3cr3t-9f1c"
    words = (("/no/such/program",),)
    recorder.start(1, python(SLEEP, environment={"TOKEN": secret}))
    recorder.start(2, python("", words=words, environment={"TOKEN": secret}))
    recorder.until(lambda: recorder.text(1) and len(recorder.events) >= 4, "one runs")

    agent = agent_pid(recorder)
    own = psutil.Process(agent)
    lines = [" ".join(one.cmdline()) for one in (own, *own.children())]
    assert secret not in "".join(lines)
    assert secret not in "".join(own.environ().values())
    assert psutil.Process(recorder.pid(1)).environ()["TOKEN"] == secret
    assert secret not in repr(recorder.events) + repr(recorder.warnings)
    recorder.finish()
    assert secret not in "".join(capfd.readouterr())


# ---- the link


def test_a_slow_screen_makes_the_processes_wait(recorder: Recorder):
    code = "import os\nfor i in range(1000): os.write(1, b'x' * 65536); os.write(2, b'%d\\n' % i)"
    recorder.start(1, python(code))
    recorder.until(lambda: recorder.blocks, "it writes")
    recorder.link.pause(True)
    before = len(recorder.text())
    wrote = -1

    def has_stopped() -> bool:
        nonlocal wrote
        process = psutil.Process(recorder.pid())
        last, wrote = wrote, process.num_ctx_switches().voluntary
        return last == wrote and process.status() == psutil.STATUS_SLEEPING

    recorder.until(has_stopped, "it waits")
    assert not recorder.exits()
    assert len(recorder.text()) - before < 65536 * 4

    recorder.link.pause(False)
    recorder.until(lambda: recorder.exits(), "it goes on")
    assert len(recorder.text()) == 1000 * 65536 + sum(len(b"%d\n" % i) for i in range(1000))


def test_a_lost_connection_is_replaced_and_nothing_is_lost():
    code = "import time\nfor i in range(10**6): print(i, flush=True); time.sleep(0.002)"
    with Recorder(host(), words=RELAYED) as recorder:
        recorder.ready().start(1, python(code))
        recorder.until(lambda: recorder.text().count(b"\n") > 100, "it writes")
        pid = recorder.pid()
        for _ in range(3):
            recorder.sever()
            recorder.until(lambda: recorder.link.state is LinkState.UNREACHABLE, "lost")
            recorder.ready()
        count = recorder.text().count(b"\n")
        recorder.until(lambda: recorder.text().count(b"\n") > count + 100, "it goes on")

        lines = recorder.text().split(b"\n")[:-1]
        assert [int(line) for line in lines] == list(range(len(lines)))
        times = [at_s for _, _, _, at_s in recorder.blocks]
        assert times == sorted(times)
        assert recorder.pid() == pid
        assert recorder.lines_dropped == 0
        recorder.link.command(1, MachineCommand.STOP)
        recorder.until(lambda: recorder.exits(), "it is stopped")
        assert recorder.finish() == ([], False)


def test_requests_wait_for_the_connection():
    with Recorder(host(), words=RELAYED) as recorder:
        recorder.ready().start(1, python(SLEEP))
        recorder.until(lambda: recorder.text(), "it is up")
        recorder.sever()
        recorder.link.command(1, MachineCommand.STOP)
        recorder.until(lambda: recorder.exits(), "it is stopped")
        assert recorder.finish() == ([], False)  # it would wait ten minutes for us


@pytest.mark.thorough
def test_without_the_operator_the_host_stops_them():
    with Recorder(host(stop_after_s=3.0), words=RELAYED) as recorder:
        recorder.ready().start(1, python(SLEEP))
        agent = agent_pid(recorder)
        recorder.until(lambda: recorder.text(), "it is up")
        recorder.sever()
        wait_until(lambda: is_gone(recorder.pid()), "it is stopped")  # nobody connects meanwhile
        assert not is_gone(agent)
        recorder.until(lambda: recorder.exits(), "the exit is reported")
        recorder.ready()
        assert recorder.replicas[1].state is ProcessState.STOPPED
        recorder.start(2, python("print('again')"))
        recorder.until(lambda: recorder.exits(2), "the host is still at work")
        assert recorder.finish() == ([], False)


def test_a_killed_agent_leaves_nothing_and_is_told():
    with Recorder(host(), words=RELAYED) as recorder:
        recorder.ready().start(1, python(SLEEP))
        recorder.until(lambda: recorder.text(), "it is up")
        os.kill(agent_pid(recorder), signal.SIGKILL)

        recorder.until(lambda: recorder.link.state is LinkState.GONE, "it is gone")

        assert "no agent" in recorder.states[-1][1]
        wait_until(lambda: is_gone(recorder.pid()), "its watchdog has killed the process")


def test_sigterm_stops_the_processes_and_the_agent():
    with Recorder(host(), words=RELAYED) as recorder:
        recorder.ready().start(1, python(SLEEP))
        recorder.until(lambda: recorder.text(), "it is up")
        agent = agent_pid(recorder)
        os.kill(agent, signal.SIGTERM)

        recorder.until(lambda: recorder.link.state is LinkState.GONE, "it is gone")

        assert recorder.exits()
        assert "SIGTERM" in recorder.states[-1][1]
        wait_until(lambda: is_gone(agent), "the agent ends")


def test_an_agent_that_is_not_understood_stops_its_processes(tmp_path: Path):
    flag = tmp_path / "damage"
    code = (
        "import os\n"
        "while data := os.read(0, 65536):\n"
        f"    os.write(1, bytes(60000) if os.path.exists({str(flag)!r}) else data)"
    )
    relayed = f'"$@" | {sys.executable} -c {shlex.quote(code)}'
    with Recorder(host(), words=("sh", "-c", relayed, "sh", *AGENT)) as recorder:
        recorder.ready().start(1, python(SLEEP))
        recorder.until(lambda: recorder.text(), "it is up")
        agent = agent_pid(recorder)
        flag.touch()
        recorder.until(lambda: recorder.link.state is LinkState.GONE, "it is gone")

        assert recorder.states[-1][1].endswith("; a stop of its processes was requested")
    wait_until(lambda: is_gone(recorder.pid()), "it is stopped")
    wait_until(lambda: is_gone(agent), "the agent ends")
