"""Each verb on real processes of a real run, over its socket."""

from __future__ import annotations

import json
import os
import re
import signal

import psutil
import pytest

from launcher.control.client import RefusedError
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun, state_of
from tests.support.waiting import wait_until

CAT = 'sh("exec cat", name="cat")'
SLEEPER = 'sh("exec sleep 1000", name="sleeper")'
STUBBORN = """sh("trap '' INT; echo ready; while :; do sleep 0.1; done", name="stubborn",
              sigterm_timeout="600")"""


def pid_of(run: ControlledRun, name: str) -> int:
    return run.row(name)["pid"]


def test_a_stopped_process_stays_stopped_until_it_is_started_and_the_run_waits(
    control_bench: ControlBench,
):
    with control_bench.launch(SLEEPER) as run:
        pid = pid_of(run, "sleeper")
        answer = run.ask_text("stop", "sleeper")
        assert re.fullmatch(r"sleeper-1 stopped in \d+\.\d\d s \(SIGINT\)", answer)
        assert not state_of(pid)
        row = run.row("sleeper")
        assert (row["state"], row["pid"]) == ("STOPPED", None)
        assert row["last_exit"]["asked"]
        assert row["last_exit"]["returncode"] == -signal.SIGINT
        started = run.ask_text("start", "sleeper-1")
        assert started == f"sleeper-1 started with pid {pid_of(run, 'sleeper')}"
        assert "asked for it: shutting down" not in run.screen
        run.ask_text("quit")
        assert run.exit_code() == 0
        assert not run.sockets()


def test_a_stop_turns_restarts_off_and_says_so(control_bench: ControlBench):
    with control_bench.launch('sh("exec sleep 1000", name="sleeper", respawn=True)') as run:
        assert run.ask_text("stop", "sleeper").endswith("; automatic restart is off")
        assert run.row("sleeper")["state"] == "STOPPED"
        run.ask_text("start", "sleeper")
        os.kill(pid_of(run, "sleeper"), signal.SIGKILL)  # nobody asked the launcher for this
        wait_until(lambda: run.row("sleeper")["restarts"] == 1, "a restart")


def test_a_process_that_waits_for_its_restart_can_be_stopped(control_bench: ControlBench):
    actions = 'sh("exit 3", name="loop", respawn=True, respawn_delay=1000.0)'
    with control_bench.launch(actions) as run:
        wait_until(lambda: run.row("loop")["state"] == "BACKOFF", "the end of the first life")
        text = "loop-1 was waiting for its restart, which is cancelled"
        assert run.ask_text("stop", "loop") == text
        assert run.row("loop")["state"] == "STOPPED"


def test_an_exit_by_a_users_signal_is_no_failure_and_not_restarted(
    control_bench: ControlBench,
):
    with control_bench.launch('sh("exec sleep 1000", name="sleeper", respawn=True)') as run:
        answer = run.ask_text("kill", "sleeper", signal="SIGKILL")
        ended = r"sleeper-1 ended in \d+\.\d\d s \(SIGKILL\); automatic restart is off"
        assert re.fullmatch(ended, answer)
        row = run.row("sleeper")
        assert row["state"] == "STOPPED"
        assert row["last_exit"]["asked"]
        run.ask_text("quit")
        assert run.exit_code() == 0
        assert "has died" not in run.screen


def test_a_signal_that_a_process_survives_is_reported_as_survived(control_bench: ControlBench):
    script = "trap 'echo caught' USR1; echo ready; while :; do sleep 0.1; done"
    with control_bench.launch(f'sh("{script}", name="trapper")') as run:
        run.wait_for("ready")
        assert (
            run.ask_text("kill", "trapper", signal="usr1")
            == "trapper-1 received SIGUSR1 and is still running"
        )
        run.wait_for("[trapper-1] caught")


def test_a_kill_is_sigkill_and_turns_restarts_off(control_bench: ControlBench):
    with control_bench.launch('sh("exec sleep 1000", name="sleeper", respawn=True)') as run:
        ended = r"sleeper-1 ended in \d+\.\d\d s \(SIGKILL\); automatic restart is off"
        assert re.fullmatch(ended, run.ask_text("kill", "sleeper"))
        with pytest.raises(RefusedError, match=r"is not running \(STOPPED\)") as refused:
            run.ask_text("kill", "sleeper")
        assert refused.value.code == "wrong-state"


