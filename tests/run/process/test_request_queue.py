"""Several requests for one process at the same time, from shells, connections and the console."""

from __future__ import annotations

import random
import re
import signal
import threading
from collections.abc import Sequence

import pytest

from launcher.control.client import Connection, ControlError, RefusedError
from tests.support.benches import Bench, ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun
from tests.support.supervising import events, go
from tests.support.waiting import wait_until

# When it is stopped, it ends as soon as the file `go` is there.
SLOW = """sh("trap 'until test -e go; do sleep 0.02; done; exit 0' INT; echo ready; "
   "while :; do sleep 0.1; done", name="slow", sigterm_timeout="600", cwd={cwd!r})"""


def slow(bench: Bench) -> str:
    return SLOW.format(cwd=str(bench.folder))


def started_pids(run: ControlledRun, name: str = "slow-1") -> list[int]:
    events = run.ask("events")["events"]
    return [one["pid"] for one in events if one["event"] == "started" and one["process"] == name]


def verbs_asked(run: ControlledRun) -> list[str]:
    return [one["verb"] for one in run.ask("events")["events"] if one["event"] == "asked"]


def is_stopping(run: ControlledRun) -> bool:
    return run.row("slow")["state"] == "STOPPING"


@pytest.mark.parametrize(
    ("verbs", "ends"),
    [
        pytest.param(
            ("restart", "restart"), "RUNNING", id="restart-restart", marks=pytest.mark.thorough
        ),
        pytest.param(("restart", "start"), "RUNNING", id="restart-start"),
        pytest.param(
            ("stop", "start", "start"), "RUNNING", id="stop-start-start", marks=pytest.mark.thorough
        ),
        pytest.param(("stop", "restart", "restart"), "RUNNING", id="stop-restart-restart"),
    ],
)
def test_requests_at_the_same_time_are_all_answered_and_share_a_start(
    control_bench: ControlBench, verbs: tuple[str, ...], ends: str
):
    with control_bench.launch(slow(control_bench)) as run:
        run.wait_for("ready")
        first = run.shell_start(verbs[0], "slow")
        wait_until(lambda: is_stopping(run), "the stop")
        others = [run.shell_start(verb, "slow") for verb in verbs[1:]]
        wait_until(lambda: len(verbs_asked(run)) == len(verbs), "the others wait")
        go(control_bench)
        texts = [one.communicate(timeout=TIMEOUT_S)[0] for one in (first, *others)]
        assert [one.returncode for one in (first, *others)] == [0] * len(verbs)
        (pid,) = {m[1] for text in texts if (m := re.search(r"started with pid (\d+)", text))}
        assert started_pids(run)[1:] == [int(pid)]
        assert run.row("slow")["state"] == ends


def test_a_stop_overtakes_a_restart_which_says_so_and_has_failed(control_bench: ControlBench):
    with control_bench.launch(slow(control_bench)) as run:
        run.wait_for("ready")
        restart = run.shell_start("restart", "slow")
        wait_until(lambda: is_stopping(run), "the stop")
        stop = run.shell_start("stop", "slow")
        wait_until(lambda: verbs_asked(run) == ["restart", "stop"], "the stop waits")
        go(control_bench)
        assert "slow-1 stopped in" in stop.communicate(timeout=TIMEOUT_S)[0]
        error = restart.communicate(timeout=TIMEOUT_S)[1]
        assert error == "error: slow-1 is not started: a later request stops it\n"
        assert restart.returncode == 1
        assert run.row("slow")["state"] == "STOPPED"


def test_a_request_that_was_given_up_is_not_carried_out_later(control_bench: ControlBench):
    with control_bench.launch(slow(control_bench)) as run:
        run.wait_for("ready")
        stop = run.shell_start("stop", "slow")
        wait_until(lambda: is_stopping(run), "the stop")
        waiting = run.shell_start("start", "slow")
        wait_until(lambda: verbs_asked(run) == ["stop", "start"], "the start waits")
        waiting.send_signal(signal.SIGINT)
        waiting.communicate(timeout=TIMEOUT_S)
        assert is_stopping(run)  # an answer: the end of the other connection was noticed before
        go(control_bench)
        assert "stopped in" in stop.communicate(timeout=TIMEOUT_S)[0]
        assert run.row("slow")["state"] == "STOPPED"
        run.ask_text("start", "slow")
        run.ask_text("stop", "slow")
        assert run.row("slow")["state"] == "STOPPED"
        assert len(started_pids(run)) == 2