def test_a_restart_gives_another_process_and_leaves_the_others_alone(control_bench: ControlBench):
    with control_bench.launch(f"{SLEEPER}, {CAT}") as run:
        before, other = pid_of(run, "sleeper"), pid_of(run, "cat")
        answer = run.ask_text("restart", "sleep*")
        after = pid_of(run, "sleeper")
        assert re.search(rf"stopped in .*, started with pid {after} instead of {before}$", answer)
        assert not state_of(before)
        assert pid_of(run, "cat") == other


def test_what_ended_by_itself_is_started_again_and_then_keeps_the_run_alive(
    control_bench: ControlBench,
):
    reader = 'sh("read line; exit 0", name="reader")'
    with control_bench.launch(f"{reader}, {SLEEPER}") as run:
        run.ask_text("send", "reader", text="x")
        wait_until(lambda: run.row("reader")["state"] == "EXITED", "its end")
        run.ask_text("start", "reader")
        os.kill(pid_of(run, "sleeper"), signal.SIGTERM)  # dies: by itself, for the launcher
        wait_until(lambda: run.row("sleeper")["state"] == "EXITED", "its end")
        assert run.row("reader")["state"] == "RUNNING"
        run.ask_text("send", "reader", text="x")
        assert run.exit_code() == 1  # sleeper died, and nobody had asked for that


def test_a_start_that_fails_says_why_and_the_run_stays(control_bench: ControlBench):
    program = control_bench.folder / "program"
    program.write_text("#!/bin/sh\nexec sleep 1000\n", encoding="utf-8")
    program.chmod(0o755)
    with control_bench.launch(f'ExecuteProcess(cmd=["{program}"], output="screen")') as run:
        run.ask_text("stop", "program")
        program.unlink()
        with pytest.raises(RefusedError, match="could not be started: No such file"):
            run.ask_text("start", "program")
        program.write_text("#!/bin/sh\nexec sleep 1000\n", encoding="utf-8")
        program.chmod(0o755)
        assert "started with pid" in run.ask_text("start", "program")


def test_a_required_process_may_be_stopped_by_a_person(control_bench: ControlBench):
    with control_bench.launch(f"{SLEEPER}, {CAT}", "--required", "sleeper") as run:
        run.ask_text("stop", "sleeper")
        run.ask_text("start", "sleeper")
        os.kill(pid_of(run, "sleeper"), signal.SIGKILL)
        assert run.exit_code() == 1


def test_the_launch_file_sees_an_exit_that_a_user_requested(control_bench: ControlBench):
    action = 'sh("exec sleep 1000", name="sleeper", on_exit=[Shutdown(reason="it is over")])'
    with control_bench.launch(f"{action}, {CAT}") as run:
        assert "stopped in" in run.ask_text("stop", "sleeper")
        assert run.exit_code() == 0
        assert "sending signal 'SIGINT' to process[cat-2]" in run.screen


def test_a_process_that_is_queued_for_its_start_can_be_stopped(control_bench: ControlBench):
    never = "sleeper-2 was stopped before it had started"
    with control_bench.launch(f"{CAT}, {SLEEPER}", "--stagger", "1000") as run:
        assert run.row("sleeper")["state"] == "STARTING"
        assert run.ask_text("restart", "sleeper") == "sleeper-2 is queued to start"
        with pytest.raises(RefusedError, match="sleeper-2 is queued to start"):
            run.ask_text("start", "sleeper")
        assert run.ask_text("stop", "sleeper") == never
        with run.connect() as connection:
            connection.send("start", ["sleeper"])
            assert run.row("sleeper")["state"] == "STARTING"
            assert run.ask_text("stop", "sleeper") == never
            message = connection.read(TIMEOUT_S)["error"]["message"]
            assert message == "sleeper-2 is not started: a later request stops it"
        assert run.row("sleeper")["state"] == "STOPPED"
        assert run.screen.count("[sleeper-2]: process was not started: stopped") == 2


@pytest.mark.thorough
def test_stopping_a_process_queued_for_its_restart_does_not_report_its_last_exit(
    control_bench: ControlBench,
):
    with control_bench.launch(SLEEPER, "--stagger", "1000") as run, run.connect() as connection:
        assert "(SIGINT)" in run.ask_text("stop", "sleeper")
        connection.send("start", ["sleeper"])
        assert run.row("sleeper")["state"] == "STARTING"
        run.ask_text("stop", "sleeper")
        message = connection.read(TIMEOUT_S)["error"]["message"]
        assert message == "sleeper-1 is not started: a later request stops it"


def test_nothing_is_started_while_the_run_is_being_stopped(control_bench: ControlBench):
    with control_bench.launch(f"{STUBBORN}, {SLEEPER}") as run, run.connect() as connection:
        run.wait_for("ready")
        connection.ask("stop", ["sleeper"])
        connection.ask("quit")
        with pytest.raises(RefusedError, match="the run is being stopped") as refused:
            connection.ask("start", ["sleeper"])
        assert refused.value.code == "stopping"
        run.process.send_signal(signal.SIGINT)  # the second to ask: SIGTERM at once
        assert connection.wait_for_end(TIMEOUT_S)


def test_a_paused_process_is_suspended_and_resumes(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run:
        pid = pid_of(run, "sleeper")
        assert run.ask_text("pause", "sleeper") == "sleeper-1 paused with SIGSTOP"
        assert state_of(pid) == psutil.STATUS_STOPPED
        assert run.row("sleeper")["paused"]
        assert run.ask_text("resume", "sleeper") == "sleeper-1 resumed with SIGCONT"
        assert state_of(pid) in (psutil.STATUS_SLEEPING, psutil.STATUS_RUNNING)
        assert not run.row("sleeper")["paused"]
        with pytest.raises(RefusedError, match="is not paused"):
            run.ask_text("resume", "sleeper")


@pytest.mark.thorough
def test_top_shows_who_is_suspended_by_a_request_and_by_others(run: ControlledRun):
    def is_shown(paused: bool) -> bool:
        return next(looks)["processes"][0]["paused"] is paused

    pid = pid_of(run, "cat")
    with run.connect() as connection:
        looks = connection.follow("top", period_s=0.1)
        for suspend, resume in (
            (lambda: os.kill(pid, signal.SIGSTOP), lambda: os.kill(pid, signal.SIGCONT)),
            (lambda: run.ask("pause", "cat"), lambda: run.ask("resume", "cat")),
        ):
            suspend()
            wait_until(lambda: is_shown(paused=True), "it is shown as suspended")
            resume()
            wait_until(lambda: is_shown(paused=False), "it is shown as going on")


def test_a_paused_process_cannot_be_paused_again(run: ControlledRun):
    assert run.ask_text("pause", "cat") == "cat-1 paused with SIGSTOP"
    with pytest.raises(RefusedError, match="cat-1 is already paused"):
        run.ask_text("pause", "cat")
    os.kill(pid_of(run, "cat"), signal.SIGCONT)  # by somebody else
    wait_until(lambda: not run.row("cat")["paused"], "it goes on")
    assert run.ask_text("pause", "cat") == "cat-1 paused with SIGSTOP"


def test_a_paused_process_is_stopped_as_politely_as_another(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run:
        run.ask_text("pause", "sleeper")
        assert "(SIGINT)" in run.ask_text("stop", "sleeper")
        run.ask_text("start", "sleeper")
        run.ask_text("pause", "sleeper")
        run.ask_text("quit")
        assert run.exit_code() == 0  # so nothing had to be killed


def test_a_line_is_sent_to_standard_input(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        text = "cat-1 received 12 bytes on its standard input"
        assert run.ask_text("send", "cat", text="hello there") == text
        run.wait_for("[cat-1] hello there\n")


@pytest.mark.thorough
def test_a_slow_stop_does_not_delay_other_requests(control_bench: ControlBench):
    with control_bench.launch(f"{STUBBORN}, {SLEEPER}") as run:
        run.wait_for("ready")
        with run.connect() as connection:
            stop = connection.send("stop", ["stubborn"])
            look = connection.send("ps", ["stubborn"])
            first = connection.read(TIMEOUT_S)
            assert first["id"] == look
            assert first["result"]["processes"][0]["state"] == "STOPPING"
            connection.send("kill", ["stubborn"], signal="TERM")
            answers = [connection.read(TIMEOUT_S) for _ in range(2)]
            (stopped,) = (answer for answer in answers if answer["id"] == stop)
            assert "SIGTERM" in stopped["text"][0]


@pytest.mark.thorough
def test_several_at_once_are_answered_together_and_partly(control_bench: ControlBench):
    with control_bench.launch(f"{SLEEPER}, {CAT}") as run:
        run.ask_text("stop", "cat")
        lines = run.ask_text("stop", "*").splitlines()
        assert [line.split()[0] for line in lines] == ["sleeper-1", "cat-2"]
        assert lines[1] == "cat-2 is not running (STOPPED)"
        done = run.shell("start", "*", "--json")
        assert done.returncode == 0
        assert all(one["done"] for one in json.loads(done.stdout)["processes"])


def test_an_unknown_and_an_ambiguous_name_say_what_there_is(control_bench: ControlBench):
    twins = 'sh("exec cat", name="twin"), sh("exec cat", name="twin")'
    with control_bench.launch(f"{SLEEPER}, {twins}") as run:
        with pytest.raises(RefusedError, match="unknown process 'slepper'") as unknown:
            run.ask_text("stop", "slepper")
        assert unknown.value.code == "unknown-name"
        hint = "did you mean 'sleeper-1'? known: sleeper-1, twin-2 and twin-3"
        assert unknown.value.hint == hint
        with pytest.raises(
            RefusedError, match="'twin' is ambiguous: twin-2 or twin-3"
        ) as ambiguous:
            run.ask_text("stop", "twin")
        assert ambiguous.value.code == "ambiguous-name"
        assert run.row("twin-3")["state"] == "RUNNING"


def test_ctrl_c_still_ends_a_run_that_waits_for_a_person(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run:
        run.ask_text("stop", "sleeper")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0


def answers_in_order(run: ControlledRun, *requests: tuple) -> list[str]:
    """Type everything ahead over one connection; the answers by request."""
    with run.connect() as connection:
        ids = [connection.send(verb, ["cat"], **options) for verb, options in requests]
        answers = {}
        while len(answers) < len(ids):
            answer = connection.read(TIMEOUT_S)
            answers[answer["id"]] = answer
    assert list(answers) == ids
    texts = [answers[one].get("text") or [answers[one]["error"]["message"]] for one in ids]
    return [" ".join(text) for text in texts]


def test_what_is_typed_ahead_for_a_process_happens_in_that_order(run: ControlledRun):
    ahead = ["pause", "resume", "stop", "restart"]
    texts = answers_in_order(run, *((verb, {}) for verb in ahead), ("send", {"text": "here"}))
    marks = ["paused", "resumed", "stopped", "started with"]
    for mark, text in zip(marks, texts[:-1], strict=True):
        assert mark in text, texts
    assert run.row("cat")["state"] == "RUNNING"
    run.wait_for_log("cat", "here")


@pytest.mark.thorough
def test_a_signal_typed_ahead_is_delivered_before_the_next_start(run: ControlledRun):
    pid = pid_of(run, "cat")
    killed, started = answers_in_order(run, ("kill", {"signal": "KILL"}), ("start", {}))
    assert "ended in" in killed and "started with pid" in started
    assert pid_of(run, "cat") != pid


@pytest.mark.thorough
def test_a_signal_helps_a_stop_that_takes_too_long(control_bench: ControlBench):
    deaf = """sh("trap '' INT TERM; echo ready; while :; do sleep 0.1; done", name="cat",
                 sigterm_timeout="1000")"""
    with control_bench.launch(deaf) as run, run.connect() as connection:
        run.wait_for("ready")
        connection.send("stop", ["cat"])
        connection.send("kill", ["cat"], signal="KILL")
        answers = [connection.read(TIMEOUT_S) for _ in range(2)]
        assert all(answer["ok"] for answer in answers), answers
        assert run.row("cat")["state"] == "STOPPED"


def test_a_signal_zero_only_asks_whether_it_is_there(run: ControlledRun):
    pid = pid_of(run, "cat")
    assert run.ask_text("kill", "cat", signal="0") == f"cat-1 is running (pid {pid})"
    assert pid_of(run, "cat") == pid
    run.ask_text("stop", "cat")
    with pytest.raises(RefusedError, match="is not running"):
        run.ask_text("kill", "cat", signal="0")


@pytest.mark.thorough
def test_a_stop_that_a_person_asked_for_is_no_failure_even_if_it_takes_a_sigkill(
    control_bench: ControlBench,
):
    # Without a child, which could outlive it on a busy machine: a leftover is told as an error.
    deaf = """sh("trap '' INT TERM; echo ready; exec sleep 1000", name="deaf",
                 sigterm_timeout="0.2", sigkill_timeout="0.2")"""
    with control_bench.launch(deaf) as run:
        run.wait_for("ready")
        assert "SIGKILL" in run.ask_text("stop", "deaf")
        run.ask_text("quit")
        assert run.exit_code() == 0
        assert "[ERROR]" not in run.screen
        assert "[WARNING] [deaf-1]: process was stopped [pid " in run.screen