def test_a_restart_that_was_given_up_half_way_is_finished(control_bench: ControlBench):
    with control_bench.launch(slow(control_bench)) as run:
        run.wait_for("ready")
        with run.connect() as connection:
            connection.send("restart", ["slow"])
            wait_until(lambda: is_stopping(run), "the stop")
        assert is_stopping(run)  # an answer: the end of the connection was noticed before
        go(control_bench)
        wait_until(lambda: run.row("slow")["state"] == "RUNNING", "it runs again")


def test_what_is_typed_twice_in_the_console_is_answered_twice(bench: Bench):
    terminal = bench.screen_terminal(f"{slow(bench)},")
    terminal.wait_for_prompt()
    terminal.wait_for("slow-1] ready")
    terminal.enter("restart slow")
    terminal.enter("restart slow")
    terminal.wait_until(
        lambda: sum(one["event"] == "asked" for one in events(bench)) == 2, "both requests"
    )
    go(bench)
    terminal.wait_until(
        lambda: sum("| slow-1 stopped in" in row for row in terminal.scrolled) == 2, "both answers"
    )
    pids = {m[1] for row in terminal.scrolled if (m := re.search(r"started with pid (\d+)", row))}
    assert len(pids) == 1
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text


@pytest.mark.parametrize("words", [("--stagger", "0.1"), ("--max-starting", "1")], ids=" ".join)
def test_what_was_started_last_is_started_again(control_bench: ControlBench, words: Sequence[str]):
    sleepers = 'sh("exec sleep 1000", name="a"), sh("exec sleep 1000", name="b")'
    respawned = 'sh("exit 3", name="c", respawn=True, respawn_delay=0.05)'
    with control_bench.launch(f"{sleepers}, {respawned}", *words) as run:
        wait_until(lambda: len(started_pids(run, "c-3")) > 3, "it is respawned")
        run.ask_text("stop", "c")
        for name in ("b", "b", "a", "b"):
            assert "started with pid" in run.ask_text("restart", name)
        run.ask_text("stop", "b")
        assert "started with pid" in run.ask_text("start", "b")


def test_a_users_stop_during_a_restart_for_a_changed_file_is_seen_by_the_launch_file(
    control_bench: ControlBench,
):
    node = control_bench.folder / "node.py"
    node.write_text(
        "import os, signal, sys, time\n"
        "def stop(*args):\n"
        f"    while not os.path.exists('{control_bench.folder}/go'): time.sleep(0.02)\n"
        "    sys.exit(0)\n"
        "signal.signal(signal.SIGINT, stop)\n"
        "print('ready', flush=True)\nwhile True: time.sleep(0.1)\n",
        encoding="utf-8",
    )
    action = f"""ExecuteProcess(cmd=[sys.executable, "{node}"], name="slow", output="screen",
                 sigterm_timeout="600", on_exit=[LogInfo(msg="the launch file has seen it")])"""
    with control_bench.launch(action, "--watch") as run:
        run.wait_for("ready")
        wait_until(lambda: run.ask("watch", "slow")["processes"][0]["files"], "it is watched")
        node.write_text(node.read_text(encoding="utf-8") + "# edited\n", encoding="utf-8")
        wait_until(lambda: is_stopping(run), "the restart for the file")
        with run.connect() as connection:
            connection.send("stop", ["slow"])
            wait_until(lambda: "stop" in verbs_asked(run), "the stop waits")
            go(control_bench)
            assert "stopped in" in connection.read(TIMEOUT_S)["text"][0]
        run.wait_for("the launch file has seen it")
        assert run.row("slow")["state"] == "STOPPED"


# ---- a storm

CLIENTS, EACH = 6, 150
NAMES = ("a", "b", "c")
# It takes 0 to 1.5 s to stop, and now and then crashes or ends by itself.
RESTLESS = """
import os, random, signal, sys, time
chance = random.Random(os.getpid())
def stop(*args):
    time.sleep(chance.choice((0.0, 0.05, chance.uniform(0.0, 1.5))))
    sys.exit(0)
signal.signal(signal.SIGINT, stop)
until_s = time.monotonic() + chance.choice((0.3, 2.0, 1e9, 1e9))
while time.monotonic() < until_s:
    time.sleep(0.02)
sys.exit(0) if chance.random() < 0.5 else os.abort()
"""


class StormClient(threading.Thread):
    """Asks at random, one request after the other, and gives some up."""

    def __init__(self, run: ControlledRun, number: int) -> None:
        super().__init__()
        self.run_ = run
        self.random = random.Random(number)
        self.answers: list[str] = []
        self.unanswered: list[str] = []
        self.given_up = 0
        self.starts_given_up = 0

    def run(self) -> None:
        for _ in range(EACH):
            verb = self.random.choice(
                ("stop", "start", "start", "restart", "restart", "restart", "kill")
            )
            patience_s = self.random.uniform(0.001, 0.05) if self.random.random() < 0.2 else None
            with self.run_.connect() as connection:
                self._ask(connection, verb, self.random.choice(NAMES), patience_s)

    def _ask(self, connection: Connection, verb: str, name: str, patience_s: float | None) -> None:
        connection.send(verb, [name])
        try:
            answer = connection.read(TIMEOUT_S if patience_s is None else patience_s)
        except ControlError as error:
            if patience_s is None:
                self.unanswered.append(f"{verb} {name}: {error}")
                return
            self.given_up += 1
            self.starts_given_up += verb in ("start", "restart")
            return
        text = answer.get("text") or [answer["error"]["message"]]
        self.answers += text


@pytest.mark.thorough
def test_in_a_storm_of_requests_nothing_starts_that_nobody_waits_for(control_bench: ControlBench):
    script = control_bench.folder / "restless.py"
    script.write_text(RESTLESS, encoding="utf-8")
    actions = ",".join(
        f'ExecuteProcess(cmd=[sys.executable, "-S", "{script}"], name="{name}", '
        f'output="screen", sigterm_timeout="30")'
        for name in NAMES
    )
    with control_bench.launch(f'{actions}, sh("exec sleep 10000", name="stays")') as run:
        wait_until(lambda: started_pids(run, "c-3"), "the last start")
        clients = [StormClient(run, number) for number in range(CLIENTS)]
        for client in clients:
            client.start()
        for client in clients:
            client.join()
        assert [text for client in clients for text in client.unanswered] == []
        for name in NAMES:
            _stop(run, name)
        _check_starts(run, clients)
        run.ask_text("quit")  # what had waited for longer would have started meanwhile
        run.exit_code()


def _stop(run: ControlledRun, name: str) -> None:
    """The last request counts, also if the process has ended by itself."""
    try:
        run.ask_text("stop", name)
    except RefusedError as error:
        assert "is not running" in str(error), error
    assert run.row(name)["pid"] is None


def _check_starts(run: ControlledRun, clients: list[StormClient]) -> None:
    reported = {
        int(match[1])
        for client in clients
        for text in client.answers
        if (match := re.search(r"started with pid (\d+)", text))
    }
    for number, name in enumerate(NAMES, 1):
        pids = started_pids(run, f"{name}-{number}")
        assert len(pids) > 20
    unreported = [
        pid
        for number, name in enumerate(NAMES, 1)
        for pid in started_pids(run, f"{name}-{number}")[1:]
        if pid not in reported
    ]
    # A restart whose client went away half-way is finished, and nobody reads its pid.
    assert len(unreported) <= sum(client.starts_given_up for client in clients)
    assert sum(client.given_up for client in clients) > 0
